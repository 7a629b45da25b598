"""When each foot is on the ground: by its contact force in a take, by its sole's motion in a clip.

A force plate calls it contact above 20 N (Fukuchi, Fukuchi & Duarte 2017), and so do we where there
are forces. A clip has none: there a foot stands while a point of its sole is low and slow. The
limits are wider than those for feet that stand still, because running soles roll from the moment
they land to the moment they leave.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from understudy.evaluate.feet import feet
from understudy.evaluate.gait_body import PERSON, SIDES, Mover
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.evaluate.measure import Measured

CONTACT_FORCE = 20.0
"""A foot that bears more than this is on the ground [N]; Fukuchi et al. 2017."""
LOW = 0.06
"""A sole point lower than this over the floor may bear [m], for a person of 1.75 m."""
SLOW = 0.8
"""And slower than this [m/s]; a foot in swing passes at twice the running speed."""
SHORTEST = 0.06
"""Stays and gaps shorter than this are noise [s]; a sprinter's stance lasts 0.09 s."""


@dataclass(frozen=True, kw_only=True)
class Stance:
    """One stay of one foot on the ground.

    Attributes:
        side: "left" or "right".
        start_s: Touchdown [s].
        end_s: Toe-off [s].
        whole: Whether both lie within the record.
        begins: Whether the touchdown does.
    """

    side: str
    start_s: float
    end_s: float
    whole: bool
    begins: bool

    @property
    def duration_s(self) -> float:
        """[s]."""
        return self.end_s - self.start_s

    @property
    def middle_s(self) -> float:
        """[s]."""
        return 0.5 * (self.start_s + self.end_s)


def stances_by_force(m: Measured, character: int = 0) -> tuple[Stance, ...]:
    """Stances of a measured take, in order of touchdown."""
    out = []
    for side, bodies in feet(m.performer(character)).items():
        force = m.ground_reaction(character, links=bodies)[:, 2]
        out += _spans(side, m.times, force / CONTACT_FORCE - 1.0)
    return tuple(sorted(out, key=lambda s: s.start_s))


def stances_by_motion(mover: Mover) -> tuple[Stance, ...]:
    """Stances of a clip, in order of touchdown.

    How sure each point is: the lesser of how far below both limits it is, as a share of the limit;
    the foot is as sure as its surest point, and stands where that is positive.
    """
    size = mover.height / PERSON
    out = []
    for side in SIDES:
        low = 1.0 - mover.sole_heights[side] / (LOW * size)
        slow = 1.0 - mover.sole_speeds[side] / (SLOW * np.sqrt(size))
        out += _spans(side, mover.times, np.minimum(low, slow).max(axis=1))
    return tuple(sorted(out, key=lambda s: s.start_s))


def _spans(side: str, times: Array, margin: Array) -> list[Stance]:
    """Stretches in which the margin is positive, to a fraction of a frame."""
    on = margin > 0.0
    edges = np.flatnonzero(on[1:] != on[:-1])
    # Where the straight line between two frames crosses zero.
    share = margin[edges] / (margin[edges] - margin[edges + 1])
    at = times[edges] + share * (times[edges + 1] - times[edges])
    bounds = [*([times[0]] if on[0] else []), *at, *([times[-1]] if on[-1] else [])]
    spans = _joined(list(zip(bounds[::2], bounds[1::2], strict=True)))
    return [
        Stance(
            side=side,
            start_s=float(a),
            end_s=float(b),
            whole=bool(a > times[0] and b < times[-1]),
            begins=bool(a > times[0]),
        )
        for a, b in spans
        if b - a >= SHORTEST or a <= times[0] or b >= times[-1]
    ]


def _joined(spans: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Stretches less than `SHORTEST` apart as one."""
    out: list[tuple[float, float]] = []
    for a, b in spans:
        if out and a - out[-1][1] < SHORTEST:
            out[-1] = (out[-1][0], b)
        else:
            out.append((a, b))
    return out


def flights(stances: Sequence[Stance]) -> list[float]:
    """Time from each toe-off to the other foot's touchdown [s]; negative where both stand."""
    return [
        b.start_s - a.end_s
        for a, b in pairwise(stances)
        if a.side != b.side and a.end_s < b.end_s and b.begins
    ]
