"""Hands placed where they should be at given times, by offsets that come and go.

Zordan & Hodgins 1999, section 5.1: at each time inverse kinematics (`motion.arm`) finds how far to
turn shoulder, elbow and wrist; around it the offsets are eased in and out by slerp. For a body
other than the actor's this brings hands back to what they touched.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from understudy.errors import InvalidValue, expect, shown
from understudy.motion import rotations as rot
from understudy.motion.arm import Arm, Posture, arm_of, moved, place, posture, solved
from understudy.motion.clip import Clip
from understudy.motion.edits import SPEEDS, sampled
from understudy.motion.rotations import Array
from understudy.motion.segments import eased
from understudy.motion.skeleton import frozen_array

# Paper: the hand is at its place; less than this off [m] is there.
MISS = 0.002
# Frames on either side that decide a pose between frames.
AROUND = 12
# The hand of an arm this near to straight hardly obeys: two hands meet within this part of reach.
EASY = 0.97


@dataclass(frozen=True, kw_only=True)
class HandTarget:
    """A hand at a place at a time.

    Attributes:
        time: When [s].
        joint: The wrist; its parent and grandparent with a bone are elbow and shoulder.
        position: Where the point of the hand shall be, world [m], (3,).
        window: Time on either side over which the offset comes and goes [s].
        point: Which point of the hand, in the wrist's frame [m], (3,); None is the middle of the
            palm (`motion.arm.palm`).
    """

    time: float
    position: ArrayLike
    joint: str = "right_wrist"
    window: float = 0.3
    point: ArrayLike | None = None

    def __post_init__(self) -> None:
        _check_times(self.time, self.window)
        expect(self.joint, str, "joint", "the name of a joint")
        object.__setattr__(self, "position", _spot(self.position, "position"))
        if self.point is not None:
            object.__setattr__(self, "point", _spot(self.point, "point"))

    def retimed(self, speed: float, *, window: float | None = None) -> HandTarget:
        """The target for a clip played `speed` times as fast; its window shrinks, or is `window`.

        Faster, servos lag more: a window as long as before brings the hand there all the same.
        """
        factor = _speed(speed)
        return replace(
            self, time=self.time / factor, window=self.window / factor if window is None else window
        )


@dataclass(frozen=True, kw_only=True)
class Reached:
    """What became of one target.

    Attributes:
        target: The target.
        moved: How far the hand's point was moved [m].
        miss: How far it still is from its place [m].
        turned: By how much the hand's orientation changed [rad].
    """

    target: HandTarget
    moved: float
    miss: float
    turned: float


@dataclass(frozen=True, kw_only=True)
class Meet:
    """Two hands of two clips that come together.

    Attributes:
        time: When [s].
        hands: The wrist of the first clip's hand and of the second's.
        window: Time on either side over which the offsets come and go [s].
        position: Where, world [m], (3,); None is half way between the two hands, or as near to it
            as both can reach.
        apart: Distance left between the two palms' middles [m], for the thickness of hands.
    """

    time: float
    hands: tuple[str, str] = ("right_wrist", "left_wrist")
    window: float = 0.3
    position: ArrayLike | None = None
    apart: float = 0.005

    def __post_init__(self) -> None:
        _check_times(self.time, self.window)
        if not (len(self.hands) == 2 and all(isinstance(hand, str) for hand in self.hands)):
            raise InvalidValue(f"hands is {shown(self.hands)}; it must be two names of wrists.")
        object.__setattr__(self, "hands", tuple(self.hands))
        if not (isinstance(self.apart, Real) and 0.0 <= self.apart <= 1.0):
            raise InvalidValue(f"apart is {shown(self.apart)}; it must lie in 0 to 1 m.")
        if self.position is not None:
            object.__setattr__(self, "position", _spot(self.position, "position"))

    def retimed(self, speed: float, *, window: float | None = None) -> Meet:
        """The meeting of clips played `speed` times as fast; its window shrinks, or is `window`."""
        factor = _speed(speed)
        return replace(
            self, time=self.time / factor, window=self.window / factor if window is None else window
        )


def reaching(clip: Clip, targets: Iterable[HandTarget]) -> Clip:
    """The clip with its hands at their places at the given times; see `reach`."""
    return reach(clip, targets)[0]


def reach(clip: Clip, targets: Iterable[HandTarget]) -> tuple[Clip, tuple[Reached, ...]]:
    """The clip with its hands at their places at the given times, and how well that went.

    The hand keeps its world orientation where the arm allows it. A window ends at the arm's next
    target, so that each is met at its own time; where two windows overlap their offsets add up.

    Raises:
        UnknownName: No such joint.
        InvalidValue: A time outside the clip, two places for one hand at one time, arms that share
            joints, or a place out of reach: the text gives the distance and the arm's length.
    """
    expect(clip, Clip, "clip", "a Clip")
    expect(targets, Iterable, "targets", "a list of HandTarget")
    wanted = list(targets)
    for target in wanted:
        expect(target, HandTarget, "target", "a HandTarget")
        if not -0.5 / clip.rate <= target.time <= clip.duration + 0.5 / clip.rate:
            raise InvalidValue(
                f"A target at {target.time:g} s lies outside {clip.name!r}, which lasts 0 .. "
                f"{clip.duration:g} s."
            )
    if not wanted:
        return clip, ()
    wanted.sort(key=lambda target: target.time)
    names = list(dict.fromkeys(target.joint for target in wanted))
    arms = {name: arm_of(clip, name) for name in names}
    _check_apart(clip, arms)
    turned, outcomes = np.array(clip.rotations), []
    for name in names:
        mine = [target for target in wanted if target.joint == name]
        _check_order(clip, mine)
        offsets = [_offset(clip, arms[name], target) for target in mine]
        weights = _weights(clip.times, mine)
        # (frames, 3 joints, 3): rotation vectors add up where windows overlap.
        whole = np.einsum("tf,tjk->fjk", weights, np.array([o for o, _ in offsets]))
        joints = list(arms[name].joints)
        turned[:, joints] = rot.multiply(turned[:, joints], rot.from_rotvec(whole))
        outcomes += [outcome for _, outcome in offsets]
    outcomes.sort(key=lambda outcome: outcome.target.time)
    notes = tuple(
        f"{o.target.joint} placed at {o.target.time:g} s: moved {1000 * o.moved:.0f} mm, missed by "
        f"{1000 * o.miss:.1f} mm, hand turned {np.degrees(o.turned):.1f} degrees."
        for o in outcomes
    )
    return replace(clip, rotations=turned, notes=(*clip.notes, *notes)), tuple(outcomes)


def meeting(clip_a: Clip, clip_b: Clip, meets: Iterable[Meet]) -> tuple[Clip, Clip]:
    """Two clips whose hands come together at the given times, as in a game of patty-cake.

    Each palm's middle is put half of `apart` short of the meeting place, along the line from the
    one hand to the other.

    Raises:
        UnknownName: No such joint.
        InvalidValue: As for `reach`, or two bodies too far apart to touch; the text says how far.
    """
    expect(meets, Iterable, "meets", "a list of Meet")
    clips, first, second = (clip_a, clip_b), [], []
    for clip in clips:
        expect(clip, Clip, "clip", "a Clip")
    for meet in meets:
        expect(meet, Meet, "meet", "a Meet")
        arms = [arm_of(clip, joint) for clip, joint in zip(clips, meet.hands, strict=True)]
        sides = [(arm, _at(clip, arm, meet.time)) for clip, arm in zip(clips, arms, strict=True)]
        palms = [place(arm, pose) for arm, pose in sides]
        way = palms[1] - palms[0]
        if np.linalg.norm(way) < 1e-3:
            way = sides[1][1].shoulder - sides[0][1].shoulder
        way = 0.5 * meet.apart * way / max(float(np.linalg.norm(way)), 1e-9)
        if meet.position is None:
            spot = _between(sides, palms, meet)
        else:
            spot = np.asarray(meet.position, float)
        for joint, at, list_ in zip(
            meet.hands, (spot - way, spot + way), (first, second), strict=True
        ):
            list_.append(HandTarget(time=meet.time, joint=joint, position=at, window=meet.window))
    return reaching(clip_a, first), reaching(clip_b, second)


# -- one target -------------------------------------------------------------------------------


def _at(clip: Clip, arm: Arm, time: float, point: ArrayLike | None = None) -> Posture:
    """The arm of a clip at a time [s]; `point` in the wrist's frame, by default the palm."""
    # A spline forgets a frame within a dozen others, to a ten-millionth: no need of the whole clip.
    first = max(0, min(int(time * clip.rate), clip.frames - 1) - AROUND)
    part = replace(
        clip,
        rotations=clip.rotations[first : first + 2 * AROUND + 2],
        root_positions=clip.root_positions[first : first + 2 * AROUND + 2],
    )
    local, root = sampled(part, [time - first / clip.rate])
    where = arm.hand if point is None else np.asarray(point, float)
    return posture(arm, clip.skeleton, local[0], root[0], where)


