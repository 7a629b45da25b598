"""Hands that bear the body, put on the floor: cartwheels and handstands.

A captured hand ends somewhere above the floor it leans on: markers sit on its back, and shoulders
rise under the body by more than a skeleton's do. A hand bears where it is slow and low while no
foot is near the floor. The body is lowered by what the lower hand lacks, smoothly over time, and
the arms reach for the rest; the hands keep their orientation.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_closing, binary_opening, gaussian_filter1d

from understudy.character.body import Character
from understudy.character.planting import ARM, VERTICAL, moved_end
from understudy.character.soles import Floor, point_paths, sole_paths, under
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array

LOW, SLOW = 0.13, 1.0  # A hand that bears is lower than this [m] and slower than this [m/s],
ALOFT = 0.05  # while both feet are higher than this over the floor [m]
LASTS = 0.2  # for this long [s].
MOST = 0.12  # Most a hand is moved [m].
EASE = 0.06  # Over this time [s] a hand comes to the floor and leaves it.


def bearing_hands(
    clip: Clip, character: Character, ground: Floor | None = None
) -> dict[str, np.ndarray]:
    """When each hand bears the body, shape (frames,) of bool, by side; empty where none ever does.

    Args:
        clip: On the character's own skeleton, standing on the floor.
        character: The body.
        ground: The floor; None is z = 0.
    """
    paths, bears = _hands(clip, character), {}
    soles = sole_paths(clip, character)
    if not paths or not soles.shape[1] or clip.frames < 5:
        return {}
    aloft = _heights(soles, ground).min(axis=1) > ALOFT
    window = max(1, round(0.5 * LASTS * clip.rate))
    for side, path in paths.items():
        speed = np.linalg.norm(derivative(path, clip.rate, smoothing=0.1), axis=-1).min(axis=1)
        held = aloft & (_heights(path, ground).min(axis=1) < LOW) & (speed < SLOW)
        held = binary_closing(np.pad(held, window), iterations=window)[window:-window]
        bears[side] = binary_opening(held, iterations=window)
    return bears if any(held.any() for held in bears.values()) else {}


def leaning(clip: Clip, character: Character, *, ground: Floor | None = None) -> Clip:
    """The clip with the hands that bear the body on the floor; without any it is unchanged.

    Args:
        clip: On the character's own skeleton, standing on the floor.
        character: The body.
        ground: The floor; None is z = 0.
    """
    bears = bearing_hands(clip, character, ground)
    if not bears:
        return clip
    lack = {
        side: np.clip(_heights(path, ground).min(axis=1), -MOST, MOST)
        for side, path in _hands(clip, character).items()
    }
    both = np.min([np.where(bears[side], lack[side], np.inf) for side in bears], axis=0)
    sunk = _eased(both, np.isfinite(both), clip.rate)
    path = np.array(clip.root_positions)
    path[:, 2] -= sunk
    lowered, local = replace(clip, root_positions=path), np.array(clip.rotations)
    joints, most = [link.joint for link in character.links], 0.0
    for side, held in bears.items():
        limb = [f"{side}_{joint}" for joint in ARM]
        if held.any() and set(limb) <= set(joints):
            shift = np.zeros((clip.frames, 3))
            shift[:, 2] = -_eased(lack[side] - sunk, held, clip.rate)
            moved_end(lowered, [joints.index(name) for name in limb], shift, local, VERTICAL)
            most = max(most, float(np.abs(lack[side][held]).max()))
    note = (
        f"Put the hands that bear the body on the floor: moved by up to {1000 * most:.0f} mm, the "
        f"body by up to {1000 * np.abs(sunk).max():.0f} mm."
    )
    return replace(lowered, rotations=local, notes=(*clip.notes, note))


def _hands(clip: Clip, character: Character) -> dict[str, Array]:
    """World paths of the lowest points of each hand [m], (frames, points, 3), by side."""
    found = list(zip(*point_paths(clip, character, "hands"), strict=True))
    out = {}
    for side in ("left", "right"):
        own = [path for path, link in found if character.links[link].joint.startswith(side)]
        if own:
            out[side] = np.stack(own, axis=1)
    return out


def _heights(points: Array, ground: Floor | None) -> Array:
    return points[..., 2] if ground is None else points[..., 2] - under(ground, points)


def _eased(values: Array, held: np.ndarray, rate: float) -> Array:
    """The values where they hold, as at the nearest of them before and after, eased to nothing."""
    knots = np.flatnonzero(held)
    frames = np.arange(len(held))
    filled = np.interp(frames, knots, values[knots])
    away = np.abs(frames[:, None] - knots).min(axis=1) / (2.0 * EASE * rate)
    weight = np.clip(1.0 - away, 0.0, 1.0)
    smooth = weight * weight * (3.0 - 2.0 * weight)
    return gaussian_filter1d(filled * smooth, 0.5 * EASE * rate, mode="nearest")
