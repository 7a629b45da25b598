"""Reads BVH files of any dialect.

One grammar serves every exporter: channels in any order and number on any joint, any line ends and
line breaks, names with blanks and colons, joints without end sites. What a file contains decides;
there is no code per exporter.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from understudy.errors import ClipError
from understudy.motion import rotations as rot
from understudy.motion.bvh_hierarchy import Hierarchy, Scanner
from understudy.motion.bvh_writer import write_bvh
from understudy.motion.clip import Clip
from understudy.motion.recording import Recording
from understudy.motion.rotations import Array
from understudy.motion.settle import checked_options, settled
from understudy.motion.skeleton import Skeleton
from understudy.motion.source import decoded, file_bytes, quoted, unique
from understudy.motion.values import line_of, numbers

__all__ = ["parsed", "read_bvh", "write_bvh"]


_MOTION = (
    re.compile(rb"\}\s*(MOTION)(?!\S)", re.IGNORECASE),
    re.compile(rb"^[ \t]*(MOTION)[ \t]*[\r\n]", re.IGNORECASE | re.MULTILINE),
)
_COUNT = re.compile(rb"\s*Frames[ \t]*:?[ \t]*([^\s:]+)", re.IGNORECASE)
_TIME = re.compile(rb"\s*Frame[ \t]*Time[ \t]*:?[ \t]*([^\s:]+)", re.IGNORECASE)
# Rates that a rounded frame time is meant to state.
_RATES = (24, 25, 30, 48, 50, 60, 72, 75, 90, 96, 100, 120, 144, 150, 180, 200, 240, 250, 300, 480)


def read_bvh(
    path: str | os.PathLike[str],
    *,
    up: str | None = None,
    unit: float | str | None = None,
    rate: float | None = None,
    t_pose: str = "auto",
) -> Clip:
    """A BVH file as a clip in meters, z up.

    Root position channels are absolute and replace the root's OFFSET. Position channels of another
    joint replace its OFFSET with their mean (a note gives the largest deviation), unless they are
    all zero. A root with one child that travels is folded into that child. A frame count that
    disagrees with whole rows of values is corrected with a note.

    Args:
        path: The file.
        up: Vertical axis of the file, "x", "y" or "z"; None detects it.
        unit: Meters per file unit, or "m", "cm", "mm", "inch", "ft", "cmu"; None detects it.
        rate: Frames per second [Hz]; None takes the file's.
        t_pose: "auto" drops a T-pose before the motion, "keep" keeps it, "drop" drops frame 0.

    Raises:
        ClipError: The file cannot be read; names the line, the value and the remedy.
        InvalidValue: An option that cannot be meant.
    """
    checked_options(up, rate, t_pose)
    recording = parsed(file_bytes(path), path, rate=rate)
    return settled(recording, up=up, unit=unit, rate=rate, t_pose=t_pose)


def parsed(data: bytes, path: str | os.PathLike[str], *, rate: float | None = None) -> Recording:
    """The bytes of a BVH file as a recording in the file's axes and units.

    Raises:
        ClipError: The bytes are no BVH file that can be read.
    """
    motion = next((m for m in (p.search(data) for p in _MOTION) if m), None)
    header = decoded(data if motion is None else data[: motion.start(1)])
    hierarchy = Scanner(header, path).hierarchy()
    if motion is None:
        raise ClipError(path, "has no MOTION section; export the motion, not only the skeleton.")
    table, stated_rate, notes = _motion(data, motion.end(1), hierarchy, path, rate)
    names, name_notes = unique([joint.name for joint in hierarchy.joints])
    return _recording(hierarchy, names, table, stated_rate, [*name_notes, *notes], path)


def _motion(
    data: bytes,
    start: int,
    hierarchy: Hierarchy,
    path: str | os.PathLike[str],
    rate: float | None,
) -> tuple[Array, float, list[str]]:
    """The motion section as a table (frames, channels), the rate [Hz], and notes."""
    stated: dict[str, tuple[bytes, int]] = {}
    for _ in range(2):
        for kind, pattern in (("time", _TIME), ("count", _COUNT)):
            match = pattern.match(data, start)
            if match and kind not in stated:
                stated[kind] = match.group(1), match.start(1)
                start = match.end()
    notes: list[str] = []
    hertz = _rate(stated.get("time"), data, path, rate, notes)
    channels = hierarchy.channels
    if channels == 0:
        raise ClipError(path, "declares no channels, so it holds no motion.")
    values = numbers(data, start, path)
    if len(values) == 0:
        raise ClipError(path, "holds no frames; export the motion again.")
    if len(values) % channels:
        raise _misfit(data, start, channels, len(values), path)
    table = values.reshape(-1, channels)
    if "count" in stated:
        word, place = stated["count"]
        try:
            count = int(word)
        except ValueError:
            raise ClipError(
                path, f"Frames: {quoted(word)} is not a whole number.", line_of(data, place)
            ) from None
        if count != len(table):
            notes.append(
                f"The header says {count:.6g} frames and {len(table)} are present; "
                "all of them are read."
            )
    return table, hertz, notes


def _rate(
    stated: tuple[bytes, int] | None,
    data: bytes,
    path: str | os.PathLike[str],
    rate: float | None,
    notes: list[str],
) -> float:
    """Frames per second from the frame time, or `rate` where it is given."""
    if rate is not None:
        return float(rate)
    if stated is None:
        raise ClipError(path, "has no Frame Time; pass rate= in frames per second.")
    word, place = stated
    try:
        time = float(word)
    except ValueError:
        time = np.nan
    if not 1e-5 <= time <= 100.0:
        raise ClipError(
            path,
            f"Frame Time {quoted(word)} must be a number of seconds; pass rate= to overrule it.",
            line_of(data, place),
        )
    if time >= 1.0:
        notes.append(f"Frame Time says {time:g} s a frame; if it is a rate, pass rate={time:g}.")
    # 0.0083333 states 1/120 s in seven digits: the rate that rounds to the same digits is meant.
    digits = len(word.partition(b".")[2])
    for nominal in _RATES:
        if abs(time * nominal - 1.0) < 2e-4 and f"{1 / nominal:.{digits}f}" == f"{time:.{digits}f}":
            return float(nominal)
    return 1.0 / time


def _misfit(
    data: bytes, start: int, channels: int, values: int, path: str | os.PathLike[str]
) -> ClipError:
    """The error for values that do not fill whole frames: names the first odd row if there is."""
    frame = 0
    for match in re.finditer(rb"[^\r\n]+", data[start:]):
        count = len(match.group().split())
        if count == 0:
            continue
        if count != channels:
            return ClipError(
                path,
                f"frame {frame} has {count} values; the hierarchy declares {channels} channels.",
                line_of(data, start + match.start()),
            )
        frame += 1
    return ClipError(
        path, f"{values} motion values are no whole number of frames of {channels} channels."
    )


def _recording(
    hierarchy: Hierarchy,
    names: tuple[str, ...],
    table: Array,
    rate: float,
    notes: list[str],
    path: str | os.PathLike[str],
) -> Recording:
    """Rotations, offsets and root path from the channel table."""
    joints = hierarchy.joints
    channels = tuple(joint.channels or "" for joint in joints)
    offsets = np.array([joint.offset for joint in joints])
    starts = np.concatenate(([0], np.cumsum([len(c) for c in channels])))[:-1]
    rotations = rot.identity(len(table), len(joints))
    columns: dict[str, list[tuple[int, list[int]]]] = {}
    for j, letters in enumerate(channels):
        order = "".join(c for c in letters if c.isupper())
        columns.setdefault(order, []).append(
            (j, [int(starts[j]) + k for k, c in enumerate(letters) if c.isupper()])
        )
    for order, members in columns.items():
        if order:
            angles = np.radians(table[:, np.array([c for _, c in members])])
            rotations[:, [j for j, _ in members]] = rot.from_euler(order, angles)
    root = np.tile(offsets[0], (len(table), 1))
    moving: dict[int, Array] = {}
    for j, letters in enumerate(channels):
        placed = [(k, "xyz".index(c)) for k, c in enumerate(letters) if c in "xyz"]
        if not placed:
            continue
        values = np.tile(offsets[j], (len(table), 1))
        for k, axis in placed:
            values[:, axis] = table[:, starts[j] + k]
        if j == 0:
            root = values
        elif np.any(table[:, [int(starts[j]) + k for k, _ in placed]]):
            moving[j] = values
    tree = [joint.parent for joint in joints]
    fold = _folded(tree, moving, root, rotations)
    ends = hierarchy.ends
    if fold is not None:
        root, rotations = fold
        notes = [*notes, f"The root {names[0]!r} only carries {names[1]!r}: both became one root."]
        moving.pop(1)
        moving = {j - 1: values for j, values in moving.items()}
        names, channels, offsets = names[1:], channels[1:], offsets[1:]
        tree = [p - 1 for p in tree[1:]]
        ends = [(j - 1, offset) for j, offset in ends if j > 0]
    for j, values in moving.items():
        offsets[j] = values.mean(axis=0)
        spread = float(np.linalg.norm(values - offsets[j], axis=1).max())
        if spread > 1e-4 * max(float(np.abs(offsets).max()), 1e-12):
            notes = [
                *notes,
                f"Joint {names[j]!r} moves against its parent by up to {spread:.4g} file units; "
                "its mean place is kept.",
            ]
    return Recording(
        path=str(path),
        name=Path(path).stem,
        skeleton=Skeleton(
            names=names,
            parents=tuple(tree),
            offsets=offsets,
            end_joints=tuple(j for j, _ in ends),
            end_offsets=np.array([offset for _, offset in ends]).reshape(-1, 3),
        ),
        rotations=rotations,
        root_positions=root,
        rate=rate,
        channels=channels,
        notes=tuple(notes),
    )


def _folded(
    parents: list[int], moving: dict[int, Array], root: Array, rotations: Array
) -> tuple[Array, Array] | None:
    """World path and rotations with the root's only child as the root, where that child travels.

    Several exporters put the hips under a node that stands still at the origin.
    """
    if 1 not in moving or parents.count(0) != 1:
        return None
    travel = float(np.ptp(moving[1], axis=0).max())
    if travel <= 1e-3 * max(float(np.abs(moving[1]).max()), 1e-12):
        return None
    path = root + rot.rotate(rotations[:, 0], moving[1])
    turned = rotations[:, 1:].copy()
    turned[:, 0] = rot.multiply(rotations[:, 0], rotations[:, 1])
    return path, turned
