"""How a person walks or runs: footfalls, distances, forces and joint curves, cycle by cycle.

    gait = gait_of(us.read("run.bvh"))         # a clip: by the motion of its soles
    gait = gait_of(take, start=2.0)            # a take: by the force under its feet
    print(gait)

A cycle begins with a foot's touchdown and ends with its next; 0 and 100 % are touchdowns. Both legs
count, each for itself. Published human values to hold against it: `understudy.evaluate.people`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import InvalidValue, expect
from understudy.evaluate.gait_angles import ANGLES, heading, legs_apart
from understudy.evaluate.gait_body import SIDES, Mover, named, of_clip, of_measured
from understudy.evaluate.gait_cycle import Cycle, cycle_of, frames_between
from understudy.evaluate.gait_forces import StanceForce, foot_forces, stance_by_plate
from understudy.evaluate.gait_stances import (
    Stance,
    flights,
    stances_by_force,
    stances_by_motion,
)
from understudy.evaluate.measure import Measured, measured
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take


@dataclass(frozen=True, kw_only=True)
class Spread:
    """A figure over several steps or cycles.

    Attributes:
        mean: Its mean.
        sd: Standard deviation; 0 for one value.
        count: How many values.
    """

    mean: float
    sd: float
    count: int

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread | None:
        """Of some values; None of none."""
        if not len(values):
            return None
        return cls(mean=float(np.mean(values)), sd=float(np.std(values)), count=len(values))


@dataclass(frozen=True, kw_only=True, eq=False)
class Gait:
    """The gait of one person in one record.

    Attributes:
        name: Of the record.
        kind: "contact forces" or "motion of the soles": what said when a foot stood.
        mass: [kg].
        height: Stature [m].
        leg_length: Thigh and shank [m].
        stances: Stays of the feet on the ground, in order.
        cycles: Whole strides of either leg, in order.
        forces: Force over each whole stance; empty for a clip.
    """

    name: str
    kind: str
    mass: float
    height: float
    leg_length: float
    stances: tuple[Stance, ...] = field(repr=False)
    cycles: tuple[Cycle, ...] = field(repr=False)
    forces: tuple[StanceForce, ...] = field(repr=False)

    @property
    def speed(self) -> float:
        """Mean over the cycles [m/s]; 0 without any."""
        return float(np.mean([c.speed for c in self.cycles])) if self.cycles else 0.0

    @property
    def duty(self) -> float:
        """Mean share of the cycle on the ground; 0 without cycles."""
        return float(np.mean([c.duty for c in self.cycles])) if self.cycles else 0.0

    @property
    def runs(self) -> bool:
        """Whether each foot is on the ground for less than half of the time."""
        return 0.0 < self.duty < 0.5

    def curve(self, name: str) -> tuple[Array, Array]:
        """Mean and standard deviation of a curve over the cycles [rad], shape (101,) each.

        Raises:
            InvalidValue: There is no whole cycle.
        """
        if not self.cycles:
            raise InvalidValue(f"{self.name}: has no whole cycle, so no mean curve.")
        rows = np.array([c.curves[name] for c in self.cycles])
        return rows.mean(axis=0), rows.std(axis=0)

    def force(self) -> tuple[Array, Array] | None:
        """Mean upward and forward force over the stance [BW], shape (101,) each; None in a clip."""
        if not self.forces:
            return None
        return (
            np.mean([f.up for f in self.forces], axis=0),
            np.mean([f.along for f in self.forces], axis=0),
        )

    def figures(self) -> dict[str, Spread]:
        """Every figure that exists, by name; names say the unit."""
        found = {name: Spread.of(values(self)) for name, values in _FIGURES.items()}
        return {name: spread for name, spread in found.items() if spread is not None}

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes; curves in degrees and body weights."""
        force = self.force()
        return {
            "name": self.name,
            "stance_by": self.kind,
            "mass_kg": self.mass,
            "height_m": self.height,
            "leg_length_m": self.leg_length,
            "speed_m_s": self.speed if self.cycles else None,
            "runs": self.runs if self.cycles else None,
            "figures": {
                name: {"mean": s.mean, "sd": s.sd, "count": s.count}
                for name, s in self.figures().items()
            },
            "stances": [
                {"side": s.side, "start_s": s.start_s, "end_s": s.end_s, "whole": s.whole}
                for s in self.stances
            ],
            "cycles": [
                {
                    "side": c.side,
                    "start_s": c.start_s,
                    "end_s": c.end_s,
                    "stance_s": c.stance_s,
                    "speed_m_s": c.speed,
                }
                for c in self.cycles
            ],
            "curves_deg": {
                name: np.degrees(self.curve(name)[0]).round(3).tolist()
                for name in (ANGLES if self.cycles else ())
            },
            "force_up_bw": [] if force is None else force[0].round(4).tolist(),
            "force_forward_bw": [] if force is None else force[1].round(4).tolist(),
        }

    def __str__(self) -> str:
        paced = f"{len(self.cycles)} cycles at {self.speed:.2f} m/s"
        lines = [f"{self.name}: {paced if self.cycles else 'no whole cycle'}, by {self.kind}"]
        lines += [
            f"  {name:<28}{s.mean:9.3f} ± {s.sd:.3f}  ({s.count})"
            for name, s in self.figures().items()
        ]
        return "\n".join(lines)


