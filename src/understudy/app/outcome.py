"""What a command hands back: an object for machines, text for people, an exit status."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The outcome of a command.

    Attributes:
        result: What `--json` prints: strings, numbers, booleans, None, lists and mappings.
        text: What a person reads on standard output.
        status: Exit status of the process.
    """

    result: Mapping[str, Any] = field(default_factory=dict)
    text: str = ""
    status: int = 0


class Interrupted(KeyboardInterrupt):
    """A command that was told to stop, with what it had finished.

    Attributes:
        result: What `--json` prints of the finished part.
        status: Exit status of the process: 130 for Ctrl-C, 143 for a request to end.
        kept: What a person reads of the finished part.
    """

    def __init__(
        self,
        *,
        result: Mapping[str, Any] | None = None,
        status: int = 130,
        kept: str = "finished files are kept",
    ):
        super().__init__()
        self.kept = kept
        self.result = dict(result or {})
        self.status = status


def plain(value: Any) -> Any:
    """The same value in types JSON knows; NaN and infinity become null."""
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, str | bool) or value is None:
        return value
    if hasattr(value, "tolist"):  # NumPy arrays and scalars
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, int):
        return value
    if isinstance(value, PathLike):
        return fspath(value)
    if isinstance(value, Sequence):
        return [plain(v) for v in value]
    return str(value)


def table(rows: Sequence[Sequence[str]], *, right: Sequence[int] = ()) -> str:
    """Rows of cells as aligned columns: the first row is the head, `right` the numeric columns."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [
            cell.rjust(width) if i in right else cell.ljust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
    lines.insert(1, "-" * max(len(line) for line in lines))
    return "\n".join(lines)
