"""States of a machine over time, a row for each, as HTML and SVG."""

from __future__ import annotations

import html as markup
from dataclasses import dataclass, field

import numpy as np

from understudy.evaluate.chart import ticks
from understudy.motion.rotations import Array

_WIDE, _ROW, _LEFT, _GAP = 1000.0, 26.0, 130.0, 6.0
STYLE = """
.timeline{margin:0 0 2rem}
.timeline h3{margin:0 0 .15rem;font-size:1rem}
.timeline p{margin:0 0 .5rem;color:var(--dim);font-size:.875rem;max-width:70ch}
.timeline svg{display:block;width:100%;height:auto}
.timeline text{font-size:15px;fill:var(--ink)}.timeline .dim{fill:var(--dim);font-size:13px}
.timeline .rule{stroke:var(--rule);stroke-width:1}
.timeline .left{fill:var(--c0)}.timeline .right{fill:var(--c1)}
"""


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """What state the machine was in, and for which leg.

    Attributes:
        title: Heading.
        caption: What is drawn, a sentence or two.
        names: Of the states.
        notes: Shown at the end of each row, such as the state's share.
        times: Shape (steps,) [s].
        states: Number of the state, shape (steps,).
        legs: 0 for the left leg, 1 for the right, shape (steps,).
    """

    title: str
    caption: str
    names: tuple[str, ...]
    notes: tuple[str, ...]
    times: Array = field(repr=False)
    states: np.ndarray = field(repr=False)
    legs: np.ndarray = field(repr=False)

    def spells(self) -> list[tuple[int, int, float, float]]:
        """Every stay in a state: state, leg, first and last time [s]."""
        both = np.stack((self.states, self.legs), axis=1)
        edges = np.flatnonzero((np.diff(both, axis=0) != 0).any(axis=1)) + 1
        starts = np.concatenate(([0], edges))
        ends = np.concatenate((edges, [len(both) - 1]))
        return [
            (int(self.states[a]), int(self.legs[a]), float(self.times[a]), float(self.times[b]))
            for a, b in zip(starts, ends, strict=True)
        ]

    def html(self) -> str:
        """The figure; the page needs `STYLE`."""
        text = markup.escape
        first, last = float(self.times[0]), float(self.times[-1])
        scale = (_WIDE - 2.0 * _LEFT) / (last - first)
        height = (_ROW + _GAP) * len(self.names)
        parts = []
        for time in ticks(first, last, count=8):
            x = _LEFT + (time - first) * scale
            parts.append(
                f'<path class="rule" d="M{x:.1f} 0V{height:.1f}"/><text class="dim" x="{x:.1f}" '
                f'y="{height + 16:.0f}" text-anchor="middle">{abs(time):g} s</text>'
            )
        for k, (name, note) in enumerate(zip(self.names, self.notes, strict=True)):
            y = k * (_ROW + _GAP) + 0.7 * _ROW
            parts.append(
                f'<text x="0" y="{y:.1f}">{text(name)}</text><text class="dim" '
                f'x="{_WIDE - _LEFT + 10:.0f}" y="{y:.1f}">{text(note)}</text>'
            )
        for state, leg, start, end in self.spells():
            x, y = _LEFT + (start - first) * scale, state * (_ROW + _GAP)
            parts.append(
                f'<rect class="{"right" if leg else "left"}" x="{x:.1f}" y="{y:.1f}" '
                f'width="{max((end - start) * scale, 1.0):.1f}" height="{_ROW:.0f}" rx="2"/>'
            )
        return (
            f'<figure class="timeline"><figcaption><h3>{text(self.title)}</h3>'
            f"<p>{text(self.caption)}</p></figcaption>"
            f'<svg viewBox="0 0 {_WIDE:.0f} {height + 22:.0f}" role="img" '
            f'aria-label="{text(self.title)}">{"".join(parts)}</svg></figure>'
        )
