"""A clip made continuous: poses and velocities at any time.

Zordan & Hodgins 1999, section 3: the sampled joint angles are interpolated to continuous
trajectories, by spline or by quaternion slerp.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from understudy.motion import edits
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import Method
from understudy.motion.rotations import Array


@dataclass(frozen=True, eq=False)
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


def sampled(clip: Clip, times: Array, *, interpolation: Method = "spline") -> Sampled:
    """The clip and its velocities at `times` [s]; before its start and after its end it rests.

    `spline` is twice continuously differentiable and its velocities are the spline's own
    derivatives; `slerp` turns at a constant rate from frame to frame. See
    `understudy.motion.edits.sampled`.

    Raises:
        InvalidValue: Another interpolation is named.
    """
    times = np.asarray(times, float)
    resting = (times < 0.0) | (times > clip.duration + 1e-9)
    frame = np.clip(times * clip.rate, 0.0, clip.frames - 1)
    if interpolation == "spline" and clip.frames > 2:
        grid = np.arange(clip.frames, dtype=float)
        path, curve = CubicSpline(grid, clip.root_positions), CubicSpline(grid, clip.rotations)
        positions, velocities = path(frame), path(frame, 1) * clip.rate
        q, dq = curve(frame), curve(frame, 1) * clip.rate
        # omega = 2 q^-1 dq/dt; dividing by |q|^2 makes up for the spline's leaving the unit sphere.
        square = np.sum(q * q, axis=-1, keepdims=True)
        rotations = q / np.sqrt(square)
        rates = (2.0 / square) * rot.multiply(rot.conjugate(q), dq)[..., 1:]
    else:
        rotations, positions = edits.sampled(clip, times, method=interpolation)
        velocities, rates = np.zeros((len(times), 3)), np.zeros((*rotations.shape[:2], 3))
        if clip.frames > 1:
            k = np.minimum(frame.astype(int), clip.frames - 2)
            step = rot.multiply(rot.conjugate(clip.rotations[:-1]), clip.rotations[1:])
            velocities = np.diff(clip.root_positions, axis=0)[k] * clip.rate
            rates = rot.to_rotvec(step)[k] * clip.rate
    velocities[resting], rates[resting] = 0.0, 0.0
    return Sampled(positions, velocities, rotations, rates)
