"""`understudy tune --drive`: the gains at which driven rigid bodies follow a clip best."""

from __future__ import annotations

import contextlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import arg

from understudy.app.outcome import Outcome, plain
from understudy.app.performing import ready, staged
from understudy.app.reading import Reading, clip_from, inputs, stem

if TYPE_CHECKING:
    from understudy.drive_tuning import TunedDrive


@dataclass(frozen=True, kw_only=True)
class Searching:
    """Search for the drive of rigid bodies instead (Wilke & Semwal 2017).

    Attributes:
        drive: Tune the rigid-body drive of this linkage instead of a servo: K_f, K_vc and n.
        method: monte_carlo (the paper's algorithm 1) or cma (CMA-ES); with --drive.
        points: Points of a run of algorithm 1, nine simulations each.
        runs: Runs of algorithm 1; each begins at the best of the one before.
        evaluations: Simulations of CMA-ES.
        hz: Frames per second to drive at, one physics step each.
        scale: Size of the simulated model over the clip's.
        seed: Seed of the search.
        checkpoint: File that keeps the trials, so that a stopped search goes on.
    """

    drive: Literal["independent", "skeleton", "constrained", "tree"] | None = None
    method: Literal["monte_carlo", "cma"] = "cma"
    points: Annotated[int, arg(metavar="N")] = 100
    runs: Annotated[int, arg(metavar="N")] = 1
    evaluations: Annotated[int, arg(metavar="N")] = 90
    hz: Annotated[float, arg(metavar="HZ")] = 60.0
    scale: Annotated[float, arg(metavar="S")] = 1.4286
    seed: Annotated[int, arg(metavar="N")] = 0
    checkpoint: Annotated[
        Path | None, arg(metavar="FILE", help_behavior_hint="(default: none)")
    ] = None


def searched(clip_word: str, reading: Reading, options: Searching, out: Path) -> Outcome:
    """Search, and write the trials, their plot, and the best parameters for other clips."""
    from understudy.character import Linkage
    from understudy.drive_tuning import tune_drive, write_parameters

    ready(out)
    clip = clip_from(clip_word, reading)
    assert options.drive is not None
    tuned = tune_drive(
        clip,
        Linkage.from_clip(clip, options.drive),
        method=options.method,
        points=options.points,
        runs=options.runs,
        evaluations=options.evaluations,
        rate=options.hz,
        scale=options.scale,
        seed=options.seed,
        checkpoint=options.checkpoint,
        progress=True,
    )
    found = result(clip_word, tuned)
    name = f"{stem(clip_word)}_{options.drive}"
    with staged(out, name, keep=inputs([clip_word], reading)) as (folder, files):
        text = json.dumps(plain(found), indent=2)
        (folder / f"{name}_tuning.json").write_text(text + "\n", encoding="utf-8")
        write_parameters(tuned, folder / f"{name}_parameters.json")
        plot(tuned, folder / f"{name}_tuning.png")
    return Outcome(result=found | {"files": files}, text=summary(tuned, files))


def result(clip_word: str, tuned: TunedDrive) -> dict[str, Any]:
    """A search as plain values."""
    return {
        "clip": clip_word,
        "best": asdict(tuned.best),
        "driven": tuned.parameters,
        "trials": [asdict(trial) for trial in tuned.trials],
        "settings": dict(tuned.settings),
        "units": {
            "gain": "K_f, 1/s",
            "speed": "K_vc, clip units per frame to simulated units per second",
            "error": "units^2, equation 4",
            "variance": "units^4, over joints",
        },
    }


def summary(tuned: TunedDrive, files: dict[str, str]) -> str:
    """What was found, how to use it, and the files."""
    path = files.get("parameters.json", "parameters.json")
    return "\n".join(
        [
            str(tuned),
            "",
            "use it in Python, on any clip:",
            f"  us.driven(clip, linkage, **read_parameters({path!r}))",
            "",
            "files:",
            *(f"  {path}" for path in files.values()),
        ]
    )


def plot(tuned: TunedDrive, path: Path) -> None:
    """Least error so far against simulations, where matplotlib is installed."""
    from understudy.errors import MissingExtra
    from understudy.evaluate.chart import write_chart
    from understudy.evaluate.convergence import convergence

    with contextlib.suppress(MissingExtra):
        write_chart(convergence([tuned]), path)
