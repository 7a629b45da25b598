from __future__ import annotations

import mujoco
import numpy as np
import pytest
from people import DIALECTS, moving, person, renamed, still
from test_roles import chain, dog

from understudy.character import adult_man, adult_woman, alien, child, retargeted
from understudy.character.body import Character
from understudy.errors import InvalidValue
from understudy.motion.figure import ROLES

CLIP = moving(renamed(person(), DIALECTS["motionbuilder"]))
SKELETONS = {
    "person": CLIP.skeleton,
    "dog": dog(),
    "chain": chain(30),
    "single": chain(1),
}


def standing(character: Character) -> np.ndarray:
    """Positions of the rest pose, shape (nq,)."""
    skeleton = character.skeleton
    return np.concatenate([skeleton.offsets[0], np.tile([1.0, 0, 0, 0], len(skeleton))])


@pytest.mark.parametrize("name", SKELETONS)
def test_mujoco_places_every_link_where_the_clip_does(name):
    clip = moving(SKELETONS[name])
    character = Character.from_clip(clip)
    own = retargeted(clip, character)
    model = character.spec().compile()
    data = mujoco.MjData(model)
    pose = own.forward_kinematics()
    for frame in range(0, own.frames, 7):
        data.qpos[:3] = own.root_positions[frame]
        data.qpos[3:] = own.rotations[frame].ravel()
        mujoco.mj_kinematics(model, data)
        assert data.xpos[1:] == pytest.approx(pose.positions[frame], abs=1e-9)
        dots = np.abs(np.sum(data.xquat[1:] * pose.rotations[frame], axis=1))
        assert dots == pytest.approx(1.0, abs=1e-12)


def test_bodies_joints_and_actuators_come_in_link_order():
    character = Character.from_clip(CLIP)
    model = character.spec().compile()
    assert [model.body(i + 1).name for i in range(18)] == [k.name for k in character.links]
    joints = [model.joint(i).name for i in range(model.njnt)]
    assert joints == ["root_x", "root_y", "root_z", *ROLES]
    servos = [model.actuator(i).name for i in range(model.nactuator)]
    assert servos == [*ROLES[1:], "root_x", "root_y", "root_z", "root"]
    assert (model.nq, model.nv) == (3 + 4 * 18, 3 + 3 * 18)
    assert model.nu == 4 * 17 + 2 * 3 + 4
    assert {model.site(i).name for i in range(model.nsite)} == {
        f"{side}_{what}" for side in ("left", "right") for what in ("sole", "palm")
    }


def test_servos_do_nothing_until_they_get_gains():
    model = Character.from_clip(CLIP).spec().compile()
    data = mujoco.MjData(model)
    data.qpos[:] = standing(Character.from_clip(CLIP))
    data.ctrl[:] = 1.0
    mujoco.mj_forward(model, data)
    assert np.all(data.qfrc_actuator == 0.0)


@pytest.mark.parametrize("body", [adult_man, adult_woman, child, alien])
def test_the_compiled_body_weighs_what_it_should(body):
    character = body()
    model = character.spec().compile()
    assert model.body_mass.sum() == pytest.approx(character.mass, abs=1e-9)
    for i, link in enumerate(character.links, 1):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.body_iquat[i])
        axes = turn.reshape(3, 3)
        inertia = axes @ np.diag(model.body_inertia[i]) @ axes.T
        assert inertia == pytest.approx(link.inertia, abs=1e-9)


@pytest.mark.parametrize("body", [adult_man, adult_woman, child, alien])
def test_the_rest_pose_stands_on_flat_soles(body):
    character = body()
    spec = character.spec()
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1], contype=1, conaffinity=1
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = standing(character)
    data.qpos[2] -= 1e-4
    mujoco.mj_forward(model, data)
    touching = {model.body(model.geom_bodyid[c.geom2]).name for c in data.contact}
    assert touching == {"left_foot", "right_foot", "left_toes", "right_toes"}
    assert data.contact.dist == pytest.approx(-1e-4, abs=1e-9)


def test_every_link_can_lie_on_the_ground_once():
    """Feet and hands by their contact shapes, the rest by those for self-collision, never both."""
    character = Character.from_clip(CLIP)
    model = character.spec().compile()
    touching = {model.body(b).name for b in model.geom_bodyid[model.geom_conaffinity > 0]}
    assert touching == {link.name for link in character.links}
    for link in character.links:
        if any(shape.contact for shape in link.shapes):
            uses = {
                shape.use
                for k, shape in enumerate(link.shapes)
                if model.geom(f"{link.name}_{k}").conaffinity[0] > 0
            }
            assert uses == {"contact"}


def test_links_of_one_body_pass_through_each_other_unless_asked():
    character = adult_man()
    squeezed = standing(character)
    at = 3 + 4 * character.index("left_hip")
    squeezed[at : at + 4] = [np.cos(0.2), -np.sin(0.2), 0.0, 0.0]  # left leg swung inward
    for choice, touches in (("off", False), ("pairs", True)):
        model = character.spec(self_collision=choice).compile()
        data = mujoco.MjData(model)
        data.qpos[:] = squeezed
        mujoco.mj_forward(model, data)
        assert (data.ncon > 0) == touches


def test_nothing_touches_in_the_rest_pose():
    for body in (adult_man(), adult_woman(), child(), alien()):
        model = body.spec(self_collision="pairs").compile()
        data = mujoco.MjData(model)
        data.qpos[:] = standing(body)
        mujoco.mj_forward(model, data)
        assert data.ncon == 0, body.name


def test_limits_stop_an_elbow_at_its_range():
    character = adult_man()
    for choice, rows in (("off", 0), ("on", 1)):
        model = character.spec(limits=choice).compile()
        data = mujoco.MjData(model)
        data.qpos[:] = standing(character)
        at = 3 + 4 * character.index("left_elbow")
        half = np.radians(150.0) / 2
        data.qpos[at : at + 4] = [np.cos(half), 0.0, 0.0, -np.sin(half)]
        mujoco.mj_forward(model, data)
        assert data.nefc == rows


def test_free_fall_is_free():
    """No joint friction or contact slows a falling body: drop = g t^2 / 2."""
    character = adult_man()
    model = character.spec().compile()
    model.opt.timestep = 1e-3
    data = mujoco.MjData(model)
    data.qpos[:] = standing(character)
    mujoco.mj_forward(model, data)
    before = data.subtree_com[1, 2]
    for _ in range(200):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    # Semi-implicit steps fall g h t / 2 further than the parabola.
    drop = 9.81 * 0.2**2 / 2 + 9.81 * 1e-3 * 0.2 / 2
    assert before - data.subtree_com[1, 2] == pytest.approx(drop, rel=1e-9)


def test_choices_outside_are_refused():
    character = adult_man()
    with pytest.raises(InvalidValue, match="self_collision"):
        character.spec(self_collision="all")  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="limits"):
        character.spec(limits="human")  # type: ignore[arg-type]


def test_every_call_gives_a_fresh_model():
    character = Character.from_clip(still(person()))
    one, two = character.spec(), character.spec()
    one.worldbody.add_body(name="prop")
    assert two.body("prop") is None
