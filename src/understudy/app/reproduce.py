"""`understudy reproduce`: a paper's tables and figures, run again beside the published numbers."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome, table
from understudy.errors import InvalidValue

if TYPE_CHECKING:
    from understudy.papers import wilke2017, zordan1999

EXAMPLE = """\
  understudy reproduce wilke2017 --out out
  understudy reproduce wilke2017 --clips cmu --out out
  understudy reproduce zordan1999 --clips cmu
  understudy reproduce hodgins1995 --part running --out out"""
# What only one paper's experiments know.
_SEARCHES = ("fetch", "points", "runs", "evaluations", "seed")
# Folder with captured motions, where --clips gives none (hodgins1995).
_CLIPS = "UNDERSTUDY_CLIPS"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Run a paper's experiments again: published and measured numbers side by side.

    wilke2017: tables 1 to 4 and figures 2 to 11 of Wilke & Semwal 2017. zordan1999: figures 1 and 4
    to 9 of Zordan & Hodgins 1999. hodgins1995: what Hodgins et al. 1995 say of a part. Writes
    PAPER.html, PAPER.json and a CSV per table. The page says which clips stand in for the paper's,
    and what cannot be compared and why. About two minutes on two cores.

    Attributes:
        paper: wilke2017, zordan1999 or hodgins1995.
        part: Of hodgins1995: running, figures 1 to 3, 5 and 6 and the text's statements.
        clips: Folder with captured motions, BVH or AMC; bundled samples for what is missing.
            wilke2017: CMU 141_02, 08, 14, 15, 30, or 127_03, 14_21, 135_04, 127_02, 09_12 and
            others in their place. zordan1999: a gesture, CMU 13_26, 13_18, 18_08, 02_05 or
            wave_hello. hodgins1995: runs to show beside, CMU 02_03, 35_17, 127_03; by default in
            the folder that the variable UNDERSTUDY_CLIPS names.
        fetch: Download motions that are missing, where a public source is known (wilke2017).
        points: Points of a run of algorithm 1; nine simulations each (wilke2017).
        runs: Runs of algorithm 1 for each linkage; 0 for the paper's 5, 9 and 10 (wilke2017).
        evaluations: Simulations of CMA-ES (wilke2017).
        seed: Seed of the searches (wilke2017).
        quick: Short clips and token experiments, to see that all of it runs.
        out: Folder for the files.
        json: Print one JSON object.
    """

    paper: Positional[
        Annotated[Literal["wilke2017", "zordan1999", "hodgins1995"], arg(metavar="PAPER")]
    ]
    part: Annotated[Literal["running"], arg(metavar="PART")] = "running"
    clips: Annotated[Path | None, arg(metavar="FOLDER", help_behavior_hint="(default: none)")] = (
        None
    )
    fetch: bool = False
    points: Annotated[int, arg(metavar="N")] = 100
    runs: Annotated[int, arg(metavar="N")] = 1
    evaluations: Annotated[int, arg(metavar="N")] = 90
    seed: Annotated[int, arg(metavar="N")] = 0
    quick: bool = False
    out: Annotated[
        Path | None, arg(metavar="DIR", help_behavior_hint="(default: the paper's name)")
    ] = None
    json: bool = False


def run(options: Options) -> Outcome:
    """Run the experiments and write the page."""
    from understudy.app.performing import ready

    folder = options.out or Path(options.paper)
    ready(folder)
    if options.paper == "wilke2017":
        return _wilke(options, folder)
    _without_searches(options)
    return (_zordan if options.paper == "zordan1999" else _hodgins)(options, folder)


def _without_searches(options: Options) -> None:
    """Refuse what only the searches of wilke2017 know."""
    usual = {field.name: field.default for field in fields(Options)}
    for name in _SEARCHES:
        if getattr(options, name) != usual[name]:
            raise InvalidValue(f"--{name} is for wilke2017; {options.paper} has no searches.")


def _wilke(options: Options, out: Path) -> Outcome:
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
    with staged(out, options.paper) as (folder, files):
        wilke2017.write(found, folder)
    return Outcome(result=wilke2017.as_dict(found) | {"files": files}, text=summary(found, files))


def _zordan(options: Options, out: Path) -> Outcome:
    from understudy.app.performing import staged
    from understudy.papers import zordan1999

    found = zordan1999.reproduce(options.clips, quick=options.quick, progress=True)
    with staged(out, options.paper) as (folder, files):
        zordan1999.write(found, folder)
    return Outcome(result=zordan1999.as_dict(found) | {"files": files}, text=told(found, files))


def _hodgins(options: Options, out: Path) -> Outcome:
    from understudy.app.performing import staged
    from understudy.papers import hodgins1995
    from understudy.papers.finding import told_of
    from understudy.papers.hodgins1995.page import QUICK

    named = os.environ.get(_CLIPS)
    folder = options.clips or (Path(named) if named and Path(named).is_dir() else None)
    found = hodgins1995.reproduce(options.part, folder, quick=options.quick, progress=True)
    with staged(out, options.paper) as (place, files):
        hodgins1995.write(found, place)
    parts = [QUICK] if found.quick else []
    parts += [f"captured: {', '.join(found.captured) or 'none'}", *told_of(found.findings)]
    text = "\n\n".join([*parts, _listed(files)])
    return Outcome(result=hodgins1995.as_dict(found) | {"files": files}, text=text)


def told(found: zordan1999.Reproduced, files: dict[str, str]) -> str:
    """What the paper says of each figure, what was measured, and the files."""
    from understudy.papers.finding import told_of
    from understudy.papers.zordan1999.page import QUICK

    parts = [QUICK] if found.quick else []
    parts += [f"gesture: {found.cast.source}", *told_of(found.findings)]
    return "\n\n".join([*parts, _listed(files)])


def summary(found: wilke2017.Reproduced, files: dict[str, str]) -> str:
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
    return "\n\n".join([*parts, _listed(files)])


def _listed(files: dict[str, str]) -> str:
    return "\n".join(["files:", *(f"  {path}" for path in files.values())])


def _shown(cell: Any) -> str:
    if cell is None:
        return ""
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)
