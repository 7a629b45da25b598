"""An athlete that stands, starts and stops."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from understudy.athletics import running_law as law
from understudy.athletics import standing_law as stand
from understudy.athletics.course import COURSE_MEMORY, Course
from understudy.athletics.gains import NAMES
from understudy.athletics.running import Running
from understudy.athletics.standing import at_rest, tallest
from understudy.athletics.standing_gains import (
    STANDING_NAMES,
    StandingGains,
    StandingSchedule,
    shipped_standing,
)
from understudy.athletics.standing_judge import (
    COLUMNS,
    Recorder,
    Samples,
    onsets,
    smoothed,
    start_and_stop,
)
from understudy.character import athlete_man, athlete_woman
from understudy.control import EngineState, Push
from understudy.control.compiling import compiled_law
from understudy.errors import InvalidValue, UnknownName
from understudy.performance import running
from understudy.scene import Scene
from understudy.simulate import prepared, simulate
from understudy.simulate.trials import judged


def _course(*rows):
    times, speeds = np.array(rows).T
    return Course(times=times, speeds=speeds, headings=np.zeros(len(rows)))


_START = _course((0.0, 0.0), (0.3, 0.0), (0.31, 3.0))
_STOP = _course((0.0, 3.5), (1.0, 3.5), (1.01, 0.0))


def _seen(course, duration, **given):
    whole = running(given.pop("body", None), course, duration=duration, **given)
    (runner, *_) = whole.controllers
    memory, _ = judged(whole, Recorder(running=runner, seconds=duration))  # type: ignore[arg-type]
    return Samples.of(memory)


def test_it_stands_for_ten_seconds_without_moving():
    seen = _seen(Course.steady(0.0), 10.0)
    assert not seen.fell
    assert seen.speed[200:].max() < 0.02
    assert np.abs(seen["pitch"]).max() < 0.02
    assert np.ptp(seen["z"]) < 0.01
    assert np.ptp(seen["left_x"]) < 0.02


def test_a_woman_stands_as_well():
    seen = _seen(Course.steady(0.0), 3.0, body=athlete_woman())
    assert not seen.fell
    assert seen.speed[200:].max() < 0.02


@pytest.mark.parametrize("impulse", [(8.0, 0.0, 0.0), (-6.0, 0.0, 0.0), (0.0, 8.0, 0.0)])
def test_small_pushes_are_withstood_without_a_step(impulse):
    seen = _seen(Course.steady(0.0), 4.0, disturbances=[Push(time=1.0, impulse=impulse)])
    assert not seen.fell
    assert np.ptp(seen["left_x"]) < 0.03
    assert seen.speed[-50:].max() < 0.05


def test_a_start_reaches_its_speed():
    seen = _seen(_START, 6.0)
    assert not seen.fell
    found = start_and_stop(seen, _START)
    assert found["start_s"] is not None and found["start_s"] < 5.0
    assert found["stop_s"] is None
    assert smoothed(seen.speed)[-100:].mean() == pytest.approx(3.0, rel=0.1)


def test_a_stop_ends_in_quiet_standing():
    seen = _seen(_STOP, 7.0)
    assert not seen.fell
    found = start_and_stop(seen, _STOP)
    assert found["stop_s"] is not None and found["stop_s"] < 5.0
    assert (found["residual_speed_m_s"] or 0.0) < 0.05
    assert abs(seen["left_x"][-1] - seen["right_x"][-1]) < 0.1
    assert 0.1 < abs(seen["left_y"][-1] - seen["right_y"][-1]) < 0.4


@pytest.mark.parametrize(
    ("course", "seconds", "shown"),
    [
        (_course((0.0, 0.0), (0.05, 0.0), (0.06, 3.0)), 1.1, {stand.LEANING, stand.PUSHING}),
        (_course((0.0, 0.0), (0.01, 0.0)), 0.7, {stand.STANDING, stand.STEPPING}),
    ],
)
def test_the_law_is_the_same_compiled(course, seconds, shown):
    shove = Push(time=0.1, impulse=(40.0, 0.0, 0.0))
    steps_on = stand.STEPPING in shown
    whole = running(course=course, duration=seconds, disturbances=[shove] if steps_on else [])
    model, data = prepared(whole)
    pushes = simulate(whole).xfrc_applied
    runner = whole.controllers[0]
    assert isinstance(runner, Running)
    function, parameters, memory = runner.feedback(whole.scene, model)
    assert function is stand.athlete
    state, memory = EngineState.of(data), np.array(memory)
    fast, modes = compiled_law(function), set()
    for step in range(whole.steps):
        mujoco.mj_step1(model, data)
        other, torques, data.ctrl[:] = memory.copy(), np.zeros(model.nu), 0.0
        fast(step * 0.001, state, torques, data.qfrc_applied, parameters, other)
        function(step * 0.001, state, data.ctrl, data.qfrc_applied, parameters, memory)
        assert torques == pytest.approx(data.ctrl, rel=1e-6, abs=1e-6)
        assert other == pytest.approx(memory, abs=1e-9)
        data.xfrc_applied[:] = pushes[step]
        mujoco.mj_step2(model, data)
        modes.add(int(memory[stand.MODE]))
    assert shown <= modes


def test_a_course_without_standing_runs_the_runners_law():
    whole = running(course=Course.steady(3.5), duration=0.1)
    model, _ = prepared(whole)
    (runner,) = whole.controllers
    assert isinstance(runner, Running)
    assert runner.feedback(whole.scene, model)[0] is law.runner


@pytest.mark.parametrize("body", [athlete_man(), athlete_woman()])
def test_it_begins_on_its_soles_under_its_center_of_mass(body):
    qpos, qvel = at_rest(body, StandingGains())
    model = Scene(characters=(body,), timestep=0.001).model
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    assert not qvel.any()
    height = data.subtree_com[1, 2]
    assert height == pytest.approx(StandingGains().straight * tallest(body), abs=0.004)
    heel, ball = data.site("left_heel").xpos[0], data.site("left_ball").xpos[0]
    assert heel < data.subtree_com[1, 0] < ball


def test_the_tallest_height_is_that_of_the_engine():
    for body in (athlete_man(), athlete_woman()):
        model = body.spec().compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        ankle = data.xpos[1 + body.index("left_ankle"), 2]
        assert tallest(body) == pytest.approx(data.subtree_com[1, 2] - ankle - body.sole_height)


def test_it_begins_where_its_course_does():
    course = Course.along([(2.0, 1.0), (2.0, 30.0)], 0.0)
    whole = running(course=course, duration=0.1)
    _, data = prepared(whole)
    assert data.qpos[:2] == pytest.approx([2.0, 1.0])
    assert data.qpos[3:7] == pytest.approx([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])


def test_onsets_are_read_from_a_course():
    assert onsets(Course.steady(3.0)) == (None, None)
    start, stop = onsets(_START)[0], onsets(_STOP)[1]
    assert start == pytest.approx(0.31, abs=0.02)
    assert stop == pytest.approx(1.01, abs=0.02)


def test_a_made_up_start_and_stop_are_measured_right():
    times = np.arange(0.0, 10.0, 0.01)
    speed = np.clip((times - 1.0) * 2.0, 0.0, 3.0) - np.clip((times - 6.0) * 2.0, 0.0, 3.0)
    rows = np.zeros((len(times), len(COLUMNS)))
    rows[:, COLUMNS.index("east")] = speed
    course = _course((0.0, 0.0), (1.0, 0.0), (1.01, 3.0), (6.0, 3.0), (6.01, 0.0))
    found = start_and_stop(Samples(fell=False, seconds=10.0, rows=rows), course)
    assert found["start_s"] == pytest.approx(1.45, abs=0.05)
    assert found["start_m"] == pytest.approx(1.45**2, rel=0.08)
    assert found["stop_s"] == pytest.approx(1.48, abs=0.03)
    assert found["stop_m"] == pytest.approx(2.25, rel=0.03)
    assert found["residual_speed_m_s"] == 0.0


def test_gains_keep_the_order_the_laws_read_them_in():
    from understudy.athletics import support_law

    for k, name in enumerate(STANDING_NAMES):
        assert getattr(support_law, name.upper()) == support_law.PULL + k
    assert support_law.PULL + len(STANDING_NAMES) == law.P_COURSE


def test_gains_go_through_json():
    given = StandingSchedule(gains=StandingGains(pull=2.0), slow={"pitch": 0.1})
    assert StandingSchedule.from_json(given.as_json()) == given
    assert shipped_standing().row().shape == (len(NAMES),)


def test_gains_that_are_no_numbers_or_no_gains_are_refused():
    with pytest.raises(InvalidValue, match="pull"):
        StandingGains(pull=float("nan"))
    with pytest.raises(UnknownName, match="pitch"):
        StandingSchedule(slow={"pich": 0.1})


def test_a_slow_step_has_slopes_of_its_own():
    runner = Running(standing=StandingSchedule(slow={"pitch": 0.1}))
    scene = Scene(characters=(athlete_man(),), timestep=0.001)
    parameters = runner.feedback(scene, scene.model)[1]
    memory = np.zeros(law.M_COURSE + COURSE_MEMORY)
    pitch = []
    for speed in (2.5, 1.5, 4.0):
        law.scheduled(parameters, memory, speed)
        pitch.append(memory[law.M_GAINS + law.PITCH])
    schedule = runner.schedule
    assert pitch[0] == pytest.approx(schedule.at(2.5).pitch)
    assert pitch[1] == pytest.approx(schedule.at(2.5).pitch + 0.1)
    assert pitch[2] == pytest.approx(schedule.at(4.0).pitch)
