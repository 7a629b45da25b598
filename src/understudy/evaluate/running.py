"""A gait against people: how like the curves are, how far off each figure, and the charts of it.

In come gaits (`understudy.evaluate.gait`), out go a `Likeness` for each and the pieces of a page:
tables and plain values for JSON. Charts: `understudy.evaluate.running_charts`.
"""

from __future__ import annotations

import html as markup
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from understudy.errors import InvalidValue
from understudy.evaluate.gait import Gait, Spread
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
    found = {name: np.degrees(gait.curve(name)[0]) for name in CURVES}
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


def beside(run: Gait, other: Gait) -> dict[str, CurveMatch]:
    """A run's curves against another's, such as a captured one; by name.

    Raises:
        InvalidValue: One of them has no whole cycle.
    """
    return {
        name: matched(name, *(np.degrees(one.curve(name)[0]) for one in (run, other)))
        for name in CURVES
    }


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


CURVES = {
    "hip": ("Hip flexion", "Thigh against pelvis; zero standing, flexion positive."),
    "thigh": ("Thigh", "Line from hip to knee, forward of straight down."),
    "knee": ("Knee flexion", "Between thigh and shank; zero is straight."),
    "ankle": ("Ankle dorsiflexion", "Foot against shank; zero standing, toes up positive."),
    "foot": ("Foot, toe up", "Attitude of the foot; zero is flat."),
    "pelvis": ("Pelvis, anterior tilt", "Zero standing, forward positive."),
    "trunk": ("Trunk lean", "Line from the hips to the neck, forward of standing."),
}
"""Title of every curve, and how it is defined."""


@dataclass(frozen=True)
class _Row:
    """How a figure is shown: its title, unit, factor from its own unit, and digits."""

    title: str
    unit: str
    factor: float
    digits: int

    def number(self, value: float) -> str:
        """A value in the row's unit; zero has no sign."""
        text = f"{self.factor * value:.{self.digits}f}"
        return text.lstrip("-") if float(text) == 0.0 else text

    def mean(self, spread: Spread | None) -> str:
        """The mean and, over several values, their standard deviation."""
        if spread is None:
            return "-"
        text = self.number(spread.mean)
        return text if spread.count < 2 else f"{text} ± {self.number(spread.sd)}"

    def usual(self, human: Human | None) -> str:
        """People's mean and usual range."""
        if human is None:
            return "-"
        text = self.number(human.mean)
        if human.low is None or human.high is None:
            return text
        return f"{text} ({self.number(human.low)} to {self.number(human.high)})"

    def beside(self, spread: Spread | None, human: Human | None) -> str:
        """The mean and, in brackets, people's."""
        text = self.mean(spread)
        return text if spread is None or human is None else f"{text} ({self.number(human.mean)})"


_ROWS = {
    "speed_m_s": _Row("Speed", "m/s", 1.0, 2),
    "acceleration_m_s2": _Row("Gain in speed", "m/s²", 1.0, 1),
    "stance_s": _Row("Stance", "ms", 1e3, 0),
    "flight_s": _Row("Flight", "ms", 1e3, 0),
    "duty": _Row("Duty factor", "%", 100.0, 1),
    "step_rate_hz": _Row("Step rate", "Hz", 1.0, 2),
    "step_length_m": _Row("Step length", "m", 1.0, 2),
    "step_width_m": _Row("Step width", "mm", 1e3, 0),
    "com_rise_m": _Row("Rise of the center of mass", "mm", 1e3, 0),
    "legs_apart_m": _Row("Lower legs apart, least", "mm", 1e3, 0),
    "landing_forward_m_s": _Row("Ankle, forward at touchdown", "m/s", 1.0, 1),
    "landing_down_m_s": _Row("Ankle, downward at touchdown", "m/s", 1.0, 1),
    "knee_touchdown_deg": _Row("Knee at touchdown", "°", 1.0, 0),
    "knee_stance_peak_deg": _Row("Knee, most in stance", "°", 1.0, 0),
    "knee_toe_off_deg": _Row("Knee at toe-off", "°", 1.0, 0),
    "knee_swing_peak_deg": _Row("Knee, most in swing", "°", 1.0, 0),
    "thigh_toe_off_deg": _Row("Thigh at toe-off", "°", 1.0, 0),
    "thigh_forward_peak_deg": _Row("Thigh, most forward", "°", 1.0, 0),
    "thigh_back_peak_deg": _Row("Thigh, furthest back", "°", 1.0, 0),
    "plantarflexion_toe_off_deg": _Row("Plantarflexion at toe-off", "°", 1.0, 0),
    "ankle_stance_peak_deg": _Row("Ankle, most dorsiflexed in stance", "°", 1.0, 0),
    "foot_touchdown_deg": _Row("Foot at touchdown, toe up", "°", 1.0, 0),
    "trunk_touchdown_deg": _Row("Trunk lean at touchdown", "°", 1.0, 0),
    "trunk_stance_peak_deg": _Row("Trunk lean, most in stance", "°", 1.0, 0),
    "trunk_mean_deg": _Row("Trunk lean, mean", "°", 1.0, 0),
    "force_peak_bw": _Row("Force, largest", "BW", 1.0, 2),
    "force_active_bw": _Row("Force, largest after the first quarter", "BW", 1.0, 2),
    "force_impact_bw": _Row("Force, impact peak", "BW", 1.0, 2),
    "force_mean_bw": _Row("Force, mean in stance", "BW", 1.0, 2),
    "loading_rate_bw_s": _Row("Loading rate", "BW/s", 1.0, 0),
    "braking_m_s": _Row("Braking impulse over mass", "m/s", 1.0, 2),
    "pushing_m_s": _Row("Pushing impulse over mass", "m/s", 1.0, 2),
}


