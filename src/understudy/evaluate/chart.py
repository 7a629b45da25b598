"""Line and bar charts as small pieces of HTML, drawn without a plotting package.

A chart is a value; `html` gives a figure that follows the width of the page, light and dark, with
values under the pointer or the arrow keys. A page includes `STYLE` and `SCRIPT` once. Drawing takes
about a millisecond; importing a plotting package would take most of a second. `write_chart` makes
a PNG, PDF or SVG file with matplotlib for those who want one.
"""

from __future__ import annotations

import html as markup
import itertools
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from understudy.errors import InvalidValue, require
from understudy.motion.figure import plain_name
from understudy.motion.files import written
from understudy.motion.rotations import Array

WIDTH, HEIGHT = 1000, 300
BUCKETS = 400
STROKES = ("", "7 4", "2 3", "10 3 2 3", "1 4", "4 2")


@dataclass(frozen=True, kw_only=True)
class Series:
    """One line: finite values where there are any, gaps where not.

    Attributes:
        name: Shown in the legend.
        x: Shape (points,), increasing.
        y: Shape (points,).
    """

    name: str
    x: Array = field(repr=False)
    y: Array = field(repr=False)

    def __post_init__(self) -> None:
        x, y = np.array(self.x, float).ravel(), np.array(self.y, float).ravel()
        if len(x) != len(y):
            raise InvalidValue(f"Series {self.name!r} has {len(x)} x and {len(y)} y values.")
        object.__setattr__(self, "x", x)
        object.__setattr__(self, "y", y)


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A line chart.

    Attributes:
        title: Heading.
        caption: What is drawn and how to read it, a sentence or two.
        x_label: Quantity and unit.
        y_label: Quantity and unit.
        series: The lines, most important first.
        x_scale: "linear" or "log".
        decimals: Digits after the point in values shown.
    """

    title: str
    caption: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]
    x_scale: str = "linear"
    decimals: int = 1

    def __post_init__(self) -> None:
        object.__setattr__(self, "series", tuple(self.series))
        if self.x_scale not in ("linear", "log"):
            raise InvalidValue(f"x_scale is {self.x_scale!r}; it must be 'linear' or 'log'.")

    def html(self) -> str:
        """The chart as an HTML figure; the page needs `STYLE` and `SCRIPT`."""
        return _line_html(self)


@dataclass(frozen=True, kw_only=True)
class Bars:
    """A bar chart with one bar for each name.

    Attributes:
        title: Heading.
        caption: What is drawn, a sentence or two.
        label: Quantity and unit.
        names: One per bar.
        values: Shape (bars,), zero or positive.
        marks: A limit to mark on each bar, NaN for none, shape (bars,); empty for none at all.
        mark_name: What the marks are.
    """

    title: str
    caption: str
    label: str
    names: tuple[str, ...]
    values: Array = field(repr=False)
    marks: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    mark_name: str = "limit"

    def html(self) -> str:
        """The chart as an HTML figure; the page needs `STYLE`."""
        return _bars_html(self)


def ticks(low: float, high: float, *, count: int = 5) -> list[float]:
    """Round values between two bounds, about `count` of them, steps of 1, 2 or 5 times 10^n."""
    if not high > low:
        return [low]
    raw = (high - low) / max(count, 1)
    power = 10.0 ** np.floor(np.log10(raw))
    step = next(s * power for s in (1, 2, 5, 10) if s * power >= raw * (1 - 1e-9))
    first = np.ceil(low / step - 1e-9)
    return [float(k * step) for k in np.arange(first, np.floor(high / step + 1e-9) + 1)]


def number(value: float, step: float = 0.0) -> str:
    """A tick's label: as many decimals as the step needs."""
    decimals = max(0, int(np.ceil(-np.log10(step) - 1e-9))) if step > 0 else 0
    text = f"{value:.{decimals}f}" if step > 0 else f"{value:g}"
    return "0" if float(text) == 0 else text


def thinned(x: Array, y: Array, *, buckets: int = BUCKETS) -> tuple[Array, Array]:
    """Fewer points that look the same: the lowest and highest of every stretch."""
    if len(x) <= 2 * buckets:
        return x, y
    edges = np.linspace(0, len(x), buckets + 1).astype(int)
    keep = {0, len(x) - 1}
    for a, b in itertools.pairwise(edges):
        part = y[a:b]
        keep |= {a + int(np.argmin(part)), a + int(np.argmax(part))}
    chosen = np.array(sorted(keep))
    return x[chosen], y[chosen]


@dataclass(frozen=True)
class _Frame:
    """The rectangle of a chart in data values; x is a logarithm when the scale is."""

    x0: float
    x1: float
    y0: float
    y1: float
    x_ticks: tuple[tuple[float, str], ...]
    y_ticks: tuple[tuple[float, str], ...]


