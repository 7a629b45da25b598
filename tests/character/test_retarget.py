from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from people import DIALECTS, moving, person, renamed, still, without
from test_roles import chain, dog, with_extras

from understudy.character import adult_man, alien, child, restored, retargeted
from understudy.character.body import Character
from understudy.character.soles import sole_heights
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import sample

CLIP = moving(renamed(person(), DIALECTS["motionbuilder"]))


def apart(one: Clip, two: Clip) -> float:
    """Largest distance of any joint [m]."""
    a, b = one.forward_kinematics(), two.forward_kinematics()
    return float(np.abs(a.positions - b.positions).max())


@pytest.mark.parametrize("skeleton", [CLIP.skeleton, dog(), chain(1), chain(40)])
def test_a_clip_goes_exactly_onto_its_own_character(skeleton):
    clip = moving(skeleton, size=1.2)
    character = Character.from_clip(clip)
    own = retargeted(clip, character).forward_kinematics()
    captured = clip.forward_kinematics()
    for i, link in enumerate(character.links):
        joint = skeleton.index(link.origin_joint)
        assert own.positions[:, i] == pytest.approx(captured.positions[:, joint], abs=1e-9)


@pytest.mark.parametrize("skeleton", [CLIP.skeleton, dog(), chain(1), with_extras(CLIP.skeleton)])
def test_restored_undoes_retargeted(skeleton):
    clip = moving(skeleton, size=1.0)
    character = Character.from_clip(clip)
    back = restored(retargeted(clip, character), clip, character)
    assert back.skeleton == clip.skeleton
    assert apart(back, clip) < 1e-9
    assert rot.angle_between(back.rotations, clip.rotations).max() < 1e-7


def test_folded_joints_keep_what_was_captured():
    """Fingers move on while the arm does something else, at another rate."""
    clip = moving(with_extras(CLIP.skeleton), frames=61)
    character = Character.from_clip(clip)
    performed = retargeted(clip, character).resampled(60.0)
    rotations = np.array(performed.rotations)
    rotations[:, character.index("left_elbow")] = [1.0, 0.0, 0.0, 0.0]
    back = restored(replace(performed, rotations=rotations), clip, character)
    captured = clip.resampled(60.0)
    thumb = clip.skeleton.index("LeftThumb1")
    assert rot.angle_between(back.rotations[:, thumb], captured.rotations[:, thumb]).max() < 1e-7
    elbow = clip.skeleton.index("LeftForeArm")
    assert rot.angle_between(back.rotations[:, elbow], captured.rotations[:, elbow]).max() > 0.1


def test_an_upper_body_leaves_the_captured_legs():
    character = Character.from_clip(CLIP, plan="upper")
    back = restored(retargeted(CLIP, character), CLIP, character)
    assert apart(back, CLIP) < 1e-9


def test_edits_of_the_clip_still_go_over_exactly():
    character = Character.from_clip(CLIP)
    own = retargeted(CLIP.resampled(77.0).retimed(1.5), character)
    assert own.forward_kinematics().positions[0] == pytest.approx(
        retargeted(CLIP, character).forward_kinematics().positions[0], abs=1e-9
    )


def test_a_clip_already_on_the_body_is_returned():
    character = Character.from_clip(CLIP)
    own = retargeted(CLIP, character)
    assert retargeted(own, character) is own
    assert restored(own, own, character) is own


@pytest.mark.parametrize("dialect", ["daz", "smpl", "meaningless"])
def test_names_do_not_change_what_another_body_does(dialect):
    """The same motion under other names makes the same performance."""
    body = child()
    one = retargeted(moving(renamed(person(), DIALECTS["motionbuilder"])), body)
    two = retargeted(moving(renamed(person(), DIALECTS[dialect])), body)
    assert apart(one, two) < 1e-9


def test_another_body_turns_its_joints_alike():
    actor = Character.from_clip(CLIP)
    own, other = retargeted(CLIP, actor), retargeted(CLIP, alien())
    assert rot.angle_between(own.rotations, other.rotations).max() < 1e-7


def test_the_path_is_scaled_by_leg_length():
    small = replace(CLIP, skeleton=person(height=1.75))
    large = retargeted(small, Character.from_clip(still(person(height=1.75)), name="same"))
    double = retargeted(small, Character.from_clip(still(person(height=1.75 * 1.2)), name="tall"))
    one, two = large.root_positions, double.root_positions
    way = [np.linalg.norm(p[-1, :2] - p[0, :2]) for p in (one, two)]
    assert way[1] / way[0] == pytest.approx(1.2, rel=0.03)


@pytest.mark.parametrize("body", [adult_man, child, alien])
def test_soles_stay_on_the_floor_in_a_walk(body):
    walk = sample("walk")
    performer = body()
    performed = retargeted(walk, performer)
    lowest = sole_heights(performed, performer).min(axis=1)
    assert np.median(lowest) == pytest.approx(0.0, abs=0.003)
    assert np.quantile(np.abs(lowest), 0.95) < 0.01


def test_a_flight_keeps_its_height_in_scale():
    """A still figure lifted 0.5 m for a while: the child flies as high in leg lengths."""
    clip = still(person(height=1.75), frames=90)
    path = np.array(clip.root_positions)
    path[30:60, 2] += 0.5 * np.sin(np.linspace(0, np.pi, 30)) ** 2
    clip = replace(clip, root_positions=path)
    performer = child()
    flown = sole_heights(retargeted(clip, performer), performer).min(axis=1)
    actor = Character.from_clip(clip)
    leg = [
        np.linalg.norm(k.link("left_knee").offset)
        + np.linalg.norm(k.link("left_ankle").offset)
        - k.sole_height
        for k in (performer, actor)
    ]
    assert flown.max() == pytest.approx(0.5 * leg[0] / leg[1], rel=0.05)
    assert abs(flown[:20]).max() < 1e-6


def test_missing_joints_of_the_actor_follow_their_parents():
    names = DIALECTS["motionbuilder"]
    skeleton = renamed(without(person(), "left_ball", "right_ball", "neck"), names)
    body = adult_man()
    performed = retargeted(moving(skeleton), body)
    for joint in ("left_ball", "neck"):
        still_joint = performed.joint(joint)
        assert rot.angle(still_joint).max() < 1e-9


def test_a_rigid_back_composes_both_joints_of_the_actor():
    character = Character.from_clip(still(person()), plan="full16")
    skeleton = person(height=1.6)
    performed = retargeted(moving(skeleton), character).forward_kinematics()
    actor = retargeted(moving(skeleton), Character.from_clip(moving(skeleton)))
    chest = actor.forward_kinematics().rotations[:, actor.skeleton.index("upper_back")]
    own = performed.rotations[:, character.index("upper_back")]
    assert rot.angle_between(chest, own).max() < 1e-9


def test_a_motion_of_another_body_comes_back_on_the_captured_skeleton():
    body = alien()
    back = restored(retargeted(CLIP, body), CLIP, body)
    assert back.skeleton == CLIP.skeleton
    for joint in ("LeftForeArm", "RightLeg", "Spine1"):
        gap = rot.angle_between(back.joint(joint), CLIP.joint(joint))
        assert np.degrees(gap.max()) < 0.1, joint


def test_what_does_not_fit_is_refused():
    with pytest.raises(InvalidValue, match="no person"):
        retargeted(still(chain(5)), adult_man())
    with pytest.raises(InvalidValue, match="lacks the joint"):
        retargeted(CLIP, Character.from_clip(still(dog())))
    with pytest.raises(InvalidValue, match="not on the skeleton"):
        restored(CLIP, CLIP, adult_man())
