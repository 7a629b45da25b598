"""`understudy train`: search an athlete's gains."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from understudy import __version__
from understudy.app import train_standing
from understudy.app.outcome import Outcome, plain, table
from understudy.app.performing import ready, staged

if TYPE_CHECKING:
    from understudy.training import Trained

EXAMPLE = """\
  understudy train running --evaluations 6000 --checkpoint search.json --out out
  understudy train running --start out/running.json --sigma 0.02 --seed 1 --out out
  understudy train running --part stop --evaluations 240 --sigma 0.1 --out out"""

# Steady states are kept at these speeds [m/s].
_SPEEDS = (2.5, 3.0, 3.5, 4.0, 4.5, 5.0)


@dataclass(frozen=True, kw_only=True)
class Options:
    """Search an athlete's gains by CMA-ES over scenarios: speeds, ramps, turns, friction, pushes.

    Writes NAME.json, gains with the command and seed that made them, and NAME.png, the convergence
    plot, where matplotlib is installed. With --checkpoint a stopped search goes on.

    Attributes:
        behavior: running (Hodgins et al. 1995).
        part: gait; or start or stop, of standing, with the shipped gait, which write standing.json.
        start: Gains to begin with, a NAME.json; by default a guess, of standing the shipped ones.
        gains: Names of the gains to search, with their slopes.
        evaluations: Candidates to try, each in every scenario.
        population: Candidates of a generation.
        sigma: First step over the range of the bounds.
        seed: Of the search and of the scenarios' chances.
        threads: Runs at a time; by default one per core.
        checkpoint: File that keeps the search.
        out: Folder for the files.
        json: Print one JSON object.
    """

    behavior: Positional[Annotated[Literal["running"], arg(metavar="BEHAVIOR")]]
    part: Literal["gait", "start", "stop"] = "gait"
    start: Annotated[Path | None, arg(metavar="FILE", help_behavior_hint="(default: none)")] = None
    gains: Annotated[tuple[str, ...], arg(metavar="NAME", help_behavior_hint="(default: all)")] = ()
    evaluations: Annotated[int, arg(metavar="N")] = 4000
    population: Annotated[int, arg(metavar="N")] = 20
    sigma: Annotated[float, arg(metavar="S")] = 0.02
    seed: Annotated[int, arg(metavar="N")] = 1
    threads: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: cores)")] = None
    checkpoint: Annotated[
        Path | None, arg(metavar="FILE", help_behavior_hint="(default: none)")
    ] = None
    out: Annotated[Path, arg(metavar="DIR")] = Path()
    json: bool = False


def run(options: Options) -> Outcome:
    """Search, and write the gains and the convergence plot."""
    from understudy.athletics.gains import Schedule
    from understudy.character import athlete_man, athlete_woman
    from understudy.training import steady_states, train

    if options.part != "gait":
        return train_standing.run(options, _told)
    ready(options.out)
    start = Schedule()
    if options.start is not None:
        start = Schedule.from_json(json.loads(options.start.read_text(encoding="utf-8")))
    trained = train(
        start,
        names=options.gains,
        evaluations=options.evaluations,
        population=options.population,
        sigma=options.sigma,
        seed=options.seed,
        threads=options.threads or os.cpu_count() or 1,
        checkpoint=options.checkpoint,
        told=_told,
    )
    schedule = replace(trained.schedule, origin=_origin(options, trained))
    notes = []
    for body in (athlete_man(), athlete_woman()):
        schedule, fallen = steady_states(schedule, body, _SPEEDS)
        if fallen:
            speeds = ", ".join(f"{speed:g}" for speed in fallen)
            notes.append(f"{body.name} fell at {speeds} m/s: no steady states there")
    name = options.behavior
    keep = [path for path in (options.start, options.checkpoint) if path is not None]
    with staged(options.out, name, keep=keep) as (folder, files):
        text = json.dumps(plain(schedule.as_json()), indent=1)
        (folder / f"{name}.json").write_text(text + "\n", encoding="utf-8")
        _plot(trained, folder / f"{name}.png")
    result = {"origin": dict(schedule.origin), "notes": notes, "files": files}
    rows = [("generation", "evaluations", "least cost", "median cost", "falls %")]
    rows += [_shown(row) for row in trained.history[-10:]]
    text = "\n".join([table(rows, right=range(5)), *notes, "", "files:", *files.values()])
    return Outcome(result=result, text=text)


def _told(row: dict[str, float]) -> None:
    words = ("generation", "evaluations", "least", "median", "falls %")
    if row["generation"] % 20 == 0:
        print("  ".join(f"{word:>11}" for word in words), file=sys.stderr)
    print("  ".join(f"{cell:>11}" for cell in _shown(row)), file=sys.stderr, flush=True)


def _shown(row: dict[str, float]) -> tuple[str, ...]:
    return (
        f"{row['generation']:.0f}",
        f"{row['evaluations']:.0f}",
        f"{row['least']:.3f}",
        f"{row['median']:.3f}",
        f"{100 * row['falls']:.0f}",
    )


def _origin(options: Options, trained: Trained) -> dict[str, Any]:
    words = ["understudy", "train", options.behavior]
    for name in ("evaluations", "population", "sigma", "seed"):
        words += [f"--{name}", str(getattr(options, name))]
    if options.gains:
        words += ["--gains", *options.gains]
    if options.start is not None:
        words += ["--start", options.start.name]
    return {
        "command": " ".join(words),
        "seed": options.seed,
        "generations": len(trained.history),
        "version": __version__,
    }


def _plot(trained: Trained, path: Path) -> None:
    """Cost against evaluations, where matplotlib is installed."""
    import numpy as np

    from understudy.errors import MissingExtra
    from understudy.evaluate.chart import Chart, Series, write_chart

    x = np.array([row["evaluations"] for row in trained.history])
    chart = Chart(
        title="Convergence of the runner's gains",
        caption="Cost over the scenarios of each generation, which differ in their chances.",
        x_label="Evaluations",
        y_label="Cost",
        series=tuple(
            Series(
                name=f"{name} of a generation", x=x, y=np.array([r[name] for r in trained.history])
            )
            for name in ("least", "median")
        ),
    )
    with contextlib.suppress(MissingExtra):
        write_chart(chart, path)
