"""Feet laid flat, legs closed under a body, and where its center of mass comes to lie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from understudy.character import Character, body, retargeted
from understudy.character.footing import SIDES, balanced, footing, sole_of
from understudy.character.soles import sole_heights
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import sample
from understudy.motion.samples.bowing import bow


@pytest.fixture(scope="module")
def deep() -> Clip:
    return bow(90.0).trimmed(1.0, 3.5)


def center_of_mass(clip: Clip, character: Character) -> np.ndarray:
    pose = clip.forward_kinematics()
    masses = np.array([link.mass for link in character.links])
    at = pose.positions + rot.rotate(
        pose.rotations, np.array([link.com for link in character.links])
    )
    return np.tensordot(at, masses / masses.sum(), (1, 0))


@pytest.mark.parametrize("who", ["adult_woman", "child", "alien"])
def test_the_center_of_mass_is_over_the_middle_of_feet_that_lie_flat_and_still(deep, who):
    character = body(who)
    clip = retargeted(deep, character)
    feet = footing(clip, character)
    made = balanced(clip, character, feet)
    away = center_of_mass(made, character)[:, :2] - feet.center[:2]
    assert np.abs(away).max() < 0.005
    assert np.abs(sole_heights(made, character)).max() < 1e-3
    pose = made.forward_kinematics()
    for side in SIDES:
        path = pose.positions[:, character.index(f"{side}_ankle")]
        assert np.ptp(path, axis=0).max() < 1e-6


def test_only_legs_and_pelvis_position_change(deep):
    character = Character.from_clip(deep)
    clip = retargeted(deep, character)
    made = balanced(clip, character, footing(clip, character))
    legs = ("hip", "knee", "ankle", "ball")
    kept = [i for i, name in enumerate(clip.skeleton.names) if not name.endswith(legs)]
    np.testing.assert_allclose(made.rotations[:, kept], clip.rotations[:, kept], atol=1e-12)


def test_feet_stand_where_the_clip_stands_and_below_it_where_it_walks(deep):
    character = Character.from_clip(deep)
    clip = retargeted(deep, character)
    stood = footing(clip, character)
    assert stood.captured
    ankle = clip.forward_kinematics().positions[0, character.index("left_ankle")]
    np.testing.assert_allclose(stood.ankles[0], ankle, atol=0.002)
    walk = sample("walk")
    walker = Character.from_clip(walk)
    walked = footing(retargeted(walk, walker), walker)
    assert not walked.captured
    apart = np.linalg.norm(walked.soles[0] - walked.soles[1])
    hips = [walker.link(f"{side}_hip").offset for side in SIDES]
    assert apart == pytest.approx(np.linalg.norm(hips[0] - hips[1]), rel=0.02)


def test_a_turned_clip_gives_the_turned_stance(deep):
    character = Character.from_clip(deep)
    clip = retargeted(deep, character)
    spin = rot.from_euler("Z", np.array([0.7]))
    rotations = np.array(clip.rotations)
    rotations[:, 0] = rot.multiply(spin, rotations[:, 0])
    turned = replace(
        clip, rotations=rotations, root_positions=rot.rotate(spin, clip.root_positions)
    )
    plain = balanced(clip, character, footing(clip, character))
    other = balanced(turned, character, footing(turned, character))
    np.testing.assert_allclose(
        other.root_positions, rot.rotate(spin, plain.root_positions), atol=1e-6
    )
    assert rot.angle_between(other.rotations[:, 1:], plain.rotations[:, 1:]).max() < 1e-5


def test_the_sole_is_level_and_symmetric_on_a_made_body():
    left, right = (sole_of(body("adult_man"), side) for side in SIDES)
    assert left.middle[2] == pytest.approx(body("adult_man").sole_height, abs=1e-6)
    np.testing.assert_allclose(left.half, right.half, atol=1e-9)
    assert rot.angle(left.tilt) < 1e-6


def test_feet_too_far_apart_and_a_lying_pelvis_are_refused(deep):
    character = Character.from_clip(deep)
    clip = retargeted(deep, character)
    feet = footing(clip, character)
    wide = replace(feet, ankles=feet.ankles * np.array([1.0, 20.0, 1.0]))
    with pytest.raises(InvalidValue, match="too far apart"):
        balanced(clip, character, wide)
    rotations = np.array(clip.rotations)
    rotations[:, 0] = rot.from_euler("Y", np.array([2.2]))
    with pytest.raises(InvalidValue, match="tilts by"):
        balanced(replace(clip, rotations=rotations), character, feet)
