"""A wave and a point: free gestures of both arms, standing."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.keyframes import STANDING, Key, eased, keyframed, rotation
from understudy.motion.rotations import Array
from understudy.motion.samples.standing import RATE, made, planted, trunk


def gesture() -> Clip:
    """A wave with the right hand, then pointing ahead and to the left."""
    raised = {"abduction": 62.0, "flexion": 24.0, "rotation": -66.0}
    keys = [
        Key(time=0.0, pose={**STANDING, **trunk(0, 0, 0, 0)}),
        Key(
            time=0.4,
            pose={
                "right_shoulder": {"abduction": 9, "flexion": 3},
                "right_elbow": {"flexion": 18, "pronation": 12},
                "right_wrist": {"flexion": 6},
                **trunk(0, 1, 1, -3),
            },
        ),
        Key(time=1.0, pose={"right_shoulder": raised, **trunk(-4, 0, 3, -9)}),
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
        Key(time=1.9, pose=trunk(-5, 1, 3, -8)),
        Key(time=2.95, pose={"left_shoulder": {"abduction": 9, "flexion": -2},
                             "left_elbow": {"flexion": 20, "pronation": 14},
                             "left_wrist": {"flexion": 8}}),
        Key(time=3.0, pose={"right_shoulder": {"abduction": 22, "flexion": 22, "rotation": -8},
                            **trunk(2, 1, 0, 6)}),
        Key(time=3.05, pose={"right_elbow": {"flexion": 58, "pronation": 20},
                             "right_wrist": {"flexion": 10}}),
        Key(time=3.5, pose={"right_shoulder": STANDING["right_shoulder"],
                            "left_shoulder": {"flexion": 62, "abduction": 20, "rotation": 14},
                            "left_elbow": {"flexion": 58, "pronation": 46},
                            "left_wrist": {"flexion": 14}, **trunk(9, 2, -2, 22)}),
        Key(time=3.6, pose={"right_elbow": STANDING["right_elbow"],
                            "right_wrist": STANDING["right_wrist"]}),
        Key(time=3.9, pose={"left_shoulder": pointing,
                            "left_elbow": {"flexion": 9, "pronation": 66},
                            "left_wrist": {"flexion": -6}, **trunk(12, 3, -2, 21)}),
        Key(time=4.3, pose={"left_shoulder": {**pointing, "flexion": 90},
                            "left_elbow": {"flexion": 12, "pronation": 66},
                            "left_wrist": {"flexion": -2}, **trunk(11, 3, -2, 19)}),
        Key(time=4.7, pose={"left_shoulder": {**pointing, "flexion": 87},
                            "left_elbow": {"flexion": 11, "pronation": 64},
                            "left_wrist": {"flexion": 0}, **trunk(10, 3, -2, 12)}),
        Key(time=5.15, pose={"left_shoulder": {"flexion": 38, "abduction": 14, "rotation": 4},
                             "left_elbow": {"flexion": 42, "pronation": 34},
                             "left_wrist": {"flexion": 14}, **trunk(4, 1, 0, 2)}),
        Key(time=5.65, pose={**{j: a for j, a in STANDING.items() if j.startswith("left")},
                             **trunk(0, 0, 0, -1)}),
        Key(time=6.0, pose={**STANDING, **trunk(0, 0, 0, 0)}),
    ]  # fmt: skip
    keys.sort(key=lambda key: key.time)
    arms = keyframed(keys, rate=RATE)
    # Weight goes to the left while the right arm is up, then forward and over the left foot.
    at = np.array([0.0, 0.4, 1.0, 2.0, 2.7, 3.3, 3.9, 4.7, 5.4, 6.0])
    aside = eased(at, np.array([0, -8, 22, 26, 20, -6, 12, 14, 4, 0.0]), arms.times) / 1000.0
    ahead = eased(at, np.array([0, -4, 2, 4, 0, -6, 14, 12, 0, 0.0]), arms.times) / 1000.0
    turn = np.radians(eased(at, np.array([0, 0, -3, -3, -1, 2, 6, 6, 1, 0.0]), arms.times))
    # Muscles round off what monotone cubics leave: accelerations that step at the keys.
    turned = rot.normalized(gaussian_filter1d(arms.rotations, 0.03 * RATE, axis=0, mode="nearest"))
    aside, ahead, turn = (
        gaussian_filter1d(track, 0.1 * RATE, mode="nearest") for track in (aside, ahead, turn)
    )
    return _standing("gesture", turned, aside, ahead, turn)


def _standing(name: str, turned: Array, aside: Array, ahead: Array, turn: Array) -> Clip:
    skeleton, times = figure(), np.arange(len(turned)) / RATE
    breath = 0.6 * np.sin(2.0 * np.pi * times / 3.7)
    chest = skeleton.index("upper_back")
    turned[:, chest] = rot.multiply(turned[:, chest], rotation("upper_back", {"flexion": -breath}))
    turned, root = planted(skeleton, turned, times, aside, ahead, turn)
    what = "Stands, waves with the right hand, points ahead with the left."
    return made(name, skeleton, turned, root, what)
