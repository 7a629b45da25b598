"""Figures 1 and 5: a runner, a group, and a person beside the runner."""

from __future__ import annotations

import numpy as np

from understudy.athletics.course import Course
from understudy.character import athlete_man, athlete_woman
from understudy.papers.filmstrip import Film
from understudy.papers.finding import Claim, Finding, Strip
from understudy.papers.hodgins1995 import published as paper
from understudy.papers.hodgins1995.runs import Captured, steady
from understudy.performance import running, together
from understudy.simulate import simulate
from understudy.take import Take

_LANE = 1.22
_GROUP = 4


def _times(first: float, spacing: float, count: int) -> tuple[float, ...]:
    return tuple(float(first + spacing * k) for k in range(count))


def running_pictures(captured: tuple[Captured, ...] = (), *, quick: bool = False) -> Finding:
    """Rows of pictures with the paper's spacing."""
    one, group = simulate(steady(3.5, 4.0)), _group(quick)
    count = 4 if quick else 12
    films = [
        Film(
            title=f"A runner at 3.5 m/s, every {paper.RUNNER_SPACING:g} s",
            thing=one,
            times=_times(2.0, paper.RUNNER_SPACING, count),
            view="follow-side",
        )
    ]
    if captured:
        person = min(captured, key=lambda run: abs(run.gait.speed - 3.5))
        last = person.clip.duration - paper.RUNNER_SPACING * (count - 1)
        first = person.gait.cycles[0].start_s if person.gait.cycles else 0.0
        films.append(
            Film(
                title=f"A person, {person.name}, at {person.gait.speed:.1f} m/s",
                thing=person.clip,
                times=_times(max(0.0, min(first, last)), paper.RUNNER_SPACING, count),
                view="follow-side",
            )
        )
    pelvises = [group.qpos[:, part.qpos.start + 2] for part in group.scene.parts]
    stood = sum(bool(height.min() > 0.6) for height in pelvises)
    crowd = Film(
        title=f"{len(pelvises)} runners in lanes, every {paper.GROUP_SPACING:g} s",
        thing=group,
        times=_times(0.5, paper.GROUP_SPACING, 2 if quick else 6),
        view="follow",
    )
    return Finding(
        figure="1 and 5",
        title="Runners",
        setting="Side by side as in the paper; a captured run is shown where a folder with one "
        "is given.",
        claims=(
            Claim(
                said="A group of runners runs in one scene.",
                measured=f"{stood} of {len(pelvises)}, men and women, run {group.duration:g} s "
                "without a fall",
                holds=stood == len(pelvises),
            ),
        ),
        strips=(
            Strip(alt="A runner and a person from the side.", films=tuple(films)),
            Strip(alt="A group of runners.", films=(crowd,)),
        ),
    )


def _group(quick: bool) -> Take:
    """Men and women at speeds of their own."""
    asked = np.linspace(3.2, 3.8, 2 if quick else _GROUP)
    alone = []
    for k, speed in enumerate(asked):
        body = athlete_man() if k % 2 == 0 else athlete_woman()
        course = Course.steady(float(speed)).beside(_LANE * k)
        alone.append(running(body, course, duration=1.5 if quick else 4.0))
    return simulate(together(*alone))
