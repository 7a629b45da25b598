"""What the standing samples share: two planted feet, a trunk, and hands placed in the world."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter1d

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.keyframes import STANDING, eased, rotation
from understudy.motion.limbs import place_foot, place_hand
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

RATE = 120.0
"""Frames per second of every sample [Hz]."""
PALM = 0.052
"""Distance of the palm's middle from the wrist, as a fraction of stature."""
HALF_PALM = 0.012
"""Distance of the palm's skin from the hand's middle line, as a fraction of stature."""
FOOT_AT = (-0.03, 0.085)
"""Where the left ankle stands [m]: x and y; the right one is its mirror image."""
TOE_OUT = 8.0
"""How far the feet turn outward [deg]."""
NOTE = "Made from key poses, with both feet planted; not captured."


def trunk(
    turn: ArrayLike, lean: ArrayLike, bend: ArrayLike, gaze: ArrayLike, *, nod: ArrayLike = 0.0
) -> dict[str, dict[str, ArrayLike]]:
    """Angles [deg] of the trunk, and of the head so that it looks `gaze` to the left.

    `nod` [deg] bows the head; without it, it stays nearly level as the trunk leans.
    """
    turn, lean, bend, gaze, nod = (np.asarray(a, float) for a in (turn, lean, bend, gaze, nod))
    return {
        "lower_back": {"turn": 0.4 * turn, "flexion": 0.5 * lean + 1.0, "bend": 0.5 * bend},
        "upper_back": {"turn": 0.6 * turn, "flexion": 0.5 * lean + 1.5, "bend": 0.5 * bend},
        "neck": {"turn": gaze - turn, "flexion": nod - 0.7 * lean - 1.5, "bend": -0.6 * bend},
    }


def set_angles(
    turned: Array, skeleton: Skeleton, angles: Mapping[str, Mapping[str, ArrayLike]]
) -> None:
    """Set joints in `turned` (frames, joints, 4) from angles [deg] by joint and name."""
    for joint, given in angles.items():
        turned[:, skeleton.index(joint)] = rotation(joint, given)


def track(
    times: Array, keys: Mapping[float, float | tuple[float, ...]], *, softness: float = 0.04
) -> Array:
    """A value over `times` [s] through those at key times, rounded off over `softness` [s].

    Shape (frames,) for numbers and (frames, n) for tuples of n.
    """
    knots = np.array(list(keys), float)
    smooth = eased(knots, np.array(list(keys.values()), float), times)
    return gaussian_filter1d(smooth, softness * RATE, axis=0, mode="nearest")


def hand_rotation(yaw: ArrayLike, pitch: ArrayLike, roll: ArrayLike) -> Array:
    """World rotation of a hand: turned forward by `yaw`, rolled about its length, pitched up [rad].

    At rest a hand points sideways with its palm down. The angles broadcast.
    """
    yaw, pitch, roll = np.broadcast_arrays(*(np.asarray(a, float) for a in (yaw, pitch, roll)))
    forward = rot.from_euler("Z", yaw[..., None])
    rolled = rot.multiply(rot.from_euler("X", roll[..., None]), forward)
    return rot.multiply(rot.from_euler("Y", -pitch[..., None]), rolled)


def place_palm(
    turned: Array,
    skeleton: Skeleton,
    side: str,
    root: Array,
    palm: Array,
    elbow: Array,
    hand: Array,
) -> None:
    """Set shoulder, elbow and wrist in `turned` so that the palm's middle is where it should be.

    Args:
        turned: Local rotations, (frames, joints, 4); the arm's three joints are overwritten.
        skeleton: The standard figure.
        side: "left" or "right".
        root: Pelvis position [m], (frames, 3).
        palm: World position [m] of the hand's middle line at the palm, (frames, 3).
        elbow: World direction in which the elbow points, (frames, 3).
        hand: World rotation of the hand, (frames, 4).
    """
    wrist = palm - rot.rotate(hand, palm_offset(skeleton, side))
    place_hand(
        turned, skeleton, side, chest_of(skeleton, turned, root), wrist,
        np.broadcast_to(elbow, wrist.shape), hand,
    )  # fmt: skip