def _check_order(clip: Clip, targets: Sequence[HandTarget]) -> None:
    """Refuse two targets of one arm, in order of time, that are less than a frame apart."""
    for one, two in pairwise(targets):
        if two.time - one.time < 1.0 / clip.rate - 1e-9:
            raise InvalidValue(
                f"{one.joint!r} has two targets at {one.time:g} s, less than a frame apart."
            )


def _offset(clip: Clip, arm: Arm, target: HandTarget) -> tuple[Array, Reached]:
    """Rotation vectors (3, 3) that meet a target at its time, and how well they do."""
    before = _at(clip, arm, target.time, target.point)
    goal = np.asarray(target.position, float)
    distance = float(np.linalg.norm(goal - before.shoulder))
    length = arm.reach(before.point)
    where = (
        f"{target.joint!r}: the target at {target.time:.2f} s lies {distance:.2f} m from the "
        f"shoulder"
    )
    if distance > length + MISS:
        raise InvalidValue(f"{where}; the arm reaches {length:.2f} m.")
    offsets = solved(arm, before, goal)
    after = moved(before, offsets)
    miss = float(np.linalg.norm(place(arm, after) - goal))
    if miss > MISS:
        raise InvalidValue(f"{where}; the arm comes no nearer than {1000 * miss:.0f} mm to it.")
    turn = rot.angle(rot.from_matrix(before.hand().T @ after.hand()))
    way = float(np.linalg.norm(goal - place(arm, before)))
    return offsets, Reached(target=target, moved=way, miss=miss, turned=float(turn))


