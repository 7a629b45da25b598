"""Which joint of a skeleton is the left knee: roles found by topology, symmetry and names together.

Arms and legs are pairs of equal chains. In each chain the joints that make the most human limb are
taken: lengths count, and what names say counts more. Whether it is a person at all is decided by
the stance: somewhere in the clip the trunk stands over the legs. Left and right come from names
where they say so, otherwise from where the feet point.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from math import log

import numpy as np

from understudy.character.anthropometry import LENGTHS
from understudy.character.mapping import Mapping
from understudy.character.names import Hint, hints
from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.figure import ROLES
from understudy.motion.skeleton import Skeleton

_LEG = LENGTHS["thigh"] + LENGTHS["shank"]
_ARM = LENGTHS["upper_arm"] + LENGTHS["forearm"]
_NAMED, _MISNAMED = -1.5, 1.0
# A pair of chains whose best limb costs more than this is no arm or leg.
_WORST = 2.0
# Cosine between the trunk, or the legs, and the vertical in the most upright frame.
_UPRIGHT = 0.7
_SAMPLES = 120


@dataclass(frozen=True, kw_only=True)
class Role:
    """A role found.

    Attributes:
        role: Such as "left_knee".
        joint: The clip joint whose orientation the link takes.
        origin: The clip joint at which the link begins; the same joint unless several are folded
            into one (a neck of two joints turns with the head about its base).
        confidence: 0 to 1: 1 when a person said so.
        evidence: Why.
    """

    role: str
    joint: str
    origin: str
    confidence: float
    evidence: str


@dataclass(frozen=True, kw_only=True)
class Roles:
    """All roles of a skeleton, empty when it is no person.

    Attributes:
        found: In the order of the standard roles.
        folded: Joints between links that are folded into the link inboard of them.
        dropped: Joints that carry no link: fingers, eyes, a tail.
        reason: What was decided on, or why nothing was found.
    """

    found: tuple[Role, ...] = ()
    folded: tuple[str, ...] = ()
    dropped: tuple[str, ...] = ()
    reason: str = ""

    def __bool__(self) -> bool:
        return bool(self.found)

    def __contains__(self, role: str) -> bool:
        return role in self._by_role

    @cached_property
    def _by_role(self) -> dict[str, Role]:
        return {r.role: r for r in self.found}

    def get(self, role: str) -> Role | None:
        """The role found, or None."""
        return self._by_role.get(role)

    @property
    def joints(self) -> dict[str, str]:
        """Clip joint by role."""
        return {r.role: r.joint for r in self.found}

    @property
    def confidence(self) -> float:
        """The least certain role's confidence; 0 when there are none."""
        return min((r.confidence for r in self.found), default=0.0)

    def __str__(self) -> str:
        if not self.found:
            return f"no roles: {self.reason}"
        width = max(len(r.joint) for r in self.found)
        lines = [
            f"{r.role:<15} {r.joint:<{width}}  {100 * r.confidence:3.0f} %  {r.evidence}"
            for r in self.found
        ]
        for title, names in (("folded", self.folded), ("not needed", self.dropped)):
            if names:
                lines.append(f"{title}: {', '.join(names)}")
        return "\n".join(lines)


def find_roles(clip: Clip, *, mapping: Mapping | None = None) -> Roles:
    """The roles of a clip's joints.

    Args:
        clip: Its skeleton is searched; its frames tell up from down.
        mapping: What a person says; overrides what is found.

    Raises:
        UnknownName: The mapping names a joint that does not exist.
        InvalidValue: The mapping contradicts the tree.
    """
    mapping = mapping or Mapping()
    mapping.check(clip.skeleton)
    tree = _Tree(clip, mapping)
    roles, reason = _search(tree)
    for role, joint in mapping.roles.items():
        roles[role] = Role(
            role=role, joint=joint, origin=joint, confidence=1.0, evidence="said by the mapping"
        )
    if not roles or "pelvis" not in roles:
        return Roles(reason=reason or "no pair of legs or arms.")
    ordered = tuple(roles[r] for r in ROLES if r in roles)
    _check_tree(clip.skeleton, ordered)
    folded, dropped = _others(clip.skeleton, ordered)
    return Roles(found=ordered, folded=folded, dropped=dropped, reason=reason)


