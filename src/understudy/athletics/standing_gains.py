"""Numbers of standing, starting and stopping: named values, as the runner's gains are.

Steps slower than `SLOW` are those of starts and stops: there the runner's gains go on with slopes
of their own. The shipped values are the output of `understudy train running --part start` and
`--part stop`, kept in `standing.json` beside this module with what made them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from understudy.athletics.gains import NAMES
from understudy.errors import InvalidValue, UnknownName
from understudy.motion.rotations import Array

# Speed [m/s] below which the runner's gains have slopes of their own.
SLOW = 2.5


@dataclass(frozen=True, kw_only=True)
class StandingGains:
    """Numbers of the laws for standing; angles [rad], times [s], lengths [m], speeds [m/s].

    Attributes:
        pull: How far the center of pressure goes past the capture point, over its way off.
        lift: Stiffness of the height over mass [1/s^2].
        sink: Its damping [1/s].
        turn: Stiffness of the pelvis' attitude [N m/rad].
        spin: Its damping [N m s/rad].
        reach: How far the capture point may be outside the soles before a step.
        straight: Height of the center of mass in standing, over that with straight legs.
        lean_time: How long the lean before a run takes to build up.
        lean_ahead: How far ahead the capture point is then sent.
        lean_aside: How far toward the foot that pushes off.
        lean_pitch: Forward lean of the pelvis at its end.
        lean_dip: How far the body sinks.
        lift_at: How far the body is ahead of the foot that bears when the other leaves the ground.
        push_at: The same when the foot that bears begins to push off.
        push: Upward acceleration of the push [m/s^2].
        push_hip: Flexion to which the free hip swings.
        push_knee: The same of its knee.
        push_time: How long that takes.
        first_speed: Desired speed of the first step.
        start_rate: Gain of the desired speed in a start [m/s^2].
        start_lead: How much further back feet are put in a start.
        start_thrust: Share by which the ankle then thrusts harder.
        start_lean: How much further the pelvis then leans.
        stop_rate: Loss of the desired speed in a stop [m/s^2].
        stop_lead: How much further ahead feet are put in a stop.
        stop_damping: Damping that knees have besides in a stop [N m s/rad].
        stop_thrust: Share by which the ankle then thrusts harder; negative.
        stop_lean: How much further the pelvis then leans; negative.
        stop_slow: Least desired speed in a stop.
        stop_speed: Speed under which a landing foot stays.
        step_time: How long a step of a stop takes.
        step_rise: How high the foot is lifted in it.
        step_apart: Least distance of the feet in standing.
        step_ahead: How far past the capture point a foot is put.
    """

    pull: float = 1.5
    lift: float = 120.0
    sink: float = 18.0
    turn: float = 900.0
    spin: float = 90.0
    reach: float = 0.02
    straight: float = 0.985
    lean_time: float = 0.35
    lean_ahead: float = 0.30
    lean_aside: float = 0.06
    lean_pitch: float = 0.25
    lean_dip: float = 0.05
    lift_at: float = 0.08
    push_at: float = 0.10
    push: float = 4.0
    push_hip: float = 1.0
    push_knee: float = 1.2
    push_time: float = 0.22
    first_speed: float = 1.4
    start_rate: float = 1.3
    start_lead: float = -0.06
    start_thrust: float = 0.0
    start_lean: float = 0.05
    stop_rate: float = 2.0
    stop_lead: float = 0.12
    stop_damping: float = 10.0
    stop_thrust: float = -0.3
    stop_lean: float = -0.1
    stop_slow: float = 1.2
    stop_speed: float = 2.1
    step_time: float = 0.28
    step_rise: float = 0.06
    step_apart: float = 0.17
    step_ahead: float = -0.06

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not np.isfinite(value):
                raise InvalidValue(f"{name} is {value}; it must be a finite number.")


STANDING_NAMES = tuple(f.name for f in fields(StandingGains))

# What the laws for standing read: the body, then the gains in this order.
BODY_NUMBERS = 9
STANDING_NUMBERS = BODY_NUMBERS + len(STANDING_NAMES)


@dataclass(frozen=True, kw_only=True)
class StandingSchedule:
    """Gains of standing, starting and stopping.

    Attributes:
        gains: Of the laws for standing.
        slow: Change of the runner's gains per m/s that the speed is below 2.5 m/s, by name; the
            slopes that they have above end there.
        origin: What made them: command, seed, evaluations.
    """

    gains: StandingGains = field(default_factory=StandingGains)
    slow: Mapping[str, float] = field(default_factory=dict)
    origin: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in self.slow:
            if name not in NAMES:
                raise UnknownName("gain", name, NAMES)

    def row(self) -> Array:
        """Slopes of slow steps in the order of the runner's gains, shape (gains,)."""
        return np.array([self.slow.get(name, 0.0) for name in NAMES])

    def as_json(self) -> dict[str, Any]:
        """Plain values; `from_json` reads them."""
        return {
            "origin": dict(self.origin),
            "gains": vars(self.gains).copy(),
            "slow": dict(self.slow),
        }

    @classmethod
    def from_json(cls, saved: Mapping[str, Any]) -> StandingSchedule:
        """From `as_json`'s values."""
        return cls(
            gains=StandingGains(**saved["gains"]),
            slow=dict(saved["slow"]),
            origin=dict(saved.get("origin", {})),
        )


@cache
def shipped_standing() -> StandingSchedule:
    """The gains of standing that come with the package."""
    file = resources.files("understudy.athletics") / "standing.json"
    return StandingSchedule.from_json(json.loads(file.read_text(encoding="utf-8")))
