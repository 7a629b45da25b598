"""Reads Acclaim motion: an AMC file of joint values and the ASF file of its skeleton.

The skeleton file gives every bone a direction, a length and a rest axis C; a bone turns by
L = C M C^-1 against its parent, M being the rotation by its values (Jeff Lander, "Working with
Motion Capture File Formats", Game Developer, January 1998). A bone starts where its parent ends, so
it becomes a joint there, named after the bone.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from understudy.errors import ClipError
from understudy.motion import rotations as rot
from understudy.motion.asf import Bone, Figure, parsed_asf
from understudy.motion.clip import Clip
from understudy.motion.recording import Recording
from understudy.motion.rotations import Array
from understudy.motion.settle import checked_options, settled
from understudy.motion.skeleton import Skeleton
from understudy.motion.source import decoded, file_bytes, quoted
from understudy.motion.values import LARGEST

RATE = 120.0  # Hz; AMC files state no rate, and the CMU collection was taken at 120


def read_acclaim(
    path: str | os.PathLike[str],
    *,
    asf: str | os.PathLike[str] | None = None,
    up: str | None = None,
    unit: float | str | None = None,
    rate: float | None = None,
    t_pose: str = "auto",
) -> Clip:
    """An AMC file and its ASF skeleton as a clip in meters, z up.

    Joints are named after the bones; the root's joint is "root". AMC files state no rate: 120 Hz is
    taken unless `rate` is given.

    Args:
        path: The AMC file.
        asf: The skeleton file; None looks beside `path` for the same name, then for the part of
            the name before an underscore (02_01.amc: 02.asf), then for the only ASF file there.
        up, unit, rate, t_pose: As in `understudy.motion.bvh.read_bvh`.

    Raises:
        ClipError: A file cannot be read, or the two do not fit; names the line and the remedy.
        InvalidValue: An option that cannot be meant.
    """
    checked_options(up, rate, t_pose)
    if Path(path).suffix.lower() == ".asf":
        raise ClipError(
            path, "is only the skeleton; give the AMC file and pass this one as asf= (--asf)."
        )
    motion = file_bytes(path)
    beside = skeleton_file(path) if asf is None else Path(asf)
    figure = parsed_asf(file_bytes(beside), beside)
    recording = parsed_amc(motion, figure, path, rate=rate)
    return settled(recording, up=up, unit=unit, rate=rate, t_pose=t_pose)


def skeleton_file(path: str | os.PathLike[str]) -> Path:
    """The ASF file that belongs to an AMC file.

    Raises:
        ClipError: There is none, or several and none fits by name.
    """
    file = Path(path)
    try:
        found = [p for p in file.parent.iterdir() if p.suffix.lower() == ".asf"]
    except OSError:
        found = []
    stem = file.stem.lower()
    for name in (stem, stem.split("_")[0]):
        for candidate in sorted(found):
            if candidate.stem.lower() == name:
                return candidate
    if len(found) == 1:
        return found[0]
    listed = ", ".join(sorted(p.name for p in found)[:5]) or "none"
    raise ClipError(
        path,
        f"needs its skeleton, {stem.split('_')[0]}.asf, in the same folder (there: {listed}); "
        "or pass asf= (--asf).",
    )


@dataclass
class _Values:
    """Values of the bones over the frames, in order of the file."""

    frames: int = 0
    bones: dict[str, list[list[float]]] = field(default_factory=dict)


def parsed_amc(
    data: bytes, figure: Figure, path: str | os.PathLike[str], *, rate: float | None = None
) -> Recording:
    """The bytes of an AMC file as a recording in the axes and units of its skeleton file.

    Raises:
        ClipError: The bytes are no AMC file that can be read, or do not fit the skeleton.
    """
    text = decoded(data)
    values, radians = _frames(text, figure, path)
    scale = 1.0 if radians else np.pi / 180.0
    frames = values.frames
    bones = figure.bones
    rotations = rot.identity(frames, len(bones))
    root = np.tile(np.array(figure.position), (frames, 1))
    notes: list[str] = []
    if rate is None:
        notes.append(
            f"AMC files state no rate: {RATE:g} Hz assumed; pass rate= (--rate) for another."
        )
    for j, bone in enumerate(bones):
        rest = _turn(bone.order, np.array(bone.axis) * figure.radians)
        table = np.array(values.bones.get(bone.name, np.zeros((frames, 0))), float)
        if table.shape[1]:
            rotations[:, j] = _bone_turn(bone, table, scale, rest)
            if j == 0:
                root = root + _moves(bone, table)
            elif np.any(np.ptp(_moves(bone, table), axis=0) > 0.0):
                notes.append(f"Bone {bone.name!r} changes its length; that is left out.")
    # The pose of the root at rest comes on top of its motion.
    still = _turn(bones[0].order, np.array(figure.orientation) * figure.radians)
    rotations[:, 0] = rot.multiply(still, rotations[:, 0])
    offsets = np.array([bones[b.parent].vector if b.parent > 0 else (0.0,) * 3 for b in bones])
    offsets[0] = figure.position
    parents = {b.parent for b in bones}
    leaves = [j for j, b in enumerate(bones) if j not in parents and j > 0]
    return Recording(
        path=str(path),
        name=Path(path).stem,
        skeleton=Skeleton(
            names=tuple(b.name for b in bones),
            parents=tuple(b.parent for b in bones),
            offsets=offsets,
            end_joints=tuple(leaves),
            end_offsets=np.array([bones[j].vector for j in leaves]).reshape(-1, 3),
        ),
        rotations=rotations,
        root_positions=root,
        rate=RATE if rate is None else rate,
        channels=tuple("xyzZYX" if j == 0 else "ZYX" for j in range(len(bones))),
        stated_unit=figure.unit,
        notes=tuple(notes),
    )


def _turn(order: str, angles: Array) -> Array:
    """Rotation by angles [rad] listed in `order`, the first applied first (about fixed axes)."""
    return rot.from_euler(order[::-1], angles[..., ::-1])


def _bone_turn(bone: Bone, table: Array, scale: float, rest: Array) -> Array:
    """Local rotations of a bone from its values, in the axes of the file."""
    columns = [k for k, dof in enumerate(bone.dofs) if dof[0] == "r"]
    order = "".join(bone.dofs[k][1].upper() for k in columns)
    moved = _turn(order, table[:, columns] * scale)
    return rot.multiply(rest, rot.multiply(moved, rot.conjugate(rest)))


def _moves(bone: Bone, table: Array) -> Array:
    """Translations of a bone from its values, in file units, shape (frames, 3)."""
    out = np.zeros((len(table), 3))
    for k, dof in enumerate(bone.dofs):
        if dof[0] == "t":
            out[:, "xyz".index(dof[1])] = table[:, k]
        elif dof == "l":
            out[:, 0] = table[:, k]
    return out


def _frames(text: str, figure: Figure, path: str | os.PathLike[str]) -> tuple[_Values, bool]:
    """Values per bone and frame, and whether angles are radians."""
    widths = {bone.name: len(bone.dofs) for bone in figure.bones}
    out = _Values()
    radians = False
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            radians = radians or words[0].upper() == ":RADIANS"
        elif len(words) == 1 and words[0].isdecimal():
            _complete(out, path, number)
            out.frames += 1
        else:
            _bone_line(out, words, widths, path, number)
    if out.frames == 0:
        raise ClipError(path, "holds no frames; an AMC file numbers them on lines of their own.")
    _complete(out, path, None)
    return out, radians


def _bone_line(
    out: _Values,
    words: list[str],
    widths: dict[str, int],
    path: str | os.PathLike[str],
    number: int,
) -> None:
    """Take one line of a frame: a bone's name and its values."""
    name = words[0]
    width = widths.get(name)
    if out.frames == 0:
        raise ClipError(path, f"{quoted(name)} comes before the first frame number.", number)
    if width is None:
        raise ClipError(
            path, f"bone {quoted(name)} is not in the skeleton; pass the ASF that fits.", number
        )
    try:
        values = [float(word) for word in words[1:]]
    except ValueError as error:
        raise ClipError(path, f"bone {quoted(name)}: {error}; repair it.", number) from None
    if len(values) != width:
        raise ClipError(
            path,
            f"bone {quoted(name)} has {len(values)} values; the skeleton gives it {width}.",
            number,
        )
    if not all(abs(v) <= LARGEST for v in values):
        raise ClipError(
            path, f"bone {quoted(name)} has a value that is not finite or above 1e9.", number
        )
    rows = out.bones.setdefault(name, [])
    if len(rows) != out.frames - 1:
        raise ClipError(
            path,
            f"bone {quoted(name)} is listed {'twice' if len(rows) >= out.frames else 'late'}; "
            "every bone belongs once into every frame.",
            number,
        )
    rows.append(values)


def _complete(out: _Values, path: str | os.PathLike[str], number: int | None) -> None:
    """Refuse a frame that lacks a bone of the frames before it."""
    for name, rows in out.bones.items():
        if len(rows) != out.frames:
            raise ClipError(
                path,
                f"frame {out.frames} lacks bone {quoted(name)}; only fully specified motion is "
                "read.",
                number,
            )
