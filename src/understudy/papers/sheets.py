"""Tables of published and measured numbers: as a value, as HTML and as CSV."""

from __future__ import annotations

import csv
import html as markup
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

STYLE = """
.note{color:var(--dim);font-size:.875rem;margin:.35rem 0}
.wide{margin-bottom:.6rem}
.wide table{font-size:.8125rem}
.wide th,.wide td{padding:.25rem .6rem .25rem 0;vertical-align:bottom}
.wide thead th{font-weight:600;line-height:1.25}
.wide th:first-child,.wide .words{text-align:left}
.wide tbody th{white-space:nowrap}
.wide .published>*{background:var(--panel)}
"""


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A table: published and measured numbers side by side.

    Attributes:
        name: "Table 1".
        caption: What it is and in which units.
        head: Column names.
        rows: Strings and numbers; None where there is nothing.
        notes: What to know when reading it.
    """

    name: str
    caption: str
    head: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...] = field(repr=False)
    notes: tuple[str, ...] = ()


def as_csv(sheet: Sheet) -> str:
    """A table as CSV, numbers in full."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(sheet.head)
    writer.writerows(["" if cell is None else cell for cell in row] for row in sheet.rows)
    return out.getvalue()


def as_html(sheet: Sheet, *, endless: str = "") -> str:
    """A table as HTML; the page needs `STYLE`.

    Args:
        sheet: The table. A row with the cell "published" is set off.
        endless: What to write for numbers that are not finite.
    """
    columns = range(len(sheet.head))
    worded = [any(isinstance(row[k], str) for row in sheet.rows) for k in columns]

    def row(cells: Sequence[Any], tag: str = "td") -> str:
        parts = []
        for k, (cell, words) in enumerate(zip(cells, worded, strict=True)):
            own = "th scope='row'" if k == 0 and tag == "td" else tag
            kind = ' class="words"' if words and k else ""
            parts.append(f"<{own}{kind}>{_cell(cell, endless)}</{own.split()[0]}>")
        return f"<tr>{''.join(parts)}</tr>"

    body = "".join(
        row(cells).replace("<tr>", '<tr class="published">') if "published" in cells else row(cells)
        for cells in sheet.rows
    )
    text = markup.escape
    notes = "".join(f'<p class="note">{text(note)}</p>' for note in sheet.notes)
    return (
        f'<div class="wide" tabindex="0" role="region" aria-label="{text(sheet.name)}">'
        f"<table><caption>{text(sheet.caption)}</caption>"
        f"<thead>{row(sheet.head, 'th')}</thead><tbody>{body}</tbody></table></div>{notes}"
    )


def plain(value: Any) -> Any:
    """The same in types JSON knows; what is not finite becomes null."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _cell(value: Any, endless: str) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}" if math.isfinite(value) else endless
    return markup.escape(str(value))
