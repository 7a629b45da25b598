"""Paths of hands and moments: what the measurements of the figures are made of."""

from __future__ import annotations

import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.arm import palm
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.take import Take

# In sentences; tables say "paper" and "modern".
LAW_NAMES = {"paper": "the paper's law", "modern": "modern law"}


def hand_path(clip: Clip, side: str = "right") -> Array:
    """Path of the middle of a palm [m], world, of a clip on a character's skeleton, (frames, 3)."""
    joint = f"{side}_wrist"
    pose, i = clip.forward_kinematics(), clip.skeleton.index(joint)
    return pose.positions[:, i] + rot.rotate(pose.rotations[:, i], palm(clip.skeleton, joint))


def hand_of(take: Take, side: str = "right", *, character: int = 0) -> Array:
    """Path of the middle of a palm at every step of a take [m], world, shape (frames, 3)."""
    return hand_path(take.clip(character, rate=take.rate), side)


def at_times(path: Array, times: Array, wanted: Array) -> Array:
    """A path (frames, 3) at other times [s], linear between its own."""
    return np.stack([np.interp(wanted, times, path[:, k]) for k in range(3)], axis=-1)


def speed_of(path: Array, rate: float) -> Array:
    """Speed along a path [m/s], by central differences, shape (frames,)."""
    return np.linalg.norm(np.gradient(path, 1.0 / rate, axis=0), axis=1)


def acceleration_of(path: Array, rate: float) -> Array:
    """Size of the acceleration along a path [m/s^2], by second differences, (frames - 2,)."""
    return np.linalg.norm(np.diff(path, n=2, axis=0), axis=1) * rate * rate


def spread(first: float, last: float, count: int) -> tuple[float, ...]:
    """So many even moments from the first to the last [s]."""
    return tuple(float(t) for t in np.linspace(first, last, count))
