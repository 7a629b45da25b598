from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from small_takes import body_spec, simulated

from understudy.errors import InvalidValue
from understudy.evaluate import physics
from understudy.evaluate.measure import measured


def test_ground_reaction_of_a_body_at_rest_is_its_weight(standing: Any) -> None:
    m = measured(standing)
    settled = m.ground_reaction()[m.times > 0.5]
    weight = m.performer().weight
    assert weight == pytest.approx(13.0 * 9.81)
    assert np.allclose(settled[:, 2], weight, rtol=0.01)
    assert np.abs(settled[:, :2]).max() < 0.01 * weight


def test_center_of_pressure_lies_under_the_center_of_mass_at_rest(standing: Any) -> None:
    m = measured(standing)
    pressure = physics.center_of_pressure(m)[-1]
    assert np.allclose(pressure, m.center_of_mass[-1, 0, :2], atol=1e-3)


def test_center_of_pressure_in_flight_is_nan(thrown: Any) -> None:
    assert np.isnan(physics.center_of_pressure(measured(thrown))).all()


def test_thrown_body_falls_freely(thrown: Any) -> None:
    m = measured(thrown, rate=None)
    com = m.center_of_mass[:, 0]
    speed = m.momentum[0, 0] / 13.0
    # The engine moves positions with the velocity after a step, half a step's fall lower.
    height = physics.free_fall_height(com[0, 2], speed[2] - 0.5 * 9.81 / thrown.rate, m.times)
    assert np.abs(com[:, 2] - height).max() < 1e-3
    assert np.abs(com[:, 0] - com[0, 0] - speed[0] * m.times).max() < 1e-3


def test_flight_conserves_angular_momentum_and_horizontal_momentum(thrown: Any) -> None:
    m = measured(thrown)
    spin = m.angular_momentum[:, 0]
    assert np.abs(spin - spin[0]).max() < 0.02 * np.linalg.norm(spin[0])
    flat = m.momentum[:, 0, :2]
    assert np.abs(flat - flat[0]).max() < 0.01 * np.linalg.norm(flat[0])


def test_vertical_momentum_in_flight_falls_by_weight_times_time(thrown: Any) -> None:
    m = measured(thrown)
    lost = m.momentum[0, 0, 2] - m.momentum[:, 0, 2]
    assert np.allclose(lost, m.performer().weight * m.times, atol=0.01 * lost[-1])


@pytest.mark.parametrize("limit", [0.0, 30.0])
@pytest.mark.parametrize("integrator", ["IMPLICITFAST", "IMPLICIT", "DISCRETE"])
def test_torque_over_a_step_accounts_for_the_change_of_momentum(
    integrator: str, limit: float
) -> None:
    kind = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    spec = body_spec(servo=400.0, hold=100.0, integrator=kind)
    if limit:
        spec.actuators[0].forcelimited = True
        spec.actuators[0].forcerange = [0.0, limit]

    def swing(time: float, data: Any) -> None:
        angle = 0.5 * np.sin(12.0 * time)
        data.ctrl[0:4] = [np.cos(angle), 0, np.sin(angle), 0]

    # At rest but for the servos: the terms of `implicit` that depend on turning are not theirs.
    take = simulated(spec, 0.3, qpos=[0, 0, 2.0], control=swing)
    m, model = measured(take, rate=None), take.model
    data, mass = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    for t in range(0, 150, 5):
        data.qpos[:], data.qvel[:], data.ctrl[:] = take.qpos[t], take.qvel[t], take.ctrl[t]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, mass)
        gained = mass @ (take.qvel[t + 1] - take.qvel[t]) * take.rate
        left = gained - (m.torque[t] + m.resistance[t] - data.qfrc_bias)
        bound = 1e-8 if integrator != "IMPLICIT" else 0.02 * np.abs(m.torque).max()
        assert np.abs(left).max() < bound


