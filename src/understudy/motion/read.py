"""Reads a motion clip of any supported format."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from understudy.errors import ClipError, InvalidValue
from understudy.motion import amass, npz, orientations
from understudy.motion.acclaim import read_acclaim
from understudy.motion.bvh import read_bvh
from understudy.motion.clip import Clip
from understudy.motion.settle import checked_options, doubts
from understudy.motion.source import decoded, file_bytes

SUPPORTED = (
    "BVH (.bvh), Acclaim (.amc with .asf), AMASS or this package's own npz (.npz), "
    "segment orientations (.csv)"
)


def read(
    path: str | os.PathLike[str],
    *,
    up: str | None = None,
    unit: float | str | None = None,
    rate: float | None = None,
    t_pose: str = "auto",
    asf: str | os.PathLike[str] | None = None,
) -> Clip:
    """A motion clip in meters with z up, from a file of any supported format.

    The extension decides, and the content where the extension is another: BVH, Acclaim AMC with its
    ASF, npz in the layout of AMASS or of `understudy.motion.npz`, and tables of segment
    orientations (`understudy.motion.orientations`). What was detected or changed is in
    `Clip.notes`, a sentence each, and can be overruled here.

    Args:
        path: The file.
        up: The file's vertical axis, "x", "y" or "z"; None detects it.
        unit: Meters per file unit, or "m", "cm", "mm", "inch", "ft", "cmu"; None detects it.
        rate: Frames per second [Hz]; None takes the file's.
        t_pose: "auto" drops a T-pose before the motion, "keep" keeps it, "drop" drops frame 0.
        asf: Skeleton file of an AMC file; None looks beside it.

    Raises:
        ClipError: The file cannot be read; one line with file, line, value and remedy.
        InvalidValue: An option that cannot be meant.
    """
    if not isinstance(path, str | os.PathLike):
        raise InvalidValue(f"path is {path!r:.40}; it must be the name of a motion file.")
    checked_options(up, rate, t_pose)
    kind = _kind(path)
    if asf is not None and kind != "acclaim":
        raise InvalidValue(f"asf (--asf) is the skeleton of an AMC file, and {path} is none.")
    if kind == "bvh":
        return read_bvh(path, up=up, unit=unit, rate=rate, t_pose=t_pose)
    if kind == "acclaim":
        return read_acclaim(path, asf=asf, up=up, unit=unit, rate=rate, t_pose=t_pose)
    if kind == "orientations":
        return _doubted(orientations.read_orientations(path, up=up, unit=unit, rate=rate))
    data = file_bytes(path)
    if npz.is_clip(data):
        clip = npz.clip_of(npz.arrays_of(data, path), path)
        return clip if rate is None else replace(clip, rate=rate)
    arrays = npz.arrays_of(data, path, amass.ARRAYS)
    return _doubted(amass.clip_of_amass(arrays, path, up=up, rate=rate))


def _doubted(clip: Clip) -> Clip:
    return clip.noted(*doubts(clip.frames, clip.rate))


def _kind(path: str | os.PathLike[str]) -> str:
    """The format of a file: by its extension, else by how its text begins."""
    known = {
        ".bvh": "bvh",
        ".amc": "acclaim",
        ".asf": "acclaim",
        ".npz": "npz",
        ".csv": "orientations",
        ".tsv": "orientations",
    }
    suffix = Path(path).suffix.lower()
    if suffix in known:
        return known[suffix]
    data = file_bytes(path)
    if data.startswith(b"PK"):
        return "npz"
    start = decoded(data[:65536])
    if start.lstrip()[:9].upper() == "HIERARCHY":
        return "bvh"
    if ":FULLY-SPECIFIED" in start.upper() or ":DEGREES" in start.upper():
        return "acclaim"
    if orientations.is_orientations(start):
        return "orientations"
    raise ClipError(path, f"is of no format that is read; supported are {SUPPORTED}.")
