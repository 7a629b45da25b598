"""Reads BVH files of any dialect.

One grammar serves every exporter: channels in any order and number on any joint, any line ends and
line breaks, names with blanks and colons, joints without end sites. What a file contains decides;
there is no code per exporter.
"""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Callable
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
        raise ClipError(path, "has no Frame Time; pass rate= (--rate) in frames per second.")
    word, place = stated
    try:
        time = float(word)
    except ValueError:
        time = np.nan
    if not 1e-5 <= time <= 100.0:
        raise ClipError(
            path,
            f"Frame Time {quoted(word)} must be a number of seconds; pass rate= (--rate) to "
            "overrule it.",
            line_of(data, place),
        )
    if time >= 1.0:
        notes.append(
            f"Frame Time says {time:g} s a frame; if it is a rate, pass rate={time:g} (--rate)."
        )
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
    parents = [joint.parent for joint in joints]
    ends = hierarchy.ends
    starts = [0, *itertools.accumulate(len(letters) for letters in channels)]
    rotations = rotations_of(table, channels, starts)
    root, moving = _positions(table, channels, starts, offsets)
    if _carries(parents, moving):
        # Several exporters put the hips under a node that stands still at the origin.
        notes = [*notes, f"The root {names[0]!r} only carries {names[1]!r}: both became one root."]
        root = root + rot.rotate(rotations[:, 0], moving.pop(1))
        hips = rot.multiply(rotations[:, 0], rotations[:, 1])
        rotations = np.concatenate((hips[:, None], rotations[:, 2:]), axis=1)
        moving = {j - 1: values for j, values in moving.items()}
        names, channels, offsets = names[1:], channels[1:], offsets[1:]
        parents = [-1, *(p - 1 for p in parents[2:])]
        ends = [(j - 1, offset) for j, offset in ends if j > 0]
    for j, values in moving.items():
        middle = values.mean(axis=0)
        size = max(float(np.abs(offsets).max()), 1e-12)
        spread = float(np.linalg.norm(values - middle, axis=1).max())
        # Some exporters list the change against OFFSET instead of the place itself.
        near = np.linalg.norm(middle) < 0.05 * np.linalg.norm(offsets[j])
        change = near and spread > 1e-4 * size
        offsets[j] = offsets[j] + middle if change else middle
        if spread > 1e-4 * size:
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
            parents=tuple(parents),
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


def rotations_of(table: Array, channels: tuple[str, ...], starts: list[int]) -> Array:
    """Local rotations from the rotation channels, in degrees, shape (frames, joints, 4)."""
    out = rot.identity(len(table), len(channels))
    members: dict[str, list[int]] = {}
    for j, letters in enumerate(channels):
        members.setdefault("".join(c for c in letters if c.isupper()), []).append(j)
    members.pop("", None)
    columns = {
        order: np.array([_columns(channels[j], starts[j], str.isupper) for j in joints])
        for order, joints in members.items()
    }
    # Blocks of rows stay in the processor's cache: twice as fast as whole columns.
    for first in range(0, len(table), 256):
        rows = slice(first, first + 256)
        half = table[rows] * (np.pi / 360.0)
        sines, cosines = np.sin(half), np.cos(half)
        for order, joints in members.items():
            if len(set(order)) == 3:
                at = columns[order]
                out[rows, joints] = _three_turns(order, sines[:, at], cosines[:, at])
            else:
                out[rows, joints] = rot.from_euler(order, 2.0 * half[:, columns[order]])
    return out


def _three_turns(order: str, sines: Array, cosines: Array) -> Array:
    """Quaternions of turns about three different axes, from sines and cosines of half angles."""
    s1, s2, s3 = (sines[..., k] for k in range(3))
    c1, c2, c3 = (cosines[..., k] for k in range(3))
    a, b, c = (1 + "XYZ".index(axis) for axis in order)
    sign = 1.0 if (b - a) % 3 == 1 else -1.0
    s3_signed = sign * s3
    cc, ss, sc, cs = c1 * c2, s1 * s2, s1 * c2, c1 * s2
    out = np.empty((*s1.shape, 4))
    out[..., 0] = cc * c3 - ss * s3_signed
    out[..., a] = sc * c3 + cs * s3_signed
    out[..., b] = cs * c3 - sc * s3_signed
    out[..., c] = cc * s3 + sign * ss * c3
    return out


def _columns(letters: str, start: int, kind: Callable[[str], bool]) -> list[int]:
    """Columns of the table under those channels of a joint that are of a kind."""
    return [start + k for k, letter in enumerate(letters) if kind(letter)]


def _positions(
    table: Array, channels: tuple[str, ...], starts: list[int], offsets: Array
) -> tuple[Array, dict[int, Array]]:
    """The root's path, and the places against their parents of joints that state them."""
    root = np.tile(offsets[0], (len(table), 1))
    moving: dict[int, Array] = {}
    for j, letters in enumerate(channels):
        columns = _columns(letters, starts[j], str.islower)
        if not columns:
            continue
        values = np.tile(offsets[j], (len(table), 1))
        values[:, ["xyz".index(c) for c in letters if c.islower()]] = table[:, columns]
        if j == 0:
            root = values
        elif np.any(table[:, columns]):
            moving[j] = values
    return root, moving


def _carries(parents: list[int], moving: dict[int, Array]) -> bool:
    """Whether the root has one child only and that child travels."""
    if 1 not in moving or parents.count(0) != 1:
        return False
    travel = float(np.ptp(moving[1], axis=0).max())
    return travel > 1e-3 * max(float(np.abs(moving[1]).max()), 1e-12)