def _weights(times: Array, targets: Sequence[HandTarget]) -> Array:
    """How much of each target's offset there is in each frame, (targets, frames).

    `targets` are one arm's, in order of time. A weight is 1 at its own time and 0 at the others'.
    """
    own = [target.time for target in targets]
    rows = []
    for k, target in enumerate(targets):
        before = min(target.window, own[k] - own[k - 1]) if k else target.window
        after = min(target.window, own[k + 1] - own[k]) if k + 1 < len(own) else target.window
        since = times - target.time
        rows.append(eased(1.0 - np.where(since < 0.0, -since / before, since / after)))
    return np.array(rows)


# -- two bodies -------------------------------------------------------------------------------


def _between(sides: list[tuple[Arm, Posture]], palms: list[Array], meet: Meet) -> Array:
    """The place nearest to the middle of two palms that both reach easily [m], (3,).

    A hand that keeps its orientation reaches a ball about the shoulder, shifted by the hand; where
    those of two bodies do not touch, hands are stretched out as well.
    """
    kept, stretched = [], []
    for arm, pose in sides:
        bones = float(np.linalg.norm(arm.upper) + np.linalg.norm(arm.lower))
        kept.append((pose.shoulder + pose.hand() @ pose.point, EASY * bones - 0.5 * meet.apart))
        stretched.append((pose.shoulder, EASY * arm.reach(pose.point) - 0.5 * meet.apart))
    gap = 0.0
    for (here, near), (there, far) in (kept, stretched):
        gap = float(np.linalg.norm(here - there)) - near - far
        if gap <= 0.0:
            return _nearest(0.5 * (palms[0] + palms[1]), ((here, near), (there, far)))
    distance = float(np.linalg.norm(sides[0][1].shoulder - sides[1][1].shoulder))
    raise InvalidValue(
        f"{meet.hands[0]!r} and {meet.hands[1]!r} cannot meet at {meet.time:.2f} s: the shoulders "
        f"are {distance:.2f} m apart and the hands stay {gap:.2f} m apart. Place one clip nearer: "
        "clip.placed(at=...)."
    )


def _nearest(spot: Array, balls: tuple[tuple[Array, float], ...]) -> Array:
    """The point of all balls (center, radius) that is nearest to a spot, (3,).

    Dykstra's projections onto the balls in turn; they must have a point in common.
    """
    left = [np.zeros(3) for _ in balls]
    for k in range(200 * len(balls)):
        center, room = balls[k % len(balls)]
        start = spot + left[k % len(balls)]
        away = start - center
        spot = center + away * min(1.0, room / max(float(np.linalg.norm(away)), 1e-9))
        left[k % len(balls)] = start - spot
    return spot


# -- checks -----------------------------------------------------------------------------------


def _check_times(time: float, window: float) -> None:
    if not (isinstance(time, Real) and np.isfinite(time) and time >= 0.0):
        raise InvalidValue(f"time is {shown(time)}; it must be a time in seconds, 0 or more.")
    if not (isinstance(window, Real) and 1e-6 <= window <= 100.0):
        raise InvalidValue(f"window is {shown(window)}; it must be a time in 1e-6 to 100 s.")


def _spot(value: ArrayLike, name: str) -> tuple[float, float, float]:
    """Three finite numbers [m], as a value that compares."""
    x, y, z = frozen_array(value, (3,), name).tolist()
    return x, y, z


def _speed(speed: float) -> float:
    low, high = SPEEDS
    if not (isinstance(speed, Real) and low <= speed <= high):
        raise InvalidValue(f"speed is {shown(speed)}; it must lie in {low:g} to {high:g}.")
    return float(speed)


def _check_apart(clip: Clip, arms: dict[str, Arm]) -> None:
    """Refuse two hands whose arms share a joint."""
    users: dict[int, str] = {}
    for name, arm in arms.items():
        for joint in arm.joints:
            if joint in users:
                raise InvalidValue(
                    f"Targets of {users[joint]!r} and {name!r} both turn "
                    f"{clip.skeleton.names[joint]!r}; place one of them."
                )
            users[joint] = name
