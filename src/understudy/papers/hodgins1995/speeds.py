"""Speeds of 2.5 to 5 m/s, and what happens when speed or direction change abruptly."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from understudy.athletics.course import Course
from understudy.evaluate.chart import Chart, Series
from understudy.evaluate.people import people
from understudy.papers.finding import Claim, Finding
from understudy.papers.hodgins1995 import published as paper
from understudy.papers.hodgins1995.runs import Captured, seen, steady
from understudy.papers.sheets import Sheet
from understudy.performance import running
from understudy.simulate import simulate

SPEEDS = (2.5, 3.0, 3.5, 4.0, 4.5, 5.0)
# Mean speed this near to the one asked for; ours.
NEAR = 0.03
# Sudden changes: of the heading [deg], of the speed [m/s].
TURNS, JUMPS = (15.0, 30.0, 60.0, 90.0), (0.5, 1.0, 1.5)


def speeds(captured: tuple[Captured, ...] = (), *, quick: bool = False) -> Finding:
    """Every half meter per second."""
    seconds = 6.0 if quick else 60.0
    asked = SPEEDS[::5] if quick else SPEEDS
    found = {v: seen(steady(v, seconds)) for v in asked}
    stood = [v for v, one in found.items() if not one["fell"]]
    off = {v: found[v]["mean_speed"] / v - 1.0 for v in stood}
    ramp = _ramp(quick)
    rows = [_row(v, one) for v, one in found.items()]
    take = simulate(steady(3.5, 5.0))
    real = take.duration / float(take.facts["cpu_seconds"])
    low, high = paper.SPEEDS
    return Finding(
        figure="speeds",
        title="From 2.5 to 5 m/s",
        setting=f"A man, {seconds:g} s at each speed from a steady state kept with the gains; "
        "one set "
        "of gains for all speeds. Friction 1.",
        claims=(
            Claim(
                said=f"The runner can run at speeds between {low:g} and {high:g} m/s.",
                measured=f"{len(stood)} of {len(asked)} speeds run {seconds:g} s without a fall; "
                "mean "
                "speed off by at most "
                + (f"{100 * max(map(abs, off.values())):.1f} %" if off else "-"),
                holds=len(stood) == len(asked) and max(map(abs, off.values())) <= NEAR,
            ),
            Claim(
                said="The user changes the desired velocity while he runs.",
                measured=f"{low:g} to {high:g} to {low:g} m/s in {ramp['whole']:.0f} s: "
                + (f"falls after {ramp['time']:.1f} s" if ramp["fell"] else "no fall"),
                holds=not ramp["fell"],
            ),
            Claim(
                said="A three-dimensional human simulation will run in real time within a few "
                "years; "
                f"the paper's bicyclist took {paper.SLOWER:g} times as long.",
                measured=f"{real:.0f} times faster than real time on one core",
                holds=real > 1.0,
            ),
        ),
        charts=(_chart(found, captured),),
        sheets=(
            Sheet(
                name="Speeds",
                caption="Steady running; what people do in brackets (Fukuchi et al. 2017).",
                head=(
                    *("asked [m/s]", "falls at [s]", "mean [m/s]", "stance [s]", "people [s]"),
                    *("flight [s]", "people [s]", "steps [1/s]", "people [1/s]", "peak [BW]"),
                ),
                rows=tuple(rows),
            ),
        ),
        facts={"real_time": real, "speeds_without_a_fall": len(stood)},
    )


def _ramp(quick: bool) -> dict[str, float]:
    """Slow, fast and slow again."""
    low, high = paper.SPEEDS
    whole = 6.0 if quick else 20.0
    course = Course(
        times=np.array([0.0, 0.4, 0.6, 1.0]) * whole,
        speeds=np.array([low, high if not quick else 3.5, high if not quick else 3.5, low]),
        headings=np.zeros(4),
    )
    return seen(running(course=course, duration=whole)) | {"whole": whole}


def _row(speed: float, one: dict[str, float]) -> tuple[Any, ...]:
    them = people(speed).figures
    period, stance = one["mean_period"], one["mean_stance"]
    return (
        *(speed, one["time"] if one["fell"] else None, one["mean_speed"]),
        *(stance, them["stance_s"].mean, period - stance, them["flight_s"].mean),
        *(1.0 / period if period else math.nan, them["step_rate_hz"].mean, one["mean_peak"]),
    )


def _chart(found: dict[float, dict[str, float]], captured: tuple[Captured, ...]) -> Chart:
    asked = np.array(list(found))
    stance = np.array([one["mean_stance"] for one in found.values()])
    flight = np.array([one["mean_period"] for one in found.values()]) - stance
    line = np.linspace(*paper.SPEEDS, 26)
    them = [people(v).figures for v in line]
    lines = [
        Series(name="stance, simulated", x=asked, y=1e3 * stance),
        Series(name="flight, simulated", x=asked, y=1e3 * flight),
        Series(name="stance, people", x=line, y=[1e3 * f["stance_s"].mean for f in them]),  # type: ignore[arg-type]
        Series(name="flight, people", x=line, y=[1e3 * f["flight_s"].mean for f in them]),  # type: ignore[arg-type]
    ]
    for what in ("stance", "flight") if captured else ():
        order = sorted(captured, key=lambda one: one.gait.speed)
        values = [one.gait.figures().get(f"{what}_s") for one in order]
        known = [(o.gait.speed, 1e3 * v.mean) for o, v in zip(order, values, strict=True) if v]
        x, y = np.array(known).reshape(-1, 2).T
        lines.append(Series(name=f"{what}, captured", x=x, y=y))
    return Chart(
        title="Stance and flight over speed",
        caption="People: means of 28 runners on a treadmill, carried on in a straight line over "
        "4.5 m/s.",
        x_label="Speed [m/s]",
        y_label="Time [ms]",
        series=tuple(lines),
        decimals=0,
    )


def abrupt(*, quick: bool = False) -> Finding:
    """Sudden turns and jumps of the speed, beside the same ones made gently."""
    rows = []
    for angle in TURNS[-1:] if quick else TURNS:
        rows.append(("heading", angle, *(_changed(angle, 0.0, sudden) for sudden in (True, False))))
    for jump in JUMPS[-1:] if quick else JUMPS:
        rows.append(("speed", jump, *(_changed(0.0, jump, sudden) for sudden in (True, False))))
    fell = [f"{row[1]:g} {'degrees' if row[0] == 'heading' else 'm/s'}" for row in rows if row[2]]
    gentle = sum(row[3] is None for row in rows)
    return Finding(
        figure="changes",
        title="Abrupt changes",
        setting="A man at 3.5 m/s for 8 s; after 2 s another heading or speed is asked for, at "
        "once or "
        "at the rates to which a course keeps by itself.",
        claims=(
            Claim(
                said="He changes speed and direction, but abrupt changes make him fall.",
                measured=f"at once: falls over {', '.join(fell) or 'none of them'}; gently: "
                f"{gentle} of {len(rows)} without a fall",
                holds=bool(fell) and gentle == len(rows),
            ),
        ),
        sheets=(
            Sheet(
                name="Changes",
                caption="When he falls [s], empty if he does not.",
                head=("change of", "by [deg, m/s]", "at once", "gently"),
                rows=tuple(rows),
            ),
        ),
    )


def _changed(angle: float, jump: float, sudden: bool) -> float | None:
    """When a runner falls who is asked to turn [deg] or to be faster [m/s]; None if he does not."""
    course = Course(
        times=np.array([0.0, 2.0, 2.001]),
        speeds=np.array([3.5, 3.5, 3.5 + jump]),
        headings=np.radians([0.0, 0.0, angle]),
    )
    if sudden:
        course = replace(course, acceleration=1e3, turning=1e3, bending=1e6)
    found = seen(running(course=course, duration=8.0))
    return found["time"] if found["fell"] else None
