"""Pictures without any graphics library: rays through the engine's own geometry.

`mj_multiRay` finds what every ray hits, whatever the shape; NumPy shades it. Rays are cast only
where a body can be, the ground and the sky are closed forms, and only pixels on an edge are cast
again with more rays, so that stills look smooth.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from understudy.motion.rotations import Array
from understudy.output import meshes
from understudy.output.camera import Camera

_LIGHT_DISTANCE = 40.0  # m; far enough that its rays are nearly parallel
_SUN = np.array([1.0, 0.96, 0.90]) * 0.78
_SKY = np.array([0.50, 0.58, 0.70]) * 0.62  # ambient light from above
_BOUNCE = np.array([0.42, 0.40, 0.38]) * 0.42  # ambient light from the ground
_TOP, _HORIZON = np.array([0.38, 0.52, 0.72]), np.array([0.84, 0.89, 0.94])  # sky, linear
_TILES = np.array([[0.50, 0.53, 0.56], [0.42, 0.45, 0.48]])  # ground, linear
_TILE = 0.5  # m
_FOG = 0.018  # 1/m; the ground fades into the horizon
_TEXEL = 0.014  # m; resolution of the shadow on the ground
_GHOST = np.array([0.16, 0.42, 0.85])  # linear
_GHOST_DEPTH = 0.04  # m; a ghost tints the body only where it is this much nearer
_HIDDEN = 5
# Offsets of the extra rays through an edge pixel [pixels]: a rotated grid.
_SUBPIXELS = np.array([[-0.125, -0.375], [0.375, -0.125], [-0.375, 0.125], [0.125, 0.375]])


@dataclass
class _Hits:
    """What rays found: geometry (-1: nothing), distance [m], normal."""

    geom: np.ndarray[Any, np.dtype[np.int32]]
    distance: Array
    normal: Array


@dataclass(frozen=True)
class _View:
    """Rays and all that does not change while the camera only moves.

    `ground` numbers the rays that fall toward the ground; `distance`, `place` and `size` tell how
    far along they meet a ground one meter below, where, and how wide a pixel is there [m].
    """

    rays: Array
    sky: Array
    ground: np.ndarray
    distance: Array
    place: Array
    size: Array


class _Body:
    """The shown shapes of a model, posed, for casting rays; ground planes left out."""

    def __init__(self, model: mujoco.MjModel, bodies: tuple[int, ...] | None = None):
        self.model = copy.copy(model)
        seen = meshes.shown(model) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE)
        if bodies is not None:
            seen &= np.isin(model.geom_bodyid, bodies)
        self.model.geom_group[:] = np.where(seen, 0, _HIDDEN)
        self.geoms = np.flatnonzero(seen)
        self.radii = np.array(model.geom_rbound[self.geoms], float)
        self.data = mujoco.MjData(self.model)
        self._groups = np.array([1, 1, 1, 1, 1, 0], np.uint8)
        self.paint = _linear(meshes.colors(model)[:, :3])

    def pose(self, qpos: Array) -> None:
        self.data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, self.data)

    @property
    def centers(self) -> Array:
        return self.data.geom_xpos[self.geoms]

    def cast(self, origin: Array, rays: Array) -> _Hits:
        """What unit vectors `rays` (n, 3) from one point hit."""
        n = len(rays)
        geom = np.full(n, -1, np.int32)
        distance, normal = np.full(n, -1.0), np.zeros(3 * n)
        if n and len(self.geoms):
            mujoco.mj_multiRay(
                self.model,
                self.data,
                np.asarray(origin, float),
                np.ascontiguousarray(rays, float).ravel(),
                self._groups,
                True,
                -1,
                geom,
                distance,
                normal,
                n,
                mujoco.mjMAXVAL,
            )
        return _Hits(geom, distance, normal.reshape(-1, 3))


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
        self._body = _Body(model)
        self._ghost = _Body(model, ghost_bodies)
        plane = meshes.planes(model)
        self._plane = int(plane[0]) if len(plane) else None
        self._shadow: _ShadowMap | None = None
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
        self._light = _lamp(camera)
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
        edge = np.flatnonzero(_edges(label.reshape(height, width)))
        if len(edge):
            color[edge] = self._smooth(edge % width + 0.5, edge // width + 0.5, camera, bodies)
        return _bytes(color).reshape(height, width, 3)

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
            x, y = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
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
            ends = np.where(rays[:, 2:] > 0.0, _TOP, _TILES[0] * 0.9)
            sky = _HORIZON + (ends - _HORIZON) * blend
            nothing = np.zeros(0)
            return _View(rays, sky, np.zeros(0, np.int64), nothing, rays[:0, :2], rays[:0, :2])
        sky = _HORIZON + (_TOP - _HORIZON) * (1.0 - np.exp(-3.2 * np.clip(rays[:, 2:], 0.0, 1.0)))
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
        return _View(rays, sky, down, distance, place, size)

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
        place = offset @ self._ground_frame[:, :2] + height * view.place
        mix = _checker(place / _TILE, view.size * (height / _TILE))[:, None]
        normal = np.broadcast_to(self._ground_frame[:, 2], (1, 3))
        tile = _TILES[1] + (_TILES[0] - _TILES[1]) * mix
        tile *= self._lighting(normal, np.ones(1))
        if self._shadow is not None:
            inside, light = self._shadow.light(place)
            shaded = self._lighting(np.broadcast_to(normal, (len(inside), 3)), light)
            tile[inside] *= shaded / self._lighting(normal, np.ones(1))
        fog = np.exp(-_FOG * np.maximum(height * view.distance - 4.0, 0.0))[:, None]
        tile -= color[view.ground]
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
                paint = body.paint[geom] * self._lighting(normal, lit)
                paint += self._shine(normal, rays[hit])
                color[hit] = paint
                # Where the two bodies coincide, the simulated one is seen.
                nearest[hit] = found.distance[hit] - _GHOST_DEPTH
                label[hit] = 2 * (body.model.geom_bodyid[geom] + 1) + (lit < 0.5)
            else:
                facing = np.abs(np.einsum("ij,ij->i", normal, rays[hit]))
                paint = _GHOST * self._lighting(normal, np.ones(len(hit)))
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
        lamp = self._body.centers.mean(axis=0) + _LIGHT_DISTANCE * self._light
        rays = points[facing] - lamp
        distance = np.linalg.norm(rays, axis=1)
        found = self._body.cast(lamp, rays / distance[:, None])
        blocked = (found.geom >= 0) & (found.distance < distance - 0.008)
        # Fade the cast shadow where the surface turns away, which hides its jagged border.
        slope = np.clip((normals[facing] @ self._light) / 0.25, 0.0, 1.0)
        light[facing[blocked]] = 1.0 - slope[blocked]
        return light

    def _bounds(self, body: _Body, camera: Camera) -> np.ndarray[Any, np.dtype[np.bool_]]:
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

    def _cast_shadow(self) -> _ShadowMap | None:
        """The bodies' shadow on the ground; a ghost casts none."""
        if not self._shadows or self._plane is None or not len(self._body.geoms):
            return None
        origin = self._body.data.geom_xpos[self._plane]
        return _ShadowMap.cast(self._body, self._light, self._ground_frame, origin)

    def _lighting(self, normals: Array, lit: Array) -> Array:
        """Light that a matte white surface sends back, shape (n, 3); `lit` (n,) is 0 in shadow."""
        up = (0.5 + 0.5 * normals[:, 2])[:, None]
        ambient = _BOUNCE + (_SKY - _BOUNCE) * up
        # Wrapped around a little, as from a large lamp.
        sun = np.clip((normals @ self._light + 0.15) / 1.15, 0.0, 1.0) * lit
        return ambient + _SUN * sun[:, None]

    def _shine(self, normals: Array, rays: Array) -> Array:
        """A soft highlight and a brighter rim, shape (n, 3)."""
        facing = -np.einsum("ij,ij->i", normals, rays)
        halfway = self._light - rays
        halfway /= np.linalg.norm(halfway, axis=1)[:, None]
        spot = np.clip(np.einsum("ij,ij->i", normals, halfway), 0.0, 1.0) ** 40
        rim = np.clip(1.0 - facing, 0.0, 1.0) ** 4
        return (0.10 * spot)[:, None] * _SUN + (0.10 * rim)[:, None] * _SKY


