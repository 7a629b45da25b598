"""Bytes and text of a motion file, with every refusal in one line that names the file.

Comes in: a path. Goes out: bytes or text small enough to hold, or a `ClipError`.
"""

from __future__ import annotations

import os
from pathlib import Path

from understudy.errors import ClipError

# A day of 100 channels at 120 Hz in text is about 8 GB; a clip for a simulation is far below this.
MAX_BYTES = 512 * 1024 * 1024
# Bodies with every finger, the face and cloth helpers stay below a few hundred joints.
MAX_JOINTS = 4096


def file_bytes(path: str | os.PathLike[str]) -> bytes:
    """The bytes of a file.

    Raises:
        ClipError: No such file, a folder, not permitted, empty, or larger than 512 MiB.
    """
    file = Path(path)
    try:
        if file.is_dir():
            raise ClipError(path, "is a folder; give the name of one motion file.")
        size = file.stat().st_size
        if size > MAX_BYTES:
            raise ClipError(
                path, f"has {size / 2**20:.0f} MiB; at most 512 MiB are read, so split the file."
            )
        data = file.read_bytes()
    except FileNotFoundError:
        raise ClipError(path, "no such file; check the name and the folder.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ClipError(path, f"cannot be read: {reason}.") from None
    if data.isspace() or not data:
        raise ClipError(path, "is empty; export the motion again.")
    return plain(data)


def plain(data: bytes) -> bytes:
    """The same text without a byte order mark, and in UTF-8 where the mark says UTF-16."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", errors="replace").encode()
    return data.removeprefix(b"\xef\xbb\xbf")


def decoded(data: bytes) -> str:
    """Text of bytes in UTF-8, or in Latin-1 where they are not."""
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1")


def quoted(word: str | bytes) -> str:
    """A word of a file for an error message: in quotes, printable and short."""
    text = decoded(word) if isinstance(word, bytes) else word
    return repr(text if len(text) <= 40 else text[:37] + "...")


def unique(names: list[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names made unique by a number, and a note for every name that changed."""
    taken = set(names)
    seen: set[str] = set()
    out: list[str] = []
    notes: list[str] = []
    counts: dict[str, int] = {}
    for name in names:
        fresh = name
        if name in seen:
            k = counts.get(name, 1)
            while fresh in taken or fresh in seen:
                k += 1
                fresh = f"{name}_{k}"
            counts[name] = k
            notes.append(f"A second joint named {name!r} is called {fresh!r} here.")
        seen.add(fresh)
        out.append(fresh)
    if len(notes) > 5:
        notes = [*notes[:4], f"{len(notes) - 4} more repeated joint names were numbered."]
    return tuple(out), tuple(notes)
