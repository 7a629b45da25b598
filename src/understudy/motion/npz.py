"""Reads and writes clips as npz: exact, fast, and never by pickle.

`arrays_of` opens any npz file without trusting it: sizes are checked against the bytes that are
there before anything is allocated, and headers are matched, not evaluated.
"""

from __future__ import annotations

import io
import math
import os
import re
import zipfile
import zlib
from collections.abc import Iterable
from typing import Any

import numpy as np

from understudy.errors import ClipError, InvalidValue
from understudy.motion.clip import Clip, Conventions
from understudy.motion.files import written
from understudy.motion.skeleton import Skeleton
from understudy.motion.source import MAX_JOINTS, file_bytes, quoted
from understudy.motion.values import LARGEST

FORMAT = "understudy clip 1"
# All arrays of a file together; an hour of a body of 31 joints at 120 Hz takes 430 MiB.
MAX_CONTENT = 512 * 1024 * 1024
# Motion shrinks tenfold at best when packed; a file that grows far more was made to fill memory.
MAX_GROWTH = 100
_HEADER = re.compile(
    r"\{\s*'descr':\s*'([<>|=]?)([a-zA-Z])(\d{1,6})',\s*'fortran_order':\s*(True|False),"
    r"\s*'shape':\s*\(([\d,\s]{0,200})\),?\s*\}\s*"
)
_KINDS = "fiubUS"


def arrays_of(
    data: bytes, path: str | os.PathLike[str], wanted: Iterable[str] | None = None
) -> dict[str, np.ndarray[Any, Any]]:
    """Arrays of an npz file by name, only those `wanted` (None: all).

    Raises:
        ClipError: The file is damaged, holds Python objects, or states sizes that are not there.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {
                info.filename.removesuffix(".npy"): info
                for info in archive.infolist()
                if info.filename.endswith(".npy")
            }
            names = [n for n in members if wanted is None or n in set(wanted)]
            total = sum(members[name].file_size for name in names)
            if total > MAX_CONTENT:
                raise ClipError(
                    path, f"holds {total / 2**20:.0f} MiB of arrays; at most 512 MiB are read."
                )
            if total > max(2**26, MAX_GROWTH * len(data)):
                raise ClipError(path, "unpacks to more than 100 times its size; it is no motion.")
            return {name: _array(_content(archive, members[name]), name, path) for name in names}
    except (
        zipfile.BadZipFile,
        zlib.error,
        EOFError,
        OSError,
        NotImplementedError,
        RuntimeError,
        ValueError,
        IndexError,
        KeyError,
    ) as error:
        raise ClipError(path, f"is a damaged npz file: {_short(error)}.") from None


def _short(error: Exception) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:80].rstrip(".")


def _content(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> bytes:
    """The bytes of a member: never more than its directory entry says."""
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{quoted(info.filename)} is packed in a way NumPy does not write")
    with archive.open(info) as member:
        return member.read(info.file_size + 1)


def _array(data: bytes, name: str, path: str | os.PathLike[str]) -> np.ndarray[Any, Any]:
    """One npy member; its header must agree with the bytes that follow it."""
    if data[:6] != b"\x93NUMPY" or len(data) < 12:
        raise ClipError(path, f"{quoted(name)} is no NumPy array.")
    wide = data[6] > 1
    size = int.from_bytes(data[8:12] if wide else data[8:10], "little")
    start = (12 if wide else 10) + size
    header = data[12 if wide else 10 : min(start, 4096)].decode("latin-1")
    if "'O'" in header or "|O" in header:
        raise ClipError(path, f"{quoted(name)} holds Python objects, which are never read.")
    match = _HEADER.fullmatch(header)
    if match is None or match[2] not in _KINDS:
        raise ClipError(path, f"{quoted(name)} is of a type that is not read; save plain numbers.")
    order, kind, width, fortran, lengths = match.groups()
    shape = tuple(int(n) for n in lengths.replace(",", " ").split())
    try:
        dtype = np.dtype(f"{order}{kind}{width}")
    except TypeError:
        raise ClipError(path, f"{quoted(name)} has the unknown type {kind}{width}.") from None
    count = math.prod(shape)
    if len(shape) > 8 or count * dtype.itemsize != len(data) - start:
        raise ClipError(
            path,
            f"{quoted(name)} states the shape {quoted(str(shape))}, which does not fit its "
            f"{max(len(data) - start, 0)} bytes.",
        )
    if kind == "U" and count:
        codes = np.frombuffer(data, np.dtype(f"{order}u4"), offset=start)
        if codes.max(initial=0) > 0x10FFFF or np.any((codes >= 0xD800) & (codes < 0xE000)):
            raise ClipError(path, f"{quoted(name)} holds text that is no Unicode.")
    array = np.frombuffer(data, dtype, count, start) if count else np.zeros(0, dtype)
    return array.reshape(shape, order="F" if fortran == "True" else "C")


def write_npz(clip: Clip, path: str | os.PathLike[str]) -> None:
    """Write a clip as npz; `read_npz` gives back an equal clip, bit for bit.

    Raises:
        UnderstudyError: The file cannot be written.
    """
    skeleton, dialect = clip.skeleton, clip.conventions
    arrays: dict[str, Any] = {
        "format": np.array(FORMAT),
        "name": np.array(clip.name),
        "names": _texts(skeleton.names),
        "parents": np.array(skeleton.parents),
        "offsets": skeleton.offsets,
        "end_joints": np.array(skeleton.end_joints, dtype=int),
        "end_offsets": skeleton.end_offsets,
        "rotations": clip.rotations,
        "root_positions": clip.root_positions,
        "rate": np.array(clip.rate),
        "synthetic": np.array(clip.synthetic),
        "notes": _texts(clip.notes),
        "up": np.array(dialect.up),
        "unit": np.array(dialect.unit),
        "rotation_orders": _texts(dialect.rotation_orders),
        "channels": _texts(dialect.channels),
    }
    with written(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def _texts(texts: tuple[str, ...]) -> np.ndarray[Any, Any]:
    return np.array(texts, dtype=str) if texts else np.zeros(0, "U1")


def is_clip(data: bytes) -> bool:
    """Whether the bytes of an npz file look like a clip that `write_npz` wrote."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return "format.npy" in archive.namelist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError, IndexError):
        return False


