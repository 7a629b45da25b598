"""A staff pumped up and down in the right hand, with a wrist that lets it tilt."""

from __future__ import annotations

import numpy as np

from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.rotations import Array
from understudy.motion.samples.standing import (
    RATE,
    hand_rotation,
    made,
    place_palm,
    planted,
    posed,
    set_angles,
    track,
    trunk,
)

GRIP = (0.40, -0.24, 1.23)
"""Mean position of the fist that holds the staff [m], for the figure at the origin, facing +x."""
PUMPS = 1.25
"""Pumps a second."""
STROKE = 0.30
"""How far the staff goes up and down, from lowest to highest [m]."""
_LASTS = 6.0
_WHAT = "Pumps a staff in the right hand, 1.25 times a second by 30 cm; it tilts up to 27 degrees."


def staff() -> Clip:
    """Stands and pumps a vertical staff, 1.25 times a second by 30 cm (6 s).

    The staff lies in the right fist, along the hand's local x (the thumb's side is up). The wrist
    is what a careless capture gives: it follows the forearm too far, so that the staff tilts by up
    to 27 degrees (14 rms).
    """
    skeleton, times = figure(), np.arange(round(_LASTS * RATE) + 1) / RATE
    turned = posed(skeleton, len(times))
    size = track(times, {0.0: 0.0, 0.3: 0.0, 1.1: 1.0, 5.0: 1.0, 5.7: 0.0, _LASTS: 0.0})
    size = size * (1.0 + 0.05 * np.sin(2.0 * np.pi * times / 2.3))
    beat = PUMPS * (times - 0.4) + 0.02 * np.sin(2.0 * np.pi * times / 1.9)

    def wave(late: float) -> Array:
        """The pump, `late` [s] behind the fist: -1 lowest to 1 highest."""
        return -size * np.cos(2.0 * np.pi * (beat - PUMPS * late)) - (1.0 - size)

    gaze = track(times, {0.0: -4.0, 1.4: -9.0, 3.2: -6.0, 4.6: -10.0, _LASTS: -4.0}, softness=0.2)
    set_angles(
        turned,
        skeleton,
        trunk(
            -3.0 + 2.5 * wave(-0.04),
            2.5 - 2.2 * wave(-0.05),
            -1.5 - 1.5 * wave(0.0),
            gaze,
            nod=5.0 - 2.0 * wave(0.06),
        ),
    )
    follow = wave(0.08)
    set_angles(
        turned,
        skeleton,
        {
            "left_shoulder": {"abduction": 9.0, "flexion": 1.0 - 2.0 * follow},
            "left_elbow": {"flexion": 19.0 - 2.5 * follow, "pronation": 16.0},
        },
    )
    turned, root = planted(
        skeleton, turned, times, -0.008 - 0.004 * wave(0.02), 0.004 - 0.004 * follow,
        np.radians(-1.0 + 0.8 * wave(-0.03)), down=0.004 - 0.011 * wave(-0.06),
    )  # fmt: skip
    z = 0.5 * STROKE * wave(0.0)
    grip = np.stack((GRIP[0] - 0.25 * z * z / STROKE, GRIP[1] - 0.04 * z, GRIP[2] + z), axis=-1)
    ahead, aside = _tilt(times, size, wave(0.03))
    # Thumb up is a quarter turn of the palm-down hand; `aside` rolls it about its length.
    hand = hand_rotation(np.radians(97.0), np.radians(ahead), np.radians(90.0 + aside))
    place_palm(turned, skeleton, "right", root, grip, np.array([-0.6, -0.55, -0.75]), hand)
    return made("staff", skeleton, turned, root, _WHAT)


def _tilt(times: Array, size: Array, follow: Array) -> tuple[Array, Array]:
    """How far the wrist lets the staff tip backward and to the right [deg]."""
    drift = np.sin(2.0 * np.pi * times / 2.7 + 0.6) + 0.6 * np.sin(2.0 * np.pi * times / 1.31)
    back = 5.0 + size * (10.0 * follow + 2.0 * drift)
    right = 4.0 + size * (4.0 * np.sin(2.0 * np.pi * PUMPS * times + 1.0) + 2.0 * drift)
    return back, right
