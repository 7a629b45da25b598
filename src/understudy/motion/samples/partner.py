"""Patty-cake with a partner who stands opposite, and a slap: one adult's hands.

Every clap with the partner lies between two claps of one's own hands, which are the home pose. The
motion is a chain of segments that begin and end there, so that they can be put in any order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from understudy.errors import UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.keyframes import eased
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

PARTNER = 0.92
"""Distance of the partner [m], who faces this way; palms meet halfway."""
BEAT = 0.5
"""From one's own clap to the clap with the partner, and back [s]."""
PAUSE = 0.5
"""How long the home pose is held before the first and after the last segment [s]."""
CLAPS = ("right", "left", "both", "right", "both")
"""Which hands meet the partner's, in order."""
SLAP = 1.20
"""When the hand of `slap` meets the partner's cheek [s]."""
CHEEK = (0.79, -0.10, 1.58)
"""Where that is [m], for the middle line of the hand."""

# Half of what lies between the middle lines of two hands that touch [m].
_SKIN = 0.022
# A hand goes on for this far and this long after it met the partner's [m, s].
_PRESS, _PRESSING = 0.012, 0.05
# Middle of the palms: own clap in front of the breastbone, with the partner halfway between both,
# at the height of the shoulders. One hand goes to the middle (the partner's same hand comes from
# across), both hands go straight ahead.
_HOME_X, _HOME_Z = 0.30, 1.20
_MEET_X, _MEET_Z = 0.5 * PARTNER - _SKIN + _PRESS, 1.35
# Small things in which one clap differs from the next [m]: aside, up.
_DIFFERENT = ((0.0, 0.0), (0.006, -0.012), (0.004, 0.008), (-0.008, 0.006), (-0.005, -0.006))
# Where elbows point in the home pose, of the left arm.
_ELBOWS = (-0.3, 0.9, -0.8)
_DWELL = 0.05  # palms stay together this long [s]


def boundaries(claps: Sequence[str] = CLAPS) -> tuple[float, ...]:
    """When segments begin and end [s]: one more than there are claps; home pose at each."""
    return tuple(PAUSE + 2.0 * BEAT * k for k in range(len(claps) + 1))


def clap_times(claps: Sequence[str] = CLAPS) -> tuple[float, ...]:
    """When the partner's hands are met [s]: halfway through each segment."""
    return tuple(start + BEAT for start in boundaries(claps)[:-1])


def patty_cake(claps: Sequence[str] = CLAPS) -> Clip:
    """Claps own hands and a partner's in turn, standing (6 s for five claps).

    Begins and ends with the own hands together, as does every segment (see `boundaries`); the
    partner's hands are met at `clap_times`, palms upright and forward, halfway to `PARTNER`.

    Args:
        claps: "right", "left" or "both" hands for each clap with the partner.

    Raises:
        UnknownName: Another clap.
    """
    for clap in claps:
        if clap not in ("right", "left", "both"):
            raise UnknownName("clap", clap, ("right", "left", "both"))
    lasts = boundaries(claps)[-1] + PAUSE
    times = np.arange(round(lasts * RATE) + 1) / RATE
    keys = {side: _clapping(side, claps, lasts) for side in ("left", "right")}
    reach = {side: [float(c in (side, "both")) for c in claps] for side in ("left", "right")}
    body = _body(times, claps, reach["left"], reach["right"])
    hands = {side: _through(keys[side], times) for side in keys}
    what = f"Own hands and a partner's in turn: {', '.join(claps)}."
    return _performed("patty_cake", times, body, hands, what)


@dataclass(frozen=True, kw_only=True)
class _HandKey:
    """A hand at rest at a time: palm [m], hand angles [deg], and the way it comes there.

    `hand` is inward, up and rolled: fingers turned to the other side, fingers raised, and the palm
    turned inward from facing down. `arc` [m] bends the way here.
    """

    time: float
    palm: tuple[float, float, float]
    hand: tuple[float, float, float]
    elbow: tuple[float, float, float] = (-0.35, 0.55, -1.0)
    arc: tuple[float, float, float] = (0.0, 0.0, 0.0)


def _own(time: float, side: str, arc: tuple[float, float, float]) -> _HandKey:
    """Palms together; the right fingers a little above the left ones."""
    up = 39.0 if side == "right" else 36.0
    return _HandKey(
        time=time, palm=(_HOME_X, _SKIN + 0.003, _HOME_Z), hand=(9.0, up, 90.0),
        elbow=_ELBOWS, arc=arc,
    )  # fmt: skip


