"""A bow from standing, held, and back."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.rotations import Array
from understudy.motion.samples.standing import (
    FOOT_AT,
    RATE,
    made,
    posed,
    set_angles,
    stand,
)
from understudy.motion.skeleton import Skeleton

HELD = (3.3, 5.3)
"""From when to when the bow is held [s]."""
_LASTS = 9.0
# Of the tilt, how much each part gives [deg per deg]. Most of a bow with straight knees is in the
# hips; of what the spine gives two thirds are lumbar.
_SHARES = {"pelvis": 0.70, "lower_back": 0.24, "upper_back": 0.16}
# The hips go back, so that the body stays over the feet: this far for a tilt of a right angle, in
# statures.
_BACK = 0.115
_KNEES = 6.0


def bow(degrees: float = 60.0) -> Clip:
    """Stands, bows, holds the bow for two seconds and comes back up (9 s).

    Args:
        degrees: How far the trunk tilts forward while the bow is held: the angle of the line from
            the pelvis joint to the neck joint from the vertical [deg], see `trunk_tilt`.

    Raises:
        InvalidValue: A tilt that is not between 0 and 110 degrees.
    """
    if not 0.0 < degrees <= 110.0:
        raise InvalidValue(f"degrees is {degrees}; a bow tilts the trunk by 0 to 110 degrees.")
    skeleton, times = figure(), np.arange(round(_LASTS * RATE) + 1) / RATE
    turned = posed(skeleton, len(times))
    upright, full = _whole(skeleton, 0.0), _whole(skeleton, degrees)
    # The head starts, hips and trunk follow, the arms hang and come last.
    down = _course(times, 0.0)
    sway = _sway(times)
    tilt = upright + (full - upright) * down + sway[0]
    chest = sum(_SHARES.values()) * tilt
    head = (0.10 * full * _course(times, -0.12) + 3.0 * _course(times, 0.15)) / 1.0
    hang = 0.80 * sum(_SHARES.values()) * full * _course(times, 0.10) - 0.03 * chest
    arms = {}
    for side, sign in (("left", 1.0), ("right", -1.0)):
        arms |= {
            f"{side}_shoulder": {
                "abduction": 7.0 - 3.0 * down + 0.6 * sign,
                "flexion": 2.0 + hang * (1.0 + 0.015 * sign),
                "rotation": 6.0 * down,
            },
            f"{side}_elbow": {"flexion": 14.0 + 5.0 * down - sign, "pronation": 12.0 + 14.0 * down},
            f"{side}_wrist": {"flexion": 4.0 + 8.0 * down},
        }
    set_angles(
        turned,
        skeleton,
        {
            "lower_back": {"flexion": _SHARES["lower_back"] * tilt, "bend": sway[1]},
            "upper_back": {"flexion": _SHARES["upper_back"] * tilt, "turn": 1.2 * down},
            "neck": {"flexion": head - 1.5, "turn": -1.5 * down, "bend": -0.6 * sway[1]},
            **arms,
        },
    )
    pitch = np.radians(_SHARES["pelvis"] * tilt)
    turned[:, 0] = rot.from_euler("Y", pitch[:, None])
    root = _hips(skeleton, turned, pitch, 0.002 * sway)
    stand(skeleton, turned, root)
    return made(
        "bow", skeleton, turned, root, f"Bows by {degrees:g} degrees of trunk tilt, held for 2 s."
    )


def trunk_tilt(clip: Clip) -> Array:
    """Angle of the line from the pelvis joint to the neck joint from the vertical [deg], (frames,).

    Of a clip on the standard figure, or with its joint names.
    """
    pose, skeleton = clip.forward_kinematics(), clip.skeleton
    line = pose.positions[:, skeleton.index("neck")] - pose.positions[:, skeleton.index("pelvis")]
    return np.degrees(np.arctan2(np.linalg.norm(line[:, :2], axis=-1), line[:, 2]))


def _whole(skeleton: Skeleton, degrees: float) -> float:
    """What the parts share [deg] so that the line from pelvis to neck tilts by `degrees`."""
    joints = [skeleton.index(j) for j in ("lower_back", "upper_back", "neck")]
    lengths = skeleton.offsets[joints, 2]

    def beyond(whole: float) -> float:
        pitches = np.radians(whole * np.cumsum(list(_SHARES.values())))
        ahead, up = float(lengths @ np.sin(pitches)), float(lengths @ np.cos(pitches))
        return math.degrees(math.atan2(ahead, up)) - degrees

    return float(np.asarray(brentq(beyond, -10.0, 160.0)))


def _course(times: Array, late: float) -> Array:
    """How far the bow has gone, 0 to 1, `late` [s] behind: down in two seconds, up in two."""
    t = times - late
    start, end = HELD[0] - 2.0, HELD[1] + 2.1

    def ease(s: Array) -> Array:
        s = np.clip(s, 0.0, 1.0)
        return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)

    # Down a little faster at first than at the end, up likewise.
    warp = 0.85
    down = ease(np.clip((t - start) / (HELD[0] - start), 0.0, 1.0) ** warp)
    up = ease(np.clip((t - HELD[1]) / (end - HELD[1]), 0.0, 1.0) ** warp)
    return down - up


def _sway(times: Array) -> Array:
    """Quiet standing's small movements [deg], forward and to the left, shape (2, frames)."""
    forward = 0.25 * np.sin(2.0 * np.pi * times / 3.7) + 0.12 * np.sin(2.0 * np.pi * times / 1.7)
    left = 0.35 * np.sin(2.0 * np.pi * times / 5.1 + 1.0) + 0.1 * np.sin(2.0 * np.pi * times / 2.2)
    return np.stack((forward, left))


def _hips(skeleton: Skeleton, turned: Array, pitch: Array, sway: Array) -> Array:
    """Pelvis path [m]: the hips go back over straight legs as the pelvis tips, (frames, 3)."""
    hip, knee, ankle = (
        skeleton.offsets[skeleton.index(f"left_{j}")] for j in ("hip", "knee", "ankle")
    )
    rise = skeleton.rest_positions()[skeleton.index("left_ankle")][2]
    stature = skeleton.offsets[0][2] / 0.55
    x = -0.01 - _BACK * stature * np.sin(pitch) / np.sin(np.radians(70.0)) + sway[0]
    # The leg's length with knees that bend a little more in the bow.
    bend = np.radians(_KNEES + 4.0 * np.sin(pitch))
    a, b = abs(knee[2]), abs(ankle[2])
    leg = np.sqrt(a * a + b * b + 2.0 * a * b * np.cos(bend))
    # Feet a little farther apart than the hips: measured in the plane of the two ends.
    apart = FOOT_AT[1] - hip[1] + np.abs(sway[1])
    z = rise + np.sqrt(leg**2 - (x - FOOT_AT[0]) ** 2 - apart**2)
    middle = np.stack((x, sway[1], z), axis=-1)
    return middle - rot.rotate(turned[:, 0], np.array([0.0, 0.0, hip[2]]))
