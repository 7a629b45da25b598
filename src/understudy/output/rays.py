"""What rays from one point hit: the engine's shapes, and the ground in their shadow."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from understudy.motion.rotations import Array
from understudy.output import meshes
from understudy.output.shading import linear

LAMP_DISTANCE = 40.0  # m; far enough that its rays are nearly parallel
_TEXEL = 0.014  # m; resolution of the shadow on the ground
_HIDDEN = 5  # the geometry group that no ray sees


@dataclass
class Hits:
    """What rays found: geometry (-1: nothing), distance [m], normal."""

    geom: np.ndarray[Any, np.dtype[np.int32]]
    distance: Array
    normal: Array


class Shapes:
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
        self.paint = linear(meshes.colors(model)[:, :3])

    def pose(self, qpos: Array) -> None:
        """Take a pose, shape (nq,)."""
        self.data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, self.data)

    @property
    def centers(self) -> Array:
        """Centers of the shapes [m], shape (shapes, 3)."""
        return self.data.geom_xpos[self.geoms]

    def cast(self, origin: Array, rays: Array) -> Hits:
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
        return Hits(geom, distance, normal.reshape(-1, 3))


@dataclass
class ShadowMap:
    """Light on a rectangle of the ground: a grid of values 0..1 from corner `low` on."""

    low: Array
    values: Array

    @classmethod
    def cast(
        cls, body: Shapes, lamp_direction: Array, frame: Array, origin: Array
    ) -> ShadowMap | None:
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
        lamp = body.centers[near].mean(axis=0) + LAMP_DISTANCE * lamp_direction
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
