"""The reproduction as one HTML page, and its numbers as plain values."""

from __future__ import annotations

import html as markup
from typing import TYPE_CHECKING, Any

from understudy import __version__
from understudy.evaluate.chart import SCRIPT
from understudy.evaluate.chart import STYLE as CHART_STYLE
from understudy.output.page import page
from understudy.papers.filmstrip import STYLE as FILM_STYLE
from understudy.papers.finding import STYLE, Finding, finding_dict, section_html, summary_html
from understudy.papers.sheets import STYLE as SHEET_STYLE
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
        *(summary_html(finding) for finding in found.findings if finding.claims),
        "</ol>",
        "<h2>What cannot be compared, and why</h2><ul>",
        *(f"<li>{_text(reason)}</li>" for reason in NOT_COMPARABLE),
        "</ul>",
        *(
            section_html(finding, shows=_shows(finding), sharp=not found.quick)
            for finding in found.findings
        ),
        f'<p class="kicker">Made by understudy {__version__}.</p>',
    ]
    style = SHEET_STYLE + CHART_STYLE + FILM_STYLE + STYLE
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
        "figures": [finding_dict(finding) for finding in found.findings],
        "version": __version__,
    }


def _text(value: object) -> str:
    return markup.escape(str(value))


def _shows(finding: Finding) -> str:
    """What the paper's figures show, in words of ours."""
    numbers = {int(word) for word in finding.figure.replace(",", " ").split() if word.isdigit()}
    if "," in finding.figure:
        return ""
    texts = [f"Figure {f.number}: {f.shows}" for f in FIGURES if f.number in numbers]
    return f"The paper's {' '.join(texts)}"
