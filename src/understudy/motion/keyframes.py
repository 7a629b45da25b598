"""Key poses in anatomical angles, joined into a clip.

    clip = keyframed(
        [
            Key(time=0.0, pose=STANDING),
            Key(time=0.8, pose={"right_shoulder": {"abduction": 150}}),
            Key(time=1.6, pose=STANDING),
        ]
    )

A pose names only the joints it sets; between the keys that set it, a joint moves smoothly, and
before its first and after its last it stays. Joints that no key sets keep the standing pose.

Angles are in degrees from the neutral standing position (arms hanging, palms to the thighs) and
have the same sign on both sides:

    shoulder, hip   flexion (forward), abduction (outward), rotation (inward)
    elbow           flexion, pronation           wrist   flexion (palmward), deviation (thumbward)
    knee            flexion                      ball    extension (toes up)
    ankle           flexion (toes up), inversion, rotation (inward)
    pelvis, lower_back, upper_back, neck   flexion (forward), bend and turn (both to the left)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton, frozen_array

Angles = Mapping[str, float]
Pose = Mapping[str, Any]
Ease = Literal["spline", "rest"]

# Every joint at its neutral standing angle; arms a little off the body, elbows not locked.
STANDING: dict[str, Angles] = {
    f"{side}_{joint}": angles
    for side in ("left", "right")
    for joint, angles in (
        ("shoulder", {"abduction": 7.0, "flexion": 2.0}),
        ("elbow", {"flexion": 14.0, "pronation": 12.0}),
        ("wrist", {"flexion": 4.0}),
    )
}

_X, _Y, _Z = np.eye(3)
# Axis (for the left side) of each angle, outermost rotation first. The standard figure rests in
# a T-pose facing +x with left +y; the arm's own axis is y and the leg's is -z.
_AXES: dict[str, tuple[tuple[str, Array], ...]] = {
    "shoulder": (("flexion", -_Y), ("abduction", _X), ("rotation", _Y)),
    "elbow": (("flexion", -_Z), ("pronation", _Y)),
    "wrist": (("flexion", -_X), ("deviation", -_Z)),
    "hip": (("flexion", -_Y), ("abduction", _X), ("rotation", -_Z)),
    "knee": (("flexion", _Y),),
    "ankle": (("flexion", -_Y), ("inversion", -_X), ("rotation", -_Z)),
    "ball": (("extension", -_Y),),
    "trunk": (("turn", _Z), ("flexion", _Y), ("bend", -_X)),
}


def rotation(joint: str, angles: Mapping[str, ArrayLike] | Sequence[float]) -> Array:
    """Local rotation of a standard joint from named angles [deg] or a rotation vector [rad].

    Angles may be arrays of one shape (...); the rotations are then (..., 4).

    Raises:
        UnknownName: The joint has no such angle; the text lists those it has.
        InvalidValue: An angle or vector that is not finite numbers.
    """
    if not isinstance(angles, Mapping):
        return rot.from_rotvec(frozen_array(angles, (3,), f"rotation vector of {joint!r}"))
    side, _, part = joint.partition("_") if joint.startswith(("left_", "right_")) else ("", "", "")
    axes = _AXES.get(part, _AXES["trunk"] if not side else ())
    given = dict(angles)
    q = rot.identity()
    for name, axis in axes:
        degrees = np.asarray(given.pop(name, 0.0), float)
        if not np.isfinite(degrees).all():
            raise InvalidValue(f"{joint}: {name} is {degrees}; it must be a finite angle.")
        vector = np.radians(degrees)[..., None] * axis
        if name == "rotation" and part == "shoulder":
            q = rot.multiply(q, rot.from_rotvec(-0.5 * np.pi * _X))  # the T-pose's arm hangs down
        q = rot.multiply(q, rot.from_rotvec(vector))
    if given:
        raise UnknownName(f"angle of {joint}", next(iter(given)), [name for name, _ in axes])
    # Reflection in the plane y = 0 gives the right side.
    return q * np.array([1.0, -1.0, 1.0, -1.0]) if side == "right" else q


@dataclass(frozen=True, kw_only=True)
class Key:
    """A pose at a time.

    Attributes:
        time: When [s].
        pose: Joint name to angles [deg] by name, or to a rotation vector [rad] of three numbers.
        root: Position of the pelvis [m] in the world, or None to leave it to the other keys.
    """

    time: float
    pose: Pose = field(default_factory=dict)
    root: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if not np.isfinite(self.time):
            raise InvalidValue(f"time of a key is {self.time}; it must be finite.")


def keyframed(
    keys: Sequence[Key],
    *,
    skeleton: Skeleton | None = None,
    rate: float = 120.0,
    ease: Ease = "spline",
    base: Pose = STANDING,
    name: str = "keyframed",
) -> Clip:
    """A clip on the standard figure (or another skeleton with its joint names) through key poses.

    Args:
        keys: In order of time; the clip lasts from the first to the last.
        skeleton: Defaults to `figure()`.
        rate: Frames per second [Hz].
        ease: "spline" passes through keys and never swings beyond them (a monotone cubic, Fritsch &
            Butland 1984; continuous speed, at rest at both ends and where it turns back); "rest"
            comes to rest at every key (minimum-jerk timing, Flash & Hogan 1985; geodesic path).
        base: Pose of joints that no key sets.
        name: Name of the clip.

    Raises:
        InvalidValue: No key, or times that do not increase.
        UnknownName: A joint or an angle that does not exist.
    """
    if not keys or any(b.time <= a.time for a, b in pairwise(keys)):
        raise InvalidValue("keyframed needs at least one key, with times that increase.")
    if ease not in ("spline", "rest"):
        raise InvalidValue(f"ease is {ease!r}; it must be 'spline' or 'rest'.")
    skeleton = figure() if skeleton is None else skeleton
    start, end = keys[0].time, keys[-1].time
    times = start + np.arange(int(np.floor((end - start) * rate + 1e-6)) + 1) / rate
    turned = rot.identity(len(times), len(skeleton))
    for joint, angles in base.items():
        turned[:, skeleton.index(joint)] = rotation(joint, angles)
    for joint in dict.fromkeys(j for key in keys for j in key.pose):
        index = skeleton.index(joint)
        known = [key for key in keys if joint in key.pose]
        track = np.array([rotation(joint, key.pose[joint]) for key in known])
        knots = np.array([key.time for key in known])
        turned[:, index] = _rotation_track(knots, track, times, ease)
    placed = [key for key in keys if key.root is not None]
    path = np.tile(skeleton.offsets[0], (len(times), 1))
    if placed:
        knots = np.array([key.time for key in placed])
        path = eased(knots, np.array([key.root for key in placed], float), times, ease)
    return Clip(
        skeleton=skeleton,
        rotations=turned,
        root_positions=path,
        rate=rate,
        name=name,
        synthetic=True,
        notes=("Made from key poses; not captured.",),
    )


def _rotation_track(knots: Array, track: Array, times: Array, ease: Ease) -> Array:
    track = rot.continuous(track)
    if ease == "spline" or len(knots) == 1:
        return rot.normalized(eased(knots, track, times, ease))
    low, weight = _stretch(knots, times)
    return rot.slerp(track[low], track[low + 1], weight)


def eased(knots: Array, values: Array, times: Array, ease: Ease = "spline") -> Array:
    """Values (keys, n) at increasing `knots` [s], joined over `times` [s] as `keyframed` does."""
    if len(knots) == 1:
        return np.repeat(values, len(times), axis=0)
    if ease == "spline":
        inside = np.clip(times, knots[0], knots[-1])
        slow = np.array([knots[0] - 1.0, *knots, knots[-1] + 1.0])  # at rest at both ends
        return PchipInterpolator(slow, values[[0, *range(len(values)), -1]])(inside)
    low, weight = _stretch(knots, times)
    return values[low] + weight[:, None] * (values[low + 1] - values[low])


def _stretch(knots: Array, times: Array) -> tuple[np.ndarray, Array]:
    """For each time the key before it and the weight of the next (minimum jerk)."""
    low = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(knots) - 2)
    s = np.clip((times - knots[low]) / (knots[low + 1] - knots[low]), 0.0, 1.0)
    return low, s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
