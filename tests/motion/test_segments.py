"""Segments joined: equation 4, its hemisphere, alignment over the ground, seams, refusals."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.motion import edits, samples
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import partner
from understudy.motion.segments import blended, concatenated, eased, looped, spliced
from understudy.motion.skeleton import Skeleton
from understudy.motion.transitions import transitions

RATE = 120.0
ROD = Skeleton(
    names=("a", "b"),
    parents=(-1, 0),
    offsets=np.array([[0, 0, 0], [0, 0, 1.0]]),
    end_joints=(1,),
    end_offsets=np.array([[1.0, 0, 0]]),
)


def turning(angle: float, speed: float, *, heading: float = 0.0, seconds: float = 2.0) -> Clip:
    """The second joint turns about z from `angle` [rad] at `speed` [rad/s]; the root walks."""
    t = np.arange(round(seconds * RATE) + 1) / RATE
    q = rot.identity(len(t), 2)
    q[:, 0] = rot.from_rotvec([0.0, 0.0, heading])
    q[:, 1] = rot.from_rotvec(np.stack((0 * t, 0 * t, angle + speed * t), axis=-1))
    way = np.array([np.cos(heading), np.sin(heading), 0.0])
    path = t[:, None] * way + [3.0, -2.0, 1.0]
    return Clip(skeleton=ROD, rotations=q, root_positions=path, rate=RATE, name="turning")


def turns(clip: Clip) -> np.ndarray:
    """Angle of every joint from frame to frame [rad], (frames - 1, joints)."""
    return rot.angle_between(clip.rotations[1:], clip.rotations[:-1])


@pytest.fixture(scope="module")
def gesture() -> Clip:
    return samples.sample("gesture").trimmed(0.0, 3.0)


@pytest.fixture(scope="module")
def walk() -> Clip:
    return samples.sample("walk").trimmed(0.0, 3.0)


def test_a_splice_follows_equation_4():
    a, b = turning(0.2, 0.5), turning(0.7, -0.3)
    out = spliced(a, b, at=0.5, blend=0.4, start=0.25)
    t = out.times
    weight = eased((t - 0.5) / 0.4)
    expected = (0.2 + 0.5 * t) * (1 - weight) + (0.7 - 0.3 * (t - 0.25)) * weight
    assert np.allclose(rot.to_rotvec(out.rotations[:, 1])[:, 2], expected, atol=1e-9)
    assert out.duration == pytest.approx(0.5 + 2.0 - 0.25)


def test_a_splice_of_a_clip_with_itself_at_one_time_is_the_clip(walk):
    out = walk.spliced(walk, at=1.0, start=1.0)
    assert out.frames == walk.frames
    assert rot.angle_between(out.rotations, walk.rotations).max() < 1e-6
    assert np.allclose(out.root_positions, walk.root_positions, atol=1e-9)


def test_frames_outside_the_blend_are_those_of_the_two_clips(gesture, walk):
    out = gesture.spliced(walk, at=1.0, blend=0.5, start=0.75)
    np.testing.assert_array_equal(out.rotations[:120], gesture.rotations[:120])
    after = out.rotations[181:, 1:]
    same = walk.rotations[151 : 151 + len(after), 1:]
    assert rot.angle_between(after, same).max() < 1e-6


def test_the_way_is_chosen_once_where_the_motions_pass_half_a_turn_apart():
    a, b = turning(0.0, 0.0), turning(np.radians(150.0), np.radians(100.0))
    out = spliced(a, b, at=0.0, blend=0.5)
    # Apart by 150 to 200 degrees: the short way in the middle (175) leads on past 180.
    assert np.degrees(turns(out)).max() < 6.0
    short = rot.slerp(a.rotations[:61], b.rotations[:61], eased(np.arange(61) / 60.0)[:, None])
    assert np.degrees(rot.angle_between(short[1:], short[:-1])).max() > 50.0


@pytest.mark.parametrize("seed", range(5))
def test_a_blend_turns_by_no_more_than_its_parts(seed):
    chance = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, 61)[:, None, None]
    spins = chance.uniform(-3.0, 3.0, (2, 2, 3, 3))
    a, b = (rot.multiply(rot.from_rotvec(s[0]), rot.from_rotvec(t * s[1])) for s in spins)
    weight = eased(np.linspace(0.0, 1.0, 61))
    out = blended(a, b, weight, middle=30)
    # Each part's speed, and the way between them at the ease's greatest slope.
    most = sum(rot.angle_between(q[1:], q[:-1]).max() for q in (a, b)) + 2.0 * np.pi * 0.5 / 60 * 2
    assert rot.angle_between(out[1:], out[:-1]).max() < 2.0 * most
    assert rot.angle_between(out[[0, -1]], np.stack((a[0], b[-1]))).max() < 1e-7


def test_heading_and_place_go_on_where_the_first_clip_is():
    a, b = turning(0.0, 0.0), turning(0.0, 0.0, heading=2.0)
    out = a.spliced(b, at=1.0)
    # Both walk straight at 1 m/s: the result is one straight walk.
    assert np.allclose(out.root_positions, [3.0, -2.0, 1.0] + out.times[:, None] * [1.0, 0, 0])
    assert rot.angle(out.rotations[:, 0]).max() < 1e-7


def test_heights_are_blended(gesture):
    raised = replace(gesture, root_positions=gesture.root_positions + np.array([0.0, 0.0, 0.1]))
    out = gesture.spliced(raised, at=1.0, start=1.0)
    height = out.root_positions[:, 2] - gesture.root_positions[:, 2]
    weight = eased((gesture.times - 1.0) / 0.5)
    assert np.allclose(height, 0.1 * weight, atol=1e-9)


def test_another_rate_is_resampled_to_the_first():
    a, b = turning(0.2, 0.5), turning(0.7, -0.3)
    same = a.spliced(b, at=1.0, start=0.5)
    for rate in (50.0, 240.0):
        out = a.spliced(b.resampled(rate), at=1.0, start=0.5)
        assert (out.rate, out.frames) == (same.rate, same.frames)
        assert rot.angle_between(out.rotations, same.rotations).max() < 1e-5
        ends = concatenated([a, b.resampled(rate)], tolerance=1.0)
        assert (ends.rate, ends.frames) == (RATE, 481)


def test_a_splice_into_another_place_and_heading_is_the_same(gesture, walk):
    one = gesture.spliced(walk, at=1.0, start=0.5)
    moved = gesture.spliced(walk.placed(at=(7.0, 3.0), heading=1.2), at=1.0, start=0.5)
    assert rot.angle_between(one.rotations, moved.rotations).max() < 1e-6
    assert np.allclose(one.root_positions, moved.root_positions, atol=1e-9)


def test_hands_stay_as_fast_as_the_clips_own(gesture, walk):
    def peak(clip: Clip) -> float:
        hands = [clip.skeleton.index(f"{side}_wrist") for side in ("left", "right")]
        return float(np.linalg.norm(edits.joint_velocities(clip)[:, hands], axis=-1).max())

    best = transitions(gesture, walk, count=1)[0]
    out = gesture.spliced(walk, at=best.time_a, start=best.time_b)
    assert peak(out) < 1.3 * max(peak(gesture), peak(walk))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"at": 9.0}, "at is 9"),
        ({"at": -0.1}, "at is -0.1"),
        ({"at": 1.0, "start": 2.9}, "start is 2.9"),
        ({"at": 0.0, "blend": 4.0}, "does not fit"),
        ({"at": 1.0, "blend": 0.0}, "blend is 0"),
        ({"at": np.nan}, "at is nan"),
    ],
)
def test_times_outside_the_clips_are_refused(gesture, walk, options, text):
    with pytest.raises(InvalidValue, match=text):
        gesture.spliced(walk, **options)


def test_other_skeletons_are_refused_with_the_remedy(gesture):
    with pytest.raises(InvalidValue, match=r"only one has the joint .*retargeted"):
        gesture.spliced(turning(0.0, 0.0), at=1.0)
    longer = replace(gesture, skeleton=gesture.skeleton.scaled(1.1))
    with pytest.raises(InvalidValue, match="bones differ in length"):
        gesture.spliced(longer, at=1.0)


# -- segments that share a home pose ----------------------------------------------------------


def test_parts_of_a_clip_put_back_together_are_the_clip(gesture):
    parts = [gesture.trimmed(0.0, 1.0), gesture.trimmed(1.0, 2.0), gesture.trimmed(2.0, 3.0)]
    out = concatenated(parts)
    assert out.frames == gesture.frames
    # Velocities at the seams are fits from either side.
    assert np.degrees(rot.angle_between(out.rotations, gesture.rotations).max()) < 0.3
    assert np.abs(out.root_positions - gesture.root_positions).max() < 1e-4


def test_a_seam_has_no_jump_of_pose_or_velocity():
    a, b = turning(0.0, 0.4, seconds=1.0), turning(0.5, -0.8, heading=1.0, seconds=1.0)
    out = concatenated([a, b])
    angle = rot.to_rotvec(out.rotations[:, 1])[:, 2]
    speed = np.diff(angle) * RATE
    assert out.duration == pytest.approx(2.0)
    # 0.1 rad and 1.2 rad/s over 0.6 s: no step of velocity beyond a cubic's own acceleration.
    assert np.abs(np.diff(speed)).max() < 20.0 / RATE
    assert speed[0] == pytest.approx(0.4)
    assert speed[-1] == pytest.approx(-0.8)
    assert angle[120] == pytest.approx(0.45, abs=1e-9)
    assert np.allclose(np.diff(out.root_positions, axis=0) * RATE, [1.0, 0.0, 0.0], atol=1e-9)


def test_short_segments_are_met_at_both_ends():
    parts = [turning(0.1 * k, 0.0, seconds=0.1) for k in (0, 1, 2, 1, 0)]
    angle = rot.to_rotvec(concatenated(parts).rotations[:, 1])[:, 2]
    assert np.allclose(angle[12::12][:4], [0.05, 0.15, 0.15, 0.05], atol=1e-9)
    assert np.abs(np.diff(angle)).max() < 0.02


def test_a_pose_that_is_not_shared_is_refused_with_joint_and_angle():
    with pytest.raises(InvalidValue, match=r"'b' is 57 degrees off, 20 are allowed.*spliced"):
        concatenated([turning(0.0, 0.0), turning(1.0, 0.0)])
    concatenated([turning(0.0, 0.0), turning(1.0, 0.0)], tolerance=1.1)
    high = turning(0.0, 0.0)
    high = replace(high, root_positions=high.root_positions + np.array([0, 0, 0.4]))
    with pytest.raises(InvalidValue, match=r"\+0.40 m above"):
        concatenated([turning(0.0, 0.0), high])


def test_segments_of_patty_cake_go_in_any_order():
    whole, times = partner.patty_cake(), partner.boundaries()
    parts = [whole.trimmed(a, b) for a, b in pairwise(times)]
    out = concatenated([parts[k] for k in (2, 0, 4, 1, 3, 0)])
    speed = [np.linalg.norm(edits.joint_velocities(c), axis=-1).max() for c in (out, whole)]
    assert out.duration == pytest.approx(6.0 * parts[0].duration)
    assert speed[0] < 1.05 * speed[1]


def test_a_loop_walks_on():
    a = turning(0.0, 2.0 * np.pi, seconds=1.0)
    out = a.looped(3)
    t = out.times
    assert out.frames == 361
    assert np.allclose(out.root_positions, [3.0, -2.0, 1.0] + t[:, None] * [1.0, 0.0, 0.0])
    assert np.abs(turns(out)[:, 1] * RATE - 2.0 * np.pi).max() < 1e-6
    assert a.looped(until=2.25).duration == pytest.approx(2.25)
    assert a.looped(1) is a


@pytest.mark.parametrize(
    "options", [{}, {"count": 2, "until": 3.0}, {"count": 0}, {"count": 1.5}, {"until": -1.0}]
)
def test_a_loop_needs_one_sensible_length(options):
    with pytest.raises(InvalidValue):
        looped(turning(0.0, 0.0), **options)


def test_segments_need_clips_of_two_frames():
    with pytest.raises(InvalidValue, match="at least one clip"):
        concatenated([])
    with pytest.raises(InvalidValue, match="list of Clips"):
        concatenated(turning(0.0, 0.0))
    with pytest.raises(InvalidValue, match="it must be a Clip"):
        turning(0.0, 0.0).spliced(None, at=1.0)
    still = turning(0.0, 0.0).trimmed(0.0, 0.0)
    with pytest.raises(InvalidValue, match="one frame"):
        concatenated([still, still])
