"""Pictures without any graphics library: rays through the engine's own geometry.

`mj_multiRay` finds what every ray hits, whatever the shape; NumPy shades it. Rays are cast only
where a body can be, the ground and the sky are closed forms, and only pixels on an edge are cast
again with more rays, so that stills look smooth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from understudy.motion.rotations import Array
from understudy.output import meshes
from understudy.output.camera import Camera
from understudy.output.rays import LAMP_DISTANCE, ShadowMap, Shapes
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
# Offsets of the extra rays through an edge pixel [pixels]: a rotated grid.
_SUBPIXELS = np.array([[-0.125, -0.375], [0.375, -0.125], [-0.375, 0.125], [0.125, 0.375]])


@dataclass(frozen=True)
class _View:
    """Rays and all that does not change while the camera only moves.

    `ground` numbers the rays that fall toward the ground; `distance`, `place` and `size` tell how
    far along they meet a ground one meter below, where, and how wide a pixel is there [m].
    """

    rays: Array
    sky: np.ndarray
    ground: np.ndarray
    distance: np.ndarray
    place: np.ndarray
    size: np.ndarray


class RayCaster:
    """Draws a model with rays; needs nothing but the engine and NumPy.

    Attributes:
        name: "raycast".
    """

    name = "raycast"

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
        self._body = Shapes(model)
        self._ghost = Shapes(model, ghost_bodies)
        plane = meshes.planes(model)
        self._plane = int(plane[0]) if len(plane) else None
        self._shadow: ShadowMap | None = None
        self._kept: tuple[bytes, _View] | None = None
        self._light = np.array([0.0, 0.0, 1.0])
        self._body.pose(np.array(model.qpos0))

    def __enter__(self) -> RayCaster:
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
        self._shadow = self._cast_shadow()
        width, height = self.width, self.height
        view = self._whole(camera)
        color = self._background(view, camera)
        label = np.zeros(width * height, np.int32)
        area = np.zeros((height, width), bool)
        for body, _ in bodies:
            area |= self._bounds(body, camera)
        inside = np.flatnonzero(area)
        color[inside], label[inside] = self._over(color[inside], view.rays[inside], camera, bodies)
        edge = np.flatnonzero(edges(label.reshape(height, width)))
        if len(edge):
            color[edge] = self._smooth(
                (edge % width).astype(float) + 0.5,
                (edge // width).astype(float) + 0.5,
                camera,
                bodies,
            )
        return to_bytes(color).reshape(height, width, 3)

    def _smooth(self, x: Array, y: Array, camera: Camera, bodies: list) -> Array:
        """The mean color of several rays through each pixel (n,)."""
        many_x = (x[:, None] + _SUBPIXELS[:, 0]).ravel()
        many_y = (y[:, None] + _SUBPIXELS[:, 1]).ravel()
        view = self._view(many_x, many_y, camera)
        color, _ = self._over(self._background(view, camera), view.rays, camera, bodies)
        return color.reshape(len(x), len(_SUBPIXELS), 3).mean(axis=1)

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
        return _View(rays, _small(sky), down, _small(distance), _small(place), _small(size))

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
        if height <= 0.0 or not len(view.ground):
            return color
        offset = camera.position - self._body.data.geom_xpos[self._plane]
        place = height * view.place + (offset @ self._ground_frame[:, :2]).astype(np.float32)
        mix = checker(place / _TILE, view.size * (height / _TILE))[:, None]
        normal = self._ground_frame[:, 2][None]
        open_light = lighting(normal, np.ones(1), self._light)
        dark, bright = (TILES[1] * open_light).astype(np.float32), TILES[0] * open_light
        tile = dark + mix * (bright - dark).astype(np.float32)
        if self._shadow is not None:
            inside, light = self._shadow.light(place)
            shaded = lighting(np.broadcast_to(normal, (len(inside), 3)), light, self._light)
            tile[inside] *= shaded / open_light
        fog = np.exp(np.minimum(4.0 - height * view.distance, 0.0) * np.float32(_FOG))[:, None]
        tile -= view.sky[view.ground]
        tile *= fog
        color[view.ground] += tile
        return color

    def _over(
        self, color: Array, rays: Array, camera: Camera, bodies: list
    ) -> tuple[Array, np.ndarray[Any, np.dtype[np.int32]]]:
        """Colors with the bodies drawn over them, and a label that differs where surfaces do."""
        nearest = np.full(len(rays), np.inf)
        height = self._above_ground(camera)
        if height > 0.0:
            fall = -(rays @ self._ground_frame[:, 2])
            nearest = np.where(fall > 1e-6, height / np.maximum(fall, 1e-6), np.inf)
        label = np.zeros(len(rays), np.int32)
        for number, (body, opacity) in enumerate(bodies):
            found = body.cast(camera.position, rays)
            hit = np.flatnonzero((found.geom >= 0) & (found.distance < nearest))
            if not len(hit):
                continue
            normal, geom = found.normal[hit], found.geom[hit]
            if number == 0:
                point = camera.position + found.distance[hit, None] * rays[hit]
                lit = self._lit(point, normal)
                paint = body.paint[geom] * lighting(normal, lit, self._light)
                paint += shine(normal, rays[hit], self._light)
                color[hit] = paint
                # Where the two bodies coincide, the simulated one is seen.
                nearest[hit] = found.distance[hit] - _GHOST_DEPTH
                label[hit] = 2 * (body.model.geom_bodyid[geom] + 1) + (lit < 0.5)
            else:
                facing = np.abs(np.einsum("ij,ij->i", normal, rays[hit]))
                paint = GHOST * lighting(normal, np.ones(len(hit)), self._light)
                weight = (opacity * (0.85 + 0.6 * (1.0 - facing) ** 2)).clip(0.0, 1.0)[:, None]
                color[hit] += (paint - color[hit]) * weight
                label[hit] += 100_000 * (body.model.geom_bodyid[geom] + 1)
        return color, label

    def _lit(self, points: Array, normals: Array) -> Array:
        """How much of the lamp reaches points on the body, 0 or 1, shape (n,)."""
        light = np.ones(len(points))
        facing = np.flatnonzero(normals @ self._light > 0.0)
        if not (self._shadows and len(facing)):
            return light
        lamp = self._body.centers.mean(axis=0) + LAMP_DISTANCE * self._light
        rays = points[facing] - lamp
        distance = np.linalg.norm(rays, axis=1)
        found = self._body.cast(lamp, rays / distance[:, None])
        blocked = (found.geom >= 0) & (found.distance < distance - 0.008)
        # Fade the cast shadow where the surface turns away, which hides its jagged border.
        slope = np.clip((normals[facing] @ self._light) / 0.25, 0.0, 1.0)
        light[facing[blocked]] = 1.0 - slope[blocked]
        return light

    def _bounds(self, body: Shapes, camera: Camera) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Pixels in which a body can be: the boxes around its shapes' bounding spheres."""
        area = np.zeros((self.height, self.width), bool)
        if not len(body.geoms):
            return area
        at, depth = camera.project(body.centers, self.width, self.height)
        reach = body.radii + 1e-3
        near = np.maximum(depth - reach, 0.05)
        slope = 0.5 * self.height / np.tan(0.5 * camera.field_of_view)
        # A sphere seen off the axis is stretched outward; 1.25 covers it within 60 degrees.
        radius = 1.25 * reach * slope / near + 2.0
        low = np.clip(np.floor(at - radius[:, None]), 0, (self.width, self.height)).astype(int)
        high = np.clip(np.ceil(at + radius[:, None]), 0, (self.width, self.height)).astype(int)
        for (x0, y0), (x1, y1), ahead in zip(low, high, depth + reach > 0.0, strict=True):
            if ahead:
                area[y0:y1, x0:x1] = True
        return area

    def _cast_shadow(self) -> ShadowMap | None:
        """The bodies' shadow on the ground; a ghost casts none."""
        if not self._shadows or self._plane is None or not len(self._body.geoms):
            return None
        origin = self._body.data.geom_xpos[self._plane]
        return ShadowMap.cast(self._body, self._light, self._ground_frame, origin)


def _small(values: Array) -> np.ndarray:
    """The same in 32 bits, which halve the time of a background and suffice for colors."""
    return values.astype(np.float32)
