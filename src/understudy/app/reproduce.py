"""`understudy reproduce`: a paper's tables and figures, run again beside the published numbers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome, table

if TYPE_CHECKING:
    from understudy.papers.wilke2017 import Reproduced

EXAMPLE = """\
  understudy reproduce wilke2017 --out out
  understudy reproduce wilke2017 --clips cmu --out out"""


@dataclass(frozen=True, kw_only=True)
class Options:
    """Run a paper's experiments again: published and measured numbers side by side.

    wilke2017: tables 1 to 4 and figures 2 to 11 of Wilke & Semwal 2017. Writes wilke2017.html,
    wilke2017.json and a CSV per table. The page says which clips stand in for the paper's, and what
    cannot be compared and why. About two minutes on two cores.

    Attributes:
        paper: wilke2017.
        clips: Folder with CMU motions, BVH or AMC: 141_02, 08, 14, 15, 30, or 127_03, 14_21,
            135_04, 127_02, 09_12 and others in their place; bundled samples for what is missing.
        fetch: Download motions that are missing, where a public source is known.
        points: Points of a run of algorithm 1; nine simulations each.
        runs: Runs of algorithm 1 for each linkage; 0 for the paper's 5, 9 and 10.
        evaluations: Simulations of CMA-ES.
        seed: Seed of the searches.
        quick: Two seconds of each clip and a token search, to see that all of it runs.
        out: Folder for the files.
        json: Print one JSON object.
    """

    paper: Positional[Annotated[Literal["wilke2017"], arg(metavar="PAPER")]]
    clips: Annotated[Path | None, arg(metavar="FOLDER", help_behavior_hint="(default: none)")] = (
        None
    )
    fetch: bool = False
    points: Annotated[int, arg(metavar="N")] = 100
    runs: Annotated[int, arg(metavar="N")] = 1
    evaluations: Annotated[int, arg(metavar="N")] = 90
    seed: Annotated[int, arg(metavar="N")] = 0
    quick: bool = False
    out: Annotated[Path, arg(metavar="DIR")] = Path("wilke2017")
    json: bool = False


def run(options: Options) -> Outcome:
    """Run the experiments and write the page."""
    from understudy.app.performing import staged
    from understudy.papers import wilke2017

    effort = wilke2017.Effort(
        points=options.points,
        runs=options.runs or None,
        evaluations=options.evaluations,
        seed=options.seed,
    )
    found = wilke2017.reproduce(
        options.clips,
        effort=effort,
        quick=options.quick,
        online=options.fetch,
        progress=True,
    )
    with staged(options.out, options.paper) as (folder, files):
        wilke2017.write(found, folder)
    return Outcome(result=wilke2017.as_dict(found) | {"files": files}, text=summary(found, files))


def summary(found: Reproduced, files: dict[str, str]) -> str:
    """Who played, tables 1 and 3, and the files."""
    from understudy.papers.wilke2017.page import PARTS, QUICK, SETTINGS

    clips: list[tuple[str, ...]] = [("published file", "motion", "used here")]
    clips += [(f"{p.file}.bvh", p.motion, found.cast.sources[p.file]) for p in PARTS]
    parts = [*([QUICK] if found.quick else []), table(clips), SETTINGS]
    for sheet in (found.tables[0], found.tables[2]):
        rows = [sheet.head, *([_shown(cell) for cell in row] for row in sheet.rows)]
        numbers = [k for k, cell in enumerate(sheet.rows[0]) if not isinstance(cell, str)]
        parts.append(f"{sheet.name}. {sheet.caption}\n{table(rows, right=numbers)}")
        parts += sheet.notes
    return "\n\n".join([*parts, "\n".join(["files:", *(f"  {path}" for path in files.values())])])


def _shown(cell: Any) -> str:
    if cell is None:
        return ""
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)
