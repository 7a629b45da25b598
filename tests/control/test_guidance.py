"""Guidance: what it measures is mechanics, what it commands is what it says, and no more."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from understudy.character import Character
from understudy.control import EngineState, Guidance, PythonController, Tracking, guidance_law
from understudy.control.guidance import axes, layout
from understudy.errors import InvalidValue
from understudy.evaluate.measure import measured
from understudy.motion import rotations as rot
from understudy.motion.samples import sample
from understudy.performance import Performance, tracked
from understudy.simulate import open_loop_controls, prepared, simulate

WINDOWS = 6


@pytest.fixture(scope="module")
def walking() -> Performance:
    clip = sample("walk").trimmed(1.0, 1.3)
    return tracked(clip, Character.from_clip(clip), pelvis="free", servos="soft")


def guidance(performance: Performance, **changes: object) -> Guidance:
    """One that asks for nothing."""
    size = len(axes(performance.scene, 0))
    postures = np.zeros((WINDOWS, guidance_law.POSTURE))
    postures[:, 9] = 1.0
    nothing = Guidance(
        window=performance.scene.timestep * 20,
        offsets=np.zeros((WINDOWS, size)),
        help=np.zeros((WINDOWS, 6)),
        postures=postures,
        gains=np.zeros((0, size, guidance_law.DEVIATION + size)),
    )
    return replace(nothing, **changes)  # type: ignore[arg-type]


def guided(performance: Performance, one: Guidance) -> Performance:
    return replace(performance, controllers=(*performance.controllers, one))


def test_posture_is_the_engines_momentum(walking: Performance) -> None:
    model, data = prepared(walking)
    rng = np.random.default_rng(1)
    data.qvel[:] = rng.standard_normal(model.nv)
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    now = np.zeros(guidance_law.POSTURE)
    guidance_law.posture(EngineState.of(data), layout(walking.scene, model, 0), now)
    root = walking.scene.parts[0].bodies[0]
    assert now[:3] == pytest.approx(data.subtree_com[root])
    assert now[3:6] == pytest.approx(data.subtree_linvel[root])
    assert now[6:9] == pytest.approx(data.subtree_angmom[root])
    assert now[9:13] == pytest.approx(data.xquat[root])


def test_deviation_undoes_what_was_done_to_a_posture() -> None:
    rng = np.random.default_rng(2)
    planned, turn = rng.standard_normal(guidance_law.POSTURE), np.array([0.3, -0.2, 0.1])
    planned[9:13] /= np.linalg.norm(planned[9:13])
    change = rng.standard_normal(guidance_law.DEVIATION)
    change[9:12] = turn
    now = planned.copy()
    now[:9] += change[:9]
    now[9:13] = rot.multiply(rot.from_rotvec(turn), planned[9:13])
    now[13:] += change[12:]
    off = np.zeros(guidance_law.DEVIATION)
    guidance_law.deviation(now, planned, off)
    assert off == pytest.approx(change)


def test_guidance_that_asks_for_nothing_changes_nothing(walking: Performance) -> None:
    plain, with_it = simulate(walking), simulate(guided(walking, guidance(walking)))
    assert with_it.qpos == pytest.approx(plain.qpos, abs=1e-6)


def test_offsets_turn_the_commands_of_their_window(walking: Performance) -> None:
    turned = axes(walking.scene, 0)
    offsets = np.zeros((WINDOWS, len(turned)))
    knee = walking.scene.characters[0].index("left_knee")
    offsets[2, turned.index((knee, 1))] = 0.1
    take = simulate(guided(walking, guidance(walking, offsets=offsets)))
    model, _ = prepared(walking)
    block = open_loop_controls(walking, model)
    column = walking.scene.parts[0].joint_controls[knee - 1]
    columns = slice(column, column + 4)
    window = slice(40, 60)
    more = rot.multiply(block.ctrl[window, columns], rot.from_rotvec(np.array([0.0, 0.1, 0.0])))
    assert take.ctrl[window, columns] == pytest.approx(more)
    assert take.ctrl[60, columns] == pytest.approx(block.ctrl[60, columns])


def test_help_is_a_force_on_the_pelvis(walking: Performance) -> None:
    held = np.zeros((WINDOWS, 6))
    held[1] = np.arange(6.0)
    take = simulate(guided(walking, guidance(walking, help=held)))
    first = walking.scene.parts[0].dofs.start
    assert take.qfrc_applied[20:40, first : first + 6] == pytest.approx(np.tile(held[1], (20, 1)))
    assert not take.qfrc_applied[:20].any()


def test_gains_answer_to_the_deviation_up_to_a_limit(walking: Performance) -> None:
    size = len(axes(walking.scene, 0))
    gains = np.zeros((WINDOWS, size, guidance_law.DEVIATION + size))
    gains[:, 0, 2], gains[:, 1, 2] = 0.05, 5.0  # the body is a meter over the planned height 0
    take = simulate(guided(walking, guidance(walking, gains=gains, most=0.2)))
    model, data = prepared(walking)
    mujoco.mj_forward(model, data)
    height = data.subtree_com[walking.scene.parts[0].bodies[0], 2]
    back = walking.scene.characters[0].index("lower_back")
    column = walking.scene.parts[0].joint_controls[back - 1]
    block = open_loop_controls(walking, model)
    turn = rot.multiply(
        rot.conjugate(block.ctrl[0, column : column + 4]), take.ctrl[0, column:][:4]
    )
    assert rot.to_rotvec(turn) == pytest.approx(np.array([0.05 * height, 0.2, 0.0]))


def test_law_runs_as_it_is_and_compiled(walking: Performance) -> None:
    rng = np.random.default_rng(3)
    size = len(axes(walking.scene, 0))
    one = guidance(
        walking,
        offsets=0.02 * rng.standard_normal((WINDOWS, size)),
        gains=0.01 * rng.standard_normal((WINDOWS, size, guidance_law.DEVIATION + size)),
    )
    performance = replace(guided(walking, one), duration=0.15)
    nobody = PythonController(function=lambda time, data: None)
    slow = replace(performance, controllers=(*performance.controllers, nobody))
    assert simulate(slow).qpos == pytest.approx(simulate(performance).qpos, abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"window": -1.0}, "window is -1.0 s"),
        ({"most": 4.0}, "most is 4.0 rad"),
        ({"help": np.zeros((WINDOWS, 5))}, "help of a Guidance has shape"),
        ({"offsets": np.full((WINDOWS, 15), np.nan)}, "must be finite"),
    ],
)
def test_values_that_cannot_be_are_refused(
    walking: Performance, changes: dict[str, object], says: str
) -> None:
    with pytest.raises(InvalidValue, match=says):
        guidance(walking, **changes)


def test_windows_must_be_whole_steps(walking: Performance) -> None:
    odd = guidance(walking, window=walking.scene.timestep * 2.5)
    with pytest.raises(InvalidValue, match="no whole number of steps"):
        simulate(guided(walking, odd))


def test_a_discrete_servo_is_told_where_to_be_at_the_end_of_its_step(walking: Performance) -> None:
    scene = replace(walking.scene, integrator="discrete")
    late = replace(walking, scene=scene)
    model, _ = prepared(walking)
    discrete, _ = prepared(late)
    now, then = open_loop_controls(walking, model), open_loop_controls(late, discrete)
    assert then.ctrl[:-1] == pytest.approx(now.ctrl[1:], abs=1e-9)


def test_soft_legs_are_as_strong_as_in_motion(walking: Performance) -> None:
    (tracking,) = walking.controllers
    assert isinstance(tracking, Tracking)
    model, _ = prepared(replace(walking, controllers=(replace(tracking, torque_limits="human"),)))
    body, part = walking.scene.characters[0], walking.scene.parts[0]
    for joint, factor in (("left_ankle", 2.0), ("left_knee", 1.5), ("left_elbow", 1.0)):
        k = body.index(joint)
        limit = model.actuator_forcerange[part.joint_actuators[k - 1]].max()
        assert limit == pytest.approx(factor * np.max(body.links[k].torque_limit)), joint


def test_no_command_asks_for_more_torque_than_there_is(walking: Performance) -> None:
    (tracking,) = walking.controllers
    assert isinstance(tracking, Tracking)
    scene = replace(walking.scene, integrator="discrete", timestep=1.0 / 120.0)
    weak = replace(tracking, torque_limits="human", strengths=(("left_hip", 0.2),))
    one = guidance(walking, window=0.05)
    take = simulate(replace(walking, scene=scene, controllers=(weak, one)))
    hip = scene.characters[0].index("left_hip")
    limit = take.model.actuator_forcerange[scene.parts[0].joint_actuators[hip - 1]].max()
    torque = np.linalg.norm(measured(take).joint_torques(0)[:, hip - 1], axis=-1)
    assert torque.max() > 0.5 * limit
    assert np.quantile(torque, 0.9) < 1.1 * limit
