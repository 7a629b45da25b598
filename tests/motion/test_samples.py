"""The bundled samples stand on the floor and move as people do."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.errors import UnknownName
from understudy.motion import edits, gait, ground
from understudy.motion import rotations as rot
from understudy.motion.samples import sample, samples

# Fastest joint rotation in the samples [deg/s]; quick wrists in drumming reach about 600, and the
# elbow 1040 in a stroke at 3.5 m/s.
FASTEST = {"strike": 1100.0}
# Greatest acceleration of a joint [m/s^2]; the strike stops its hand within 4 hundredths.
HARDEST = {"strike": 130.0}


@pytest.fixture(scope="module", params=samples())
def clip(request):
    return sample(request.param)


def test_samples_say_that_they_are_made(clip):
    assert clip.synthetic
    assert "not captured" in clip.notes[0]
    assert clip.rate == 120.0
    assert 2.9 < clip.duration < 9.1


def test_samples_are_the_same_every_time(clip):
    np.testing.assert_array_equal(sample(clip.name).rotations, clip.rotations)


def test_nothing_goes_through_the_floor(clip):
    pose = clip.forward_kinematics()
    lowest = np.concatenate((pose.positions, pose.ends), axis=1)[..., 2].min()
    assert lowest > ground.sole_height(clip.skeleton) - 0.002
    assert abs(ground.floor_height(clip)) < 1e-3


def test_feet_do_not_slide(clip):
    contacts = ground.foot_contacts(clip, floor=0.0)
    assert not contacts.airborne.any()
    assert contacts.slide < 0.02


def test_joints_turn_and_move_at_human_speed(clip):
    omega = np.degrees(np.linalg.norm(edits.angular_velocities(clip, world=False), axis=-1))
    assert omega.max() < FASTEST.get(clip.name, 800.0)
    speed = np.linalg.norm(edits.joint_velocities(clip), axis=-1)
    assert speed.max() < 5.0
    acceleration = np.linalg.norm(edits.joint_accelerations(clip), axis=-1)
    assert acceleration.max() < HARDEST.get(clip.name, 90.0)


def test_knees_and_elbows_bend_only_forward_and_back(clip):
    for side, sign in (("left", 1.0), ("right", -1.0)):
        knee = rot.to_rotvec(clip.joint(f"{side}_knee"))
        assert knee[:, 1].min() > -1e-6
        np.testing.assert_allclose(knee[:, [0, 2]], 0.0, atol=1e-6)
        forward = rot.rotate(clip.joint(f"{side}_elbow"), np.array([0.0, sign, 0.0]))
        assert forward[:, 0].min() > -1e-6


def test_unknown_samples_list_those_there_are():
    with pytest.raises(UnknownName, match="Did you mean 'walk'"):
        sample("walkk")


@pytest.fixture(scope="module")
def walk():
    return sample("walk")


def test_the_walk_has_normative_speed_and_travel(walk):
    way = walk.root_positions[-1] - walk.root_positions[0]
    assert way[0] / walk.duration == pytest.approx(1.32, abs=0.03)
    whole = walk.root_positions[: round(2 * 1.09 * 120)]
    assert 0.040 < np.ptp(whole[:, 2]) < 0.048
    assert 0.038 < np.ptp(whole[:, 1]) < 0.048


def test_the_walk_follows_the_normative_joint_curves(walk):
    phase = walk.times / gait._Stride(1.75).time + 0.3
    for side, shift in (("left", 0.0), ("right", 0.5)):
        knee = np.degrees(rot.angle(walk.joint(f"{side}_knee")))
        apart = knee - np.degrees(gait._curve(gait._KNEE, phase + shift))
        assert np.sqrt(np.mean(apart**2)) < 7.5  # the table's standard deviation is 6.5
        assert 60 < knee.max() < 66
        ankle = -np.degrees(rot.to_euler(walk.joint(f"{side}_ankle"), "YXZ")[:, 0])
        apart = ankle - np.degrees(gait._curve(gait._ANKLE, phase + shift))
        assert np.sqrt(np.mean(apart**2)) < 5.0


def test_the_stance_foot_rolls_over_points_that_stay(walk):
    pose, body = walk.forward_kinematics(), walk.skeleton
    phase = walk.times / gait._Stride(1.75).time + 0.3
    ankle = body.index("left_ankle")
    heel = np.array([-0.19 * 0.152, 0.0, 0.012 - 0.039]) * 1.75
    tip = [body.names[j] for j in body.end_joints].index("left_ball")
    tracks = {
        (0.01, 0.25): pose.positions[:, ankle] + rot.rotate(pose.rotations[:, ankle], heel),
        (0.10, 0.41): pose.positions[:, body.index("left_ball")],
        (0.10, 0.58): pose.ends[:, tip],
    }
    for (low, high), track in tracks.items():
        speed = np.linalg.norm(edits.derivative(track, walk.rate), axis=-1)
        assert speed[(phase % 1 > low) & (phase % 1 < high)].max() < 0.02


def test_the_walk_repeats_every_stride(walk):
    frames = gait._Stride(1.75).time * walk.rate
    later, _ = edits.sampled(walk, (np.arange(200) + frames) / walk.rate)
    assert np.degrees(rot.angle_between(later, walk.rotations[:200]).max()) < 0.5


def test_the_walk_is_left_right_symmetric(walk):
    half = gait._Stride(1.75).time / 2
    image = walk.mirrored()
    later, _ = edits.sampled(image, np.arange(200) / walk.rate + half)
    assert np.degrees(rot.angle_between(later, walk.rotations[:200]).max()) < 1.5


@pytest.mark.parametrize("height", [1.1, 1.95])
def test_people_of_any_height_can_walk(height):
    clip = gait.walk(3.0, 100.0, height)
    assert ground.foot_contacts(clip, floor=0.0).slide < 0.02
    assert abs(ground.floor_height(clip)) < 1e-3


def test_hands_meet_twice_a_second_in_clapping():
    clip = sample("clapping")
    hands = clip.forward_kinematics().positions
    left, right = (hands[:, clip.skeleton.index(f"{s}_wrist")] for s in ("left", "right"))
    gap = np.abs(left - right)[:, 1]
    closed = np.flatnonzero((gap[1:-1] < gap[:-2]) & (gap[1:-1] <= gap[2:]) & (gap[1:-1] < 0.08))
    assert len(closed) == 10
    np.testing.assert_allclose(np.diff(closed) / clip.rate, 0.5, atol=0.02)


def test_both_hands_drum_in_turn():
    clip = sample("drumming")
    positions = clip.forward_kinematics().positions
    strokes = {}
    for side in ("left", "right"):
        z = positions[:, clip.skeleton.index(f"{side}_wrist"), 2]
        low = (z[1:-1] < z[:-2]) & (z[1:-1] <= z[2:])
        strokes[side] = np.flatnonzero(low) / clip.rate
        assert len(strokes[side]) in (12, 13)
    first = min(len(strokes["left"]), len(strokes["right"]))
    offset = np.abs(strokes["left"][:first] - strokes["right"][:first])
    np.testing.assert_allclose(offset, 0.2, atol=0.02)
