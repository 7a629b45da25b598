"""The runner's gains: named values at 3.5 m/s and how each changes with speed.

The shipped values are the output of `understudy train running`, kept with the command and the seed
that made them in `running.json` beside this module.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from understudy.errors import InvalidValue, UnknownName
from understudy.motion.rotations import Array

# Speed [m/s] at which gains have their named values.
MIDDLE = 3.5


@dataclass(frozen=True, kw_only=True)
class Gains:
    """Numbers of the runner's control laws; angles [rad], times [s], lengths [m].

    Stiffnesses [N m/rad] and dampings [N m s/rad] are those of a body of 70 kg and 1.75 m; another
    body's are scaled by weight times height.

    Attributes:
        touchdown_knee: Flexion of the knee at touchdown; gives the leg its length.
        touchdown_foot: Toe-up pitch of the foot at touchdown, so that the heel lands first.
        speed_place: k of equation 1 [s].
        side_place: k of equation 2 [s].
        place_apart: Heel outward of the middle line.
        place_ahead: Added to equation 1.
        place_turn: Heel outward of a turn, over speed times turning rate.
        speed_matching: Share of the ground's speed with which the foot, swung further forward,
            moves back to touch.
        knee_stiffness: Of the spring that the knee is in stance.
        knee_damping: Of the same.
        knee_rest: Its rest angle.
        knee_rest_thrust: Its rest angle from the thrust on.
        thrust_at: Share of the expected stance after which the ankle thrusts.
        heel_ankle: Ankle's rest angle while only the heel touches.
        heel_stiffness: Its stiffness there.
        flat_ankle: Ankle's rest angle while heel and toe touch.
        flat_stiffness: Its stiffness there.
        thrust_ankle: Angle to which the ankle thrusts; negative points the toe.
        thrust_stiffness: Its stiffness there.
        thrust_time: How long the thrust takes to build up.
        ankle_damping: In stance.
        toe_stiffness: Of the passive joint at the ball of the foot.
        pitch: Desired forward lean of the pelvis.
        roll_stiffness: Of the attitude servo in the stance hip.
        roll_damping: Of the same.
        roll_support: Torque that holds up the swing side [N m], negative for the left leg.
        pitch_stiffness: Of the attitude servo.
        pitch_damping: Of the same.
        yaw_stiffness: Of the attitude servo.
        yaw_damping: Of the same.
        idle_reaction: Share of the idle hip's reaction that the stance hip takes up.
        hip_stiffness: Of the hips in flight and of the idle hip.
        hip_damping: Of the same.
        hip_turn: Share of a heading error that the landing hip turns out.
        swing_stiffness: Of the knees in flight and of the idle knee.
        swing_damping: Of the same.
        swing_share: Share of the expected flight in which the active leg reaches its place.
        idle_knee: Flexion that shortens the idle leg.
        idle_time: How long it takes to get there.
        ready_knee: Flexion of the idle knee from the other's thrust on.
        mirror: Share of the active hip's motion that the idle hip mirrors (1 in equation 4).
        mirror_ahead: Added to the idle hip's angle (0 in equation 4).
        idle_apart: Outward turn of the idle hip, so that the legs pass.
        arm_swing: k of equation 5.
        arm_offset: gamma_0 of equation 5, about a hip flexion of 0.3.
        waist_stiffness: Of the waist's servos.
        waist_turn: Waist's turn over the difference of the hips.
        waist_lean: Forward lean of the chest over the pelvis.
        flight_goal: Desired time of flight [s].
        flight_thrust: Stiffness that the thrust gains per second that the last flights were too
            short [N m/rad s].
    """

    touchdown_knee: float = 0.4
    touchdown_foot: float = 0.393
    speed_place: float = 0.02
    side_place: float = 0.03
    place_apart: float = 0.03
    place_ahead: float = -0.29
    place_turn: float = 0.085
    speed_matching: float = 0.6
    knee_stiffness: float = 334.0
    knee_damping: float = 14.3
    knee_rest: float = 0.382
    knee_rest_thrust: float = 0.286
    thrust_at: float = 0.4
    heel_ankle: float = -0.0109
    heel_stiffness: float = 120.0
    flat_ankle: float = 0.128
    flat_stiffness: float = 678.0
    thrust_ankle: float = -0.55
    thrust_stiffness: float = 500.0
    thrust_time: float = 0.0397
    ankle_damping: float = 12.6
    toe_stiffness: float = 100.0
    pitch: float = 0.0555
    roll_stiffness: float = 1450.0
    roll_damping: float = 151.0
    roll_support: float = -55.4
    pitch_stiffness: float = 1280.0
    pitch_damping: float = 132.0
    yaw_stiffness: float = 160.0
    yaw_damping: float = 30.0
    idle_reaction: float = 0.573
    hip_stiffness: float = 381.0
    hip_damping: float = 48.5
    hip_turn: float = 0.0923
    swing_stiffness: float = 487.0
    swing_damping: float = 17.9
    swing_share: float = 0.65
    idle_knee: float = 1.69
    idle_time: float = 0.23
    ready_knee: float = 1.4
    mirror: float = 0.54
    mirror_ahead: float = 0.47
    idle_apart: float = 0.0092
    arm_swing: float = 0.95
    arm_offset: float = -0.4
    waist_stiffness: float = 401.0
    waist_turn: float = -0.25
    waist_lean: float = -0.00431
    flight_goal: float = 0.14
    flight_thrust: float = 3000.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not np.isfinite(value):
                raise InvalidValue(f"{name} is {value}; it must be a finite number.")


NAMES = tuple(f.name for f in fields(Gains))

# Change of a gain per m/s over `MIDDLE`. Like the values above, a guess to search from.
_SLOPES = {
    "touchdown_knee": 0.03,
    "place_ahead": -0.045,
    "thrust_ankle": -0.000836,
    "thrust_stiffness": 70.0,
    "thrust_at": -0.0415,
    "knee_rest_thrust": -0.0193,
    "knee_stiffness": -45.4,
    "pitch": 0.00669,
    "idle_knee": 0.153,
    "ready_knee": 0.0735,
    "knee_rest": 0.05,
    "mirror_ahead": 0.03,
    "side_place": 0.00922,
    "flat_ankle": 0.0118,
    "flat_stiffness": 24.0,
    "touchdown_foot": -0.00144,
    "idle_time": -0.03,
    "mirror": -0.04,
}


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """Gains over speed: `gains` at `MIDDLE`, plus a slope for some.

    Attributes:
        gains: At 3.5 m/s.
        slopes: Change per m/s, by name of the gain.
        origin: What made them: command, seed, evaluations.
        starts: Steady states to start from, by name; see `running.Running`.
    """

    gains: Gains = field(default_factory=Gains)
    slopes: Mapping[str, float] = field(default_factory=lambda: dict(_SLOPES))
    origin: Mapping[str, Any] = field(default_factory=dict)
    starts: tuple[Mapping[str, Any], ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        for name in self.slopes:
            if name not in NAMES:
                raise UnknownName("gain", name, NAMES)

    def rows(self) -> Array:
        """Values, then slopes, in the order of `NAMES`, shape (2, gains)."""
        values = [getattr(self.gains, name) for name in NAMES]
        return np.array([values, [self.slopes.get(name, 0.0) for name in NAMES]])

    def at(self, speed: float) -> Gains:
        """The gains at a speed [m/s]."""
        values, slopes = self.rows()
        return replace(
            self.gains, **dict(zip(NAMES, values + slopes * (speed - MIDDLE), strict=True))
        )

    def as_json(self) -> dict[str, Any]:
        """Plain values; `from_json` reads them."""
        return {
            "origin": dict(self.origin),
            "gains": vars(self.gains).copy(),
            "slopes": dict(self.slopes),
            "starts": [dict(start) for start in self.starts],
        }

    @classmethod
    def from_json(cls, saved: Mapping[str, Any]) -> Schedule:
        """From `as_json`'s values."""
        return cls(
            gains=Gains(**saved["gains"]),
            slopes=dict(saved["slopes"]),
            origin=dict(saved.get("origin", {})),
            starts=tuple(saved.get("starts", ())),
        )


@cache
def shipped() -> Schedule:
    """The gains that come with the package."""
    file = resources.files("understudy.athletics") / "running.json"
    return Schedule.from_json(json.loads(file.read_text(encoding="utf-8")))
