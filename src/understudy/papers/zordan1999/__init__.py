"""Zordan & Hodgins 1999: every figure with simulations, run again.

In: a folder with a captured gesture, or none. Out: one HTML page, its tables as CSV, all numbers as
JSON.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from understudy.papers.finding import Finding, held_of
from understudy.papers.reproduction import Makers, findings_of, write_files
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
    makers: Makers = (
        (4, lambda: (gesturing(cast, quick=quick),)),
        (4, lambda: drumming(quick=quick)),
        (3, lambda: (slapping(quick=quick),)),
        (1, lambda: (speeding(cast, quick=quick),)),
        (2, lambda: (pumping(quick=quick),)),
        (6, lambda: (bowing(quick=quick),)),
        (9, lambda: (clapping(quick=quick),)),
    )
    findings = findings_of(makers, progress=progress)
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
    from understudy.papers.zordan1999 import page

    write_files(
        folder,
        "zordan1999",
        page=page.page_html(found),
        numbers=page.as_dict(found),
        sheets=[sheet for finding in found.findings for sheet in finding.sheets],
    )


def as_dict(found: Reproduced) -> dict[str, object]:
    """All numbers as plain values; see `page.as_dict`."""
    from understudy.papers.zordan1999 import page

    return page.as_dict(found)
