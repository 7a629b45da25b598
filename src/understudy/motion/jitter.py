"""A joint that shakes faster than a body can, steadied.

Where markers are taken for one another, a segment's orientation jumps by some degrees and back
within a few frames, often less than a repair of single spikes looks for, and what hangs on it turns
against it: a pelvis that shakes while thighs and trunk do not, toes that flutter. It hardly shows
but in what the motion asks for: moments no body gives, a floor that is touched and left every other
frame. The stretch is drawn smoothly; what hangs on the joint keeps its orientation in the world.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import find_objects, gaussian_filter1d, label, maximum_filter1d

from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

# A joint farther than this from its own mean over some 12 ms about the frame [deg] shakes. The
# pelvis is heavy: kicks and hops stay below four degrees; an arm that throws, below six.
_ROOT, _LIMB, _SEEN = 4.5, 12.0, 0.012
# Around it, so long on either side [s], shaking by this part of it is steadied too.
_NEARBY, _LESSER = 0.5, 0.25
# Standard deviation of what is drawn instead; how far around, and how gently it goes over [s].
_DRAWN, _AROUND, _EASE = 0.025, 0.05, 0.02
_NO_ANSWER = 1e-3  # Keeps the point where too little turns to tell [squared turns].
_STILL = 1e-6  # Part of a quaternion in which a joint that never turns differs.


class Steadied(NamedTuple):
    """A stretch that was steadied.

    Attributes:
        first: Frame in which it begins.
        last: Its last frame.
        before: Largest turn from frame to frame in it, before [deg].
        after: The same, after [deg].
    """

    first: int
    last: int
    before: float
    after: float


def steadied(
    rotations: Array, path: Array, parents: Sequence[int], rate: float, joint: int
) -> tuple[Array, Array, list[Steadied]]:
    """Rotations and root path with a joint that shakes no more, and where it did.

    Args:
        rotations: Of all joints, the root first, relative to their parents, (frames, joints, 4).
        path: Of the root [m], (frames, 3); it changes with the root alone.
        parents: Index of every joint's parent; -1 for the root.
        rate: Frames per second; below 1 / (12 ms) nothing can be told and nothing is done.
        joint: Which one.
    """
    least = _LIMB if joint else _ROOT
    if _SEEN * rate < 1.0:
        return rotations, path, []
    own = rot.continuous(rotations[:, joint])
    off = np.degrees(rot.angle_between(own, _smooth_turns(own, _SEEN * rate)))
    if not (off > least).any():
        return rotations, path, []
    nearby: Any = maximum_filter1d(off > least, 2 * round(_NEARBY * rate) + 1)
    wide: Any = maximum_filter1d(nearby & (off > _LESSER * least), 2 * round(_AROUND * rate) + 1)
    weight = gaussian_filter1d(wide.astype(float), _EASE * rate, mode="nearest")
    calm = rot.slerp(own, _smooth_turns(own, _DRAWN * rate), weight)
    out = np.array(rotations)
    out[:, joint] = calm
    turn = rot.multiply(rot.conjugate(calm), own)
    for other, rigid in _hanging(rotations, parents, joint):
        world = rot.multiply(turn, rot.multiply(rigid, rotations[:, other]))
        out[:, other] = rot.multiply(rot.conjugate(rigid), world)
    if joint == 0:
        center = _center(own, path, wide, _SEEN * rate)
        seen = path + rot.rotate(own, center)
        drawn = seen + weight[:, None] * (_smooth(seen, _DRAWN * rate) - seen)
        path = drawn - rot.rotate(calm, center)
    return out, path, list(_stretches(wide, own, calm))


def _center(root: Array, path: Array, shakes: Any, deviation: float) -> Array:
    """The point of the root about which it shakes [m], (3,): its path shakes the least."""
    axes = np.stack([rot.rotate(root, axis) for axis in np.eye(3)], axis=2)
    shaking, moving = (x - _smooth(x, deviation) for x in (axes, path))
    a, b = shaking[shakes].reshape(-1, 3), -moving[shakes].reshape(-1)
    return np.linalg.solve(a.T @ a + _NO_ANSWER * np.eye(3), a.T @ b).astype(np.float64)


def _stretches(wide: Any, root: Array, calm: Array) -> Iterator[Steadied]:
    labeled: tuple[Array, int] = label(wide)  # type: ignore[assignment]
    for (span,) in find_objects(labeled[0]):
        before, after = (
            float(np.degrees(rot.angle_between(q[span][:-1], q[span][1:])).max(initial=0.0))
            for q in (root, calm)
        )
        yield Steadied(span.start, span.stop - 1, before, after)


def _hanging(rotations: Array, parents: Sequence[int], top: int) -> Iterator[tuple[int, Array]]:
    """Joints that turn on what is rigid with joint `top`, and how that is turned, (4,)."""
    rigid = {top: rot.identity()}
    for joint, parent in enumerate(parents):
        if parent in rigid:
            if np.ptp(rotations[:, joint], axis=0).max() < _STILL:
                rigid[joint] = rot.multiply(rigid[parent], rotations[0, joint])
            else:
                yield joint, rigid[parent]


def _smooth(values: Array, deviation: float) -> Array:
    """A Gaussian of so many frames over the first axis; the ends go on as they come."""
    more = min(round(4.0 * deviation) + 1, len(values) - 1)
    wide = np.pad(
        values, ((more, more), *((0, 0),) * (values.ndim - 1)), "reflect", reflect_type="odd"
    )
    return gaussian_filter1d(wide, deviation, axis=0, mode="nearest")[more : more + len(values)]


def _smooth_turns(q: Array, deviation: float) -> Array:
    """The same for orientations (frames, 4)."""
    return rot.normalized(_smooth(q, deviation))
