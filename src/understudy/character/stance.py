"""The neutral stance of a skeleton, and from it how each link lies in its clip joint's frame.

A link frame is aligned with the world in the neutral T-pose (x forward, y left, z up). No clip
shows that pose, so it is inferred bone by bone from a reference: the rest pose where that is a
plausible upright stance, else the clip's most neutral frame. Whatever is inferred is a constant per
joint, so a clip's own motion is reproduced exactly in any case; the inference decides only what a
joint angle means, and so how a motion looks on another body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d

from understudy.character.roles import Roles
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import PARENTS, ROLES
from understudy.motion.rotations import Array

_UP = np.array([0.0, 0.0, 1.0])
_DOWN = -_UP
# Directions of the bones in the T-pose.
_LIMBS = {
    **{f"{s}_{j}": _DOWN for s in ("left", "right") for j in ("hip", "knee")},
    **{f"left_{j}": np.array([0.0, 1.0, 0.0]) for j in ("shoulder", "elbow", "wrist")},
    **{f"right_{j}": np.array([0.0, -1.0, 0.0]) for j in ("shoulder", "elbow", "wrist")},
}
_OUTBOARD = {"hip": "knee", "knee": "ankle", "shoulder": "elbow", "elbow": "wrist"}
# Axis about which the outboard bone flexes, in the frame of the inboard link.
_HINGES = {
    "left_shoulder": _DOWN,
    "right_shoulder": _UP,
    "left_hip": np.array([0.0, 1.0, 0.0]),
    "right_hip": np.array([0.0, 1.0, 0.0]),
}
_SAMPLES = 400
# A foot at rest on the floor: its joints this near their lowest [m] and this slow [m/s].
_NEAR, _STILL = 0.03, 0.3
_LOCAL = 2.0  # s
# How far the way from ankle to ball drops below the sole's plane in the standard figure [rad].
_SLOPE = float(np.arctan2(0.039 - 0.012, 0.45 * 0.152))


@dataclass(frozen=True)
class Stance:
    """Link orientations in their clip joints.

    Attributes:
        alignments: By role: world orientation of the link = that of the joint times this.
        note: Which reference was used.
    """

    alignments: dict[str, Array]
    note: str


def neutral_stance(clip: Clip, roles: Roles) -> Stance:
    """Alignments of every role found."""
    return _Reference(clip, roles).stance()


class _Reference:
    """A reference pose, and the walk over the roles that aligns each."""

    def __init__(self, clip: Clip, roles: Roles):
        self.clip, self.roles = clip, roles
        skeleton = clip.skeleton
        self.joint = {r.role: skeleton.index(r.joint) for r in roles.found}
        self.origin = {r.role: skeleton.index(r.origin) for r in roles.found}
        self._stood: dict[str, np.ndarray] = {}
        self.step = step = max(1, clip.frames // _SAMPLES)
        pose = clip.forward_kinematics()
        self.positions, self.turned = pose.positions[::step], pose.rotations[::step]
        self.ends = pose.ends[::step]
        rest = skeleton.rest_positions()
        carriers = list(skeleton.end_joints)
        if _score(self, rest[None])[0] > 0:
            self.at, self.turn = rest, rot.identity(len(skeleton))
            self.end_at = rest[carriers] + skeleton.end_offsets
            self.frame, self.note = None, "Neutral stance: the rest pose."
        else:
            best = int(np.argmax(_score(self, self.positions)))
            self.at, self.turn, self.end_at = (
                self.positions[best],
                self.turned[best],
                self.ends[best],
            )
            self.frame = best
            self.note = (
                f"Neutral stance: the frame at {best * step / clip.rate:.2f} s, the most upright; "
                "the rest pose is no stance."
            )

    def stance(self) -> Stance:
        """Align every role, parents first."""
        links: dict[str, Array] = {}  # world orientation of each link in the reference
        heading = self._heading()
        for role in ROLES:
            if role not in self.joint:
                continue
            parent = PARENTS.get(role)
            while parent is not None and parent not in links:
                parent = PARENTS.get(parent)
            inboard = heading if parent is None else links[parent]
            links[role] = self._link(role, inboard, heading, links)
        return Stance(
            {
                role: rot.multiply(rot.conjugate(self.turn[self.joint[role]]), link)
                for role, link in links.items()
            },
            self.note,
        )

    def _link(self, role: str, inboard: Array, heading: Array, links: dict[str, Array]) -> Array:
        if role in ("pelvis", "lower_back", "upper_back"):
            return self._trunk(role, heading)
        if role == "neck":
            return heading if self.frame is None else self._facing(inboard)
        kind = role.split("_")[1]
        if kind == "ankle":
            return self._foot(role, inboard)
        if kind == "ball":
            return self._toes(role, inboard, links)
        if self.frame is not None and role in _HINGES:
            hinged = self._hinged(role)
            if hinged is not None:
                return hinged
        direction = self._direction(role)
        if direction is None:
            return inboard
        local = rot.rotate(rot.conjugate(inboard), direction)
        return rot.multiply(inboard, rot.shortest_arc(_LIMBS[role], local))

    # -- trunk --------------------------------------------------------------------------------

    def _across(self, left: str, right: str) -> Array | None:
        if left not in self.origin or right not in self.origin:
            return None
        across = self.at[self.origin[left]] - self.at[self.origin[right]]
        across = across * [1, 1, 0]
        length = np.linalg.norm(across)
        return across / length if length > 1e-6 else None

    def _yaw(self, left: Array) -> Array:
        return rot.from_matrix(np.stack([np.cross(left, _UP), left, _UP], axis=-1))

    def _heading(self) -> Array:
        """Yaw of the body: left from the hips, else the shoulders, else the file's +x."""
        for pair in (("left_hip", "right_hip"), ("left_shoulder", "right_shoulder")):
            across = self._across(*pair)
            if across is not None:
                return self._yaw(across)
        return self._yaw(np.array([1.0, 0.0, 0.0]))

    def _trunk(self, role: str, heading: Array) -> Array:
        if self.frame is None or role == "pelvis":
            return heading
        across = self._across("left_shoulder", "right_shoulder")
        chest = heading if across is None else self._yaw(across)
        return chest if role == "upper_back" else rot.slerp(heading, chest, np.array(0.5))

    def _facing(self, inboard: Array) -> Array:
        """On average over the clip a head faces where the chest does."""
        role = next(r for r in ("upper_back", "lower_back", "pelvis") if r in self.joint)
        chest_alignment = rot.multiply(rot.conjugate(self.turn[self.joint[role]]), inboard)
        chest = rot.multiply(self.turned[:, self.joint[role]], chest_alignment)
        head = self.turned[:, self.joint["neck"]]
        relative = rot.mean(rot.multiply(rot.conjugate(head), chest))
        return rot.multiply(self.turn[self.joint["neck"]], relative)

    # -- limbs --------------------------------------------------------------------------------

    def _direction(self, role: str) -> Array | None:
        """World direction of a limb's bone in the reference, shape (3,)."""
        side, kind = role.split("_")
        start = self.at[self.origin[role]]
        outboard = f"{side}_{_OUTBOARD.get(kind, '')}"
        if outboard in self.origin:
            end = self.at[self.origin[outboard]]
        else:
            end = self._tip(self.joint[role])
        if end is None or np.linalg.norm(end - start) < 1e-6:
            return None
        return (end - start) / np.linalg.norm(end - start)

    def _tip(self, joint: int) -> Array | None:
        """Mean of what lies outboard of a joint in the reference: end sites, fingers."""
        skeleton = self.clip.skeleton
        inside = {joint}
        for i in range(joint + 1, len(skeleton)):
            if skeleton.parents[i] in inside:
                inside.add(i)
        points = [
            p for j, p in zip(skeleton.end_joints, self.end_at, strict=True) if j in inside
        ] or [self.at[i] for i in inside - {joint}]
        return np.mean(points, axis=0) if points else None

    def _hinged(self, role: str) -> Array | None:
        """Orientation of an upper arm or thigh whose hinge is seen in the motion, or None."""
        side, kind = role.split("_")
        lower = f"{side}_{_OUTBOARD[kind]}"
        if lower not in self.joint:
            return None
        upper_turn, lower_turn = self.turned[:, self.joint[role]], self.turned[:, self.joint[lower]]
        relative = rot.multiply(rot.conjugate(upper_turn), lower_turn)
        middle = rot.mean(relative)
        moved = rot.to_rotvec(rot.multiply(relative, rot.conjugate(middle)))
        values, axes = np.linalg.eigh(moved.T @ moved / len(moved))
        if values[-1] < 0.8 * values.sum() or values[-1] < np.radians(8.0) ** 2:
            return None
        axis = axes[:, -1]
        along = rot.rotate(
            rot.conjugate(upper_turn),
            self.positions[:, self.origin[lower]] - self.positions[:, self.origin[role]],
        ).mean(axis=0)
        along /= np.linalg.norm(along)
        if abs(axis @ along) > 0.35:
            return None
        # The sign that bends the limb: the outboard bone turns with the axis as it leaves `along`.
        outboard = f"{side}_{_OUTBOARD.get(_OUTBOARD[kind], '')}"
        if outboard not in self.origin:
            return None
        bone = rot.rotate(
            rot.conjugate(upper_turn),
            self.positions[:, self.origin[outboard]] - self.positions[:, self.origin[lower]],
        )
        axis = axis * (np.sign(np.sum(np.cross(along, bone) @ axis)) or 1.0)
        axis = axis - along * (axis @ along)
        axis /= np.linalg.norm(axis)
        file = np.stack([along, axis, np.cross(along, axis)], axis=-1)
        own = np.stack([_LIMBS[role], _HINGES[role], np.cross(_LIMBS[role], _HINGES[role])], -1)
        alignment = rot.from_matrix(file @ own.T)
        return rot.multiply(self.turn[self.joint[role]], alignment)

    # -- feet ---------------------------------------------------------------------------------

    def _foot(self, role: str, inboard: Array) -> Array:
        """Flat on the ground, toes ahead: up is what was up while the feet stood.

        A foot never seen standing slopes from ankle to ball like the other; where neither is seen
        standing, an upright rest pose is taken as standing flat.
        """
        forward = self._forward(role, inboard)
        up = rot.rotate(inboard, _UP)
        seen = self._sole_up(role)
        other = "right_ankle" if role == "left_ankle" else "left_ankle"
        slope = self._slope(role)
        slope = self._slope(other) if slope is None else slope
        level = self.frame is None and up[2] > np.cos(np.radians(12.0))
        if seen is not None:
            up = rot.rotate(self.turn[self.joint[role]], seen)
        side = np.cross(_UP if level and seen is None else up, forward)
        side /= np.linalg.norm(side)
        if slope is not None or not level:
            slope = _SLOPE if slope is None else slope
            up = np.cross(rot.rotate(rot.from_rotvec(-slope * side), forward), side)
        else:
            up = _UP
        forward = np.cross(side, up)
        return rot.from_matrix(np.stack([forward, side, up], axis=-1))

    def _sole_up(self, role: str) -> Array | None:
        """Direction in the foot's joint frame that was up while the foot stood, or None."""
        standing = self._standing(role)
        if not len(standing):
            return None
        turned = self.turned[standing, self.joint[role]]
        mean = rot.rotate(rot.conjugate(turned), _UP).mean(axis=0)
        if np.linalg.norm(mean) < 0.97:
            return None
        up = mean / np.linalg.norm(mean)
        slope = self._slope(role, up)
        # Feet stand flat with the ball up to 38 degrees below the ankle; steeper is on tiptoe.
        return up if slope is not None and -0.1 < slope < np.radians(38.0) else None

    def _slope(self, role: str, up: Array | None = None) -> float | None:
        """Angle by which the way from ankle to ball (or toe) drops below the sole's plane [rad]."""
        if role not in self.joint:
            return None
        up = self._sole_up(role) if up is None else up
        end = self._foot_end(role)
        if up is None or end is None:
            return None
        way = rot.rotate(rot.conjugate(self.turn[self.joint[role]]), end)
        return float(np.arcsin(np.clip(-(way @ up) / np.linalg.norm(way), -1.0, 1.0)))

    def _foot_end(self, role: str) -> Array | None:
        """Way from the ankle to the ball, or to what lies outboard, in the reference [m]."""
        ball = role.replace("ankle", "ball")
        at = self.at[self.origin[role]]
        end = self.at[self.origin[ball]] if ball in self.origin else self._tip(self.joint[role])
        return None if end is None or np.linalg.norm(end - at) < 1e-6 else end - at

    def _forward(self, role: str, inboard: Array) -> Array:
        """World direction from the ankle to the ball or toe in the reference, shape (3,)."""
        along = rot.rotate(inboard, np.array([1.0, 0.0, 0.0]))
        end = self._foot_end(role)
        if end is None:
            return along
        direction = end / np.linalg.norm(end)
        # A foot drawn as a stub along the shank says nothing of where it points.
        return direction if direction @ along > 0.3 else along

    def _standing(self, role: str) -> np.ndarray:
        """Sampled frames in which the foot is on the floor and at rest, shape (n,)."""
        if role not in self._stood:
            self._stood[role] = self._find_standing(role)
        return self._stood[role]

    def _find_standing(self, role: str) -> np.ndarray:
        if len(self.positions) < 3:
            return np.zeros(0, int)
        rate = self.clip.rate / self.step
        window = max(1, round(_LOCAL * rate))
        still = np.ones(len(self.positions), bool)
        for kind in ("ankle", "ball"):
            joint = self.origin.get(role.replace("ankle", kind))
            if joint is None:
                continue
            # The floor is where the lower of the two feet was lately: captured floors slope and
            # drift, and a foot held up stands nowhere.
            both = [
                self.positions[:, self.origin[f"{side}_{kind}"], 2]
                for side in ("left", "right")
                if f"{side}_{kind}" in self.origin
            ]
            floor = minimum_filter1d(np.min(both, axis=0), window, mode="nearest")
            speed = np.linalg.norm(np.gradient(self.positions[:, joint], axis=0), axis=1) * rate
            height = self.positions[:, joint, 2] - floor
            still &= (height < _NEAR) & (speed < _STILL)
        return np.flatnonzero(still)

    def _toes(self, role: str, inboard: Array, links: dict[str, Array]) -> Array:
        """In line with the foot while it stands."""
        ankle = role.replace("ball", "ankle")
        standing = self._standing(ankle) if ankle in self.joint else np.zeros(0, int)
        if not len(standing):
            return inboard
        foot_alignment = rot.multiply(rot.conjugate(self.turn[self.joint[ankle]]), links[ankle])
        foot = rot.multiply(self.turned[standing, self.joint[ankle]], foot_alignment)
        toes = self.turned[standing, self.joint[role]]
        relative = rot.mean(rot.multiply(rot.conjugate(toes), foot))
        return rot.multiply(self.turn[self.joint[role]], relative)


