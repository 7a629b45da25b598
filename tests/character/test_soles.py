"""Soles that fit the clip and feet that stay on the floor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from understudy.character import Character, adult_woman, retargeted
from understudy.character.planting import planted
from understudy.character.soles import sole_heights, sole_points, standing
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import sample

WALK = sample("walk")
WALKER = Character.from_clip(WALK)


def shifted(clip: Clip, offset) -> Clip:
    return replace(clip, root_positions=clip.root_positions + np.asarray(offset, float))


def slide(clip: Clip, character: Character) -> float:
    """Mean horizontal speed [m/s] of sole points within 5 mm of the floor."""
    pose = clip.forward_kinematics()
    speeds = []
    for link, center, radius in sole_points(character):
        place = pose.positions[:, link] + rot.rotate(pose.rotations[:, link], center)
        velocity = np.linalg.norm(np.gradient(place[:, :2], axis=0), axis=1) * clip.rate
        speeds.append(velocity[place[:, 2] - radius < 0.005])
    return float(np.concatenate(speeds).mean())


def test_each_foot_touches_at_heel_ball_and_toes():
    assert len(sole_points(WALKER)) == 12
    assert len(sole_points(Character.from_clip(WALK, plan="upper"))) == 0


@pytest.mark.parametrize("height", [-0.2, 0.05, 0.4])
def test_a_clip_stands_on_the_floor_wherever_it_was_captured(height):
    clip = shifted(retargeted(WALK, WALKER), (0.0, 0.0, height))
    lowest = sole_heights(standing(clip, WALKER), WALKER).min(axis=1)
    assert np.abs(np.quantile(lowest, [0.1, 0.5, 0.9])).max() < 0.005


def test_a_sloping_capture_floor_is_leveled():
    clip = retargeted(WALK, WALKER)
    slope = np.column_stack((np.zeros((clip.frames, 2)), 0.03 * clip.times / clip.duration))
    lowest = sole_heights(standing(shifted(clip, slope), WALKER), WALKER).min(axis=1)
    assert np.abs(np.quantile(lowest, [0.1, 0.5, 0.9])).max() < 0.006


def test_feet_that_sink_are_lifted_and_nothing_else_moves():
    clip = standing(retargeted(WALK, WALKER), WALKER)
    sunk = shifted(clip, (0.0, 0.0, -0.02))
    out = planted(sunk, WALKER)
    # In stance the leg cannot fold away 2 cm everywhere at once without the hip; soles come up.
    assert sole_heights(out, WALKER).min() > -0.008
    np.testing.assert_array_equal(out.root_positions, sunk.root_positions)
    joints = [link.joint for link in WALKER.links]
    for name in ("neck", "left_elbow", "lower_back"):
        k = joints.index(name)
        np.testing.assert_array_equal(out.rotations[:, k], sunk.rotations[:, k])


def test_planting_keeps_the_orientation_of_the_foot():
    sunk = shifted(standing(retargeted(WALK, WALKER), WALKER), (0.0, 0.0, -0.02))
    before, after = sunk.forward_kinematics(), planted(sunk, WALKER).forward_kinematics()
    for joint in ("left_ankle", "right_ankle", "left_ball"):
        k = WALKER.index(joint)
        angles = rot.angle_between(before.rotations[:, k], after.rotations[:, k])
        assert angles.max() < 1e-6


def test_sliding_feet_stay_put():
    clip = standing(retargeted(WALK, WALKER), WALKER)
    drift = np.column_stack((0.15 * clip.times, np.zeros((clip.frames, 2))))
    sliding = shifted(clip, drift)
    assert slide(sliding, WALKER) > 0.12
    out = planted(sliding, WALKER)
    assert slide(out, WALKER) < 0.4 * slide(sliding, WALKER)
    assert "Planted the feet" in out.notes[-1]


def test_planting_pops_nowhere():
    clip = standing(retargeted(WALK, WALKER), WALKER)
    drift = np.column_stack((0.15 * clip.times, np.zeros((clip.frames, 2))))
    out = planted(shifted(clip, drift), WALKER)
    steps = rot.angle_between(out.rotations[1:], out.rotations[:-1]) * clip.rate
    before = rot.angle_between(clip.rotations[1:], clip.rotations[:-1]) * clip.rate
    assert steps.max() < 1.5 * before.max()


def test_a_body_without_feet_is_left_alone():
    upper = Character.from_clip(WALK, plan="upper")
    clip = retargeted(WALK, upper)
    assert standing(clip, upper) is clip
    assert planted(clip, upper) is clip


def test_soles_are_fitted_to_a_foot_that_stands_at_an_angle():
    """Feet captured 8 degrees toe-up: fitted soles agree on the floor, anatomical ones do not."""
    turned = np.array(WALK.rotations)
    for side in ("left", "right"):
        k = WALK.skeleton.index(f"{side}_ankle")
        turned[:, k] = rot.multiply(turned[:, k], rot.from_rotvec([0.0, -np.radians(8.0), 0.0]))
    clip = replace(WALK, rotations=turned)
    character = Character.from_clip(clip)
    fitted = sole_heights(standing(retargeted(clip, character), character), character)
    plain = sole_heights(standing(retargeted(clip, WALKER), WALKER), WALKER)
    reached = [np.quantile(h, 0.05, axis=0) for h in (fitted, plain)]
    assert np.abs(reached[0]).max() < 0.002
    assert reached[1].max() > 0.015


def test_another_body_keeps_its_feet_on_the_ground():
    woman = adult_woman()
    lowest = sole_heights(standing(retargeted(WALK, woman), woman), woman).min(axis=1)
    assert np.abs(np.quantile(lowest, [0.1, 0.5, 0.9])).max() < 0.012


def test_hands_that_sink_are_lifted_out_of_the_floor():
    """Arms hanging down with the body lowered until the fingers are 10 cm below the floor."""
    from understudy.motion.figure import figure

    skeleton = figure()
    turned = rot.identity(60, len(skeleton))
    for side, sign in (("left", -1.0), ("right", 1.0)):
        k = skeleton.index(f"{side}_shoulder")
        turned[:, k] = rot.from_rotvec([sign * np.pi / 2, 0.0, 0.0])
    path = np.tile(skeleton.offsets[0], (60, 1))
    pose = Clip(skeleton=skeleton, rotations=turned, root_positions=path, rate=60.0)
    character = Character.from_clip(pose)
    clip = retargeted(pose, character)
    wrist = character.index("left_wrist")
    low = clip.forward_kinematics().positions[:, wrist, 2].min() - 0.08
    out = planted(shifted(clip, (0.0, 0.0, -low)), character)
    after = out.forward_kinematics().positions[:, wrist, 2]
    assert after.min() > 0.08
    assert any("Lifted the hands" in note for note in out.notes)


def test_a_fallen_body_lies_on_the_ground():
    from understudy.simulate import track

    take = track(WALK.trimmed(0.0, 3.0), WALKER, pelvis="free")
    assert take.clip().forward_kinematics().positions[..., 2].min() > -0.03
