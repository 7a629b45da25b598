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
from understudy.papers.hodgins1995.published import FIGURES, NOT_COMPARABLE
from understudy.papers.hodgins1995.timeline import STYLE as TIMELINE_STYLE
from understudy.papers.sheets import STYLE as SHEET_STYLE

if TYPE_CHECKING:
    from understudy.papers.hodgins1995 import Reproduced

TITLE = "Animating human athletics, reproduced"
SETTINGS = (
    "A body of 17 links with a motor on each of its 30 hinges, physics steps of 1 ms, gains "
    "found by "
    "a search and kept with the package."
)
QUICK = (
    "Quick run: seconds instead of minutes and few speeds, to see that all of it runs. Its numbers "
    "say little about the paper's statements."
)


def page_html(found: Reproduced) -> str:
    """The page."""
    held, count = found.held
    text = markup.escape
    used = ", ".join(found.captured) or "none"
    body = [
        f"<h1>{text(TITLE)}</h1>",
        "<p>J. K. Hodgins, W. L. Wooten, D. C. Brogan, J. F. O'Brien, <em>Animating Human "
        f"Athletics</em>, SIGGRAPH 95, part: {text(found.part)}. What the paper says beside what "
        "was "
        "measured here.</p>",
        *([f'<p class="held">{text(QUICK)}</p>'] if found.quick else []),
        f"<p>{text(SETTINGS)} Captured runs: {text(used)}.</p>",
        f"<p><b>{held} of {count}</b> statements hold.</p>",
        '<ol class="claims">',
        *(summary_html(finding) for finding in found.findings if finding.claims),
        "</ol>",
        "<h2>What cannot be compared, and why</h2><ul>",
        *(f"<li>{text(reason)}</li>" for reason in NOT_COMPARABLE),
        "</ul>",
        *(
            section_html(finding, shows=_shows(finding), sharp=not found.quick)
            for finding in found.findings
        ),
        f'<p class="kicker">Made by understudy {__version__}.</p>',
    ]
    style = SHEET_STYLE + CHART_STYLE + FILM_STYLE + TIMELINE_STYLE + STYLE
    return page("Hodgins et al. 1995, reproduced", "\n".join(body), style=style, script=SCRIPT)


def as_dict(found: Reproduced) -> dict[str, Any]:
    """All numbers as plain values."""
    held, count = found.held
    return {
        "paper": "Hodgins et al. 1995",
        "part": found.part,
        "settings": SETTINGS,
        "quick": found.quick,
        "captured": list(found.captured),
        "not_comparable": list(NOT_COMPARABLE),
        "statements": count,
        "statements_that_hold": held,
        "figures": [finding_dict(finding) for finding in found.findings],
        "version": __version__,
    }


def _shows(finding: Finding) -> str:
    """What the paper's figures show, in words of ours."""
    if "," in finding.figure:
        return ""
    numbers = {int(word) for word in finding.figure.split() if word.isdigit()}
    texts = [f"Figure {f.number}: {f.shows}" for f in FIGURES if f.number in numbers]
    return f"The paper's {' '.join(texts)}" if texts else ""
