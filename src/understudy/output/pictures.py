"""Stills and contact sheets: a moment, or a whole motion on one page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import InvalidValue, UnknownName, require
from understudy.motion.clip import Clip
from understudy.output.camera import BEARINGS, Shot
from understudy.output.playback import Playback, playback
from understudy.output.png import write_png
from understudy.output.renderer import opened

if TYPE_CHECKING:
    from understudy.take import Take

GHOSTS = ("over", "beside", "none")
# A ghost over the body must let it be seen; one beside it stands for itself.
_OPACITY = {"over": 0.45, "beside": 0.8, "none": 0.0}
_COLUMNS = 6
_LABEL_HEIGHT = 26  # pixels
_PAPER, _INK, _GREY = (250, 250, 250), (35, 38, 43), (105, 112, 122)


@dataclass(frozen=True, kw_only=True)
class Picture:
    """What was drawn.

    Attributes:
        pixels: Red, green, blue, uint8, shape (height, width, 3).
        renderer: "opengl" or "software".
        text: What is stored with the picture: title, renderer, view, time.
    """

    pixels: np.ndarray[Any, np.dtype[np.uint8]]
    renderer: str
    text: Mapping[str, str]


def still(
    thing: Take | Clip,
    time: float,
    path: str | PathLike[str] | None = None,
    *,
    view: str = "follow",
    ghost: str = "over",
    width: int = 960,
    height: int = 720,
    renderer: str = "software",
) -> Picture:
    """Draw one moment, framed so that the body fills the picture.

    Args:
        thing: A take, or a clip (drawn as rods).
        time: When [s].
        path: PNG file to write, if any.
        view: "front", "three-quarter", "side" or "back" with the whole motion in the frame;
            "follow" (three-quarter) or "follow-front", ... with the body at its time.
        ghost: The reference "over" the simulated body, "beside" it, or "none".
        width: Width [pixels].
        height: Height [pixels].
        renderer: "software", "opengl" or "auto"; see `renderer.opened`. Software is the
            default: for a few pictures it takes less time than finding out whether OpenGL works,
            looks the same on every machine, and draws soft shadows.

    Raises:
        InvalidValue: A time outside the motion, or a size that is no picture.
        UnknownName: No such view, ghost or renderer.
    """
    checked_size(width, height)
    rate = thing.rate if isinstance(thing, Clip) else min(thing.rate, 240.0)
    shown = arranged(playback(thing, rate=rate), ghost, view)
    frame = shown.nearest(time)
    moment = shown.between(frame, frame + 1) if view.startswith("follow") else shown
    shot = moment.shot(view, width / height)
    frame = frame if moment is shown else 0
    drawing = opened(
        shown.model,
        width,
        height,
        renderer=renderer,
        spec=shown.spec,
        ghost_bodies=shown.ghost_bodies,
    )
    try:
        pixels = drawn(drawing, moment, shot, frame, ghost)
    finally:
        drawing.close()
    text = _described(shown, drawing.name, view) | {"Time": f"{moment.times[frame]:.3f} s"}
    if path is not None:
        write_png(path, pixels, text)
    return Picture(pixels=pixels, renderer=drawing.name, text=text)


def contact_sheet(
    thing: Take | Clip,
    path: str | PathLike[str] | None = None,
    *,
    count: int = 12,
    view: str = "follow",
    follow: bool = True,
    width: int = 220,
    height: int = 280,
    renderer: str = "software",
) -> Picture:
    """Draw a motion as a strip of moments at even times, reference above simulated.

    Args:
        thing: A take, or a clip (one row).
        path: PNG file to write, if any.
        count: How many moments.
        view: See `still`; every moment is drawn at the same scale.
        follow: Travel along with the body, also for "front", "side", ...; otherwise those show
            the whole way it goes, in which a body that travels is small.
        width: Width of one moment [pixels].
        height: Height of one moment [pixels].
        renderer: See `still`.

    Raises:
        InvalidValue: A count outside 1 to 200, or a size that is no picture.
        UnknownName: No such view or renderer.
        MissingExtra: Pillow, which writes the labels, is not installed.
    """
    checked_size(width, height)
    if not 1 <= count <= 200:
        raise InvalidValue(f"count is {count}; it must lie between 1 and 200.")
    require("PIL", extra="video")
    if follow and view in BEARINGS:
        view = f"follow-{view}"
    shown = playback(thing, rate=60.0)
    frames = np.unique(np.linspace(0, shown.frames - 1, count).round().astype(int))
    rows = [(shown.labels[1], shown.reference())] if shown.ghost is not None else []
    rows.append((shown.labels[0] if shown.simulated else shown.name, shown.alone()))
    shots = _shots(shown, [row for _, row in rows], view, width / height)
    drawing = opened(shown.model, width, height, renderer=renderer, spec=shown.spec)
    try:
        cells = [
            [drawn(drawing, row, shot, int(f), "none") for f in frames]
            for (_, row), shot in zip(rows, shots, strict=True)
        ]
    finally:
        drawing.close()
    times = [f"{shown.times[f]:.2f} s" for f in frames]
    pixels = _laid_out(cells, [name for name, _ in rows], times, shown.name)
    text = _described(shown, drawing.name, view)
    if path is not None:
        write_png(path, pixels, text)
    return Picture(pixels=pixels, renderer=drawing.name, text=text)


def _shots(shown: Playback, rows: list[Playback], view: str, aspect: float) -> list[Shot]:
    """A shot per row, from one side and at one scale; a following camera follows each row's body.

    So a body that fell, and its reference that walked on, both fill their pictures.
    """
    if not view.startswith("follow"):
        return [shown.shot(view, aspect)] * len(rows)
    for row in rows:
        row.__dict__["heading"] = shown.heading
    shots = [row.shot(view, aspect) for row in rows]
    distance = max(shot.distance for shot in shots)
    return [replace(shot, distance=distance) for shot in shots]


def arranged(shown: Playback, ghost: str, view: str) -> Playback:
    """The playback with its ghost over the body, beside it, or gone."""
    if ghost not in GHOSTS:
        raise UnknownName("ghost", ghost, GHOSTS)
    return {"over": shown, "beside": shown.beside(view), "none": shown.alone()}[ghost]


def drawn(
    drawing: Any, shown: Playback, shot: Shot, frame: int, ghost: str
) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """One frame of a playback, uint8, shape (height, width, 3)."""
    return drawing.picture(
        shown.qpos[frame],
        shot.camera(frame),
        ghost=None if shown.ghost is None else shown.ghost[frame],
        opacity=_OPACITY[ghost],
    )


def checked_size(width: int, height: int) -> None:
    """Refuse sizes [pixels] that are no picture; raises `InvalidValue`."""
    if not (16 <= width <= 7680 and 16 <= height <= 4320):
        raise InvalidValue(
            f"A picture of {width} x {height} pixels; it must lie in 16 x 16 to 7680 x 4320."
        )


def _described(shown: Playback, renderer: str, view: str) -> dict[str, str]:
    return {
        "Title": shown.name,
        "Software": "Understudy",
        "Renderer": renderer,
        "View": view,
    }


def _laid_out(
    cells: list[list[np.ndarray]], names: list[str], times: list[str], title: str
) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Cells in bands of a few columns, with times above and the row's name at the left."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = cells[0][0].shape[:2]
    columns = min(len(times), _COLUMNS)
    bands = -(-len(times) // columns)
    small, large = ImageFont.load_default(15), ImageFont.load_default(20)
    left = 12 + max(int(small.getlength(name)) for name in names) + 12 if len(names) > 1 else 12
    top, gap = 44, 4
    band = _LABEL_HEIGHT + len(cells) * (height + gap)
    page = Image.new(
        "RGB", (left + columns * (width + gap) + 12 - gap, top + bands * band + 10), _PAPER
    )
    pen = ImageDraw.Draw(page)
    heading = title if len(names) == 1 else f"{title}: {' and '.join(names)}"
    pen.text((12, 12), heading, fill=_INK, font=large)
    for k, time in enumerate(times):
        x = left + (k % columns) * (width + gap)
        y = top + (k // columns) * band
        pen.text((x + width / 2, y + 4), time, fill=_GREY, font=small, anchor="ma")
        for r, row in enumerate(cells):
            at = y + _LABEL_HEIGHT + r * (height + gap)
            page.paste(Image.fromarray(np.ascontiguousarray(row[k])), (x, at))
            if k % columns == 0 and len(names) > 1:
                pen.text((12, at + height / 2), names[r], fill=_INK, font=small, anchor="lm")
    return np.asarray(page)
