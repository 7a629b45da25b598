"""Soles that fit the way a clip stands.

A captured foot is a rigid line with noise: with soles drawn where anatomy puts them, heel, ball and
toes of a standing actor disagree about the floor by centimeters. So each contact point of a foot is
moved along the sole's normal until the clip itself says it stands on the floor, and the slow drift
of the floor under the clip (capture floors are not level) is taken out with the same points.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter, minimum_filter1d

from understudy.character.body import Character
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array

SLOW = 0.35  # A point in stance moves slower than this [m/s].
LOW = 0.12  # And lies lower than this over the floor [m].
MOST = 0.03  # Most a point moves in one round [m].
ROUNDS = 3
# On uneven ground the lowest point within this time [s] is on it; the body goes up and down more
# slowly than the feet [s], and a foot in stance may be further off before it is planted [m].
DRIFT, UNEVEN_SMOOTHING, UNEVEN_HEIGHT = 0.3, 0.4, 0.08
EDGE = 0.04  # This near the edge of a step [m] a point may stand in front of it.
STANDS = 0.003  # A floor found this near z = 0 [m] is z = 0, and so is a foot moved by less.


class Floor(Protocol):
    """What lies under the feet where it is not the plane z = 0."""

    def height(self, points: Any, /) -> Array:
        """Height under world points (..., 2 or more) [m], shape (...)."""
        ...

    def normals(self, points: Any, /) -> Array:
        """Unit normals there, shape (..., 3)."""
        ...


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


def standing(
    clip: Clip,
    character: Character,
    *,
    shifts: Array | None = None,
    ground: Floor | None = None,
    own: Floor | None = None,
) -> Clip:
    """The clip lowered or raised, slowly over time, so that its resting soles touch the floor.

    Args:
        clip: On the character's own skeleton.
        character: A body with contact shapes at its feet; without any the clip is unchanged.
        shifts: Change of each sole point along its link's z [m], for a fit in progress.
        ground: The floor; None is z = 0. On a slope the feet are tilted with it.
        own: The floor instead, where it is the one that the clip was captured on: only its height
            is off, and the feet are tilted already.
    """
    if not sole_points(character):
        return clip
    if ground is not None:
        clip = _tilted(clip, character, ground)
    heights, slow = _sole_motion(clip, character, shifts, own if ground is None else ground)
    base = _base(heights, slow)
    near, smooth, part = base, 0.15, 0.2
    if ground is not None:
        # A straight leg gets no longer: so low that feet have to be lifted to stand on the floor.
        smooth, part = UNEVEN_SMOOTHING, 0.9
        # Walking level over a slope, a clip is off the floor by more and more.
        window = 2 * round(DRIFT * clip.rate) + 1
        lows = np.where(slow, heights, np.inf).min(axis=1)
        lows = np.where(np.isfinite(lows), lows, heights.min(axis=1))
        near = minimum_filter1d(lows, window, mode="nearest")[:, None]
    resting = slow & (heights < near + LOW)
    known = resting.any(axis=1)
    if known.sum() < 3:
        return _lowered(clip, np.full(clip.frames, base))
    lowest = np.where(resting, heights, np.inf).min(axis=1)
    frames = np.arange(clip.frames)
    floor = np.interp(frames, frames[known], lowest[known])
    window = 2 * round(0.1 * clip.rate) + 1
    floor = median_filter(floor, window, mode="nearest")
    # Odd reflection at the ends keeps a walk up a slope going up.
    pad = 0 if ground is None else min(round(3.0 * smooth * clip.rate), clip.frames - 1)
    floor = np.pad(floor, pad, mode="reflect", reflect_type="odd")
    floor = gaussian_filter1d(floor, smooth * clip.rate, mode="nearest")
    floor = floor[pad : pad + clip.frames]
    after = np.where(resting, heights - floor[:, None], np.inf).min(axis=1)[known]
    floor += float(np.quantile(after, part)) + 0.001
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


def sole_paths(clip: Clip, character: Character, *, side: str = "") -> Array:
    """World path of the lowest point of every sole sphere [m], shape (frames, points, 3).

    Of both feet, or of the "left" or "right".
    """
    found = zip(*point_paths(clip, character, "feet"), strict=True)
    paths = [path for path, link in found if character.links[link].joint.startswith(side)]
    return np.stack(paths, axis=1) if paths else np.zeros((clip.frames, 0, 3))


def sole_heights(clip: Clip, character: Character) -> Array:
    """Height of every sole point over z = 0 [m], shape (frames, points)."""
    return _sole_motion(clip, character, None)[0]


def _is_foot(joint: str) -> bool:
    return joint.endswith(("_ankle", "_ball"))


def point_paths(clip: Clip, character: Character, part: str) -> tuple[list[Array], list[int]]:
    """World path [m] of the lowest point of every end of a contact shape, (frames, 3), and link.

    `part` is "feet" (spheres) or "hands" (capsules, with their two ends).
    """
    pose = clip.forward_kinematics()
    points = sole_points(character) if part == "feet" else _hand_points(character)
    paths = [
        pose.positions[:, link]
        + rot.rotate(pose.rotations[:, link], center)
        - np.array([0.0, 0.0, radius])
        for link, center, radius in points
    ]
    return paths, [link for link, _, _ in points]


def _hand_points(character: Character) -> list[tuple[int, Array, float]]:
    """Link, center in the link frame [m] and radius [m] of both ends of the hands' capsules."""
    return [
        (i, shape.position + end * rot.rotate(shape.rotation, np.array([0.0, 0.0, 1.0])), radius)
        for i, link in enumerate(character.links)
        if link.joint.endswith("_wrist")
        for shape in link.shapes
        if shape.contact and shape.kind == "capsule"
        for radius in [float(shape.size[0])]
        for end in (-float(shape.size[1]), float(shape.size[1]))
    ]


