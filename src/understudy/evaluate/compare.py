"""Two motions on one skeleton, compared: angles, distances and the time one lags the other."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array


def sampled(clip: Clip, times: Array) -> tuple[Array, Array]:
    """A clip at any times [s], by slerp; times outside it get its first or last frame.

    Returns:
        Local rotations wxyz (times, joints, 4) and root positions [m] (times, 3).
    """
    position = np.clip(np.asarray(times, float), 0.0, clip.duration) * clip.rate
    first = np.minimum(np.floor(position + 1e-9).astype(int), clip.frames - 1)
    after = np.minimum(first + 1, clip.frames - 1)
    weight = np.clip(position - first, 0.0, 1.0)
    if np.all(weight < 1e-6):
        return clip.rotations[first], clip.root_positions[first]
    path = clip.root_positions
    return (
        rot.slerp(clip.rotations[first], clip.rotations[after], weight[:, None]),
        path[first] + weight[:, None] * (path[after] - path[first]),
    )


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A motion against its reference, at the same times on the same skeleton.

    Attributes:
        times: [s], shape (frames,).
        joint_angles: Angle between local rotations [rad], shape (frames, joints - 1); the root is
            left out.
        root_angles: Angle between root orientations [rad], shape (frames,).
        root_distances: Between root positions [m], shape (frames,).
        root_drops: How much lower the motion's root is [m], shape (frames,).
        distances: Between joint positions in the world [m], shape (frames, joints).
        aligned_distances: The same with both motions expressed in their own root's frame [m],
            shape (frames, joints).
        relative_distances: The same with each motion's root moved to the origin but not turned
            [m], shape (frames, joints).
        end_distances: Between end sites in the world [m], shape (frames, ends).
    """

    times: Array = field(repr=False)
    joint_angles: Array = field(repr=False)
    root_angles: Array = field(repr=False)
    root_distances: Array = field(repr=False)
    root_drops: Array = field(repr=False)
    distances: Array = field(repr=False)
    aligned_distances: Array = field(repr=False)
    relative_distances: Array = field(repr=False)
    end_distances: Array = field(repr=False)


def compared(motion: Clip, reference: Clip, *, lag: float = 0.0) -> Comparison:
    """Compare `motion` at its frames with `reference`, `lag` seconds earlier.

    Only frames for which the shifted reference exists count; motion longer than its reference has
    nothing to be measured against there.

    Raises:
        InvalidValue: The skeletons have different joints, or the two share no time.
    """
    if motion.skeleton.names != reference.skeleton.names:
        raise InvalidValue("The two motions are on different skeletons; retarget one first.")
    wanted = motion.times - lag
    shared = np.flatnonzero((wanted >= -1e-9) & (wanted <= reference.duration + 1e-9))
    if not len(shared):
        raise InvalidValue("The motion and its reference share no moment in time.")
    turned, path = sampled(reference, wanted[shared])
    one = Clip(
        skeleton=motion.skeleton,
        rotations=motion.rotations[shared],
        root_positions=motion.root_positions[shared],
        rate=motion.rate,
    )
    two = Clip(skeleton=motion.skeleton, rotations=turned, root_positions=path, rate=motion.rate)
    a, b = one.forward_kinematics(), two.forward_kinematics()

    def in_root_frame(clip: Clip, positions: Array) -> Array:
        back = rot.conjugate(clip.rotations[:, :1])
        return rot.rotate(back, positions - clip.root_positions[:, None])

    apart = a.positions - b.positions
    angles = rot.angle_between(one.rotations, two.rotations)
    return Comparison(
        times=motion.times[shared],
        joint_angles=angles[:, 1:],
        root_angles=angles[:, 0],
        root_distances=np.linalg.norm(one.root_positions - two.root_positions, axis=-1),
        root_drops=two.root_positions[:, 2] - one.root_positions[:, 2],
        distances=np.linalg.norm(apart, axis=-1),
        aligned_distances=np.linalg.norm(
            in_root_frame(one, a.positions) - in_root_frame(two, b.positions), axis=-1
        ),
        relative_distances=np.linalg.norm(apart - apart[:, :1], axis=-1),
        end_distances=np.linalg.norm(a.ends - b.ends, axis=-1),
    )


def lag(motion: Clip, reference: Clip, *, longest: float = 0.5) -> float | None:
    """Time by which the joints of `motion` follow those of `reference` [s]; positive is late.

    The delay with the least mean squared (chordal) rotation difference over all joints but the
    root, by a parabola through the best delay on the frame grid and its neighbors. The same frames
    of the motion are used for every delay.

    Returns:
        The lag, or None when there is no clear one: too little motion, or a best delay at the
        border of the search (`longest` or a quarter of the shared time).
    """
    shared = min(motion.duration, reference.duration)
    reach = int(np.floor(min(longest, 0.25 * shared) * motion.rate + 1e-9))
    frames = int(np.floor(shared * motion.rate + 1e-6)) + 1
    if reach < 2 or frames < 2 * reach + 3:
        return None
    turned, _ = sampled(reference, np.arange(frames) / motion.rate)
    inner = slice(reach, frames - reach)
    # Only joints that move can show a delay; still ones would add noise and cost.
    moving = 1 + np.flatnonzero(
        np.ptp(rot.to_matrix(turned[:, 1:]).reshape(frames, -1, 9), axis=0).max(axis=1) > 0.02
    )
    if not len(moving):
        return None
    mine = rot.to_matrix(motion.rotations[:frames][inner][:, moving])
    theirs = rot.to_matrix(turned[:, moving])
    count = frames - 2 * reach
    delays = np.arange(-reach, reach + 1)
    # trace(A^T B) = 1 + 2 cos(angle): its mean is largest where the chordal error is least. All
    # delays at once, as a product of spectra; no delay shifts the inner frames past the ends.
    size = 1 << (frames - 1).bit_length()
    spectra = (np.fft.rfft(each.reshape(len(each), -1), size, axis=0) for each in (mine, theirs))
    product = np.einsum("fc,fc->f", np.conj(next(spectra)), next(spectra))
    likeness = np.fft.irfft(product, size)[reach - delays] / (count * len(moving))
    best = int(np.argmax(likeness))
    if best in (0, len(delays) - 1):
        return None
    before, here, after = likeness[best - 1 : best + 2]
    curvature = 2.0 * here - before - after
    if curvature < 1e-12:
        return None
    return float((delays[best] + 0.5 * (after - before) / curvature) / motion.rate)
