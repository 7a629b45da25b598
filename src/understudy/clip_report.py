"""A clip before it is performed: what the ground cannot give, what was changed, both motions."""

from __future__ import annotations

import html as markup
from os import PathLike

from understudy.control import Tracking
from understudy.evaluate.chart import SCRIPT, STYLE, Chart, Series
from understudy.evaluate.preparation import preparation
from understudy.feasibility import Feasibility, assess
from understudy.motion.files import written
from understudy.output.page import page
from understudy.output.player import player_html
from understudy.performance import Performance
from understudy.take import posed


def feasibility_chart(found: Feasibility) -> Chart:
    """The force that the ground cannot give over time, and what it bears."""
    return Chart(
        title="What the ground cannot give",
        caption="Force that the motion needs and contact with the ground does not explain, in % of "
        "body weight (BW), and its upward part. Zero needs no help.",
        x_label="Time [s]",
        y_label="Force [% BW]",
        series=(
            Series(name="missing", x=found.times, y=found.sizes),
            Series(name="upward part", x=found.times, y=found.force[:, 2]),
        ),
    )


def clip_page(performance: Performance) -> str:
    """One HTML page: outlook, moments, plot, changes, and a player with both motions.

    Args:
        performance: As `tracked` gives, on a ground.
    """
    take, found = posed(performance), assess(performance)
    clip = take.references[0]
    name = "clip" if clip is None else clip.name
    followed = [c for c in performance.controllers if isinstance(c, Tracking)]
    notes = followed[0].reference.notes
    moments = "".join(f"<li>{_text(moment)}</li>" for moment in found.moments)
    listed = "".join(f"<li>{_text(note)}</li>" for note in notes)
    body = (
        f"<header><h1>{_text(name)}</h1><p><b>Missing {_text(found)}</b></p></header>"
        f'<iframe title="as read and prepared" sandbox="allow-scripts" style="{_FRAME}" '
        f'srcdoc="{_text(player_html(take, title=name))}"></iframe>'
        f"<section><h2>Over time</h2>{feasibility_chart(found).html()}"
        f"{f'<ul>{moments}</ul>' if moments else ''}</section>"
        f"<section><h2>Changed</h2><p>{_text(preparation(take))}</p><ul>{listed}</ul></section>"
    )
    return page(name, body, style=STYLE, script=SCRIPT)


def write_clip_page(performance: Performance, path: str | PathLike[str]) -> None:
    """Write the page to a file.

    Raises:
        UnderstudyError: The file cannot be written.
    """
    text = clip_page(performance)
    with written(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _text(value: object) -> str:
    return markup.escape(str(value), quote=True)


_FRAME = "display:block;width:100%;height:clamp(20rem,58vw,36rem);border:0"
