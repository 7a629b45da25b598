"""Edits of a clip: trimmed, resampled, retimed, placed, mirrored; and its velocities.

Every edit takes a clip and returns a new one with a note of what was done; the file conventions are
kept. The root path and the joint rotations are always treated alike.
"""

from __future__ import annotations

from dataclasses import replace
from numbers import Real
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter

from understudy.errors import InvalidValue, shown
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip, check_rate
from understudy.motion.mirror import mirrored as mirrored
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array

Method = Literal["slerp", "spline"]
SPEEDS = (1e-3, 1e3)
# Numbers in the rotations of a clip that an edit may make: 0.8 GB, an hour of 60 joints at 120 Hz.
MOST_NUMBERS = 100_000_000


def trimmed(clip: Clip, start: float = 0.0, end: float | None = None) -> Clip:
    """The frames from `start` to `end` [s], both included; time starts again at zero.

    Raises:
        InvalidValue: The times lie outside the clip or leave no frame.
    """
    last = clip.duration if end is None else end
    slack = 0.5 / clip.rate
    if not (-slack <= start <= last <= clip.duration + slack):
        raise InvalidValue(
            f"Cannot trim {clip.name!r} to {start} .. {last} s; it lasts 0 .. {clip.duration:g} s."
        )
    # Frame numbers, with a millionth of a frame of slack for times such as 0.1 * 3.
    first = max(0, int(np.ceil(start * clip.rate - 1e-6)))
    stop = min(clip.frames, int(np.floor(last * clip.rate + 1e-6)) + 1)
    if stop <= first:
        raise InvalidValue(f"No frame of {clip.name!r} lies between {start} and {last} s.")
    if first == 0 and stop == clip.frames:
        return clip
    note = f"Trimmed to {first / clip.rate:g} .. {(stop - 1) / clip.rate:g} s."
    return replace(
        clip,
        rotations=clip.rotations[first:stop],
        root_positions=clip.root_positions[first:stop],
        notes=(*clip.notes, note),
    )


def sampled(clip: Clip, times: ArrayLike, *, method: Method = "spline") -> tuple[Array, Array]:
    """Local rotations (times, joints, 4) and root positions [m] (times, 3) at any times [s].

    Times outside the clip take its first or last frame. "slerp" moves at a constant angular speed
    between neighboring frames (root: straight lines). "spline" is twice continuously
    differentiable: a cubic spline through the quaternions of one hemisphere, made unit length
    again, and a cubic spline through the root path; it passes through every frame.

    Raises:
        InvalidValue: Another method, or times that are not a list of finite numbers.
    """
    times = np.asarray(times, float)
    if times.ndim != 1 or not np.isfinite(times).all():
        raise InvalidValue("times must be a list of finite numbers of seconds.")
    if method not in ("slerp", "spline"):
        raise InvalidValue(f"method is {method!r}; it must be 'slerp' or 'spline'.")
    t = np.clip(times * clip.rate, 0.0, clip.frames - 1.0)
    if clip.frames == 1:
        return clip.rotations[[0] * len(t)], clip.root_positions[[0] * len(t)]
    if method == "spline" and clip.frames > 2:
        grid = np.arange(clip.frames, dtype=float)
        turned = rot.normalized(CubicSpline(grid, clip.rotations)(t))
        return turned, CubicSpline(grid, clip.root_positions)(t)
    low = np.minimum(t.astype(int), clip.frames - 2)
    weight = t - low
    turned = rot.slerp(clip.rotations[low], clip.rotations[low + 1], weight[:, None])
    a, b = clip.root_positions[low], clip.root_positions[low + 1]
    return turned, a + weight[:, None] * (b - a)


def resampled(clip: Clip, rate: float, *, method: Method = "slerp") -> Clip:
    """The same motion at `rate` frames per second; see `sampled` for the methods.

    The last frame is the last multiple of the new frame time inside the clip. Nothing is filtered:
    motion faster than half the new rate folds back, as in a camera.

    Raises:
        InvalidValue: A rate outside 0.01 to 100000 Hz, more frames than memory holds, or another
            method.
    """
    rate = check_rate(rate)
    if method not in ("slerp", "spline"):
        raise InvalidValue(f"method is {method!r}; it must be 'slerp' or 'spline'.")
    if rate == clip.rate:
        return clip
    frames = _frames(clip, clip.duration * rate, f"At {rate:g} Hz")
    turned, path = sampled(clip, np.arange(frames) / rate, method=method)
    note = f"Resampled from {clip.rate:g} to {rate:g} Hz ({method})."
    return replace(
        clip, rotations=turned, root_positions=path, rate=rate, notes=(*clip.notes, note)
    )


def retimed(clip: Clip, speed: float) -> Clip:
    """The motion `speed` times as fast, at the same frame rate (spline between frames).

    Raises:
        InvalidValue: A speed outside 0.001 to 1000, or more frames than memory holds.
    """
    low, high = SPEEDS
    if not (isinstance(speed, Real) and low <= speed <= high):
        raise InvalidValue(f"speed is {speed!s:.40}; it must lie in {low:g} to {high:g} (--speed).")
    if speed == 1.0:
        return clip
    frames = _frames(clip, clip.duration / speed * clip.rate, f"At speed {speed:g}")
    turned, path = sampled(clip, np.arange(frames) * speed / clip.rate)
    note = f"Retimed: plays {speed:g} times as fast."
    return replace(clip, rotations=turned, root_positions=path, notes=(*clip.notes, note))


