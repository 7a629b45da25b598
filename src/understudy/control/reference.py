"""A clip made continuous: poses and velocities at any time.

Zordan & Hodgins 1999, section 3: the sampled joint angles are interpolated to continuous
trajectories, by spline or by quaternion slerp.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array

INTERPOLATIONS = ("spline", "slerp")


@dataclass(frozen=True)
class Sampled:
    """A reference at given times.

    Attributes:
        positions: Root positions [m], world, shape (times, 3).
        velocities: Root velocities [m/s], world, shape (times, 3).
        rotations: Local joint rotations, wxyz, shape (times, joints, 4).
        rates: Angular velocity of each joint in its own frame [rad/s], shape (times, joints, 3).
    """

    positions: Array
    velocities: Array
    rotations: Array
    rates: Array

    def qpos(self) -> Array:
        """Engine positions, shape (times, 3 + 4 joints)."""
        return np.concatenate((self.positions, self.rotations.reshape(len(self.positions), -1)), 1)

    def qvel(self) -> Array:
        """Engine velocities, shape (times, 3 + 3 joints)."""
        return np.concatenate((self.velocities, self.rates.reshape(len(self.positions), -1)), 1)


def frame_velocities(clip: Clip) -> tuple[Array, Array]:
    """Central differences at the clip's frames.

    Returns:
        Root velocity [m/s], world, (frames, 3), and joint rates in the joint's own frame [rad/s],
        (frames, joints, 3).
    """
    if clip.frames < 2:
        return np.zeros((clip.frames, 3)), np.zeros((*clip.rotations.shape[:2], 3))
    step = np.diff(clip.root_positions, axis=0) * clip.rate
    linear = np.concatenate((step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]))
    turned = clip.rotations
    forward = rot.to_rotvec(rot.multiply(rot.conjugate(turned[:-1]), turned[1:])) * clip.rate
    angular = np.concatenate((forward[:1], 0.5 * (forward[1:] + forward[:-1]), forward[-1:]))
    return linear, angular


def sampled(clip: Clip, times: Array, *, interpolation: str = "spline") -> Sampled:
    """The clip at `times` [s]; before its start and after its end it holds still.

    `spline` is a cubic Hermite curve in the tangent space of each frame (continuous velocity);
    `slerp` turns at a constant rate from frame to frame.

    Raises:
        InvalidValue: Another interpolation is named.
    """
    if interpolation not in INTERPOLATIONS:
        raise InvalidValue(
            f"interpolation is {interpolation!r}; it must be one of {INTERPOLATIONS}."
        )
    times = np.asarray(times, float)
    if clip.frames < 2:
        n, joints = len(times), len(clip.skeleton)
        return Sampled(
            np.repeat(clip.root_positions, n, axis=0),
            np.zeros((n, 3)),
            np.repeat(clip.rotations, n, axis=0),
            np.zeros((n, joints, 3)),
        )
    inside = (times >= 0.0) & (times <= clip.duration + 1e-9)
    frame = np.clip(times * clip.rate, 0.0, clip.frames - 1)
    k = np.minimum(frame.astype(int), clip.frames - 2)
    s = frame - k
    h = 1.0 / clip.rate
    turned, path = clip.rotations, clip.root_positions
    relative = rot.to_rotvec(rot.multiply(rot.conjugate(turned[:-1]), turned[1:]))
    if interpolation == "slerp":
        linear = np.diff(path, axis=0) / h
        w = s[:, None]
        tangent, rates = relative[k] * w[..., None], relative[k] / h
        positions, velocities = path[k] + linear[k] * (w * h), linear[k]
    else:
        linear, angular = frame_velocities(clip)
        h10, h01, h11 = s * (1 - s) ** 2, s * s * (3 - 2 * s), s * s * (s - 1)
        d10, d01, d11 = 1 - 4 * s + 3 * s * s, 6 * s * (1 - s), s * (3 * s - 2)

        def blend(start: Array, change: Array, end: Array, a: Array, b: Array, c: Array) -> Array:
            shape = (-1,) + (1,) * (start.ndim - 1)
            return (
                a.reshape(shape) * h * start
                + b.reshape(shape) * change
                + c.reshape(shape) * h * end
            )

        change = np.diff(path, axis=0)[k]
        positions = path[k] + blend(linear[k], change, linear[k + 1], h10, h01, h11)
        velocities = blend(linear[k], change, linear[k + 1], d10, d01, d11) / h
        tangent = blend(angular[k], relative[k], angular[k + 1], h10, h01, h11)
        rates = blend(angular[k], relative[k], angular[k + 1], d10, d01, d11) / h
    rotations = rot.multiply(turned[k], rot.from_rotvec(tangent))
    still = ~inside
    velocities[still], rates[still] = 0.0, 0.0
    return Sampled(positions, velocities, rotations, rates)
