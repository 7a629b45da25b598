"""The reproduction as one HTML page, and its numbers as plain values."""

from __future__ import annotations

import html as markup
from typing import TYPE_CHECKING, Any

from understudy.evaluate.chart import SCRIPT
from understudy.evaluate.chart import STYLE as CHART_STYLE
from understudy.output.page import page
from understudy.papers.filmstrip import STYLE as FILM_STYLE
from understudy.papers.finding import STYLE
from understudy.papers.hodgins1995.published import FIGURES, NOT_COMPARABLE
from understudy.papers.hodgins1995.timeline import STYLE as TIMELINE_STYLE
from understudy.papers.reproduction import body_html, numbers_of
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
    text = markup.escape
    used = ", ".join(found.captured) or "none"
    about = [
        "<p>J. K. Hodgins, W. L. Wooten, D. C. Brogan, J. F. O'Brien, <em>Animating Human "
        f"Athletics</em>, SIGGRAPH 95, part: {text(found.part)}. What the paper says beside what "
        "was "
        "measured here.</p>",
        *([f'<p class="held">{text(QUICK)}</p>'] if found.quick else []),
        f"<p>{text(SETTINGS)} Captured runs: {text(used)}.</p>",
    ]
    body = body_html(
        found.findings,
        title=TITLE,
        about=about,
        not_comparable=NOT_COMPARABLE,
        printed=FIGURES,
        sharp=not found.quick,
    )
    style = SHEET_STYLE + CHART_STYLE + FILM_STYLE + TIMELINE_STYLE + STYLE
    return page("Hodgins et al. 1995, reproduced", body, style=style, script=SCRIPT)


def as_dict(found: Reproduced) -> dict[str, Any]:
    """All numbers as plain values."""
    return {
        "paper": "Hodgins et al. 1995",
        "part": found.part,
        "settings": SETTINGS,
        "quick": found.quick,
        "captured": list(found.captured),
        **numbers_of(found.findings, NOT_COMPARABLE),
    }