def _frame(chart: Chart) -> _Frame:
    xs = [np.log10(s.x[s.x > 0]) if chart.x_scale == "log" else s.x for s in chart.series]
    x = np.concatenate([*xs, np.zeros(0)])
    y = np.concatenate([*(s.y for s in chart.series), np.zeros(0)])
    x, y = x[np.isfinite(x)], y[np.isfinite(y)]
    x0, x1 = (float(x.min()), float(x.max())) if len(x) else (0.0, 1.0)
    low = min(0.0, float(y.min())) if len(y) else 0.0
    # Differences too small to print would only show rounding.
    least = 10.0**-chart.decimals
    high = max(float(y.max()), low + least) if len(y) else 1.0
    if x1 <= x0:
        x1 = x0 + 1.0
    marks = ticks(low, high)
    step = marks[1] - marks[0] if len(marks) > 1 else high - low
    # Whole steps above and below, so that no line runs along the edge.
    y0, y1 = np.floor(low / step + 1e-9) * step, np.ceil(high / step - 1e-9) * step
    marks = ticks(y0, y1, count=max(1, round((y1 - y0) / step)))
    if chart.x_scale == "log":
        whole = np.arange(np.floor(x0), np.ceil(x1) + 1)
        values = [m * 10.0**k for k in whole for m in ((1, 2, 5) if x1 - x0 < 2 else (1,))]
        across = [(float(np.log10(v)), f"{v:g}") for v in values if x0 <= np.log10(v) <= x1]
    else:
        even = ticks(x0, x1, count=6)
        gap = even[1] - even[0] if len(even) > 1 else 0.0
        across = [(v, number(v, gap)) for v in even]
    return _Frame(
        x0,
        x1,
        float(y0),
        float(y1),
        tuple(across),
        tuple((v, number(v, float(step))) for v in marks),
    )


def _path(chart: Chart, series: Series, frame: _Frame) -> str:
    x, y = thinned(series.x, series.y)
    if chart.x_scale == "log":
        x, y = np.log10(x[x > 0]), y[x > 0]
    across = (x - frame.x0) / (frame.x1 - frame.x0) * WIDTH
    down = (frame.y1 - y) / (frame.y1 - frame.y0) * HEIGHT
    pieces, pen = [], "M"
    for px, py in zip(across, down, strict=True):
        if not np.isfinite(py):
            pen = "M"
            continue
        pieces.append(f"{pen}{px:.1f} {py:.1f}")
        pen = "L"
    return "".join(pieces)


def _spoken(chart: Chart) -> str:
    """The chart in words, for those who cannot see it."""
    parts = [f"{chart.title}: {chart.y_label} against {chart.x_label}."]
    for s in chart.series:
        good = s.y[np.isfinite(s.y)]
        if len(good):
            d = chart.decimals
            parts.append(
                f"{s.name} from {good.min():.{d}f} to {good.max():.{d}f}, mean {good.mean():.{d}f}."
            )
    return " ".join(parts)


def _line_html(chart: Chart) -> str:
    frame, text = _frame(chart), markup.escape
    wide, tall = frame.x1 - frame.x0, frame.y1 - frame.y0
    grid = "".join(
        f'<path class="grid" d="M0 {(frame.y1 - v) / tall * HEIGHT:.1f}H{WIDTH}"/>'
        for v, _ in frame.y_ticks
    )
    if frame.y0 < 0 < frame.y1:
        grid += f'<path class="zero" d="M0 {frame.y1 / tall * HEIGHT:.1f}H{WIDTH}"/>'
    lines = "".join(
        f'<path class="line c{k % 6}" data-name="{text(s.name)}" '
        f'stroke-dasharray="{STROKES[k % 6]}" d="{_path(chart, s, frame)}"/>'
        # The first line is the most important one: drawn last, over the others.
        for k, s in reversed(list(enumerate(chart.series)))
    )
    legend = "".join(
        f'<li><svg width="26" height="10" aria-hidden="true"><path class="line c{k % 6}" '
        f'stroke-dasharray="{STROKES[k % 6]}" d="M0 5H26"/></svg>{text(s.name)}</li>'
        for k, s in enumerate(chart.series)
    )
    down = "".join(
        f'<span style="top:{(frame.y1 - v) / tall * 100:.2f}%">{t}</span>' for v, t in frame.y_ticks
    )
    across = "".join(
        f'<span style="left:{(v - frame.x0) / wide * 100:.2f}%">{t}</span>'
        for v, t in frame.x_ticks
    )
    unit = chart.x_label
    return (
        f'<figure class="chart"><figcaption><h3>{text(chart.title)}</h3>'
        f"<p>{text(chart.caption)}</p></figcaption>"
        f'<p class="unit">{text(chart.y_label)}</p>'
        f'<div class="axes"><div class="down" aria-hidden="true">{down}</div>'
        f'<div class="plot" tabindex="0" role="img" aria-label="{text(_spoken(chart))}" '
        f'data-x0="{frame.x0:.9g}" data-x1="{frame.x1:.9g}" data-y0="{frame.y0:.9g}" '
        f'data-y1="{frame.y1:.9g}" data-log="{int(chart.x_scale == "log")}" '
        f'data-digits="{chart.decimals}" data-unit="{text(unit)}">'
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" preserveAspectRatio="none" aria-hidden="true">'
        f"{grid}{lines}</svg></div>"
        f'<div class="across" aria-hidden="true">{across}</div></div>'
        f'<p class="unit right">{text(unit)}</p><ul class="legend">{legend}</ul></figure>'
    )


