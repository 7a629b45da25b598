"""Clips to begin with, made on the spot: no file, no download, nobody's copyright.

`sample("walk")` gives a clip on the standard figure at 120 Hz; each says in its notes that it was
made and from what.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.ndimage import gaussian_filter1d

from understudy.errors import UnknownName, expect
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.gait import walk
from understudy.motion.keyframes import STANDING, Key, eased, keyframed, rotation
from understudy.motion.limbs import place_foot, place_hand
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

_RATE = 120.0


def samples() -> tuple[str, ...]:
    """Names of the clips that come with the package."""
    return tuple(_MAKERS)


def sample(name: str) -> Clip:
    """A clip that comes with the package, on the standard figure (1.75 m), 120 Hz.

    "gesture": stands, waves, points (6 s). "walk": level walking at 1.32 m/s (5 s). "drumming":
    both hands in turn, 5 strokes a second (5 s). "clapping": two claps a second (5 s).

    Raises:
        UnknownName: Another name; the text lists those there are.
    """
    expect(name, str, "name", f"one of {', '.join(_MAKERS)}")
    if name not in _MAKERS:
        raise UnknownName("sample", name, _MAKERS)
    return _MAKERS[name]()


def _gesture() -> Clip:
    """A wave with the right hand, then pointing ahead and to the left."""
    raised = {"abduction": 62.0, "flexion": 24.0, "rotation": -66.0}
    keys = [
        Key(time=0.0, pose={**STANDING, **_trunk(0, 0, 0, 0)}),
        Key(
            time=0.4,
            pose={
                "right_shoulder": {"abduction": 9, "flexion": 3},
                "right_elbow": {"flexion": 18, "pronation": 12},
                "right_wrist": {"flexion": 6},
                **_trunk(0, 1, 1, -3),
            },
        ),
        Key(time=1.0, pose={"right_shoulder": raised, **_trunk(-4, 0, 3, -9)}),
    ]
    # Two waves a second: the forearm leads, the hand follows.
    for k, time in enumerate(np.arange(1.0, 2.61, 0.25)):
        side = 1.0 if k % 2 else -1.0
        size = (0.7, 1.0, 1.0, 1.0, 0.9, 0.7, 0.4)[k]
        keys.append(
            Key(
                time=time + 0.002,
                pose={
                    "right_elbow": {
                        "flexion": 84 + 19 * side * size,
                        "pronation": 4.0 - 6 * side * size,
                    },
                },
            )
        )
        keys.append(
            Key(
                time=time + 0.06,
                pose={
                    "right_wrist": {"deviation": 16.0 * side * size, "flexion": -8.0},
                },
            )
        )
        keys.append(
            Key(
                time=time + 0.03,
                pose={
                    "right_shoulder": {**raised, "rotation": -66.0 - 6 * side * size},
                },
            )
        )
    pointing = {"flexion": 88, "abduction": 26, "rotation": 8}
    keys += [
        Key(time=1.9, pose=_trunk(-5, 1, 3, -8)),
        Key(time=2.95, pose={"left_shoulder": {"abduction": 9, "flexion": -2},
                             "left_elbow": {"flexion": 20, "pronation": 14},
                             "left_wrist": {"flexion": 8}}),
        Key(time=3.0, pose={"right_shoulder": {"abduction": 22, "flexion": 22, "rotation": -8},
                            **_trunk(2, 1, 0, 6)}),
        Key(time=3.05, pose={"right_elbow": {"flexion": 58, "pronation": 20},
                             "right_wrist": {"flexion": 10}}),
        Key(time=3.5, pose={"right_shoulder": STANDING["right_shoulder"],
                            "left_shoulder": {"flexion": 62, "abduction": 20, "rotation": 14},
                            "left_elbow": {"flexion": 58, "pronation": 46},
                            "left_wrist": {"flexion": 14}, **_trunk(9, 2, -2, 22)}),
        Key(time=3.6, pose={"right_elbow": STANDING["right_elbow"],
                            "right_wrist": STANDING["right_wrist"]}),
        Key(time=3.9, pose={"left_shoulder": pointing,
                            "left_elbow": {"flexion": 9, "pronation": 66},
                            "left_wrist": {"flexion": -6}, **_trunk(12, 3, -2, 21)}),
        Key(time=4.3, pose={"left_shoulder": {**pointing, "flexion": 90},
                            "left_elbow": {"flexion": 12, "pronation": 66},
                            "left_wrist": {"flexion": -2}, **_trunk(11, 3, -2, 19)}),
        Key(time=4.7, pose={"left_shoulder": {**pointing, "flexion": 87},
                            "left_elbow": {"flexion": 11, "pronation": 64},
                            "left_wrist": {"flexion": 0}, **_trunk(10, 3, -2, 12)}),
        Key(time=5.15, pose={"left_shoulder": {"flexion": 38, "abduction": 14, "rotation": 4},
                             "left_elbow": {"flexion": 42, "pronation": 34},
                             "left_wrist": {"flexion": 14}, **_trunk(4, 1, 0, 2)}),
        Key(time=5.65, pose={**{j: a for j, a in STANDING.items() if j.startswith("left")},
                             **_trunk(0, 0, 0, -1)}),
        Key(time=6.0, pose={**STANDING, **_trunk(0, 0, 0, 0)}),
    ]  # fmt: skip
    keys.sort(key=lambda key: key.time)
    arms = keyframed(keys, rate=_RATE)
    # Weight goes to the left while the right arm is up, then forward and over the left foot.
    at = np.array([0.0, 0.4, 1.0, 2.0, 2.7, 3.3, 3.9, 4.7, 5.4, 6.0])
    aside = eased(at, np.array([0, -8, 22, 26, 20, -6, 12, 14, 4, 0.0]), arms.times) / 1000.0
    ahead = eased(at, np.array([0, -4, 2, 4, 0, -6, 14, 12, 0, 0.0]), arms.times) / 1000.0
    turn = np.radians(eased(at, np.array([0, 0, -3, -3, -1, 2, 6, 6, 1, 0.0]), arms.times))
    # Muscles round off what monotone cubics leave: accelerations that step at the keys.
    turned = rot.normalized(gaussian_filter1d(arms.rotations, 0.03 * _RATE, axis=0, mode="nearest"))
    aside, ahead, turn = (
        gaussian_filter1d(track, 0.1 * _RATE, mode="nearest") for track in (aside, ahead, turn)
    )
    return _standing("gesture", turned, aside, ahead, turn)


def _trunk(turn: float, lean: float, bend: float, gaze: float) -> dict[str, dict[str, float]]:
    """Angles [deg] of the trunk, and of the head so that it looks `gaze` to the left."""
    return {
        "lower_back": {"turn": 0.4 * turn, "flexion": 0.5 * lean + 1.0, "bend": 0.5 * bend},
        "upper_back": {"turn": 0.6 * turn, "flexion": 0.5 * lean + 1.5, "bend": 0.5 * bend},
        "neck": {"turn": gaze - turn, "flexion": -0.7 * lean - 1.5, "bend": -0.6 * bend},
    }


def _drumming() -> Clip:
    """Strokes of the left and right hand in turn on a drum in front, standing."""
    skeleton, times = figure(), np.arange(601) / _RATE
    turned = _posed(skeleton, len(times))
    beat = 2.5 * times
    loud = 1.0 + 0.22 * np.sin(2.0 * np.pi * times / 1.6) + 0.1 * np.sin(2.0 * np.pi * times / 0.7)
    nod = np.cos(4.0 * np.pi * beat)
    for joint, angles in {
        "lower_back": {"flexion": 4.0 + 0.5 * nod, "turn": 1.2 * np.sin(2.0 * np.pi * beat)},
        "upper_back": {
            "flexion": 6.0 + 0.8 * nod,
            "turn": 2.0 * np.sin(2.0 * np.pi * beat),
            "bend": 1.0 * np.sin(2.0 * np.pi * beat - 0.5),
        },
        "neck": {
            "flexion": 9.0 + 2.2 * np.cos(4.0 * np.pi * beat - 0.9),
            "turn": 6.0 * np.sin(2.0 * np.pi * times / 3.1),
        },
    }.items():
        turned[:, skeleton.index(joint)] = rotation(joint, angles)
    aside = 0.006 * np.sin(2.0 * np.pi * (beat - 0.1))
    turned, root = _planted(skeleton, turned, times, aside, 0.0 * times, 0.0 * times)
    chest = _chest(skeleton, turned, root)
    for side, sign, start in (("left", 1.0, 0.0), ("right", -1.0, 0.5)):
        phase = beat + start
        lift, whip = _stroke(phase) * loud, _stroke(phase - 0.07) * loud
        wrist = np.stack(
            (0.31 - 0.02 * lift, sign * (0.17 + 0.02 * lift), 0.975 + 0.055 * lift), axis=-1
        )
        elbow = np.broadcast_to([-0.7, 0.55 * sign, -0.4], wrist.shape)
        pitch = np.radians(-15.0 + 42.0 * whip)
        hand = _hand(np.full_like(pitch, -sign * np.radians(101.0)), pitch, 0.0 * pitch)
        place_hand(turned, skeleton, side, chest, wrist, elbow, hand)
    return _made("drumming", skeleton, turned, root)


def _stroke(phase: Array) -> Array:
    """Height of the hand over a stroke, 0 at the hit (whole phases) to 1; falls faster."""
    turn = 2.0 * np.pi * phase
    return (0.5 - 0.5 * np.cos(turn - 0.45 * np.sin(turn) - 0.22 * (1.0 - np.cos(turn)))) ** 1.2


def _clapping() -> Clip:
    """Two claps a second, palms meeting in front of the chest."""
    skeleton, times = figure(), np.arange(601) / _RATE
    turned = _posed(skeleton, len(times))
    beat = 2.0 * times + 0.5
    loud = 1.0 + 0.1 * np.sin(2.0 * np.pi * times / 1.9) + 0.06 * np.sin(2.0 * np.pi * times / 0.83)
    nod = np.cos(2.0 * np.pi * beat - 0.4)
    for joint, angles in {
        "lower_back": {"flexion": 1.5 + 0.4 * nod},
        "upper_back": {"flexion": 2.0 + 0.9 * nod, "turn": 1.5 * np.sin(2.0 * np.pi * times / 2.7)},
        "neck": {
            "flexion": 1.0 + 1.6 * np.cos(2.0 * np.pi * beat - 1.0),
            "turn": 5.0 * np.sin(2.0 * np.pi * times / 3.3),
        },
    }.items():
        turned[:, skeleton.index(joint)] = rotation(joint, angles)
    aside = 0.008 * np.sin(2.0 * np.pi * times / 1.0)
    turned, root = _planted(skeleton, turned, times, aside, 0.0 * times, 0.0 * times)
    chest = _chest(skeleton, turned, root)
    # The hands come together at about the same speed until they meet: a rounded |sine|.
    apart = np.sqrt(np.sin(np.pi * beat) ** 2 + 0.14**2) - 0.14
    late = np.sqrt(np.sin(np.pi * (beat - 0.05)) ** 2 + 0.3**2) - 0.3
    middle = chest[0][:, 1]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        y = middle + sign * (0.026 + 0.19 * loud * apart)
        x = chest[0][:, 0] + 0.33 - 0.03 * apart
        wrist = np.stack((x, y, 1.17 + 0.012 * sign * apart + 0.02 * apart), axis=-1)
        elbow = np.broadcast_to([-0.35, 0.8 * sign, -0.9], wrist.shape)
        yaw = -sign * np.radians(90.0 - 10.0 * late)
        hand = _hand(
            yaw, np.radians(38.0 + 4.0 * sign + 0.0 * late), -sign * np.radians(82.0 - 10.0 * late)
        )
        place_hand(turned, skeleton, side, chest, wrist, elbow, hand)
    return _made("clapping", skeleton, turned, root)


def _hand(yaw: Array, pitch: Array, roll: Array) -> Array:
    """World rotation of a hand: turned forward by `yaw`, rolled about its length, pitched up [rad].

    At rest a hand points sideways with its palm down.
    """
    forward = rot.from_euler("Z", yaw[:, None])
    rolled = rot.multiply(rot.from_euler("X", np.broadcast_to(roll, yaw.shape)[:, None]), forward)
    return rot.multiply(rot.from_euler("Y", -np.broadcast_to(pitch, yaw.shape)[:, None]), rolled)


def _posed(skeleton: Skeleton, frames: int) -> Array:
    """Local rotations of someone standing, shape (frames, joints, 4)."""
    turned = rot.identity(frames, len(skeleton))
    for joint, angles in STANDING.items():
        turned[:, skeleton.index(joint)] = rotation(joint, angles)
    return turned


def _standing(name: str, turned: Array, aside: Array, ahead: Array, turn: Array) -> Clip:
    skeleton, times = figure(), np.arange(len(turned)) / _RATE
    breath = 0.6 * np.sin(2.0 * np.pi * times / 3.7)
    chest = skeleton.index("upper_back")
    turned[:, chest] = rot.multiply(turned[:, chest], rotation("upper_back", {"flexion": -breath}))
    turned, root = _planted(skeleton, turned, times, aside, ahead, turn)
    return _made(name, skeleton, turned, root)


def _planted(
    skeleton: Skeleton, turned: Array, times: Array, aside: Array, ahead: Array, turn: Array
) -> tuple[Array, Array]:
    """Legs closed on two feet that do not move, under a pelvis that shifts [m] and turns [rad].

    Adds quiet standing's sway, a few millimeters. The feet are 17 cm apart and toed out by 8
    degrees.
    """
    sway = [
        sum(a * np.sin(2.0 * np.pi * f * times + p) for a, f, p in waves)
        for waves in (
            ((2.2, 0.17, 0.3), (1.2, 0.41, 1.9), (0.5, 0.83, 4.0)),
            ((2.6, 0.13, 2.2), (1.0, 0.37, 0.4), (0.5, 0.71, 1.2)),
        )
    ]
    x, y = ahead + 0.001 * sway[0], aside + 0.001 * sway[1]
    # The pelvis rides down a little as it moves over one leg, and tips to the other.
    height = skeleton.offsets[0][2] - 0.010 - 0.12 * np.abs(y) - 2.0 * (x * x + y * y)
    root = np.stack((x - 0.01, y, height), axis=-1)
    turned[:, 0] = rot.from_euler("ZX", np.stack((turn, 0.9 * y), axis=-1))
    ankle_height = skeleton.rest_positions()[skeleton.index("left_ankle")][2]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        ankle = np.broadcast_to([-0.03, 0.085 * sign, ankle_height], root.shape)
        foot = rot.from_euler("Z", np.full((len(times), 1), sign * np.radians(8.0)))
        place_foot(turned, skeleton, side, root, ankle, foot)
    return turned, root


def _chest(skeleton: Skeleton, turned: Array, root: Array) -> tuple[Array, Array]:
    """World position and rotation of the upper back."""
    low, high = skeleton.index("lower_back"), skeleton.index("upper_back")
    turn = rot.multiply(turned[:, 0], turned[:, low])
    position = root + rot.rotate(turned[:, 0], skeleton.offsets[low])
    position = position + rot.rotate(turn, skeleton.offsets[high])
    return position, rot.multiply(turn, turned[:, high])


def _made(name: str, skeleton: Skeleton, turned: Array, root: Array) -> Clip:
    return Clip(
        skeleton=skeleton,
        rotations=turned,
        root_positions=root,
        rate=_RATE,
        name=name,
        synthetic=True,
        notes=("Made from key poses, with both feet planted; not captured.",),
    )


_MAKERS: dict[str, Callable[[], Clip]] = {
    "gesture": _gesture,
    "walk": walk,
    "drumming": _drumming,
    "clapping": _clapping,
}
