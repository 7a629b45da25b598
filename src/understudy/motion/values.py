"""Numbers in the text of a motion file, fast and strict."""

from __future__ import annotations

import os
import re
import warnings

import numpy as np

from understudy.errors import ClipError
from understudy.motion.rotations import Array
from understudy.motion.source import quoted

# Beyond this a coordinate or an angle is a broken file in every unit there is.
LARGEST = 1e9


def numbers(data: bytes, start: int, path: str | os.PathLike[str]) -> Array:
    """All numbers of a text from a place on, in one row; a bad word raises with its line.

    Raises:
        ClipError: A word is no number, is not finite or is absurdly large.
    """
    parts: list[Array] = []
    size = 1 << 20  # parsed in pieces, so that the text is never copied whole
    while start < len(data):
        stop = data.find(b"\n", start + size) + 1 or len(data)
        values = _piece(data[start:stop])
        # A NaN fails the comparison too.
        if values is None or not np.abs(values).max(initial=0.0) <= LARGEST:
            raise _bad_number(data, start, stop, path)
        parts.append(values)
        start = stop
    return np.concatenate(parts) if parts else np.zeros(0)


def _piece(text: bytes) -> Array | None:
    """The numbers of a piece of text, or None where a word is no number.

    Even rows go to NumPy's table reader, which is a third faster than its reader of free text.
    """
    if not text or text.isspace():
        return np.zeros(0)
    try:
        lines = text.decode("ascii").splitlines()
        return np.loadtxt(lines, comments=None, ndmin=2).reshape(-1)
    except ValueError:
        pass
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, sep=" ")
        except (ValueError, DeprecationWarning):
            return None


def line_of(data: bytes, place: int) -> int:
    """Number of the line at a place in a file, from 1."""
    return max(data.count(b"\n", 0, place), data.count(b"\r", 0, place)) + 1


def _bad_number(data: bytes, start: int, stop: int, path: str | os.PathLike[str]) -> ClipError:
    """The error for the first word between two places that is no usable number."""
    for match in re.finditer(rb"\S+", data[start:stop]):
        try:
            good = abs(float(match.group())) <= LARGEST
        except ValueError:
            good = False
        if not good:
            return ClipError(
                path,
                f"{quoted(match.group())} is not a usable number; repair or remove that frame.",
                line_of(data, start + match.start()),
            )
    return ClipError(path, "holds motion values that are no numbers.", line_of(data, start))
