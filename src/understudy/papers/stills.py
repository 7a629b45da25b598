"""Rigid bodies drawn as rounded lines in SVG: stills of takes, side by side, one camera."""

from __future__ import annotations

import html as markup
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.take import Take

_AZIMUTH, _ELEVATION = np.radians(-35.0), np.radians(8.0)
_SCALE = 100.0  # drawing units per meter
STYLE = """
.stills{margin:0 0 1.6rem}
.stills .row{display:flex;flex-wrap:wrap;gap:.5rem}
.stills .row figure{margin:0;flex:1 1 0;min-width:7.5rem}
.stills .row svg{display:block;width:100%;background:var(--panel);border-radius:.3rem}
.stills .row figcaption{font-size:.75rem;color:var(--dim);text-align:center}
.stills h4{margin:.5rem 0 .2rem;font-size:.8125rem;font-weight:600}
.still line,.still circle{stroke-linecap:round}
.still .ghost{stroke:var(--dim);opacity:.45}
.still .left{stroke:var(--c1);fill:var(--c1)}.still .right{stroke:var(--c0);fill:var(--c0)}
.still .middle{stroke:var(--ink);fill:var(--ink)}
.still circle{stroke:none}
"""


@dataclass(frozen=True, kw_only=True)
class Strip:
    """Stills of one take.

    Attributes:
        title: What it is.
        take: A driven linkage.
        times: Moments to show [s].
    """

    title: str
    take: Take = field(repr=False)
    times: tuple[float, ...]


def strips_html(strips: Sequence[Strip], *, alt: str) -> str:
    """Rows of stills, the clip's own pose in gray behind each; an HTML figure.

    All are seen from one direction, at one size, each centered on the clip's root.
    """
    drawn = [(strip, [_lines(strip.take, time) for time in strip.times]) for strip in strips]
    first = strips[0].take.references[0]
    assert first is not None
    axes = view_axes(first)
    spots = np.concatenate(
        [
            np.concatenate((d.ghost.reshape(-1, 3), d.body.reshape(-1, 3)))
            for _, ds in drawn
            for d in ds
        ]
    )
    height = _stature(first)
    # What flies off is cut at twice the body's height.
    flat = np.clip(spots @ axes[:2].T, [-height, -2 * height], [height, 2 * height])
    low, high = flat.min(axis=0) - 0.1, flat.max(axis=0) + 0.1
    box = (_SCALE * low[0], -_SCALE * high[1], *(_SCALE * (high - low)))
    rows = []
    for strip, moments in drawn:
        panels = "".join(
            f"<figure>{_svg(moment, axes, box)}<figcaption>{time:.2f} s</figcaption></figure>"
            for moment, time in zip(moments, strip.times, strict=True)
        )
        rows.append(f'<h4>{markup.escape(strip.title)}</h4><div class="row">{panels}</div>')
    label = markup.escape(alt, quote=True)
    return f'<div class="stills" role="img" aria-label="{label}">{"".join(rows)}</div>'


def view_axes(clip: Clip) -> Array:
    """Right, up and depth of a three-quarter camera before the first frame, as rows (3, 3)."""
    p = clip.forward_kinematics().positions[0]
    names = [name.lower() for name in clip.skeleton.names]

    def mean(side: str) -> Array:
        chosen = [k for k, name in enumerate(names) if name.startswith(side)]
        return p[chosen].mean(axis=0) if chosen else np.zeros(3)

    across = mean("left") - mean("right")
    heading = np.arctan2(-across[0], across[1]) if np.any(across[:2]) else 0.0
    bearing = heading + _AZIMUTH
    flat = np.cos(_ELEVATION)
    to_camera = np.array([flat * np.cos(bearing), flat * np.sin(bearing), np.sin(_ELEVATION)])
    right = np.array([-np.sin(bearing), np.cos(bearing), 0.0])
    return np.stack((right, np.cross(to_camera, right), to_camera))


@dataclass(frozen=True, eq=False)
class _Moment:
    """Lines of the body and of the clip's pose about its root; there is no floor to draw."""

    body: Array  # (bodies, 2, 3)
    ghost: Array  # (bones, 2, 3)
    radii: Array
    sides: tuple[str, ...]


def _lines(take: Take, time: float) -> _Moment:
    linkage, reference = take.scene.characters[0], take.references[0]
    assert reference is not None
    step = min(round(time * take.rate), take.frames - 1)
    frame = min(round(time * reference.rate), reference.frames - 1)
    placed, turned = linkage.poses(take.qpos[step : step + 1, take.scene.parts[0].qpos])
    starts = (placed + rot.rotate(turned, linkage.anchors))[0]
    ends = (placed + rot.rotate(turned, linkage.ends))[0]
    pose = reference.forward_kinematics().positions
    root = pose[frame, 0] * [1.0, 1.0, 0.0]
    parents = list(linkage.skeleton.parents)
    ghost = np.stack((pose[frame, [max(p, 0) for p in parents]], pose[frame]), axis=1)
    sides = tuple(_side(name.lower()) for name in linkage.names)
    body = np.stack((starts, ends), axis=1) - root
    return _Moment(body, ghost - root, linkage.radii, sides)


def _side(name: str) -> str:
    """Left, right or middle; the bones from the spine to shoulders and hips are in the middle."""
    if "shoulder" in name or "hipjoint" in name or name.startswith(("low", "root")):
        return "middle"
    return "left" if name.startswith("l") else "right" if name.startswith("r") else "middle"


def _stature(clip: Clip) -> float:
    return float(np.ptp(clip.skeleton.rest_positions(), axis=0).max())


def _svg(moment: _Moment, axes: Array, box: tuple[float, float, float, float]) -> str:
    def flat(points: Array) -> Array:
        return _SCALE * (points @ axes[:2].T) * [1.0, -1.0]

    parts = []
    for a, b in flat(moment.ghost):
        parts.append(
            f'<line class="ghost" stroke-width="1.5" x1="{a[0]:.1f}" y1="{a[1]:.1f}" '
            f'x2="{b[0]:.1f}" y2="{b[1]:.1f}"/>'
        )
    depth = moment.body.mean(axis=1) @ axes[2]
    lines = flat(moment.body)
    for k in np.argsort(depth):
        (a, b), r = lines[k], _SCALE * moment.radii[k]
        if not np.isfinite(lines[k]).all() or np.abs(lines[k]).max() > 1e5:
            continue
        if np.linalg.norm(moment.body[k, 1] - moment.body[k, 0]) < 1e-6:
            parts.append(
                f'<circle class="{moment.sides[k]}" cx="{a[0]:.1f}" cy="{a[1]:.1f}" '
                f'r="{1.4 * r:.1f}"/>'
            )
        else:
            parts.append(
                f'<line class="{moment.sides[k]}" stroke-width="{2 * r:.1f}" x1="{a[0]:.1f}" '
                f'y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}"/>'
            )
    shape = " ".join(f"{number:.1f}" for number in box)
    return f'<svg class="still" viewBox="{shape}" aria-hidden="true">{"".join(parts)}</svg>'
