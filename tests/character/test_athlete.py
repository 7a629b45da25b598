"""The athlete's body: its hinges, its strength, and its motion as a clip."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from understudy.character import athlete, athlete_man, athlete_woman
from understudy.errors import InvalidValue, UnknownName
from understudy.scene import Scene


@pytest.fixture(scope="module", params=["man", "woman"])
def body(request):
    return athlete(request.param)


def test_it_has_17_segments_and_30_controlled_degrees_of_freedom(body):
    assert len(body.links) == 17
    assert body.controlled_dof == 30
    model = body.spec().compile()
    assert (model.nv, model.nu) == (36, 30)


def test_it_weighs_what_was_asked(body):
    model = body.spec().compile()
    assert model.body_mass.sum() == pytest.approx(body.mass)


def test_a_clip_of_it_is_where_the_engine_has_it(body):
    model = body.spec().compile()
    data = mujoco.MjData(model)
    rng = np.random.default_rng(1)
    rows = rng.uniform(-0.5, 0.5, (4, model.nq))
    rows[:, 3:7] /= np.linalg.norm(rows[:, 3:7], axis=1, keepdims=True)
    turned = body.local_rotations(rows)
    for row, local in zip(rows, turned, strict=True):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        from understudy.motion.clip import Clip

        clip = Clip(
            skeleton=body.skeleton,
            rotations=local[None],
            root_positions=row[None, :3],
            rate=60.0,
            name="pose",
        )
        assert clip.forward_kinematics().positions[0] == pytest.approx(data.xpos[1:], abs=1e-12)


def test_arms_hang_where_hinges_are_at_zero(body):
    model = body.spec().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for side in ("left", "right"):
        away = data.body(f"{side}_hand").xpos - data.body(f"{side}_upper_arm").xpos
        assert away[:2] == pytest.approx([0.0, 0.0], abs=1e-9)
        assert away[2] < -0.4


def test_motors_of_both_sides_are_equally_strong(body):
    model = body.spec().compile()
    for name in ("hip_y", "knee", "ankle", "ball", "shoulder_y", "elbow"):
        left = model.actuator(f"left_{name}").forcerange
        assert model.actuator(f"right_{name}").forcerange == pytest.approx(left)
    left, right = (model.actuator(f"{s}_shoulder_x").forcerange for s in ("left", "right"))
    assert right == pytest.approx(-left[::-1])


def test_the_ankle_is_twice_as_strong_as_one_on_a_dynamometer(body):
    # Anderson et al. 2007: plantarflexion 0.095 (men) and 0.104 (women) of weight times height.
    share = 0.095 if body.sex == "male" else 0.104
    low, _ = body.spec().compile().actuator("left_ankle").forcerange
    assert low == pytest.approx(-2.0 * share * body.mass * 9.81 * body.height)


def test_a_woman_is_smaller():
    assert athlete_woman().mass < athlete_man().mass


def test_an_unknown_athlete_names_those_there_are():
    with pytest.raises(UnknownName, match="woman"):
        athlete("wman")


def test_self_collision_is_refused():
    with pytest.raises(InvalidValue, match="do not touch"):
        athlete_man().spec(self_collision="pairs")


def test_two_share_a_scene():
    scene = Scene(characters=(athlete_man(), athlete_woman()))
    first, second = scene.parts
    assert first.qpos.stop == second.qpos.start == 37
    assert second.joint_controls == tuple(range(30, 60))


def test_an_athlete_of_another_height_weighs_in_proportion():
    tall = athlete("man", height=1.925)
    assert tall.mass == pytest.approx(70.0 * 1.1**3)
    assert athlete("woman", mass=50.0).mass == pytest.approx(50.0)
    assert athlete("woman", mass=50.0).height == pytest.approx(1.65)
