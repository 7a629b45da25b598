"""Hodgins et al. 1995: what the paper says of its athletes, run again.

In: a part of the paper, and a folder with captured runs, or none. Out: one HTML page, its tables as
CSV, all numbers as JSON.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from understudy.errors import UnknownName
from understudy.papers.finding import Finding, held_of
from understudy.papers.hodgins1995.likeness import alike
from understudy.papers.hodgins1995.limbs import limbs
from understudy.papers.hodgins1995.paths import following
from understudy.papers.hodgins1995.pictures import running_pictures
from understudy.papers.hodgins1995.runs import Captured, captured_runs
from understudy.papers.hodgins1995.speeds import abrupt, speeds
from understudy.papers.hodgins1995.states import bodies, machine
from understudy.papers.reproduction import Makers, findings_of, write_files

__all__ = ["PARTS", "Reproduced", "as_dict", "reproduce", "write"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Reproduced:
    """Everything measured.

    Attributes:
        part: Of the paper, such as "running".
        captured: Names of the captured motions shown beside.
        findings: One for each figure or group of statements, in the paper's order.
        quick: Whether runs were cut short, to see that all of it runs.
    """

    part: str
    captured: tuple[str, ...]
    findings: tuple[Finding, ...]
    quick: bool = False

    @property
    def held(self) -> tuple[int, int]:
        """How many of the claims hold, and how many there are."""
        return held_of(self.findings)


def _running(captured: tuple[Captured, ...], quick: bool) -> Makers:
    """What is measured of the runner, each with about how long it takes."""
    return (
        (6, lambda: [running_pictures(captured, quick=quick)]),
        (1, lambda: [bodies()]),
        (2, lambda: [machine(quick=quick)]),
        (3, lambda: [limbs(quick=quick)]),
        (6, lambda: [speeds(captured, quick=quick)]),
        (2, lambda: [abrupt(quick=quick)]),
        (2, lambda: [following(quick=quick)]),
        (2, lambda: [alike(captured, quick=quick)]),
    )


PARTS: dict[str, Callable[[tuple[Captured, ...], bool], Makers]] = {"running": _running}
"""Parts of the paper that can be run again."""


def reproduce(
    part: str = "running",
    folder: Path | None = None,
    *,
    quick: bool = False,
    progress: bool = False,
) -> Reproduced:
    """Measure what the paper says.

    Args:
        part: One of `PARTS`.
        folder: Where captured runs may be; None for none.
        quick: Seconds instead of minutes, to see that all of it runs.
        progress: Show a progress bar on standard error.

    Raises:
        UnknownName: No such part.
        ClipError: No such folder.
    """
    if part not in PARTS:
        raise UnknownName("part", part, PARTS)
    captured = captured_runs(folder)
    findings = findings_of(PARTS[part](captured, quick), progress=progress)
    names = tuple(one.name for one in captured)
    return Reproduced(part=part, captured=names, findings=tuple(findings), quick=quick)


def write(found: Reproduced, folder: Path) -> None:
    """Write hodgins1995.html, hodgins1995.json and one hodgins1995_NAME.csv per table.

    Raises:
        UnderstudyError: A file cannot be written.
    """
    from understudy.papers.hodgins1995 import page

    write_files(
        folder,
        "hodgins1995",
        page=page.page_html(found),
        numbers=page.as_dict(found),
        sheets=[sheet for finding in found.findings for sheet in finding.sheets],
    )


def as_dict(found: Reproduced) -> dict[str, object]:
    """All numbers as plain values; see `page.as_dict`."""
    from understudy.papers.hodgins1995 import page

    return page.as_dict(found)
