"""The drive: the published law's closed forms, what it must not touch, and recorded figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import understudy as us
from understudy.character import Linkage
from understudy.character.linkage import KINDS, Kind
from understudy.control import Drive, PythonController
from understudy.control.drive import scaling_for
from understudy.errors import Diverged, InvalidValue, UnknownName
from understudy.fidelity import drive_error, drive_forces, welford
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.output.take_file import load_take, save_take
from understudy.performance import driven
from understudy.scene import Ground, Scene
from understudy.simulate import simulate, simulate_many


@pytest.fixture(scope="module")
def gesture() -> Clip:
    return us.sample("gesture").trimmed(0.0, 2.0).resampled(60.0)


@pytest.fixture(scope="module")
def still(gesture: Clip) -> Clip:
    frames = 1201
    return replace(
        gesture,
        rotations=np.tile(gesture.rotations[:1], (frames, 1, 1)),
        root_positions=np.tile(gesture.root_positions[:1], (frames, 1)),
    )


# -- the published law ------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_bodies_sink_as_the_sag_law_says(still, kind):
    linkage = Linkage.from_clip(still, kind)
    performance = driven(still, linkage, law="paper", gain=60.0)
    error = drive_error(simulate(performance))
    gravity = 9.81  # units per second squared
    assert error.settings["gravity_units_per_s2"] == pytest.approx(gravity)
    expected = (gravity * still.duration / 60.0) ** 2 / 3.0
    assert error.mean == pytest.approx(expected, rel=0.05 if kind != "tree" else 0.08)
    assert error.growth == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("kind", ["independent", "skeleton", "constrained"])
def test_drift_of_a_moving_clip_grows_with_time_squared(kind):
    clip = us.sample("gesture").resampled(60.0)
    linkage = Linkage.from_clip(clip, kind)
    error = drive_error(simulate(driven(clip, linkage, law="paper", gain=60.0, gravity=9.81)))
    expected = (9.81 / linkage.unit * clip.duration / 60.0) ** 2 / 3.0
    assert error.mean == pytest.approx(expected, rel=0.05)
    assert error.growth == pytest.approx(2.0, abs=0.1)


def test_scale_is_the_same_as_weaker_gravity(gesture):
    linkage = Linkage.from_clip(gesture, "constrained")
    scaled = driven(gesture, linkage, law="paper", scale=2.0)
    weaker = driven(gesture, linkage, law="paper", gravity=9.81 * linkage.unit / 2.0)
    np.testing.assert_array_equal(simulate(scaled).qpos, simulate(weaker).qpos)
    facts = simulate(scaled).facts
    assert facts["K_vc"] == pytest.approx(120.0)
    assert facts["gravity_units_per_s2"] == pytest.approx(9.81)


def test_one_step_applies_exactly_the_published_force_and_torque(gesture):
    linkage = Linkage.from_clip(gesture, "skeleton")
    performance = driven(gesture, linkage, law="paper", gain=30.0, order=5)
    take = simulate(performance)
    drive = performance.controllers[0]
    assert isinstance(drive, Drive)
    k, body = 40, linkage.index("right_wrist")
    wanted = drive.targets(performance.scene)[k, body]
    state = take.qvel[k].reshape(-1, 6)[body]
    mass = linkage.masses[body]
    forces = drive_forces(take)
    np.testing.assert_allclose(
        forces.force[k, body], 30.0 * mass * (wanted[:3] - state[:3]), rtol=1e-12
    )
    turn = take.qpos[k].reshape(-1, 7)[body, 3:]
    tensor = rot.to_matrix(turn) @ np.diag(linkage.inertias[body]) @ rot.to_matrix(turn).T
    spin = rot.rotate(turn, state[3:])
    np.testing.assert_allclose(
        forces.torque[k, body], 30.0 * tensor @ (wanted[3:6] - spin), rtol=1e-9, atol=1e-15
    )
    # The velocity is that of the next frame (equation 1): a five-point difference of its path.
    pose = gesture.forward_kinematics()
    x = linkage.placed(pose.positions, pose.rotations)[0][:, body]
    f = k + 1
    five = (8.0 * (x[f + 1] - x[f - 1]) - (x[f + 2] - x[f - 2])) / 12.0 * 60.0
    np.testing.assert_allclose(wanted[:3], five, atol=1e-12)


def test_paper_mode_is_one_explicit_step_per_frame(gesture):
    performance = driven(gesture, Linkage.from_clip(gesture), law="paper")
    model = performance.scene.model
    assert model.opt.timestep == 1.0 / 60.0
    assert model.opt.integrator == int(mujoco.mjtIntegrator.mjINT_EULER)
    assert model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    assert model.nu == 0


def test_gains_an_explicit_step_cannot_carry_are_refused_before_running(gesture):
    linkage = Linkage.from_clip(gesture)
    with pytest.raises(InvalidValue, match=r"K_f dt = 2, and it must stay below 2.*K_f < 120"):
        driven(gesture, linkage, law="paper", gain=120.0)
    driven(gesture, linkage, law="paper", gain=119.0)
    with pytest.raises(InvalidValue, match="K_f < 99"):
        driven(gesture, linkage, gain=100.0, substeps=1)
    performance = driven(gesture, linkage, gain=100.0, substeps=2)
    slow = replace(performance, scene=replace(performance.scene, timestep=1.0 / 60.0))
    with pytest.raises(InvalidValue, match="unstable"):
        simulate(slow)


def test_the_limit_is_where_the_figure_flies_apart(gesture):
    still_runs = driven(gesture, Linkage.from_clip(gesture, "independent"), law="paper", gain=119.0)
    assert drive_error(simulate(still_runs)).mean < 1.0
    beyond = replace(
        still_runs,
        controllers=(_Unchecked(**vars(replace(still_runs.controllers[0], gain=130.0))),),
    )
    try:
        take = simulate(beyond)
    except Diverged:
        return
    assert drive_error(take).mean > 1e6


class _Unchecked(Drive):
    def check(self, scene: Scene) -> None:
        pass


# -- the modern law ---------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_the_modern_law_follows_within_a_millimeter_under_real_gravity(gesture, kind):
    take = simulate(driven(gesture, Linkage.from_clip(gesture, kind)))
    error = drive_error(take)
    assert take.scene.gravity == 9.81
    assert error.rms_mm < 1.0
    assert kind == "independent" or error.gap_max_mm < 1.0
    found = take.clip()
    assert found.rate == 60.0
    apart = rot.angle_between(found.rotations, gesture.rotations)
    assert np.degrees(apart.max()) < 2.0


def test_a_position_leads_no_velocity(gesture):
    # Trap: a position target one frame ahead, like the velocity's, costs a lag's worth of error.
    performance = driven(gesture, Linkage.from_clip(gesture), substeps=1)
    (drive,) = performance.controllers
    assert isinstance(drive, Drive)
    rows = drive.targets(performance.scene)
    pose = gesture.forward_kinematics()
    placed, _ = Linkage.from_clip(gesture).placed(pose.positions, pose.rotations)
    np.testing.assert_allclose(rows[:, :, 6:9], placed, atol=1e-12)


def test_gravity_feedforward_holds_still_bodies_still(still):
    linkage = Linkage.from_clip(still, "constrained")
    take = simulate(driven(still.trimmed(0.0, 2.0), linkage, position_gain=0.0))
    assert drive_error(take).rms_mm < 1e-6


# -- variations ---------------------------------------------------------------------------------


def test_uncontrolled_independent_bodies_fall_freely(gesture):
    linkage = Linkage.from_clip(gesture, "independent")
    strength = np.ones(len(linkage))
    strength[linkage.index("left_wrist")] = 0.0
    take = simulate(driven(gesture, linkage, strength=strength))
    body = linkage.index("left_wrist")
    height, speed = (
        take.qpos.reshape(len(take.times), -1, 7)[:, body, 2],
        take.qvel[0, 6 * body + 2],
    )
    t, h = take.times, take.scene.timestep
    np.testing.assert_allclose(height, height[0] + speed * t - 0.5 * 9.81 * t * (t + h), atol=1e-9)


@pytest.mark.parametrize("kind", ["constrained", "tree"])
def test_limp_bodies_get_no_force_and_hang_on_their_joint(gesture, kind):
    linkage = Linkage.from_clip(gesture, kind)
    limp = [linkage.index(n) for n in ("right_elbow", "right_wrist")]
    strength = np.ones(len(linkage))
    strength[limp] = 0.0
    take = simulate(driven(gesture, linkage, strength=strength))
    forces, error = drive_forces(take), drive_error(take)
    assert np.abs(forces.force[:, limp]).max() == 0.0
    assert np.abs(forces.torque[:, limp]).max() == 0.0
    others = np.delete(np.arange(len(linkage)), limp)
    assert (np.abs(forces.force[:, others]).max(axis=(0, 2)) > 0.0).all()
    assert np.sqrt(error.per_joint[limp]).min() * linkage.unit > 0.05
    assert np.sqrt(error.per_joint[linkage.index("left_wrist")]) * linkage.unit < 0.005
    assert error.gap_max_mm < 3.0


def test_scaling_speeds_up_only_the_named_joint_in_its_time(gesture):
    linkage = Linkage.from_clip(gesture, "independent")
    scaling = scaling_for(gesture, ["right_wrist"], 1.2, start=0.5, end=1.0)
    hand = linkage.index("right_wrist")
    assert scaling[29, hand] == 1.0 and scaling[30, hand] == 1.2
    assert scaling[60, hand] == 1.2 and scaling[61, hand] == 1.0
    plain, scaled = (
        simulate(driven(gesture, linkage, law="paper", **k)) for k in ({}, {"scaling": scaling})
    )
    moved = np.abs(plain.qpos - scaled.qpos).reshape(len(plain.times), -1, 7).max(axis=(0, 2))
    assert moved[hand] > 1e-3
    assert np.delete(moved, hand).max() == 0.0
    force, torque = drive_forces(plain).change(drive_forces(scaled))
    assert force.argmax() == hand and force[hand] > 0.0 and torque[hand] > 0.0


def test_scaling_a_foot_changes_forces_most_there_and_less_with_distance():
    clip = us.sample("walk").trimmed(0.0, 3.0).resampled(60.0)
    linkage = Linkage.from_clip(clip, "constrained")
    scaling = scaling_for(clip, ["right_ball"], 1.2)
    plain, scaled = (
        simulate(driven(clip, linkage, law="paper", **k)) for k in ({}, {"scaling": scaling})
    )
    force, _ = drive_forces(plain).change(drive_forces(scaled))
    chain = ["right_ball", "right_knee", "right_hip", "lower_back", "left_knee", "left_ball"]
    values = [force[linkage.index(name)] for name in chain]
    assert values == sorted(values, reverse=True)


@pytest.mark.parametrize("kind", ["constrained", "tree"])
@pytest.mark.parametrize("axes", ["xyz", "x", "yz"])
def test_locked_axes_stay_locked_while_driven(gesture, kind, axes):
    linkage = Linkage.from_clip(gesture, kind).locked("right_elbow", axes=axes)
    take = simulate(driven(gesture, linkage))
    body, parent = linkage.index("right_wrist"), linkage.index("right_elbow")
    _, turned = linkage.poses(take.qpos)
    world = rot.multiply(turned, rot.conjugate(linkage.alignments))
    local = rot.multiply(rot.conjugate(world[:, parent]), world[:, body])
    matrix = rot.to_matrix(local)
    # The cosines of what the lock keeps at right angles.
    kept = {
        "xyz": [(1, 2), (2, 0), (0, 1)],
        "x": [(1, 2)],
        "yz": [(0, 1), (0, 2)],
    }[axes]
    worst = max(np.abs(matrix[:, i, j]).max() for i, j in kept)
    assert np.degrees(np.arcsin(worst)) < 1.0
    free = simulate(driven(gesture, Linkage.from_clip(gesture, kind)))
    apart = rot.angle_between(take.clip().joint("right_elbow"), free.clip().joint("right_elbow"))
    assert np.degrees(apart.max()) > 5.0


# -- physics and programs -----------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["skeleton", "constrained"])
def test_momentum_changes_by_the_drive_and_gravity_alone(gesture, kind):
    linkage = Linkage.from_clip(gesture, kind, masses={"pelvis": 9.0, "left_knee": 0.3})
    take = simulate(driven(gesture, linkage, law="paper"))
    momentum = np.einsum(
        "tjk,j->tk", take.qvel.reshape(-1, len(linkage), 6)[..., :3], linkage.masses
    )
    force = drive_forces(take).force.sum(axis=1)
    force[:, 2] -= linkage.mass * take.scene.gravity
    np.testing.assert_allclose(
        np.diff(momentum, axis=0), force * take.scene.timestep, atol=1e-9 * np.abs(momentum).max()
    )


def test_a_free_tree_keeps_its_momentum(gesture):
    linkage = Linkage.from_clip(gesture, "tree")
    drift = []
    for substeps in (16, 32):
        take = simulate(
            driven(
                gesture.trimmed(1.0, 1.5),
                linkage,
                gravity=0.0,
                substeps=substeps,
                strength=np.zeros(len(linkage)),
            )
        )
        data = mujoco.MjData(take.model)
        found = []
        for qpos, qvel in zip(take.qpos, take.qvel, strict=True):
            data.qpos[:], data.qvel[:] = qpos, qvel
            mujoco.mj_forward(take.model, data)
            mujoco.mj_subtreeVel(take.model, data)
            found.append(data.subtree_linvel[1].copy())
        drift.append(np.abs(np.array(found) - found[0]).max() / np.abs(found).max())
    assert drift[0] < 0.02
    assert drift[1] == pytest.approx(0.5 * drift[0], rel=0.2)


@pytest.mark.parametrize("kind", ["constrained", "tree"])
@pytest.mark.parametrize("law", ["paper", "modern"])
def test_the_compiled_law_gives_what_the_plain_function_gives(gesture, kind, law):
    performance = driven(gesture.trimmed(0.0, 0.4), Linkage.from_clip(gesture, kind), law=law)
    idle = PythonController(function=lambda time, data: None)
    plain = replace(performance, controllers=(*performance.controllers, idle))
    np.testing.assert_allclose(simulate(plain).qpos, simulate(performance).qpos, atol=1e-9)


def test_the_same_performance_gives_the_same_bytes_on_any_number_of_threads(gesture):
    linkage = Linkage.from_clip(gesture)
    runs = [driven(gesture, linkage, law="paper", gain=k) for k in (20.0, 40.0, 60.0)]
    alone = [simulate(run).qpos.tobytes() for run in runs]
    for threads in (1, 2):
        takes = simulate_many(runs, threads=threads)
        assert [t.qpos.tobytes() for t in takes] == alone  # type: ignore[union-attr]


@pytest.mark.parametrize("kind", KINDS)
def test_a_take_of_a_linkage_comes_back_from_disk(gesture, kind, tmp_path: Path):
    linkage = Linkage.from_clip(gesture, kind, masses={"neck": 3.0})
    if kind in ("constrained", "tree"):
        linkage = linkage.locked("left_elbow", axes="xy", rotation=rot.from_rotvec([0, 0, 0.4]))
    take = simulate(driven(gesture, linkage))
    save_take(take, tmp_path / "take.npz")
    read = load_take(tmp_path / "take.npz")
    np.testing.assert_array_equal(read.qpos, take.qpos)
    assert str(drive_error(read)) == str(drive_error(take))
    np.testing.assert_array_equal(read.clip().rotations, take.clip().rotations)
    np.testing.assert_array_equal(read.model.eq_solref, take.model.eq_solref)
    if kind == "tree":
        with pytest.raises(InvalidValue, match="performance"):
            drive_forces(read)
    else:
        np.testing.assert_array_equal(drive_forces(read).force, drive_forces(take).force)


def test_what_was_simulated_can_be_written_and_driven_again(gesture, tmp_path: Path):
    take = simulate(driven(gesture, Linkage.from_clip(gesture)))
    us.write(take, tmp_path / "a.bvh", tmp_path / "a.glb")
    again = us.read(tmp_path / "a.bvh", unit=gesture.conventions.unit, t_pose="keep")
    assert drive_error(simulate(driven(again, Linkage.from_clip(again)))).rms_mm < 1.0


def test_contact_keeps_feet_on_the_ground_while_the_body_sags(still):
    linkage = Linkage.from_clip(still, contact=True)
    clip = still.trimmed(0.0, 2.0)
    floor, none = (
        simulate(driven(clip, linkage, law="paper", gravity=9.81, ground=ground))
        for ground in (Ground(), None)
    )
    assert floor.poses()[1][-1, 1:, 2].min() > 0.0
    assert none.poses()[1][-1, 1:, 2].min() < -0.5


def test_settings_that_cannot_be_meant_are_refused(gesture):
    linkage = Linkage.from_clip(gesture)
    for settings, text in (
        ({"law": "published"}, "law is"),
        ({"law": "paper", "position_gain": 4.0}, "no position term"),
        ({"law": "paper", "feedforward": "gravity"}, "no feedforward"),
        ({"order": 4}, "order is 4"),
        ({"gain": -1.0}, "gain is"),
        ({"strength": np.full(len(linkage), 1.5)}, "strength must lie in 0 to 1"),
        ({"scaling": np.ones(3)}, "scaling has shape"),
        ({"scale": 0.0}, "scale is"),
        ({"substeps": 0}, "substeps is"),
        ({"velocity_scale": np.nan}, "velocity_scale is"),
    ):
        with pytest.raises(InvalidValue, match=text):
            driven(gesture, linkage, **settings)
    with pytest.raises(InvalidValue, match="not on the skeleton"):
        other = us.sample("walk")
        renamed = replace(other.skeleton, names=tuple(f"j{i}" for i in range(len(other.skeleton))))
        driven(replace(other, skeleton=renamed), linkage)
    with pytest.raises(InvalidValue, match=r"must be a Linkage|is no linkage"):
        person = us.Character.from_clip(gesture)
        driven(gesture, person)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="right_ball"):
        scaling_for(gesture, ["right_bal"], 1.2)
    with pytest.raises(InvalidValue, match="No frame"):
        scaling_for(gesture, ["neck"], 1.2, start=1.0, end=0.5)


def test_a_score_points_to_the_drives_own_error(gesture):
    take = simulate(driven(gesture.trimmed(0.0, 0.1), Linkage.from_clip(gesture)))
    with pytest.raises(InvalidValue, match="drive_error"):
        us.score(take)


def test_welford_is_the_mean_and_the_variance():
    values = 1e8 + np.random.default_rng(1).normal(size=(500, 4))
    mean, variance = welford(values)
    np.testing.assert_allclose(mean, values.mean(axis=0), rtol=1e-14)
    np.testing.assert_allclose(variance, values.var(axis=0, ddof=1), rtol=1e-6)


# -- real clips -----------------------------------------------------------------------------------

# Mean squared errors [units^2] of the plain law recorded in separate runs of this engine and of
# Bullet 3.2.7 (btRigidBody, point-to-point constraints): CMU 02_01 (walk), 29_01 (slow walk), 02_05
# (punch), every other frame of 120 Hz, T-pose dropped, three-point differences, the paper's K_f,
# scale 1, 9.81 units/s^2, one step of 1/60 s per frame.
RECORDED = {
    ("02_01", "independent"): (0.065, 0.01),
    ("29_01", "independent"): (0.418, 0.002),
    ("02_05", "independent"): (0.862, 0.002),
    ("02_01", "skeleton"): (0.26, 0.02),
    ("29_01", "skeleton"): (3.58, 0.002),
    ("02_05", "skeleton"): (6.96, 0.002),
    ("02_01", "constrained"): (0.524, 0.002),
    ("29_01", "constrained"): (6.559, 0.002),
    ("02_05", "constrained"): (12.917, 0.002),
    ("02_01", "tree"): (1.02, 0.005),
    ("29_01", "tree"): (7.54, 0.002),
    ("02_05", "tree"): (17.0, 0.005),
}
BULLET = {"02_01": (0.521, 0.01), "29_01": (6.551, 0.005), "02_05": (12.900, 0.005)}


def decimated(clips: Path, name: str) -> Clip:
    return us.read(clips / "cmu_bvh" / f"{name}.bvh", t_pose="drop").resampled(60.0)


@pytest.mark.clips
@pytest.mark.parametrize(("name", "kind"), RECORDED)
def test_errors_are_those_recorded_in_other_runs(clips: Path, name: str, kind: Kind):
    clip = decimated(clips, name)
    error = drive_error(simulate(driven(clip, Linkage.from_clip(clip, kind), law="paper", order=3)))
    value, tolerance = RECORDED[name, kind]
    assert error.mean == pytest.approx(value, rel=tolerance)
    if kind == "constrained":
        assert error.mean == pytest.approx(BULLET[name][0], rel=BULLET[name][1])


@pytest.mark.clips
@pytest.mark.parametrize("name", ["05_06", "49_02"])
def test_the_modern_law_holds_fast_dances_and_jumps(clips: Path, name: str):
    clip = us.read(clips / "cmu_bvh" / f"{name}.bvh")
    error = drive_error(simulate(driven(clip, Linkage.from_clip(clip), rate=60.0)))
    assert error.mean <= 0.01
    assert error.gap_max <= 0.05


def test_dense_and_sparse_jacobians_drive_joined_bodies_alike(gesture):
    """MuJoCo 4.0.0's sparse Newton solver can be wrong with contacts; here there are none."""
    performance = driven(gesture.trimmed(0.0, 0.5), Linkage.from_clip(gesture, "constrained"))
    ends = []
    for kind in (mujoco.mjtJacobian.mjJAC_DENSE, mujoco.mjtJacobian.mjJAC_SPARSE):
        scene = replace(performance.scene)
        scene.model.opt.jacobian = kind
        ends.append(simulate(replace(performance, scene=scene)).qpos[-1])
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-6)
