"""A body as a few rounded bones between tracked points: quick to draw, and true to every length."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from understudy.character import Character, Linkage
from understudy.motion.rotations import Array

# Radius of what lies between a joint and the next, for a stature of 1.75 m [m].
_RADII = {
    "shoulder": 0.046,
    "elbow": 0.036,
    "wrist": 0.03,
    "hip": 0.07,
    "knee": 0.05,
    "ankle": 0.035,
    "ball": 0.03,
}
_NEXT = {
    "shoulder": "elbow",
    "elbow": "wrist",
    "wrist": "",
    "hip": "knee",
    "knee": "ankle",
    "ankle": "ball",
    "ball": "",
}
_AZIMUTH, _ELEVATION = np.radians(-42.0), np.radians(10.0)


@dataclass(frozen=True, kw_only=True)
class Bone:
    """A rounded line between two points of the poses.

    Attributes:
        a: Where it begins; a point's number.
        b: Where it ends.
        begin: Share of the way from a to b at which it begins.
        end: The same for its end.
        radius: [m].
        side: "left", "right" or "".
    """

    a: int
    b: int
    begin: float = 0.0
    end: float = 1.0
    radius: float
    side: str = ""


def figure_of(character: Character | Linkage) -> tuple[Bone, ...]:
    """The bones to draw for poses of a character (its joints in order, then its ends).

    Of a linkage, whose poses are its joints alone, one bone per body.
    """
    skeleton = character.skeleton
    if isinstance(character, Linkage):
        return tuple(
            Bone(a=p, b=j, radius=0.022 * character.height, side=_side(skeleton.names[j]))
            for j, p in enumerate(skeleton.parents)
            if p >= 0
        )
    ends = {j: len(skeleton) + k for k, j in enumerate(skeleton.end_joints)}
    roles = {link.role: i for i, link in enumerate(character.links) if link.role}
    if not roles:
        size = float(np.ptp(skeleton.rest_positions(), axis=0).max()) or 1.0
        lines = [(p, j) for j, p in enumerate(skeleton.parents) if p >= 0] + list(ends.items())
        return tuple(Bone(a=a, b=b, radius=0.02 * size) for a, b in lines)
    scale = character.height / 1.75
    out: list[Bone] = []

    def add(a: str, b: str, radius: float, side: str = "") -> None:
        if a in roles and b in roles:
            out.append(Bone(a=roles[a], b=roles[b], radius=radius * scale, side=side))

    add("left_hip", "right_hip", 0.075)
    add("pelvis", "upper_back", 0.1)
    add("upper_back" if "upper_back" in roles else "pelvis", "neck", 0.1)
    add("left_shoulder", "right_shoulder", 0.06)
    for side in ("left", "right"):
        for part, after in _NEXT.items():
            role = f"{side}_{part}"
            if role not in roles:
                continue
            if f"{side}_{after}" in roles:
                add(role, f"{side}_{after}", _RADII[part], side)
            elif roles[role] in ends:
                b, radius = ends[roles[role]], _RADII[part] * scale
                out.append(Bone(a=roles[role], b=b, radius=radius, side=side))
    if "neck" in roles and roles["neck"] in ends:
        top = ends[roles["neck"]]
        out.append(Bone(a=roles["neck"], b=top, begin=0.1, end=0.3, radius=0.05 * scale))
        out.append(Bone(a=roles["neck"], b=top, begin=0.5, end=0.72, radius=0.088 * scale))
    return tuple(out)


def _side(name: str) -> str:
    """The side that a clip joint's name tells: LeftFoot, LHipJoint, left_knee."""
    for side in ("left", "right"):
        initial = side[0].upper()
        if name.lower().startswith(side) or (name[:1] == initial and name[1:2].isupper()):
            return side
    return ""


def heading_of(poses: Array, figure: tuple[Bone, ...]) -> float:
    """Direction in which a figure faces at first, from +x toward +y [rad]."""
    left = [bone.a for bone in figure if bone.side == "left"]
    right = [bone.a for bone in figure if bone.side == "right"]
    if not left or len(left) != len(right):
        return 0.0
    some = np.asarray(poses[: max(1, len(poses) // 4)], float)
    across = (some[:, left] - some[:, right]).sum(axis=(0, 1))
    return float(np.arctan2(-across[0], across[1])) if np.any(across[:2]) else 0.0


def view_axes(heading: float) -> Array:
    """Right, up and forward of a three-quarter camera in the world as rows, shape (3, 3)."""
    bearing = heading + _AZIMUTH
    flat = np.cos(_ELEVATION)
    to_camera = np.array([flat * np.cos(bearing), flat * np.sin(bearing), np.sin(_ELEVATION)])
    right = np.array([-np.sin(bearing), np.cos(bearing), 0.0])
    return np.stack((right, np.cross(to_camera, right), -to_camera))


def plain(figure: tuple[Bone, ...]) -> list[list[Any]]:
    """Bones as JSON lists: a, b, begin, end, radius [m], side."""
    return [[b.a, b.b, b.begin, b.end, round(b.radius, 4), b.side] for b in figure]