def gait_of(
    motion: Clip | Take | Measured,
    *,
    character: int = 0,
    start: float = 0.0,
    name: str | None = None,
) -> Gait:
    """The gait in a clip, or of a character in a take.

    Args:
        motion: A clip of a person; a take; or a take measured at every step.
        character: Which of the scene's characters.
        start: Stances before this do not count [s], so that a run can get going first.
        name: What to call it; by default the clip's or the character's name.

    Raises:
        InvalidValue: No person with two legs; too short a clip; or a start that is no time in it.
    """
    if isinstance(motion, Clip):
        _check_start(start, motion.duration)
        mover = named(of_clip(motion), name)
        return _gait(mover, _late(stances_by_motion(mover), start), None)
    if not isinstance(motion, Measured):
        expect(getattr(motion, "qpos", None), np.ndarray, "motion", "a clip or a take")
        motion = measured(motion)
    _check_start(start, float(motion.times[-1]))
    mover = named(of_measured(motion, character), name)
    stances = _late(stances_by_force(motion, character), start)
    return _gait(mover, stances, (motion.times, foot_forces(motion, character)))


def _check_start(start: float, end: float) -> None:
    expect(start, (int, float, np.number), "start", "a time [s]")
    # A NaN fails the comparison too.
    if not 0.0 <= start < end:
        raise InvalidValue(f"start is {start:g} s; it must be a time from 0 to {end:g} s.")


def _late(stances: Sequence[Stance], start: float) -> tuple[Stance, ...]:
    return tuple(s for s in stances if s.start_s >= start)


def _gait(
    mover: Mover, stances: tuple[Stance, ...], plate: tuple[Array, dict[str, Array]] | None
) -> Gait:
    apart = legs_apart(mover)
    cycles = []
    for side in SIDES:
        mine = [s for s in stances if s.side == side and s.begins]
        cycles += [cycle_of(mover, a, b, stances, apart) for a, b in pairwise(mine)]
    return Gait(
        name=mover.name,
        kind="motion of the soles" if plate is None else "contact forces",
        mass=mover.mass,
        height=mover.height,
        leg_length=mover.leg_length,
        stances=stances,
        cycles=tuple(sorted(cycles, key=lambda c: c.start_s)),
        forces=() if plate is None else tuple(_forces(mover, stances, *plate)),
    )


def _forces(
    mover: Mover, stances: Sequence[Stance], times: Array, force: dict[str, Array]
) -> list[StanceForce]:
    out = []
    for stance in stances:
        frames = frames_between(mover, stance.start_s, stance.end_s)
        if stance.whole and len(mover.times[frames]) > 2:
            ahead = heading(mover, frames)[len(mover.times[frames]) // 2]
            out.append(stance_by_plate(times, force[stance.side], stance, ahead))
    return out


def _of_cycles(value: Callable[[Cycle], float | None]) -> Callable[[Gait], list[float]]:
    def values(gait: Gait) -> list[float]:
        return [v for c in gait.cycles for v in [value(c)] if v is not None]

    return values


def _degrees(value: Callable[[Cycle], float]) -> Callable[[Gait], list[float]]:
    return _of_cycles(lambda c: float(np.degrees(value(c))))


def _of_forces(value: Callable[[StanceForce], float | None]) -> Callable[[Gait], list[float]]:
    return lambda gait: [v for f in gait.forces for v in [value(f)] if v is not None]


_FIGURES: dict[str, Callable[[Gait], list[float]]] = {
    "speed_m_s": _of_cycles(lambda c: c.speed),
    "acceleration_m_s2": _of_cycles(lambda c: c.acceleration),
    "stance_s": lambda gait: [s.duration_s for s in gait.stances if s.whole],
    "flight_s": lambda gait: flights(gait.stances),
    "duty": _of_cycles(lambda c: c.duty),
    "step_rate_hz": _of_cycles(lambda c: c.step_rate),
    "step_length_m": _of_cycles(lambda c: c.step_length),
    "step_width_m": _of_cycles(lambda c: c.step_width),
    "landing_forward_m_s": _of_cycles(lambda c: c.landing[0]),
    "landing_down_m_s": _of_cycles(lambda c: -c.landing[1]),
    "com_rise_m": _of_cycles(lambda c: c.rise),
    "legs_apart_m": _of_cycles(lambda c: c.apart),
    "knee_touchdown_deg": _degrees(lambda c: c.angle("knee", 0.0)),
    "knee_stance_peak_deg": _degrees(lambda c: float(c.part("knee", 0.0, c.duty).max())),
    "knee_swing_peak_deg": _degrees(lambda c: float(c.part("knee", c.duty, 1.0).max())),
    "knee_toe_off_deg": _degrees(lambda c: c.angle("knee", c.duty)),
    "thigh_toe_off_deg": _degrees(lambda c: c.angle("thigh", c.duty)),
    "thigh_forward_peak_deg": _degrees(lambda c: float(c.curves["thigh"].max())),
    "thigh_back_peak_deg": _degrees(lambda c: float(c.curves["thigh"].min())),
    "plantarflexion_toe_off_deg": _degrees(lambda c: -c.angle("ankle", c.duty)),
    "ankle_stance_peak_deg": _degrees(lambda c: float(c.part("ankle", 0.0, c.duty).max())),
    "foot_touchdown_deg": _degrees(lambda c: c.angle("foot", 0.0)),
    "trunk_touchdown_deg": _degrees(lambda c: c.angle("trunk", 0.0)),
    "trunk_stance_peak_deg": _degrees(lambda c: float(c.part("trunk", 0.0, c.duty).max())),
    "trunk_mean_deg": _degrees(lambda c: float(c.curves["trunk"].mean())),
    "force_peak_bw": _of_forces(lambda f: f.peak),
    "force_active_bw": _of_forces(lambda f: f.active),
    "force_impact_bw": _of_forces(lambda f: f.impact),
    "force_mean_bw": _of_forces(lambda f: f.mean),
    "loading_rate_bw_s": _of_forces(lambda f: f.loading_rate),
    "braking_m_s": _of_forces(lambda f: f.braking),
    "pushing_m_s": _of_forces(lambda f: f.pushing),
}