def _bars_html(bars: Bars) -> str:
    text = markup.escape
    marks = bars.marks if len(bars.marks) else np.full(len(bars.values), np.nan)
    known = np.concatenate((bars.values, marks[np.isfinite(marks)], [1e-9]))
    # A limit far beyond every bar would leave the bars too short to compare.
    top = float(min(known.max(), 2.0 * max(float(np.max(bars.values, initial=0.0)), 1e-9)))
    rows = []
    for name, value, mark in zip(bars.names, bars.values, marks, strict=True):
        limit = ""
        if np.isfinite(mark) and mark <= top:
            limit = f'<i class="mark" style="left:{100 * mark / top:.2f}%"></i>'
        over = " over" if np.isfinite(mark) and value > mark else ""
        beside = f" of {mark:.0f}" if np.isfinite(mark) else ""
        rows.append(
            f'<tr><th scope="row">{text(plain_name(name))}</th><td class="bar">'
            f'<i class="fill{over}" style="width:{100 * value / top:.2f}%"></i>{limit}</td>'
            f'<td class="value">{value:.1f}<small>{beside}</small></td></tr>'
        )
    head = text(bars.label) + (
        f"; the tick is the {text(bars.mark_name)}" if np.isfinite(marks).any() else ""
    )
    return (
        f'<figure class="chart"><figcaption><h3>{text(bars.title)}</h3>'
        f"<p>{text(bars.caption)}</p></figcaption>"
        f'<table class="bars"><caption>{head}</caption><tbody>{"".join(rows)}</tbody></table>'
        "</figure>"
    )


def write_chart(chart: Chart | Bars, path: str | PathLike[str]) -> None:
    """Write a chart as .png, .pdf or .svg.

    Raises:
        MissingExtra: matplotlib is not installed.
        InvalidValue: The suffix is another.
        UnderstudyError: The file cannot be written.
    """
    kind = Path(path).suffix.lower().lstrip(".")
    if kind not in ("png", "pdf", "svg"):
        raise InvalidValue(f"{path}: charts are written as .png, .pdf or .svg.")
    figure = require("matplotlib.figure", extra="plots").Figure(
        figsize=(8, 3.6), layout="constrained"
    )
    axes = figure.subplots()
    if isinstance(chart, Chart):
        _draw_lines(chart, axes)
    else:
        axes.barh(chart.names, chart.values, color="#2f6fdb")
        axes.invert_yaxis()
        axes.set_xlabel(chart.label)
        figure.set_size_inches(8, 1.2 + 0.28 * len(chart.names))
    axes.set_title(chart.title, loc="left", fontsize="medium")
    with written(path) as temporary:
        figure.savefig(temporary, format=kind, dpi=150)


def _draw_lines(chart: Chart, axes: Any) -> None:
    styles = ("-", "--", ":", "-.", (0, (1, 4)), (0, (4, 2)))
    for k, s in reversed(list(enumerate(chart.series))):
        axes.plot(s.x, s.y, linestyle=styles[k % 6], linewidth=1.4, label=s.name)
    axes.set_xscale(chart.x_scale)
    axes.set_xlabel(chart.x_label)
    axes.set_ylabel(chart.y_label)
    axes.grid(alpha=0.25)
    if chart.series:
        axes.legend(frameon=False, fontsize="small")


