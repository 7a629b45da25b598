"""The reproduction as one HTML page, and its numbers as CSV and JSON."""

from __future__ import annotations

import csv
import html as markup
import io
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from understudy import __version__
from understudy.evaluate.chart import SCRIPT, Chart, Series
from understudy.evaluate.chart import STYLE as CHART_STYLE
from understudy.evaluate.convergence import convergence
from understudy.fidelity import drive_error
from understudy.papers.stills import STYLE as STILLS_STYLE
from understudy.papers.stills import Strip, strips_html
from understudy.papers.wilke2017 import published
from understudy.papers.wilke2017.cast import PARTS
from understudy.papers.wilke2017.experiments import (
    TUNED_ON,
    UNIT,
    Reproduced,
    Sheet,
    kick_height,
    kick_window,
    sag_law,
)

SETTINGS = (
    f"1 unit = {1e3 * UNIT:.2f} mm (a BVH unit of the CMU motions). Gravity 9.81 units/s^2, scale "
    "1.4286 unless a row says otherwise, one step of 1/60 s for each frame, semi-implicit Euler, "
    "bodies of 1 kg, no floor, the paper's law: F = K_f m (v* - v), T = K_f I (w* - w)."
)

QUICK = (
    "Quick run: the first two seconds of each clip and token searches, to see that all of it runs. "
    "Its numbers say nothing about the paper's."
)


def page_html(found: Reproduced) -> str:
    """The page."""
    tables = {sheet.name: _table(sheet) for sheet in found.tables}
    charts = [convergence(list(found.searches[kind].values())) for kind in published.KINDS]
    body = [
        "<h1>Generative animation with motion captures, reproduced</h1>",
        "<p>Every table and every figure with simulations of B. Wilke, S. K. Semwal, "
        "<em>Generative Animation in a Physics Engine using Motion Captures</em>, GRAPP 2017: "
        "published numbers beside those measured here.</p>",
        *([f'<p class="held">{_text(QUICK)}</p>'] if found.quick else []),
        f"<p>{_text(SETTINGS)}</p>",
        _clips(found),
        "<h2>What cannot be compared, and why</h2><ul>",
        *(f"<li>{_text(reason)}</li>" for reason in published.NOT_COMPARABLE),
        "</ul>",
        "<h2>Tuning</h2>",
        tables["Table 1"],
        *(chart.html() for chart in charts),
        tables["Table 2"],
        _figure_2(found).html(),
        "<h2>Simulated clips</h2>",
        *_plain_stills(found),
        "<h2>Asymmetric scaling</h2>",
        tables["Table 3"],
        *_scaled_stills(found, tables["Table 4"]),
        "<h2>Under-controlling and zombies</h2>",
        *_limp_stills(found),
        f'<p class="kicker">Made by understudy {__version__}.</p>',
    ]
    return _PAGE.format(
        style=_STYLE + CHART_STYLE + STILLS_STYLE, body="\n".join(body), script=SCRIPT
    )


def as_dict(found: Reproduced) -> dict[str, Any]:
    """All numbers as plain values."""
    return {
        "paper": "Wilke & Semwal 2017",
        "settings": SETTINGS,
        "quick": found.quick,
        "clips": {
            part.file: {
                "motion": part.motion,
                "used": found.cast.sources[part.file],
                "own": part.file in found.cast.own,
                "duration_s": found.cast.clips[part.file].duration,
            }
            for part in PARTS
        },
        "not_comparable": list(published.NOT_COMPARABLE),
        "tables": [asdict(sheet) for sheet in (*found.tables, *found.figures.values())],
        "figure_2_growth": {kind: error.growth for kind, error in found.growth.items()},
        "searches": {
            kind: {
                method: {
                    "best": asdict(search.best),
                    "driven": search.parameters,
                    "simulations": len(search.trials),
                    "settings": search.settings,
                }
                for method, search in searches.items()
            }
            for kind, searches in found.searches.items()
        },
        "version": __version__,
        **found.facts,
    }


