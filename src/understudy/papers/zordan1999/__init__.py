"""Zordan & Hodgins 1999: every figure with simulations, run again.

In: a folder with a captured gesture, or none. Out: one HTML page, its tables as CSV, all numbers as
JSON.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from understudy.motion.files import written
from understudy.papers.finding import Finding, held_of
from understudy.papers.sheets import as_csv, plain
from understudy.papers.zordan1999.bow import bowing
from understudy.papers.zordan1999.cast import Cast, casting
from understudy.papers.zordan1999.drum import drumming
from understudy.papers.zordan1999.gestures import gesturing
from understudy.papers.zordan1999.patty_cake import clapping
from understudy.papers.zordan1999.speeds import speeding
from understudy.papers.zordan1999.staff import pumping
from understudy.papers.zordan1999.transition import slapping

__all__ = ["Reproduced", "as_dict", "reproduce", "write"]

# What "quick" leaves of the gesture [s].
_QUICK_SECONDS = 2.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Reproduced:
    """Everything measured.

    Attributes:
        cast: Which clips stood in for the paper's.
        findings: One for each figure, or part of one, in the paper's order.
        quick: Whether clips and games were cut short, to see that all of it runs.
    """

    cast: Cast
    findings: tuple[Finding, ...]
    quick: bool = False

    @property
    def held(self) -> tuple[int, int]:
        """How many of the claims hold, and how many there are."""
        return held_of(self.findings)


def reproduce(
    folder: Path | None = None, *, quick: bool = False, progress: bool = False
) -> Reproduced:
    """Make the paper's figures again.

    Args:
        folder: Where a captured gesture may be; None for the bundled one.
        quick: The beginning of each motion and fewer bodies and games, to see that all of it runs.
        progress: Show a progress bar on standard error.

    Raises:
        ClipError: No such folder.
    """
    cast = casting(folder, seconds=_QUICK_SECONDS if quick else None)
    # Each with about how long it takes.
    makers: tuple[tuple[int, Callable[[], tuple[Finding, ...]]], ...] = (
        (4, lambda: (gesturing(cast, quick=quick),)),
        (4, lambda: drumming(quick=quick)),
        (3, lambda: (slapping(quick=quick),)),
        (1, lambda: (speeding(cast, quick=quick),)),
        (2, lambda: (pumping(quick=quick),)),
        (6, lambda: (bowing(quick=quick),)),
        (9, lambda: (clapping(quick=quick),)),
    )
    findings: list[Finding] = []
    with tqdm(
        total=sum(cost for cost, _ in makers),
        desc="figures",
        bar_format="{desc} {percentage:3.0f} %|{bar}| {elapsed}",
        delay=1.0,
        disable=None if progress else True,
        leave=False,
    ) as bar:
        for cost, make in makers:
            findings += make()
            bar.update(cost)
    # A film that belongs to a later figure is shown there.
    order = ("drum", "staff", "bow")
    findings.sort(
        key=lambda finding: (
            finding.figure.split(",")[0],
            [part in finding.figure for part in order][::-1],
        )
    )
    return Reproduced(cast=cast, findings=tuple(findings), quick=quick)


def write(found: Reproduced, folder: Path) -> None:
    """Write zordan1999.html, zordan1999.json and one zordan1999_NAME.csv per table.

    Raises:
        UnderstudyError: A file cannot be written.
    """
    from understudy.papers.zordan1999.page import as_dict, page_html

    kept = plain(as_dict(found))
    texts = {
        "zordan1999.html": page_html(found),
        "zordan1999.json": json.dumps(kept, indent=2, allow_nan=False, ensure_ascii=False) + "\n",
    }
    for finding in found.findings:
        for sheet in finding.sheets:
            name = sheet.name.lower().replace(" ", "_")
            texts[f"zordan1999_{name}.csv"] = as_csv(sheet)
    for name, text in texts.items():
        with written(folder / name) as temporary:
            temporary.write_text(text, encoding="utf-8")


def as_dict(found: Reproduced) -> dict[str, object]:
    """All numbers as plain values; see `page.as_dict`."""
    from understudy.papers.zordan1999 import page

    return page.as_dict(found)
