"""Clips joined in time: spliced at any two poses, or put end to end at a pose they share.

Zordan & Hodgins 1999, section 5.2. A splice lays both motions on one timeline and blends joint by
joint (equation 4) with a weight that eases in and out like a sinusoid; both keep moving meanwhile.
The second motion is first turned about the vertical and shifted over the ground so that heading and
place of the root agree in the middle of the blend. `motion.transitions` suggests where to splice.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from numbers import Integral, Real

import numpy as np

from understudy.errors import InvalidValue, expect, shown
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import placed, resampled, sampled, trimmed
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

# Joint positions of two skeletons that are one and the same differ by less than this [m].
SAME = 1e-4
# Home poses are one pose when no joint turns by more than this [rad] and the root's heights are
# within this [m].
HOME = float(np.radians(20.0))
HOME_HEIGHT = 0.15
# Velocities at a seam are those of parabolas through this much of a segment [s].
FITTED = 0.05
# A loop of more repetitions than this is a mistake.
MOST_LOOPS = 1000


def spliced(clip: Clip, other: Clip, *, at: float, blend: float = 0.5, start: float = 0.0) -> Clip:
    """The clip going over into another: equation 4 of Zordan & Hodgins 1999.

    From `at` to `at + blend` [s] of the clip both motions run and every joint turns from the one to
    the other by slerp, with w = (1 - cos(pi s)) / 2; `other` is at its own time `start` [s] when
    the blend begins. The short way is chosen once for each joint, in the middle of the blend, and
    the same side is kept throughout: chosen anew in each frame it jumps by a turn wherever two
    moving joints pass half a turn apart. `other` is turned about the vertical and shifted over the
    ground so that the root's heading and place agree in the middle; heights are blended.

    The result has the clip's frames up to `at` and its rate; `other` is sampled at that rate.

    Raises:
        InvalidValue: Clips of different skeletons, or times outside a clip.
    """
    check_pair(clip, other)
    check_blend(blend)
    _check_time(clip, at, blend, "at")
    _check_time(other, start, blend, "start")
    frames = int(np.floor((at + other.duration - start) * clip.rate + 1e-6)) + 1
    times = np.arange(frames) / clip.rate
    # The blend's own frames and what lies on either side.
    first = int(np.ceil(at * clip.rate - 1e-6))
    last = min(int(np.floor((at + blend) * clip.rate + 1e-6)) + 1, frames, clip.frames)
    shifted, moved = _aligned(clip, other, at + 0.5 * blend, start + 0.5 * blend)
    turned, path = sampled(shifted, np.clip(times[first:] - at + start, 0.0, None))
    ours, ground = clip.rotations[first:last], clip.root_positions[first:last]
    overlap = last - first
    weight = eased((times[first:last] - at) / blend)
    middle = min(int(np.searchsorted(weight, 0.5)), max(overlap - 1, 0))
    turned[:overlap] = blended(ours, turned[:overlap], weight, middle=middle)
    path[:overlap] = ground + weight[:, None] * (path[:overlap] - ground)
    note = (
        f"Spliced with {other.name!r} from its {start:g} s at {at:g} s, blended over {blend:g} s; "
        f"turned by {np.degrees(moved):.1f} degrees to continue the heading."
    )
    return replace(
        clip,
        rotations=np.concatenate((clip.rotations[:first], turned)),
        root_positions=np.concatenate((clip.root_positions[:first], path)),
        synthetic=clip.synthetic or other.synthetic,
        notes=(*clip.notes, note),
    )


def blended(a: Array, b: Array, weight: Array, *, middle: int) -> Array:
    """Rotations from `a` (weight 0) to `b` (weight 1), (frames, joints, 4); weight (frames,).

    The way from a to b is the short one in frame number `middle` and stays on that side of the
    quaternion sphere in the frames around it, also where it grows past half a turn.
    """
    if not len(a):
        return np.array(a)
    between = rot.continuous(rot.multiply(rot.conjugate(a), b))
    between = between * np.where(between[middle, :, :1] < 0.0, -1.0, 1.0)
    # The rotation vector of a signed quaternion: up to a whole turn, not half of one.
    sine = np.linalg.norm(between[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, between[..., :1])
    axis = between[..., 1:] / np.where(sine > 1e-12, sine, 1.0)
    return rot.multiply(a, rot.from_rotvec(weight[:, None, None] * angle * axis))


def eased(s: Array) -> Array:
    """The sinusoid ease: 0 for s <= 0, 1 for s >= 1, and no slope at either end."""
    return 0.5 - 0.5 * np.cos(np.pi * np.clip(s, 0.0, 1.0))


def concatenated(clips: Iterable[Clip], *, blend: float = 0.3, tolerance: float = HOME) -> Clip:
    """Segments that share a home pose, one after the other in the order given.

    Each begins where the one before ended: its first frame takes the place of that last frame,
    turned about the vertical and shifted over the ground. What the two poses and their velocities
    still differ by is taken out over `blend` [s] on either side, half on each, by cubics, so that
    neither jumps. All are sampled at the rate of the first.

    Args:
        clips: One or more, of one skeleton, each of two frames or more.
        blend: Time on either side over which differences fade [s]; shorter in shorter segments.
        tolerance: Most that a joint's two angles may differ by [rad].

    Raises:
        InvalidValue: No clips, different skeletons, or poses too far apart; the text names the
            joint and the angle.
    """
    parts = _segments(clips)
    check_blend(blend)
    first = parts[0]
    placed_parts = [first]
    for part in parts[1:]:
        _check_home(placed_parts[-1], part, tolerance)
        shifted, _ = _aligned(placed_parts[-1], part, placed_parts[-1].duration, 0.0)
        placed_parts.append(shifted)
    turned = [np.array(part.rotations) for part in placed_parts]
    path = [np.array(part.root_positions) for part in placed_parts]
    for k in range(len(parts) - 1):
        _joined(turned[k], turned[k + 1], path[k], path[k + 1], first.rate, blend)
    if len(parts) == 1:
        return first
    names = ", ".join(repr(part.name) for part in parts[:6]) + (", ..." if len(parts) > 6 else "")
    note = f"{len(parts)} segments end to end ({names}), smoothed over {blend:g} s at each seam."
    return replace(
        first,
        rotations=np.concatenate([turned[0], *(t[1:] for t in turned[1:])]),
        root_positions=np.concatenate([path[0], *(p[1:] for p in path[1:])]),
        synthetic=any(part.synthetic for part in parts),
        notes=(*first.notes, note),
    )


def looped(
    clip: Clip,
    count: int | None = None,
    *,
    until: float | None = None,
    blend: float = 0.3,
    tolerance: float = HOME,
) -> Clip:
    """The clip played `count` times, or as often as it takes and cut at `until` [s].

    Each round goes on from where the one before ended. The clip must end in the pose in which it
    begins, but for heading and place; see `concatenated`.

    Raises:
        InvalidValue: Neither or both of `count` and `until`, or ends that are too far apart.
    """
    if (count is None) == (until is None):
        raise InvalidValue("looped needs one of count and until, as clip.looped(4).")
    if until is not None:
        if not (isinstance(until, Real) and 0.0 < until <= MOST_LOOPS * max(clip.duration, 1e-9)):
            raise InvalidValue(
                f"until is {shown(until)} s; it must lie in 0 to {MOST_LOOPS} times the clip's "
                f"{clip.duration:g} s."
            )
        count = int(np.ceil(until / clip.duration - 1e-9))
    if not (isinstance(count, Integral) and 1 <= count <= MOST_LOOPS):
        raise InvalidValue(f"count is {shown(count)}; it must be a whole number, 1 to 1000.")
    out = concatenated([clip] * int(count), blend=blend, tolerance=tolerance)
    return out if until is None else trimmed(out, 0.0, min(until, out.duration))


# -- alignment --------------------------------------------------------------------------------


def _aligned(clip: Clip, other: Clip, time: float, time_other: float) -> tuple[Clip, float]:
    """`other`, placed so that its root at `time_other` is over the clip's at `time`; its turn.

    The turn [rad] is the part about the vertical of what leads from the one root orientation to the
    other: it makes them as alike as turning about the vertical can.
    """
    ours, here = sampled(clip, [time])
    theirs, there = sampled(other, [time_other])
    between = rot.multiply(ours[0, 0], rot.conjugate(theirs[0, 0]))
    heading = 2.0 * float(np.arctan2(between[3], between[0]))
    heading = (heading + np.pi) % (2.0 * np.pi) - np.pi
    turn = rot.from_rotvec(np.array([0.0, 0.0, heading]))
    way = rot.rotate(turn, there[0] - other.root_positions[0])
    at = here[0] - way
    return placed(other, at=at[:2], heading=heading), heading


def _joined(
    before: Array, after: Array, path: Array, path_after: Array, rate: float, blend: float
) -> None:
    """Change the end of one segment and the start of the next so that they meet smoothly.

    Rotations (frames, joints, 4) and root paths (frames, 3) are changed in place: half the
    difference of pose and of velocity fades out on either side.
    """
    apart = rot.to_rotvec(rot.multiply(rot.conjugate(before[-1]), after[0]))
    ends = [
        rot.to_rotvec(rot.multiply(rot.conjugate(turned[:1]), turned))
        for turned in (before[::-1], after)
    ]
    faster = _slope(ends[1], rate) + _slope(ends[0], rate)
    # The root path meets over the ground already: only height and velocity differ.
    gap = path_after[0] - path[-1]
    quicker = _slope(path_after - path_after[0], rate) + _slope(path[::-1] - path[-1], rate)
    for turned, places, sign in ((before, path, 1.0), (after, path_after, -1.0)):
        window = min(blend, (len(turned) - 1) / rate)
        here = slice(None, None, -1) if sign > 0 else slice(None)
        value, slope = _fading(np.arange(len(turned)) / rate, window)
        # On the way to the seam time runs toward it, so the slope changes sign; half to each.
        value, slope = 0.5 * sign * value[:, None], -0.5 * slope[:, None]
        offset = value[..., None] * apart + slope[..., None] * faster
        turned[:] = rot.multiply(turned, rot.from_rotvec(offset[here]))
        places += (value * gap + slope * quicker)[here]


def _slope(values: Array, rate: float) -> Array:
    """Rate of change at the first frame of values that are 0 there, by a parabola, (...)."""
    frames = min(len(values), max(3, round(FITTED * rate)))
    s = np.arange(frames) / rate
    terms = np.stack((s, s * s), axis=-1)[:, : frames - 1]
    fit = np.linalg.lstsq(terms, values[:frames].reshape(frames, -1), rcond=None)[0]
    return fit[0].reshape(values.shape[1:])


def _fading(time: Array, window: float) -> tuple[Array, Array]:
    """Two cubics of the time from a seam [s] that end flat at `window`: value 1, and slope 1."""
    s = np.clip(time / max(window, 1e-9), 0.0, 1.0)
    return (1.0 - s) ** 2 * (1.0 + 2.0 * s), window * s * (1.0 - s) ** 2


# -- checks -----------------------------------------------------------------------------------


def same_skeleton(a: Skeleton, b: Skeleton) -> bool:
    """Whether motion of one fits the other: all but where the root rests is alike."""
    return (
        a.names == b.names
        and a.parents == b.parents
        and a.end_joints == b.end_joints
        and np.allclose(a.offsets[1:], b.offsets[1:], atol=SAME)
        and np.allclose(a.end_offsets, b.end_offsets, atol=SAME)
    )


def check_pair(clip: Clip, other: Clip) -> None:
    """Refuse two clips that are not of one skeleton.

    Raises:
        InvalidValue: Says how they differ and what to do.
    """
    expect(clip, Clip, "clip", "a Clip")
    expect(other, Clip, "other", "a Clip")
    a, b = clip.skeleton, other.skeleton
    if same_skeleton(a, b):
        return
    strange = [name for name in b.names if name not in a.names]
    lacking = [name for name in a.names if name not in b.names]
    if strange or lacking:
        how = f"only one has the joint {(strange or lacking)[0]!r}"
    elif a.parents != b.parents or a.names != b.names or len(a.end_joints) != len(b.end_joints):
        how = "their joints hang together differently"
    else:
        how = "their bones differ in length"
    raise InvalidValue(
        f"{clip.name!r} and {other.name!r} are not on one skeleton: {how}. Bring both onto one "
        "body first: understudy.retargeted(clip, character)."
    )


def check_blend(blend: float) -> None:
    """Refuse a blend [s] that is not a positive time."""
    if not (isinstance(blend, Real) and 0.0 < blend <= 100.0):
        raise InvalidValue(f"blend is {shown(blend)}; it must be a time in 0 to 100 s.")


def _check_time(clip: Clip, time: float, blend: float, name: str) -> None:
    slack = 0.5 / clip.rate
    last = clip.duration - blend
    if not (isinstance(time, Real) and -1e-9 <= time <= last + slack):
        if last < -slack:
            raise InvalidValue(
                f"A blend of {blend:g} s does not fit into {clip.name!r}, which lasts "
                f"{clip.duration:g} s."
            )
        raise InvalidValue(
            f"{name} is {shown(time)} s; with a blend of {blend:g} s it must lie in 0 to "
            f"{max(last, 0.0):g} s of {clip.name!r}."
        )


def _segments(clips: Iterable[Clip]) -> list[Clip]:
    """The clips at the rate of the first, checked."""
    expect(clips, Iterable, "clips", "a list of Clips")
    parts = list(clips)
    if not parts:
        raise InvalidValue("concatenated needs at least one clip.")
    for part in parts:
        check_pair(parts[0], part)
        if part.frames < 2 and len(parts) > 1:
            raise InvalidValue(f"{part.name!r} has one frame; a segment needs two or more.")
    return [resampled(part, parts[0].rate, method="spline") for part in parts]


def _check_home(before: Clip, after: Clip, tolerance: float) -> None:
    """Refuse a seam whose two poses are further apart than `tolerance` [rad]."""
    if not (isinstance(tolerance, Real) and 0.0 < tolerance <= np.pi):
        raise InvalidValue(f"tolerance is {shown(tolerance)}; it must be an angle in 0 to pi rad.")
    between = rot.multiply(before.rotations[-1], rot.conjugate(after.rotations[0]))
    # Heading does not count: the part about the vertical is taken off the root.
    twist = rot.normalized(between[0] * np.array([1.0, 0.0, 0.0, 1.0]))
    between[0] = rot.multiply(rot.conjugate(twist), between[0])
    angles = rot.angle(between)
    worst = int(angles.argmax())
    remedy = "Trim both to a pose they share, or use spliced, which joins any two poses."
    if angles[worst] > tolerance:
        raise InvalidValue(
            f"{after.name!r} does not begin in the pose in which {before.name!r} ends: "
            f"{before.skeleton.names[worst]!r} is {np.degrees(angles[worst]):.0f} degrees off, "
            f"{np.degrees(tolerance):.0f} are allowed. {remedy}"
        )
    height = float(after.root_positions[0, 2] - before.root_positions[-1, 2])
    if abs(height) > HOME_HEIGHT:
        raise InvalidValue(
            f"{after.name!r} begins {height:+.2f} m above where {before.name!r} ends; "
            f"{HOME_HEIGHT} m is allowed. {remedy}"
        )
