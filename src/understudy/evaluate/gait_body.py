"""A moving person seen by role: joint centers, orientations, center of mass, soles.

In comes a clip or a take; out goes one `Mover`, so that everything after it measures both alike. A
clip is put on the body with its own bones, whose masses are those of published segments.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.character import Character, Linkage
from understudy.character.retarget import retargeted
from understudy.character.soles import sole_points, standing
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.evaluate.measure import Measured

SIDES = ("left", "right")
LEG = ("hip", "knee", "ankle")
PERSON = 1.75
"""Stature [m] for which lengths in rules are meant; speeds scale with its square root."""
NEEDED = 200.0
"""Frames per second [Hz] of a take that are enough for joint angles."""
# Speeds of sole points are taken over this long [s].
_WINDOW = 0.05


@dataclass(frozen=True, kw_only=True)
class Mover:
    """Where a person's parts are over time, world frame.

    Attributes:
        name: Of the clip or the character.
        times: [s], shape (frames,).
        rate: Frames per second [Hz].
        mass: [kg].
        height: Stature [m].
        roles: Number of each role's link.
        positions: Joint centers [m], shape (frames, links, 3).
        rotations: Link orientations, wxyz, shape (frames, links, 4); the identity in a neutral
            stance that faces +x.
        center_of_mass: [m], shape (frames, 3).
        upright: Forward lean of the trunk's line in the neutral stance [rad].
        sole_heights: Per side, height of its sole points over the floor [m], (frames, points);
            empty for a take, whose contact forces tell more.
        sole_speeds: Per side, speed of those points [m/s], (frames, points).
    """

    name: str
    times: Array = field(repr=False)
    rate: float
    mass: float
    height: float
    roles: dict[str, int] = field(repr=False)
    positions: Array = field(repr=False)
    rotations: Array = field(repr=False)
    center_of_mass: Array = field(repr=False)
    upright: float = 0.0
    sole_heights: dict[str, Array] = field(default_factory=dict, repr=False)
    sole_speeds: dict[str, Array] = field(default_factory=dict, repr=False)

    def at(self, role: str) -> Array:
        """Position of a role's joint [m], shape (frames, 3)."""
        return self.positions[:, self.roles[role]]

    def axis(self, role: str, way: Any) -> Array:
        """A direction fixed in a role's link, in the world, shape (frames, 3)."""
        return rot.rotate(self.rotations[:, self.roles[role]], np.asarray(way, float))

    def forefoot(self, side: str) -> Array:
        """The ball of a foot [m], or its ankle where there is no ball joint, shape (frames, 3)."""
        role = f"{side}_ball"
        return self.at(role if role in self.roles else f"{side}_ankle")

    @property
    def leg_length(self) -> float:
        """Thigh and shank [m], mean of both sides."""
        return float(
            np.mean(
                [
                    np.linalg.norm(self.at(f"{side}_{b}")[0] - self.at(f"{side}_{a}")[0])
                    for side in SIDES
                    for a, b in (("hip", "knee"), ("knee", "ankle"))
                ]
            )
            * 2.0
        )


def of_clip(clip: Clip, body: Character | None = None) -> Mover:
    """A clip as a person in motion.

    Args:
        clip: Any motion of a person with legs.
        body: Whose bones and masses to use; None makes the body of the clip's own skeleton.

    Raises:
        InvalidValue: No person with two legs, or fewer than five frames.
    """
    if clip.frames < 5:
        raise InvalidValue(f"{clip.name}: has {clip.frames} frames; gait needs at least 5.")
    body = body or Character.from_clip(clip)
    roles = _roles(body, clip.name)
    own = retargeted(clip, body)
    pose = own.forward_kinematics()
    masses = np.array([link.mass for link in body.links])
    centers = pose.positions + rot.rotate(pose.rotations, np.array([k.com for k in body.links]))
    heights, speeds = _soles(standing(own, body), body)
    return Mover(
        name=clip.name,
        times=own.times,
        rate=own.rate,
        mass=float(masses.sum()),
        height=float(body.height),
        roles=roles,
        positions=pose.positions,
        rotations=pose.rotations,
        center_of_mass=np.einsum("l,fli->fi", masses / masses.sum(), centers),
        upright=_upright(body, roles),
        sole_heights=heights,
        sole_speeds=speeds,
    )


def of_measured(m: Measured, character: int = 0) -> Mover:
    """A character of a measured take, at no more frames than joint angles need.

    Raises:
        InvalidValue: No person with two legs.
    """
    who = m.performer(character)
    if isinstance(who.character, Linkage):
        raise InvalidValue(
            f"{who.character.name}: is a linkage of rigid bodies; measure the gait of take.clip()."
        )
    roles = _roles(who.character, who.character.name)
    gravity = 9.81
    every = max(1, round(m.rate / NEEDED))
    keep = slice(None, None, every)
    return Mover(
        name=who.character.name,
        times=m.times[keep],
        rate=m.rate / every,
        mass=who.weight / gravity,
        height=who.height,
        roles=roles,
        positions=m.body_positions[keep][:, who.bodies],
        rotations=m.body_rotations[keep][:, who.bodies],
        center_of_mass=m.center_of_mass[keep, character],
        upright=_upright(who.character, roles),
    )


def named(mover: Mover, name: str | None) -> Mover:
    """The same under another name; None keeps it."""
    return mover if name is None else replace(mover, name=name)


def _roles(body: Any, name: str) -> dict[str, int]:
    roles = {link.role: k for k, link in enumerate(body.links) if link.role is not None}
    for role in ("pelvis", *(f"{side}_{joint}" for side in SIDES for joint in LEG)):
        if role not in roles:
            raise InvalidValue(
                f"{name}: has no {role.replace('_', ' ')}; gait needs a person with two legs."
            )
    return roles


def _upright(body: Any, roles: dict[str, int]) -> float:
    """Forward lean of the line from the hips to the neck in the neutral stance [rad]."""
    rest = body.skeleton.rest_positions()
    line = rest[trunk_end(roles)] - 0.5 * (rest[roles["left_hip"]] + rest[roles["right_hip"]])
    return float(np.arctan2(line[0], line[2]))


def trunk_end(roles: dict[str, int]) -> int:
    """Number of the link whose joint is the upper end of the trunk's line."""
    return next((roles[r] for r in ("neck", "upper_back", "lower_back") if r in roles), 0)


def _soles(clip: Clip, body: Character) -> tuple[dict[str, Array], dict[str, Array]]:
    """Heights [m] and speeds [m/s] of the sole points of each side, (frames, points)."""
    pose = clip.forward_kinematics()
    heights: dict[str, list[Array]] = {side: [] for side in SIDES}
    speeds: dict[str, list[Array]] = {side: [] for side in SIDES}
    for link, center, radius in sole_points(body):
        side = (body.links[link].role or "").partition("_")[0]
        if side not in heights:
            continue
        place = pose.positions[:, link] + rot.rotate(pose.rotations[:, link], center)
        window = max(_WINDOW, 4.0 / clip.rate)
        velocity = derivative(place, clip.rate, smoothing=window)
        heights[side].append(place[:, 2] - radius)
        speeds[side].append(np.linalg.norm(velocity, axis=1))
    if not all(heights.values()):
        raise InvalidValue(f"{body.name}: has a foot without a sole; gait needs both.")
    return (
        {side: np.stack(rows, axis=1) for side, rows in heights.items()},
        {side: np.stack(rows, axis=1) for side, rows in speeds.items()},
    )
