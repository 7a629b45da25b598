"""Angles of the legs and the trunk in the plane of travel, and how near the legs come.

Signs and definitions are those of the published tables (`understudy.evaluate.people`): flexion,
dorsiflexion, forward swing, forward lean and toe up are positive; thigh and shank are measured
along the bones from the vertical, the foot from flat, pelvis and trunk from the neutral stance.
"""

from __future__ import annotations

import numpy as np

from understudy.evaluate.gait_body import SIDES, Mover, trunk_end
from understudy.motion.rotations import Array

ANGLES = ("hip", "thigh", "knee", "ankle", "foot", "pelvis", "trunk")
"""The curves of a cycle: hip flexion, thigh forward of the vertical, knee flexion, ankle
dorsiflexion, foot toe up, pelvis anterior tilt, trunk lean."""
STILL = 0.3
"""A body that gets no further than this in a cycle [m] is going nowhere: it faces its pelvis."""


def travel(mover: Mover, frames: slice) -> Array:
    """Velocity on the ground over a stretch of frames [m/s], z being 0, shape (frames, 3).

    The derivative of the parabola that fits the path of the center of mass best: a straight line or
    an even turn at an even change of speed, without the sway of the steps.
    """
    path = mover.center_of_mass[frames, :2]
    time = mover.times[frames] - mover.times[frames].mean()
    fit = np.polynomial.polynomial.polyfit(time, path, min(2, len(path) - 1))
    slope = np.concatenate((fit, np.zeros((2, 2))))
    return np.pad(slope[1] + 2.0 * slope[2] * time[:, None], ((0, 0), (0, 1)))


def heading(mover: Mover, frames: slice) -> Array:
    """Unit vectors of travel on the ground over a stretch of frames, shape (frames, 3).

    A body that goes nowhere travels where its pelvis faces.
    """
    path = mover.center_of_mass[frames, :2]
    way = travel(mover, frames)
    if np.linalg.norm(path[-1] - path[0]) <= STILL:
        facing = mover.axis("pelvis", (1, 0, 0))[frames, :2].mean(axis=0)
        way = np.broadcast_to(np.append(facing, 0.0), way.shape)
    return way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)


def across(ahead: Array) -> Array:
    """Unit vectors to the left of the way of travel, shape (frames, 3)."""
    return np.stack((-ahead[:, 1], ahead[:, 0], np.zeros(len(ahead))), axis=1)


def angles(mover: Mover, side: str, frames: slice, ahead: Array) -> dict[str, Array]:
    """The curves named in `ANGLES` for one leg [rad], each of shape (frames,).

    Args:
        mover: Who moves.
        side: Whose leg.
        frames: Which frames.
        ahead: Ways of travel in those frames, from `heading`.
    """
    hip, knee, ankle = (mover.at(f"{side}_{joint}")[frames] for joint in ("hip", "knee", "ankle"))
    thigh = _hanging(knee - hip, ahead)
    shank = _hanging(ankle - knee, ahead)
    foot = _raised(mover.axis(f"{side}_ankle", (1, 0, 0))[frames], ahead)
    pelvis = -_raised(mover.axis("pelvis", (1, 0, 0))[frames], ahead)
    hips = 0.5 * (mover.at("left_hip") + mover.at("right_hip"))[frames]
    trunk = mover.positions[frames, trunk_end(mover.roles)] - hips
    return {
        "hip": _wrapped(thigh + pelvis),
        "thigh": thigh,
        "knee": _wrapped(thigh - shank),
        "ankle": _wrapped(foot - shank),
        "foot": foot,
        "pelvis": pelvis,
        "trunk": np.arctan2(np.sum(trunk * ahead, axis=1), trunk[:, 2]) - mover.upright,
    }


def _hanging(bone: Array, ahead: Array) -> Array:
    """How far a bone swings forward of hanging straight down [rad]."""
    return np.arctan2(np.sum(bone * ahead, axis=1), -bone[:, 2])


def _raised(axis: Array, ahead: Array) -> Array:
    """How far a forward axis points up [rad]."""
    return np.arctan2(axis[:, 2], np.sum(axis * ahead, axis=1))


def _wrapped(angle: Array) -> Array:
    """Within half a turn of zero."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


def legs_apart(mover: Mover) -> Array:
    """Least distance of the axes of the two lower legs and feet [m], shape (frames,).

    Axes are the lines from knee to ankle and from ankle to the ball of the foot.
    """
    lines = {
        side: (
            (mover.at(f"{side}_knee"), mover.at(f"{side}_ankle")),
            (mover.at(f"{side}_ankle"), mover.forefoot(side)),
        )
        for side in SIDES
    }
    each = [_distance(*one, *two) for one in lines["left"] for two in lines["right"]]
    return np.min(each, axis=0)


def _distance(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Least distance between segments a-b and c-d [m]; points of shape (frames, 3).

    The two points nearest each other lie inside both segments, or one of them is an end.
    """
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = (np.sum(x * y, axis=1) for x, y in ((u, u), (u, v), (v, v)))
    uw, vw = np.sum(u * w, axis=1), np.sum(v * w, axis=1)
    area = uu * vv - uv**2
    safe = area > 1e-12
    s = np.where(safe, (uv * vw - vv * uw) / np.where(safe, area, 1.0), -1.0)
    t = np.where(safe, (uu * vw - uv * uw) / np.where(safe, area, 1.0), -1.0)
    inside = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    lines = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)
    ends = np.min(
        [_to_segment(p, c, d) for p in (a, b)] + [_to_segment(p, a, b) for p in (c, d)], 0
    )
    return np.where(inside, lines, ends)


def _to_segment(point: Array, a: Array, b: Array) -> Array:
    """Distance of points from segments a-b [m]."""
    way = b - a
    length = np.maximum(np.sum(way * way, axis=1), 1e-12)
    share = np.clip(np.sum((point - a) * way, axis=1) / length, 0.0, 1.0)
    return np.linalg.norm(point - a - share[:, None] * way, axis=1)
