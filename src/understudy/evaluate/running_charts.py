"""Charts of a gait beside people and other gaits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.evaluate.chart import Chart, Series
from understudy.evaluate.gait_cycle import PHASE
from understudy.evaluate.running import CURVES, Likeness


def running_charts(found: Sequence[Likeness]) -> tuple[Chart, ...]:
    """Curves over the cycle, the phase plot of hip and knee, rise and ground force."""
    curves = [
        _curve_chart(name, found) for name in CURVES if name in ("hip", "knee", "ankle", "trunk")
    ]
    more = [_curve_chart(name, found) for name in ("thigh", "foot", "pelvis")]
    forces = [chart for chart in (_force_chart(found, 0), _force_chart(found, 1)) if chart]
    return (phase_chart(found), *curves, _rise_chart(found), *forces, *more)


def _placed(lines: Sequence[Series], people: Series | None) -> tuple[Series, ...]:
    """The lines of all gaits with people's second, so that each has one color in every chart."""
    nobody = Series(name="people: none published", x=np.zeros(1), y=np.full(1, np.nan))
    return (lines[0], people or nobody, *lines[1:])


def _called(found: Likeness) -> str:
    return f"people at {found.people.speed:.1f} m/s"


def _curve_chart(name: str, found: Sequence[Likeness]) -> Chart:
    title, caption = CURVES[name]
    share, first = 100.0 * PHASE, found[0]
    lines = [
        Series(name=one.gait.name, x=share, y=np.degrees(one.gait.curve(name)[0])) for one in found
    ]
    theirs = None
    if name in first.people.curves:
        curve = np.degrees(first.people.curves[name])
        theirs = Series(name=_called(first), x=share, y=curve)
    return Chart(
        title=title,
        caption=f"{caption} Mean over the cycles of both legs.",
        x_label="Share of the cycle, from touchdown to touchdown [%]",
        y_label="Angle [deg]",
        series=_placed(lines, theirs),
    )


def phase_chart(found: Sequence[Likeness]) -> Chart:
    """Knee over hip angle, a loop per gait: figure 6 of Hodgins et al. 1995."""
    hip, knee = (np.degrees(found[0].people.curves[joint]) for joint in ("hip", "knee"))
    lines = [
        Series(
            name=one.gait.name,
            x=np.degrees(one.gait.curve("hip")[0]),
            y=np.degrees(one.gait.curve("knee")[0]),
        )
        for one in found
    ]
    return Chart(
        title="Hip and knee",
        caption="Knee flexion over hip flexion through one cycle: the phase plot of figure 6 in "
        "Hodgins et al. 1995.",
        x_label="Hip flexion [deg]",
        y_label="Knee flexion [deg]",
        series=_placed(lines, Series(name=_called(found[0]), x=hip, y=knee)),
    )


def _rise_chart(found: Sequence[Likeness]) -> Chart:
    lines = [
        Series(
            name=one.gait.name,
            x=100.0 * PHASE,
            y=1e3 * np.mean([c.height for c in one.gait.cycles], axis=0),
        )
        for one in found
    ]
    return Chart(
        title="Height of the center of mass",
        caption="Over its mean in the cycle, drift taken out.",
        x_label="Share of the cycle, from touchdown to touchdown [%]",
        y_label="Height [mm]",
        series=_placed(lines, None),
    )


def _force_chart(found: Sequence[Likeness], which: int) -> Chart | None:
    """Upward (0) or forward (1) force over the stance; None where no gait has forces."""
    lines = []
    for one in found:
        force = one.gait.force()
        if force is not None:
            lines.append(Series(name=one.gait.name, x=100.0 * PHASE, y=force[which]))
    if not lines:
        return None
    theirs = None
    caption = "Of the ground on one foot, mean over the stances, filtered as a force plate's."
    if which == 0:
        mean = found[0].people.figures["force_mean_bw"].mean
        half = 0.5 * np.pi * mean * np.sin(np.pi * PHASE)
        theirs = Series(name="half sine of people's mean force", x=100.0 * PHASE, y=half)
    return Chart(
        title="Upward force" if which == 0 else "Force along the way",
        caption=caption if which == 0 else f"{caption} Braking is negative.",
        x_label="Share of the stance [%]",
        y_label="Force [body weights]",
        series=_placed(lines, theirs),
        decimals=2,
    )
