"""Hands placed at times: met, eased, combined, retimed; two bodies that meet; refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from understudy.errors import InvalidValue, UnknownName
from understudy.motion import edits, samples
from understudy.motion import rotations as rot
from understudy.motion.arm import arm_of, palm
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.reaching import HandTarget, Meet, meeting, reach, reaching
from understudy.motion.read import read


@pytest.fixture(scope="module")
def gesture() -> Clip:
    return samples.sample("gesture")


def hand(clip: Clip, time: float, joint: str = "right_wrist") -> tuple[np.ndarray, np.ndarray]:
    """World place of the palm [m] and rotation of the hand at a time [s]."""
    turned, path = edits.sampled(clip, [time])
    one = replace(clip, rotations=turned, root_positions=path)
    pose, wrist = one.forward_kinematics(), clip.skeleton.index(joint)
    turn = pose.rotations[0, wrist]
    return pose.positions[0, wrist] + rot.rotate(turn, palm(clip.skeleton, joint)), turn


def near(clip: Clip, time: float, offset: tuple[float, float, float], **options) -> HandTarget:
    """A target beside where the right palm is at a time."""
    return HandTarget(time=time, position=hand(clip, time)[0] + offset, **options)


def test_a_hand_is_where_it_should_be_and_as_it_was(gesture):
    target = near(gesture, 2.0, (-0.05, 0.06, -0.04))
    out, (what,) = reach(gesture, [target])
    place, turn = hand(out, 2.0)
    assert np.linalg.norm(place - target.position) < 0.0005
    assert np.degrees(rot.angle_between(turn, hand(gesture, 2.0)[1])) < 1.0
    assert what.miss < 0.0005
    assert what.moved == pytest.approx(np.linalg.norm([0.05, 0.06, 0.04]))
    assert what.turned < np.radians(1.0)
    assert "right_wrist placed at 2 s: moved 88 mm" in out.notes[-1]


def test_times_between_frames_are_met(gesture):
    target = near(gesture, 2.0 + 0.4 / gesture.rate, (-0.05, 0.05, 0.0))
    place, _ = hand(gesture.reaching(target), target.time)
    assert np.linalg.norm(place - target.position) < 0.0005


def test_offsets_come_and_go_within_the_window(gesture):
    out = gesture.reaching(near(gesture, 2.0, (-0.05, 0.05, 0.0), window=0.25))
    changed = rot.angle_between(out.rotations, gesture.rotations)
    outside = np.abs(gesture.times - 2.0) >= 0.25 - 1e-9
    assert changed[outside].max() < 1e-7
    arm = list(arm_of(gesture, "right_wrist").joints)
    others = [i for i in range(len(gesture.skeleton)) if i not in arm]
    assert changed[:, others].max() < 1e-12
    # The sinusoid ease: half the angle at half the window, and no corner.
    peak = changed[240, arm[0]]
    assert changed[225, arm[0]] == pytest.approx(0.5 * peak, rel=1e-6)
    assert np.abs(np.diff(changed[:, arm[0]], 2)).max() < 1.1 * peak * np.pi**2 / (2 * 30**2)


def test_neighbors_whose_windows_overlap_are_both_met(gesture):
    targets = [
        near(gesture, time, offset, window=0.5)
        for time, offset in (
            (2.0, (-0.05, 0.0, 0.05)),
            (2.2, (-0.05, 0.05, 0.0)),
            (2.5, (0.0, 0.05, -0.05)),
        )
    ]
    out = reaching(gesture, reversed(targets))
    for target in targets:
        assert np.linalg.norm(hand(out, target.time)[0] - target.position) < 0.0005
    joints = [gesture.skeleton.index("right_wrist")]
    speeds = [np.linalg.norm(edits.joint_velocities(c)[:, joints], axis=-1) for c in (out, gesture)]
    assert (speeds[0] - speeds[1]).max() < 1.5


def test_a_held_offset_stays_between_two_equal_ones():
    still = samples.sample("gesture").trimmed(2.0, 2.0)
    clip = replace(
        still,
        rotations=np.repeat(still.rotations, 121, axis=0),
        root_positions=np.repeat(still.root_positions, 121, axis=0),
    )
    place = hand(clip, 0.3)[0] + [-0.05, 0.05, 0.0]
    targets = [HandTarget(time=t, position=place, window=0.4) for t in (0.3, 0.7)]
    out = reaching(clip, targets)
    for time in np.linspace(0.3, 0.7, 9):
        assert np.linalg.norm(hand(out, time)[0] - place) < 0.0005


def test_both_arms_reach_at_once(gesture):
    left = hand(gesture, 2.0, "left_wrist")[0] + [0.05, 0.0, 0.05]
    out = gesture.reaching(
        near(gesture, 2.0, (-0.04, 0.04, 0.0)),
        HandTarget(time=2.0, joint="left_wrist", position=left),
    )
    assert np.linalg.norm(hand(out, 2.0, "left_wrist")[0] - left) < 0.0005
    assert np.linalg.norm(hand(out, 2.0)[0] - hand(gesture, 2.0)[0] - [-0.04, 0.04, 0]) < 0.0005


def test_another_point_of_the_hand_can_be_placed(gesture):
    wrist = gesture.skeleton.index("right_wrist")
    goal = gesture.forward_kinematics().positions[240, wrist] + [-0.03, 0.03, 0.02]
    out = gesture.reaching(HandTarget(time=2.0, position=goal, point=(0.0, 0.0, 0.0)))
    assert np.linalg.norm(out.forward_kinematics().positions[240, wrist] - goal) < 0.0005


def test_retiming_before_and_after_is_the_same(gesture):
    target = near(gesture, 2.0, (-0.05, 0.05, 0.0))
    fast = gesture.retimed(1.33).reaching(target.retimed(1.33))
    same = gesture.reaching(target).retimed(1.33)
    assert np.linalg.norm(hand(fast, 2.0 / 1.33)[0] - target.position) < 0.001
    assert np.degrees(rot.angle_between(fast.rotations, same.rotations).max()) < 0.3
    assert target.retimed(2.0) == replace(target, time=1.0, window=0.15)
    assert target.retimed(2.0, window=0.3).window == 0.3
    assert Meet(time=3.0).retimed(2.0) == Meet(time=1.5, window=0.15)


def test_no_targets_leave_the_clip_alone(gesture):
    assert reaching(gesture, []) is gesture


def test_out_of_reach_says_how_far(gesture):
    arm = arm_of(gesture, "right_wrist")
    shoulder = gesture.forward_kinematics().positions[144, arm.joints[0]]
    goal = shoulder + np.array([2.1, 0.0, 0.0])
    length = arm.reach(arm.hand)
    with pytest.raises(
        InvalidValue,
        match=rf"at 1.20 s lies 2.10 m from the shoulder; the arm reaches {length:.2f} m",
    ):
        gesture.reaching(HandTarget(time=1.2, position=goal))


def test_too_near_the_shoulder_says_how_near_it_comes(gesture):
    arm = arm_of(gesture, "right_wrist")
    shoulder = gesture.forward_kinematics().positions[144, arm.joints[0]]
    with pytest.raises(InvalidValue, match="comes no nearer than"):
        long = replace(gesture, skeleton=_long_handed(gesture))
        long.reaching(HandTarget(time=1.2, position=shoulder))


def _long_handed(clip: Clip):
    """A skeleton with hands longer than the rest of the arm: the palm cannot reach the shoulder."""
    return replace(clip.skeleton, end_offsets=clip.skeleton.end_offsets * 15.0)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"time": 9.0}, "outside 'gesture'"),
        ({"joint": "lower_back"}, "cannot be placed"),
    ],
)
def test_targets_that_do_not_fit_are_refused(gesture, change, text):
    target = replace(near(gesture, 2.0, (0.0, 0.0, 0.0)), **change)
    with pytest.raises(InvalidValue, match=text):
        gesture.reaching(target)


def test_two_places_at_once_and_shared_joints_are_refused(gesture):
    one = near(gesture, 2.0, (0.0, 0.0, 0.0))
    two = near(gesture, 2.0, (0.0, 0.1, 0.0))
    with pytest.raises(InvalidValue, match="two targets at 2 s"):
        gesture.reaching(one, two)
    elbow = replace(one, joint="right_elbow")
    with pytest.raises(InvalidValue, match="both turn 'right_shoulder'"):
        gesture.reaching(one, elbow)
    with pytest.raises(UnknownName, match="right_wrist"):
        gesture.reaching(replace(one, joint="right_hand"))


def test_what_is_no_list_of_targets_is_refused(gesture):
    target = near(gesture, 2.0, (0.0, 0.0, 0.0))
    for wrong in (target, None, [Meet(time=1.0)]):
        with pytest.raises(InvalidValue, match="HandTarget"):
            reaching(gesture, wrong)
    with pytest.raises(InvalidValue, match="list of Meet"):
        meeting(gesture, gesture, Meet(time=1.0))


@pytest.mark.parametrize(
    "options",
    [
        {"time": -1.0},
        {"time": np.nan},
        {"window": 0.0},
        {"position": (0.0, 1.0)},
        {"position": (0.0, 1.0, np.inf)},
        {"point": (0.0,)},
    ],
)
def test_senseless_targets_are_refused(options):
    with pytest.raises(InvalidValue):
        HandTarget(**{"time": 1.0, "position": (0.0, 0.0, 1.0), **options})


# -- two bodies -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pair(gesture) -> tuple[Clip, Clip]:
    """Two that stand opposite, a third of the way into the gesture."""
    x, y = gesture.root_positions[0, :2]
    return gesture, gesture.placed(at=(x + 0.9, y), heading=np.pi)


def test_two_hands_meet_a_gap_apart(pair):
    meets = [Meet(time=2.0), Meet(time=2.6, hands=("right_wrist", "right_wrist"), apart=0.03)]
    a, b = meeting(*pair, meets)
    for meet in meets:
        palms = [hand(c, meet.time, j)[0] for c, j in zip((a, b), meet.hands, strict=True)]
        assert np.linalg.norm(palms[0] - palms[1]) == pytest.approx(meet.apart, abs=0.001)


def test_they_meet_half_way_where_both_reach_easily(pair):
    a, b = pair
    before = [hand(c, 2.0, j)[0] for c, j in ((a, "right_wrist"), (b, "left_wrist"))]
    x, y = meeting(a, b, [Meet(time=2.0)])
    after = [hand(c, 2.0, j)[0] for c, j in ((x, "right_wrist"), (y, "left_wrist"))]
    moved = [np.linalg.norm(p - q) for p, q in zip(before, after, strict=True)]
    middle = 0.5 * (before[0] + before[1])
    assert np.linalg.norm(0.5 * (after[0] + after[1]) - middle) < 0.3
    assert max(moved) < np.linalg.norm(before[0] - before[1]) + 0.3


def test_hands_that_meet_only_outstretched_are_turned_as_far_as_it_takes(pair):
    first, second = pair
    shoulders = [c.skeleton.index(f"{s}_shoulder") for c, s in ((first, "right"), (second, "left"))]
    reaches = [arm_of(c, f"{s}_wrist") for c, s in ((first, "right"), (second, "left"))]
    apart = 0.94 * sum(arm.reach(arm.hand) for arm in reaches)
    ends = [c.forward_kinematics().positions[240, j] for c, j in zip(pair, shoulders, strict=True)]
    way = apart * np.array([1.0, 0.0, 0.0]) - (ends[1] - ends[0])
    second = second.placed(at=second.root_positions[0, :2] + way[:2])
    a, b = meeting(first, second, [Meet(time=2.0)])
    palms = [hand(a, 2.0)[0], hand(b, 2.0, "left_wrist")[0]]
    assert np.linalg.norm(palms[0] - palms[1]) == pytest.approx(0.005, abs=0.002)


def test_a_meeting_can_be_given_its_place(pair):
    spot = 0.5 * (hand(pair[0], 2.0)[0] + hand(pair[1], 2.0)[0])
    spot = spot * [0.0, 0.0, 1.0] + [*(0.5 * sum(c.root_positions[240, :2] for c in pair)), 0.0]
    meet = Meet(time=2.0, position=tuple(spot), hands=("right_wrist", "right_wrist"), apart=0.0)
    for clip in meeting(*pair, [meet]):
        assert np.linalg.norm(hand(clip, 2.0)[0] - spot) < 0.001


def test_bodies_too_far_apart_are_told_so(pair):
    away = pair[1].placed(at=pair[1].root_positions[0, :2] + [2.0, 0.0])
    with pytest.raises(InvalidValue, match=r"shoulders are \d\.\d\d m apart.*placed"):
        meeting(pair[0], away, [Meet(time=2.0)])


@pytest.mark.parametrize(
    "options", [{"time": -1.0}, {"hands": ("a",)}, {"apart": -0.1}, {"position": (1.0,)}]
)
def test_senseless_meetings_are_refused(options):
    with pytest.raises(InvalidValue):
        Meet(**{"time": 1.0, **options})


def test_bodies_of_other_sizes_clap_to_an_adults_clip(gesture):
    """A child's hands meet although the motion was made for an adult's."""
    small = figure(1.2)
    child = replace(gesture, skeleton=small, root_positions=gesture.root_positions * 1.2 / 1.75)
    x, y = child.root_positions[0, :2]
    other = child.placed(at=(x + 0.65, y), heading=np.pi)
    a, b = meeting(child, other, [Meet(time=t) for t in (1.5, 2.0, 2.5)])
    for time in (1.5, 2.0, 2.5):
        apart = hand(a, time)[0] - hand(b, time, "left_wrist")[0]
        assert np.linalg.norm(apart) == pytest.approx(0.005, abs=0.002)


@pytest.mark.clips
@pytest.mark.parametrize(
    ("file", "wrist"),
    [
        ("cmu_bvh/02_01.bvh", "RightHand"),
        ("cmu_3dsmax_bvh/131_01.bvh", "rhand"),
        ("cmu_asfamc/02_01.amc", "rwrist"),
        ("cmu_daz_bvh/02_01.bvh", "rHand"),
        ("other_bvh/dab.bvh", "RightHand"),
    ],
)
def test_hands_of_captured_skeletons_are_placed(clips, file, wrist):
    clip = read(clips / file)
    place, _ = hand(clip, 1.0, wrist)
    shoulder = arm_of(clip, wrist).joints[0]
    start = clip.forward_kinematics().positions[round(clip.rate), shoulder]
    target = HandTarget(time=1.0, joint=wrist, position=place + 0.15 * (start - place))
    out, (what,) = reach(clip, [target])
    assert np.linalg.norm(hand(out, 1.0, wrist)[0] - target.position) < 0.002
    assert what.turned < np.radians(2.0)
