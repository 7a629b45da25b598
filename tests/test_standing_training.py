"""Training of starts and stops: outings by chance, the search's space, costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from understudy.athletics.gains import NAMES, shipped
from understudy.athletics.standing_gains import STANDING_NAMES, shipped_standing
from understudy.athletics.standing_judge import COLUMNS, Samples
from understudy.errors import UnknownName
from understudy.standing_training import (
    BOUNDS,
    SLOPES,
    Outing,
    StandingSpace,
    cost_of,
    outings,
    train_standing,
)


def test_bounds_are_of_gains_there_are():
    assert set(BOUNDS["start"]) | set(BOUNDS["stop"]) <= set(STANDING_NAMES)
    assert not set(BOUNDS["start"]) & set(BOUNDS["stop"])
    assert set(SLOPES) <= set(NAMES)


@pytest.mark.parametrize("part", ["start", "stop"])
def test_numbers_and_gains_go_over_into_each_other(part):
    space = StandingSpace(part, shipped_standing())
    numbers = space.numbers(shipped_standing())
    again = space.numbers(space.schedule(numbers))
    assert again == pytest.approx(numbers, abs=1e-12)


def test_gains_of_the_other_part_stay():
    space = StandingSpace("stop", shipped_standing())
    found = space.schedule(np.zeros(len(space.keys)))
    assert found.slow == shipped_standing().slow
    assert found.gains.lean_time == shipped_standing().gains.lean_time
    assert found.gains.step_time == BOUNDS["stop"]["step_time"][0]
    with pytest.raises(UnknownName, match="step_time"):
        StandingSpace("stop", shipped_standing(), ["step_tme"])


def test_one_seed_gives_the_same_outings():
    a, b = (outings("stop", np.random.default_rng(3)) for _ in range(2))
    assert a == b
    assert [run.speed for run in a] == sorted(run.speed for run in a)
    assert all(run.course.stands and run.seconds > run.change for run in a)


def _stopping(outing, deceleration):
    times = np.arange(0.0, outing.seconds, 0.01)
    rows = np.zeros((len(times), len(COLUMNS)))
    slower = deceleration * (times - outing.change - 0.15)
    rows[:, COLUMNS.index("east")] = outing.speed - np.clip(slower, 0.0, outing.speed)
    rows[:, COLUMNS.index("z")] = 0.96
    rows[:, COLUMNS.index("left_y")] = 0.17
    return Samples(fell=False, seconds=outing.seconds, rows=rows)


def test_a_stop_as_people_do_it_costs_least_and_a_fall_most():
    outing = Outing(part="stop", speed=3.0)
    good, slow = _stopping(outing, 1.8), _stopping(outing, 0.9)
    half = len(good.rows) // 2
    fallen = Samples(fell=True, seconds=0.5 * outing.seconds, rows=good.rows[:half])
    assert cost_of(outing, good) < 0.3
    assert cost_of(outing, good) < cost_of(outing, slow) < cost_of(outing, fallen)
    limp = replace(good, rows=np.full_like(good.rows, np.nan))
    assert cost_of(outing, limp) > cost_of(outing, fallen)


def test_a_search_is_the_same_on_one_thread_and_two():
    given = {"names": ["step_time", "pull"], "population": 2, "evaluations": 2, "seed": 4}
    one, two = (
        train_standing("stop", shipped_standing(), shipped(), threads=threads, **given)
        for threads in (1, 2)
    )
    assert one == two
    assert one.history == two.history
