"""Linkages: bodies where the joints are, joints that hold, locks that lock."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

import understudy as us
from understudy.character import Linkage, Lock
from understudy.character.linkage import KINDS
from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.skeleton import Skeleton
from understudy.scene import Scene


@pytest.fixture(scope="module")
def clip() -> Clip:
    return us.sample("gesture").trimmed(0.0, 1.0).resampled(60.0)


def breadth_first() -> Clip:
    """A clip whose joints are listed level by level, which no tree of bodies is."""
    skeleton = Skeleton(
        names=("root", "a", "b", "a2", "b2"),
        parents=(-1, 0, 0, 1, 2),
        offsets=[[0, 0, 1], [0.3, 0, 0], [-0.3, 0, 0], [0.2, 0, 0.1], [0, 0, 0]],
    )
    rng = np.random.default_rng(5)
    return Clip(
        skeleton=skeleton,
        rotations=rot.from_rotvec(rng.normal(size=(3, 5, 3))),
        root_positions=rng.normal(size=(3, 3)),
        rate=60.0,
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_engine_puts_every_body_where_the_clip_has_its_joint(clip, kind):
    for motion in (clip, breadth_first()):
        linkage = Linkage.from_clip(motion, kind)
        scene = Scene(characters=(linkage,), ground=None)
        pose = motion.forward_kinematics()
        placed, turned = linkage.placed(pose.positions, pose.rotations)
        state = linkage.coordinates(placed, turned)
        data = mujoco.MjData(scene.model)
        bodies = list(scene.parts[0].bodies)
        for k in (0, motion.frames - 1):
            data.qpos[:] = state[k]
            mujoco.mj_kinematics(scene.model, data)
            ends = data.xpos[bodies] + rot.rotate(data.xquat[bodies], linkage.ends)
            np.testing.assert_allclose(ends, pose.positions[k], atol=1e-12)
        again, rotations = linkage.poses(state)
        np.testing.assert_allclose(again, placed, atol=1e-12)
        assert np.abs(rot.angle_between(rotations, turned)).max() < 1e-7


@pytest.mark.parametrize("kind", KINDS)
def test_bodies_give_the_joint_rotations_back(clip, kind):
    linkage = Linkage.from_clip(clip, kind)
    pose = clip.forward_kinematics()
    _, turned = linkage.placed(pose.positions, pose.rotations)
    found = linkage.joint_rotations(turned, clip.rotations)
    assert np.abs(rot.angle_between(found, clip.rotations)).max() < 1e-7


def test_inertias_are_the_engines_of_solid_capsules(clip):
    linkage = Linkage.from_clip(clip, "skeleton", radius=0.03)
    spec = mujoco.MjSpec()
    for j in range(len(linkage)):
        body = spec.worldbody.add_body(name=f"{j}")
        shapes = mujoco.mjtGeom
        kind = shapes.mjGEOM_CAPSULE if linkage.lengths[j] else shapes.mjGEOM_SPHERE
        body.add_geom(type=kind, size=[0.03, 0.5 * linkage.lengths[j], 0], mass=linkage.masses[j])
    model = spec.compile()
    np.testing.assert_allclose(linkage.inertias, model.body_inertia[1:], rtol=1e-9)
    own = linkage.spec().compile()
    np.testing.assert_allclose(own.body_inertia[1:], linkage.inertias, rtol=1e-12)
    np.testing.assert_allclose(own.body_ipos, 0.0)
    np.testing.assert_allclose(own.body_iquat[:, 0], 1.0)


def test_masses_are_one_or_named_or_a_persons(clip):
    assert Linkage.from_clip(clip).mass == len(clip.skeleton)
    named = Linkage.from_clip(clip, masses={"left_knee": 5.0})
    assert named.masses[named.index("left_knee")] == 5.0
    assert named.mass == len(clip.skeleton) + 4.0
    assert named.weighing({"neck": 2.0}).mass == named.mass + 1.0
    person = Linkage.from_clip(clip, masses="anthropometry", mass=80.0)
    assert person.mass == pytest.approx(80.0)
    # The bone that ends at the knee is the thigh, a tenth to a sixth of a person.
    assert 8.0 < person.masses[person.index("left_knee")] < 13.0


def test_what_cannot_be_meant_is_refused(clip):
    with pytest.raises(InvalidValue, match="independent, skeleton, constrained, tree"):
        Linkage.from_clip(clip, "ragdoll")  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="masses of 'neck' is -1"):
        Linkage.from_clip(clip, masses={"neck": -1.0})
    with pytest.raises(UnknownName, match="left_knee"):
        Linkage.from_clip(clip, masses={"left_nee": 1.0})
    with pytest.raises(InvalidValue, match="radii"):
        Linkage.from_clip(clip, radius=0.0)
    with pytest.raises(InvalidValue, match="unit"):
        Linkage.from_clip(clip, unit=0.0)
    with pytest.raises(InvalidValue, match="no joints"):
        Linkage.from_clip(clip, "skeleton", locks=[Lock(joint="left_knee")])
    with pytest.raises(UnknownName, match="left_knee"):
        Linkage.from_clip(clip).locked("left_nee")
    with pytest.raises(InvalidValue, match="No bone begins"):
        Linkage.from_clip(clip).locked("left_ball")
    with pytest.raises(InvalidValue, match="axes"):
        Lock(joint="left_knee", axes="w")
    with pytest.raises(InvalidValue, match="twice"):
        Linkage.from_clip(clip, locks=[Lock(joint="left_knee"), Lock(joint="left_knee", axes="x")])


@pytest.mark.parametrize("kind", ["constrained", "tree"])
@pytest.mark.parametrize("axes", ["xyz", "x", "y", "z", "xy", "xz", "yz"])
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.7, 0.2, -0.3)])
def test_a_locked_joint_meets_its_constraints_and_another_does_not(clip, kind, axes, turn):
    rotation = rot.from_rotvec(turn)
    linkage = Linkage.from_clip(clip, kind).locked("right_elbow", axes=axes, rotation=rotation)
    model = linkage.spec().compile()
    data = mujoco.MjData(model)
    rng = np.random.default_rng(2)
    wild = replace(
        clip, rotations=rot.from_rotvec(0.5 * rng.normal(size=(*clip.rotations.shape[:2], 3)))
    )

    def violation(motion: Clip) -> float:
        pose = motion.forward_kinematics()
        data.qpos[:] = linkage.coordinates(*linkage.placed(pose.positions, pose.rotations))[7]
        mujoco.mj_forward(model, data)
        return float(np.abs(data.efc_pos).max())

    assert violation(linkage.held(wild)) < 1e-9
    assert violation(wild) > 1e-3


def test_two_linkages_and_a_character_share_a_scene(clip):
    one = Linkage.from_clip(clip, "tree")
    two = Linkage.from_clip(clip).locked("left_elbow", axes="x")
    person = us.Character.from_clip(clip)
    scene = Scene(characters=(one, two, person))
    assert scene.model.nq == one.widths[0] + two.widths[0] + 3 + 4 * len(person.links)
    assert scene.parts[1].qpos.start == one.widths[0]
    # Somebody has servos, whose damping an explicit step would not take implicitly.
    assert scene.model.opt.integrator == int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    alone = Scene(characters=two, ground=None)
    assert alone.model.opt.integrator == int(mujoco.mjtIntegrator.mjINT_EULER)


def test_linkages_with_contact_land_on_the_ground(clip):
    from understudy.performance import Performance
    from understudy.scene import Ground
    from understudy.simulate import simulate

    linkage = Linkage.from_clip(clip, contact=True)
    scene = Scene(characters=linkage, ground=Ground())
    take = simulate(Performance(scene=scene, duration=1.5))
    _, placed, _ = take.poses()
    assert placed[-1, 1:, 2].min() > 0.0
    assert placed[-1, 1, 2] < 0.6 * placed[0, 1, 2]


def test_a_skeleton_of_one_joint_is_one_sphere():
    one = Clip(
        skeleton=Skeleton(names=("ball",), parents=(-1,), offsets=[[0, 0, 1]]),
        rotations=rot.identity(4, 1),
        root_positions=np.zeros((4, 3)),
        rate=60.0,
    )
    for kind in KINDS:
        assert Linkage.from_clip(one, kind).spec().compile().nv == 6
    with pytest.raises(InvalidValue, match="not recognized"):
        Linkage.from_clip(one, masses="anthropometry")
