from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from people import DIALECTS, moving, person, renamed, still, without
from test_roles import chain, dog, with_extras

from understudy.character.body import Character, Link, Shape
from understudy.character.mapping import Mapping
from understudy.character.masses import measured_properties
from understudy.character.solids import Section, capsule, loft
from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.figure import LINKS, ROLES
from understudy.motion.skeleton import Skeleton
from understudy.performance import tracked

CLIP = moving(renamed(person(), DIALECTS["motionbuilder"]))


def center(character: Character) -> np.ndarray:
    """Center of mass of the rest pose [m]."""
    rest = character.skeleton.rest_positions()
    parts = [link.mass * (link.com + at) for link, at in zip(character.links, rest, strict=True)]
    return np.sum(parts, axis=0) / character.simulated_mass


@pytest.mark.parametrize(
    ("plan", "links", "dof"),
    [("full", 18, 51), ("full16", 17, 48), ("upper", 10, 27), ("upper8", 9, 24)],
)
def test_plans_have_the_papers_degrees_of_freedom(plan, links, dof):
    character = Character.from_clip(CLIP, plan=plan)
    assert len(character.links) == links
    assert character.controlled_dof == dof


def test_links_come_in_the_standard_order():
    character = Character.from_clip(CLIP)
    assert [link.joint for link in character.links] == list(ROLES)
    assert [link.name for link in character.links] == [LINKS[r] for r in ROLES]


@pytest.mark.parametrize("sex", ["female", "male"])
@pytest.mark.parametrize("parameters", ["de_leva", "dempster"])
@pytest.mark.parametrize("plan", ["full", "full16"])
def test_links_add_up_to_the_body_mass(sex, parameters, plan):
    character = Character.from_clip(
        CLIP, plan=plan, sex=sex, mass=70.0, segment_parameters=parameters
    )
    assert character.simulated_mass == pytest.approx(70.0, abs=1e-9)


def test_an_upper_body_lacks_exactly_its_legs():
    upper = Character.from_clip(CLIP, plan="upper", mass=70.0)
    legs = 2 * (0.1416 + 0.0433 + 0.0137)
    assert upper.simulated_mass == pytest.approx(70.0 * (1 - legs), abs=1e-9)
    assert upper.mass == 70.0


def test_a_folded_joint_changes_no_mass():
    whole = Character.from_clip(CLIP, mass=70.0)
    skeleton = without(CLIP.skeleton, "LeftToeBase", "RightToeBase", "LeftHand", "RightHand")
    lesser = Character.from_clip(still(skeleton), mass=70.0)
    assert lesser.simulated_mass == pytest.approx(70.0, abs=1e-9)
    foot = whole.link("left_foot").mass + whole.link("left_toes").mass
    assert lesser.link("left_foot").mass == pytest.approx(foot)
    arm = whole.link("left_forearm").mass + whole.link("left_hand").mass
    assert lesser.link("left_forearm").mass == pytest.approx(arm)


def test_the_body_is_symmetric():
    character = Character.from_clip(still(person()))
    assert center(character)[1] == pytest.approx(0.0, abs=1e-12)
    mirror = np.array([1.0, -1.0, 1.0])
    for link in character.links:
        if link.name.startswith("left_"):
            other = character.link(link.name.replace("left_", "right_"))
            assert link.mass == pytest.approx(other.mass)
            assert link.com * mirror == pytest.approx(other.com, abs=1e-12)
            assert link.inertia * np.outer(mirror, mirror) == pytest.approx(other.inertia)


def test_the_center_of_mass_lies_where_people_have_it():
    """About 0.56 of stature in a man who lets his arms hang (Winter 2009)."""
    clip = still(person(height=1.78), frames=1)
    character = Character.from_clip(clip, height=1.78)
    skeleton = character.skeleton
    rotations = np.array(still(skeleton).rotations)
    for side, sign in (("left", -1.0), ("right", 1.0)):
        rotations[0, skeleton.index(f"{side}_shoulder")] = rot.from_rotvec(
            np.array([sign * np.pi / 2, 0.0, 0.0])
        )
    pose = replace(still(skeleton), rotations=rotations).forward_kinematics()
    parts = [
        link.mass * (pose.positions[0, i] + rot.rotate(pose.rotations[0, i], link.com))
        for i, link in enumerate(character.links)
    ]
    height = np.sum(parts, axis=0)[2] / character.simulated_mass
    assert height / 1.78 == pytest.approx(0.56, abs=0.015)


