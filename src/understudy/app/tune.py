"""`understudy tune`: the servo stiffness that follows a clip best."""

from __future__ import annotations

import contextlib
import json
import math
import shlex
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from understudy.app.body import Body, character_for
from understudy.app.drive_search import Searching, searched
from understudy.app.outcome import Outcome, plain, table
from understudy.app.performing import ready, staged
from understudy.app.reading import Reading, clip_from, inputs, stem

if TYPE_CHECKING:
    from understudy.tuning import Trial, Tuned

EXAMPLE = """\
  understudy tune sample:gesture --law paper --out out
  understudy tune sample:gesture --drive constrained --out out"""


@dataclass(frozen=True, kw_only=True)
class Options(Body, Searching, Reading):
    """Search for the servo stiffness that follows a clip best, by gradient.

    The error falls with stiffness to the floor the lag sets; a cost on torque puts the optimum
    where more stiffness no longer buys accuracy. Writes NAME_tuning.json, and NAME_tuning.png where
    matplotlib is installed.

    With --drive it searches the gains of the rigid-body drive of Wilke & Semwal 2017 instead, and
    writes NAME_LINKAGE_parameters.json, which other clips can use.

    Attributes:
        clip: A motion file, or sample:NAME.
        law: modern, or paper (Zordan & Hodgins 1999).
        torque_weight: Radians of error worth a torque of one body weight times height.
        low: Least stiffness tried [1/s^2].
        high: Greatest stiffness tried [1/s^2].
        survey: Trials of the first survey.
        out: Folder for the files.
        json: Print one JSON object.
    """

    clip: Positional[Annotated[str, arg(metavar="CLIP")]]
    law: Literal["modern", "paper"] = "modern"
    torque_weight: Annotated[float, arg(metavar="W")] = 1.0
    low: Annotated[float, arg(metavar="K")] = 10.0
    high: Annotated[float, arg(metavar="K")] = 1e5
    survey: Annotated[int, arg(metavar="N")] = 9
    out: Annotated[Path, arg(metavar="DIR")] = Path()
    json: bool = False


def run(options: Options) -> Outcome:
    """Search, and write the trials and their plot."""
    import understudy as us

    if options.drive is not None:
        return searched(options.clip, options, options, options.out)
    ready(options.out)
    clip = clip_from(options.clip, options)
    performance = us.tracked(clip, character_for(clip, options), law=options.law)
    tuned = us.tune(
        performance,
        torque_weight=options.torque_weight,
        bounds=(options.low, options.high),
        survey=options.survey,
        progress=True,
    )
    found = result(options, tuned)
    name = f"{stem(options.clip)}_tuning"
    with staged(options.out, name, keep=inputs([options.clip], options)) as (folder, files):
        text = json.dumps(plain(found), indent=2)
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
        plot(tuned, folder / f"{name}.png")
    return Outcome(result=found | {"files": files}, text=summary(options, tuned, files))


def result(options: Options, tuned: Tuned) -> dict[str, Any]:
    """A search as plain values."""
    return {
        "clip": options.clip,
        "best": asdict(tuned.best),
        "trials": [asdict(trial) for trial in tuned.trials],
        "settings": dict(tuned.settings),
        "units": {
            "stiffness": "1/s^2",
            "error": "rad, mean over joints and frames",
            "torque": "rms over joints and time, of body weight x height",
            "cost": "rad",
        },
    }


def summary(options: Options, tuned: Tuned, files: dict[str, str]) -> str:
    """The trials as a table, the best one, how to use it, and the files."""
    rows = [("stiffness 1/s^2", "mean error deg", "rms torque % BW x height", "cost deg")]
    rows += [
        (
            stiffness,
            f"{math.degrees(t.error):.3f}",
            f"{100 * t.torque:.3f}",
            f"{math.degrees(t.cost):.3f}",
        )
        for stiffness, t in distinct(tuned).items()
    ]
    best = f"{tuned.best.stiffness:.0f}"
    lines = [
        table(rows, right=range(4)),
        "",
        "mean error: angle between simulated and reference joints, mean over joints and frames",
        "(track prints its rms); cost: that plus the weighted torque.",
        "",
        f"best stiffness: {best} /s^2",
        f"use it: {use(options, best)}",
    ]
    return "\n".join([*lines, "", "files:", *(f"  {path}" for path in files.values())])


def distinct(tuned: Tuned) -> dict[str, Trial]:
    """The trial of least cost for every stiffness, rounded to three digits."""
    found: dict[str, Trial] = {}
    for trial in sorted(tuned.trials, key=lambda t: (t.stiffness, t.cost)):
        key = f"{float(f'{trial.stiffness:.3g}'):.0f}"
        if key not in found or trial.cost < found[key].cost:
            found[key] = trial
    return found


def use(options: Options, stiffness: str) -> str:
    """The command that performs the clip as it was tuned."""
    words = ["understudy", "track", options.clip]
    for name in (*Body.__dataclass_fields__, *Reading.__dataclass_fields__, "law"):
        value = getattr(options, name)
        if value != Options.__dataclass_fields__[name].default:
            words += [f"--{name.replace('_', '-')}", str(value)]
    return shlex.join([*words, "--stiffness", stiffness])


def plot(tuned: Tuned, path: Path) -> None:
    """Error, torque and their sum against stiffness, where matplotlib is installed."""
    import numpy as np

    from understudy.errors import MissingExtra
    from understudy.evaluate.chart import Chart, Series, write_chart

    trials = [t for t in tuned.trials if np.isfinite(t.cost)]
    stiffness = np.array([t.stiffness for t in trials])
    lines = {
        "mean error [deg]": np.degrees([t.error for t in trials]),
        "cost [deg]": np.degrees([t.cost for t in trials]),
        "rms torque [% of body weight (BW) x height]": 100.0 * np.array([t.torque for t in trials]),
    }
    chart = Chart(
        title=f"Stiffness for {tuned.settings['clip']}: best {tuned.best.stiffness:.0f} /s^2",
        caption="Cost: mean error plus the weighted torque; the best stiffness has the least.",
        x_label="Stiffness [1/s^2]",
        y_label="Angle [deg], torque [% BW x height]",
        series=tuple(Series(name=name, x=stiffness, y=y) for name, y in lines.items()),
        x_scale="log",
    )
    with contextlib.suppress(MissingExtra):
        write_chart(chart, path)
