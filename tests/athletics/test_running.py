"""A runner: it stays up, its states follow each other, and the law is the same compiled."""

from __future__ import annotations

from itertools import pairwise

import mujoco
import numpy as np
import pytest

from understudy.athletics import running_judge
from understudy.athletics import running_law as law
from understudy.athletics.course import Course
from understudy.athletics.gains import NAMES, Gains, Schedule, shipped
from understudy.athletics.running import Running
from understudy.athletics.running_judge import SUMS, Judge, report
from understudy.character import adult_woman, athlete_man, athlete_woman
from understudy.control import EngineState
from understudy.control.machine import STATE
from understudy.errors import InvalidValue, UnknownName
from understudy.performance import running, together
from understudy.scene import Scene
from understudy.simulate import prepared, simulate
from understudy.simulate.trials import judged

_SECONDS = 1.5


@pytest.fixture(scope="module")
def performance():
    return running(athlete_man(), Course.steady(3.5), duration=_SECONDS)


@pytest.fixture(scope="module")
def plain(performance):
    """The law run as plain Python: states of the engine and of the machine."""
    model, data = prepared(performance)
    function, parameters, memory = performance.controllers[0].feedback(performance.scene, model)
    state, rows, machine = EngineState.of(data), [], []
    memory = np.array(memory)
    for step in range(performance.steps):
        mujoco.mj_step1(model, data)
        function(step * 0.001, state, data.ctrl, data.qfrc_applied, parameters, memory)
        mujoco.mj_step2(model, data)
        rows.append(data.qpos.copy())
        machine.append((int(memory[STATE]), int(memory[law.ACTIVE])))
    return np.array(rows), machine


def test_the_law_is_the_same_compiled(performance, plain):
    take = simulate(performance)
    # Rounding differs; a fall or a missed step would show at once.
    assert take.qpos[1:600] == pytest.approx(plain[0][:599], abs=1e-6)


def test_states_follow_each_other_on_every_step_and_legs_take_turns(plain):
    changes = [(a, b) for a, b in pairwise(plain[1]) if a != b]
    assert len(changes) > 15
    for (before, foot), (after, next_foot) in changes:
        assert after == (before + 1) % len(law.STATES)
        assert (foot != next_foot) == (after == law.FLIGHT)


@pytest.mark.parametrize("speed", [2.5, 3.5, 5.0])
def test_nobody_falls_in_ten_seconds(speed):
    whole = running(athlete_man(), Course.steady(speed), duration=10.0)
    (runner,) = whole.controllers
    seen = report(judged(whole, Judge(running=runner, begin=4.0))[0])  # type: ignore[arg-type]
    assert not seen["fell"]
    assert seen["mean_speed"] == pytest.approx(speed, rel=0.06)
    assert 2.4 < 1.0 / seen["mean_period"] < 3.7


@pytest.mark.parametrize(("height", "mass"), [(1.60, 70.0), (1.95, 100.0)])
def test_bodies_of_other_sizes_run(height, mass):
    take = simulate(running(athlete_man(height=height, mass=mass), duration=3.0))
    lowest = take.qpos[:, 2].min() / athlete_man(height=height).links[0].offset[2]
    assert lowest > 0.85 and take.qpos[-1, 0] > 9.0


def test_a_mirrored_start_gives_a_mirrored_run():
    body = athlete_man()
    start = Schedule(gains=shipped().gains, slopes=shipped().slopes)  # a made-up flight
    whole = running(body, Course.steady(3.5), duration=0.4, schedule=start)
    take = simulate(whole)
    model, data = prepared(whole)
    function, parameters, memory = whole.controllers[0].feedback(whole.scene, model)
    data.qpos[:], data.qvel[:] = _mirrored(take.qpos[0]), np.array(data.qvel)
    memory = np.array(memory)
    memory[law.ACTIVE] = law.LEFT
    for left, right in ((law.HIP_Y_LEFT, law.HIP_Y_RIGHT), (law.KNEE_LEFT, law.KNEE_RIGHT)):
        memory[[left, right]] = memory[[right, left]]
    state = EngineState.of(data)
    for step in range(whole.steps):
        mujoco.mj_step1(model, data)
        function(step * 0.001, state, data.ctrl, data.qfrc_applied, parameters, memory)
        mujoco.mj_step2(model, data)
    assert _mirrored(data.qpos) == pytest.approx(take.qpos[-1], abs=1e-4)