def _clapping(side: str, claps: Sequence[str], lasts: float) -> list[_HandKey]:
    """Keys of one hand; y and angles as of the left hand."""
    sign = 1.0 if side == "left" else -1.0
    keys = [_own(0.0, side, (0.0, 0.0, 0.0)), _own(PAUSE, side, (0.0, 0.0, 0.0))]
    for k, (clap, time) in enumerate(zip(claps, clap_times(claps), strict=True)):
        met = time + _PRESSING
        aside, up = _DIFFERENT[k % len(_DIFFERENT)]
        if clap == "both":
            palm, arc = (_MEET_X, 0.155 + sign * aside, _MEET_Z + 0.02 + up), (-0.05, 0.03, 0.0)
            there = _HandKey(time=met, palm=palm, hand=(2.0, 80.0, 4.0), arc=arc)
        elif clap == side:
            palm, arc = (_MEET_X, 0.012 + sign * aside, _MEET_Z + up), (-0.05, 0.06, 0.01)
            there = _HandKey(time=met, palm=palm, hand=(6.0, 79.0, 8.0), arc=arc)
        else:  # the other hand waits, open, beside the breastbone
            palm = (_HOME_X - 0.05, 0.13 + 0.5 * aside, _HOME_Z - 0.02 + up)
            there = _HandKey(time=met, palm=palm, hand=(8.0, 50.0, 62.0), elbow=(-0.4, 0.7, -1.0))
        keys += [there, _own(time + BEAT, side, (-0.02, 0.05, -0.01))]
    return [*keys, _own(lasts, side, (0.0, 0.0, 0.0))]


def _through(keys: Sequence[_HandKey], times: Array) -> tuple[Array, Array, Array]:
    """Palm, hand rotation and elbow direction of a left hand through rests at keys.

    Between keys the timing is minimum jerk (Flash & Hogan 1985), starting after a dwell and
    reaching its greatest speed late: hands that clap arrive faster than they leave.
    """
    knots = np.array([key.time for key in keys])
    low = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
    span = knots[low + 1] - knots[low]
    s = np.clip((times - knots[low] - _DWELL) / (span - _DWELL), 0.0, 1.0) ** 1.6
    weight = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
    palm, elbow, arc = (
        np.array([getattr(key, name) for key in keys]) for name in ("palm", "elbow", "arc")
    )
    w = weight[:, None]
    way = palm[low] + w * (palm[low + 1] - palm[low]) + 4.0 * w * (1.0 - w) * arc[low + 1]
    angles = np.array([_oriented(key.hand) for key in keys])
    turned = rot.slerp(angles[low], angles[low + 1], weight)
    pole = elbow[low] + w * (elbow[low + 1] - elbow[low])
    return way, turned, pole


def _oriented(hand: Sequence[float] | Array) -> Array:
    """World rotation of a left hand from inward, up and rolled [deg], (..., 4)."""
    inward, up, rolled = np.radians(np.moveaxis(np.asarray(hand, float), -1, 0))
    return hand_rotation(-0.5 * np.pi - inward, up, -rolled)


def _performed(
    name: str, times: Array, body: Array, hands: dict[str, tuple[Array, Array, Array]], what: str
) -> Clip:
    """Put trunk, legs and both hands together; `hands` are given as left hands."""
    skeleton = figure()
    turned = posed(skeleton, len(times))
    set_angles(turned, skeleton, trunk(*body[:, :4].T))
    turned, root = planted(
        skeleton, turned, times, 0.001 * body[:, 4], 0.001 * body[:, 5],
        np.radians(0.4 * body[:, 0]), down=0.001 * body[:, 6], restless=0.0,
    )  # fmt: skip
    for side, (palm, hand, elbow) in hands.items():
        flip = np.array([1.0, 1.0 if side == "left" else -1.0, 1.0])
        # Reflection in the plane y = 0 makes a left hand a right one.
        image = np.array([1.0, flip[1], 1.0, flip[1]])
        place_palm(turned, skeleton, side, root, palm * flip, elbow * flip, hand * image)
    return made(name, skeleton, turned, root, what)