def figures_table(found: Sequence[Likeness]) -> str:
    """Every figure of every gait beside people at its own speed, as HTML."""
    first, *rest = found
    head = ["Figure", first.gait.name, f"people at {first.people.speed:.1f} m/s"]
    head += [f"{one.gait.name} (people at {one.people.speed:.1f} m/s)" for one in rest]
    measures = [one.gait.figures() for one in found]
    rows = []
    for name, row in _ROWS.items():
        values = [figures.get(name) for figures in measures]
        if not any(values):
            continue
        published = [one.people.figures.get(name) for one in found]
        cells = [f"{row.title} [{row.unit}]", row.mean(values[0]), row.usual(published[0])]
        cells += [row.beside(v, h) for v, h in zip(values[1:], published[1:], strict=True)]
        rows.append(cells)
    return table("Mean ± standard deviation; of people the mean and the usual range", head, rows)


def curves_table(found: Sequence[Likeness]) -> str:
    """How like people's the curves of every gait are, as HTML."""
    first, *rest = found
    head = ["Curve", "correlation", "rms [°]", "mean off [°]", "range [°]", "people's range [°]"]
    head += [f"{one.gait.name}: correlation; rms [°]" for one in rest]
    rows = []
    for name, m in first.curves.items():
        cells = [CURVES[name][0], f"{m.correlation:.3f}", f"{m.rms_deg:.1f}"]
        cells += [f"{m.offset_deg:+.1f}", f"{m.range_deg:.0f}", f"{m.people_range_deg:.0f}"]
        for one in rest:
            cells.append(f"{one.curves[name].correlation:.3f}; {one.curves[name].rms_deg:.1f}")
        rows.append(cells)
    caption = f"Angle curves of {first.gait.name} against people's at the same speed"
    return table(f"{caption}, then the others' against people's at theirs", head, rows)


def beside_table(found: Sequence[Likeness]) -> str:
    """How like the other gaits' the curves of the first are, as HTML; nothing without others."""
    first, *rest = found
    if not rest:
        return ""
    matches = [beside(first.gait, one.gait) for one in rest]
    rows = [
        [title, *(f"{match[name].correlation:.3f}; {match[name].rms_deg:.1f}" for match in matches)]
        for name, (title, _) in CURVES.items()
    ]
    head = ["Curve", *(f"{one.gait.name}: correlation; rms [°]" for one in rest)]
    return table(f"The curves of {first.gait.name} against the others'", head, rows)


def sources_list(found: Sequence[Likeness]) -> str:
    """Where people's values come from, as an HTML list."""
    rows: dict[str, list[str]] = {f"{found[0].people.curve_source}": ["angle curves"]}
    for one in found:
        for name, human in one.people.figures.items():
            at = "" if human.at_speed is None else f"; known at {human.at_speed:g} m/s only"
            title = _ROWS[name].title.lower()
            titles = rows.setdefault(f"{human.source}; {human.known}{at}", [])
            if title not in titles:
                titles.append(title)
    items = "".join(
        f"<li>{markup.escape(', '.join(what))}: {markup.escape(source)}.</li>"
        for source, what in rows.items()
    )
    return f"<ul>{items}</ul>"
