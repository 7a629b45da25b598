"""PNG files without an imaging library: 8-bit RGB and text fields."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from os import PathLike

import numpy as np

from understudy.motion.files import written


def encoded(pixels: np.ndarray, text: Mapping[str, str] | None = None) -> bytes:
    """A PNG file's bytes for RGB pixels, uint8, shape (height, width, 3).

    Args:
        pixels: Red, green and blue, row by row from the top.
        text: Fields stored with the picture, such as {"Renderer": "software"}; Latin-1.
    """
    height, width = pixels.shape[:2]
    rows = np.ascontiguousarray(pixels, np.uint8).reshape(height, -1)
    # Filter 2 (each row as the difference from the one above) suits gradients.
    rows = np.concatenate((rows[:1], rows[1:] - rows[:-1]))
    filtered = np.concatenate((np.full((height, 1), 2, np.uint8), rows), axis=1)
    chunks = [_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))]
    for key, value in (text or {}).items():
        field = key.encode("latin-1", "replace") + b"\0" + value.encode("latin-1", "replace")
        chunks.append(_chunk(b"tEXt", field))
    chunks.append(_chunk(b"IDAT", zlib.compress(filtered.tobytes(), 6)))
    chunks.append(_chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def write_png(
    path: str | PathLike[str], pixels: np.ndarray, text: Mapping[str, str] | None = None
) -> None:
    """Write RGB pixels, uint8, shape (height, width, 3), as a PNG file."""
    with written(path) as temporary:
        temporary.write_bytes(encoded(pixels, text))


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
