"""Figure 8, the bow: legs that were never captured keep the balance."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import mujoco
import numpy as np

from understudy.character import Character, retargeted
from understudy.character.bodies import adult_man
from understudy.character.footing import SIDES, sole_of
from understudy.control import Balance, Push
from understudy.evaluate import score
from understudy.evaluate.chart import Chart, Series
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.motion.samples.bowing import HELD, bow, trunk_tilt
from understudy.papers.filmstrip import Film
from understudy.papers.finding import Claim, Finding, Strip
from understudy.papers.sheets import Sheet
from understudy.performance import Performance, tracked
from understudy.simulate import simulate, simulate_many
from understudy.take import Take

ANGLES = (60.0, 80.0, 100.0)
# A push of 200 N for 0.1 s on the chest, and when: standing and in the bow [s].
PUSH, STANDING, BOWED = 20.0, 0.3, 3.6
WAYS = {
    "ahead": (1.0, 0.0),
    "back": (-1.0, 0.0),
    "to the left": (0.0, 1.0),
    "to the right": (0.0, -1.0),
}
# Watched this long after a push [s].
AFTER = 2.5
# Fallen: the pelvis is below this part of its height in the clip.
FALLEN = 0.75
# Goal: the center of mass this near to the middle of the feet, in the held bow [m].
NEAR = 0.040


@dataclass(frozen=True, kw_only=True)
class Bow:
    """A bow, simulated.

    Attributes:
        degrees: Of the clip.
        push: Its direction, or "".
        pushed: When it begins [s].
        balanced: Whether the task is at work.
        take: What happened.
    """

    degrees: float
    push: str = ""
    pushed: float = 0.0
    balanced: bool = True
    take: Take = field(repr=False)

    @property
    def fell(self) -> float | None:
        """When it fell [s], or None."""
        return fell(self.take)


def performed(body: Character, clip: Clip, *, balanced: bool = True) -> Performance:
    """A bow without legs by a body with legs that nothing else holds."""
    return tracked(clip, body, tasks=[Balance()] if balanced else [], pelvis="free")


def pushed(performance: Performance, way: str, time: float) -> Performance:
    """The same with a push, up to some time after it."""
    x, y = WAYS[way]
    push = Push(time=time, on="chest", impulse=(PUSH * x, PUSH * y, 0.0))
    return replace(
        performance,
        controllers=(*performance.controllers, push),
        duration=min(time + AFTER, performance.duration),
    )


def off_center(take: Take, *, rate: float = 120.0) -> tuple[Array, Array]:
    """Distance over the ground from the center of mass to the middle of the feet.

    Returns:
        Times [s] and distances [m], both (frames,).
    """
    body, part = take.scene.characters[0], take.scene.parts[0]
    every, data = take.stride(rate), mujoco.MjData(take.model)
    soles = [(part.bodies[body.index(f"{s}_ankle")], sole_of(body, s).middle) for s in SIDES]
    away = []
    for state in take.qpos[::every]:
        data.qpos[:] = state
        mujoco.mj_kinematics(take.model, data)
        mujoco.mj_comPos(take.model, data)
        feet = [data.xpos[b] + rot.rotate(data.xquat[b], middle) for b, middle in soles]
        away.append(data.subtree_com[part.bodies[0]] - np.mean(feet, axis=0))
    return take.times[::every], np.linalg.norm(np.array(away)[:, :2], axis=1)


def fell(take: Take) -> float | None:
    """When the pelvis came too low [s], or None."""
    reference = take.references[0]
    assert reference is not None
    height = take.qpos[:, take.scene.parts[0].qpos.start + 2]
    frames = np.minimum(np.round(take.times * reference.rate).astype(int), reference.frames - 1)
    low = np.flatnonzero(height < FALLEN * reference.root_positions[frames, 2])
    return float(take.times[low[0]]) if len(low) else None


def bowing(*, quick: bool = False) -> Finding:
    """Bows of three depths, with the controller and without, and pushed from four sides."""
    body, trunk = adult_man(), adult_man(plan="upper")
    angles = ANGLES[:1] if quick else ANGLES
    clips = {degrees: retargeted(bow(degrees), trunk) for degrees in angles}
    if quick:
        clips = {degrees: clip.trimmed(0.0, BOWED + 0.9) for degrees, clip in clips.items()}
    plain = {degrees: performed(body, clip) for degrees, clip in clips.items()}
    first, ways = angles[0], list(WAYS)[:1] if quick else list(WAYS)
    asked: list[tuple[float, str, float, bool]] = [(degrees, "", 0.0, True) for degrees in angles]
    runs = list(plain.values())
    for degrees, way, time in (
        *((degrees, way, BOWED) for degrees in angles for way in ways),
        *((first, way, STANDING) for way in ways if not quick),
    ):
        asked.append((degrees, way, time, True))
        runs.append(pushed(plain[degrees], way, time))
    asked.append((first, "", 0.0, False))
    runs.append(performed(body, clips[first], balanced=False))
    made = [*simulate_many(runs[:-1]), simulate(runs[-1])]
    bows = []
    for (degrees, push, time, balanced), take in zip(asked, made, strict=True):
        if isinstance(take, Exception):
            raise take
        bows.append(Bow(degrees=degrees, push=push, pushed=time, balanced=balanced, take=take))
    return _finding(bows)


def _row(one: Bow) -> tuple[object, ...]:
    times, away = off_center(one.take)
    where = "" if not one.push else "in the bow" if one.pushed == BOWED else "standing"
    held = (times >= HELD[0]) & (times <= HELD[1])
    tilt: tuple[float | None, ...] = (None, None, None)
    if not one.push and one.balanced:
        tilts = trunk_tilt(one.take.clip(rate=120.0))[held]
        tilt = (float(tilts.mean()), float(np.ptp(tilts)), 1e3 * float(away[held].max()))
    return (
        one.degrees,
        "balanced" if one.balanced else "servos alone",
        f"{one.push}, {where}" if one.push else "none",
        *tilt,
        1e3 * float(away.max()) if one.fell is None else None,
        None if one.push else score(one.take).root_force_peak_percent,
        one.fell is None,
        one.fell,
    )


def _finding(bows: list[Bow]) -> Finding:
    rows = [_row(one) for one in bows]
    plain = [(one, row) for one, row in zip(bows, rows, strict=True) if not one.push]
    held = [(one, row) for one, row in plain if one.balanced]
    alone = next(one for one in bows if not one.balanced)
    hit = [one for one in bows if one.push]
    kept = sum(one.fell is None for one in hit)
    off = max(float(str(row[5])) for _, row in held)
    tilts = ", ".join(f"{row[3]:.1f}" for _, row in held)
    force = max(float(str(row[7])) for _, row in plain)
    down = alone.fell
    return Finding(
        figure="8, bow",
        title="The bow",
        setting="sample:bow by a man of 1.78 m and 75 kg: the trunk, head and arms of the clip "
        "alone, the legs by the balance controller at hips, knees and ankles. Nothing else holds "
        f"the body up. Pushes are {PUSH:g} N s: 200 N for 0.1 s on the chest.",
        claims=(
            Claim(
                said="Captured motion drives the upper body; the lower body was not captured.",
                measured=f"bows of {', '.join(f'{one.degrees:g}' for one, _ in held)} degrees held "
                f"at {tilts}; largest force from outside {force:.2f} % of weight",
                holds=force == 0.0
                and all(abs(float(str(row[3])) - one.degrees) < 3.0 for one, row in held),
            ),
            Claim(
                said="The controller holds the center of mass over the feet.",
                measured=f"at most {off:.0f} mm from the middle of the feet while the bow is "
                f"held (goal: {1e3 * NEAR:.0f} mm)",
                holds=off <= 1e3 * NEAR,
            ),
            Claim(
                said="(Goal of our own: pushes are survived, and without the controller it falls.)",
                measured=f"{kept} of {len(hit)} pushes survived; with the legs' servos alone "
                + (f"it falls at {down:.1f} s" if down is not None else "it stands"),
                holds=kept == len(hit) and down is not None,
            ),
        ),
        charts=(_chart(held, alone),),
        strips=(_strip(held, alone),),
        sheets=(
            Sheet(
                name="Figure 8 bow",
                caption=f"Bows, held from {HELD[0]:g} to {HELD[1]:g} s. Tilt: the line from the "
                "pelvis to the neck from the vertical.",
                head=(
                    "bow [deg]",
                    "legs",
                    "push",
                    "held tilt [deg]",
                    "its range [deg]",
                    "center of mass off, held [mm]",
                    "ever [mm]",
                    "outside force, peak [% of weight]",
                    "stands",
                    "falls at [s]",
                ),
                rows=tuple(rows),
            ),
        ),
        facts={
            "bow_off_center_mm": off,
            "bow_pushes_survived": kept,
            "bow_pushes": len(hit),
            "bow_falls_without_s": down,
        },
    )


def _chart(held: list[tuple[Bow, tuple[object, ...]]], alone: Bow) -> Chart:
    series = []
    for name, one in (
        *((f"{one.degrees:g} degrees", one) for one, _ in held),
        (f"{alone.degrees:g} degrees, servos alone", alone),
    ):
        times, away = off_center(one.take)
        # What has fallen is off the chart.
        shown = np.where(away < 0.12, away, np.nan)
        series.append(Series(name=name, x=times, y=1e3 * shown))
    return Chart(
        title="Figure 8, bow: center of mass",
        caption="Distance over the ground from the middle of the feet; what falls leaves the "
        "chart at 120 mm.",
        x_label="Time [s]",
        y_label="Distance [mm]",
        series=tuple(series),
    )


def _strip(held: list[tuple[Bow, tuple[object, ...]]], alone: Bow) -> Strip:
    last = held[0][0].take.duration
    times = tuple(t for t in (0.5, 1.8, 2.4, 3.0, 4.3, 6.0, 6.8, 8.5) if t <= last)
    films = [
        Film(title=f"{one.degrees:g} degrees", thing=one.take, times=times, view="side")
        for one, _ in held
    ]
    down = alone.fell or 3.0
    last = alone.take.duration
    late = tuple(min(down + d, last) for d in (-1.5, -1.0, -0.6, -0.3, 0.0, 0.3))
    late = tuple(max(0.0, t) for t in late)
    films.append(
        Film(title="the legs' servos alone, no balance", thing=alone.take, times=late, view="side")
    )
    return Strip(
        alt="A man bows by 60, 80 and 100 degrees; without control he falls.", films=tuple(films)
    )
