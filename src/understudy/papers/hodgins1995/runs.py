"""Runs that the figures are made of, and captured runs beside them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from understudy.athletics.course import Course
from understudy.athletics.running import Running
from understudy.athletics.running_judge import Judge, report
from understudy.athletics.upper import UpperBody
from understudy.character import Athlete, athlete_man
from understudy.errors import ClipError, UnderstudyError
from understudy.evaluate.gait import Gait, gait_of
from understudy.motion.clip import Clip
from understudy.motion.read import read
from understudy.performance import Performance, running
from understudy.simulate.trials import judged

# Captured runs, in three speeds.
CAPTURED = ("02_03", "35_17", "127_03")
# Steps before this do not count [s].
SETTLED = 3.0


@dataclass(frozen=True, kw_only=True)
class Captured:
    """A captured run.

    Attributes:
        name: Of its file.
        clip: The motion.
        gait: What was measured in it.
    """

    name: str
    clip: Clip = field(repr=False)
    gait: Gait = field(repr=False)


def captured_runs(folder: Path | None) -> tuple[Captured, ...]:
    """The captured runs in a folder and below it; none without a folder.

    Raises:
        ClipError: No such folder.
    """
    if folder is None:
        return ()
    if not folder.is_dir():
        raise ClipError(str(folder), "no such folder.")
    found = []
    for name in CAPTURED:
        paths = [path for end in ("bvh", "amc") for path in sorted(folder.rglob(f"{name}.{end}"))]
        for path in paths:
            try:
                clip = read(path).renamed(name)
                found.append(Captured(name=name, clip=clip, gait=gait_of(clip)))
                break
            except UnderstudyError:
                continue
    return tuple(found)


def steady(speed: float, seconds: float) -> Performance:
    """A man at one speed."""
    return running(athlete_man(), Course.steady(speed), duration=seconds)


def seen(performance: Performance, *, begin: float = SETTLED) -> dict[str, float]:
    """What the judge of the runner says of a run: means by name, and whether it fell and when."""
    (runner, *_) = performance.controllers
    assert isinstance(runner, Running)
    return report(judged(performance, Judge(running=runner, begin=begin))[0])


def changed(performance: Performance, **gains: float) -> Performance:
    """The same run with other values of some gains, at every speed."""
    (runner, *rest) = performance.controllers
    assert isinstance(runner, Running)
    schedule = runner.schedule
    slopes = {name: slope for name, slope in schedule.slopes.items() if name not in gains}
    other: Any = replace(schedule, gains=replace(schedule.gains, **gains), slopes=slopes)
    return replace(performance, controllers=(replace(runner, schedule=other), *rest))


def armless(duration: float, *, body: Athlete | None = None, speed: float = 3.5) -> Performance:
    """A run whose arms hang still at the sides from half a second on, the waist straight."""
    body = athlete_man() if body is None else body
    state = np.zeros((11, body.widths[0]))
    state[:, 3] = 1.0
    hanging = Clip(
        skeleton=body.skeleton,
        rotations=body.local_rotations(state),
        root_positions=np.tile(body.links[0].offset, (11, 1)),
        rate=10.0,
        name="arms at the sides",
    )
    upper = UpperBody(clip=hanging, loop=True, stride=False)
    return running(body, Course.steady(speed), duration=duration, upper=upper)