# -- the tree ---------------------------------------------------------------------------------


class _Tree:
    """A skeleton with what the search needs: lengths, reach, hints, sampled positions.

    End sites count as joints here, numbered after the real ones, so that a forearm that ends
    without a hand still is a bone.
    """

    def __init__(self, clip: Clip, mapping: Mapping):
        skeleton = clip.skeleton
        self.skeleton = skeleton
        self.real = len(skeleton)
        self.parents = (*skeleton.parents, *skeleton.end_joints)
        nothing = Hint("", ())
        self.hints: tuple[Hint, ...] = (
            *hints(skeleton.names),
            *(nothing for _ in skeleton.end_joints),
        )
        offsets = np.concatenate((skeleton.offsets, skeleton.end_offsets))
        self.lengths = np.linalg.norm(offsets, axis=1)
        self.lengths[0] = 0.0
        rest = skeleton.rest_positions()
        rest = np.concatenate((rest, rest[list(skeleton.end_joints)] + skeleton.end_offsets))
        step = max(1, clip.frames // _SAMPLES)
        pose = clip.forward_kinematics()
        seen = np.concatenate((pose.positions[::step], pose.ends[::step]), axis=1)
        self.positions = np.concatenate((rest[None], seen))
        hidden = {skeleton.index(n) for n in mapping.drop}
        for i, p in enumerate(self.parents):
            if p in hidden:
                hidden.add(i)
        self.hidden = hidden
        self.unlinked = {skeleton.index(n) for n in mapping.fold}
        self.reach = np.zeros(len(self.parents))
        for i in range(len(self.parents) - 1, 0, -1):
            if i not in hidden and i >= self.real:
                self._carry(i)
        for i in range(self.real - 1, 0, -1):
            if i not in hidden:
                self._carry(i)
        self.tiny = 1e-3 * max(float(self.reach.max()), 1e-9)

    def _carry(self, joint: int) -> None:
        p = self.parents[joint]
        self.reach[p] = max(self.reach[p], self.lengths[joint] + self.reach[joint])

    def children(self, joint: int) -> list[int]:
        return [i for i, p in enumerate(self.parents) if p == joint and i not in self.hidden]

    def kinds(self, joint: int) -> tuple[str, ...]:
        return self.hints[joint].kinds

    def chain(self, joint: int) -> list[int]:
        """From a joint outward along the longest way, fingers and helpers last in choice."""
        out = [joint]
        while children := self.children(out[-1]):
            plain = [c for c in children if self.kinds(c) != ("finger",)] or children
            out.append(max(plain, key=lambda c: self.lengths[c] + self.reach[c]))
        return out

    def ancestors(self, joint: int) -> list[int]:
        """The joint and all inboard of it, outermost first."""
        out = [joint]
        while self.parents[out[-1]] >= 0:
            out.append(self.parents[out[-1]])
        return out

    def between(self, inboard: int, outboard: int) -> float:
        """Length of the way from one joint out to another."""
        total = 0.0
        while outboard != inboard:
            total += float(self.lengths[outboard])
            outboard = self.parents[outboard]
        return total


@dataclass(frozen=True)
class _Limb:
    """Three joints of one chain (hip, knee, ankle or shoulder, elbow, wrist) and their cost."""

    joints: tuple[int, int, int]
    cost: float
    chain: tuple[int, ...]


@dataclass(frozen=True)
class _Pair:
    """Two chains hanging on one joint, read as legs and as arms."""

    root: int
    chains: tuple[tuple[int, ...], tuple[int, ...]]
    legs: tuple[_Limb, _Limb] | None = field(repr=False)
    arms: tuple[_Limb, _Limb] | None = field(repr=False)


def _pairs(tree: _Tree) -> Iterator[_Pair]:
    """Pairs of chains that are alike in length or opposite in name."""
    longest = float(tree.reach.max())
    for root in range(tree.real):
        heads = [c for c in tree.children(root) if tree.lengths[c] + tree.reach[c] > 0.2 * longest]
        for a, b in combinations(heads, 2):
            one, two = tree.chain(a), tree.chain(b)
            if not (_opposite(tree, one, two) or _alike(tree, one, two)):
                continue
            yield _Pair(
                root,
                (tuple(one), tuple(two)),
                _limb_pair(tree, root, one, two, _leg),
                _limb_pair(tree, root, one, two, _arm),
            )


def _opposite(tree: _Tree, one: list[int], two: list[int]) -> bool:
    """Whether names say that one is left and the other right."""
    sides = [{tree.hints[j].side for j in chain} - {""} for chain in (one, two)]
    return len(sides[0]) == 1 and len(sides[1]) == 1 and sides[0] != sides[1]


def _alike(tree: _Tree, one: list[int], two: list[int]) -> bool:
    """Whether two chains have the same bones within 15 %, and names do not put them on one side."""
    bones = [
        [tree.lengths[j] for j in chain if tree.lengths[j] > tree.tiny] for chain in (one, two)
    ]
    if len(bones[0]) != len(bones[1]) or len(bones[0]) < 2:
        return False
    sides = [{tree.hints[j].side for j in chain} - {""} for chain in (one, two)]
    if sides[0] and sides[0] == sides[1]:
        return False
    a, b = np.array(bones[0]), np.array(bones[1])
    return bool(np.abs(a - b).sum() < 0.15 * max(a.sum(), b.sum()))


def _limb_pair(
    tree: _Tree, root: int, one: list[int], two: list[int], cost: Callable[..., float]
) -> tuple[_Limb, _Limb] | None:
    """The best limb of either chain, joints at the same places where both chains have as many."""
    best: tuple[float, _Limb, _Limb] | None = None
    if len(one) == len(two):
        for places in combinations(range(len(one)), 3):
            limbs = [
                _Limb(
                    j := (c[places[0]], c[places[1]], c[places[2]]),
                    cost(tree, root, c, j),
                    tuple(c),
                )
                for c in (one, two)
            ]
            total = 0.5 * (limbs[0].cost + limbs[1].cost)
            if best is None or total < best[0]:
                best = total, limbs[0], limbs[1]
    else:
        found = [
            min(
                (_Limb(j, cost(tree, root, c, j), tuple(c)) for j in combinations(c, 3)),
                key=lambda limb: limb.cost,
                default=None,
            )
            for c in (one, two)
        ]
        if found[0] is not None and found[1] is not None:
            best = 0.5 * (found[0].cost + found[1].cost), found[0], found[1]
    return None if best is None or not np.isfinite(best[0]) else (best[1], best[2])


def _leg(tree: _Tree, root: int, chain: list[int], joints: tuple[int, ...]) -> float:
    """Cost of reading three joints of a chain as hip, knee and ankle."""
    hip, knee, ankle = joints
    thigh, shank = tree.between(hip, knee), tree.between(knee, ankle)
    if min(thigh, shank) <= tree.tiny or tree.unlinked & set(joints):
        return np.inf
    foot = float(tree.reach[ankle]) / (thigh + shank)
    inboard = tree.between(root, hip) / (thigh + shank)
    cost = 2 * abs(log(thigh / shank)) + 5 * max(0.0, foot - 0.5) + 2 * max(0.0, inboard - 0.3)
    return cost + _skipped(tree, chain, joints) + _naming(tree, joints, ("hip", "knee", "ankle"))


def _arm(tree: _Tree, root: int, chain: list[int], joints: tuple[int, ...]) -> float:
    """Cost of reading three joints of a chain as shoulder, elbow and wrist."""
    shoulder, elbow, wrist = joints
    upper, fore = tree.between(shoulder, elbow), tree.between(elbow, wrist)
    if min(upper, fore) <= tree.tiny or tree.unlinked & set(joints):
        return np.inf
    whole = upper + fore
    inboard = tree.between(root, shoulder) / whole
    hand = float(tree.reach[wrist]) / whole
    cost = abs(log(upper / fore * LENGTHS["forearm"] / LENGTHS["upper_arm"]))
    cost += 1.5 * max(0.0, abs(inboard - 0.55) - 0.2) + max(0.0, hand - 0.45)
    cost += 2 * max(0.0, 0.75 - upper / fore)
    return (
        cost + _skipped(tree, chain, joints) + _naming(tree, joints, ("shoulder", "elbow", "wrist"))
    )


def _skipped(tree: _Tree, chain: list[int], joints: tuple[int, ...]) -> float:
    """Joints of a length that are passed over; of several at one place the first is best."""
    if joints[1] >= tree.real:
        return np.inf
    first, last = chain.index(joints[0]), chain.index(joints[-1])
    passed = [j for j in chain[first + 1 : last] if j not in joints]
    cost = 0.3 * sum(tree.lengths[j] > tree.tiny for j in passed)
    cost += 0.3 * (joints[2] >= tree.real)
    cost += 0.1 * sum(tree.lengths[j] <= tree.tiny for j in joints[1:])
    # A zero-length joint before the limb (LHipJoint) is not the limb's first joint.
    head = chain[: first + 1]
    if first + 1 < len(chain) and tree.lengths[joints[0]] <= tree.tiny and len(head) == 1:
        cost += 0.2
    return cost


def _naming(tree: _Tree, joints: tuple[int, ...], kinds: tuple[str, ...]) -> float:
    cost = 0.0
    for joint, kind in zip(joints, kinds, strict=True):
        said = tree.kinds(joint)
        if kind in said:
            cost += _NAMED if said[0] == kind else 0.6 * _NAMED
        elif said:
            cost += _MISNAMED
    return cost


# -- the search -------------------------------------------------------------------------------


def _search(tree: _Tree) -> tuple[dict[str, Role], str]:
    """Roles by name, and what was decided on."""
    legs, arms = _limbs(tree)
    if legs is None and arms is None:
        return {}, "no two chains are alike in the way of legs or arms."
    if not _person(tree, legs, arms):
        return {}, "the trunk never stands upright over the legs."
    pelvis = legs.root if legs is not None else 0
    spine, neck = _trunk(tree, pelvis, arms)
    sides, how = _sides(tree, legs, arms)
    out: dict[str, Role] = {}

    def add(role: str, joint: int, kind: str, why: str, origin: int | None = None) -> None:
        said = tree.kinds(joint)
        named = kind in said or (kind == "neck" and "head" in said)
        confidence = 0.95 if named else (0.55 if said else 0.75)
        words = "name and " if named else ("against its name, " if said else "")
        out[role] = Role(
            role=role,
            joint=tree.skeleton.names[joint],
            origin=tree.skeleton.names[joint if origin is None else origin],
            confidence=confidence,
            evidence=words + why,
        )

    add("pelvis", pelvis, "pelvis", "the legs hang on it" if legs else "the root")
    if spine:
        add("upper_back", spine[-1], "spine", "the arms hang on it" if arms else "end of the back")
        if len(spine) > 1:
            add("lower_back", spine[0], "spine", "first joint of the back")
    if neck:
        add("neck", neck[-1], "neck", "middle chain above the arms", origin=neck[0])
    for pair, kinds, tail in (
        (legs, ("hip", "knee", "ankle"), "ball"),
        (arms, ("shoulder", "elbow", "wrist"), None),
    ):
        if pair is None:
            continue
        limbs = pair.legs if tail else pair.arms
        assert limbs is not None
        for side, which in sides[tail or "arm"].items():
            limb = limbs[which]
            for kind, joint in zip(kinds, limb.joints, strict=True):
                if joint >= tree.real:
                    continue
                add(f"{side}_{kind}", joint, kind, f"lengths of {'leg' if tail else 'arm'}")
            toe = _toe(tree, limb) if tail else None
            if toe is not None:
                add(f"{side}_ball", toe, "ball", "beyond the ankle")
    if not ("left_ball" in out and "right_ball" in out):
        out.pop("left_ball", None)
        out.pop("right_ball", None)
    return out, _reason(legs, arms, how)


def _limbs(tree: _Tree) -> tuple[_Pair | None, _Pair | None]:
    """The pair of legs and the pair of arms that together cost least."""
    pairs = list(_pairs(tree))
    legs = [p for p in pairs if p.legs and _cost(p.legs) < _WORST]
    arms = [p for p in pairs if p.arms and _cost(p.arms) < _WORST]
    best: tuple[float, _Pair | None, _Pair | None] | None = None
    for leg in legs:
        for arm in arms:
            if not _apart(tree, leg, arm):
                continue
            assert leg.legs and arm.arms
            cost = _cost(leg.legs) + _cost(arm.arms) - 4.0
            sizes = [_size(tree, leg.legs[0]), _size(tree, arm.arms[0])]
            cost += 1.5 * max(0.0, abs(log(sizes[1] / sizes[0] * _LEG / _ARM)) - 0.4)
            # A spine between the two; the legs nearer to the root.
            cost += 0.0 if arm.root in _inside(tree, leg.root) and arm.root != leg.root else 1.5
            if best is None or cost < best[0]:
                best = cost, leg, arm
    if best is not None:
        return best[1], best[2]
    single = [(_cost(p.legs), 0, p) for p in legs if p.legs and _alone(tree, p, "legs")]
    single += [(_cost(p.arms), 1, p) for p in arms if p.arms and _alone(tree, p, "arms")]
    if not single:
        return None, None
    _, which, pair = min(single, key=lambda s: s[0])
    return (pair, None) if which == 0 else (None, pair)


def _alone(tree: _Tree, pair: _Pair, read: str) -> bool:
    """Whether a lone pair is legs (or arms): names, or that they hang below the root."""
    limbs = pair.legs if read == "legs" else pair.arms
    assert limbs is not None
    kinds = ("hip", "knee", "ankle") if read == "legs" else ("shoulder", "elbow", "wrist")
    named = sum(
        kind in tree.kinds(j) for arm in limbs for j, kind in zip(arm.joints, kinds, strict=True)
    )
    if named >= 4:
        return True
    other = pair.arms if read == "legs" else pair.legs
    said = any(tree.kinds(j) for arm in (*limbs, *(other or ())) for j in arm.joints)
    if said or not _other_chain(tree, pair):
        return False
    drop = tree.positions[:, limbs[0].joints[0], 2] - tree.positions[:, limbs[0].joints[2], 2]
    down = float(np.max(drop) / _size(tree, limbs[0])) > 0.9 and pair.root == 0
    return down if read == "legs" else not down


def _other_chain(tree: _Tree, pair: _Pair) -> bool:
    """Whether something besides the pair hangs on its joint or inboard of it: a trunk."""
    heads = {pair.chains[0][0], pair.chains[1][0]}
    return any(c not in heads for c in tree.children(pair.root)) or pair.root != 0


def _cost(limbs: tuple[_Limb, _Limb]) -> float:
    return 0.5 * (limbs[0].cost + limbs[1].cost)


def _size(tree: _Tree, limb: _Limb) -> float:
    return tree.between(limb.joints[0], limb.joints[2])


def _inside(tree: _Tree, joint: int) -> set[int]:
    """A joint and all outboard of it."""
    out = {joint}
    for i in range(joint + 1, len(tree.parents)):
        if tree.parents[i] in out:
            out.add(i)
    return out


def _apart(tree: _Tree, leg: _Pair, arm: _Pair) -> bool:
    """Neither pair lies within the other's chains."""
    for one, two in ((leg, arm), (arm, leg)):
        held = {j for head in (one.chains[0][0], one.chains[1][0]) for j in _inside(tree, head)}
        if two.root in held or two.chains[0][0] in held:
            return False
    return True


def _person(tree: _Tree, legs: _Pair | None, arms: _Pair | None) -> bool:
    """Whether somewhere the trunk stands over the legs; a person by name needs no such frame."""
    named = sum(bool(h.kinds) and h.kinds != ("finger",) for h in tree.hints)
    if named >= 10:
        return True
    at = tree.positions
    upright = []
    if legs is not None and legs.legs is not None:
        a, b = legs.legs
        rise = 0.5 * (
            at[:, a.joints[0]] + at[:, b.joints[0]] - at[:, a.joints[2]] - at[:, b.joints[2]]
        )
        upright.append(rise[:, 2] / _size(tree, a))
    if legs is not None and arms is not None and arms.root != legs.root:
        trunk = at[:, arms.root] - at[:, legs.root]
        length = np.linalg.norm(trunk, axis=1)
        upright.append(trunk[:, 2] / np.maximum(length, 1e-9))
    elif arms is not None and arms.root != 0:
        trunk = at[:, arms.root] - at[:, 0]
        length = np.linalg.norm(trunk, axis=1)
        upright.append(trunk[:, 2] / np.maximum(length, 1e-9))
    if not upright:
        return named > 0
    return bool(np.max(np.min(upright, axis=0)) > _UPRIGHT)


def _trunk(tree: _Tree, pelvis: int, arms: _Pair | None) -> tuple[list[int], list[int]]:
    """Joints of the back from the pelvis out, and of the neck from its base to the head."""
    if arms is not None:
        inboard = tree.ancestors(arms.root)
        shared = set(tree.ancestors(pelvis))
        spine = [j for j in reversed(inboard) if j not in shared]
        top, taken = arms.root, {arms.chains[0][0], arms.chains[1][0]}
    else:
        spine = _back_without_arms(tree, pelvis)
        top, taken = (spine[-1] if spine else pelvis), set()
    spine = [j for j in spine if j not in tree.unlinked]
    neck = _neck(tree, top, taken)
    if arms is None:
        spine = [j for j in spine if j not in neck]
    return spine, neck


def _back_without_arms(tree: _Tree, pelvis: int) -> list[int]:
    heads = [c for c in tree.children(pelvis) if {"spine"} & set(tree.kinds(c))]
    if not heads:
        return []
    out = []
    for joint in tree.chain(heads[0]):
        if joint >= tree.real:
            break
        if {"neck", "head"} & set(tree.kinds(joint)):
            break
        out.append(joint)
    return out


def _neck(tree: _Tree, top: int, taken: set[int]) -> list[int]:
    heads = [c for c in tree.children(top) if c not in taken]
    named = [
        c for c in heads if {"neck", "head"} & {k for j in tree.chain(c) for k in tree.kinds(j)}
    ]
    if not named and any(tree.kinds(c) for c in heads):
        heads = [c for c in heads if not tree.kinds(c)]
    heads = named or [c for c in heads if tree.hints[c].side == ""]
    if not heads:
        return []
    start = max(heads, key=lambda c: tree.lengths[c] + tree.reach[c])
    chain = [j for j in tree.chain(start) if j < tree.real]
    if not chain:
        return []
    first = next((i for i, j in enumerate(chain) if "neck" in tree.kinds(j)), 0)
    chain = chain[first:]
    heads_named = [i for i, j in enumerate(chain) if "head" in tree.kinds(j)]
    if heads_named:
        return chain[: heads_named[0] + 1]
    out = [chain[0]]
    for joint in chain[1:]:
        # Eyes and jaws hang in pairs or carry nothing; a head carries something.
        if len(tree.children(out[-1])) > 1 or tree.reach[joint] <= tree.tiny:
            break
        if tree.kinds(joint) == ("finger",):
            break
        out.append(joint)
    return out


def _toe(tree: _Tree, limb: _Limb) -> int | None:
    """The joint at the ball of the foot."""
    if limb.joints[2] >= tree.real:
        return None
    chain = limb.chain[limb.chain.index(limb.joints[2]) + 1 :]
    chain = tuple(j for j in chain if j < tree.real)
    named = [j for j in chain if "ball" in tree.kinds(j)]
    if named:
        return named[0]
    size = _size(tree, limb)
    plain = [j for j in chain if 0.06 < tree.lengths[j] / size < 0.4 and not tree.kinds(j)]
    return plain[0] if plain and tree.reach[plain[0]] > tree.tiny else None


def _sides(
    tree: _Tree, legs: _Pair | None, arms: _Pair | None
) -> tuple[dict[str, dict[str, int]], str]:
    """Which of the two chains is left, for legs ("ball") and arms ("arm"), and how it was told."""
    out: dict[str, dict[str, int]] = {}
    how = "names"
    for key, pair in (("ball", legs), ("arm", arms)):
        if pair is None:
            continue
        said = [{tree.hints[j].side for j in chain} - {""} for chain in pair.chains]
        if said[0] == {"left"} or said[1] == {"right"}:
            out[key] = {"left": 0, "right": 1}
        elif said[0] == {"right"} or said[1] == {"left"}:
            out[key] = {"left": 1, "right": 0}
        else:
            first_left, how = _geometric_side(tree, pair, legs)
            out[key] = {"left": 0, "right": 1} if first_left else {"left": 1, "right": 0}
    return out, how


def _geometric_side(tree: _Tree, pair: _Pair, legs: _Pair | None) -> tuple[bool, str]:
    """Whether the first chain is left: from where the feet point, else the way of travel."""
    at = tree.positions
    limbs = pair.legs if pair is legs else pair.arms
    assert limbs is not None
    across = at[:, limbs[0].joints[0]] - at[:, limbs[1].joints[0]]
    forward, how = np.zeros_like(across), ""
    if legs is not None and legs.legs is not None:
        how = "where the feet point"
        for limb in legs.legs:
            forward += at[:, limb.chain[-1]] - at[:, limb.joints[2]]
    if np.abs(forward[..., :2]).sum() <= tree.tiny and len(at) > 2:
        travel = at[-1, 0] - at[1, 0]
        forward, how = np.broadcast_to(travel, across.shape), "the way it travels"
    left = np.cross([0.0, 0.0, 1.0], forward)
    vote = float(np.sum(np.sign(np.sum(left * across, axis=1))))
    if vote == 0.0:
        # The custom of most files: in the rest pose left is +x of the file.
        return bool(across[0, 0] > 0), "the custom that left is the file's +x"
    return vote > 0, how


def _reason(legs: _Pair | None, arms: _Pair | None, how: str) -> str:
    parts = " and ".join(n for n, p in (("legs", legs), ("arms", arms)) if p is not None)
    return f"a person with {parts}; left and right by {how}."


def _check_tree(skeleton: Skeleton, roles: tuple[Role, ...]) -> None:
    joints = [r.joint for r in roles]
    for role in roles:
        if joints.count(role.joint) > 1:
            other = next(r for r in roles if r.joint == role.joint and r is not role)
            raise InvalidValue(
                f"Joint {role.joint!r} is given two roles: {role.role} and {other.role}."
            )


def _others(skeleton: Skeleton, roles: tuple[Role, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Joints inboard of a link that are none themselves, and joints outboard of every link."""
    kept = {skeleton.index(r.joint) for r in roles}
    inboard: set[int] = set()
    for joint in kept:
        while joint >= 0:
            inboard.add(joint)
            joint = skeleton.parents[joint]
    folded = tuple(n for i, n in enumerate(skeleton.names) if i in inboard - kept)
    dropped = tuple(n for i, n in enumerate(skeleton.names) if i not in inboard)
    return folded, dropped
