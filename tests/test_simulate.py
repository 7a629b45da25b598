"""The physics where it is closed-form, and the three gears giving the same answer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np
import pytest

from bodies import INERTIA, LENGTH, MASS, Pinned, chain, still
from understudy.control import Controls, PythonController, Tracking
from understudy.errors import ControllerFailed, Diverged, InvalidValue
from understudy.motion import rotations as rot
from understudy.performance import Performance
from understudy.scene import Ground, Scene
from understudy.simulate import open_loop_controls, prepared, simulate, simulate_many
from understudy.take import Take

SWING = MASS * LENGTH**2 + INERTIA  # Moment of inertia about the joint [kg m^2].


def free_space(character, **changes) -> Scene:
    return Scene(characters=(character,), ground=None, **{"timestep": 0.001, **changes})


def rod_angle(take) -> np.ndarray:
    part = take.scene.parts[0]
    q = take.qpos[:, part.qpos][:, 7:11]
    return 2.0 * np.arctan2(q[:, 2], q[:, 0])


def test_a_body_in_free_space_falls_half_g_t_squared():
    scene = free_space(chain(1))
    take = simulate(Performance(scene=scene, duration=1.0))
    fall = take.qpos[0, 2] - take.qpos[:, 2]
    # A semi-implicit step adds g t dt / 2 to the exact parabola.
    expected = 0.5 * 9.81 * take.times * (take.times + scene.timestep)
    np.testing.assert_allclose(fall, expected, atol=1e-9)


def test_a_rod_swings_with_the_period_of_a_physical_pendulum():
    take = simulate(
        Performance(scene=free_space(chain(2)), controllers=(Pinned(0.05),), duration=6.0)
    )
    angle = rod_angle(take)
    down = np.flatnonzero((angle[:-1] > 0) & (angle[1:] <= 0))
    crossings = take.times[down] + angle[down] / (angle[down] - angle[down + 1]) * 0.001
    armature = float(take.model.dof_armature[6])
    period = 2.0 * np.pi * np.sqrt((SWING + armature) / (MASS * 9.81 * LENGTH))
    period *= 1.0 + 0.05**2 / 16.0
    np.testing.assert_allclose(np.diff(crossings).mean(), period, rtol=1e-3)


def test_a_swinging_rod_keeps_its_energy():
    take = simulate(
        Performance(scene=free_space(chain(3)), controllers=(Pinned(1.0),), duration=5.0)
    )
    energies = []
    model, data = take.model, mujoco.MjData(take.model)
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    for qpos, qvel in zip(take.qpos[::20], take.qvel[::20], strict=True):
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(model, data)
        energies.append(data.energy.sum())
    swing = MASS * 9.81 * LENGTH * 3.0
    assert np.ptp(energies) < 0.01 * swing


def momentum_drift(timestep: float) -> tuple[float, float]:
    """Largest change of linear and angular momentum in flight, relative to the most there was."""
    body = chain(3)
    clip = still(body, seconds=1.0)
    wave = 0.5 * np.sin(2.0 * np.pi * clip.times)
    turned = np.array(clip.rotations)
    turned[:, 1] = rot.from_rotvec(wave[:, None] * [0.0, 1.0, 0.0])
    turned[:, 2] = rot.from_rotvec(wave[:, None] * [1.0, 0.0, 0.0])
    moving = replace(clip, rotations=turned)
    scene = free_space(body, gravity=0.0, timestep=timestep)
    tracking = Tracking(reference=moving, pelvis="free", stiffness=500.0)
    take = simulate(Performance(scene=scene, controllers=(tracking,), duration=1.0))
    data = mujoco.MjData(take.model)
    linear, angular = [], []
    for qpos, qvel in zip(take.qpos[::10], take.qvel[::10], strict=True):
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(take.model, data)
        mujoco.mj_subtreeVel(take.model, data)
        linear.append(data.subtree_linvel[1] * take.model.body_subtreemass[1])
        angular.append(data.subtree_angmom[1].copy())
    return tuple(
        float(np.abs(np.array(p) - p[0]).max() / np.abs(p).max()) for p in (linear, angular)
    )


def test_servos_do_not_change_momentum_in_flight():
    coarse, fine = momentum_drift(0.001), momentum_drift(0.0005)
    for at_1_ms, at_half_ms in zip(coarse, fine, strict=True):
        assert at_1_ms < 0.02
        # What is left is the first-order error of the step: half the step, half the drift.
        assert at_half_ms == pytest.approx(0.5 * at_1_ms, rel=0.1)


def test_a_servo_sags_under_gravity_by_load_over_stiffness():
    body = chain(2)
    clip = still(body, seconds=3.0)
    turned = np.array(clip.rotations)
    turned[:, 1] = rot.from_rotvec([0.0, -np.pi / 2, 0.0])
    level = replace(clip, rotations=turned)
    tracking = Tracking(
        reference=level, law="paper", stiffness=400.0, pelvis="free", interpolation="slerp"
    )
    scene = free_space(body)
    take = simulate(
        Performance(scene=scene, controllers=(tracking, Pinned(-np.pi / 2)), duration=3.0)
    )
    k = take.model.actuator_gainprm[scene.parts[0].joint_actuators[0], 0]
    sag = np.pi / 2 + rod_angle(take)[-1]
    np.testing.assert_allclose(k * sag, MASS * 9.81 * LENGTH * np.cos(sag), rtol=2e-3)


def test_a_performance_of_no_time_is_its_first_state():
    take = simulate(Performance(scene=free_space(chain(1)), duration=0.0))
    assert take.frames == 1
    assert take.duration == 0.0


def performance_of_a_wave(**settings) -> Performance:
    body = chain(3)
    clip = still(body, seconds=0.6)
    turned = np.array(clip.rotations)
    wave = np.sin(2.0 * np.pi * clip.times)
    turned[:, 1] = rot.from_rotvec(wave[:, None] * [0.0, 1.0, 0.0])
    moving = replace(clip, rotations=turned)
    scene = free_space(body, timestep=0.002)
    tracking = Tracking(reference=moving, pelvis="led", **settings)
    return Performance(scene=scene, controllers=(tracking,), duration=0.6)


def test_open_loop_gives_bitwise_what_a_plain_engine_loop_gives():
    performance = performance_of_a_wave()
    take = simulate(performance)
    model, data = prepared(performance)
    ctrl = open_loop_controls(performance, model).ctrl
    for step in range(performance.steps):
        data.ctrl[:] = ctrl[step]
        mujoco.mj_step(model, data)
        np.testing.assert_array_equal(data.qpos, take.qpos[step + 1])
        np.testing.assert_array_equal(data.qvel, take.qvel[step + 1])


def test_a_batch_gives_the_same_bits_on_any_number_of_threads():
    performances = [performance_of_a_wave(stiffness=s) for s in (500.0, 1000.0, 2000.0)]
    alone = [simulate(p) for p in performances]
    for threads in (1, 2, 3):
        for one, many in zip(alone, simulate_many(performances, threads=threads), strict=True):
            assert not isinstance(many, Diverged)
            np.testing.assert_array_equal(one.qpos, many.qpos)
            np.testing.assert_array_equal(one.qvel, many.qvel)


def push_law(time, state, ctrl, applied, parameters, memory):
    memory[0] += 1.0
    applied[7] += parameters[0] * (parameters[1] - state.qvel[7])


@dataclass(frozen=True)
class Push:
    """A compiled law: pushes one joint toward a speed."""

    def configure(self, scene, model) -> None:
        pass

    def start(self, scene, data) -> None:
        pass

    def feedback(self, scene, model):
        return push_law, np.array([30.0, 1.5]), np.zeros(1)


def test_a_compiled_law_gives_the_same_motion_compiled_and_in_python():
    performance = performance_of_a_wave()
    compiled = replace(performance, controllers=(*performance.controllers, Push()))

    def function(time: float, data: mujoco.MjData) -> None:
        data.qfrc_applied[7] += 30.0 * (1.5 - data.qvel[7])

    python = replace(
        performance,
        controllers=(*performance.controllers, PythonController(function=function, period=0.002)),
    )
    idle = PythonController(function=lambda time, data: None, period=0.002)
    uncompiled = replace(compiled, controllers=(*compiled.controllers, idle))
    first = simulate(compiled)
    assert np.abs(first.qpos - simulate(performance).qpos).max() > 1e-3
    for other in (python, uncompiled):
        np.testing.assert_allclose(simulate(other).qpos, first.qpos, rtol=0, atol=1e-12)


def test_a_python_controller_that_does_nothing_changes_nothing():
    performance = performance_of_a_wave()
    idle = PythonController(function=lambda time, data: None, period=0.01)
    watched = replace(performance, controllers=(*performance.controllers, idle))
    np.testing.assert_array_equal(simulate(watched).qpos, simulate(performance).qpos)


def test_python_controls_are_held_for_their_period():
    seen = []

    def function(time: float, data: mujoco.MjData) -> None:
        seen.append(time)
        data.qfrc_applied[2] = 5.0 + len(seen)

    scene = free_space(chain(1), timestep=0.002)
    take = simulate(
        Performance(
            scene=scene,
            controllers=(PythonController(function=function, period=0.01),),
            duration=0.05,
        )
    )
    np.testing.assert_allclose(seen, np.arange(5) * 0.01)
    np.testing.assert_array_equal(take.qfrc_applied[:5, 2], 6.0)
    np.testing.assert_array_equal(take.qfrc_applied[5:10, 2], 7.0)


def exploding() -> Performance:
    def function(time: float, data: mujoco.MjData) -> None:
        if time > 0.1:
            data.qfrc_applied[:] = 1e16

    scene = free_space(chain(2))
    return Performance(
        scene=scene,
        controllers=(PythonController(function=function, period=0.001),),
        duration=0.5,
    )


def test_divergence_says_when_and_where_and_keeps_the_take():
    with pytest.raises(Diverged) as caught:
        simulate(exploding())
    error = caught.value
    assert error.time == pytest.approx(0.1, abs=0.01)
    assert error.where in {"block", "rod1"}
    assert error.take.diverged == error.time
    assert np.isfinite(error.take.qpos).all()
    assert error.take.duration == pytest.approx(error.time)


def test_divergence_in_a_batch_spares_the_others():
    scene = free_space(chain(2), timestep=0.002)

    @dataclass(frozen=True)
    class Blast:
        size: float

        def configure(self, scene, model):
            pass

        def start(self, scene, data):
            pass

        def controls(self, scene, model, times):
            applied = np.zeros((len(times), model.nv))
            applied[100:] = self.size
            return Controls(np.zeros((len(times), model.nu)), applied)

    runs = simulate_many(
        [Performance(scene=scene, controllers=(Blast(size),), duration=0.5) for size in (0.0, 1e17)]
    )
    assert not isinstance(runs[0], Diverged)
    assert isinstance(runs[1], Diverged)
    assert runs[1].take.duration == pytest.approx(0.2, abs=0.01)


def test_dense_and_sparse_jacobians_agree_for_two_bodies_on_the_ground():
    from understudy.character import body

    scene = Scene(characters=(body("child"), body("child")), ground=Ground())
    states = []
    for kind in (mujoco.mjtJacobian.mjJAC_DENSE, mujoco.mjtJacobian.mjJAC_SPARSE):
        spec = scene.spec()
        spec.option.jacobian = kind
        model = spec.compile()
        data = mujoco.MjData(model)
        data.qpos[scene.parts[1].qpos.start] += 1.0
        for _ in range(100):
            mujoco.mj_step(model, data)
        states.append(data.qpos.copy())
    np.testing.assert_allclose(states[0], states[1], atol=1e-6)


def test_a_batch_refuses_python_and_mixed_sizes():
    performance = performance_of_a_wave()
    python = PythonController(function=lambda time, data: None)
    with pytest.raises(InvalidValue, match="open-loop"):
        simulate_many([replace(performance, controllers=(python,))])
    with pytest.raises(InvalidValue, match="same sizes"):
        simulate_many([performance, replace(performance, duration=0.2)])


def test_compiled_laws_run_as_a_batch_bit_for_bit():
    performance = performance_of_a_wave()
    performance = replace(performance, controllers=(*performance.controllers, Push()))
    runs = [performance, replace(performance, duration=0.2)]
    alone = [simulate(run) for run in runs]
    for threads in (1, 2):
        for take, single in zip(simulate_many(runs, threads=threads), alone, strict=True):
            assert isinstance(take, Take)
            np.testing.assert_array_equal(take.qpos, single.qpos)


def test_controls_that_are_no_numbers_are_a_divergence():
    def function(time: float, data: mujoco.MjData) -> None:
        data.ctrl[:] = np.nan

    performance = performance_of_a_wave()
    bad = PythonController(function=function, period=0.01)
    with pytest.raises(Diverged):
        simulate(replace(performance, controllers=(*performance.controllers, bad)))


def test_a_controller_that_raises_keeps_the_take_so_far():
    def function(time: float, data: mujoco.MjData) -> None:
        if time > 0.1:
            raise RuntimeError("out of ideas")

    performance = performance_of_a_wave()
    tired = PythonController(function=function, period=0.01)
    with pytest.raises(ControllerFailed, match="out of ideas") as caught:
        simulate(replace(performance, controllers=(*performance.controllers, tired)))
    assert caught.value.take.duration == pytest.approx(caught.value.time)
    assert caught.value.time == pytest.approx(0.11, abs=0.01)


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan"), float("inf"), "a", None])
def test_a_senseless_period_is_refused(period):
    with pytest.raises(InvalidValue, match="period"):
        PythonController(function=lambda time, data: None, period=period)


def test_a_body_without_a_controller_starts_on_its_feet_and_collapses():
    from understudy.character import adult_man

    scene = Scene(characters=(adult_man(),))
    take = simulate(Performance(scene=scene, duration=1.0))
    height = take.qpos[:, 2]
    assert height[0] == pytest.approx(adult_man().links[0].offset[2])
    assert 0.0 < height[-1] < 0.8 * height[0]
