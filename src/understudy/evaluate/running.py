"""A gait against people: how like the curves are, how far off each figure, and the charts of it.

In come gaits (`understudy.evaluate.gait`), out go a `Likeness` for each and the pieces of a page:
tables, charts, and plain values for JSON.
"""

from __future__ import annotations

import html as markup
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from understudy.errors import InvalidValue
from understudy.evaluate.chart import Chart, Series
from understudy.evaluate.gait import PHASE, Gait
from understudy.evaluate.people import USABLE, Human, People, people
from understudy.evaluate.tables import table
from understudy.motion.rotations import Array

MOST_BESIDE = 3
"""As many gaits beside the first as lines can be told apart from it and from people."""


@dataclass(frozen=True, kw_only=True)
class CurveMatch:
    """One curve against people's.

    Attributes:
        name: Such as "knee".
        correlation: Over the 101 shares of the cycle.
        rms_deg: Root mean square difference.
        offset_deg: Mean difference, positive where the gait's angle is larger.
        range_deg: Largest less least angle of the gait.
        people_range_deg: The same of people.
    """

    name: str
    correlation: float
    rms_deg: float
    offset_deg: float
    range_deg: float
    people_range_deg: float

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes."""
        return dict(vars(self))


@dataclass(frozen=True, kw_only=True)
class FigureMatch:
    """One figure against people's.

    Attributes:
        name: As in `Gait.figures`.
        value: The gait's mean.
        people: What is published.
    """

    name: str
    value: float
    people: Human

    @property
    def difference(self) -> float:
        """The gait's value less people's mean."""
        return self.value - self.people.mean

    @property
    def inside(self) -> bool | None:
        """Whether it lies within people's range; None where no range is published."""
        return self.people.holds(self.value)

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes."""
        return {
            "name": self.name,
            "value": self.value,
            "people": self.people.mean,
            "low": self.people.low,
            "high": self.people.high,
            "difference": self.difference,
            "inside": self.inside,
            "source": self.people.source,
            "known": self.people.known,
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Likeness:
    """A gait beside people at the same speed.

    Attributes:
        gait: What was measured.
        people: Published values at its speed.
        curves: By name.
        figures: By name.
    """

    gait: Gait
    people: People
    curves: dict[str, CurveMatch] = field(repr=False)
    figures: dict[str, FigureMatch] = field(repr=False)

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes."""
        return {
            "gait": self.gait.as_dict(),
            "people": self.people.as_dict(),
            "curves": [match.as_dict() for match in self.curves.values()],
            "figures": [match.as_dict() for match in self.figures.values()],
        }


def likeness(gait: Gait, *, speed: float | None = None) -> Likeness:
    """A gait beside people.

    Args:
        gait: With at least one whole cycle.
        speed: Speed of the people [m/s]; by default the gait's.

    Raises:
        InvalidValue: No whole cycle, or a speed at which people's running is not known.
    """
    wanted = gait.speed if speed is None else speed
    if gait.cycles and speed is None and not USABLE[0] <= wanted <= USABLE[1]:
        raise InvalidValue(
            f"{gait.name}: moves at {wanted:.2f} m/s; people's running is known from {USABLE[0]:g} "
            f"to {USABLE[1]:g} m/s. Give the speed to compare with."
        )
    found = {name: np.degrees(gait.curve(name)[0]) for name in _CURVES}
    others = people(wanted)
    return Likeness(
        gait=gait,
        people=others,
        curves={
            name: matched(name, found[name], np.degrees(curve))
            for name, curve in others.curves.items()
        },
        figures={
            name: FigureMatch(name=name, value=spread.mean, people=others.figures[name])
            for name, spread in gait.figures().items()
            if name in others.figures
        },
    )


def matched(name: str, mine: Array, theirs: Array) -> CurveMatch:
    """Two curves over the cycle [deg], shape (101,) each; the last value repeats the first."""
    a, b = mine[:-1], theirs[:-1]
    moving = min(np.ptp(a), np.ptp(b)) > 1e-9
    return CurveMatch(
        name=name,
        correlation=float(np.corrcoef(a, b)[0, 1]) if moving else 0.0,
        rms_deg=float(np.sqrt(np.mean((a - b) ** 2))),
        offset_deg=float(np.mean(a - b)),
        range_deg=float(np.ptp(a)),
        people_range_deg=float(np.ptp(b)),
    )