def _body(
    times: Array, claps: Sequence[str], left: Sequence[float], right: Sequence[float]
) -> Array:
    """Trunk turn, lean, bend and gaze [deg], pelvis left, ahead and down [mm], (frames, 7).

    At rest, and the same, at every boundary of a segment.
    """
    home = (0.0, 1.2, 0.0, 0.0, 0.0, 1.0, 3.0)
    keys = {0.0: home, PAUSE: home}
    for k, time in enumerate(clap_times(claps)):
        side = right[k] - left[k]  # the trunk turns left after a right hand
        keys[time + 0.01] = (
            7.5 * side, 4.5, -1.5 * side, 2.0 * side + (0.0, 1.0, -1.0)[k % 3],
            -6.0 * side, 12.0, 6.0,
        )  # fmt: skip
        keys[time + BEAT] = home
    keys[float(times[-1])] = home
    return eased(np.array(list(keys)), np.array(list(keys.values())), times, "rest")


def slap() -> Clip:
    """From own hands together to a slap of the partner's cheek with the right hand (3 s).

    The hand meets the cheek at `CHEEK` at the time `SLAP`, moving to the left, and goes on; both
    arms come down afterward.
    """
    times = np.arange(round(3.0 * RATE) + 1) / RATE
    start = {side: _own(0.25, side, (0.0, 0.0, 0.0)) for side in ("left", "right")}
    right = {
        0.25: (start["right"].palm, start["right"].hand),
        0.60: ((0.22, 0.38, 1.29), (-4.0, 34.0, 76.0)),
        0.90: ((0.12, 0.52, 1.43), (-14.0, 60.0, 66.0)),
        SLAP: ((CHEEK[0], -CHEEK[1], CHEEK[2]), (14.0, 34.0, 86.0)),
        1.36: ((0.67, -0.27, 1.52), (46.0, 22.0, 78.0)),
        1.62: ((0.47, -0.30, 1.33), (60.0, 2.0, 66.0)),
        2.15: ((0.25, 0.14, 0.98), (20.0, -36.0, 66.0)),
        2.7: ((0.07, 0.27, 0.80), (0.0, -76.0, 76.0)),
        3.0: ((0.06, 0.275, 0.79), (0.0, -78.0, 76.0)),
    }
    left = {
        0.25: (start["left"].palm, start["left"].hand),
        0.75: ((0.31, 0.13, 1.13), (12.0, 26.0, 66.0)),
        1.25: ((0.21, 0.25, 1.03), (10.0, 0.0, 62.0)),
        1.9: ((0.10, 0.28, 0.86), (4.0, -54.0, 70.0)),
        2.5: ((0.06, 0.275, 0.79), (0.0, -77.0, 76.0)),
        3.0: ((0.06, 0.275, 0.79), (0.0, -78.0, 76.0)),
    }
    body = track(
        times,
        {
            0.0: (0.0, 1.2, 0.0, 0.0, 0.0, 1.0, 3.0),
            0.2: (0.0, 1.2, 0.0, 0.0, 0.0, 1.0, 3.0),
            0.80: (-24.0, 0.0, 3.0, -2.0, -8.0, -10.0, 6.0),
            1.22: (26.0, 14.0, -3.0, 2.0, 8.0, 34.0, 12.0),
            1.55: (32.0, 12.0, -2.0, 6.0, 6.0, 28.0, 10.0),
            2.4: (4.0, 3.0, 0.0, 1.0, 0.0, 4.0, 4.0),
            3.0: (0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 2.0),
        },
        softness=0.05,
    )
    hands = {side: _flowing(keys, times) for side, keys in (("left", left), ("right", right))}
    return _performed(
        "slap", times, body, hands, "From own hands together to a slap at face height."
    )


def _flowing(keys: dict[float, tuple], times: Array) -> tuple[Array, Array, Array]:
    """As `_through`, but without coming to rest at the keys: twice differentiable."""
    knots = np.array(list(keys))
    palm = np.array([key[0] for key in keys.values()])
    angles = np.array([key[1] for key in keys.values()])
    way, hand = (
        CubicSpline(knots, values, bc_type="clamped")(np.maximum(times, knots[0]))
        for values in (palm, angles)
    )
    out, hanging = (-0.45, 0.75, -0.8), (-0.75, 0.5, -0.5)
    elbow = track(times, {0.0: _ELBOWS, 0.25: _ELBOWS, 0.6: out, 1.7: out, 2.7: hanging})
    return way, _oriented(hand), elbow
