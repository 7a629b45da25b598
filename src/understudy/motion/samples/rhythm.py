"""Drumming with both hands, and clapping: the same movement at every beat, standing."""

from __future__ import annotations

import numpy as np

from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.keyframes import rotation
from understudy.motion.limbs import place_hand
from understudy.motion.rotations import Array
from understudy.motion.samples.standing import RATE, chest_of, hand_rotation, made, planted, posed


def drumming() -> Clip:
    """Strokes of the left and right hand in turn on a drum in front, standing."""
    skeleton, times = figure(), np.arange(601) / RATE
    turned = posed(skeleton, len(times))
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
    turned, root = planted(skeleton, turned, times, aside, 0.0 * times, 0.0 * times)
    chest = chest_of(skeleton, turned, root)
    for side, sign, start in (("left", 1.0, 0.0), ("right", -1.0, 0.5)):
        phase = beat + start
        lift, whip = _stroke(phase) * loud, _stroke(phase - 0.07) * loud
        wrist = np.stack(
            (0.31 - 0.02 * lift, sign * (0.17 + 0.02 * lift), 0.975 + 0.055 * lift), axis=-1
        )
        elbow = np.broadcast_to([-0.7, 0.55 * sign, -0.4], wrist.shape)
        pitch = np.radians(-15.0 + 42.0 * whip)
        hand = hand_rotation(np.full_like(pitch, -sign * np.radians(101.0)), pitch, 0.0 * pitch)
        place_hand(turned, skeleton, side, chest, wrist, elbow, hand)
    return made("drumming", skeleton, turned, root, "Both hands in turn, 5 strokes a second.")


def _stroke(phase: Array) -> Array:
    """Height of the hand over a stroke, 0 at the hit (whole phases) to 1; falls faster."""
    turn = 2.0 * np.pi * phase
    return (0.5 - 0.5 * np.cos(turn - 0.45 * np.sin(turn) - 0.22 * (1.0 - np.cos(turn)))) ** 1.2


def clapping() -> Clip:
    """Two claps a second, palms meeting in front of the chest."""
    skeleton, times = figure(), np.arange(601) / RATE
    turned = posed(skeleton, len(times))
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
    turned, root = planted(skeleton, turned, times, aside, 0.0 * times, 0.0 * times)
    chest = chest_of(skeleton, turned, root)
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
        hand = hand_rotation(
            yaw, np.radians(38.0 + 4.0 * sign + 0.0 * late), -sign * np.radians(82.0 - 10.0 * late)
        )
        place_hand(turned, skeleton, side, chest, wrist, elbow, hand)
    return made("clapping", skeleton, turned, root, "Two claps a second.")
