"""How surfaces look: a lamp behind the camera, the sky above, light from the ground.

Colors are light intensities ("linear") until the last step turns them into sRGB bytes.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from understudy.motion.rotations import Array
from understudy.output.camera import Camera

TOP, HORIZON = np.array([0.38, 0.52, 0.72]), np.array([0.84, 0.89, 0.94])  # of the sky
TILES = np.array([[0.50, 0.53, 0.56], [0.42, 0.45, 0.48]])
GHOST = np.array([0.16, 0.42, 0.85])
_SUN = np.array([1.0, 0.96, 0.90]) * 0.78
_SKY = np.array([0.50, 0.58, 0.70]) * 0.62  # ambient light from above
_BOUNCE = np.array([0.42, 0.40, 0.38]) * 0.42  # ambient light from the ground


def lamp(camera: Camera) -> Array:
    """Unit vector toward the lamp: behind the camera's left shoulder, high up."""
    right, _, forward = camera.axes
    back = -np.array([forward[0], forward[1], 0.0]) / max(np.hypot(forward[0], forward[1]), 1e-9)
    light = 0.42 * back - 0.40 * right + np.array([0.0, 0.0, 0.82])
    return light / np.linalg.norm(light)


def lighting(normals: Array, lit: Array, light: Array) -> Array:
    """Light that a matte white surface sends back, shape (n, 3); `lit` (n,) is 0 in shadow."""
    up = (0.5 + 0.5 * normals[:, 2])[:, None]
    ambient = _BOUNCE + (_SKY - _BOUNCE) * up
    # Wrapped around a little, as from a large lamp.
    sun = np.clip((normals @ light + 0.15) / 1.15, 0.0, 1.0) * lit
    return ambient + _SUN * sun[:, None]


def shine(normals: Array, rays: Array, light: Array) -> Array:
    """A soft highlight and a brighter rim, shape (n, 3)."""
    facing = -np.einsum("ij,ij->i", normals, rays)
    halfway = light - rays
    halfway /= np.linalg.norm(halfway, axis=1)[:, None]
    spot = np.clip(np.einsum("ij,ij->i", normals, halfway), 0.0, 1.0) ** 40
    rim = np.clip(1.0 - facing, 0.0, 1.0) ** 4
    return (0.10 * spot)[:, None] * _SUN + (0.10 * rim)[:, None] * _SKY


def checker(place: Array, size: Array) -> Array:
    """A checkerboard of unit tiles averaged over a box of `size`, 0..1, shape (n,).

    Closed form of the average, so that far tiles fade to gray instead of flickering.
    """
    size = np.maximum(size, 1e-4)
    low, high = 0.5 * place - 0.25 * size, 0.5 * place + 0.25 * size
    for edge in (low, high):
        edge -= np.floor(edge)
        edge -= 0.5
        np.abs(edge, out=edge)
    wave = 2.0 * (low - high) / size
    wave[size > 4.0] = 0.0
    return 0.5 - 0.5 * wave[:, 0] * wave[:, 1]


def edges(label: np.ndarray) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Pixels whose label differs from a neighbor's."""
    edge = np.zeros(label.shape, bool)
    across, down = label[:, 1:] != label[:, :-1], label[1:] != label[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


def linear(srgb: Array) -> Array:
    """Colors as light intensities."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def to_bytes(linear: Array) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Light intensities as sRGB bytes."""
    table = np.clip(linear * 4095.0, 0.0, 4095.0).astype(np.int32)
    return _SRGB[table]


_STEPS = np.linspace(0.0, 1.0, 4096)
_SRGB = np.round(
    255.0 * np.where(_STEPS <= 0.0031308, 12.92 * _STEPS, 1.055 * _STEPS ** (1 / 2.4) - 0.055)
).astype(np.uint8)