def read_npz(path: str | os.PathLike[str]) -> Clip:
    """A clip that `write_npz` wrote.

    Raises:
        ClipError: The file is damaged or of another kind.
    """
    return clip_of(arrays_of(file_bytes(path), path), path)


def clip_of(arrays: dict[str, np.ndarray[Any, Any]], path: str | os.PathLike[str]) -> Clip:
    """The clip whose arrays were read from a file.

    Raises:
        ClipError: An array is missing or does not fit the others.
    """
    if "format" not in arrays or str(arrays["format"]) != FORMAT:
        raise ClipError(path, f"is no clip of this package; its 'format' is not {FORMAT!r}.")

    def one(name: str) -> Any:
        if arrays[name].size != 1:
            raise InvalidValue(f"{name!r} has {arrays[name].size} values instead of one")
        return arrays[name].reshape(-1)[0]

    def numbers(name: str) -> np.ndarray[Any, Any]:
        if arrays[name].dtype.kind not in "fiu" or not np.all(np.abs(arrays[name]) <= LARGEST):
            raise InvalidValue(f"{name!r} has values that are no numbers, or above 1e9")
        return arrays[name]

    def texts(name: str) -> tuple[str, ...]:
        if arrays[name].dtype.kind != "U" or arrays[name].ndim != 1:
            raise InvalidValue(f"{name!r} is no list of texts")
        return tuple(str(text) for text in arrays[name])

    def whole(name: str) -> tuple[int, ...]:
        if arrays[name].dtype.kind not in "iu" or arrays[name].ndim != 1:
            raise InvalidValue(f"{name!r} is no list of whole numbers")
        return tuple(int(n) for n in arrays[name])

    try:
        if arrays["names"].size > MAX_JOINTS:
            raise InvalidValue(f"more than {MAX_JOINTS} joints")
        return Clip(
            skeleton=Skeleton(
                names=texts("names"),
                parents=whole("parents"),
                offsets=numbers("offsets"),
                end_joints=whole("end_joints"),
                end_offsets=numbers("end_offsets"),
            ),
            rotations=numbers("rotations"),
            root_positions=numbers("root_positions"),
            rate=float(one("rate")),
            name=str(one("name")),
            synthetic=bool(one("synthetic")),
            notes=texts("notes"),
            conventions=Conventions(
                up=str(one("up")),
                unit=float(one("unit")),
                rotation_orders=texts("rotation_orders"),
                channels=texts("channels"),
            ),
        )
    except KeyError as error:
        raise ClipError(path, f"lacks the array {error}; write the clip again.") from None
    except (InvalidValue, ValueError, TypeError) as error:
        raise ClipError(path, f"is no whole clip: {_short(error)}.") from None