def test_torque_at_the_instant_alone_would_overstate_a_stiff_servo() -> None:
    def turn(time: float, data: Any) -> None:
        data.ctrl[0:4] = [np.cos(0.2), np.sin(0.2), 0.0, 0.0]

    take = simulated(body_spec(ground=False, servo=4000.0), 0.05, control=turn)
    data = mujoco.MjData(take.model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = take.qpos[0], take.qvel[0], take.ctrl[0]
    mujoco.mj_forward(take.model, data)
    acted = np.linalg.norm(measured(take, rate=None).joint_torques()[0, 0])
    assert np.linalg.norm(data.qfrc_actuator[6:]) > 1.5 * acted


def test_saturated_servo_never_exceeds_its_limit() -> None:
    spec = body_spec(servo=400.0)
    spec.actuators[0].forcelimited = True
    spec.actuators[0].forcerange = [0.0, 5.0]

    def kick(time: float, data: Any) -> None:
        data.ctrl[0:4] = [0.0, 1.0, 0.0, 0.0]

    take = simulated(spec, 0.1, qpos=[0, 0, 2.0], control=kick)
    sizes = np.linalg.norm(measured(take, rate=None).joint_torques()[:, 0], axis=-1)
    assert sizes.max() <= 5.0 * (1 + 1e-9)
    assert sizes[:10].min() == pytest.approx(5.0)


def test_energy_in_flight_is_the_work_of_the_joints(thrown: Any) -> None:
    m = measured(thrown)
    assert physics.flights(m) == ((0, m.frames - 1),)
    drift = physics.energy_drift(thrown, m)
    assert drift is not None and drift < 1.0
    # The servo's work is a large part of what is accounted for.
    work = np.abs(m.power.sum(axis=1)).sum() / m.rate
    assert work > 5.0


def test_energy_error_shrinks_with_the_step() -> None:
    errors = []
    for step in (0.004, 0.002, 0.001):
        take = simulated(
            body_spec(ground=False, step=step), 0.4, qpos=[0, 0, 2.0], qvel=[0, 0, 0, 3.0, 5.0, 2.0]
        )
        errors.append(physics.energy_balance(take, 0, round(0.4 / step)).error)
    assert errors[0] > errors[1] > errors[2]


def test_pendulum_keeps_its_energy_and_its_period() -> None:
    take = simulated(
        body_spec(ground=False, pinned=True, root_mass=1.0, arm_mass=2.0),
        4.0,
        # Upside down, the arm hangs; a small angle about y.
        qpos=[0, 0, 0, 1, 0, 0, 0, np.sin(0.05), 0, np.cos(0.05), 0],
    )
    model, m = take.model, measured(take)
    total = m.kinetic + m.potential
    swing = m.potential.max() - m.potential.min()
    assert np.abs(total - total[0]).max() < 0.05 * swing
    arm = model.body_ipos[2]
    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[2])
    tensor = axes.reshape(3, 3) @ np.diag(model.body_inertia[2]) @ axes.reshape(3, 3).T
    # The arm hangs along its center of mass; swings about the two axes across it nearly agree.
    along = arm / np.linalg.norm(arm)
    across = 0.5 * (np.trace(tensor) - along @ tensor @ along)
    expected = physics.pendulum_period(2.0, float(np.linalg.norm(arm)), float(across))
    low = m.potential - m.potential.mean()
    spectrum = np.abs(np.fft.rfft(low * np.hanning(len(low)), 16 * len(low)))
    spectrum[:60] = 0.0
    frequency = np.argmax(spectrum) / (16 * len(low)) * m.rate
    assert 2.0 / frequency == pytest.approx(expected, rel=0.02)  # energy swings twice per period


def test_hung_body_hangs_from_its_root_servo() -> None:
    take = simulated(body_spec(ground=False, hold=5000.0, servo=200.0), 1.0)
    m = measured(take)
    weight = m.performer().weight
    assert m.root_force()[-1] == pytest.approx([0, 0, weight], abs=0.01 * weight)
    assert len(m.contacts) == 0
    assert not np.any(m.ground_reaction())


def test_root_torque_is_given_in_the_world() -> None:
    turned = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]

    def twist(time: float, data: Any) -> None:
        data.qfrc_applied[3] = 2.0  # about the root's own x, which points along the world's y

    take = simulated(body_spec(ground=False), 0.002, qpos=[0, 0, 0, *turned], control=twist)
    assert measured(take, rate=None).root_torque()[0] == pytest.approx([0, 2.0, 0], abs=1e-9)


@pytest.mark.parametrize("cone", [mujoco.mjtCone.mjCONE_PYRAMIDAL, mujoco.mjtCone.mjCONE_ELLIPTIC])
def test_contact_forces_equal_the_engines_own(cone: mujoco.mjtCone) -> None:
    take = simulated(body_spec(cone=cone), 0.3, qpos=[0, 0, 0.06], qvel=[0.8, 0.3, -0.5])
    m, data = measured(take), mujoco.MjData(take.model)
    seen = 0
    for f, t in enumerate(m.steps):
        data.qpos[:], data.qvel[:], data.ctrl[:] = take.qpos[t], take.qvel[t], take.ctrl[t]
        mujoco.mj_forward(take.model, data)
        rows = np.flatnonzero(m.contacts.frame == f)
        assert len(rows) == data.ncon
        for c, row in enumerate(rows):
            local = np.zeros(6)
            mujoco.mj_contactForce(take.model, data, c, local)
            world = data.contact[c].frame.reshape(3, 3).T @ local[:3]
            assert np.allclose(world, m.contacts.force[row], atol=1e-3)
            assert m.contacts.depth[row] == pytest.approx(-data.contact[c].dist)
            seen += 1
    assert seen > 20


def test_link_forces_add_up_to_the_ground_reaction(standing: Any) -> None:
    m = measured(standing)
    assert np.allclose(m.link_forces().sum(axis=1), m.ground_reaction())


def test_measuring_uses_a_whole_number_of_steps(standing: Any) -> None:
    m = measured(standing, rate=120.0)
    assert m.rate == 125.0 and m.frames == 126
    assert np.allclose(np.diff(m.times), 1 / 125.0)


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_measuring_refuses_a_rate_that_is_not_positive(standing: Any, rate: float) -> None:
    with pytest.raises(InvalidValue, match="must be positive"):
        measured(standing, rate=rate)


def test_measuring_names_the_characters_there_are(standing: Any) -> None:
    with pytest.raises(InvalidValue, match="No character 3; the scene has 1"):
        measured(standing).performer(3)


def test_servo_lag_is_damping_over_stiffness() -> None:
    assert physics.servo_lag(1000.0, 90.0) == pytest.approx(0.09)