# Title, and how the curve is defined.
_CURVES = {
    "hip": ("Hip flexion", "Thigh against pelvis; zero standing, flexion positive."),
    "thigh": ("Thigh", "Line from hip to knee, forward of straight down."),
    "knee": ("Knee flexion", "Between thigh and shank; zero is straight."),
    "ankle": ("Ankle dorsiflexion", "Foot against shank; zero standing, toes up positive."),
    "foot": ("Foot, toe up", "Attitude of the foot; zero is flat."),
    "pelvis": ("Pelvis, anterior tilt", "Zero standing, forward positive."),
    "trunk": ("Trunk lean", "Line from the hips to the neck, forward of standing."),
}
# Title, unit, factor from the figure's own unit, digits.
_ROWS: dict[str, tuple[str, str, float, int]] = {
    "speed_m_s": ("Speed", "m/s", 1.0, 2),
    "stance_s": ("Stance", "ms", 1e3, 0),
    "flight_s": ("Flight", "ms", 1e3, 0),
    "duty": ("Duty factor", "%", 100.0, 1),
    "step_rate_hz": ("Step rate", "Hz", 1.0, 2),
    "step_length_m": ("Step length", "m", 1.0, 2),
    "step_width_m": ("Step width", "mm", 1e3, 0),
    "com_rise_m": ("Rise of the center of mass", "mm", 1e3, 0),
    "legs_apart_m": ("Lower legs apart, least", "mm", 1e3, 0),
    "knee_touchdown_deg": ("Knee at touchdown", "°", 1.0, 0),
    "knee_stance_peak_deg": ("Knee, most in stance", "°", 1.0, 0),
    "knee_toe_off_deg": ("Knee at toe-off", "°", 1.0, 0),
    "knee_swing_peak_deg": ("Knee, most in swing", "°", 1.0, 0),
    "thigh_toe_off_deg": ("Thigh at toe-off", "°", 1.0, 0),
    "thigh_forward_peak_deg": ("Thigh, most forward", "°", 1.0, 0),
    "thigh_back_peak_deg": ("Thigh, furthest back", "°", 1.0, 0),
    "plantarflexion_toe_off_deg": ("Plantarflexion at toe-off", "°", 1.0, 0),
    "ankle_stance_peak_deg": ("Ankle, most dorsiflexed in stance", "°", 1.0, 0),
    "foot_touchdown_deg": ("Foot at touchdown, toe up", "°", 1.0, 0),
    "trunk_touchdown_deg": ("Trunk lean at touchdown", "°", 1.0, 0),
    "trunk_stance_peak_deg": ("Trunk lean, most in stance", "°", 1.0, 0),
    "trunk_mean_deg": ("Trunk lean, mean", "°", 1.0, 0),
    "force_peak_bw": ("Force, largest", "BW", 1.0, 2),
    "force_active_bw": ("Force, largest after the first quarter", "BW", 1.0, 2),
    "force_impact_bw": ("Force, impact peak", "BW", 1.0, 2),
    "force_mean_bw": ("Force, mean in stance", "BW", 1.0, 2),
    "loading_rate_bw_s": ("Loading rate", "BW/s", 1.0, 0),
    "braking_m_s": ("Braking impulse over mass", "m/s", 1.0, 2),
    "pushing_m_s": ("Pushing impulse over mass", "m/s", 1.0, 2),
}


def figures_table(found: Sequence[Likeness]) -> str:
    """Every figure of every gait, each beside people at its own speed, as HTML."""
    head = ["Figure"]
    for one in found:
        head += [one.gait.name, f"people at {one.people.speed:.1f} m/s"]
    measures = [one.gait.figures() for one in found]
    rows = []
    for name, (title, unit, factor, digits) in _ROWS.items():
        if not any(name in figures for figures in measures):
            continue
        cells = [f"{title} [{unit}]"]
        for one, figures in zip(found, measures, strict=True):
            spread, human = figures.get(name), one.people.figures.get(name)
            cells.append("-" if spread is None else _mean(spread.mean, spread.sd, factor, digits))
            cells.append("-" if human is None else _usual(human, factor, digits))
        rows.append(cells)
    return table("Figures, mean ± standard deviation; people with their usual range", head, rows)


def _mean(mean: float, sd: float, factor: float, digits: int) -> str:
    return f"{factor * mean:.{digits}f} ± {factor * sd:.{digits}f}"


def _usual(human: Human, factor: float, digits: int) -> str:
    text = f"{factor * human.mean:.{digits}f}"
    if human.low is not None and human.high is not None:
        text += f" ({factor * human.low:.{digits}f} to {factor * human.high:.{digits}f})"
    return text


