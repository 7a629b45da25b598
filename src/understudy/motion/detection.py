"""What a motion file does not say: vertical axis, unit, a T-pose before the motion, a wrong rate.

Legs and arms are found without names, as pairs of equal chains, the legs being the pair nearest the
root. Each finding comes with a sentence for the clip's notes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.recording import UNITS, Recording
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

# Thigh and shank together in body heights: Drillis & Contini 1966, in Winter, Biomechanics and
# Motor Control of Human Movement, figure 4.1 (.530 - .039).
LEG = 0.491
ADULT = 1.75  # m, assumed where no standard unit gives a plausible person
PLAUSIBLE = (1.40, 2.10)  # m, standing heights of adults
POSSIBLE = (0.80, 2.40)  # m, standing heights from a small child on
IMAGINED = (0.60, 3.50)  # m, standing heights of made-up bodies
# Files on Poser's figure, told by its joints, are near centimeters: the root track of CMU's trial
# 02_01 is as long as in the other conversions with this unit.
POSER, POSER_UNIT = {"lButtock", "rButtock"}, 0.01024
T_POSE_JUMP = np.radians(20.0)
BLEND = 0.25  # s, how long a conversion blends from its T-pose into the motion


@dataclass(frozen=True)
class Limbs:
    """A pair of equal chains of joints: two legs or two arms.

    Attributes:
        root: The joint both hang from.
        chains: Joints from the first below `root` to the last, for either side.
        length: Length of the chain in file units, from `root` to its end.
    """

    root: int
    chains: tuple[tuple[int, ...], tuple[int, ...]]
    length: float


@dataclass(frozen=True)
class Shape:
    """What the detectors look at: limbs, and joint positions in some frames, in the file's axes.

    Attributes:
        skeleton: Joints, offsets in file units.
        legs: The legs, or None.
        arms: The arms, or None.
        positions: Joint positions in a sample of frames, shape (frames, joints, 3).
        rest: Joint positions of the rest pose, shape (joints, 3).
    """

    skeleton: Skeleton
    legs: Limbs | None
    arms: Limbs | None
    positions: Array
    rest: Array


def shape_of(recording: Recording) -> Shape:
    """Limbs and sampled poses of a recording."""
    skeleton = recording.skeleton
    # At most 60 frames show the posture well enough; the first may be a T-pose.
    some = np.unique(
        np.linspace(min(1, recording.frames - 1), recording.frames - 1, 60).astype(int)
    )
    sample = Clip(
        skeleton=skeleton,
        rotations=recording.rotations[some],
        root_positions=recording.root_positions[some],
        rate=1.0,
    )
    legs, arms = limbs(skeleton)
    return Shape(
        skeleton, legs, arms, sample.forward_kinematics().positions, skeleton.rest_positions()
    )


def limbs(skeleton: Skeleton) -> tuple[Limbs | None, Limbs | None]:
    """Legs and arms of a skeleton, each None where there is no such pair."""
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    reach = np.zeros(len(skeleton))  # longest way from a joint outward
    outward = np.full(len(skeleton), -1)
    depth = np.zeros(len(skeleton))  # way from the root
    for joint, offset in zip(skeleton.end_joints, skeleton.end_offsets, strict=True):
        reach[joint] = max(reach[joint], float(np.linalg.norm(offset)))
    for i in range(len(skeleton) - 1, 0, -1):
        p = skeleton.parents[i]
        if lengths[i] + reach[i] > reach[p] or outward[p] < 0:
            reach[p], outward[p] = max(reach[p], lengths[i] + reach[i]), i
    for i, p in enumerate(skeleton.parents[1:], 1):
        depth[i] = depth[p] + lengths[i]

    def chain(joint: int) -> tuple[int, ...]:
        out = [joint]
        while outward[out[-1]] >= 0:
            out.append(int(outward[out[-1]]))
        return tuple(out)

    pairs: list[Limbs] = []
    longest = max(float(reach[0]), 1e-12)
    for root in range(len(skeleton)):
        below = [c for c in skeleton.children(root) if lengths[c] + reach[c] > 0.15 * longest]
        # Many equal children (a hand, a spider) still give one pair: the two most alike.
        below.sort(key=lambda c: -(lengths[c] + reach[c]))
        best: tuple[float, Limbs] | None = None
        for a, b in combinations(below[:8], 2):
            one, two = chain(a), chain(b)
            unlike = _difference(lengths[list(one)], lengths[list(two)])
            if unlike < 0.15 and (best is None or unlike < best[0]):
                best = unlike, Limbs(root, (one, two), float(lengths[a] + reach[a]))
        if best is not None:
            pairs.append(best[1])
    if not pairs:
        return None, None
    most = max(pair.length for pair in pairs)
    large = sorted((p for p in pairs if p.length > 0.5 * most), key=lambda p: depth[p.root])
    legs = large[0]
    within = {j for side in legs.chains for j in side}
    others = [p for p in large[1:] if p.root not in within]
    arms = max(others, key=lambda p: p.length, default=None)
    return legs, arms


def _difference(a: Array, b: Array) -> float:
    """How unlike two chains are: largest difference of their bones over the whole length."""
    a, b = a[a > 1e-9 * a.sum()], b[b > 1e-9 * b.sum()]
    if len(a) != len(b) or len(a) < 2:
        return np.inf
    return float(np.abs(a - b).max() / max(a.sum(), b.sum()) * 3.0)


def up_axis(shape: Shape) -> tuple[str, str]:
    """The vertical axis "x", "y" or "z" of a file, and a note."""
    if shape.legs is None:
        return "y", "Vertical axis y assumed, as BVH files have it: no pair of legs was found."
    for positions, where in ((shape.positions, "in the motion"), (shape.rest[None], "at rest")):
        # The trunk above the legs and the legs above the feet; on the average over the clip.
        rise = _rise(shape.legs, shape.arms, positions)
        order = np.argsort(-np.abs(rise))
        size = np.abs(rise)
        if size[order[0]] > 1e-9 and size[order[1]] < 0.75 * size[order[0]]:
            axis = "xyz"[order[0]]
            if rise[order[0]] > 0:
                return axis, f"Vertical axis {axis}: the body stands along it {where}."
            return axis, f"Vertical axis {axis}, with the body upside down {where}."
    return "y", "Vertical axis y assumed: the body stands along no axis clearly."


def _rise(legs: Limbs, arms: Limbs | None, positions: Array) -> Array:
    """Mean vector from the feet by the hips to the shoulders, in file units, shape (3,)."""
    feet = np.mean([positions[:, side[-1]] for side in legs.chains], axis=(0, 1))
    hips = positions[:, legs.root].mean(0)
    rise = hips - feet
    if arms is not None:
        trunk = positions[:, arms.root].mean(0) - hips
        # A trunk across the legs, as a dog's, says nothing about the vertical.
        if trunk @ rise > 0.4 * np.linalg.norm(trunk) * np.linalg.norm(rise):
            rise = rise + trunk
    return rise


def standing_height(shape: Shape) -> float | None:
    """Standing height of a person with these legs, in file units; None for another body.

    A person's arms hang from a trunk that goes on where the legs end: a body whose trunk lies
    across its legs (a dog, a spider) is no person.
    """
    legs, arms = shape.legs, shape.arms
    if legs is None or arms is None:
        return None
    feet = np.mean([shape.positions[:, side[-1]] for side in legs.chains], axis=0)
    hips = shape.positions[:, legs.root]
    trunk = shape.positions[:, arms.root] - hips
    leg = hips - feet
    cosine = np.sum(trunk * leg, -1) / np.maximum(
        np.linalg.norm(trunk, axis=-1) * np.linalg.norm(leg, axis=-1), 1e-12
    )
    if np.median(cosine) < 0.4:
        return None
    lengths = np.linalg.norm(shape.skeleton.offsets, axis=1)
    sums = []
    for side in legs.chains:
        bones = np.sort(lengths[list(side)])[::-1]
        # Twist joints break a thigh into pieces; then most of the whole chain is the leg.
        sums.append(max(bones[:2].sum(), 0.75 * bones.sum()))
    return float(np.mean(sums)) / LEG


def unit(shape: Shape, up: str, stated: float | None) -> tuple[float, str]:
    """Meters per file unit, and a note."""
    height = standing_height(shape)
    low, high = POSSIBLE
    if stated is not None and (height is None or low <= height * stated <= high):
        person = "" if height is None else f": a person of {height * stated:.2f} m"
        return stated, f"Unit {stated:.6g} m, as the file states{person}."
    if height is None or height < 1e-9:
        return _unit_of_body(shape)
    for (low, high), names in (
        (PLAUSIBLE, ("cm", "m", "cmu", "inch", "mm", "ft")),
        (POSSIBLE, ("cm", "m", "mm")),
        (IMAGINED, ("cm", "m")),
    ):
        for name in names:
            if low <= height * UNITS[name] <= high:
                if name == "cm" and set(shape.skeleton.names) >= POSER:
                    return POSER_UNIT, f"Unit {POSER_UNIT} m: CMU's motion on Poser's figure."
                tall = height * UNITS[name]
                return UNITS[name], (
                    f"Unit {UNITS[name]:.6g} m ({name}): the legs fit a person of {tall:.2f} m."
                )
    # Four digits, so that the same clip written and read again gives the same unit.
    scale = float(f"{ADULT / height:.4g}")
    return scale, (
        f"Unit {scale:.4g} m: no standard unit fits, so the body is scaled to a person of "
        f"{ADULT} m; pass unit= (--unit) if it is not."
    )


def _unit_of_body(shape: Shape) -> tuple[float, str]:
    """The standard unit in which a body that is no person comes nearest 1 m in size."""
    size = float(np.ptp(shape.positions[0], axis=0).max()) if len(shape.skeleton) > 1 else 0.0
    if size < 1e-9:
        return UNITS["cm"], "Unit 0.01 m (cm) assumed: the body has no size."
    name = min(("cm", "m", "mm"), key=lambda n: abs(np.log(size * UNITS[n])))
    return UNITS[name], (
        f"Unit {UNITS[name]:g} m ({name}) assumed: the body, no person, is then "
        f"{size * UNITS[name]:.2f} m in size."
    )


def first_motion_frame(recording: Recording, rate: float, t_pose: str) -> tuple[int, str]:
    """Number of frames to drop before the motion starts, and a note (empty when none).

    A converter's T-pose has a root that is not turned at all and is far from the second frame; some
    converters then blend from it into the motion.
    """
    frames = recording.frames
    if t_pose == "keep" or frames < 3:
        return 0, ""
    early = recording.rotations[: min(frames, 600)]
    steps = rot.angle_between(early[:-1], early[1:]).max(axis=1)  # the joint that turns most
    usual = float(np.median(steps[1:]))
    still = float(rot.angle(recording.rotations[0, 0])) < 1e-6
    jumps = steps[0] > max(T_POSE_JUMP, 4.0 * usual)
    if t_pose == "auto" and not (still and jumps):
        return 0, ""
    blend = round(BLEND * rate)
    after = steps[blend:]
    if frames > 3 * blend and blend >= 4 and len(after) >= blend:
        # A blend shows as steps that start far above the motion's own and die away.
        start = steps[1:3]
        fast = max(np.radians(8.0), 2.5 * float(np.percentile(after, 90)))
        if start.min() > fast:
            return blend, (
                f"Dropped a T-pose and the blend out of it: the first {blend} frames "
                f"({BLEND} s; t_pose='keep', --t-pose keep, keeps them)."
            )
    return 1, (
        f"Dropped a T-pose before the motion: frame 0, {np.degrees(steps[0]):.0f} degrees from "
        "frame 1 (t_pose='keep', --t-pose keep, keeps it)."
    )


def lift_from_zero(skeleton: Skeleton, rotations: Array, path: Array) -> tuple[Array, list[str]]:
    """What stands a body on z = 0 whose root never leaves the origin [m], (3,), and a note."""
    none = np.zeros(3)
    if np.abs(path).max() > 1e-9 or len(skeleton) < 2:
        return none, []
    some = np.unique(np.linspace(0, len(path) - 1, 600).astype(int))
    lowest = float(_heights(skeleton, rotations[some], path[some])[1].min())
    if lowest > -1e-6:
        return none, []
    return np.array([0.0, 0.0, -lowest]), [
        f"The root path is zero, so the motion stays in place; the body was raised by "
        f"{-lowest:.3f} m to stand on the ground."
    ]


def _heights(skeleton: Skeleton, rotations: Array, path: Array) -> tuple[Array, Array]:
    """Heights of the joints [m], (frames, joints), and of the lowest point, (frames,)."""
    pose = Clip(
        skeleton=skeleton, rotations=rotations, root_positions=path, rate=1.0
    ).forward_kinematics()
    joints = pose.positions[..., 2]
    return joints, np.minimum(joints.min(axis=1), pose.ends[..., 2].min(axis=1, initial=np.inf))


def rate_notes(skeleton: Skeleton, rotations: Array, path: Array, rate: float) -> list[str]:
    """A warning when bodies in flight fall far from 9.81 m/s2, as at a wrong frame rate."""
    falls = free_fall(skeleton, rotations, path, rate)
    if len(falls) == 0 or np.ptp(falls) > 0.6 * np.median(falls):
        return []
    gravity = float(np.median(falls))
    # A rate twice too high gives four times the acceleration. Slow rising on the toes looks like
    # one slow fall, so that takes two.
    for factor, low, high, least in ((0.5, 30.0, 56.0, 1), (2.0, 1.7, 3.4, 2)):
        if low < gravity < high and len(falls) >= least:
            return [
                f"Flights fall with {gravity:.1f} m/s2 at {rate:g} Hz; with "
                f"rate={rate * factor:g} (--rate) it would be {gravity * factor**2:.1f}."
            ]
    return []


def free_fall(skeleton: Skeleton, rotations: Array, path: Array, rate: float) -> Array:
    """Downward acceleration [m/s2] in each flight of a motion with z up, shape (flights,).

    A flight is a stretch in which the whole body is clear of the ground and its middle (the mean of
    all joints, which strays less from the center of mass than the root does) follows a parabola.
    Looks at 1200 frames at up to about 120 Hz: enough for a warning.
    """
    stride = max(1, round(rate / 120.0))
    some = slice(0, 1200 * stride, stride)
    rate = rate / stride
    heights, lowest = _heights(skeleton, rotations[some], path[some])
    size = float(np.median(heights.max(axis=1) - lowest))
    clear = lowest > np.percentile(lowest, 5) + 0.03 * size
    edges = np.flatnonzero(np.diff(np.concatenate(([0], clear.astype(int), [0]))))
    found = []
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start < max(5, round(0.058 * rate)) or start == 0 or stop == len(lowest):
            continue
        time = np.arange(stop - start) / rate
        middle = heights[start:stop].mean(axis=1)
        matrix = np.stack((np.ones_like(time), time, 0.5 * time * time), axis=1)
        fit = np.linalg.lstsq(matrix, middle, rcond=None)[0]
        rise = float(np.ptp(middle))
        misfit = float(np.abs(middle - matrix @ fit).max())
        if fit[2] < 0 and rise > 0.02 * size and misfit < 0.06 * rise:
            found.append(-fit[2])
    return np.array(found)
