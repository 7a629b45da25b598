"""The samples made for contacts and tasks do what they say, where and when they say it."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.errors import InvalidValue, UnknownName
from understudy.motion import edits
from understudy.motion import rotations as rot
from understudy.motion.samples import bowing, partner, pumping, sample, striking
from understudy.motion.samples.standing import FOOT_AT, HALF_PALM, palms

# Boone & Azen 1979, men: wrist flexion 76, extension 75, radial 22, ulnar 36; AAOS: elbow 150,
# pronation and supination 80 degrees. Three degrees beyond, as people differ by more.
WRIST = {"flexion": (-78.0, 79.0), "radial": (-39.0, 25.0)}
BEHAVIORS = ("strike", "staff", "bow", "patty_cake", "slap")


def at(clip, time):
    return round(time * clip.rate)


@pytest.fixture(scope="module", params=BEHAVIORS)
def behavior(request):
    return sample(request.param)


def test_both_feet_stay_where_they_stand(behavior):
    positions = behavior.forward_kinematics().positions
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for joint in ("ankle", "ball"):
            track = positions[:, behavior.skeleton.index(f"{side}_{joint}")]
            assert np.ptp(track, axis=0).max() < 0.001
        ankle = positions[0, behavior.skeleton.index(f"{side}_ankle"), :2]
        np.testing.assert_allclose(ankle, [FOOT_AT[0], sign * FOOT_AT[1]], atol=1e-4)


def test_wrists_and_elbows_keep_within_human_range(behavior):
    for side, sign in (("left", 1.0), ("right", -1.0)):
        image = np.array([1.0, sign, 1.0, sign])
        wrist = -np.degrees(rot.to_euler(behavior.joint(f"{side}_wrist") * image, "XZY"))
        for angle, (low, high) in zip((wrist[:, 0], wrist[:, 1]), WRIST.values(), strict=True):
            assert low < angle.min()
            assert angle.max() < high
        along = rot.rotate(behavior.joint(f"{side}_elbow"), np.array([0.0, sign, 0.0]))
        assert np.degrees(np.arccos(sign * along[:, 1])).max() < 145.0


def test_motion_begins_and_ends_at_rest(behavior):
    speed = np.linalg.norm(edits.joint_velocities(behavior), axis=-1)
    assert speed[[0, -1]].max() < 0.03


def test_each_strike_reaches_the_skin_at_3_m_per_s_and_goes_on_below():
    clip = sample("strike")
    skin = palms(clip)["right"] - [0.0, 0.0, HALF_PALM * 1.75]
    down = -edits.derivative(skin, clip.rate)[:, 2]
    for hit in striking.HITS:
        frame = at(clip, hit)
        np.testing.assert_allclose(skin[frame], striking.DRUM, atol=0.002)
        assert down[frame] > 3.0
        assert striking.DRUM[2] - skin[frame : frame + 20, 2].min() > 0.05
    above = skin[:, 2] > striking.DRUM[2]
    assert np.sum(above[:-1] & ~above[1:]) == len(striking.HITS)


def test_the_staff_is_pumped_by_30_cm_and_tilts():
    clip = sample("staff")
    height = palms(clip)["right"][:, 2]
    middle = height[at(clip, 1.2) : at(clip, 4.8)]
    assert np.ptp(middle) == pytest.approx(pumping.STROKE, rel=0.1)
    high = (middle[1:-1] > middle[:-2]) & (middle[1:-1] >= middle[2:])
    gaps = np.diff(np.flatnonzero(high)) / clip.rate
    np.testing.assert_allclose(gaps, 1.0 / pumping.PUMPS, rtol=0.1)
    hand = clip.forward_kinematics().rotations[:, clip.skeleton.index("right_wrist")]
    up = rot.rotate(hand, np.array([1.0, 0.0, 0.0]))[:, 2]
    tilt = np.degrees(np.arccos(up))
    assert 20.0 < tilt.max() < 30.0
    assert 10.0 < np.sqrt(np.mean(tilt**2)) < 20.0


@pytest.mark.parametrize("degrees", [60.0, 80.0, 100.0])
def test_a_bow_is_held_at_its_tilt(degrees):
    clip = bowing.bow(degrees)
    tilt = bowing.trunk_tilt(clip)
    held = tilt[at(clip, bowing.HELD[0]) : at(clip, bowing.HELD[1])]
    np.testing.assert_allclose(held, degrees, atol=0.5)
    assert tilt[[0, -1]].max() < 1.0
    assert np.degrees(rot.angle(clip.joint("left_knee"))).max() < 12.0
    # Most of it is in the hips, and no joint goes beyond what people can.
    pelvis = 2.0 * np.degrees(np.arcsin(np.abs(clip.rotations[:, 0, 2]).max()))
    assert 0.6 * degrees < pelvis < 0.8 * degrees
    spine = [np.degrees(rot.angle(clip.joint(f"{part}_back")).max()) for part in ("lower", "upper")]
    assert sum(spine) < 80.0


@pytest.mark.parametrize("degrees", [0.0, -10.0, 120.0, float("nan")])
def test_a_bow_that_no_one_makes_is_refused(degrees):
    with pytest.raises(InvalidValue, match="0 to 110"):
        bowing.bow(degrees)


def test_segments_of_patty_cake_share_one_home_pose():
    clip = sample("patty_cake")
    frames = [at(clip, time) for time in partner.boundaries()]
    assert clip.duration == pytest.approx(partner.boundaries()[-1] + partner.PAUSE)
    apart = rot.angle_between(clip.rotations[frames], clip.rotations[0])
    assert np.degrees(apart.max()) < 0.01
    np.testing.assert_allclose(clip.root_positions[frames], clip.root_positions[[0] * 6], atol=1e-6)
    speed = np.linalg.norm(edits.joint_velocities(clip), axis=-1)
    assert speed[frames].max() < 0.03
    hands = palms(clip)
    gap = np.linalg.norm(hands["left"] - hands["right"], axis=-1)
    np.testing.assert_allclose(gap[frames], 0.05, atol=0.005)


def test_segments_can_be_made_in_any_order():
    order = ("both", "left")
    clip = partner.patty_cake(order)
    whole = sample("patty_cake")
    assert clip.duration == pytest.approx(3.0)
    apart = rot.angle_between(clip.rotations[at(clip, 1.5)], whole.rotations[0])
    assert np.degrees(apart.max()) < 0.01
    with pytest.raises(UnknownName, match="both"):
        partner.patty_cake(("boht",))


def test_palms_meet_two_partners_of_one_size_halfway():
    clip = sample("patty_cake")
    hands, rotations = palms(clip), clip.forward_kinematics().rotations
    speed = {side: edits.derivative(hands[side], clip.rate)[:, 0] for side in hands}
    for clap, time in zip(partner.CLAPS, partner.clap_times(), strict=True):
        frame = at(clip, time)
        sides = ("left", "right") if clap == "both" else (clap,)
        for side in sides:
            # The partner plays the same clip, turned around: one hand meets its like, both meet
            # the others.
            other = "right" if (side == "left") == (clap == "both") else "left"
            theirs = [partner.PARTNER, 0.0, 0.0] + hands[other][frame] * [-1.0, -1.0, 1.0]
            gap = theirs - hands[side][frame]
            assert gap[0] == pytest.approx(0.044, abs=0.006)
            assert np.abs(gap[1:]).max() < 0.06
            assert speed[side][frame] > 0.15
            palm = rot.rotate(
                rotations[frame, clip.skeleton.index(f"{side}_wrist")], np.array([0.0, 0.0, -1.0])
            )
            assert palm[0] > 0.9


def test_the_slap_starts_from_the_home_pose_and_meets_the_cheek_fast():
    clip, home = sample("slap"), sample("patty_cake")
    apart = rot.angle_between(clip.rotations[0], home.rotations[0])
    assert np.degrees(apart.max()) < 0.01
    frame = at(clip, partner.SLAP)
    hand = palms(clip)["right"]
    np.testing.assert_allclose(hand[frame], partner.CHEEK, atol=0.005)
    velocity = edits.derivative(hand, clip.rate)[frame]
    assert velocity[1] > 2.0
    assert velocity[1] > 2.0 * np.abs(velocity[[0, 2]]).max()
