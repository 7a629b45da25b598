"""Training: scenarios by chance, the search's space, checkpoints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from understudy.athletics.gains import NAMES, Schedule, shipped
from understudy.character import athlete_man
from understudy.errors import UnderstudyError
from understudy.training import BOUNDS, Space, cost_of, rehearsed, train
from understudy.training.scenarios import first_scenarios, scenarios


def test_every_gain_has_bounds():
    assert set(BOUNDS) == set(NAMES)


def test_numbers_and_gains_go_over_into_each_other():
    space = Space(shipped())
    numbers = space.numbers(shipped())
    again = space.numbers(space.schedule(numbers))
    assert again == pytest.approx(numbers, abs=1e-12)


def test_gains_that_are_not_searched_stay():
    space = Space(shipped(), ["pitch"])
    found = space.schedule(np.array([0.0, 0.5]))
    assert found.gains.knee_rest == shipped().gains.knee_rest
    assert found.gains.pitch == BOUNDS["pitch"][0]


def test_one_seed_gives_the_same_scenarios():
    a, b = (scenarios(np.random.default_rng(3)) for _ in range(2))
    assert [s.friction for s in a] == [s.friction for s in b]
    assert {s.name for s in a} == {
        *("slow", "middle", "fast", "changing", "long", "pushed", "pushed aside")
    }
    assert {s.name for s in first_scenarios(np.random.default_rng(3))} == {"slow", "middle", "fast"}


def test_hardness_is_of_turns_pushes_and_ground():
    easy, hard = (scenarios(np.random.default_rng(3), hardness=h) for h in (0.5, 1.0))
    for one, other in zip(easy, hard, strict=True):
        assert 1.0 - one.friction == pytest.approx(0.5 * (1.0 - other.friction))
        assert one.course.headings == pytest.approx(0.5 * other.course.headings)
    assert np.linalg.norm(easy[-1].push) == pytest.approx(0.5 * np.linalg.norm(hard[-1].push))


def test_a_fall_costs_more_than_any_gait():
    body = athlete_man()
    run = scenarios(np.random.default_rng(3), hardness=0.0)[1]
    seen, _ = rehearsed(run, shipped(), body)
    limp = replace(shipped(), gains=replace(shipped().gains, knee_stiffness=0.0), starts=())
    fallen, _ = rehearsed(run, limp, body)
    assert fallen["fell"]
    assert cost_of(fallen, run.duration) > 10.0 > cost_of(seen, run.duration)


def test_a_search_goes_on_from_its_checkpoint(tmp_path):
    file = tmp_path / "search.json"
    given = {"names": ["pitch", "waist_lean"], "population": 4, "seed": 2, "checkpoint": file}
    first = train(Schedule(), evaluations=4, **given)
    again = train(Schedule(), evaluations=8, **given)
    assert len(first.history) == 1
    assert len(again.history) == 2
    assert again.history[0] == pytest.approx(first.history[0])
    with pytest.raises(UnderstudyError, match="another search"):
        train(Schedule(), evaluations=4, **given | {"seed": 3})