def as_csv(sheet: Sheet) -> str:
    """A table as CSV, numbers in full."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(sheet.head)
    writer.writerows(["" if cell is None else cell for cell in row] for row in sheet.rows)
    return out.getvalue()


# -- parts of the page --------------------------------------------------------------------------


def _text(value: object) -> str:
    return markup.escape(str(value))


def _clips(found: Reproduced) -> str:
    cast = found.cast
    rows = []
    for part in PARTS:
        clip = cast.clips[part.file]
        own = part.file in cast.own
        plays = "the paper's own" if own else "a stand-in"
        rows.append(
            (f"{part.file}.bvh", part.motion, cast.sources[part.file], plays, clip.duration)
        )
    table = _table(
        Sheet(
            name="Clips",
            caption="The paper's clips and what was used in their place.",
            head=("Published file", "motion", "used here", "", "duration [s]"),
            rows=tuple(rows),
        )
    )
    if len(cast.own) == len(PARTS):
        return table
    warning = (
        "Numbers measured on a stand-in are not those of the paper's clip: compare orders of "
        "magnitude, orders and trends. --clips with the paper's files compares like with like."
    )
    return f'{table}<p class="held">{warning}</p>'


def _figure_2(found: Reproduced) -> Chart:
    lines = []
    for kind, error in found.growth.items():
        name = f"{published.KIND_NAMES[kind]} (slope {error.growth:.2f})"
        frames = np.arange(len(error.times), dtype=float)
        lines.append(Series(name=name, x=frames, y=error.squared[:, 0]))
        gain = published.TABLE_1[kind].gain
        law = np.array([3.0 * sag_law(gain, t) for t in error.times])
        if kind == "skeleton":
            lines.append(Series(name="sag law (g t / K_f)^2, physical skeleton", x=frames, y=law))
    clip = found.cast.clips[TUNED_ON]
    return Chart(
        title="Figure 2: squared error of the Hips against the frame",
        caption=f"{clip.name} at the published K_f of each linkage and the clip's own speed. The "
        "paper shows errors that accumulate; their slope in double logarithmic axes is 2, that of "
        "bodies which sink with speed g / K_f.",
        x_label="Frame (1/60 s)",
        y_label="e^2 of Hips [units^2]",
        series=tuple(lines),
        decimals=3,
    )


def _spread(duration: float, count: int = 5) -> tuple[float, ...]:
    return tuple(float(t) for t in np.linspace(0.0, duration, count))


def _plain_stills(found: Reproduced) -> list[str]:
    run, walk = found.cast.clips["141_02"], found.cast.clips["141_30"]
    rows = [
        Strip(
            title=published.KIND_NAMES[kind],
            take=found.takes[f"run {kind}"],
            times=_spread(run.duration),
        )
        for kind in published.KINDS
    ]
    late = tuple(walk.duration * share for share in (0.85, 0.9, 0.95, 1.0))
    out = [
        f"<h3>Figure 3: {_text(run.name)} by the three linkages</h3>"
        "<p>With the parameters tuned here; gray: the clip.</p>",
        strips_html(rows, alt="Stills of three linkages that run."),
    ]
    for figure, kind in (("4", "skeleton"), ("5", "constrained")):
        gap = drive_error(found.takes[f"walk {kind}"]).gap_max
        said = f"joints come up to {gap:.3g} units apart"
        strip = Strip(
            title=published.KIND_NAMES[kind], take=found.takes[f"walk {kind}"], times=late
        )
        out += [
            f"<h3>Figure {figure}: {_text(walk.name)} after many steps: {said}</h3>",
            strips_html([strip], alt=f"Late stills of the {kind} linkage."),
        ]
    return [*out, _table(found.figures["Figures 4 and 5"])]


def _scaled_stills(found: Reproduced, table_4: str) -> list[str]:
    kick, ranged = found.cast.clips["141_14"], found.cast.clips[TUNED_ON]
    reference = found.takes["kick"].references[0]
    assert reference is not None
    first, last = (frame / 60.0 for frame in kick_window(reference))
    top = kick_height(found.takes["kick"]) / 60.0
    moments = tuple(float(np.clip(top + d, first, last)) for d in (-0.4, -0.2, 0.0, 0.2, 0.4))
    rows = [
        Strip(title="unscaled", take=found.takes["kick"], times=moments),
        Strip(title="RightFoot x 1.2", take=found.takes["kick scaled"], times=moments),
    ]
    more = [
        Strip(title="unscaled", take=found.takes["range"], times=_spread(ranged.duration, 6)),
        Strip(title="Table 4", take=found.takes["range scaled"], times=_spread(ranged.duration, 6)),
    ]
    return [
        f"<h3>Figure 6: {_text(kick.name)}, RightFoot scaled</h3>",
        strips_html(rows, alt="Stills of a kick, unscaled and scaled."),
        _table(found.figures["Figure 6"]),
        table_4,
        f"<h3>Figure 7: {_text(ranged.name)} with the scales of table 4</h3>",
        strips_html(more, alt="Stills with a stronger left side."),
    ]


def _limp_stills(found: Reproduced) -> list[str]:
    walk = found.cast.clips["141_30"]
    rows = [
        Strip(title="all bodies controlled", take=found.takes["walk constrained"], times=()),
        Strip(title="left hand and left foot uncontrolled", take=found.takes["limp"], times=()),
    ]
    moments = _spread(walk.duration, 6)
    rows = [Strip(title=r.title, take=r.take, times=moments) for r in rows]
    out = [
        f"<h3>Figure 8: {_text(walk.name)}, under-controlled</h3>",
        strips_html(rows, alt="Stills of an under-controlled walk."),
        _table(found.figures["Figure 8"]),
    ]
    for figure, file in (("9", "141_02"), ("10", "141_08"), ("11", "141_30")):
        clip = found.cast.clips[file]
        strip = Strip(
            title="zombie", take=found.takes[f"zombie {figure}"], times=_spread(clip.duration, 6)
        )
        out += [
            f"<h3>Figure {figure}: a zombie on {_text(clip.name)}</h3>",
            strips_html([strip], alt="Stills of a zombie."),
            _table(found.figures[f"Figure {figure}"]),
        ]
    return out


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return "flew apart" if not np.isfinite(value) else f"{value:.4g}"
    return _text(value)


def _table(sheet: Sheet) -> str:
    worded = [any(isinstance(row[k], str) for row in sheet.rows) for k in range(len(sheet.head))]

    def row(cells: Sequence[Any], tag: str = "td") -> str:
        parts = []
        for k, (cell, words) in enumerate(zip(cells, worded, strict=True)):
            own = "th scope='row'" if k == 0 and tag == "td" else tag
            kind = ' class="words"' if words and k else ""
            parts.append(f"<{own}{kind}>{_cell(cell)}</{own.split()[0]}>")
        return f"<tr>{''.join(parts)}</tr>"

    published_row = "".join(
        row(cells).replace("<tr>", '<tr class="published">') if "published" in cells else row(cells)
        for cells in sheet.rows
    )
    title = "" if sheet.name.startswith(("Figure", "Clips")) else f"<h3>{_text(sheet.name)}</h3>"
    notes = "".join(f'<p class="note">{_text(note)}</p>' for note in sheet.notes)
    return (
        f'{title}<div class="wide" tabindex="0" role="region" aria-label="{_text(sheet.name)}">'
        f"<table><caption>{_text(sheet.caption)}</caption>"
        f"<thead>{row(sheet.head, 'th')}</thead><tbody>{published_row}</tbody></table></div>{notes}"
    )


_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; img-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'">
<meta name="color-scheme" content="light dark">
<meta name="generator" content="Understudy">
<link rel="icon" href="data:,">
<title>Wilke &amp; Semwal 2017, reproduced</title>
<style>{style}</style>
</head>
<body>
<main>
{body}
</main>
<script>{script}</script>
</body>
</html>
"""

