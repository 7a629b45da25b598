"""Arms and legs in a tree of joints: pairs of equal chains, read by lengths and by names.

In each chain the three joints that make the most human limb are taken: lengths count, and what
names say counts more. Whether it is a person at all is decided by the stance: somewhere in the clip
the trunk stands over the legs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import combinations
from math import log

import numpy as np

from understudy.character.anthropometry import LENGTHS
from understudy.character.mapping import Mapping
from understudy.character.names import Hint, hints
from understudy.motion.clip import Clip

_LEG = LENGTHS["thigh"] + LENGTHS["shank"]
_ARM = LENGTHS["upper_arm"] + LENGTHS["forearm"]
_NAMED, _MISNAMED = -1.5, 1.0
# A pair of chains whose best limb costs more than this is no arm or leg.
_WORST = 2.0
# Cosine between the trunk, or the legs, and the vertical in the most upright frame.
_UPRIGHT = 0.7
_SAMPLES = 120


class JointTree:
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
        """Joints and end sites attached to a joint."""
        return [i for i, p in enumerate(self.parents) if p == joint and i not in self.hidden]

    def kinds(self, joint: int) -> tuple[str, ...]:
        """What a joint's name may mean, best first."""
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
class Limb:
    """Three joints of one chain (hip, knee, ankle or shoulder, elbow, wrist) and their cost."""

    joints: tuple[int, int, int]
    cost: float
    chain: tuple[int, ...]


@dataclass(frozen=True)
class Pair:
    """Two chains hanging on one joint, read as legs and as arms."""

    root: int
    chains: tuple[tuple[int, ...], tuple[int, ...]]
    legs: tuple[Limb, Limb] | None = field(repr=False)
    arms: tuple[Limb, Limb] | None = field(repr=False)


def _pairs(tree: JointTree) -> Iterator[Pair]:
    """Pairs of chains that are alike in length or opposite in name."""
    longest = float(tree.reach.max())
    for root in range(tree.real):
        heads = [c for c in tree.children(root) if tree.lengths[c] + tree.reach[c] > 0.2 * longest]
        for a, b in combinations(heads, 2):
            one, two = tree.chain(a), tree.chain(b)
            if not (_opposite(tree, one, two) or _alike(tree, one, two)):
                continue
            yield Pair(
                root,
                (tuple(one), tuple(two)),
                _limb_pair(tree, root, one, two, _leg),
                _limb_pair(tree, root, one, two, _arm),
            )


def _opposite(tree: JointTree, one: list[int], two: list[int]) -> bool:
    """Whether names say that one is left and the other right, from the first joint to the last."""
    sides = []
    for chain in (one, two):
        named = [tree.hints[j] for j in chain if tree.kinds(j)]
        sides.append(
            {h.side for h in named} or {tree.hints[j].side for j in chain if j < tree.real}
        )
    return {"left"} in sides and {"right"} in sides


def _alike(tree: JointTree, one: list[int], two: list[int]) -> bool:
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
    tree: JointTree, root: int, one: list[int], two: list[int], cost: Callable[..., float]
) -> tuple[Limb, Limb] | None:
    """The best limb of either chain, joints at the same places where both chains have as many."""
    best: tuple[float, Limb, Limb] | None = None
    if len(one) == len(two):
        for places in combinations(range(len(one)), 3):
            limbs = [
                Limb(
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
                (Limb(j, cost(tree, root, c, j), tuple(c)) for j in combinations(c, 3)),
                key=lambda limb: limb.cost,
                default=None,
            )
            for c in (one, two)
        ]
        if found[0] is not None and found[1] is not None:
            best = 0.5 * (found[0].cost + found[1].cost), found[0], found[1]
    return None if best is None or not np.isfinite(best[0]) else (best[1], best[2])


def _leg(tree: JointTree, root: int, chain: list[int], joints: tuple[int, ...]) -> float:
    """Cost of reading three joints of a chain as hip, knee and ankle."""
    hip, knee, ankle = joints
    thigh, shank = tree.between(hip, knee), tree.between(knee, ankle)
    if min(thigh, shank) <= tree.tiny or tree.unlinked & set(joints):
        return np.inf
    foot = float(tree.reach[ankle]) / (thigh + shank)
    inboard = tree.between(root, hip) / (thigh + shank)
    cost = 2 * abs(log(thigh / shank)) + 5 * max(0.0, foot - 0.5) + 2 * max(0.0, inboard - 0.3)
    return cost + _skipped(tree, chain, joints) + _naming(tree, joints, ("hip", "knee", "ankle"))


def _arm(tree: JointTree, root: int, chain: list[int], joints: tuple[int, ...]) -> float:
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


def _skipped(tree: JointTree, chain: list[int], joints: tuple[int, ...]) -> float:
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


def _naming(tree: JointTree, joints: tuple[int, ...], kinds: tuple[str, ...]) -> float:
    cost = 0.0
    for joint, kind in zip(joints, kinds, strict=True):
        said = tree.kinds(joint)
        if kind in said:
            cost += _NAMED if said[0] == kind else 0.6 * _NAMED
        elif said:
            cost += _MISNAMED
    return cost


def find_limbs(tree: JointTree) -> tuple[Pair | None, Pair | None]:
    """The pair of legs and the pair of arms that together cost least."""
    pairs = list(_pairs(tree))
    legs = [p for p in pairs if p.legs and _cost(p.legs) < _WORST]
    arms = [p for p in pairs if p.arms and _cost(p.arms) < _WORST]
    best: tuple[float, Pair | None, Pair | None] | None = None
    for leg in legs:
        for arm in arms:
            if not _apart(tree, leg, arm):
                continue
            assert leg.legs and arm.arms
            cost = _cost(leg.legs) + _cost(arm.arms) - 4.0
            sizes = [limb_size(tree, leg.legs[0]), limb_size(tree, arm.arms[0])]
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


def _alone(tree: JointTree, pair: Pair, read: str) -> bool:
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
    down = float(np.max(drop) / limb_size(tree, limbs[0])) > 0.9 and pair.root == 0
    return down if read == "legs" else not down


def _other_chain(tree: JointTree, pair: Pair) -> bool:
    """Whether something besides the pair hangs on its joint or inboard of it: a trunk."""
    heads = {pair.chains[0][0], pair.chains[1][0]}
    return any(c not in heads for c in tree.children(pair.root)) or pair.root != 0


def _cost(limbs: tuple[Limb, Limb]) -> float:
    return 0.5 * (limbs[0].cost + limbs[1].cost)


def limb_size(tree: JointTree, limb: Limb) -> float:
    """Length of both bones of a limb [m]."""
    return tree.between(limb.joints[0], limb.joints[2])


def _inside(tree: JointTree, joint: int) -> set[int]:
    """A joint and all outboard of it."""
    out = {joint}
    for i in range(joint + 1, len(tree.parents)):
        if tree.parents[i] in out:
            out.add(i)
    return out


def _apart(tree: JointTree, leg: Pair, arm: Pair) -> bool:
    """Neither pair lies within the other's chains."""
    for one, two in ((leg, arm), (arm, leg)):
        held = {j for head in (one.chains[0][0], one.chains[1][0]) for j in _inside(tree, head)}
        if held & {two.root, two.chains[0][0], two.chains[1][0]}:
            return False
    return True


def is_person(tree: JointTree, legs: Pair | None, arms: Pair | None) -> bool:
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
        upright.append(rise[:, 2] / limb_size(tree, a))
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