def _mirrored(qpos):
    """Left and right exchanged: y of the root, and turns about x and z, in reverse."""
    out = np.array(qpos)
    out[1] *= -1.0
    out[[4, 6]] *= -1.0
    body, hinges = athlete_man(), np.array(qpos[7:])
    names = [name for own in body.hinge_names for name in own]
    for k, name in enumerate(names):
        other = name
        if name.startswith("left_"):
            other = "right_" + name[5:]
        elif name.startswith("right_"):
            other = "left_" + name[6:]
        sign = -1.0 if name.endswith(("_x", "_z")) else 1.0
        out[7 + k] = sign * hinges[names.index(other)]
    return out


def test_a_circle_is_run_close_to_its_line():
    angle = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)
    circle = 20.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    whole = running(athlete_man(), Course.along(circle, 3.5, closed=True), duration=12.0)
    take = simulate(whole)
    away = np.linalg.norm(take.qpos[:, :2], axis=1) - 20.0
    assert take.qpos[:, 2].min() > 0.7
    assert np.abs(away).max() < 0.6


def test_each_of_several_runs_as_alone():
    course, lane = Course.steady(3.5), Course.steady(3.0, heading=0.5)
    alone = (
        running(athlete_man(), course, duration=1.0),
        running(athlete_woman(), lane.beside(1.22), duration=1.0),
    )
    take = simulate(together(*alone))
    for part, one in zip(take.scene.parts, alone, strict=True):
        # The engine sums the scene's contacts in another order.
        assert take.qpos[:, part.qpos] == pytest.approx(simulate(one).qpos, abs=1e-10)
    assert take.qpos[0, take.scene.parts[1].qpos.start] == pytest.approx(1.22 * np.sin(0.5))


def test_a_take_becomes_a_clip(performance):
    take = simulate(performance)
    clip = take.clip(rate=100.0)
    assert clip.skeleton.names[0] == "pelvis"
    assert clip.root_positions[-1, 0] > 3.0


def test_a_clip_of_a_run_has_about_120_frames_a_second(performance):
    take = simulate(performance)
    clip = take.clip()
    assert clip.rate == pytest.approx(125.0)
    assert clip.root_positions[-1] == pytest.approx(take.qpos[-1, :3], abs=0.05)


def test_a_run_is_tracked_by_another_body(performance):
    import understudy as us

    take = us.track(simulate(performance).clip(), adult_woman())
    found = us.score(take)
    assert found.joint_error_deg is not None and found.joint_error_deg < 1.5
    assert found.root_position_mm is not None and found.root_position_mm < 20.0


def test_nothing_but_the_ground_holds_a_runner(performance):
    import understudy as us

    found = us.score(simulate(performance))
    assert found.root_force_mean_percent == 0.0
    assert found.torque_peak_joint.split("_")[1] in ("hip", "knee", "ankle")


def test_gains_keep_the_order_the_law_reads_them_in():
    for k, name in enumerate(NAMES):
        assert getattr(law, name.upper()) == k
    assert len(SUMS) == running_judge.SMOOTH_FORWARD


def test_gains_change_with_speed_by_their_slopes():
    schedule = Schedule(gains=Gains(pitch=0.1), slopes={"pitch": 0.02})
    assert schedule.at(4.5).pitch == pytest.approx(0.12)
    assert Schedule.from_json(schedule.as_json()) == schedule


def test_an_unknown_gain_is_named():
    with pytest.raises(UnknownName, match="pitch"):
        Schedule(slopes={"pich": 0.1})


def test_only_athletes_run():
    from understudy.character import adult_man

    scene = Scene(characters=(adult_man(),))
    with pytest.raises(InvalidValue, match="no athlete"):
        Running().configure(scene, scene.model)
