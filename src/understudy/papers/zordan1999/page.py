"""The reproduction as one HTML page, and its numbers as plain values."""

from __future__ import annotations

import html as markup
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from understudy import __version__
from understudy.evaluate.chart import SCRIPT
from understudy.evaluate.chart import STYLE as CHART_STYLE
from understudy.output.page import page
from understudy.papers.filmstrip import STYLE as FILM_STYLE
from understudy.papers.filmstrip import Film, films_html
from understudy.papers.sheets import STYLE as SHEET_STYLE
from understudy.papers.sheets import as_html
from understudy.papers.zordan1999.finding import Claim, Finding, Strip
from understudy.papers.zordan1999.published import FIGURES, NOT_COMPARABLE

if TYPE_CHECKING:
    from understudy.papers.zordan1999 import Reproduced

TITLE = "Tracking and modifying upper-body motion, reproduced"
SETTINGS = (
    "Two laws: the paper's, torque = k (desired - actual) - kd (velocity) with kd = k / 10 "
    "(equation 2), and the modern one, which damps against the reference's velocity and adds what "
    "inverse dynamics says. Physics steps of about 2 ms unless a table says otherwise."
)
QUICK = (
    "Quick run: the beginning of each motion, few bodies and few games, to see that all of it "
    "runs. Its numbers say little about the paper's figures."
)


def page_html(found: Reproduced) -> str:
    """The page."""
    held, count = found.held
    used = "a capture" if found.cast.captured else "made, not captured"
    body = [
        f"<h1>{_text(TITLE)}</h1>",
        "<p>Every figure with simulations of V. B. Zordan, J. K. Hodgins, <em>Tracking and "
        "Modifying Upper-body Human Motion Data with Dynamic Simulation</em>, Computer Animation "
        "and Simulation '99: what the paper says of it beside what was measured here.</p>",
        *([f'<p class="held">{_text(QUICK)}</p>'] if found.quick else []),
        f"<p>{_text(SETTINGS)} Gesture: {_text(found.cast.source)} ({used}).</p>",
        f"<p><b>{held} of {count}</b> statements hold.</p>",
        '<ol class="claims">',
        *(_summary(finding) for finding in found.findings if finding.claims),
        "</ol>",
        "<h2>What cannot be compared, and why</h2><ul>",
        *(f"<li>{_text(reason)}</li>" for reason in NOT_COMPARABLE),
        "</ul>",
        *(_section(finding, sharp=not found.quick) for finding in found.findings),
        f'<p class="kicker">Made by understudy {__version__}.</p>',
    ]
    style = SHEET_STYLE + CHART_STYLE + FILM_STYLE + _STYLE
    return page("Zordan & Hodgins 1999, reproduced", "\n".join(body), style=style, script=SCRIPT)


def as_dict(found: Reproduced) -> dict[str, Any]:
    """All numbers as plain values."""
    held, count = found.held
    return {
        "paper": "Zordan & Hodgins 1999",
        "settings": SETTINGS,
        "quick": found.quick,
        "gesture": {
            "used": found.cast.source,
            "captured": found.cast.captured,
            "duration_s": found.cast.gesture.duration,
        },
        "not_comparable": list(NOT_COMPARABLE),
        "statements": count,
        "statements_that_hold": held,
        "figures": [
            {
                "figure": finding.figure,
                "title": finding.title,
                "setting": finding.setting,
                "claims": [asdict(claim) for claim in finding.claims],
                "facts": finding.facts,
                "tables": [asdict(sheet) for sheet in finding.sheets],
            }
            for finding in found.findings
        ],
        "version": __version__,
    }


def _text(value: object) -> str:
    return markup.escape(str(value))


def _anchor(finding: Finding) -> str:
    return "figure-" + finding.figure.replace(", ", "-").replace(" ", "-")


def _summary(finding: Finding) -> str:
    good = all(claim.holds for claim in finding.claims)
    kept = sum(claim.holds for claim in finding.claims)
    return (
        f'<li class="{"yes" if good else "no"}"><a href="#{_anchor(finding)}">'
        f"{_text(finding.name)}: {_text(finding.title)}</a> "
        f"<span>{kept} of {len(finding.claims)} hold</span></li>"
    )


def _shows(finding: Finding) -> str:
    """What the paper's figures show, in words of ours."""
    numbers = {int(word) for word in finding.figure.replace(",", " ").split() if word.isdigit()}
    if "," in finding.figure:
        return ""
    texts = [f"Figure {f.number}: {f.shows}" for f in FIGURES if f.number in numbers]
    return f"<p>The paper's {_text(' '.join(texts))}</p>"


def _claims(claims: tuple[Claim, ...]) -> str:
    items = "".join(
        f'<li class="{"yes" if claim.holds else "no"}"><b>{_text(claim.said)}</b> '
        f"<span>{_text(claim.measured)}</span></li>"
        for claim in claims
    )
    return f'<ul class="claims">{items}</ul>' if items else ""


def _section(finding: Finding, *, sharp: bool) -> str:
    width, height = (240, 300) if sharp else (80, 100)
    parts = [
        f'<section id="{_anchor(finding)}"><h2>{_text(finding.name)}: {_text(finding.title)}</h2>',
        _shows(finding),
        _claims(finding.claims),
        *(
            films_html(_films(s, sharp), alt=s.alt, scale=s.scale, width=width, height=height)
            for s in finding.strips
        ),
        *(chart.html() for chart in finding.charts),
        _numbers(finding),
        f'<p class="note">{_text(finding.setting)}</p></section>',
    ]
    return "\n".join(filter(None, parts))


def _films(strip: Strip, sharp: bool) -> list[Film]:
    """The rows; of a quick run every third moment."""
    return [replace(f, times=f.times[:: 1 if sharp else 3]) for f in strip.films]


def _numbers(finding: Finding) -> str:
    """All tables, folded away."""
    if not finding.sheets:
        return ""
    tables = "".join(as_html(sheet) for sheet in finding.sheets)
    return f"<details><summary>All numbers</summary>{tables}</details>"


_STYLE = """
.claims{list-style:none;padding:0;margin:.5rem 0 1.25rem}
.claims li{position:relative;padding:.15rem 0 .15rem 1.6rem;max-width:80ch}
.claims li::before{position:absolute;left:.1rem;font-weight:700}
.claims .yes::before{content:"\\2713";color:var(--good)}
.claims .no::before{content:"\\2717";color:var(--held)}
.claims b{font-weight:600}.claims span{display:block;color:var(--dim);font-size:.9375rem}
.claims a{color:var(--c0)}ol.claims span{display:inline}
details{margin:0 0 1rem}summary{cursor:pointer;font-weight:600;font-size:.875rem}
details .wide .words{white-space:nowrap}
"""
