"""Angles of an athlete's upper-body hinges that follow a clip.

An athlete's arm has six hinges where a clip has three ball joints. Its upper arm, forearm and hand
are made to point where the clip's do, which has a closed form; what is left over, the turn of
forearm and hand about their own length, the body cannot show.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from understudy.character.athlete import HINGES, Athlete
from understudy.character.retarget import retargeted
from understudy.errors import expect
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array

UPPER = 18
"""Hinges of the upper body: waist, neck, left arm, right arm, first in the athlete's order."""

_DOWN = np.array([0.0, 0.0, -1.0])
# Capture noise is taken out over this time [s]; where a hinge turns nothing, such as the shoulder's
# twist with a straight elbow, it is taken from the time around, this wide.
_SMOOTHING, _AROUND = 0.012, 0.15
# An arm is bent when the sine between its parts is over this.
_BENT = 0.35
_CHAINS = (
    ("left_shoulder", "left_elbow", "left_wrist"),
    ("right_shoulder", "right_elbow", "right_wrist"),
)


def upper_angles(clip: Clip, athlete: Athlete) -> Array:
    """Hinge angles of waist, neck and arms through a clip [rad], shape (frames, 18).

    Args:
        clip: Of a person, on any skeleton.
        athlete: Whose hinges.

    Raises:
        InvalidValue: No person is found in the clip.
    """
    expect(clip, Clip, "clip", "a Clip, as `read` gives")
    turns, rate = _turns(retargeted(clip.repaired(), athlete).rotations, athlete), clip.rate
    trunk = [_euler(turns["upper_back"]), _euler(turns["neck"])]
    arms = [_arm(*(turns[role] for role in chain), rate=rate) for chain in _CHAINS]
    angles = np.concatenate([*trunk, *arms], axis=1)
    low, high = _limits()
    smooth = gaussian_filter1d(angles, max(_SMOOTHING * rate, 1e-3), axis=0, mode="nearest")
    return np.clip(smooth, low, high)


def pointing(clip: Clip, athlete: Athlete, angles: Array) -> Array:
    """How far upper arms, forearms and hands point from the clip's [rad], shape (frames, 6).

    Seen from the chest; left upper arm, forearm, hand, then the right ones.

    Args:
        clip: Of a person, on any skeleton.
        athlete: Whose hinges.
        angles: Of the hinges of the upper body [rad], shape (frames, 18).
    """
    theirs = _turns(retargeted(clip.repaired(), athlete).rotations, athlete)
    state = np.zeros((len(angles), athlete.widths[0]))
    state[:, 3], state[:, 7 : 7 + UPPER] = 1.0, angles
    ours = _turns(athlete.local_rotations(state), athlete)
    out = []
    for chain in _CHAINS:
        for a, b in zip(*(_ways([t[role] for role in chain]) for t in (theirs, ours)), strict=True):
            out.append(np.arccos(np.clip(np.sum(a * b, axis=1), -1.0, 1.0)))
    return np.stack(out, axis=1)


def _ways(turns: list[Array]) -> list[Array]:
    """Directions of upper arm, forearm and hand in the chest's frame, each (frames, 3)."""
    first = turns[0]
    second = rot.multiply(first, turns[1])
    return [rot.rotate(q, _DOWN) for q in (first, second, rot.multiply(second, turns[2]))]


def _turns(local: Array, athlete: Athlete) -> dict[str, Array]:
    """By role, how far every joint is turned from standing with arms hanging, in those axes."""
    out, upright = {}, rot.identity(len(athlete.links))
    for i, link in enumerate(athlete.links):
        if i == 0:
            continue
        inboard = upright[link.parent]
        upright[i] = rot.multiply(inboard, athlete.rests[i])
        turn = rot.multiply(rot.multiply(inboard, local[:, i]), rot.conjugate(upright[i]))
        out[link.role or ""] = turn
    return out


def _euler(turns: Array) -> Array:
    """Angles about x, then y, then z [rad], shape (frames, 3)."""
    m = rot.to_matrix(turns)
    y = np.arcsin(np.clip(m[:, 0, 2], -1.0, 1.0))
    x = np.arctan2(-m[:, 1, 2], m[:, 2, 2])
    z = np.arctan2(-m[:, 0, 1], m[:, 0, 0])
    return np.stack((x, y, z), axis=1)


def _arm(shoulder: Array, elbow: Array, wrist: Array, *, rate: float) -> Array:
    """Six hinge angles of an arm [rad], shape (frames, 6).

    The upper arm points down at zero; flexion turns it forward about -y, then abduction about x.
    Twist about its length and flexion of the elbow about -y then aim the forearm, and two hinges of
    the wrist the hand.
    """
    x, y, z = rot.rotate(shoulder, _DOWN).T
    flexion = _steady(-z + 1j * x, rate)
    # Behind and overhead is the long way round.
    flexion = np.where(flexion < -2.2, flexion + 2.0 * np.pi, flexion)
    abduction = np.arctan2(y, np.cos(flexion) * -z + np.sin(flexion) * x)
    aimed = rot.multiply(_about(1, -flexion), _about(0, abduction))
    forearm = rot.multiply(shoulder, elbow)
    x, y, z = rot.rotate(rot.conjugate(aimed), rot.rotate(forearm, _DOWN)).T
    twist = _steady(x + 1j * y, rate)
    bend = np.arctan2(np.cos(twist) * x + np.sin(twist) * y, -z)
    aimed = rot.multiply(aimed, rot.multiply(_about(2, twist), _about(1, -bend)))
    hand = rot.multiply(forearm, wrist)
    x, y, z = rot.rotate(rot.conjugate(aimed), rot.rotate(hand, _DOWN)).T
    return np.stack(
        (flexion, abduction, twist, bend, np.arctan2(y, -z), np.arcsin(np.clip(x, -1, 1))), axis=1
    )


def _steady(toward: Array, rate: float) -> Array:
    """Direction of complex numbers [rad]; where they are small, that of those around them."""
    around = gaussian_filter1d(toward, max(_AROUND * rate, 1e-3), mode="nearest")
    size = np.abs(around)
    around = np.where(size > 1e-9, around / np.where(size > 1e-9, size, 1.0), 1.0)
    missing = np.clip(1.0 - np.abs(toward) / _BENT, 0.0, 1.0)
    return np.angle(toward + _BENT * missing**2 * around)


def _about(axis: int, angles: Array) -> Array:
    vectors = np.zeros((len(angles), 3))
    vectors[:, axis] = angles
    return rot.from_rotvec(vectors)


def _limits() -> tuple[Array, Array]:
    arm = [*HINGES["shoulder"], *HINGES["elbow"], *HINGES["wrist"]]
    hinges = [*HINGES["back"], *HINGES["neck"], *arm, *arm]
    limits = np.array([hinge.limits for hinge in hinges])
    return limits[:, 0], limits[:, 1]