@dataclass
class _ShadowMap:
    """Light on a rectangle of the ground: a grid of values 0..1 from corner `low` on."""

    low: Array
    values: Array

    @classmethod
    def cast(
        cls, body: _Body, lamp_direction: Array, frame: Array, origin: Array
    ) -> _ShadowMap | None:
        """Cast rays from the lamp to a grid that covers the bodies' shadow, and soften it."""
        from scipy.ndimage import gaussian_filter

        lamp_up = float(lamp_direction @ frame[:, 2])
        if lamp_up < 0.1:
            return None
        relative = body.centers - origin
        height = relative @ frame[:, 2]
        spots = relative @ frame[:, :2] - (height / lamp_up)[:, None] * (
            lamp_direction @ frame[:, :2]
        )
        reach = body.radii / lamp_up + 12 * _TEXEL
        near = (np.abs(height) < 6.0) & (height > -body.radii) & (body.radii < 8.0)
        if not near.any():
            return None
        low = np.floor((spots - reach[:, None])[near].min(axis=0) / _TEXEL)
        high = np.ceil((spots + reach[:, None])[near].max(axis=0) / _TEXEL)
        count = np.minimum((high - low).astype(int), 700)
        x, y = np.meshgrid(low[0] + np.arange(count[0]), low[1] + np.arange(count[1]))
        on_ground = np.stack((x.ravel(), y.ravel()), -1) * _TEXEL @ frame[:, :2].T + origin
        lamp = body.centers[near].mean(axis=0) + _LIGHT_DISTANCE * lamp_direction
        rays = on_ground - lamp
        distance = np.linalg.norm(rays, axis=1)
        found = body.cast(lamp, rays / distance[:, None])
        blocked = ((found.geom >= 0) & (found.distance < distance)).astype(float)
        blocked = blocked.reshape(count[1], count[0])
        # A sharp shadow, and a wide faint one as the sky's light is blocked near the feet.
        dark = 0.75 * gaussian_filter(blocked, 1.1) + 0.25 * gaussian_filter(blocked, 5.0)
        return cls(low * _TEXEL, 1.0 - dark)

    def light(self, place: Array) -> tuple[np.ndarray, Array]:
        """Which points of the ground (n, 2) [m] lie on the grid, and the light there, bilinear."""
        from scipy.ndimage import map_coordinates

        at = (place - self.low) / _TEXEL
        rows, columns = self.values.shape
        inside = np.flatnonzero(
            (at[:, 0] > 0) & (at[:, 1] > 0) & (at[:, 0] < columns - 1) & (at[:, 1] < rows - 1)
        )
        return inside, map_coordinates(self.values, at[inside, ::-1].T, order=1, mode="nearest")


