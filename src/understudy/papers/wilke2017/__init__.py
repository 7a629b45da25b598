"""Wilke & Semwal 2017: every table and every figure with simulations, run again.

In: a folder of clips, or none. Out: one HTML page, its tables as CSV, all numbers as JSON.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from understudy.errors import InvalidValue
from understudy.papers.reproduction import write_files
from understudy.papers.wilke2017.cast import casting
from understudy.papers.wilke2017.experiments import Effort, Reproduced, experiments
from understudy.papers.wilke2017.page import as_dict, page_html

__all__ = ["Effort", "Reproduced", "as_dict", "reproduce", "write"]

# What "quick" leaves of the searches and of the clips [s].
_QUICK = {"points": 1, "runs": 1, "evaluations": 14}
_QUICK_SECONDS = 2.0


def reproduce(
    folder: Path | None = None,
    *,
    effort: Effort | None = None,
    quick: bool = False,
    online: bool = False,
    progress: bool = False,
) -> Reproduced:
    """Run the paper's experiments.

    Args:
        folder: Clips: the paper's 141_02, 08, 14, 15, 30, or motions that stand in for them; None
            for the bundled samples.
        effort: How much to search.
        quick: The first seconds of each clip and a token search, to see that all of it runs.
        online: Download what is missing, where a public source is known.
        progress: Show progress bars on standard error.

    Raises:
        ClipError: No such folder.
        InvalidValue: A search of no points, runs or evaluations.
        MissingExtra: The package cma is missing (extra `search`).
    """
    effort = effort or Effort()
    check_effort(effort)
    if quick:
        effort = replace(effort, **_QUICK)
    cast = casting(folder, seconds=_QUICK_SECONDS if quick else None, online=online)
    return experiments(cast, effort, quick=quick, progress=progress)


def check_effort(effort: Effort) -> None:
    """Refuse searches that are none, whether or not they would run.

    Raises:
        InvalidValue: Names the value and its range.
    """
    counts = {"points": effort.points, "evaluations": effort.evaluations}
    if effort.runs is not None:
        counts["runs"] = effort.runs
    for name, value in counts.items():
        if not 1 <= value <= 1_000_000:
            raise InvalidValue(f"{name} is {value}; it must lie in 1 to 1000000.")
    if effort.seed < 0:
        raise InvalidValue(f"seed is {effort.seed}; it must be zero or a positive whole number.")


def write(found: Reproduced, folder: Path) -> None:
    """Write wilke2017.html, wilke2017.json and one wilke2017_NAME.csv per table.

    Raises:
        UnderstudyError: A file cannot be written.
    """
    write_files(
        folder,
        "wilke2017",
        page=page_html(found),
        numbers=as_dict(found),
        sheets=(*found.tables, *found.figures.values()),
    )