def palm_offset(skeleton: Skeleton, side: str) -> Array:
    """The palm's middle from the wrist, in the hand's frame [m], shape (3,)."""
    end = skeleton.end_joints.index(skeleton.index(f"{side}_wrist"))
    tip = skeleton.end_offsets[end]
    return tip * (PALM / 0.108)  # the hand is .108 statures long, see `figure`


def palms(clip: Clip) -> dict[str, Array]:
    """World positions [m] of the middle of both palms by side, each (frames, 3)."""
    pose, skeleton = clip.forward_kinematics(), clip.skeleton
    found = {}
    for side in ("left", "right"):
        wrist = skeleton.index(f"{side}_wrist")
        arm = rot.rotate(pose.rotations[:, wrist], palm_offset(skeleton, side))
        found[side] = pose.positions[:, wrist] + arm
    return found


def posed(skeleton: Skeleton, frames: int) -> Array:
    """Local rotations of someone standing, shape (frames, joints, 4)."""
    turned = rot.identity(frames, len(skeleton))
    set_angles(turned, skeleton, STANDING)
    return turned


def planted(
    skeleton: Skeleton,
    turned: Array,
    times: Array,
    aside: Array,
    ahead: Array,
    turn: Array,
    *,
    down: ArrayLike = 0.0,
    restless: float = 1.0,
) -> tuple[Array, Array]:
    """Legs closed on two feet that do not move, under a pelvis that shifts [m] and turns [rad].

    Adds quiet standing's sway, a few millimeters, times `restless`. The feet are 17 cm apart and
    toed out by 8 degrees. The knees give by `down` [m].
    """
    sway = [
        sum(a * np.sin(2.0 * np.pi * f * times + p) for a, f, p in waves)
        for waves in (
            ((2.2, 0.17, 0.3), (1.2, 0.41, 1.9), (0.5, 0.83, 4.0)),
            ((2.6, 0.13, 2.2), (1.0, 0.37, 0.4), (0.5, 0.71, 1.2)),
        )
    ]
    x, y = ahead + 0.001 * restless * sway[0], aside + 0.001 * restless * sway[1]
    # The pelvis rides down a little as it moves over one leg, and tips to the other.
    height = skeleton.offsets[0][2] - 0.010 - 0.12 * np.abs(y) - 2.0 * (x * x + y * y)
    root = np.stack((x - 0.01, y, height - np.asarray(down, float)), axis=-1)
    turned[:, 0] = rot.from_euler("ZX", np.stack((turn, 0.9 * y), axis=-1))
    stand(skeleton, turned, root)
    return turned, root


def stand(skeleton: Skeleton, turned: Array, root: Array) -> None:
    """Close both legs in `turned` on the planted feet, under a pelvis at `root` [m]."""
    ankle_height = skeleton.rest_positions()[skeleton.index("left_ankle")][2]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        ankle = np.broadcast_to([FOOT_AT[0], FOOT_AT[1] * sign, ankle_height], root.shape)
        foot = rot.from_euler("Z", np.full((len(root), 1), sign * np.radians(TOE_OUT)))
        place_foot(turned, skeleton, side, root, ankle, foot)


def chest_of(skeleton: Skeleton, turned: Array, root: Array) -> tuple[Array, Array]:
    """World position and rotation of the upper back."""
    low, high = skeleton.index("lower_back"), skeleton.index("upper_back")
    turn = rot.multiply(turned[:, 0], turned[:, low])
    position = root + rot.rotate(turned[:, 0], skeleton.offsets[low])
    position = position + rot.rotate(turn, skeleton.offsets[high])
    return position, rot.multiply(turn, turned[:, high])


def made(name: str, skeleton: Skeleton, turned: Array, root: Array, what: str) -> Clip:
    """The clip, with notes that say that it was made and `what` happens in it."""
    return Clip(
        skeleton=skeleton,
        rotations=turned,
        root_positions=root,
        rate=RATE,
        name=name,
        synthetic=True,
        notes=(NOTE, what),
    )