def test_height_comes_from_the_legs():
    assert Character.from_clip(still(person(height=1.6))).height == pytest.approx(1.6, rel=0.01)
    given = Character.from_clip(still(person(height=1.6)), height=1.8)
    assert given.height == 1.8
    assert given.mass == pytest.approx(22.0 * 1.8**2)


@pytest.mark.parametrize(
    "gone", [("left_hip", "right_hip"), ("left_ankle", "right_ankle", "left_wrist", "right_wrist")]
)
def test_height_comes_from_whatever_limbs_there_are(gone):
    skeleton = renamed(without(person(height=1.6), *gone), DIALECTS["motionbuilder"])
    assert Character.from_clip(still(skeleton)).height == pytest.approx(1.6, rel=0.02)


@pytest.mark.parametrize(("height", "doubted"), [(0.7, 1), (0.9, 0), (2.2, 0), (2.5, 1)])
def test_a_person_of_unlikely_height_is_doubted_in_a_note(height, doubted):
    character = Character.from_clip(still(person(height=height)))
    notes = [note for note in character.notes if "check unit= (--unit)" in note]
    assert len(notes) == doubted
    assert all(f"{character.height:.2f} m tall" in note for note in notes)
    clip = still(person(height=height))
    reference = tracked(clip, character).controllers[0].reference
    assert [note for note in reference.notes if note in notes] == notes


def test_a_height_that_is_given_is_not_doubted():
    character = Character.from_clip(still(person(height=0.7)), height=0.7)
    assert not any("check unit" in note for note in character.notes)


def test_a_wrong_unit_is_refused():
    huge = replace(CLIP, skeleton=CLIP.skeleton.scaled(100.0))
    with pytest.raises(InvalidValue, match="right unit"):
        Character.from_clip(huge)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_rest_pose_is_the_t_pose_in_every_dialect(dialect):
    """Arms out to the sides, legs straight down, whatever the clip's frames."""
    character = Character.from_clip(moving(renamed(person(), DIALECTS[dialect])))
    for name, way in (
        ("left_forearm", [0, 1, 0]),
        ("right_hand", [0, -1, 0]),
        ("left_shank", [0, 0, -1]),
        ("right_foot", [0, 0, -1]),
    ):
        offset = character.link(name).offset
        assert offset / np.linalg.norm(offset) == pytest.approx(way, abs=1e-9), name


def test_a_file_without_a_t_pose_is_aligned_by_its_motion():
    """All joint frames turned at random: the neutral stance is found in the frames."""
    skeleton = person()
    clip = moving(skeleton, frames=200, size=0.25)
    rotations = np.array(clip.rotations)
    rotations[0] = rot.identity(len(skeleton))
    clip = replace(clip, rotations=rotations)
    scrambled, turns = _scrambled(clip)
    straight, odd = Character.from_clip(clip), Character.from_clip(scrambled)
    assert "frame at" in " ".join(odd.notes)
    for joint in ("left_elbow", "left_knee", "left_hip", "right_shoulder"):
        one, two = straight.link(joint), odd.link(joint)
        # What the alignments say of one and the same file frame, apart in degrees.
        there = rot.multiply(turns[skeleton.index(joint)], two.alignment)
        assert np.degrees(rot.angle_between(one.alignment, there)) < 25.0, joint


