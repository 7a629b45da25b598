"""The stiffness search."""

from __future__ import annotations

import json

import numpy as np
import pytest

from understudy import tuning
from understudy.character import Character
from understudy.errors import InvalidValue, UnderstudyError
from understudy.motion.samples import sample
from understudy.performance import tracked
from understudy.simulate import simulate
from understudy.tuning import servo_torques, tune


@pytest.fixture(scope="module")
def performance():
    clip = sample("gesture").trimmed(0.5, 1.5)
    return tracked(clip, Character.from_clip(clip, plan="upper"), law="paper")


def test_the_search_finds_the_bottom_of_what_it_weighs(performance):
    found = tune(performance, survey=7)
    costs = [t.cost for t in found.trials]
    assert found.best.cost == min(costs)
    low, high = found.settings["bounds"]
    assert low < found.best.stiffness < high
    finer = tune(performance, survey=41, iterations=0)
    assert found.best.cost <= finer.best.cost * 1.001


def test_error_falls_and_torque_rises_with_stiffness(performance):
    trials = tune(performance, survey=5, iterations=0, bounds=(30.0, 3e4)).trials
    errors = [t.error for t in trials]
    assert errors == sorted(errors, reverse=True)
    assert trials[-1].torque > trials[0].torque


def test_without_a_torque_cost_the_search_runs_to_its_bound(performance):
    found = tune(performance, survey=5, torque_weight=0.0, bounds=(30.0, 3e4))
    assert found.best.stiffness == pytest.approx(3e4, rel=0.01)


def test_a_stopped_search_goes_on_from_its_checkpoint(performance, tmp_path, monkeypatch):
    path = tmp_path / "tune.json"
    first = tune(performance, survey=4, iterations=1, checkpoint=path)
    kept = json.loads(path.read_text())
    assert len(kept["trials"]) == len(first.trials)
    runs = []
    many = tuning.simulate_many
    monkeypatch.setattr(tuning, "simulate_many", lambda p, **k: runs.append(len(p)) or many(p, **k))
    again = tune(performance, survey=4, iterations=1, checkpoint=path)
    assert sum(runs) == 0
    assert again.best == first.best


def test_a_checkpoint_of_another_search_is_refused(performance, tmp_path):
    path = tmp_path / "tune.json"
    tune(performance, survey=2, iterations=0, checkpoint=path)
    with pytest.raises(UnderstudyError, match="another search"):
        tune(performance, survey=2, iterations=0, torque_weight=2.0, checkpoint=path)
    path.write_text("{")
    with pytest.raises(UnderstudyError, match="not a tuning checkpoint"):
        tune(performance, survey=2, iterations=0, checkpoint=path)


def test_servo_torques_are_what_the_engine_applied(performance):
    import mujoco

    take = simulate(performance)
    torque = servo_torques(take)
    data = mujoco.MjData(take.model)
    part = take.scene.parts[0]
    for frame in range(0, take.frames, 37):
        data.qpos[:], data.qvel[:] = take.qpos[frame], take.qvel[frame]
        data.ctrl[:] = take.ctrl[frame]
        mujoco.mj_forward(take.model, data)
        applied = data.qfrc_actuator[part.dofs][6:].reshape(-1, 3)
        np.testing.assert_allclose(torque[frame], applied, atol=1e-9)


def test_senseless_searches_are_refused(performance):
    with pytest.raises(InvalidValue, match="bounds"):
        tune(performance, bounds=(5.0, 1.0))
    with pytest.raises(InvalidValue, match="survey"):
        tune(performance, survey=1)
