"""The step that settles a `Recording` into SI units with z up.

What a file does not state (vertical axis, unit, whether the first frame is motion, a wrong rate) is
detected by `understudy.motion.detection`; every finding becomes a note of the clip, and every one
can be overruled by an argument.
"""

from __future__ import annotations

import numpy as np

from understudy.errors import ClipError, InvalidValue
from understudy.motion import detection
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip, Conventions, check_rate
from understudy.motion.recording import Recording, unit_in_meters
from understudy.motion.rotations import Array
from understudy.motion.skeleton import Skeleton

# With fewer frames there is no acceleration to speak of, so nothing to judge.
FEW_FRAMES = 4
USUAL_RATES = (5.0, 1000.0)


def checked_options(up: str | None, rate: float | None, t_pose: str) -> None:
    """Refuse options of a reader that cannot be meant.

    Raises:
        InvalidValue: Names the option, its value and what is allowed.
    """
    if up not in (None, "x", "y", "z"):
        raise InvalidValue(f"up is {up!r}; it must be 'x', 'y', 'z' or None to detect it.")
    if rate is not None:
        check_rate(rate, "rate (--rate)")
    if t_pose not in ("auto", "keep", "drop"):
        raise InvalidValue(f"t_pose is {t_pose!r}; it must be 'auto', 'keep' or 'drop'.")


def doubts(frames: int, rate: float) -> list[str]:
    """Warnings about what was hardly captured so: too few frames, or an unlikely rate [Hz]."""
    notes = []
    if frames < FEW_FRAMES:
        count = "one frame" if frames == 1 else f"{frames} frames"
        notes.append(f"Has only {count}: too short to judge how well a body performs it.")
    low, high = USUAL_RATES
    if not low <= rate <= high:
        notes.append(
            f"{rate:g} frames per second is hardly a rate of capture ({low:g} to {high:g}); pass "
            "rate= (--rate) if the file is wrong."
        )
    return notes


def settled(
    recording: Recording,
    *,
    up: str | None = None,
    unit: float | str | None = None,
    rate: float | None = None,
    t_pose: str = "auto",
) -> Clip:
    """The recording as a clip in meters with z up; see `understudy.motion.read.read`.

    Raises:
        ClipError: The recording cannot be a clip, for example all its bones have no length.
        InvalidValue: An option that cannot be meant.
    """
    checked_options(up, rate, t_pose)
    notes = list(recording.notes)
    try:
        shape = detection.shape_of(recording)
    except InvalidValue as error:
        raise ClipError(recording.path, str(error)) from None
    if up is None:
        up, note = detection.up_axis(shape)
        notes.append(note)
    if unit is not None:
        meters = unit_in_meters(unit)
    else:
        meters, note = detection.unit(shape, up, recording.stated_unit)
        notes.append(note)
    hertz = recording.rate if rate is None else float(rate)
    first, note = detection.first_motion_frame(recording, hertz, t_pose)
    if note:
        notes.append(note)
    conventions = Conventions(
        up=up,
        unit=meters,
        rotation_orders=tuple(
            "".join(c for c in channels if c.isupper()) for channels in recording.channels
        ),
        channels=recording.channels,
    )
    try:
        skeleton, rotations, path = _converted(recording.kept(slice(first, None)), conventions)
        lift, more = detection.lift_from_zero(skeleton, rotations, path)
        notes += more
        notes += detection.rate_notes(skeleton, rotations, path, hertz)
        notes += doubts(len(rotations), hertz)
        if not (skeleton.offsets[1:].any() or skeleton.end_offsets.any()):
            notes.append("No bone has a length: only turns and the root's path can be followed.")
        return Clip(
            skeleton=skeleton,
            rotations=rotations,
            root_positions=path + lift,
            rate=hertz,
            name=recording.name,
            notes=tuple(notes),
            conventions=conventions,
        )
    except InvalidValue as error:
        raise ClipError(recording.path, str(error)) from None


def _converted(recording: Recording, conventions: Conventions) -> tuple[Skeleton, Array, Array]:
    """Skeleton, rotations and root path, turned to z up and scaled to meters."""
    # The change of axes permutes coordinates; whole numbers keep it exact.
    turn = np.round(rot.to_matrix(conventions.axis_change))
    unit = conventions.unit
    rotations = np.empty_like(recording.rotations)
    rotations[..., 0] = recording.rotations[..., 0]
    for axis, row in enumerate(turn):
        source = int(np.argmax(np.abs(row)))
        np.multiply(recording.rotations[..., 1 + source], row[source], out=rotations[..., 1 + axis])
    skeleton = recording.skeleton
    return (
        Skeleton(
            names=skeleton.names,
            parents=skeleton.parents,
            offsets=skeleton.offsets @ turn.T * unit,
            end_joints=skeleton.end_joints,
            end_offsets=skeleton.end_offsets @ turn.T * unit,
        ),
        rotations,
        recording.root_positions @ turn.T * unit,
    )