def _scrambled(clip):
    """The same motion with every joint's own frame turned by a constant."""
    random = np.random.default_rng(3)
    skeleton = clip.skeleton
    turns = rot.normalized(random.normal(size=(len(skeleton), 4)))
    world = clip.forward_kinematics().rotations
    new_world = rot.multiply(world, turns)
    local = np.array(new_world)
    offsets = np.array(skeleton.offsets)
    for i, p in enumerate(skeleton.parents[1:], 1):
        local[:, i] = rot.multiply(rot.conjugate(new_world[:, p]), new_world[:, i])
        offsets[i] = rot.rotate(rot.conjugate(turns[p]), skeleton.offsets[i])
    carriers = list(skeleton.end_joints)
    ends = rot.rotate(rot.conjugate(turns[carriers]), skeleton.end_offsets)
    turned = replace(skeleton, offsets=offsets, end_offsets=ends)
    return replace(clip, skeleton=turned, rotations=local), turns


def test_soles_rest_on_the_ground():
    character = Character.from_clip(still(person()))
    rest = character.skeleton.rest_positions()
    for side in ("left", "right"):
        ankle = rest[character.index(f"{side}_foot")]
        assert ankle[2] + character.sole_height == pytest.approx(0.0, abs=1e-12)


def test_inertia_from_shapes_is_near_the_published():
    """An independent estimate of a 73 kg man: drawn shapes filled with Dempster's densities."""
    clip = still(person(height=1.741))
    drawn = Character.from_clip(clip, height=1.741, inertia="geometry")
    assert drawn.mass == pytest.approx(73.0, rel=0.15)
    assert drawn.simulated_mass == pytest.approx(drawn.mass)
    published = Character.from_clip(clip, height=1.741, mass=73.0)
    assert center(drawn) == pytest.approx(center(published), abs=0.03)
    for name in ("left_thigh", "left_upper_arm", "left_shank", "chest"):
        ratio = np.trace(drawn.link(name).inertia) / np.trace(published.link(name).inertia)
        assert 0.5 < ratio < 2.0, name
    scaled = Character.from_clip(clip, height=1.741, mass=50.0, inertia="geometry")
    assert scaled.simulated_mass == pytest.approx(50.0)


def test_a_capsule_has_its_exact_inertia():
    solid = capsule(np.zeros(3), np.array([0.0, 0.0, 0.4]), 0.05, density=1000.0)
    own = measured_properties({"a": (solid,)})["a"]
    cylinder = 1000 * np.pi * 0.05**2 * 0.4
    balls = 1000 * 4 / 3 * np.pi * 0.05**3
    assert own.mass == pytest.approx(cylinder + balls)
    assert own.com == pytest.approx([0, 0, 0.2])
    along = cylinder * 0.05**2 / 2 + balls * 0.4 * 0.05**2
    assert own.inertia[2, 2] == pytest.approx(along)


def test_a_loft_of_a_cylinder_has_its_volume():
    sections = [Section(np.array([0, 0, z]), 0.1, 0.1) for z in (0.0, 0.5)]
    vertices, faces = loft(sections, across=np.array([1.0, 0, 0]), start_dome=0.0, end_dome=0.0)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = np.sum(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6.0
    polygon = 20 / 2 * np.sin(2 * np.pi / 20) * 0.1**2
    assert volume == pytest.approx(polygon * 0.5, rel=1e-6)


def test_limits_never_fight_the_clip():
    wild = moving(CLIP.skeleton, size=2.0)
    character = Character.from_clip(wild)
    pose = wild.forward_kinematics()
    for link in character.links[1:]:
        if link.motion_limit is None:
            continue
        inboard = character.links[link.parent]
        turned = [
            rot.multiply(pose.rotations[:, wild.skeleton.index(k.clip_joint)], k.alignment)
            for k in (inboard, link)
        ]
        assert rot.angle_between(*turned).max() < link.motion_limit


def test_neighbors_never_collide():
    character = Character.from_clip(CLIP)
    neighbors = {frozenset((character.links[k.parent].name, k.name)) for k in character.links[1:]}
    assert not neighbors & {frozenset(pair) for pair in character.self_collisions}
    assert ("left_hand", "right_hand") in character.self_collisions


def test_extra_joints_are_folded():
    skeleton = with_extras(renamed(person(), DIALECTS["motionbuilder"]))
    character = Character.from_clip(moving(skeleton))
    assert len(character.links) == 18
    assert not any(
        link.clip_joint in ("LHipJoint", "LeftThumb1", "Tail") for link in character.links
    )


def test_what_was_assumed_is_noted():
    notes = " ".join(Character.from_clip(CLIP).notes)
    assert "Height 1.7" in notes
    assert "body-mass index of 22" in notes
    assert "rest pose" in notes


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"plan": "lower"}, "plan is 'lower'"),
        ({"sex": "other"}, "sex is 'other'"),
        ({"mass": -1.0}, "mass is -1.0 kg"),
        ({"mass": float("nan")}, "mass is nan kg"),
        ({"height": 40.0}, "height is 40.0 m"),
        ({"inertia": "guess"}, "inertia is 'guess'"),
        ({"segment_parameters": "x"}, "segment_parameters is 'x'"),
    ],
)
def test_options_outside_their_choices_are_refused(options, message):
    with pytest.raises(InvalidValue, match=message):
        Character.from_clip(CLIP, **options)