def _lamp(camera: Camera) -> Array:
    """Unit vector toward the lamp: behind the camera's left shoulder, high up."""
    right, _, forward = camera.axes
    back = -np.array([forward[0], forward[1], 0.0]) / max(np.hypot(forward[0], forward[1]), 1e-9)
    light = 0.42 * back - 0.40 * right + np.array([0.0, 0.0, 0.82])
    return light / np.linalg.norm(light)


def _checker(place: Array, size: Array) -> Array:
    """A checkerboard of unit tiles averaged over a box of `size`, 0..1, shape (n,).

    Closed form of the average, so that far tiles fade to gray instead of flickering.
    """
    size = np.maximum(size, 1e-4)
    halves = place * 0.5
    low, high = halves - 0.25 * size, halves + 0.25 * size
    wave = 2.0 * (np.abs(low - np.floor(low) - 0.5) - np.abs(high - np.floor(high) - 0.5)) / size
    wave = np.where(size > 4.0, 0.0, wave)
    return 0.5 - 0.5 * wave[:, 0] * wave[:, 1]


def _edges(label: np.ndarray) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Pixels whose label differs from a neighbor's."""
    edge = np.zeros(label.shape, bool)
    across, down = label[:, 1:] != label[:, :-1], label[1:] != label[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


def _linear(srgb: Array) -> Array:
    """Colors as light intensities."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def _bytes(linear: Array) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Light intensities as sRGB bytes."""
    table = np.clip(linear * 4095.0, 0.0, 4095.0).astype(np.int32)
    return _SRGB[table]


_STEPS = np.linspace(0.0, 1.0, 4096)
_SRGB = np.round(
    255.0 * np.where(_STEPS <= 0.0031308, 12.92 * _STEPS, 1.055 * _STEPS ** (1 / 2.4) - 0.055)
).astype(np.uint8)
