"""A character from a skeleton that is no person: one link per bone, capsules of water."""

from __future__ import annotations

import numpy as np

from understudy.character.anthropometry import MassProperties
from understudy.character.body import Character, Link, Shape
from understudy.character.mapping import Mapping
from understudy.character.masses import measured_properties
from understudy.character.roles import Roles
from understudy.character.solids import capsule
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array

DENSITY = 1000.0  # kg/m3, water; people and animals differ from it by a few per cent
# Bone radius over its length, and its bounds over the skeleton's greatest extent.
_RADIUS, _THIN, _THICK = 0.12, 0.008, 0.05
_SMALLEST = 0.02  # m
_COLOR = (0.62, 0.62, 0.58, 1.0)


def bone_character(
    clip: Clip, *, mass: float | None, mapping: Mapping | None, roles: Roles, name: str | None
) -> Character:
    """One link per joint, its bones capsules of density 1000 kg/m3, frames as in the file.

    Joints of zero length that carry nothing are folded, and so are joints whose rotation moves
    nothing else; what the mapping drops or folds goes too.

    Raises:
        InvalidValue: The skeleton is smaller than 2 cm: its unit must be wrong, and MuJoCo could
            not simulate it.
    """
    kept = _kept(clip, mapping or Mapping())
    skeleton, pose = clip.skeleton, clip.forward_kinematics()
    extent = _extent(clip)
    if extent < _SMALLEST:
        raise InvalidValue(
            f"{clip.name}: measures {extent:.3g} m from the root to the farthest tip; at least "
            f"{_SMALLEST:g} m can be simulated. Read the clip with the right unit."
        )
    offsets: list[Array] = []
    parents: list[int] = []
    for joint in kept:
        above = skeleton.parents[joint]
        while above >= 0 and above not in kept:
            above = skeleton.parents[above]
        parents.append(kept.index(above) if above >= 0 else -1)
        if above < 0:
            offsets.append(np.zeros(3))
            continue
        way = pose.positions[:, joint] - pose.positions[:, above]
        local = rot.rotate(rot.conjugate(pose.rotations[:, above]), way)
        fixed = np.linalg.norm(local - local[0], axis=1).max() < 1e-9
        offsets.append(local[0] if fixed else np.median(local, axis=0))
    ends = [
        np.array(
            [o for j, o in zip(skeleton.end_joints, skeleton.end_offsets, strict=True) if j == k]
        ).reshape(-1, 3)
        for k in kept
    ]
    shapes: dict[str, tuple[Shape, ...]] = {}
    for k, joint in enumerate(kept):
        tips = [offsets[i] for i, p in enumerate(parents) if p == k] + list(ends[k])
        shapes[skeleton.names[joint]] = _capsules(tips, extent)
    properties = measured_properties(shapes, total=mass)
    links = tuple(
        _link(skeleton.names[joint], parents[k], offsets[k], ends[k], shapes, properties)
        for k, joint in enumerate(kept)
    )
    rest = np.array(offsets)
    for k, p in enumerate(parents):
        rest[k] += rest[p] if p >= 0 else 0.0
    total = float(sum(link.mass for link in links))
    folded = [n for i, n in enumerate(skeleton.names) if i not in kept]
    notes = [
        f"No person: {roles.reason}",
        f"One link per bone, {total:.3g} kg of {DENSITY:g} kg/m3.",
    ]
    if folded:
        notes.append(f"Folded: {', '.join(folded)}.")
    return Character(
        name=name or clip.name,
        links=links,
        plan="bones",
        mass=total,
        height=extent,
        source=skeleton,
        roles=roles,
        notes=tuple(notes),
    )


def _link(
    name: str,
    parent: int,
    offset: Array,
    ends: Array,
    shapes: dict[str, tuple[Shape, ...]],
    properties: dict[str, MassProperties],
) -> Link:
    own = properties[name]
    return Link(
        name=name,
        joint=name,
        role=None,
        parent=parent,
        offset=offset,
        ends=ends,
        mass=own.mass,
        com=own.com,
        inertia=own.inertia,
        shapes=shapes[name],
        clip_joint=name,
        origin_joint=name,
    )


def _extent(clip: Clip) -> float:
    """Longest way from the root to a tip [m]."""
    skeleton = clip.skeleton
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    lengths[0] = 0.0
    depth = np.array(lengths)
    for i, p in enumerate(skeleton.parents[1:], 1):
        depth[i] += depth[p]
    tips = [
        depth[j] + float(np.linalg.norm(o))
        for j, o in zip(skeleton.end_joints, skeleton.end_offsets, strict=True)
    ]
    extent = float(max([depth.max(), *tips]))
    return extent if extent > 1e-6 else 0.1


def _kept(clip: Clip, mapping: Mapping) -> list[int]:
    """Joints that become links, every branch before the next."""
    skeleton, pose = clip.skeleton, clip.forward_kinematics()
    out: set[int] = set(range(len(skeleton)))
    gone = {skeleton.index(n) for n in mapping.drop}
    for i, p in enumerate(skeleton.parents):
        if p in gone:
            gone.add(i)
    out -= gone | {skeleton.index(n) for n in mapping.fold}
    ended = set(skeleton.end_joints)
    tiny = 1e-6 * _extent(clip)
    for joint in reversed(range(1, len(skeleton))):
        if np.linalg.norm(skeleton.offsets[joint]) > tiny or joint in ended:
            continue
        parent = skeleton.parents[joint]
        still = True
        for child in skeleton.children(joint):
            way = pose.positions[:, child] - pose.positions[:, parent]
            local = rot.rotate(rot.conjugate(pose.rotations[:, parent]), way)
            still &= bool(np.linalg.norm(local - local[0], axis=1).max() <= tiny)
        if still:
            out.discard(joint)
    if not out:
        raise InvalidValue(f"{clip.name}: the mapping leaves no joint to make a link of.")
    out.add(0)
    return [joint for joint in _depth_first(clip, 0) if joint in out]


def _depth_first(clip: Clip, joint: int) -> list[int]:
    """A joint and all outboard of it, in the order in which MuJoCo numbers bodies."""
    order, stack = [], [joint]
    while stack:
        order.append(stack.pop())
        stack.extend(reversed(clip.skeleton.children(order[-1])))
    return order


def _capsules(tips: list[Array], extent: float) -> tuple[Shape, ...]:
    """A capsule to each tip; a small ball where there is none."""
    out = []
    for tip in tips:
        length = float(np.linalg.norm(tip))
        if length < 1e-3 * extent:
            continue
        radius = float(np.clip(_RADIUS * length, _THIN * extent, _THICK * extent))
        # Drawn short of both joints by its radius, so that neighbors do not overlap.
        inset = min(radius, 0.45 * length) / length
        out.append(capsule(inset * tip, (1 - inset) * tip, radius, density=DENSITY, rgba=_COLOR))
    if not out:
        out.append(capsule(np.zeros(3), np.zeros(3), 0.02 * extent, density=DENSITY, rgba=_COLOR))
    return tuple(out)
