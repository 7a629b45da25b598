"""Triangles to pixels, in NumPy: which triangle each pixel sees, and where on it.

All triangles' boxes of pixels are laid out in one long array, tested at once, and sorted by depth.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import mujoco
import numpy as np

from understudy.motion.rotations import Array
from understudy.output import meshes
from understudy.output.camera import Camera
from understudy.output.shading import linear

_NEAR = 0.05  # m; triangles nearer to the camera are not drawn
_AT_ONCE = 3_000_000  # candidate pixels tested in one go
_TEXEL = 0.012  # m; resolution of shadows
_TEXELS = 1200  # at most, along one side
_BIAS = 0.03  # m; a surface nearer than this to what lights it does not shade it


@dataclass(frozen=True)
class Seen:
    """What some pixels see of a body: one entry per pixel that sees it.

    Attributes:
        pixel: Number of the pixel, row by row, shape (n,).
        body: Body number, shape (n,).
        part: Number of the surface, which has one color, shape (n,).
        point: Where the surface is [m], shape (n, 3).
        normal: Unit normal there, shape (n, 3).
        paint: Linear color, shape (n, 3).
    """

    pixel: np.ndarray
    body: np.ndarray
    part: np.ndarray
    point: Array
    normal: Array
    paint: Array


class Shapes:
    """Surfaces of a model, posed."""

    def __init__(self, model: mujoco.MjModel, surfaces: Iterable[meshes.Surface]):
        chosen = list(surfaces)
        starts = np.cumsum([0] + [len(s.points) for s in chosen])
        flat, none = np.zeros((0, 3)), np.zeros((0, 3), np.int64)
        self._local = np.concatenate([s.points for s in chosen] or [flat])
        self._turned = np.concatenate([s.normals for s in chosen] or [flat])
        self._carrier = np.repeat([s.body for s in chosen], np.diff(starts)).astype(int)
        self.triangles = np.concatenate(
            [s.triangles + n for s, n in zip(chosen, starts, strict=False)] or [none]
        ).astype(np.int64)
        sizes = [len(s.triangles) for s in chosen]
        colors = np.array([s.color[:3] for s in chosen]).reshape(-1, 3)
        self.paint = np.repeat(linear(colors), sizes, axis=0)
        self.body = np.repeat([s.body for s in chosen], sizes).astype(int)
        self.part = np.repeat(np.arange(len(chosen)), sizes)
        self.data, self._model = mujoco.MjData(model), model
        self.points, self.normals = self._local, self._turned

    def pose(self, qpos: Array) -> None:
        """Take a pose, shape (nq,)."""
        self.data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self.data)
        turn = self.data.xmat.reshape(-1, 3, 3)[self._carrier]
        self.points = np.einsum("nij,nj->ni", turn, self._local) + self.data.xpos[self._carrier]
        self.normals = np.einsum("nij,nj->ni", turn, self._turned)

    def seen(
        self,
        camera: Camera,
        width: int,
        height: int,
        *,
        shift: tuple[float, float] = (0.0, 0.0),
        wanted: np.ndarray | None = None,
    ) -> Seen:
        """What the pixels of a picture see.

        Args:
            camera: Where from.
            width: Width of the picture [pixels].
            height: Height of the picture [pixels].
            shift: Where in a pixel to look, from its middle [pixels].
            wanted: Which pixels are of interest, shape (height * width,); by default all.
        """
        at, depth = camera.project(self.points, width, height)
        ahead = (depth[self.triangles] > _NEAR).all(axis=1)
        at = at - np.asarray(shift)
        # Seen from outside a triangle turns clockwise in the picture, whose y points down.
        found = rasterized(
            at * [1.0, -1.0] + [0.0, height],
            1.0 / np.maximum(depth, _NEAR),
            self.triangles[ahead],
            (width, height),
            wanted=None if wanted is None else wanted.reshape(height, width)[::-1].ravel(),
        )
        pixel, triangle, weights, inverse = found
        pixel = (height - 1 - pixel // width) * width + pixel % width
        triangle = np.flatnonzero(ahead)[triangle]
        corners = self.triangles[triangle]
        true = weights / np.maximum(depth, _NEAR)[corners] / inverse[:, None]
        normal = np.einsum("nk,nki->ni", true, self.normals[corners])
        return Seen(
            pixel=pixel,
            body=self.body[triangle],
            part=self.part[triangle],
            point=np.einsum("nk,nki->ni", true, self.points[corners]),
            normal=normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-9)[:, None],
            paint=self.paint[triangle],
        )


def rasterized(
    points: Array,
    nearness: Array,
    triangles: np.ndarray,
    size: tuple[int, int],
    *,
    wanted: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, Array, Array]:
    """The nearest of the triangles that turn counter-clockwise, at the middle of every pixel.

    Args:
        points: Pixel coordinates of corners, y up, shape (corners, 2).
        nearness: Grows toward the viewer and is linear over the picture, shape (corners,).
        triangles: Corner numbers, shape (triangles, 3).
        size: Width and height [pixels].
        wanted: Which pixels are of interest, shape (height * width,); by default all.

    Returns:
        Pixel numbers, row by row from the bottom; their triangles; the weights (n, 3) of the
        corners; the nearness there.
    """
    width, height = size
    a, b, c = (points[triangles[:, k]] for k in range(3))
    double = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    low = np.ceil(np.minimum(np.minimum(a, b), c) - 0.5).clip(0, size).astype(np.int64)
    high = np.floor(np.maximum(np.maximum(a, b), c) - 0.5).clip(-1, np.array(size) - 1)
    extent = np.maximum(high.astype(np.int64) - low + 1, 0)
    count = extent[:, 0] * extent[:, 1]
    kept = np.flatnonzero((count > 0) & (double > 1e-12))
    # Weights of the first two corners as linear functions of the pixel: value, per x, per y.
    first = np.stack((b[:, 1] - c[:, 1], c[:, 0] - b[:, 0]), -1)[kept] / double[kept, None]
    second = np.stack((c[:, 1] - a[:, 1], a[:, 0] - c[:, 0]), -1)[kept] / double[kept, None]
    origin, near = c[kept], nearness[triangles[kept]]
    low, extent, count = low[kept], extent[kept], count[kept]
    parts = []
    for start, stop in _batches(count):
        number = np.repeat(np.arange(start, stop), count[start:stop])
        inside = np.arange(len(number)) - np.repeat(
            np.cumsum(count[start:stop]) - count[start:stop], count[start:stop]
        )
        row, column = np.divmod(inside, extent[number, 0])
        x, y = low[number, 0] + column, low[number, 1] + row
        if wanted is not None:
            some = wanted[y * width + x]
            number, x, y = number[some], x[some], y[some]
        dx, dy = x + 0.5 - origin[number, 0], y + 0.5 - origin[number, 1]
        u = first[number, 0] * dx + first[number, 1] * dy
        v = second[number, 0] * dx + second[number, 1] * dy
        w = 1.0 - u - v
        hit = np.flatnonzero((u >= -1e-9) & (v >= -1e-9) & (w >= -1e-9))
        number, weights = number[hit], np.stack((u[hit], v[hit], w[hit]), -1)
        parts.append(
            (
                y[hit] * width + x[hit],
                number,
                weights,
                np.einsum("nk,nk->n", weights, near[number]),
            )
        )
    if not parts:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)
    pixel, number, weights, depth = (np.concatenate(part) for part in zip(*parts, strict=True))
    best = np.full(width * height, -1, np.int64)
    order = np.argsort(depth, kind="stable")
    best[pixel[order]] = order  # the last to be written, the nearest, stays
    front = best[best >= 0]
    return pixel[front], kept[number[front]], weights[front], depth[front]


def _batches(count: np.ndarray) -> list[tuple[int, int]]:
    """Ranges of triangles with a bounded number of candidate pixels."""
    ends = np.cumsum(count)
    out, start = [], 0
    while start < len(count):
        before = ends[start - 1] if start else 0
        stop = max(int(np.searchsorted(ends, before + _AT_ONCE, side="right")), start + 1)
        out.append((start, stop))
        start = stop
    return out


class Shadows:
    """What the lamp sees: how high toward it the first surface lies, on a grid across its light.

    The grid lies still in the world, so that shadows do not shimmer.
    """

    def __init__(self, shapes: Shapes, light: Array):
        from scipy.ndimage import gaussian_filter

        side = np.cross([0.0, 0.0, 1.0], light)
        side /= np.linalg.norm(side)
        self._axes = np.stack((side, np.cross(light, side), light))
        lit = shapes.points @ self._axes.T
        span = np.ptp(lit[:, :2], axis=0).max() if len(lit) else 0.0
        self._texel = max(_TEXEL, span / _TEXELS)
        margin = 16
        low = np.floor((lit[:, :2].min(axis=0) if len(lit) else np.zeros(2)) / self._texel) - margin
        high = np.ceil((lit[:, :2].max(axis=0) if len(lit) else np.zeros(2)) / self._texel) + margin
        columns, rows = (high - low).astype(int)
        self._low = low
        pixel, _, _, top = rasterized(
            lit[:, :2] / self._texel - low, lit[:, 2], shapes.triangles, (columns, rows)
        )
        heights = np.full(rows * columns, -np.inf)
        heights[pixel] = top
        self._heights = heights.reshape(rows, columns)
        dark = np.isfinite(self._heights).astype(np.float32)
        # A sharp shadow, and a wide faint one as the sky's light is blocked near the feet.
        self._ground = 1.0 - 0.75 * gaussian_filter(dark, 1.2) - 0.25 * gaussian_filter(dark, 5.0)

    def on_ground(self, points: Array) -> Array:
        """Light on points that lie under everything, 0..1, shape (n,)."""
        from scipy.ndimage import map_coordinates

        at = points @ self._axes[:2].T / self._texel - self._low - 0.5
        return map_coordinates(
            self._ground, at[:, ::-1].T, order=1, mode="constant", cval=1.0, prefilter=False
        )

    def bounds(self, height: float, normal: Array, origin: Array) -> tuple[Array, float]:
        """Center and radius [m] of the shadow on the plane `height` along `normal` of `origin`."""
        rows, columns = self._heights.shape
        middle = (self._low + 0.5 * np.array([columns, rows])) * self._texel
        point = middle @ self._axes[:2]
        light = self._axes[2]
        fall = (origin + height * normal - point) @ normal / (light @ normal)
        radius = 0.5 * float(np.hypot(rows, columns)) * self._texel / float(light @ normal)
        return point + fall * light, radius

    def on_body(self, points: Array, normals: Array) -> Array:
        """Light on points of the bodies themselves, 0..1, shape (n,)."""
        facing = normals @ self._axes[2]
        lit = (points + 0.01 * normals) @ self._axes.T
        at = lit[:, :2] / self._texel - self._low - 0.5
        corner = np.floor(at).astype(int)
        part = at - corner
        rows, columns = self._heights.shape
        out = np.zeros(len(points))
        for dx in (0, 1):
            for dy in (0, 1):
                x = (corner[:, 0] + dx).clip(0, columns - 1)
                y = (corner[:, 1] + dy).clip(0, rows - 1)
                weight = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
                out += weight * (self._heights[y, x] < lit[:, 2] + _BIAS)
        # Surfaces that turn away get no light anyway; fading hides the jagged border there.
        fade = np.clip(facing / 0.5, 0.0, 1.0)
        return 1.0 - fade * (1.0 - out)