def placed(clip: Clip, *, at: ArrayLike | None = None, heading: float = 0.0) -> Clip:
    """The whole motion moved rigidly over the ground: turned, and set down somewhere else.

    It is turned by `heading` [rad], counterclockwise seen from above, about the vertical through
    its first root position; that root position then lies over `at` [m], (2,), by default where it
    was. Heights stay. Placing it back where it was with `-heading` gives the clip back.

    Raises:
        InvalidValue: `at` is not two finite numbers, or `heading` is not a finite one.
    """
    first = clip.root_positions[0, :2]
    to = frozen_array(first if at is None else at, (2,), "at")
    if not (isinstance(heading, Real) and np.isfinite(heading)):
        raise InvalidValue(f"heading is {shown(heading)}; it must be an angle in radians.")
    turn = rot.from_rotvec(np.array([0.0, 0.0, float(heading)]))
    turned, path = np.array(clip.rotations), np.array(clip.root_positions)
    path[:, :2] -= first
    path = rot.rotate(turn, path)
    path[:, :2] += to
    turned[:, 0] = rot.multiply(turn, turned[:, 0])
    note = f"Placed at ({to[0]:.3f}, {to[1]:.3f}) m, turned by {np.degrees(heading):.1f} degrees."
    return replace(clip, rotations=turned, root_positions=path, notes=(*clip.notes, note))


def _frames(clip: Clip, last: float, when: str) -> int:
    """Frames up to number `last`, when memory holds them."""
    frames = int(np.floor(last + 1e-6)) + 1
    if frames > clip.frames and frames * clip.rotations[0].size > MOST_NUMBERS:
        raise InvalidValue(
            f"{when}, {clip.name!r} would have {frames} frames of {len(clip.skeleton)} joints, "
            "more than memory holds; trim it first."
        )
    return frames


def derivative(values: ArrayLike, rate: float, *, smoothing: float = 0.0, order: int = 1) -> Array:
    """Time derivative along axis 0, in units of `values` per second (or per second squared).

    `smoothing` is the window [s] of a Savitzky-Golay fit (quadratic; cubic for the second
    derivative), for captured data. With 0 it is the central difference of second order, one-sided
    at the ends.

    Raises:
        InvalidValue: `order` other than 1 or 2, or a negative window.
    """
    data: Array = np.array(values, float)
    if order not in (1, 2):
        raise InvalidValue(f"order is {order}; it must be 1 or 2.")
    if not smoothing >= 0.0:
        raise InvalidValue(f"smoothing is {smoothing} s; it must not be negative.")
    if len(data) < 2:
        return np.zeros_like(data)
    degree = 1 + order
    window = min(2 * round(0.5 * smoothing * rate) + 1, len(data) - 1 + len(data) % 2)
    if window > degree:
        fitted = savgol_filter(data, window, degree, deriv=order, delta=1.0 / rate, axis=0)
        return np.asarray(fitted, float)
    for _ in range(order):
        edge = 2 if len(data) > 2 else 1
        data = np.asarray(np.gradient(data, 1.0 / rate, axis=0, edge_order=edge), float)
    return data


def joint_velocities(clip: Clip, *, smoothing: float = 0.0) -> Array:
    """World velocity of every joint [m/s], shape (frames, joints, 3); see `derivative`."""
    return derivative(clip.forward_kinematics().positions, clip.rate, smoothing=smoothing)


def joint_accelerations(clip: Clip, *, smoothing: float = 0.0) -> Array:
    """World acceleration of every joint [m/s^2], shape (frames, joints, 3); see `derivative`."""
    positions = clip.forward_kinematics().positions
    return derivative(positions, clip.rate, smoothing=smoothing, order=2)


def angular_velocities(clip: Clip, *, smoothing: float = 0.0, world: bool = True) -> Array:
    """Angular velocity of every joint's frame [rad/s], shape (frames, joints, 3).

    World axes and relative to the world by default; with `world=False` in the parent's axes and
    relative to the parent. `smoothing` as in `derivative`.
    """
    q = rot.continuous(clip.forward_kinematics().rotations) if world else clip.rotations
    if smoothing <= 0.0:
        return rot.angular_velocity(q, clip.rate)
    rate_of_q = derivative(q, clip.rate, smoothing=smoothing)
    return 2.0 * rot.multiply(rate_of_q, rot.conjugate(q))[..., 1:]


def angular_accelerations(clip: Clip, *, smoothing: float = 0.0, world: bool = True) -> Array:
    """Angular acceleration of every joint's frame [rad/s^2], shape (frames, joints, 3).

    Frames and `smoothing` as in `angular_velocities`.
    """
    velocity = angular_velocities(clip, smoothing=smoothing, world=world)
    return derivative(velocity, clip.rate, smoothing=smoothing)
