"""The reproduction as one HTML page, and its numbers as CSV and JSON."""

from __future__ import annotations

import html as markup
from dataclasses import asdict
from typing import Any

import numpy as np

from understudy import __version__
from understudy.evaluate.chart import SCRIPT, Chart, Series
from understudy.evaluate.chart import STYLE as CHART_STYLE
from understudy.evaluate.convergence import convergence
from understudy.fidelity import drive_error
from understudy.output.page import page
from understudy.papers.sheets import STYLE as SHEET_STYLE
from understudy.papers.sheets import Sheet, as_html
from understudy.papers.stills import STYLE as STILLS_STYLE
from understudy.papers.stills import Strip, strips_html
from understudy.papers.wilke2017 import published
from understudy.papers.wilke2017.cast import PARTS
from understudy.papers.wilke2017.experiments import TUNED_ON, Reproduced, sag_law
from understudy.papers.wilke2017.figures import kick_height, kick_window
from understudy.papers.wilke2017.runs import UNIT

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
    style = SHEET_STYLE + CHART_STYLE + STILLS_STYLE
    return page("Wilke & Semwal 2017, reproduced", "\n".join(body), style=style, script=SCRIPT)


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


def _table(sheet: Sheet) -> str:
    title = "" if sheet.name.startswith(("Figure", "Clips")) else f"<h3>{_text(sheet.name)}</h3>"
    return title + as_html(sheet, endless="flew apart")
