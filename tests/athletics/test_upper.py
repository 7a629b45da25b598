"""A clip's upper body on a runner."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

import understudy as us
from understudy.athletics import upper
from understudy.athletics.course import Course
from understudy.athletics.upper import UpperBody
from understudy.character import athlete_man
from understudy.control import EngineState
from understudy.errors import InvalidValue
from understudy.evaluate import certificate
from understudy.evaluate.layered import layered
from understudy.performance import running, together
from understudy.simulate import prepared, simulate


@pytest.fixture(scope="module")
def run():
    """Two and a half seconds of running, as a clip."""
    return simulate(running(duration=2.5)).clip()


def test_a_runner_shows_a_gesture_and_runs_on():
    take = simulate(running(duration=5.0, upper=us.sample("gesture")))
    found = layered(take)
    assert take.qpos[:, 2].min() > 0.7 and take.qpos[-1, 0] > 15.0
    assert not found.stride
    assert found.joint_error_deg < 2.0 and found.hands_mm < 40.0
    assert found.arms_reach_deg < 1.0
    assert set(found.joints_deg) > {"neck", "left_elbow", "right_wrist"}
    assert "upper_back" not in found.joints_deg
    assert take.facts["upper"] == "gesture"
    (who,) = certificate(take)["characters"]
    assert who["upper_body"] == found.as_dict()


def test_the_legs_are_the_controllers_until_the_clip_begins():
    plain = simulate(running(duration=0.4))
    with_arms = simulate(running(duration=0.4, upper=us.sample("gesture")))
    assert np.array_equal(plain.qpos, with_arms.qpos)


def test_the_runners_own_arms_come_back_after_the_clip():
    clip = us.sample("gesture").trimmed(0.0, 1.0)
    take = simulate(running(duration=4.0, upper=clip))
    plain = simulate(running(duration=4.0))
    swung = [np.ptp(one.qpos[3000:, 7 + 6]) for one in (take, plain)]
    assert swung[0] == pytest.approx(swung[1], abs=0.1)


def test_a_run_goes_with_the_stride(run):
    layer = UpperBody(clip=run)
    assert layer.locked and len(layer.strides) >= 3
    take = simulate(running(duration=6.0, upper=layer, course=Course.steady(3.0)))
    found = layered(take)
    assert found.stride and found.joint_error_deg < 3.0
    # Each arm swings with the opposite leg, as in the clip.
    late = take.qpos[3000:, 7:]
    for arm, hip in ((6, 25), (12, 19)):
        assert np.corrcoef(late[:, arm], late[:, hip])[0, 1] > 0.6


def test_the_share_of_a_stride_closes_on_the_thighs():
    p, m = np.zeros(upper.U_TABLE), np.array([0.4, 0.9, -1.0, 0.0])
    p[upper.U_DT] = 0.001
    shares = []
    for step in range(6000):
        time = 0.001 * step
        upper.strode(time, 0.6 * np.sin(2.0 * np.pi * time / 0.7), p, m)
        shares.append(m[upper.SHARE])
    passed = 0.7 * np.arcsin(0.1 / 0.6) / (2.0 * np.pi)
    wanted = (6.0 - 0.001 - passed) / 0.7
    assert m[upper.PERIOD] == pytest.approx(0.7, abs=0.005)
    off = (shares[-1] - wanted + 0.5) % 1.0 - 0.5
    assert off == pytest.approx(0.0, abs=0.01)


def test_a_repeated_clip_has_no_seam(run):
    gesture = us.sample("gesture")
    for layer in (UpperBody(clip=gesture, loop=True), UpperBody(clip=run)):
        table, _ = layer.table(athlete_man())
        assert table[-1] == pytest.approx(table[0], abs=1e-9)
        assert np.abs(np.diff(table, axis=0)).max() < 0.2


def test_the_law_is_the_same_compiled():
    whole = running(duration=0.9, upper=us.sample("gesture"))
    model, data = prepared(whole)
    laws = [c.feedback(whole.scene, model) for c in whole.controllers]  # type: ignore[union-attr]
    state = EngineState.of(data)
    for step in range(whole.steps):
        mujoco.mj_step1(model, data)
        for law, parameters, memory in laws:
            law(0.001 * step, state, data.ctrl, data.qfrc_applied, parameters, memory)
        mujoco.mj_step2(model, data)
    assert simulate(whole).qpos[-1] == pytest.approx(data.qpos, abs=1e-6)


def test_each_of_two_has_an_upper_body_of_its_own():
    course = Course.steady(3.5)
    whole = together(
        running(duration=1.5, course=course),
        running(duration=1.5, course=course.beside(1.22), upper=us.sample("gesture")),
    )
    take = simulate(whole)
    assert layered(take, character=1).seconds > 0.4
    with pytest.raises(InvalidValue, match="no clip"):
        layered(take)


def test_what_cannot_be_laid_on_is_refused():
    gesture = us.sample("gesture")
    with pytest.raises(InvalidValue, match="no whole stride"):
        UpperBody(clip=gesture, stride=True)
    with pytest.raises(InvalidValue, match="lean"):
        UpperBody(clip=gesture, lean=1.5)
    with pytest.raises(InvalidValue, match="turn"):
        UpperBody(clip=gesture, turn=-0.1)
    with pytest.raises(InvalidValue, match="begin"):
        replace(UpperBody(clip=gesture), begin=-1.0)


@pytest.mark.clips
@pytest.mark.parametrize("name", ["02_05", "02_03", "35_17"])
def test_a_captured_upper_body_is_carried(clips, name):
    (file, *_) = sorted(clips.rglob(f"{name}.bvh"))
    take = simulate(running(duration=5.0, upper=us.read(file)))
    found = layered(take)
    assert take.qpos[:, 2].min() > 0.7
    assert found.stride == (name != "02_05")
    assert found.joint_error_deg < 3.0 and found.arms_reach_deg < 1.0
