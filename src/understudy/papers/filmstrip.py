"""Moments of a take side by side, drawn as pictures and put into the page itself."""

from __future__ import annotations

import base64
import html as markup
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from understudy.motion.clip import Clip
from understudy.output.pictures import drawn
from understudy.output.playback import playback
from understudy.output.png import encoded
from understudy.output.renderer import opened
from understudy.take import Take

STYLE = """
.film{margin:0 0 1.6rem}
.film h4{margin:.8rem 0 .2rem;font-size:.8125rem;font-weight:600}
.film .row{display:flex;gap:.25rem;overflow-x:auto}
.film figure{margin:0;flex:1 1 0;min-width:5.5rem}
.film img{display:block;width:100%;height:auto;border-radius:.25rem}
.film figcaption{font-size:.75rem;color:var(--dim);text-align:center}
"""


@dataclass(frozen=True, kw_only=True)
class Film:
    """Moments of one motion.

    Attributes:
        title: What it is.
        thing: A take, or a clip, which is drawn as rods.
        times: Moments to show [s].
        view: See `output.still`; the camera stands still over the moments shown.
        heading: Direction that counts as ahead for the view, from +x toward +y [rad]; None is where
            those shown face, which two who face each other do not say.
    """

    title: str
    thing: Take | Clip = field(repr=False)
    times: tuple[float, ...]
    view: str = "three-quarter"
    heading: float | None = None


def films_html(
    films: Sequence[Film], *, alt: str, width: int = 210, height: int = 270, scale: str = "own"
) -> str:
    """Rows of pictures as an HTML figure; the page needs `STYLE`.

    Args:
        films: The rows.
        alt: What is seen, in words.
        width: Of one picture [pixels].
        height: Of one picture [pixels].
        scale: "own" frames each row by itself; "one" takes one distance for all, so that a child is
            smaller than a man.
    """
    shown = []
    for film in films:
        whole = playback(film.thing, rate=120.0).alone()
        if film.heading is not None:
            whole.__dict__["heading"] = film.heading
        frames = np.array([whole.nearest(time) for time in film.times])
        few = whole.chosen(frames, rate=whole.rate)
        shown.append((film, few, few.shot(film.view, width / height)))
    if scale == "one":
        far = max(shot.distance for *_, shot in shown)
        shown = [(film, few, replace(shot, distance=far)) for film, few, shot in shown]
    rows = []
    for film, few, shot in shown:
        drawing = opened(few.model, width, height, renderer="software", spec=few.spec)
        try:
            pictures = [drawn(drawing, few, shot, k, "none") for k in range(few.frames)]
        finally:
            drawing.close()
        panels = "".join(
            f'<figure><img alt="" width="{width}" height="{height}" src="data:image/png;base64,'
            f'{base64.b64encode(encoded(picture)).decode()}">'
            f"<figcaption>{time:.2f} s</figcaption></figure>"
            for picture, time in zip(pictures, film.times, strict=True)
        )
        rows.append(f'<h4>{markup.escape(film.title)}</h4><div class="row">{panels}</div>')
    label = markup.escape(alt, quote=True)
    return f'<div class="film" role="img" aria-label="{label}">{"".join(rows)}</div>'
