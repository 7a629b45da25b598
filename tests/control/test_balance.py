"""Two feet, no hand from above: the body keeps its balance, and the law is mechanics."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from understudy.character import Character, body
from understudy.character.footing import sole_of
from understudy.control import Balance, EngineState, Push, PythonController, balance_law
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import sample
from understudy.motion.samples.bowing import HELD, bow, trunk_tilt
from understudy.motion.skeleton import Skeleton
from understudy.performance import Performance, tracked
from understudy.scene import Ground, Scene
from understudy.simulate import prepared, simulate, simulate_many
from understudy.take import Take

HOLD = 3.1, 5.0


@pytest.fixture(scope="module")
def person() -> Character:
    return Character.from_clip(bow(60.0))


@pytest.fixture(scope="module")
def held(person: Character) -> Performance:
    return tracked(bow(80.0).trimmed(*HOLD), person, tasks=[Balance()])


@pytest.fixture(scope="module")
def standing(person: Character) -> Performance:
    """Two seconds of standing still, evenly."""
    clip = bow(60.0).trimmed(0.0, 2.0)
    rotations = np.broadcast_to(clip.rotations[:1], clip.rotations.shape)
    path = np.broadcast_to(clip.root_positions[:1], clip.root_positions.shape)
    still = replace(clip, rotations=rotations, root_positions=path)
    return tracked(still, person, tasks=[Balance()])


def pushed(performance: Performance, impulse: tuple[float, float, float], on: str) -> Performance:
    push = Push(time=0.2, on=on, impulse=impulse)
    return replace(performance, controllers=(*performance.controllers, push))


def from_support(take: Take, every: int = 20) -> np.ndarray:
    """Center of mass from the middle of the soles [m], shape (frames, 3)."""
    scene, data, out = take.scene, mujoco.MjData(take.model), []
    who, part = scene.characters[0], scene.parts[0]
    for q in take.qpos[::every]:
        data.qpos[:] = q
        mujoco.mj_kinematics(take.model, data)
        mujoco.mj_comPos(take.model, data)
        soles = []
        for side in ("left", "right"):
            foot = part.bodies[who.index(f"{side}_ankle")]
            middle = sole_of(who, side).middle
            soles.append(data.xpos[foot] + data.xmat[foot].reshape(3, 3) @ middle)
        out.append(data.subtree_com[part.bodies[0]] - np.mean(soles, axis=0))
    return np.array(out)


def without_legs(clip: Clip) -> Clip:
    """What is captured when only the upper body is."""
    skeleton = clip.skeleton
    legs = ("hip", "knee", "ankle", "ball")
    kept = [i for i, name in enumerate(skeleton.names) if not name.endswith(legs)]
    ends = [k for k, joint in enumerate(skeleton.end_joints) if joint in kept]
    parents = [skeleton.parents[i] for i in kept]
    upper = Skeleton(
        names=tuple(skeleton.names[i] for i in kept),
        parents=tuple(-1 if p < 0 else kept.index(p) for p in parents),
        offsets=skeleton.offsets[kept],
        end_joints=tuple(kept.index(skeleton.end_joints[k]) for k in ends),
        end_offsets=skeleton.end_offsets[ends],
    )
    return replace(clip, skeleton=upper, rotations=clip.rotations[:, kept])


class Moment:
    """A performance's law at some state: engine arrays and the law's numbers."""

    def __init__(self, performance: Performance, seed: int, size: float):
        self.model, self.data = prepared(performance)
        rng = np.random.default_rng(seed)
        part = performance.scene.parts[0]
        for i in range(len(part.bodies)):
            q = self.data.qpos[part.qpos.start + 3 + 4 * i :][:4]
            q[:] = rot.multiply(q, rot.from_rotvec(size * rng.normal(size=3)))
        self.data.qvel[:] = size * rng.normal(size=self.model.nv)
        mujoco.mj_forward(self.model, self.data)
        self.balance = next(c for c in performance.controllers if isinstance(c, Balance))
        _, self.p, _ = self.balance.feedback(performance.scene, self.model)
        self.state = EngineState.of(self.data)
        self.row = balance_law.BODIES + 2 * int(self.p[balance_law.MANY])
        self.soles = [
            balance_law.sole_at(self.state, self.p, balance_law.FEET + k * balance_law.FOOT)
            for k in (0, 1)
        ]


def test_a_legs_torques_are_its_weight_less_the_transposed_jacobian_of_the_push(held):
    at = Moment(held, seed=1, size=0.2)
    at.data.qvel[:] = 0.0
    mujoco.mj_forward(at.model, at.data)
    push = (*at.data.xpos[at.model.nbody - 1], 30.0, -20.0, 350.0)
    for k in range(6):
        foot = int(at.p[balance_law.FEET + (k // 3) * balance_law.FOOT])
        row = balance_law.ROWS + 8 * k
        jacobian = np.zeros((3, at.model.nv))
        mujoco.mj_jac(at.model, at.data, jacobian, None, np.array(push[:3]), foot)
        dofs = slice(int(at.p[row + 3]), int(at.p[row + 3]) + 3)
        expected = at.data.qfrc_bias[dofs] - jacobian[:, dofs].T @ np.array(push[3:])
        torque = balance_law.leg_torque(at.state, at.p, row, push)
        np.testing.assert_allclose(torque, expected, atol=1e-8)


def test_the_feet_give_the_force_and_moment_that_are_wanted_where_they_can(held):
    at = Moment(held, seed=2, size=0.0)
    force, moment = (15.0, -10.0, 700.0), (6.0, -4.0, 3.0)
    pushes = balance_law.shared(at.state, at.p, *at.soles, force, moment)
    np.testing.assert_allclose(np.sum([p[3:] for p in pushes], axis=0), force, atol=1e-9)
    center = at.data.subtree_com[int(at.p[balance_law.TREE])]
    turning = sum(np.cross(np.array(p[:3]) - center, p[3:]) for p in pushes)
    np.testing.assert_allclose(turning[:2], moment[:2], atol=1e-6)


def test_the_push_of_the_floor_never_leaves_the_feet(held):
    at = Moment(held, seed=3, size=0.0)
    for force in ((-900.0, 0.0, 660.0), (900.0, 900.0, 300.0), (0.0, -2000.0, 900.0)):
        for push, sole, k in zip(
            balance_law.shared(at.state, at.p, *at.soles, force, (300.0, -300.0, 50.0)),
            at.soles, (0, 1), strict=True,
        ):  # fmt: skip
            away = np.array(push[:2]) - np.array(sole[:2])
            foot = balance_law.FEET + k * balance_law.FOOT
            assert abs(away @ np.array(sole[3:5])) <= at.p[foot + 8] + 1e-9
            assert abs(away @ np.array(sole[5:7])) <= at.p[foot + 9] + 1e-9
            assert push[5] > 0.0


def test_the_velocity_of_the_center_of_mass_is_the_engines(held):
    at = Moment(held, seed=4, size=0.3)
    mujoco.mj_subtreeVel(at.model, at.data)
    velocity = balance_law.velocity_of(at.state, at.p, int(at.p[balance_law.MANY]))
    np.testing.assert_allclose(velocity, at.data.subtree_linvel[1], atol=1e-9)


def test_at_rest_over_the_feet_the_floor_is_asked_to_bear_the_weight(standing):
    at = Moment(standing, seed=5, size=0.0)
    at.data.qvel[:] = 0.0
    mujoco.mj_forward(at.model, at.data)
    force, moment = balance_law.wanted(at.state, at.p, at.row, *at.soles)
    weight = at.p[balance_law.MASS] * 9.81
    assert np.linalg.norm(force[:2]) < 0.03 * weight
    assert force[2] == pytest.approx(weight, rel=0.02)
    assert np.linalg.norm(moment) < 0.03 * weight


@pytest.mark.parametrize("degrees", [60.0, 80.0, 100.0])
def test_bows_are_held_with_the_center_of_mass_over_the_feet_and_no_help(person, degrees):
    take = simulate(tracked(bow(degrees).trimmed(*HOLD), person, tasks=[Balance()]))
    assert take.facts["pelvis"] == "free"
    assert not np.any(take.qfrc_applied)
    away = from_support(take)
    assert np.linalg.norm(away[:, :2], axis=1).max() < 0.010
    hold = slice(round((HELD[0] + 0.1 - HOLD[0]) * 120), None)
    assert trunk_tilt(take.clip())[hold] == pytest.approx(degrees, abs=1.0)


def test_legs_never_captured_hold_the_body_and_without_the_task_it_falls(person):
    clip = without_legs(bow(60.0).trimmed(1.3, 4.3))
    with_task = simulate(tracked(clip, person, tasks=[Balance()]))
    without = simulate(tracked(clip, person, pelvis="free"))
    assert np.linalg.norm(from_support(with_task)[:, :2], axis=1).max() < 0.010
    lowest = without.qpos[:, 2].min()
    assert lowest < 0.5 * without.qpos[0, 2]


def test_a_bow_survives_pushes_of_20_newton_seconds_from_four_sides(held):
    sides = ((20.0, 0.0, 0.0), (-20.0, 0.0, 0.0), (0.0, 20.0, 0.0), (0.0, -20.0, 0.0))
    runs = [pushed(held, side, on) for side in sides for on in ("pelvis", "chest")]
    for take in simulate_many(runs):
        assert isinstance(take, Take)
        away = from_support(take)
        assert np.linalg.norm(away[:, :2], axis=1).max() < 0.11
        assert np.linalg.norm(away[-1, :2]) < 0.03


def test_the_same_push_fells_the_body_that_only_tracks(standing):
    tracking = replace(standing, controllers=standing.controllers[:1])
    falls, stands = (simulate(pushed(p, (-20.0, 0.0, 0.0), "chest")) for p in (tracking, standing))
    assert np.linalg.norm(from_support(falls)[-1, :2]) > 0.3
    assert np.linalg.norm(from_support(stands)[-1, :2]) < 0.03


@pytest.mark.parametrize("step", [0.001, 0.004])
def test_steps_of_one_to_four_milliseconds_do(person, step):
    clip = bow(80.0).trimmed(3.2, 4.2)
    take = simulate(
        pushed(tracked(clip, person, tasks=[Balance()], timestep=step), (0, 20, 0), "pelvis")
    )
    assert np.linalg.norm(from_support(take)[:, :2], axis=1).max() < 0.08


@pytest.mark.parametrize("name", ["adult_woman", "child", "alien"])
def test_other_bodies_stand_and_gesture_on_their_own_feet(name):
    take = simulate(tracked(sample("gesture").trimmed(1.0, 2.5), body(name), tasks=[Balance()]))
    assert np.linalg.norm(from_support(take)[:, :2], axis=1).max() < 0.010


def test_a_push_from_the_other_side_gives_the_mirrored_motion(standing):
    short = replace(standing, duration=0.5)
    left, right = (
        from_support(simulate(pushed(short, (0.0, y, 0.0), "pelvis"))) for y in (10.0, -10.0)
    )
    assert np.abs(left[:, 1]).max() > 0.005
    # The sample's own pose leans a little to one side.
    np.testing.assert_allclose(left[:, 1], -right[:, 1], atol=0.002)


def test_the_law_gives_the_same_compiled_and_uncompiled(person):
    short = tracked(bow(60.0).trimmed(2.0, 2.1), person, tasks=[Balance()])
    beside = PythonController(function=lambda time, data: None)
    uncompiled = replace(short, controllers=(*short.controllers, beside))
    np.testing.assert_allclose(simulate(short).qpos, simulate(uncompiled).qpos, atol=1e-9)


def test_balancing_for_a_while_leaves_the_clip_alone_before_and_after(person):
    clip = sample("gesture").trimmed(0.0, 3.0)
    plain, task = tracked(clip, person), Balance(span=(1.0, 2.0))
    performance = tracked(clip, person, tasks=[task])
    before, after = (p.controllers[0].reference for p in (plain, performance))
    assert performance.controllers[0].pelvis == "assisted"
    outside = (before.times < 1.0) | (before.times > 2.0)
    assert rot.angle_between(before.rotations, after.rotations)[outside].max() < 1e-6
    assert rot.angle_between(before.rotations, after.rotations)[~outside].max() > 1e-3


def test_nonsense_is_refused(person):
    clip = sample("gesture").trimmed(0.0, 0.5)
    with pytest.raises(InvalidValue, match="left_hip"):
        tracked(clip, Character.from_clip(clip, plan="upper"), tasks=[Balance()])
    with pytest.raises(InvalidValue, match="begins at 9 s"):
        tracked(clip, person, tasks=[Balance(span=(9.0, 10.0))])
    with pytest.raises(InvalidValue, match="level"):
        prepared(tracked(clip, person, tasks=[Balance()], ground=Ground(slope=0.1)))
    with pytest.raises(InvalidValue, match="tracked"):
        prepared(
            Performance(scene=Scene(characters=(person,)), controllers=(Balance(),), duration=0.1)
        )
    with pytest.raises(InvalidValue, match="servos is 2"):
        Balance(servos=2.0)
    with pytest.raises(InvalidValue, match="stiffness is nan"):
        Balance(stiffness=float("nan"))
    turned = np.array(clip.rotations)
    spin = rot.from_euler("Z", np.linspace(0.0, 3.0, clip.frames)[:, None])
    turned[:, 0] = rot.multiply(spin, turned[:, 0])
    with pytest.raises(InvalidValue, match="away from the feet"):
        tracked(replace(clip, rotations=turned), person, tasks=[Balance()])