def _score(reference: _Reference, at: Array) -> Array:
    """How neutral each of several poses is, shape (poses,): above 0 it is a plausible stance."""
    origin = reference.origin

    def unit(a: str, b: str) -> Array | None:
        if a not in origin or b not in origin:
            return None
        v = at[:, origin[b]] - at[:, origin[a]]
        return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9)

    score = np.ones(len(at))
    top = next((r for r in ("neck", "left_shoulder", "upper_back") if r in origin), "pelvis")
    trunk = unit("pelvis", top)
    if trunk is not None and top != "pelvis" and np.linalg.norm(trunk[0]) > 0.5:
        score = np.minimum(score, trunk[:, 2] - 0.75)
    for side in ("left", "right"):
        thigh, shank = unit(f"{side}_hip", f"{side}_knee"), unit(f"{side}_knee", f"{side}_ankle")
        if thigh is not None and shank is not None:
            score = np.minimum(score, np.minimum(-thigh[:, 2], -shank[:, 2]) - 0.75)
            score = np.minimum(score, np.sum(thigh * shank, axis=-1) - 0.75)
        upper = unit(f"{side}_shoulder", f"{side}_elbow")
        fore = unit(f"{side}_elbow", f"{side}_wrist")
        if upper is not None and fore is not None:
            score = np.minimum(score, 0.25 * (np.sum(upper * fore, axis=-1) - 0.5))
            score = np.minimum(score, 0.5 * (0.9 - upper[:, 2]))
    return score
