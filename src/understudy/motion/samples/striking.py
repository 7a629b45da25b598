"""Slow, strong strokes of one hand on a drum in front: what a contact has to stop."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BPoly

from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.keyframes import STANDING
from understudy.motion.rotations import Array
from understudy.motion.samples.standing import (
    HALF_PALM,
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

DRUM = (0.45, -0.15, 0.95)
"""Middle of the drum's skin [m], for the standard figure at the origin, facing +x."""
HITS = (1.25, 2.45, 3.60, 4.75)
"""When the palm passes the plane of the skin [s]."""
# How high the hand is raised over the skin before each stroke and how fast it arrives [m, m/s].
_RAISED = (0.40, 0.42, 0.38, 0.43)
_SPEEDS = (3.25, 3.40, 3.20, 3.50)
# How far the hand goes on below the skin [m]: it was captured striking a lower drum.
_THROUGH = 0.062
_HOVER = 0.09
_LASTS = 6.0
_WHAT = "Four drum strokes at 3.2 to 3.5 m/s; the right hand goes 6 cm below the skin."


def strike() -> Clip:
    """Four strokes of the right hand, standing, the left arm relaxed (6 s).

    The palm passes the plane of the skin at `DRUM` downward at 3.2 to 3.5 m/s at each of `HITS` and
    goes on for 6 cm, as it would be captured from someone whose drum was lower.
    """
    skeleton, times = figure(), np.arange(round(_LASTS * RATE) + 1) / RATE
    turned = posed(skeleton, len(times))
    height = _height(times)
    body = _body(times)
    set_angles(turned, skeleton, trunk(*body[:, :4].T, nod=body[:, 7]))
    swing = track(times, _at_hits(0.0, raised=-5.0, hit=4.0, after=1.0, late=0.05), softness=0.08)
    set_angles(
        turned,
        skeleton,
        {
            "left_shoulder": {"abduction": 9.0 + 0.2 * swing, "flexion": 3.0 + swing},
            "left_elbow": {"flexion": 22.0 + 1.2 * swing, "pronation": 18.0},
            "left_wrist": STANDING["left_wrist"],
        },
    )
    turned, root = planted(
        skeleton, turned, times, 0.001 * body[:, 4], 0.001 * body[:, 5],
        np.radians(0.35 * body[:, 0]), down=0.001 * body[:, 6],
    )  # fmt: skip
    up = np.clip(height / 0.4, 0.0, None)
    palm = np.stack(
        (
            DRUM[0] - 0.11 * up,
            DRUM[1] - 0.05 * up,
            DRUM[2] + HALF_PALM * 1.75 + height,
        ),
        axis=-1,
    )
    # The wrist cocks as the hand goes up, and the fingers whip down after the palm.
    cocked = _height(times - 0.018) / 0.4
    hand = hand_rotation(
        np.radians(98.0 + 6.0 * up), np.radians(-5.0 + 44.0 * cocked), np.radians(6.0 + 14.0 * up)
    )
    elbow = np.array([-0.55, -0.75, -0.5])
    place_palm(turned, skeleton, "right", root, palm, elbow, hand)
    return made("strike", skeleton, turned, root, _WHAT)


def _height(times: Array) -> Array:
    """Height of the palm's skin over the drum's [m]: quintics through rest, top, hit and bottom."""
    knots, values = [0.0], [[_HOVER, 0.0, 0.0]]
    for hit, top, speed in zip(HITS, _RAISED, _SPEEDS, strict=True):
        fall, stop = 2.0 * top / speed, 2.0 * _THROUGH / speed
        knots += [hit - fall - 0.52, hit - fall, hit, hit + stop, hit + stop + 0.30]
        values += [
            [_HOVER, 0.0, 0.0],
            [top, 0.0, -4.0],
            [0.0, -speed, 0.0],
            [-_THROUGH, 0.0, 40.0],
            [_HOVER, 0.0, 0.0],
        ]
    path = BPoly.from_derivatives([*knots, _LASTS], [*values, [_HOVER, 0.0, 0.0]])
    return path(np.clip(times, 0.0, _LASTS))


def _at_hits(
    rest: float, *, raised: float, hit: float, after: float, late: float = 0.0
) -> dict[float, float]:
    """Key values: at rest, with the hand raised, at each hit (`late` [s] after it), and after."""
    keys = {0.0: rest}
    for k, time in enumerate(HITS):
        size = (1.0, 1.08, 0.9, 1.12)[k]
        keys |= {
            time - 0.30 + late: rest + size * (raised - rest),
            time + 0.03 + late: rest + size * (hit - rest),
            time + 0.42 + late: rest + size * (after - rest),
        }
    return keys | {_LASTS: rest}


def _body(times: Array) -> Array:
    """Trunk turn, lean, bend and gaze [deg], pelvis left, ahead and down [mm], nod [deg].

    Shape (frames, 8).

    The trunk goes first: it opens as the hand goes up and closes into the stroke.
    """
    parts = (
        _at_hits(-2.0, raised=-11.0, hit=5.0, after=0.0, late=-0.05),
        _at_hits(4.0, raised=1.0, hit=9.0, after=5.0, late=-0.04),
        _at_hits(-1.0, raised=3.0, hit=-3.0, after=-1.0, late=-0.04),
        _at_hits(-8.0, raised=-10.0, hit=-9.0, after=-7.0),
        _at_hits(-4.0, raised=10.0, hit=-14.0, after=-6.0, late=-0.07),
        _at_hits(4.0, raised=-4.0, hit=14.0, after=6.0, late=-0.07),
        _at_hits(0.0, raised=-3.0, hit=9.0, after=2.0, late=-0.02),
        _at_hits(15.0, raised=10.0, hit=19.0, after=16.0, late=0.02),
    )
    return np.stack([track(times, part, softness=0.05) for part in parts], axis=-1)
