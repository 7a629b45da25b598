"""The toolbox of Hodgins et al. 1995: trajectories, servos, legs, the state machine."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from understudy.character import athlete_man
from understudy.control import legs, machine, trajectory
from understudy.control.compiling import compiled

ANGLES = [(0.2, 0.7, 0.5), (-0.3, -0.4, 1.2), (0.0, 0.0, 0.0), (0.5, 1.6, 2.0)]


def test_a_blend_starts_and_ends_flat_and_is_half_way_in_the_middle():
    h = 1e-6
    assert trajectory.eased(2.0, 5.0, 0.0, 0.4) == 2.0
    assert trajectory.eased(2.0, 5.0, 0.4, 0.4) == 5.0
    assert trajectory.eased(2.0, 5.0, 0.2, 0.4) == pytest.approx(3.5)
    assert trajectory.eased(2.0, 5.0, 9.0, 0.4) == 5.0
    assert (trajectory.ease(h) - trajectory.ease(0.0)) / h == pytest.approx(0.0, abs=1e-5)
    assert (trajectory.ease(1.0) - trajectory.ease(1.0 - h)) / h == pytest.approx(0.0, abs=1e-5)


def test_a_blend_of_no_duration_is_over():
    assert trajectory.eased(2.0, 5.0, 0.0, 0.0) == 5.0


def test_not_a_number_is_not_bounded_away():
    assert math.isnan(trajectory.bounded(math.nan, -1.0, 1.0))


def test_a_servo_pulls_by_equation_6():
    assert trajectory.servo(3.0, 0.5, 1.0, 0.2, 4.0, 1.0) == pytest.approx(3.0 * 0.8 + 0.5 * 3.0)


def test_a_followed_value_has_the_rate_of_its_change_up_to_a_bound():
    memory = np.array([1.0])
    assert trajectory.followed(memory, 0, 1.001, 0.001, 15.0) == pytest.approx(1.0)
    assert trajectory.followed(memory, 0, 2.0, 0.001, 15.0) == 15.0
    assert memory[0] == 2.0


def test_a_value_goes_toward_its_goal_by_no_more_than_asked():
    assert trajectory.toward(0.0, 1.0, 0.1) == pytest.approx(0.1)
    assert trajectory.toward(0.95, 1.0, 0.1) == 1.0


@pytest.mark.parametrize("angles", ANGLES)
def test_leg_angles_undo_the_place_of_the_ankle(angles):
    place = legs.ankle_of(*angles, 0.43, 0.42)
    assert legs.leg_angles(*place, 0.43, 0.42) == pytest.approx(angles, abs=1e-7)


@pytest.mark.parametrize("angles", ANGLES)
def test_the_ankle_is_where_the_engine_has_it(angles):
    body = athlete_man()
    model = body.spec().compile()
    data = mujoco.MjData(model)
    first = 7 + body.first_hinge("left_hip")
    data.qpos[first : first + 2], data.qpos[first + 3] = angles[:2], angles[2]
    mujoco.mj_kinematics(model, data)
    hip = data.body("left_thigh").xpos
    thigh, shank = -body.link("left_knee").offset[2], -body.link("left_ankle").offset[2]
    place = legs.ankle_of(*angles, thigh, shank)
    assert data.body("left_foot").xpos - hip == pytest.approx(place, abs=1e-9)


def test_a_place_out_of_reach_straightens_the_leg_toward_it():
    hip_x, hip_y, knee = legs.leg_angles(3.0, 0.0, -3.0, 0.43, 0.42)
    assert (hip_x, knee) == pytest.approx((0.0, 0.0))
    assert hip_y == pytest.approx(math.pi / 4)


def test_the_heel_lands_at_the_foothold():
    x, y, knee, foot = 0.3, -0.06, 0.4, 0.2
    heel_x, heel_z = -0.045, -0.068
    ax, ay, az = legs.foothold(x, y, knee, 0.43, 0.42, heel_x, heel_z, foot)
    assert ax + heel_x * math.cos(foot) - heel_z * math.sin(foot) == pytest.approx(x)
    assert ay == y
    assert math.sqrt(ax * ax + ay * ay + az * az) == pytest.approx(
        legs.leg_length(knee, 0.43, 0.42)
    )


def test_the_idle_hip_mirrors_as_in_equations_3_and_4():
    assert legs.mirrored_hip(0.5, 0.9, 0.2, 1.0, 0.0) == pytest.approx(0.5 - (0.9 - 0.2))


def test_hip_torques_do_on_the_pelvis_what_was_asked():
    """A hinge's torque on the thigh acts on the pelvis in reverse, along its axis."""
    body = athlete_man()
    model = body.spec().compile()
    data = mujoco.MjData(model)
    first = 7 + body.first_hinge("right_hip")
    data.qpos[first : first + 2] = 0.2, 0.7
    mujoco.mj_kinematics(model, data)
    asked = np.array([30.0, -50.0, 10.0])
    axes = data.xaxis[model.joint("right_hip_x").id :][:3]
    assert legs.hip_torques(*asked, 0.2, 0.7) == pytest.approx(-axes @ asked)


def test_states_are_left_by_time_and_by_events():
    memory = np.zeros(machine.MACHINE)
    machine.enter(memory, 3, 1.0)
    assert machine.state_of(memory) == 3
    assert machine.time_in(memory, 1.25) == pytest.approx(0.25)
    assert not machine.timed(memory, 1.05, 0.1)
    assert machine.timed(memory, 1.2, 0.1)
    assert not machine.sensed(9.0, 5.0, memory, 1.05, 0.1)
    assert machine.sensed(9.0, 5.0, memory, 1.2, 0.1)


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (legs.leg_angles, (0.2, 0.1, -0.7, 0.43, 0.42)),
        (legs.foothold, (0.3, -0.06, 0.4, 0.43, 0.42, -0.045, -0.068, 0.2)),
        (legs.hip_torques, (3.0, 4.0, 5.0, 0.1, 0.6)),
        (trajectory.eased, (1.0, 2.0, 0.1, 0.3)),
    ],
)
def test_tools_are_the_same_compiled(function, arguments):
    assert compiled(function)(*arguments) == pytest.approx(function(*arguments), rel=1e-14)