STYLE = """
.chart{margin:0 0 2rem;break-inside:avoid}
.chart h3{margin:0 0 .15rem;font-size:1rem}
.chart figcaption p{margin:0 0 .5rem;color:var(--dim);font-size:.875rem;max-width:70ch}
.chart .unit{margin:0 0 .35rem;font-size:.75rem;color:var(--dim)}
.chart .unit.right{text-align:right;margin:.1rem 0 0;max-width:none}
.axes{display:grid;grid-template-columns:3rem 1fr;grid-template-rows:clamp(9rem,32vw,14rem) 1.4rem}
.axes .down,.axes .across{position:relative;font-size:.75rem;color:var(--dim);
 font-variant-numeric:tabular-nums}
.axes .down span{position:absolute;right:.5rem;transform:translateY(-50%)}
.axes .across{grid-column:2}
.axes .across span{position:absolute;top:.3rem;transform:translateX(-50%)}
.plot{position:relative;cursor:crosshair;touch-action:pan-y}
.plot:focus-visible{outline:2px solid var(--c0);outline-offset:2px}
.plot svg{position:absolute;inset:0;width:100%;height:100%;overflow:visible}
.chart path{fill:none;vector-effect:non-scaling-stroke}
.chart .grid{stroke:var(--rule);stroke-width:1}
.chart .zero{stroke:var(--dim);stroke-width:1}
.chart .line{stroke-width:1.6;stroke-linejoin:round}
.chart .c0{stroke:var(--c0)}.chart .c1{stroke:var(--c1)}.chart .c2{stroke:var(--c2)}
.chart .c3{stroke:var(--c3)}.chart .c4{stroke:var(--c4)}.chart .c5{stroke:var(--c5)}
.plot .cursor{position:absolute;top:0;bottom:0;width:1px;background:var(--dim);
 pointer-events:none}
.plot .tip{position:absolute;top:.25rem;padding:.3rem .5rem;font-size:.75rem;
 background:var(--page);border:1px solid var(--rule);border-radius:.3rem;pointer-events:none;
 white-space:nowrap;font-variant-numeric:tabular-nums;z-index:1}
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1.2rem;margin:.2rem 0 0 3rem;padding:0;
 list-style:none;font-size:.8125rem}
.legend svg{vertical-align:middle;margin-right:.4rem}
.bars{width:100%;border-collapse:collapse;font-size:.8125rem}
.bars caption{caption-side:top;text-align:left;color:var(--dim);font-size:.75rem;
 padding-bottom:.3rem}
.bars th{font-weight:400;text-align:left;white-space:nowrap;width:1%;padding:.15rem .8rem .15rem 0}
.bars td{padding:.15rem 0}.bars .bar{position:relative}
.bars .fill{display:block;height:.8rem;background:var(--c0);border-radius:0 .15rem .15rem 0}
.bars .fill.over{background:var(--c1)}
.bars .mark{position:absolute;top:.05rem;bottom:.05rem;width:2px;background:var(--ink)}
.bars .value{text-align:right;white-space:nowrap;width:1%;padding-left:.8rem;
 font-variant-numeric:tabular-nums}
.bars small{color:var(--dim)}
"""

SCRIPT = """
for (const plot of document.querySelectorAll('.plot')) {
  const num = key => Number(plot.dataset[key]);
  const [x0, x1, y0, y1, digits] = ['x0', 'x1', 'y0', 'y1', 'digits'].map(num);
  const lines = [...plot.querySelectorAll('.line')].reverse().map(path => ({
    name: path.dataset.name,
    points: [...path.getAttribute('d').matchAll(/[ML]([-\\d.]+) ([-\\d.]+)/g)]
      .map(m => [m[1] / 1000, m[2] / 300]),
  })).filter(line => line.points.length);
  if (!lines.length) continue;
  const cursor = document.createElement('div'), tip = document.createElement('div');
  cursor.className = 'cursor'; tip.className = 'tip';
  let at = 0;
  const near = (points, x) => points.reduce(
    (a, b) => Math.abs(b[0] - x) < Math.abs(a[0] - x) ? b : a);
  const show = x => {
    at = Math.min(1, Math.max(0, x));
    const value = x0 + at * (x1 - x0);
    const rows = [plot.dataset.unit + ': '
      + (num('log') ? 10 ** value : value).toPrecision(4)];
    for (const line of lines) {
      const y = y1 - near(line.points, at)[1] * (y1 - y0);
      rows.push(line.name + ': ' + y.toFixed(digits));
    }
    tip.replaceChildren(...rows.map(row => {
      const div = document.createElement('div'); div.textContent = row; return div;
    }));
    if (!cursor.isConnected) plot.append(cursor, tip);
    cursor.style.left = at * 100 + '%';
    tip.style.left = at < .5 ? `calc(${at * 100}% + .5rem)` : 'auto';
    tip.style.right = at < .5 ? 'auto' : `calc(${(1 - at) * 100}% + .5rem)`;
  };
  const hide = () => { cursor.remove(); tip.remove(); };
  plot.addEventListener('pointermove', event => {
    const box = plot.getBoundingClientRect();
    show((event.clientX - box.left) / box.width);
  });
  plot.addEventListener('pointerleave', hide);
  plot.addEventListener('blur', hide);
  plot.addEventListener('keydown', event => {
    const step = { ArrowLeft: -.01, ArrowRight: .01, Home: -9, End: 9 }[event.key];
    if (step) { event.preventDefault(); show(at + step); }
  });
}
"""
