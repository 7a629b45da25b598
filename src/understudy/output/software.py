"""Pictures without any graphics library, by NumPy alone.

The bodies' triangles are drawn with a depth buffer, the ground and the sky are closed forms, and
only pixels on an edge are drawn again with more samples, so that stills look smooth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from understudy.motion.rotations import Array
from understudy.output import meshes
from understudy.output.camera import Camera
from understudy.output.raster import Seen, Shadows, Shapes
from understudy.output.shading import (
    GHOST,
    HORIZON,
    TILES,
    TOP,
    checker,
    edges,
    lamp,
    lighting,
    shine,
    to_bytes,
)

_TILE = 0.5  # m
_FOG = 0.018  # 1/m; the ground fades into the horizon
_GHOST_DEPTH = 0.04  # m; a ghost tints the body only where it is this much nearer
# Where the extra samples of an edge pixel lie [pixels]: a rotated grid.
_SAMPLES = ((-0.125, -0.375), (0.375, -0.125), (-0.375, 0.125), (0.125, 0.375))


@dataclass(frozen=True)
class _View:
    """Rays and all that does not change while the camera only moves.

    `ground` selects the rays that fall toward the ground; `distance`, `place` and `size` tell how
    far along they meet a ground one meter below, where, and how wide a pixel is there [m].
    """

    rays: Array
    sky: np.ndarray
    ground: slice | np.ndarray
    distance: np.ndarray
    place: np.ndarray
    size: np.ndarray


class SoftwareRenderer:
    """Draws a model with nothing but NumPy.

    Attributes:
        name: "software".
    """

    name = "software"

    def __init__(
        self,
        model: mujoco.MjModel,
        width: int,
        height: int,
        *,
        shadows: bool = True,
        ghost_bodies: tuple[int, ...] = (),
    ):
        self.width, self.height, self._shadows = width, height, shadows
        surfaces = meshes.surfaces(model)
        self._body = Shapes(model, surfaces)
        self._ghost = Shapes(model, [s for s in surfaces if s.body in ghost_bodies])
        plane = meshes.planes(model)
        self._plane = int(plane[0]) if len(plane) else None
        self._shadow: Shadows | None = None
        self._kept: tuple[bytes, _View] | None = None
        self._light = np.array([0.0, 0.0, 1.0])
        self._body.pose(np.array(model.qpos0))

    def __enter__(self) -> SoftwareRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Nothing to give back."""

    def picture(
        self, qpos: Array, camera: Camera, *, ghost: Array | None = None, opacity: float = 0.4
    ) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """One picture, uint8, shape (height, width, 3).

        Args:
            qpos: The scene's pose, shape (nq,).
            camera: Where it is seen from.
            ghost: A second pose of the ghost bodies, drawn translucent, shape (nq,).
            opacity: How solid the ghost is, 0..1.
        """
        self._light = lamp(camera)
        self._body.pose(qpos)
        bodies = [(self._body, 1.0)]
        if ghost is not None:
            self._ghost.pose(ghost)
            bodies.append((self._ghost, opacity))
        self._shadow = Shadows(self._body, self._light) if self._shadows else None
        width, height = self.width, self.height
        view = self._whole(camera)
        found = [body.seen(camera, width, height) for body, _ in bodies]
        color = self._background(view, camera)
        label = self._draw(color, view.rays, camera, found, opacity)
        edge = np.flatnonzero(edges(label.reshape(height, width)))
        if len(edge):
            color[edge] = self._smooth(edge, camera, bodies, opacity)
        return to_bytes(color).reshape(height, width, 3)

    def _smooth(self, edge: np.ndarray, camera: Camera, bodies: list, opacity: float) -> Array:
        """The mean color of several samples in each of some pixels, shape (n, 3)."""
        width, height = self.width, self.height
        wanted = np.zeros(width * height, bool)
        wanted[edge] = True
        place = np.zeros(width * height, np.int64)
        place[edge] = np.arange(len(edge))
        total = np.zeros((len(edge), 3))
        for shift in _SAMPLES:
            x, y = edge % width + 0.5 + shift[0], edge // width + 0.5 + shift[1]
            view = self._view(x, y, camera)
            found = []
            for body, _ in bodies:
                seen = body.seen(camera, width, height, shift=shift, wanted=wanted)
                found.append(replace(seen, pixel=place[seen.pixel]))
            color = self._background(view, camera)
            self._draw(color, view.rays, camera, found, opacity)
            total += color
        return total / len(_SAMPLES)

    def _whole(self, camera: Camera) -> _View:
        """The rays of every pixel; kept while the camera only moves and does not turn."""
        key = camera.axes.tobytes() + bytes(str(camera.field_of_view), "ascii")
        if self._kept is None or self._kept[0] != key:
            x, y = np.meshgrid(np.arange(0.5, self.width), np.arange(0.5, self.height))
            self._kept = (key, self._view(x.ravel(), y.ravel(), camera))
        return self._kept[1]

    def _view(self, x: Array, y: Array, camera: Camera) -> _View:
        """Rays through pixel coordinates (n,), and what they see of a ground one meter below."""
        tangent = np.tan(0.5 * camera.field_of_view) / (0.5 * self.height)
        right, up, forward = camera.axes
        rays = (
            forward
            + ((x - 0.5 * self.width) * tangent)[:, None] * right
            - ((y - 0.5 * self.height) * tangent)[:, None] * up
        )
        rays /= np.sqrt(np.einsum("ij,ij->i", rays, rays))[:, None]
        if self._plane is None:
            blend = 1.0 - np.exp(-3.0 * np.abs(rays[:, 2:]))
            ends = np.where(rays[:, 2:] > 0.0, TOP, TILES[0] * 0.9)
            sky = HORIZON + (ends - HORIZON) * blend
            nothing = np.zeros(0)
            return _View(
                rays, _small(sky), np.zeros(0, np.int64), nothing, rays[:0, :2], rays[:0, :2]
            )
        sky = HORIZON + (TOP - HORIZON) * (1.0 - np.exp(-3.2 * np.clip(rays[:, 2:], 0.0, 1.0)))
        frame = self._ground_frame
        fall = -(rays @ frame[:, 2])
        down = np.flatnonzero(fall > 1e-4)
        distance = 1.0 / fall[down]
        place = (rays[down] @ frame[:, :2]) * distance[:, None]
        # How far the point on the ground moves from one pixel to the next.
        size = (
            np.abs(right @ frame[:, :2])
            + np.abs(place) * np.abs(up @ frame[:, 2])
            + np.abs(up @ frame[:, :2])
        ) * (2.0 * np.tan(0.5 * camera.field_of_view) / self.height * distance)[:, None]
        # Under a level camera the ground fills the last rows: a slice costs no copies.
        level = len(down) > 0 and len(down) == len(rays) - down[0]
        ground = slice(int(down[0]), len(rays)) if level else down
        return _View(rays, _small(sky), ground, _small(distance), _small(place), _small(size))

    @property
    def _ground_frame(self) -> Array:
        return self._body.data.geom_xmat[self._plane].reshape(3, 3)

    def _above_ground(self, camera: Camera) -> float:
        """Height of the camera over the ground plane [m]; zero or less when below or without."""
        if self._plane is None:
            return 0.0
        offset = camera.position - self._body.data.geom_xpos[self._plane]
        return float(offset @ self._ground_frame[:, 2])

    def _background(self, view: _View, camera: Camera) -> Array:
        """Linear colors (n, 3) of the sky and the ground."""
        color, height = view.sky.copy(), self._above_ground(camera)
        if height <= 0.0 or not len(view.distance):
            return color
        offset = camera.position - self._body.data.geom_xpos[self._plane]
        place = height * view.place + (offset @ self._ground_frame[:, :2]).astype(np.float32)
        mix = checker(place / _TILE, view.size * (height / _TILE))[:, None]
        normal = self._ground_frame[:, 2][None]
        open_light = lighting(normal, np.ones(1), self._light)
        dark, bright = (TILES[1] * open_light).astype(np.float32), TILES[0] * open_light
        tile = dark + mix * (bright - dark).astype(np.float32)
        if self._shadow is not None:
            frame, origin = self._ground_frame, self._body.data.geom_xpos[self._plane]
            middle, reach = self._shadow.bounds(0.0, frame[:, 2], origin)
            around = place - ((middle - origin) @ frame[:, :2]).astype(np.float32)
            inside = np.flatnonzero((np.abs(around) < reach).all(axis=1))
            light = self._shadow.on_ground(place[inside] @ frame[:, :2].T + origin)
            shaded = lighting(np.broadcast_to(normal, (len(inside), 3)), light, self._light)
            tile[inside] *= shaded / open_light
        fog = np.exp(np.minimum(4.0 - height * view.distance, 0.0) * np.float32(_FOG))[:, None]
        tile -= view.sky[view.ground]
        tile *= fog
        color[view.ground] += tile
        return color

    def _draw(
        self, color: Array, rays: Array, camera: Camera, found: list[Seen], opacity: float
    ) -> np.ndarray[Any, np.dtype[np.int32]]:
        """Draw the body, then its ghost, over `color`; a label that differs where surfaces do."""
        nearest = np.full(len(rays), np.inf)
        height = self._above_ground(camera)
        if height > 0.0:
            fall = -(rays @ self._ground_frame[:, 2])
            nearest = np.where(fall > 1e-6, height / np.maximum(fall, 1e-6), np.inf)
        label = np.zeros(len(rays), np.int32)
        for ghost, seen in enumerate(found):
            distance = np.linalg.norm(seen.point - camera.position, axis=1)
            hit = np.flatnonzero(distance < nearest[seen.pixel])
            at, normal, part = seen.pixel[hit], seen.normal[hit], seen.part[hit]
            if not ghost:
                lit = np.ones(len(hit))
                if self._shadow is not None:
                    lit = self._shadow.on_body(seen.point[hit], normal)
                paint = seen.paint[hit] * lighting(normal, lit, self._light)
                color[at] = paint + shine(normal, rays[at], self._light)
                # Where the two bodies coincide, the simulated one is seen.
                nearest[at] = distance[hit] - _GHOST_DEPTH
                label[at] = part + 1
            else:
                facing = np.abs(np.einsum("ij,ij->i", normal, rays[at]))
                paint = GHOST * lighting(normal, np.ones(len(hit)), self._light)
                weight = (opacity * (0.85 + 0.6 * (1.0 - facing) ** 2)).clip(0.0, 1.0)[:, None]
                color[at] += (paint - color[at]) * weight
                label[at] += 100_000 * (part + 1)
        return label


def _small(values: Array) -> np.ndarray:
    """The same in 32 bits, which halve the time of a background and suffice for colors."""
    return values.astype(np.float32)
