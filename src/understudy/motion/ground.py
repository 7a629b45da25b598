"""Where the floor is, and what touches it.

A capture's zero height is rarely the floor, so the floor is measured from the motion itself: it is
where the lowest points come to rest. No names are needed; a point is any joint or end site.

What this cannot know: a clip that never touches the floor (hanging, swimming, flight only) still
gets its lowest resting points as the floor, and for one leg on a raised support the other foot may
hang below it. A note says what was found; pass `floor` to say better.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import binary_closing, binary_opening, gaussian_filter1d, median_filter

from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

# A point at rest on the floor moves slower than this [m/s], for a body of 1.75 m; speeds scale with
# the square root of size (equal Froude number), lengths with size.
_SLOW = 0.35
_PERSON = 1.75
# Heights of one floor spread by up to this much [m]: floors are not level and feet are not points.
_SPREAD = 0.05
# A point this near the floor may be touching it [m].
_LOW = 0.04


@dataclass(frozen=True, kw_only=True)
class Contacts:
    """Which points touch the floor.

    Attributes:
        points: Name of each point that ever touches: the joint's name, or "<joint> end".
        positions: World positions of those points [m], shape (frames, points, 3).
        touching: Whether each is in contact, shape (frames, points).
        speeds: Horizontal speed of those points [m/s], shape (frames, points).
        floor: Height of the floor [m].
        rate: Frames per second [Hz].
    """

    points: tuple[str, ...]
    positions: Array = field(repr=False)
    touching: np.ndarray = field(repr=False)
    speeds: Array = field(repr=False)
    floor: float
    rate: float

    @property
    def slide(self) -> float:
        """Mean horizontal speed of points in contact [m/s]; 0 where nothing touches."""
        return float(self.speeds[self.touching].mean()) if self.touching.any() else 0.0

    @property
    def airborne(self) -> np.ndarray:
        """Frames in which nothing touches, shape (frames,)."""
        return np.logical_not(self.touching.any(axis=1))


def body_size(skeleton: Skeleton) -> float:
    """Height of the rest pose [m], or its greatest extent where that is larger by a half."""
    rest = skeleton.rest_positions()
    carriers = list(skeleton.end_joints)
    points = np.concatenate((rest, rest[carriers] + skeleton.end_offsets))
    extent = np.ptp(points, axis=0)
    return max(float(extent[2]), float(extent.max()) / 1.5, 1e-3)


def sole_height(skeleton: Skeleton) -> float:
    """How high the lowest point of the skeleton lies above the sole [m].

    Known only where the rest pose stands on z = 0, as the standard figure's does: then it is the
    height of the rest pose's lowest point. Otherwise 0: the lowest points are taken as soles.
    """
    rest = skeleton.rest_positions()
    carriers = list(skeleton.end_joints)
    lowest = float(np.concatenate((rest, rest[carriers] + skeleton.end_offsets))[:, 2].min())
    return lowest if 0.0 < lowest < 0.04 * body_size(skeleton) else 0.0


def floor_height(clip: Clip) -> float:
    """Height [m] at which the lowest points of the clip come to rest, minus the sole's thickness.

    In every frame the lowest slow point is a candidate (slower than 0.35 m/s for a person): a foot
    in stance, a seat, a hand in a handstand. Swinging feet, flights and single bad frames are fast
    and drop out. The lowest layer of 5 cm that holds a seventh of the candidates is the floor's, so
    a few frames below it do not count and neither do steps or seats above; the 20 % quantile in it
    is the floor: most stances reach it. Where nothing is ever slow, every frame's lowest point is a
    candidate.
    """
    lowest, known = _resting_heights(clip)
    candidates = lowest[known] if known.sum() >= max(3, 0.02 * clip.frames) else lowest
    heights = np.sort(candidates)
    spread = _SPREAD * body_size(clip.skeleton) / _PERSON
    held = np.searchsorted(heights, heights + spread, side="right") - np.arange(len(heights))
    base = heights[int(np.argmax(held >= len(heights) / 7.0))]
    layer = heights[(heights >= base) & (heights <= base + spread)]
    return float(np.quantile(layer, 0.2)) - sole_height(clip.skeleton)


def grounded(clip: Clip, *, floor: float | None = None, level: bool = False) -> Clip:
    """The clip shifted so that its feet stand on z = 0.

    One constant shift, by `floor` [m] or by `floor_height`. With `level` the slow drift of the
    floor is taken out as well: the height of the lowest resting point, joined by straight lines
    where nothing rests, median-filtered over 0.2 s and smoothed with a Gaussian of 0.15 s. Flights,
    steps up and raised supports (above 12 cm for a person) are left alone.

    Raises:
        InvalidValue: `floor` is not a finite number.
    """
    if floor is not None and not np.isfinite(floor):
        raise InvalidValue(f"floor is {floor}; it must be a finite height in meters.")
    measured = floor_height(clip) if floor is None else float(floor)
    shift = np.full(clip.frames, -measured)
    found = f"Grounded: shifted by {-1000.0 * measured:+.1f} mm"
    lowest, known = _resting_heights(clip)
    if floor is None and not known.any():
        found += " (nothing rests in this clip; its lowest points were taken as the floor)"
    if level:
        drift = _drift(clip, lowest - measured - sole_height(clip.skeleton), known)
        shift -= drift
        found += (
            f", and its floor leveled by {1000 * drift.min():+.1f} .. {1000 * drift.max():+.1f} mm"
        )
    path = np.array(clip.root_positions)
    path[:, 2] += shift
    return replace(clip, root_positions=path, notes=(*clip.notes, found + "."))


def foot_contacts(clip: Clip, *, floor: float | None = None) -> Contacts:
    """Which joints and end sites touch the floor in each frame: those that are low and slow.

    Low is within 4 cm of the floor (plus the sole's thickness), or within 2 cm of the frame's
    lowest slow point where that is within 8 cm, for floors that are not level; slow is below
    0.35 m/s (all for a person). Contacts or gaps shorter than 40 ms are ignored. `floor` [m]
    defaults to `floor_height(clip)`.
    """
    if floor is None:
        floor = floor_height(clip)
    positions, names = _points(clip)
    velocity = derivative(positions, clip.rate, smoothing=_window(clip))
    scale = body_size(clip.skeleton) / _PERSON
    sole = floor + sole_height(clip.skeleton)
    lowest, known = _resting_heights(clip)
    near = np.where(known & (lowest < sole + 2.0 * _LOW * scale), lowest + 0.5 * _LOW * scale, sole)
    low = positions[..., 2] < np.maximum(sole + _LOW * scale, near)[:, None]
    touching = low & (np.linalg.norm(velocity, axis=-1) < _SLOW * np.sqrt(scale))
    brief = max(1, round(0.04 * clip.rate))
    if brief > 1 and clip.frames > 2 * brief:
        block = np.ones((brief, 1), bool)
        touching = binary_closing(np.pad(touching, ((brief, brief), (0, 0)), "edge"), block)
        touching = binary_opening(touching, block)[brief:-brief]
    ever = np.flatnonzero(touching.any(axis=0))
    return Contacts(
        points=tuple(names[k] for k in ever),
        positions=positions[:, ever],
        touching=touching[:, ever],
        speeds=np.linalg.norm(velocity[:, ever, :2], axis=-1),
        floor=float(floor),
        rate=clip.rate,
    )


def _window(clip: Clip) -> float:
    """Window for speeds [s]: 75 ms, at least five frames (slow cameras)."""
    return max(0.075, 4.0 / clip.rate)


def _points(clip: Clip) -> tuple[Array, list[str]]:
    """World positions (frames, points, 3) of all joints and end sites, and their names."""
    pose, skeleton = clip.forward_kinematics(), clip.skeleton
    ends = [f"{skeleton.names[j]} end" for j in skeleton.end_joints]
    return np.concatenate((pose.positions, pose.ends), axis=1), [*skeleton.names, *ends]


def _resting_heights(clip: Clip) -> tuple[Array, np.ndarray]:
    """Height of the lowest slow point per frame [m], and whether there is one.

    Only points near the lowest of the frame count, so that a still head over running feet does not;
    frames without one hold the height of the lowest point.
    """
    positions, _ = _points(clip)
    velocity = derivative(positions, clip.rate, smoothing=_window(clip))
    scale = body_size(clip.skeleton) / _PERSON
    heights = positions[..., 2]
    bottom = heights.min(axis=1)
    slow = np.linalg.norm(velocity, axis=-1) < _SLOW * np.sqrt(scale)
    slow &= heights < bottom[:, None] + _SPREAD * scale
    known = slow.any(axis=1)
    lowest = np.where(slow, heights, np.inf).min(axis=1)
    return np.where(known, lowest, bottom), known


def _drift(clip: Clip, heights: Array, known: np.ndarray) -> Array:
    """The slow change of the floor [m], shape (frames,), from resting heights above it."""
    limit = 0.12 * body_size(clip.skeleton) / _PERSON
    use = known & (np.abs(heights) < limit)
    if use.sum() < 2:
        return np.zeros(clip.frames)
    frames = np.arange(clip.frames)
    drift = np.interp(frames, frames[use], heights[use])
    drift = median_filter(drift, size=max(1, 2 * round(0.1 * clip.rate) + 1), mode="nearest")
    return gaussian_filter1d(drift, 0.15 * clip.rate, mode="nearest")
