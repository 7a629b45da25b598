"""A web page that plays a take in 3D: one file, no network, no library.

The page holds its own WebGL 2 program (`player.html`), the surface of every body once, and a pose
per body and frame; it blends poses between frames. It opens from disk and fits into an `iframe`'s
`srcdoc`.
"""

from __future__ import annotations

import base64
import html
import json
from importlib import resources
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.files import written
from understudy.motion.rotations import Array
from understudy.output import meshes
from understudy.output.camera import BEARINGS
from understudy.output.playback import Playback, playback

if TYPE_CHECKING:
    from understudy.take import Take

_RATE = 60.0  # Hz; the page blends between frames
_MOST_POSES = 400_000  # of one body at one frame; longer takes get fewer frames a second
_ASPECT = 1.6
_AIR = 1.14  # room above the heads for the labels


def player_html(thing: Take | Clip, *, title: str | None = None, autoplay: bool = True) -> str:
    """The page as text.

    Args:
        thing: A take (with the reference beside it, where there is one), or a clip.
        title: Shown above the picture; by default the clip's name.
        autoplay: Start to play at once, unless the reader asked the browser for less motion.

    Raises:
        InvalidValue: `thing` is neither.
    """
    shown = playback(thing, rate=_RATE)
    count = shown.frames * shown.model.nbody
    if count > _MOST_POSES:
        shown = playback(thing, rate=max(_RATE * _MOST_POSES / count, 5.0))
    content = _content(shown, title or shown.name, autoplay)
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    page = resources.files("understudy.output").joinpath("player.html").read_text("utf-8")
    page = page.replace("@TITLE@", html.escape(title or shown.name), 1)
    return page.replace("@DATA@", text, 1)


def write_player(
    thing: Take | Clip, path: str | PathLike[str], *, title: str | None = None
) -> None:
    """Write the page to a file; see `player_html`."""
    text = player_html(thing, title=title)
    with written(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _content(shown: Playback, title: str, autoplay: bool) -> dict[str, Any]:
    """What the page's script reads."""
    beside = shown.beside("three-quarter")
    shots = {"none": _shot(shown.alone())}
    aside = np.zeros(3)
    if shown.ghost is not None and beside.ghost is not None:
        shots |= {"over": _shot(shown), "beside": _shot(beside)}
        first = shown.ghost_roots[0]
        aside = beside.ghost[0, first : first + 3] - shown.ghost[0, first : first + 3]
    arrays, bodies = _surfaces(shown)
    arrays["path"] = shown.smooth_path().astype("<f4")
    placed, turned = shown.poses(shown.qpos)
    arrays["positions"], arrays["rotations"] = placed.astype("<f4"), _short(turned)
    if shown.ghost is not None:
        ghost_placed, ghost_turned = shown.poses(shown.ghost)
        arrays["ghost_positions"] = ghost_placed.astype("<f4")
        arrays["ghost_rotations"] = _short(ghost_turned)
    parts, data = _packed(arrays)
    floor = meshes.planes(shown.model)
    level = bool(len(floor)) and meshes.level(shown.model, int(floor[0]))
    return {
        "name": title,
        "rate": shown.rate,
        "frames": shown.frames,
        "bodies": bodies,
        "ghost": shown.ghost is not None,
        "ground": float(shown.model.geom_pos[floor[0], 2]) if len(floor) and level else None,
        "heading": shown.heading,
        "bearings": BEARINGS,
        "aspect": _ASPECT,
        "shots": shots,
        "aside": [float(v) for v in aside],
        "travel": float(np.ptp(shown.path[:, :2], axis=0).max()),
        "labels": _labels(shown),
        "autoplay": autoplay,
        "parts": parts,
        "data": data,
    }


def _shot(shown: Playback) -> dict[str, Any]:
    """Where a following camera looks, from the smooth path, and how far away it stands [m]."""
    shot = shown.shot("follow", _ASPECT)
    center = shot.targets[0] - shown.smooth_path()[0]
    return {"center": [float(v) for v in center], "distance": _AIR * float(shot.distance)}


def _surfaces(shown: Playback) -> tuple[dict[str, np.ndarray], list[dict[str, Any]]]:
    """Arrays of corners and triangles, and for every body which triangles are its own."""
    by_body: list[list[meshes.Surface]] = [[] for _ in range(shown.model.nbody)]
    slopes = [
        tile
        for plane in meshes.planes(shown.model)
        if not meshes.level(shown.model, int(plane))
        for tile in meshes.tiles(shown.model, int(plane), shown.path.mean(axis=0))
    ]
    for surface in (*meshes.surfaces(shown.model), *slopes):
        by_body[surface.body].append(surface)
    ordered = [surface for body in by_body for surface in body]
    starts = np.cumsum([0] + [len(s.points) for s in ordered])
    bodies, at = [], 0
    for number, held in enumerate(by_body):
        count = sum(s.triangles.size for s in held)
        bodies.append({"start": at, "count": count, "ghost": number in shown.ghost_bodies})
        at += count
    empty = np.zeros((0, 3))
    points = np.concatenate([s.points for s in ordered] or [empty])
    normals = np.concatenate([s.normals for s in ordered] or [empty])
    colors = [np.broadcast_to(s.color, (len(s.points), 4)) for s in ordered] or [np.zeros((0, 4))]
    triangles = [s.triangles + n for s, n in zip(ordered, starts, strict=False)] or [empty]
    return {
        "points": points.astype("<f4"),
        "normals": np.round(127 * normals).astype("i1"),
        "colors": np.round(255 * np.concatenate(colors)).astype("u1"),
        "indices": np.concatenate(triangles).astype("<u4"),
    }, bodies


def _labels(shown: Playback) -> list[dict[str, Any]]:
    """A tag above the first performer and its ghost that says which one it is."""
    if shown.ghost is None:
        return []
    held, points = meshes.outline(shown.model)
    mine = np.isin(held, shown.ghost_bodies)
    placed, turned = shown.poses(shown.qpos[:1])
    tops = placed[0, held[mine]] + rot.rotate(turned[0, held[mine]], points[mine])
    root = shown.ghost_bodies[0]
    above = float(tops[:, 2].max() - placed[0, root, 2]) + 0.08
    return [
        {"body": int(root), "text": text, "ghost": ghost, "height": above}
        for text, ghost in zip(shown.labels, (False, True), strict=True)
    ]


def _short(rotations: Array) -> np.ndarray:
    """Unit quaternions in 16-bit numbers: an error of at most 0.003 degrees."""
    return np.round(32767 * np.clip(rotations, -1.0, 1.0)).astype("<i2")


def _packed(arrays: dict[str, np.ndarray]) -> tuple[dict[str, tuple[int, int]], str]:
    """Arrays in one base64 text, and where each begins [bytes] and how many numbers it has."""
    parts, blocks, at = {}, [], 0
    for name, array in arrays.items():
        block = np.ascontiguousarray(array).tobytes()
        parts[name] = (at, int(array.size))
        block += b"\0" * (-len(block) % 4)
        blocks.append(block)
        at += len(block)
    return parts, base64.b64encode(b"".join(blocks)).decode("ascii")