_STYLE = """
:root{--page:#fff;--ink:#1c1f24;--dim:#5c6470;--rule:#dfe3e8;--panel:#f5f7f9;--held:#9a4a06;
 --c0:#1f5fc4;--c1:#c4501a;--c2:#0f8a63;--c3:#8453bd;--c4:#7a7f18;--c5:#b03a72}
@media screen and (prefers-color-scheme:dark){:root{--page:#15181c;--ink:#e8eaed;--dim:#9aa3ae;
 --rule:#30363d;--panel:#1d2126;--held:#f0a35c;--c0:#7fb0ff;--c1:#ff9a66;--c2:#54d1a4;
 --c3:#c7a4ff;--c4:#d3d86a;--c5:#ff8fc0}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);
 font:16px/1.5 system-ui,-apple-system,"Segoe UI",sans-serif}
main{max-width:66rem;margin:0 auto;padding:1.5rem clamp(1rem,4vw,2rem) 3rem}
h1{margin:0 0 1rem;font-size:clamp(1.6rem,5vw,2.2rem);line-height:1.15}
h2{margin:2.5rem 0 .75rem;font-size:1.3rem;border-top:1px solid var(--rule);padding-top:1rem}
h3{margin:1.5rem 0 .4rem;font-size:1rem}
p,li{max-width:75ch}
.kicker,.note{color:var(--dim);font-size:.875rem;margin:.35rem 0}
.held{padding:.6rem .9rem;background:var(--panel);border-left:4px solid var(--held)}
.wide{overflow-x:auto;margin-bottom:.6rem}
.wide table{border-collapse:collapse;width:100%;font-size:.8125rem}
.wide caption{text-align:left;color:var(--dim);padding-bottom:.4rem}
.wide th,.wide td{padding:.25rem .6rem .25rem 0;border-bottom:1px solid var(--rule);
 text-align:right;vertical-align:bottom;font-variant-numeric:tabular-nums}
.wide thead th{font-weight:600;line-height:1.25}
.wide th:first-child,.wide .words{text-align:left}
.wide tbody th{font-weight:400;white-space:nowrap}
.wide .published>*{background:var(--panel)}
@media print{:root{--page:#fff;--ink:#000;--dim:#444}main{max-width:none;padding:0}
 .wide tr,.stills{break-inside:avoid}}
"""
