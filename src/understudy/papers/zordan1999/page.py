"""The reproduction as one HTML page, and its numbers as plain values."""

from __future__ import annotations

import html as markup
from typing import TYPE_CHECKING, Any

from understudy.evaluate.chart import SCRIPT
from understudy.evaluate.chart import STYLE as CHART_STYLE
from understudy.output.page import page
from understudy.papers.filmstrip import STYLE as FILM_STYLE
from understudy.papers.finding import STYLE
from understudy.papers.reproduction import body_html, numbers_of
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
    text = markup.escape
    used = "a capture" if found.cast.captured else "made, not captured"
    about = [
        "<p>Every figure with simulations of V. B. Zordan, J. K. Hodgins, <em>Tracking and "
        "Modifying Upper-body Human Motion Data with Dynamic Simulation</em>, Computer Animation "
        "and Simulation '99: what the paper says of it beside what was measured here.</p>",
        *([f'<p class="held">{text(QUICK)}</p>'] if found.quick else []),
        f"<p>{text(SETTINGS)} Gesture: {text(found.cast.source)} ({used}).</p>",
    ]
    body = body_html(
        found.findings,
        title=TITLE,
        about=about,
        not_comparable=NOT_COMPARABLE,
        printed=FIGURES,
        sharp=not found.quick,
    )
    style = SHEET_STYLE + CHART_STYLE + FILM_STYLE + STYLE
    return page("Zordan & Hodgins 1999, reproduced", body, style=style, script=SCRIPT)


def as_dict(found: Reproduced) -> dict[str, Any]:
    """All numbers as plain values."""
    return {
        "paper": "Zordan & Hodgins 1999",
        "settings": SETTINGS,
        "quick": found.quick,
        "gesture": {
            "used": found.cast.source,
            "captured": found.cast.captured,
            "duration_s": found.cast.gesture.duration,
        },
        **numbers_of(found.findings, NOT_COMPARABLE),
    }
