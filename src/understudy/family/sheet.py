"""The contact sheet of a family: every member in a few moments, the unvaried motion behind it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.errors import require
from understudy.family.figure import Bone, heading_of, view_axes
from understudy.family.member import Member
from understudy.motion.files import written
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.family.family import Family

_COLUMNS, _MOMENTS, _MOST = 4, 5, 400
_CELL, _LABELS, _GAP = (390, 150), 40, 10
_PAPER, _CARD, _INK, _GREY = (244, 245, 247), (255, 255, 255), (28, 32, 40), (108, 116, 128)
_GHOST, _ALARM, _FLOOR = (205, 211, 219), (190, 40, 40), (226, 229, 234)
COLORS = {"left": (219, 112, 52), "right": (46, 108, 178), "": (72, 84, 100)}


def write_sheet(made: Family, figure: tuple[Bone, ...], path: Path) -> None:
    """Draw the sheet; families beyond 400 are shown by their first 400.

    Raises:
        MissingExtra: Pillow is not installed.
        UnderstudyError: The file cannot be written.
    """
    require("PIL", extra="video")
    from PIL import Image, ImageDraw, ImageFont

    members = (made.unvaried, *made.members[:_MOST])
    columns = min(_COLUMNS, len(members))
    rows = -(-len(members) // columns)
    width, height = _CELL[0] + _GAP, _CELL[1] + _LABELS + _GAP
    page = Image.new("RGB", (columns * width + _GAP, rows * height + 50), _PAPER)
    pen = ImageDraw.Draw(page)
    small, large = ImageFont.load_default(12), ImageFont.load_default(20)
    flags = ", ".join(f"{n} {flag}" for flag, n in made.flagged().items() if n)
    shown = "" if len(made.members) <= _MOST else f", the first {_MOST}"
    title = f"{made.name}: {len(made.members)} variations{shown}; {flags or 'none flagged'}"
    title += "" if made.floor else "; no floor is simulated"
    pen.text((_GAP, 12), title, fill=_INK, font=large)
    axes = view_axes(heading_of(made.unvaried.poses, figure))
    scale = _scale(members, axes)
    for k, member in enumerate(members):
        x, y = _GAP + (k % columns) * width, 44 + (k // columns) * height
        page.paste(_strip(member, made.unvaried, figure, axes, scale, made.floor), (x, y + _LABELS))
        pen.rectangle((x, y, x + _CELL[0] - 1, y + _LABELS - 1), fill=_CARD)
        pen.text((x + 8, y + 4), member.name.replace("_", " "), fill=_INK, font=small)
        if member.flags:
            text = ", ".join(member.flags)
            pen.text((x + _CELL[0] - 8, y + 4), text, fill=_ALARM, font=small, anchor="ra")
        changes = [s for s in member.says if not s.startswith("grip")] or list(member.says)
        pen.text(
            (x + 8, y + 21),
            _fitting("; ".join(changes) or "as it was", small, _CELL[0] - 16),
            fill=_GREY,
            font=small,
        )
    with written(path) as temporary:
        page.save(temporary)


def _scale(members: tuple[Member, ...], axes: Array) -> float:
    """Pixels per meter with which nearly every pose fits its place."""
    tall = wide = 0.1
    for member in members[:40]:
        points = _centered(np.asarray(member.poses[::5], float)) @ axes[:2].T
        tall = max(tall, float(np.percentile(points[..., 1].max(axis=1), 95)))
        wide = max(wide, float(np.percentile(np.abs(points[..., 0]).max(axis=1), 95)))
    return min((_CELL[1] - 26) / tall, 1.3 * _CELL[0] / _MOMENTS / (2 * wide))


def _centered(poses: Array) -> Array:
    """Poses with the root over the origin, heights kept."""
    out = np.array(poses)
    out[..., :2] -= poses[:, :1, :2]
    return out


def _strip(
    member: Member,
    unvaried: Member,
    figure: tuple[Bone, ...],
    axes: Array,
    scale: float,
    ground: bool,
) -> Any:
    from PIL import Image, ImageDraw

    fine = 2  # drawn larger and reduced: smooth edges
    size = (_CELL[0] * fine, _CELL[1] * fine)
    image = Image.new("RGB", size, _CARD)
    pen = ImageDraw.Draw(image)
    floor = size[1] - 16 * fine
    if ground:
        pen.rectangle((0, floor, size[0], size[1]), fill=_FLOOR)
    for k in range(_MOMENTS):
        share = (k + 0.5) / _MOMENTS
        at = (size[0] * share, floor)
        for one, color in ((unvaried, _GHOST), (member, None)):
            if color and one is member:  # nothing to compare the unvaried motion with
                continue
            poses = one.poses
            frame = min(int(share * len(poses)), len(poses) - 1)
            seen = _centered(np.asarray(poses[frame : frame + 1], float))[0] @ axes.T
            _draw(pen, seen, figure, at, scale * fine, color)
    return image.resize(_CELL, Image.Resampling.LANCZOS)


def _draw(
    pen: Any,
    seen: Array,
    figure: tuple[Bone, ...],
    at: tuple[float, float],
    scale: float,
    color: tuple[int, int, int] | None,
) -> None:
    """A pose seen from the camera, far bones first; one color makes it a silhouette."""
    depth = [-(seen[b.a, 2] + seen[b.b, 2]) for b in figure]
    for k in np.argsort(depth):
        bone = figure[k]
        a, b = seen[bone.a], seen[bone.b]
        ends = [a + share * (b - a) for share in (bone.begin, bone.end)]
        places = [(at[0] + scale * p[0], at[1] - scale * p[1]) for p in ends]
        fill = color or COLORS[bone.side]
        for grown, paint in ((1.3, None if color else _CARD), (0.0, fill)):
            if paint is None:
                continue
            r = scale * bone.radius + grown
            pen.line(places, fill=paint, width=max(1, round(2 * r)))
            for x, y in places:
                pen.ellipse((x - r, y - r, x + r, y + r), fill=paint)


def _fitting(text: str, font: Any, width: float) -> str:
    if font.getlength(text) <= width:
        return text
    while text and font.getlength(text + "…") > width:
        text = text[:-1]
    return text.rstrip() + "…"
