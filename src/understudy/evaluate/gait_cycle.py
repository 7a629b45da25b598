"""One stride of one leg: its timing, its distances and the angles of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from understudy.evaluate.gait_angles import across, angles, heading, travel
from understudy.evaluate.gait_body import Mover
from understudy.evaluate.gait_stances import Stance
from understudy.motion.rotations import Array

PHASE = np.arange(101) / 100.0
"""Share of the cycle at which curves are given."""
# How a foot lands is how it moves this long before [s]: afterward the ground has changed it.
_JUST = 0.015


@dataclass(frozen=True, kw_only=True)
class Cycle:
    """One stride of one leg, from its touchdown to its next.

    Attributes:
        side: Which leg.
        start_s: Touchdown [s].
        end_s: Next touchdown [s].
        stance_s: Time on the ground [s].
        speed: Along the way of travel [m/s].
        acceleration: How fast it gains speed over the cycle [m/s2].
        step_width: Lateral distance of this foot's stance from the other's [m]; negative where the
            feet cross the line of travel; None where the other foot does not stand between.
        landing: Velocity of the ankle just before touchdown, along the way and upward [m/s].
        rise: From the lowest to the highest point of the center of mass, drift taken out [m].
        apart: Least distance of the axes of the two lower legs [m].
        curves: Angles named in `ANGLES` at 0, 1, ... 100 % of the cycle [rad], shape (101,).
        height: Height of the center of mass over its mean, drift taken out [m], shape (101,).
    """

    side: str
    start_s: float
    end_s: float
    stance_s: float
    speed: float
    acceleration: float
    step_width: float | None
    landing: tuple[float, float]
    rise: float
    apart: float
    curves: dict[str, Array] = field(repr=False)
    height: Array = field(repr=False)

    @property
    def duration_s(self) -> float:
        """[s]."""
        return self.end_s - self.start_s

    @property
    def duty(self) -> float:
        """Share of the cycle on the ground."""
        return self.stance_s / self.duration_s

    @property
    def step_rate(self) -> float:
        """Steps per second, two to a cycle [Hz]."""
        return 2.0 / self.duration_s

    @property
    def step_length(self) -> float:
        """How far the body gets with a step: half of what it gets in the cycle [m]."""
        return 0.5 * self.speed * self.duration_s

    def angle(self, name: str, share: float) -> float:
        """A curve's angle [rad] at a share of the cycle from 0 to 1."""
        return float(np.interp(share, PHASE, self.curves[name]))

    def part(self, name: str, first: float, last: float) -> Array:
        """A curve between two shares of the cycle [rad]."""
        inside = (first <= PHASE) & (last >= PHASE)
        return self.curves[name][inside] if inside.any() else self.curves[name][:1]


def frames_between(mover: Mover, start: float, end: float) -> slice:
    """The frames between two times, and one beyond each."""
    first, last = np.searchsorted(mover.times, (start, end))
    return slice(max(0, int(first) - 1), min(len(mover.times), int(last) + 1))


def cycle_of(
    mover: Mover, here: Stance, after: Stance, every: Sequence[Stance], apart: Array
) -> Cycle:
    """The stride between two stances of one foot.

    Args:
        mover: Who moves.
        here: The stance it begins with.
        after: The foot's next stance.
        every: All stances, to find the other foot's.
        apart: Least distance of the lower legs in every frame [m], shape (frames,).
    """
    frames = frames_between(mover, here.start_s, after.start_s)
    times, ahead = mover.times[frames], heading(mover, frames)
    at = here.start_s + PHASE * (after.start_s - here.start_s)
    path = mover.center_of_mass
    ends = [_sampled(mover.times, path, t) for t in (here.start_s, after.start_s)]
    height = np.interp(at, mover.times, path[:, 2])
    # What one cycle gains in height, it keeps: an uneven floor or a drift.
    height = height - PHASE * (height[-1] - height[0])
    curves = angles(mover, here.side, frames, ahead)
    return Cycle(
        side=here.side,
        start_s=here.start_s,
        end_s=after.start_s,
        stance_s=here.duration_s,
        speed=float(np.linalg.norm((ends[1] - ends[0])[:2]) / (after.start_s - here.start_s)),
        acceleration=_gain(mover, frames),
        step_width=_width(mover, here, after, every, ahead),
        landing=_landing(mover, here, ahead[0]),
        rise=float(np.ptp(height)),
        apart=float(apart[frames].min()),
        curves={name: np.interp(at, times, np.unwrap(curve)) for name, curve in curves.items()},
        height=height - height.mean(),
    )


def _sampled(times: Array, path: Array, at: float) -> Array:
    return np.array([np.interp(at, times, column) for column in path.T])


def _width(
    mover: Mover, here: Stance, after: Stance, every: Sequence[Stance], ahead: Array
) -> float | None:
    """Lateral distance of the other foot's stance from the line between two of this one's [m]."""
    between = [s for s in every if s.side != here.side and here.start_s < s.start_s < after.start_s]
    if not between or not after.whole:
        return None
    mine = [_standing_at(mover, s) for s in (here, after)]
    other = _standing_at(mover, between[0])
    share = (between[0].middle_s - here.middle_s) / (after.middle_s - here.middle_s)
    left = across(ahead)[len(ahead) // 2]
    gap = float((mine[0] + share * (mine[1] - mine[0]) - other) @ left)
    return gap if here.side == "left" else -gap


def _standing_at(mover: Mover, stance: Stance) -> Array:
    """Where a foot is in the middle of its stance: midway from ankle to ball [m]."""
    middle = 0.5 * (mover.at(f"{stance.side}_ankle") + mover.forefoot(stance.side))
    return _sampled(mover.times, middle, stance.middle_s)


def _landing(mover: Mover, stance: Stance, ahead: Array) -> tuple[float, float]:
    """Velocity of the ankle over the time just before touchdown, along the way and upward [m/s]."""
    path, span = mover.at(f"{stance.side}_ankle"), min(_JUST, stance.start_s - mover.times[0])
    before, at = (_sampled(mover.times, path, stance.start_s - back) for back in (span, 0.0))
    velocity = (at - before) / max(span, 1e-9)
    return float(velocity @ ahead), float(velocity[2])


def _gain(mover: Mover, frames: slice) -> float:
    """How fast the body gains speed over the cycle [m/s2]."""
    speed = np.linalg.norm(travel(mover, frames), axis=1)
    times = mover.times[frames]
    return float((speed[-1] - speed[0]) / (times[-1] - times[0]))
