"""Soles that fit the way a clip stands.

A captured foot is a rigid line with noise: with soles drawn where anatomy puts them, heel, ball and
toes of a standing actor disagree about the floor by centimeters. So each contact point of a foot is
moved along the sole's normal until the clip itself says it stands on the floor, and the slow drift
of the floor under the clip (capture floors are not level) is taken out with the same points.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from understudy.character.body import Character
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array

SLOW = 0.35  # A point in stance moves slower than this [m/s].
LOW = 0.12  # And lies lower than this over the floor [m].
MOST = 0.03  # Most a point moves in one round [m].
ROUNDS = 3


def fitted_soles(clip: Clip, character: Character) -> Character:
    """The body with soles fitted to the way a clip stands.

    Three rounds: the floor's height over time is where the lowest slow point is; each point then
    moves along its link's z until its own 5 % quantile of height is 0. Inner and outer points, left
    and right feet move alike: a body's shoes are alike.

    Args:
        clip: On the character's own skeleton.
        character: The body.

    Returns:
        The fitted body; the same where no foot is ever slow and low.
    """
    points = sole_points(character)
    if not points:
        return character
    shifts = np.zeros(len(points))
    grounded = clip
    for _ in range(ROUNDS):
        grounded = standing(grounded, character, shifts=shifts)
        heights, slow = _sole_motion(grounded, character, shifts)
        for k in range(len(points)):
            used = heights[slow[:, k] & (heights[:, k] < LOW), k]
            if len(used) >= 3:
                shifts[k] -= float(np.clip(np.quantile(used, 0.05), -MOST, MOST))
    return _moved(character, points, _shared(character, points, shifts))


def standing(clip: Clip, character: Character, *, shifts: Array | None = None) -> Clip:
    """The clip lowered or raised, slowly over time, so that its resting soles touch z = 0.

    Args:
        clip: On the character's own skeleton.
        character: A body with contact shapes at its feet; without any the clip is unchanged.
        shifts: Change of each sole point along its link's z [m], for a fit in progress.
    """
    if not sole_points(character):
        return clip
    heights, slow = _sole_motion(clip, character, shifts)
    base = _base(heights, slow)
    resting = slow & (heights < base + LOW)
    known = resting.any(axis=1)
    if known.sum() < 3:
        return _lowered(clip, np.full(clip.frames, base))
    lowest = np.where(resting, heights, np.inf).min(axis=1)
    frames = np.arange(clip.frames)
    floor = np.interp(frames, frames[known], lowest[known])
    window = 2 * round(0.1 * clip.rate) + 1
    floor = median_filter(floor, window, mode="nearest")
    floor = gaussian_filter1d(floor, 0.15 * clip.rate, mode="nearest")
    after = np.where(resting, heights - floor[:, None], np.inf).min(axis=1)[known]
    floor += float(np.quantile(after, 0.2)) + 0.001
    return _lowered(clip, floor)


def sole_points(character: Character) -> list[tuple[int, Array, float]]:
    """Link, center in the link frame [m] and radius [m] of every contact sphere of the feet."""
    return [
        (i, shape.position, float(shape.size[0]))
        for i, link in enumerate(character.links)
        if _is_foot(link.joint)
        for shape in link.shapes
        if shape.contact and shape.kind == "sphere"
    ]


def sole_heights(clip: Clip, character: Character) -> Array:
    """Height of every sole point over z = 0 [m], shape (frames, points)."""
    return _sole_motion(clip, character, None)[0]


def _is_foot(joint: str) -> bool:
    return joint.endswith(("_ankle", "_ball"))


def _sole_motion(
    clip: Clip, character: Character, shifts: Array | None
) -> tuple[Array, np.ndarray]:
    """Heights of the sole points [m] and whether each is slow, shape (frames, points)."""
    pose = clip.forward_kinematics()
    heights, slow = [], []
    for k, (link, center, radius) in enumerate(sole_points(character)):
        at = center if shifts is None else center + np.array([0.0, 0.0, shifts[k]])
        place = pose.positions[:, link] + rot.rotate(pose.rotations[:, link], at)
        speed = np.linalg.norm(derivative(place, clip.rate, smoothing=0.075), axis=1)
        heights.append(place[:, 2] - radius)
        slow.append(speed < SLOW)
    return np.stack(heights, axis=1), np.stack(slow, axis=1)


def _base(heights: Array, slow: np.ndarray) -> float:
    """A first guess of the floor: the 5 % quantile of slow points, or of the lowest points."""
    values = heights[slow] if slow.sum() >= 3 else heights.min(axis=1)
    return float(np.quantile(values, 0.05))


def _lowered(clip: Clip, floor: Array) -> Clip:
    path = np.array(clip.root_positions)
    path[:, 2] -= floor
    return replace(clip, root_positions=path)


def _shared(character: Character, points: list[tuple[int, Array, float]], shifts: Array) -> Array:
    kinds = [
        (character.links[link].joint.partition("_")[2], round(float(center[0]), 3))
        for link, center, _ in points
    ]
    out = np.array(shifts)
    for kind in set(kinds):
        same = [k for k, other in enumerate(kinds) if other == kind]
        out[same] = np.mean(shifts[same])
    return out


def _moved(
    character: Character, points: list[tuple[int, Array, float]], shifts: Array
) -> Character:
    links, k = list(character.links), 0
    for i in dict.fromkeys(link for link, _, _ in points):
        shapes = []
        for shape in links[i].shapes:
            if shape.contact and shape.kind == "sphere":
                up = np.array([0.0, 0.0, shifts[k]])
                shape = replace(shape, position=shape.position + up)
                k += 1
            shapes.append(shape)
        links[i] = replace(links[i], shapes=tuple(shapes))
    return replace(character, links=tuple(links))
