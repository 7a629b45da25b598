"""Searches for the drive's parameters."""

from __future__ import annotations

import json

import numpy as np
import pytest

from understudy.character import Linkage
from understudy.drive_tuning import (
    read_parameters,
    transferred,
    tune_drive,
    write_parameters,
)
from understudy.drive_tuning import search as drive_tuning
from understudy.errors import InvalidValue, UnderstudyError
from understudy.fidelity import drive_error
from understudy.motion.samples import sample
from understudy.performance import driven
from understudy.simulate import simulate


@pytest.fixture(scope="module")
def clip():
    return sample("gesture").trimmed(0.5, 2.0)


@pytest.fixture(scope="module")
def linkage(clip):
    return Linkage.from_clip(clip, "independent")


@pytest.fixture(scope="module")
def walked(clip, linkage):
    return tune_drive(clip, linkage, points=8, threads=2)


def test_algorithm_1_tries_every_order_at_every_point(walked):
    orders = [t.order for t in walked.trials]
    assert orders == list(range(3, 20, 2)) * 8
    assert (walked.trials[0].gain, walked.trials[0].speed) == (100.0, pytest.approx(75.0))


def test_the_walk_moves_by_at_most_one_a_simulation(walked):
    gains = np.array([t.gain for t in walked.trials])
    speeds = np.array([t.speed for t in walked.trials])
    assert 0 < np.abs(np.diff(gains)).max() <= 1.0
    assert 0 < np.abs(np.diff(speeds)).max() <= 1.0


def test_the_walk_never_leaves_the_stable_gains():
    for seed in range(5):
        points = drive_tuning._walk((119.0, 75.0), 2000, 19, 60.0, 1.4286, (seed, 0))
        gains = np.array([gain for gain, _, _ in points])
        assert gains.min() >= 1.0
        assert gains.max() / 60.0 < 2.0
        assert np.abs(np.diff(gains)).max() <= 1.0


def test_the_best_trial_is_the_least_error(walked):
    assert walked.best.error == min(t.error for t in walked.trials)


@pytest.mark.parametrize("method", ["monte_carlo", "cma"])
def test_one_thread_and_two_give_the_same_numbers(clip, linkage, method):
    settings = {"method": method, "points": 2, "evaluations": 20, "seed": 3}
    one = tune_drive(clip, linkage, threads=1, **settings)
    two = tune_drive(clip, linkage, threads=2, **settings)
    assert one.trials == two.trials


def test_another_seed_takes_another_walk(clip, linkage, walked):
    other = tune_drive(clip, linkage, points=8, seed=1, max_order=3)
    assert other.trials[1].gain != walked.trials[1].gain


def test_a_run_begins_at_the_best_of_the_one_before(clip, linkage):
    found = tune_drive(clip, linkage, points=6, runs=2, max_order=5)
    first, second = found.trials[:12], found.trials[12:]
    best = min(first, key=lambda t: t.error)
    assert (second[0].gain, second[0].speed) == (best.gain, best.speed)


def test_cma_needs_a_tenth_of_the_simulations(clip, walked):
    linkage = Linkage.from_clip(clip, "skeleton")
    walk = tune_drive(clip, linkage, points=40)
    found = tune_drive(clip, linkage, method="cma", evaluations=36)
    count = found.simulations_to(walk.best.error)
    assert count is not None and count <= len(walk.trials) / 10


def test_cma_leaves_numpys_own_generator_alone(clip, linkage):
    before = np.random.get_state()[1].copy()  # noqa: NPY002 - the one that must stay as it is
    tune_drive(clip, linkage, method="cma", evaluations=8)
    assert (np.random.get_state()[1] == before).all()  # noqa: NPY002


@pytest.mark.parametrize("method", ["monte_carlo", "cma"])
def test_a_stopped_search_goes_on_to_the_same_result(clip, linkage, tmp_path, monkeypatch, method):
    path = tmp_path / "search.json"
    settings = {"method": method, "points": 3, "evaluations": 24, "seed": 5}
    whole = tune_drive(clip, linkage, **settings)
    ran = []
    once = drive_tuning._Search._run

    def stopping(self, point):
        if len(ran) == 10:
            raise KeyboardInterrupt
        ran.append(point)
        return once(self, point)

    monkeypatch.setattr(drive_tuning, "_CHUNK", 4)
    monkeypatch.setattr(drive_tuning._Search, "_run", stopping)
    with pytest.raises(KeyboardInterrupt):
        tune_drive(clip, linkage, checkpoint=path, threads=1, **settings)
    kept = len(json.loads(path.read_text())["trials"])
    assert kept >= 7
    ran.clear()
    monkeypatch.setattr(
        drive_tuning._Search, "_run", lambda self, p: (ran.append(p), once(self, p))[1]
    )
    resumed = tune_drive(clip, linkage, checkpoint=path, **settings)
    assert resumed.trials == whole.trials
    assert len(ran) == len(whole.trials) - kept


def test_a_checkpoint_of_another_search_is_refused(clip, linkage, tmp_path):
    path = tmp_path / "search.json"
    tune_drive(clip, linkage, points=1, max_order=3, checkpoint=path)
    with pytest.raises(UnderstudyError, match="another search"):
        tune_drive(clip, linkage, points=1, max_order=3, scale=1.0, checkpoint=path)
    path.write_text("{}")
    with pytest.raises(UnderstudyError, match="not a checkpoint"):
        tune_drive(clip, linkage, points=1, max_order=3, checkpoint=path)


def test_saved_parameters_reproduce_the_error_and_work_on_other_clips(
    clip, linkage, walked, tmp_path
):
    path = tmp_path / "best.json"
    write_parameters(walked, path)
    kept = read_parameters(path)
    assert kept == walked.parameters
    assert drive_error(simulate(driven(clip, linkage, **kept))).mean == walked.best.error
    other = sample("walk").trimmed(0.0, 1.0)
    take = simulate(driven(other, Linkage.from_clip(other, "skeleton"), **kept))
    assert np.isfinite(drive_error(take).mean)
    path.write_text("[]")
    with pytest.raises(UnderstudyError, match="no drive parameters"):
        read_parameters(path)


def test_the_transfer_table_holds_every_clip_and_linkage(clip, walked):
    other = sample("walk").trimmed(0.0, 1.0)
    kinds = ("independent", "constrained")
    rows = transferred([clip, other], dict.fromkeys(kinds, walked.parameters))
    assert [(r.clip, r.kind) for r in rows] == [(c.name, k) for c in (clip, other) for k in kinds]
    assert rows[0].error == walked.best.error
    assert rows[2].travel > rows[0].travel
    assert all(np.isfinite(r.error) for r in rows)


def test_gains_beyond_the_step_are_refused_before_running(clip, linkage):
    with pytest.raises(InvalidValue, match="K_f dt"):
        tune_drive(clip, linkage, start=(125.0, 75.0))


def test_senseless_searches_are_refused(clip, linkage):
    with pytest.raises(InvalidValue, match="method"):
        tune_drive(clip, linkage, method="grid")
    with pytest.raises(InvalidValue, match="points"):
        tune_drive(clip, linkage, points=0)
    with pytest.raises(InvalidValue, match="max_order"):
        tune_drive(clip, linkage, max_order=4)
    with pytest.raises(InvalidValue, match="start"):
        tune_drive(clip, linkage, start=(-1.0, 75.0))


def test_the_error_is_told_with_what_it_depends_on(walked):
    said = str(walked)
    for word in ("K_f", "K_vc", "1 unit", "gravity 9.81", "scale 1.4286", "16.67 ms"):
        assert word in said
