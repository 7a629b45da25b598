"""`understudy train running --part start` or `stop`: search the gains of standing."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from understudy import __version__
from understudy.app.outcome import Outcome, plain, table
from understudy.app.performing import ready, staged
from understudy.errors import InvalidValue

if TYPE_CHECKING:
    from collections.abc import Callable

    from understudy.app.train import Options
    from understudy.athletics.standing_gains import StandingSchedule
    from understudy.standing_training import TrainedStanding

NAME = "standing"
_COLUMNS = ("generation", "evaluations", "least", "median", "falls %")


def run(options: Options, told: Callable[[dict[str, float]], None]) -> Outcome:
    """Search, and write the gains.

    Raises:
        InvalidValue: A checkpoint is asked for; a search of minutes goes on from its own output.
    """
    from understudy.athletics.gains import shipped
    from understudy.athletics.standing_gains import StandingSchedule, shipped_standing
    from understudy.standing_training import train_standing

    if options.checkpoint is not None:
        raise InvalidValue(
            f"--checkpoint is for the gait; --part {options.part} goes on with --start."
        )
    ready(options.out)
    start = shipped_standing()
    if options.start is not None:
        saved = json.loads(options.start.read_text(encoding="utf-8"))
        start = StandingSchedule.from_json(saved)
    assert options.part != "gait"
    trained = train_standing(
        options.part,
        start,
        shipped(),
        names=options.gains,
        evaluations=options.evaluations,
        population=options.population,
        sigma=options.sigma,
        seed=options.seed,
        threads=options.threads or os.cpu_count() or 1,
        told=told,
    )
    found = replace(trained.standing, origin=_origin(options, trained, start))
    keep = [options.start] if options.start is not None else []
    with staged(options.out, NAME, keep=keep) as (folder, files):
        text = json.dumps(plain(found.as_json()), indent=1)
        (folder / f"{NAME}.json").write_text(text + "\n", encoding="utf-8")
    rows = [_COLUMNS, *(_shown(row) for row in trained.history[-10:])]
    lines = [table(rows, right=range(5)), "", "files:", *files.values()]
    result = {"origin": dict(found.origin), "notes": [], "files": files}
    return Outcome(result=result, text="\n".join(lines))


def _shown(row: dict[str, float]) -> tuple[str, ...]:
    counts = (f"{row['generation']:.0f}", f"{row['evaluations']:.0f}")
    return *counts, f"{row['least']:.3f}", f"{row['median']:.3f}", f"{100 * row['falls']:.0f}"


def _origin(options: Options, trained: TrainedStanding, start: StandingSchedule) -> dict[str, Any]:
    words = ["understudy", "train", options.behavior, "--part", options.part]
    for name in ("evaluations", "population", "sigma", "seed"):
        words += [f"--{name}", str(getattr(options, name))]
    if options.gains:
        words += ["--gains", *options.gains]
    if options.start is not None:
        words += ["--start", options.start.name]
    made = {
        "command": " ".join(words),
        "seed": options.seed,
        "generations": len(trained.history),
        "version": __version__,
    }
    # The other part's stays; so the file tells how all of it came about.
    return dict(start.origin) | {options.part: made}
