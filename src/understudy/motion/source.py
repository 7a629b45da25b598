"""Bytes and text of a motion file, with every refusal in one line that names the file.

Comes in: a path. Goes out: bytes or text small enough to hold, or a `ClipError`.
"""

from __future__ import annotations

import os
import stat
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
    data = regular_bytes(path, what="motion file", most=MAX_BYTES)
    if data.isspace() or not data:
        raise ClipError(path, "is empty; export the motion again.")
    return plain(data)


def regular_bytes(path: str | os.PathLike[str], *, what: str, most: int) -> bytes:
    """The bytes of a file that is really one: a device or a pipe could go on forever.

    Args:
        path: The file.
        what: What it should be, for the messages.
        most: Bytes read at most.

    Raises:
        ClipError: No such file, a folder, a device or a pipe, not permitted, or larger.
    """
    try:
        check_regular(path, what=what)
        with Path(path).open("rb") as file:
            data = file.read(most + 1)
    except FileNotFoundError:
        raise ClipError(path, "no such file; check the name and the folder.") from None
    except (OSError, ValueError) as error:
        if isinstance(error, ClipError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise ClipError(path, f"cannot be read: {reason}.") from None
    if len(data) > most:
        size = Path(path).stat().st_size
        raise ClipError(
            path,
            f"has {max(size, most + 1) / 2**20:.0f} MiB; at most {most / 2**20:.0f} MiB are read, "
            "so split the file.",
        )
    return data


def check_regular(path: str | os.PathLike[str], *, what: str) -> None:
    """Refuse what is no file with an end.

    Raises:
        ClipError: A folder, a device or a pipe.
        OSError: No such file, or not permitted.
    """
    mode = Path(path).stat().st_mode
    if stat.S_ISDIR(mode):
        raise ClipError(path, f"is a folder; give the name of one {what}.")
    if not stat.S_ISREG(mode):
        raise ClipError(path, f"is a device or a pipe; give the name of one {what}.")


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
