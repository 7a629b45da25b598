"""Glitches put in are found and taken out; fast motion stays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.repair import repair
from understudy.motion.samples import sample, samples


def worst_step(clip: Clip, joint: str) -> float:
    """Largest turn from frame to frame [deg]."""
    q = clip.joint(joint)
    return float(np.degrees(rot.angle_between(q[:-1], q[1:])).max())


def glitched(clip: Clip, joint: str, first: int, last: int, degrees: float, seed: int = 0) -> Clip:
    """The clip with frames first .. last of a joint turned off their path."""
    chance = np.random.default_rng(seed)
    axis = chance.normal(size=3)
    q = np.array(clip.rotations)
    turn = rot.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis))
    i = clip.skeleton.index(joint)
    q[first : last + 1, i] = rot.multiply(q[first : last + 1, i], turn)
    return replace(clip, rotations=q)


@pytest.mark.parametrize("joint", ["left_wrist", "right_knee", "neck", "pelvis"])
@pytest.mark.parametrize("length", [1, 2, 5])
@pytest.mark.parametrize("degrees", [30.0, 60.0, 179.0])
def test_spikes_are_found_and_drawn_again(joint, length, degrees):
    clip = sample("walk")
    bad = glitched(clip, joint, 200, 199 + length, degrees)
    mended, repairs = repair(bad)
    assert [(r.joint, r.kind != "step") for r in repairs] == [(joint, True)]
    # A few fast frames in which the joint does not move far are also a path.
    assert rot.angle_between(mended.rotations, clip.rotations).max() < np.radians(4.0)
    assert repairs[0].start == pytest.approx(200 / 120)
    assert repairs[0].end == pytest.approx((199 + length) / 120)
    assert repairs[0].before > 0.9 * degrees
    assert repairs[0].after < 10.0
    assert joint in mended.notes[-1]


def test_other_frames_and_joints_are_untouched():
    clip = sample("walk")
    mended, _ = repair(glitched(clip, "left_wrist", 200, 201, 90.0))
    same = np.ones(clip.rotations.shape[:2], bool)
    same[200:202, clip.skeleton.index("left_wrist")] = False
    np.testing.assert_allclose(
        rot.angle_between(mended.rotations, clip.rotations)[same], 0.0, atol=1e-6
    )
    np.testing.assert_array_equal(mended.root_positions, clip.root_positions)


@pytest.mark.parametrize("seed", range(4))
def test_a_lasting_flip_is_turned_back(seed):
    clip = sample("walk")
    bad = glitched(clip, "left_wrist", 220, 400, 180.0, seed)
    mended, repairs = repair(bad)
    assert [(r.kind, r.start * 120, r.end * 120) for r in repairs] == [("flip", 220.0, 400.0)]
    i = clip.skeleton.index("left_wrist")
    error = rot.angle_between(mended.rotations[:, i], clip.rotations[:, i])
    assert np.degrees(error.max()) < 2.0


def test_a_flip_to_the_end_turns_the_shorter_part_back():
    clip = sample("gesture")
    mended, repairs = repair(glitched(clip, "right_elbow", 600, clip.frames - 1, 170.0))
    assert [r.kind for r in repairs] == ["flip"]
    assert rot.angle_between(mended.rotations, clip.rotations).max() < np.radians(3.0)


def test_a_lasting_small_step_is_spread():
    clip = sample("gesture")
    mended, repairs = repair(glitched(clip, "neck", 300, clip.frames - 1, 25.0))
    assert [r.kind for r in repairs] == ["step"]
    assert worst_step(mended, "neck") < 5.0


def test_root_position_spikes_are_drawn_again():
    clip = sample("walk")
    path = np.array(clip.root_positions)
    path[100:102] += [0.2, 0.0, 0.1]
    mended, repairs = repair(replace(clip, root_positions=path))
    assert [(r.joint, r.kind) for r in repairs] == [("root position", "spike")]
    np.testing.assert_allclose(mended.root_positions, clip.root_positions, atol=2e-3)
    assert "root position: 1 spike of up to 2" in mended.notes[-1]


@pytest.mark.parametrize("name", samples())
def test_clean_clips_come_back_unchanged(name):
    clip = sample(name)
    assert clip.repaired() is clip


def test_a_fast_throw_is_left_alone():
    # A shoulder that turns 90 degrees in 0.1 s and back: 1800 degrees a second at its fastest.
    t = np.arange(240) / 120.0
    bump = np.pi / 2 * np.exp(-(((t - 1.0) / 0.05) ** 2))
    clip = sample("gesture").trimmed(0.0, 239 / 120)
    q = np.array(clip.rotations)
    i = clip.skeleton.index("right_shoulder")
    q[:, i] = rot.multiply(q[:, i], rot.from_rotvec(bump[:, None] * np.array([0, 0, 1.0])))
    thrown = replace(clip, rotations=q)
    assert worst_step(thrown, "right_shoulder") > 10.0
    assert thrown.repaired() is thrown


def test_repairing_twice_changes_nothing_more():
    bad = glitched(sample("walk"), "left_knee", 100, 102, 50.0)
    once = bad.repaired()
    assert once.repaired() is once


# -- real clips ------------------------------------------------------------------------------------


def hands_and_toes(name: str) -> bool:
    return any(part in name.lower() for part in ("thumb", "finger", "hand", "wrist", "toe"))


@pytest.mark.clips
@pytest.mark.parametrize(
    "file",
    ["cmu_bvh/02_01.bvh", "cmu_bvh/02_03.bvh", "cmu_asfamc/127_02.amc", "cmu_asfamc/127_03.amc",
     "cmu_asfamc/14_21.amc", "cmu_daz_bvh/13_39.bvh", "other_bvh/wave_hello.bvh",
     "other_bvh/zombie.bvh", "other_bvh/dab.bvh", "other_bvh/jumping_jacks.bvh"],
)  # fmt: skip
def test_walks_runs_jumps_and_dances_are_left_alone(clips: Path, file):
    from understudy.motion.read import read

    clip = read(clips / file)
    assert repair(clip)[1] == ()


@pytest.mark.clips
@pytest.mark.parametrize(
    "file", ["cmu_asfamc/135_04.amc", "cmu_bvh/35_17.bvh", "cmu_bvh/49_02.bvh"]
)
def test_kicks_and_hops_change_only_at_hands_and_toes(clips: Path, file):
    from understudy.motion.read import read

    _, repairs = repair(read(clips / file))
    assert all(hands_and_toes(r.joint) for r in repairs)


@pytest.mark.clips
def test_the_flips_of_a_bad_dance_are_turned_back(clips: Path):
    from understudy.motion.read import read

    clip = read(clips / "cmu_bvh/05_06.bvh")
    mended, repairs = repair(clip)
    found = [r for r in repairs if r.joint == "RightUpLeg"]
    # Frames 121, 128, 146, 156, 165, 175, 192, 432, 459, 466 of the file, whose frame 0 is dropped.
    starts = [round(r.start * clip.rate) + 1 for r in found]
    assert [s - 1 for s in starts] == [121, 146, 165, 192, 459]
    assert worst_step(clip, "RightUpLeg") > 170
    assert worst_step(mended, "RightUpLeg") < 15


@pytest.mark.clips
@pytest.mark.parametrize(
    ("file", "joint"),
    [("cmu_bvh/49_02.bvh", "RThumb"), ("cmu_bvh/49_06.bvh", "RThumb"),
     ("cmu_bvh/08_01.bvh", "RThumb"), ("cmu_3dsmax_bvh/131_01.bvh", "RThumb"),
     ("cmu_bvh/06_15.bvh", "LThumb")],
)  # fmt: skip
def test_no_flip_is_left_in_flipping_thumbs(clips: Path, file, joint):
    from understudy.motion.read import read

    clip = read(clips / file)
    assert worst_step(clip, joint) > 170
    assert worst_step(clip.repaired(), joint) < 75
