"""Figure 6: hip and knee through a stride, beside people and captured runs."""

from __future__ import annotations

import numpy as np

from understudy.evaluate.gait import Gait, gait_of
from understudy.evaluate.running import Likeness, likeness
from understudy.evaluate.running_charts import phase_chart
from understudy.papers.finding import Claim, Finding
from understudy.papers.hodgins1995.runs import Captured, steady
from understudy.papers.sheets import Sheet
from understudy.simulate import simulate

SPEEDS = (2.5, 3.5, 4.5)
# Curves that correlate at least so much with people's are like them; ours.
ALIKE = 0.90


def alike(captured: tuple[Captured, ...] = (), *, quick: bool = False) -> Finding:
    """The phase plot at 3.5 m/s, and how like the curves are at three speeds."""
    seconds, first = (3.0, 1.0) if quick else (10.0, 3.0)
    runs = {}
    for speed in SPEEDS[1:2] if quick else SPEEDS:
        take = simulate(steady(speed, seconds))
        runs[speed] = likeness(gait_of(take, start=first, name=f"runner, {speed:g} m/s"))
    beside = [likeness(one.gait) for one in captured if one.gait.cycles]
    worst = {v: min(one.curves[c].correlation for c in ("hip", "knee")) for v, one in runs.items()}
    middle = runs[3.5]
    return Finding(
        figure="6",
        title="Hip and knee",
        setting="Curves are means over all cycles of both legs; people's are means of 28 runners "
        "at "
        "the same speed. A captured skeleton has offsets of its own, so curves are compared by "
        "their "
        "correlation.",
        claims=(
            Claim(
                said="The simulated motion is qualitatively similar to the measured data.",
                measured="correlation over the cycle, hip and knee: "
                + "; ".join(
                    f"{v:g} m/s {one.curves['hip'].correlation:.2f}, "
                    f"{one.curves['knee'].correlation:.2f}"
                    for v, one in runs.items()
                )
                + f" (bound of ours: {ALIKE:g})",
                holds=min(worst.values()) >= ALIKE,
            ),
            _repeats(middle.gait, [one.gait for one in captured]),
        ),
        charts=(phase_chart([middle, *beside[:3]]),),
        sheets=(_sheet(list(runs.values()), beside, middle.gait, captured),),
        facts={
            f"correlation_{joint}_{v:g}": one.curves[joint].correlation
            for v, one in runs.items()
            for joint in ("hip", "knee")
        },
    )


def _repeats(gait: Gait, others: list[Gait]) -> Claim:
    """How much the duration of strides varies."""
    mine, theirs = _variation(gait), [v for g in others for v in [_variation(g)] if v is not None]
    measured = f"strides vary by {100 * (mine or 0.0):.1f} % in duration"
    if theirs:
        measured += f", those of captured runs by {100 * max(theirs):.1f} %"
    return Claim(
        said="The cyclic motion of the runner is repetitive.",
        measured=measured,
        holds=mine is not None and mine < 0.02,
    )


def _variation(gait: Gait) -> float | None:
    """Standard deviation of the strides' duration over its mean; None of a single stride."""
    lasted = [c.end_s - c.start_s for c in gait.cycles]
    return float(np.std(lasted) / np.mean(lasted)) if len(lasted) > 1 else None


def _sheet(
    runs: list[Likeness], beside: list[Likeness], middle: Gait, captured: tuple[Captured, ...]
) -> Sheet:
    rows = []
    for one in (*runs, *beside):
        hip, knee = one.curves["hip"], one.curves["knee"]
        mine = [_correlated(middle, one.gait, joint) for joint in ("hip", "knee")]
        rows.append(
            (
                *(one.gait.name, one.gait.speed, hip.correlation, hip.rms_deg),
                *(knee.correlation, knee.rms_deg, *mine),
            )
        )
    return Sheet(
        name="Figure 6",
        caption="Curves against people's at the same speed, and against the runner's at 3.5 m/s.",
        head=(
            *("run", "speed [m/s]", "hip, correlation", "hip, rms [deg]", "knee, correlation"),
            *("knee, rms [deg]", "hip with the runner's", "knee with the runner's"),
        ),
        rows=tuple(rows),
        notes=() if captured else ("No folder of captured runs was given.",),
    )


def _correlated(a: Gait, b: Gait, joint: str) -> float:
    return float(np.corrcoef(a.curve(joint)[0][:-1], b.curve(joint)[0][:-1])[0, 1])
