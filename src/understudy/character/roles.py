"""Which joint of a skeleton is the left knee: roles found by topology, symmetry and names together.

Arms and legs are pairs of equal chains (`understudy.character.chains`), the back is the way from
the one to the other, and the neck goes on from there. Left and right come from names where they say
so, otherwise from where the feet point.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from understudy.character.chains import JointTree, Limb, Pair, find_limbs, is_person, limb_size
from understudy.character.mapping import Mapping
from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.figure import PARENTS, ROLES
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton


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
    tree = JointTree(clip, mapping)
    roles, reason = _search(tree)
    for role, joint in mapping.roles.items():
        roles[role] = Role(
            role=role, joint=joint, origin=joint, confidence=1.0, evidence="said by the mapping"
        )
    if mapping.roles and "pelvis" not in roles:
        raise InvalidValue(
            f"{clip.name}: the mapping gives roles, but no pelvis was found; give pelvis as well."
        )
    if not roles:
        return Roles(reason=reason or "no pair of legs or arms.")
    ordered = tuple(roles[r] for r in ROLES if r in roles)
    _check_tree(clip.skeleton, ordered)
    folded, dropped = _others(clip.skeleton, ordered)
    return Roles(found=ordered, folded=folded, dropped=dropped, reason=reason)


def _search(tree: JointTree) -> tuple[dict[str, Role], str]:
    """Roles by name, and what was decided on."""
    legs, arms = find_limbs(tree)
    if legs is None and arms is None:
        return {}, "no two chains are alike in the way of legs or arms."
    if not is_person(tree, legs, arms):
        return {}, "the trunk never stands upright over the legs."
    pelvis = legs.root if legs is not None else 0
    spine, neck = _trunk(tree, pelvis, arms)
    sides, how = _sides(tree, legs, arms)
    out: dict[str, Role] = {}

    def add(role: str, joint: int, kind: str, why: str, origin: int | None = None) -> None:
        said = tree.kinds(joint)
        named = kind in said or (kind == "neck" and "head" in said)
        confidence = 0.95 if named else (0.55 if said else 0.75)
        words = "name; " if named else ("against its name; " if said else "")
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
                add(f"{side}_{kind}", joint, kind, f"lengths of a{' leg' if tail else 'n arm'}")
            toe = _toe(tree, limb) if tail else None
            if toe is not None:
                add(f"{side}_ball", toe, "ball", "beyond the ankle")
    if not ("left_ball" in out and "right_ball" in out):
        out.pop("left_ball", None)
        out.pop("right_ball", None)
    return out, _reason(legs, arms, how)


def _trunk(tree: JointTree, pelvis: int, arms: Pair | None) -> tuple[list[int], list[int]]:
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


def _back_without_arms(tree: JointTree, pelvis: int) -> list[int]:
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


def _neck(tree: JointTree, top: int, taken: set[int]) -> list[int]:
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


def _toe(tree: JointTree, limb: Limb) -> int | None:
    """The joint at the ball of the foot."""
    if limb.joints[2] >= tree.real:
        return None
    chain = limb.chain[limb.chain.index(limb.joints[2]) + 1 :]
    chain = tuple(j for j in chain if j < tree.real)
    named = [j for j in chain if "ball" in tree.kinds(j)]
    if named:
        return named[0]
    size = limb_size(tree, limb)
    plain = [j for j in chain if 0.06 < tree.lengths[j] / size < 0.4 and not tree.kinds(j)]
    return plain[0] if plain and tree.reach[plain[0]] > tree.tiny else None


def _sides(
    tree: JointTree, legs: Pair | None, arms: Pair | None
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


def _geometric_side(tree: JointTree, pair: Pair, legs: Pair | None) -> tuple[bool, str]:
    """Whether the first chain is left, by the first that tells: feet, knees, travel, custom."""
    at = tree.positions
    limbs = pair.legs if pair is legs else pair.arms
    assert limbs is not None
    across = at[:, limbs[0].joints[0]] - at[:, limbs[1].joints[0]]
    for forward, how in _forward(tree, legs):
        left = np.cross([0.0, 0.0, 1.0], forward)
        vote = float(np.sum(left * across))
        if abs(vote) > tree.tiny**2:
            return vote > 0, how
    # The custom of most files: in the rest pose left is +x of the file.
    return bool(across[0, 0] > 0), "the custom that left is the file's +x"


def _forward(tree: JointTree, legs: Pair | None) -> Iterator[tuple[Array, str]]:
    """Ways that could be forward [m], shape (samples, 3), and what tells, best first."""
    at = tree.positions
    if legs is not None and legs.legs is not None:
        one, two = legs.legs
        feet = np.zeros_like(at[:, 0])
        knees = np.zeros_like(feet)
        for leg in (one, two):
            hip, knee, ankle = leg.joints
            feet += at[:, leg.chain[-1]] - at[:, ankle]
            knees += at[:, knee] - 0.5 * (at[:, hip] + at[:, ankle])
        # Feet drawn as stubs straight down tell nothing.
        if np.hypot(feet[:, 0], feet[:, 1]).mean() > 0.5 * np.linalg.norm(feet, axis=1).mean():
            yield feet, "where the feet point"
        if np.linalg.norm(knees, axis=1).max() > 0.05 * limb_size(tree, one):
            yield knees, "where the knees bend"
    if len(at) > 2:
        yield np.broadcast_to(at[-1, 0] - at[1, 0], at[:, 0].shape), "the way it travels"


def _reason(legs: Pair | None, arms: Pair | None, how: str) -> str:
    parts = " and ".join(n for n, p in (("legs", legs), ("arms", arms)) if p is not None)
    return f"a person with {parts}; left and right by {how}."


def _check_tree(skeleton: Skeleton, roles: tuple[Role, ...]) -> None:
    """Raise `InvalidValue` when two roles share a joint, or a limb's joints do not follow."""
    joints = {r.role: r.joint for r in roles}
    for role, joint in joints.items():
        other = next((r for r in joints if r != role and joints[r] == joint), None)
        if other is not None:
            raise InvalidValue(f"Joint {joint!r} is given two roles: {role} and {other}.")
        inboard = PARENTS.get(role, "")
        if "_" not in inboard or inboard not in joints or inboard.endswith("_back"):
            continue
        above = skeleton.index(joint)
        while above >= 0 and skeleton.names[above] != joints[inboard]:
            above = skeleton.parents[above]
        if above < 0:
            raise InvalidValue(
                f"Joint {joint!r} ({role}) does not hang on {joints[inboard]!r} ({inboard})."
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