def _tilted(clip: Clip, character: Character, ground: Floor) -> Clip:
    """The clip with each foot turned as the plane under it is turned from the level."""
    pose, local = clip.forward_kinematics(), np.array(clip.rotations)
    for k, link in enumerate(character.links):
        if not link.joint.endswith("_ankle"):
            continue
        up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (clip.frames, 3))
        normals = gaussian_filter1d(
            ground.normals(pose.positions[:, k]), 0.1 * clip.rate, axis=0, mode="nearest"
        )
        tilt = rot.shortest_arc(up, normals)
        above = pose.rotations[:, link.parent]
        turned = rot.multiply(tilt, pose.rotations[:, k])
        local[:, k] = rot.multiply(rot.conjugate(above), turned)
    # A level floor leaves the feet bitwise as they are.
    same = np.allclose(local, clip.rotations, atol=1e-12)
    return clip if same else replace(clip, rotations=local)


def under(ground: Floor, places: Array) -> Array:
    """Height of the ground under points (..., 3) [m]; within a riser, that of the lower tread.

    A toe that a captured clip puts a little into a riser stands in front of it.
    """
    here = ground.height(places)
    around = [
        ground.height(places[..., :2] + EDGE * np.array(way))
        for way in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
    ]
    low = np.min(around, axis=0)
    return np.where(places[..., 2] < np.minimum(here - EDGE, 0.5 * (here + low)), low, here)


def _sole_motion(
    clip: Clip, character: Character, shifts: Array | None, ground: Floor | None = None
) -> tuple[Array, np.ndarray]:
    """Heights of the sole points over the floor [m] and whether each is slow, (frames, points)."""
    pose = clip.forward_kinematics()
    heights, slow = [], []
    for k, (link, center, radius) in enumerate(sole_points(character)):
        at = center if shifts is None else center + np.array([0.0, 0.0, shifts[k]])
        place = pose.positions[:, link] + rot.rotate(pose.rotations[:, link], at)
        speed = np.linalg.norm(derivative(place, clip.rate, smoothing=0.075), axis=1)
        low = place[:, 2] - radius
        if ground is not None:
            low = low - under(ground, np.concatenate((place[:, :2], low[:, None]), axis=1))
        heights.append(low)
        slow.append(speed < SLOW)
    return np.stack(heights, axis=1), np.stack(slow, axis=1)


def _base(heights: Array, slow: np.ndarray) -> float:
    """A first guess of the floor: the 5 % quantile of slow points, or of the lowest points."""
    values = heights[slow] if slow.sum() >= 3 else heights.min(axis=1)
    return float(np.quantile(values, 0.05))


def _lowered(clip: Clip, floor: Array) -> Clip:
    # A clip that stands within the contact's own depth stands already.
    if np.abs(floor).max() < STANDS:
        return clip
    path = np.array(clip.root_positions)
    path[:, 2] -= floor
    low, high = 1000.0 * floor.min(), 1000.0 * floor.max()
    note = f"Set on the floor: lowered by {low:.0f} to {high:.0f} mm."
    kept = tuple(n for n in clip.notes if not n.startswith("Set on the floor:"))
    return replace(clip, root_positions=path, notes=(*kept, note))


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