@pytest.mark.parametrize("joints", [1, 2, 30, 200])
def test_any_chain_becomes_a_character(joints):
    character = Character.from_clip(still(chain(joints)))
    assert len(character.links) == joints
    assert not character.humanoid
    assert character.simulated_mass > 0


def test_a_skeleton_too_small_to_simulate_is_refused():
    with pytest.raises(InvalidValue, match="right unit"):
        Character.from_clip(still(chain(5).scaled(0.01)))


def test_a_dog_gets_one_link_per_bone_of_water():
    skeleton = dog()
    character = Character.from_clip(moving(skeleton))
    assert len(character.links) == len(skeleton)
    density = {s.density for link in character.links for s in link.shapes}
    assert density == {1000.0}
    assert all(np.array_equal(link.alignment, [1, 0, 0, 0]) for link in character.links)


def test_zero_length_joints_of_other_skeletons_fold_only_when_nothing_is_lost():
    skeleton = Skeleton(
        names=("a", "idle", "b", "turning", "c"),
        parents=(-1, 0, 1, 0, 3),
        offsets=np.array([[0, 0, 1], [0, 0, 0], [0.3, 0, 0], [0, 0, 0], [0, 0.3, 0]], float),
    )
    rotations = np.array(still(skeleton, 10).rotations)
    angles = np.linspace(0, 1, 10)[:, None] * [0.0, 0.0, 1.0]
    rotations[:, 3] = rot.from_rotvec(angles)
    clip = replace(still(skeleton, 10), rotations=rotations)
    names = [link.name for link in Character.from_clip(clip).links]
    assert names == ["a", "b", "turning", "c"]
    mapping = Mapping(drop=("turning",))
    assert [k.name for k in Character.from_clip(clip, mapping=mapping).links] == ["a", "b"]


def test_the_same_clip_gives_the_same_character():
    one, two = Character.from_clip(CLIP), Character.from_clip(CLIP)
    for a, b in zip(one.links, two.links, strict=True):
        assert np.array_equal(a.inertia, b.inertia)
        assert np.array_equal(a.alignment, b.alignment)


def test_links_are_found_by_name_or_joint():
    character = Character.from_clip(CLIP)
    assert character.link("left_shank") is character.link("left_knee")
    with pytest.raises(UnknownName, match="Did you mean 'left_shank'"):
        character.link("left_shnk")


def test_impossible_links_and_shapes_are_refused():
    details = {"name": "a", "joint": "a", "role": None, "parent": -1, "offset": np.zeros(3)}
    with pytest.raises(InvalidValue, match="mass 0"):
        Link(**details, mass=0.0, com=np.zeros(3), inertia=np.eye(3))
    with pytest.raises(InvalidValue, match="principal inertias"):
        Link(**details, mass=1.0, com=np.zeros(3), inertia=np.diag([1.0, 1.0, 3.0]))
    with pytest.raises(InvalidValue, match="0 faces"):
        Shape(kind="mesh")