def curves_table(found: Sequence[Likeness]) -> str:
    """How like people's the curves of every gait are, as HTML."""
    head = ["Curve"]
    for one in found:
        head += [
            f"{one.gait.name}: correlation",
            "rms [°]",
            "mean off [°]",
            "range [°]",
            "people's",
        ]
    rows = []
    for name in found[0].curves:
        cells = [_CURVES[name][0]]
        for one in found:
            m = one.curves[name]
            cells += [f"{m.correlation:.3f}", f"{m.rms_deg:.1f}", f"{m.offset_deg:+.1f}"]
            cells += [f"{m.range_deg:.0f}", f"{m.people_range_deg:.0f}"]
        rows.append(cells)
    return table("Angle curves against people's at the same speed", head, rows)


def sources_list(found: Sequence[Likeness]) -> str:
    """Where people's values come from, as an HTML list."""
    rows: dict[str, list[str]] = {f"{found[0].people.curve_source}": ["angle curves"]}
    for one in found:
        for name, human in one.people.figures.items():
            at = "" if human.at_speed is None else f"; known at {human.at_speed:g} m/s only"
            title = _ROWS[name][0].lower()
            titles = rows.setdefault(f"{human.source}; {human.known}{at}", [])
            if title not in titles:
                titles.append(title)
    items = "".join(
        f"<li>{markup.escape(', '.join(what))}: {markup.escape(source)}.</li>"
        for source, what in rows.items()
    )
    return f"<ul>{items}</ul>"


def running_charts(found: Sequence[Likeness]) -> tuple[Chart, ...]:
    """Curves over the cycle, the phase plot of hip and knee, rise and ground force."""
    curves = [
        _curve_chart(name, found) for name in _CURVES if name in ("hip", "knee", "ankle", "trunk")
    ]
    more = [_curve_chart(name, found) for name in ("thigh", "foot", "pelvis")]
    forces = [chart for chart in (_force_chart(found, 0), _force_chart(found, 1)) if chart]
    return (phase_chart(found), *curves, _rise_chart(found), *forces, *more)


def _lines(found: Sequence[Likeness], name: str) -> list[Series]:
    first, *rest = found
    share = 100.0 * PHASE
    lines = [Series(name=first.gait.name, x=share, y=np.degrees(first.gait.curve(name)[0]))]
    if name in first.people.curves:
        theirs = np.degrees(first.people.curves[name])
        lines.append(Series(name=f"people at {first.people.speed:.1f} m/s", x=share, y=theirs))
    lines += [Series(name=o.gait.name, x=share, y=np.degrees(o.gait.curve(name)[0])) for o in rest]
    return lines


def _curve_chart(name: str, found: Sequence[Likeness]) -> Chart:
    title, caption = _CURVES[name]
    return Chart(
        title=title,
        caption=f"{caption} Mean over the cycles of both legs.",
        x_label="Share of the cycle, from touchdown to touchdown [%]",
        y_label="Angle [deg]",
        series=tuple(_lines(found, name)),
    )


def phase_chart(found: Sequence[Likeness]) -> Chart:
    """Knee over hip angle, a loop per gait: figure 6 of Hodgins et al. 1995."""
    first, *rest = found
    theirs = f"people at {first.people.speed:.1f} m/s"
    loops = [(first.gait.name, first.gait), (theirs, None), *((o.gait.name, o.gait) for o in rest)]
    lines = []
    for name, gait in loops:
        hip, knee = (
            first.people.curves[joint] if gait is None else gait.curve(joint)[0]
            for joint in ("hip", "knee")
        )
        lines.append(Series(name=name, x=np.degrees(hip), y=np.degrees(knee)))
    return Chart(
        title="Hip and knee",
        caption="Knee flexion over hip flexion through one cycle: the phase plot of figure 6 in "
        "Hodgins et al. 1995.",
        x_label="Hip flexion [deg]",
        y_label="Knee flexion [deg]",
        series=tuple(lines),
    )


def _rise_chart(found: Sequence[Likeness]) -> Chart:
    return Chart(
        title="Height of the center of mass",
        caption="Over its mean in the cycle, drift taken out.",
        x_label="Share of the cycle, from touchdown to touchdown [%]",
        y_label="Height [mm]",
        series=tuple(
            Series(
                name=one.gait.name,
                x=100.0 * PHASE,
                y=1e3 * np.mean([c.height for c in one.gait.cycles], axis=0),
            )
            for one in found
        ),
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
    caption = "Of the ground on one foot, mean over the stances, unfiltered."
    if which == 0:
        mean = found[0].people.figures["force_mean_bw"].mean
        half = 0.5 * np.pi * mean * np.sin(np.pi * PHASE)
        lines.append(Series(name="half sine, people's mean force", x=100.0 * PHASE, y=half))
    return Chart(
        title="Upward force" if which == 0 else "Force along the way",
        caption=caption if which == 0 else f"{caption} Braking is negative.",
        x_label="Share of the stance [%]",
        y_label="Force [body weights]",
        series=tuple(lines),
        decimals=2,
    )
