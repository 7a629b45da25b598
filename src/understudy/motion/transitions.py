"""Where one clip goes over into another with the least change: a search over all pairs of times.

Two moments are alike when the body's points, seen from the root and along its heading, are in the
same places, move alike, and touch the floor alike, all through the blend. After the comparison of
point clouds of Kovar, Gleicher & Pighin, Motion Graphs, 2002, section 3.1, with velocities in place
of their neighboring frames. The heading is taken off each clip by itself, so that all pairs
together are one matrix product.
"""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral, Real

import numpy as np

from understudy.errors import InvalidValue, shown
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.ground import foot_contacts
from understudy.motion.mirror import side
from understudy.motion.rotations import Array
from understudy.motion.segments import check_blend, check_pair

# A difference of velocity of 1 m/s counts like one of place of this many meters.
VELOCITY = 0.15
# A foot that touches the floor in one clip and not in the other counts like this many meters.
CONTACT = 0.2
# Times are compared this often [Hz], and more coarsely where that makes more pairs than this.
COMPARED = 30.0
MOST_PAIRS = 4_000_000


@dataclass(frozen=True, kw_only=True)
class Transition:
    """Times at which one clip goes over into another: `a.spliced(b, at=time_a, start=time_b)`.

    Attributes:
        time_a: Time in the first clip when the blend begins [s].
        time_b: Time in the second clip at that moment [s].
        blend: Duration of the blend [s].
        cost: How unlike the motions are during the blend [m]: root mean square over points and
            time of the difference in place, with velocities and contacts counted in.
    """

    time_a: float
    time_b: float
    blend: float
    cost: float


def transitions(
    a: Clip, b: Clip, *, count: int = 5, blend: float = 0.5, keep: float = 0.0
) -> tuple[Transition, ...]:
    """The best times to go over from clip `a` into clip `b`, best first.

    No two are within one blend of each other in both clips. For a loop give the same clip twice:
    then only jumps back by more than a blend are found, and `clip.trimmed(time_b, time_a)` loops.

    Args:
        a: The clip that ends.
        b: The clip that goes on.
        count: Most to return; there are fewer where the clips are short.
        blend: Duration of the blend [s].
        keep: Time of each clip that must be left before and after the blend [s].

    Raises:
        InvalidValue: Clips of different skeletons, one too short, or no `count`.
    """
    check_pair(a, b)
    check_blend(blend)
    if not (isinstance(keep, Real) and 0.0 <= keep < np.inf):
        raise InvalidValue(f"keep is {shown(keep)}; it must be a time in seconds, 0 or more.")
    if not (isinstance(count, Integral) and count >= 1):
        raise InvalidValue(f"count is {shown(count)}; it must be a whole number from 1 on.")
    for clip in (a, b):
        if clip.duration < blend + keep:
            raise InvalidValue(
                f"{clip.name!r} lasts {clip.duration:g} s; a blend of {blend:g} s that leaves "
                f"{keep:g} s does not fit."
            )
    rate = min(COMPARED, np.sqrt(MOST_PAIRS / (a.duration * b.duration + 1e-9)))
    # At least three moments of every blend, whatever the budget.
    rate = max(rate, 2.0 / blend)
    seen = _features(a, rate), _features(b, rate)
    # A clip of just one blend has a moment less where the rate does not divide the blend.
    cost = _costs(*seen, min(round(blend * rate) + 1, *map(len, seen)))
    early = int(np.ceil(keep * rate - 1e-6))
    cost[:early] = np.inf
    cost[:, max(cost.shape[1] - early, 0) :] = np.inf
    if a is b or a == b:
        i, j = np.indices(cost.shape)
        cost[i - j < max(blend * rate, 1.0)] = np.inf
    found = _lowest(cost, int(count), max(1, round(blend * rate)))
    return tuple(
        Transition(
            time_a=min(i / rate, a.duration - blend),
            time_b=min(j / rate, b.duration - blend),
            blend=blend,
            cost=float(cost[i, j]),
        )
        for i, j in found
    )


def _features(clip: Clip, rate: float) -> Array:
    """What is compared of each moment, shape (moments, numbers), scaled so that squares sum to m^2.

    Places and velocities of joints and end sites from the root's ground point and along its
    heading, and contacts.
    """
    times = np.arange(int(np.floor(clip.duration * rate + 1e-6)) + 1) / rate
    pose = clip.forward_kinematics()
    points = np.concatenate((pose.positions, pose.ends), axis=1)
    velocity = derivative(points, clip.rate, smoothing=0.075)
    twist = rot.normalized(clip.rotations[:, 0] * np.array([1.0, 0.0, 0.0, 1.0]))
    back = rot.conjugate(twist)[:, None]
    ground = clip.root_positions[:, None] * np.array([1.0, 1.0, 0.0])
    place = rot.rotate(back, points - ground)
    speed = VELOCITY * rot.rotate(back, velocity)
    frame = np.minimum(np.round(times * clip.rate).astype(int), clip.frames - 1)
    parts = [place[frame].reshape(len(times), -1), speed[frame].reshape(len(times), -1)]
    together = np.concatenate(parts, axis=1) / np.sqrt(points.shape[1])
    return np.concatenate((together, CONTACT * _touching(clip)[frame]), axis=1)


def _touching(clip: Clip) -> Array:
    """How much of each side of the body that touches the floor does, shape (frames, 2)."""
    contacts = foot_contacts(clip)
    out = np.zeros((clip.frames, 2))
    for sign, column in ((1, 0), (-1, 1)):
        mine = [
            k
            for k, point in enumerate(contacts.points)
            if side(clip.skeleton, clip.skeleton.index(point.removesuffix(" end"))) == sign
        ]
        if mine:
            out[:, column] = contacts.touching[:, mine].any(axis=1)
    return out


def _costs(a: Array, b: Array, window: int) -> Array:
    """Cost of every pair of beginnings [m], shape (moments of a, moments of b), less the window.

    The squared distances of all moments are one matrix product; their mean over the blend is a
    difference of sums along diagonals.
    """
    square = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1)[None] - 2.0 * (a @ b.T)
    square = np.maximum(square, 0.0)
    rows, columns = len(a) - window + 1, len(b) - window + 1
    total = np.zeros((rows, columns))
    for k in range(window):
        total += square[k : k + rows, k : k + columns]
    return np.sqrt(total / window)


def _lowest(cost: Array, count: int, apart: int) -> list[tuple[int, int]]:
    """Places of the lowest costs, each at least `apart` from the others in one direction."""
    left, found = np.array(cost), []
    while len(found) < count:
        i, j = (int(k) for k in np.unravel_index(int(left.argmin()), left.shape))
        if not np.isfinite(left[i, j]):
            break
        found.append((i, j))
        left[max(0, i - apart + 1) : i + apart, max(0, j - apart + 1) : j + apart] = np.inf
    return found
