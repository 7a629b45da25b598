"""Axes, units, T-poses and wrong rates are found, and every finding can be overruled."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from texts import person

from understudy.motion import rotations as rot
from understudy.motion.bvh import read_bvh, write_bvh
from understudy.motion.clip import Clip, Conventions
from understudy.motion.detection import free_fall
from understudy.motion.recording import UNITS
from understudy.motion.skeleton import Skeleton


@pytest.fixture
def again(tmp_path: Path):
    """Write a clip in a dialect and read it, everything detected."""

    def read(clip: Clip, up: str = "y", unit: float = 0.01, read_as=None, **options) -> Clip:
        names = tuple(f"j{k}" for k in range(len(clip.skeleton)))
        skeleton = replace(clip.skeleton, names=names)
        dialect = Conventions(up=up, unit=unit)
        write_bvh(replace(clip, skeleton=skeleton, conventions=dialect), tmp_path / "a.bvh")
        return read_bvh(tmp_path / "a.bvh", **(read_as or {}), **options)

    return read


def noted(clip: Clip, word: str) -> bool:
    return any(word in note for note in clip.notes)


@pytest.mark.parametrize("up", "xyz")
def test_the_vertical_axis_is_the_one_the_body_stands_along(again, up):
    clip = again(person(), up=up)
    assert clip.conventions.up == up
    assert noted(clip, f"Vertical axis {up}")
    assert 1.5 < np.ptp(clip.forward_kinematics().positions[..., 2]) < 1.9


@pytest.mark.parametrize("name", UNITS)
def test_the_unit_is_the_standard_one_that_fits_a_person(again, name):
    clip = again(person(), unit=UNITS[name])
    assert clip.conventions.unit == pytest.approx(UNITS[name])
    assert noted(clip, "person of 1.7")


def test_a_person_in_no_standard_unit_is_scaled_to_one(again):
    clip = again(person(), unit=0.0396)
    assert clip.conventions.unit == pytest.approx(0.0396, rel=0.02)
    assert noted(clip, "pass unit=")


@pytest.mark.parametrize(("scale", "height"), [(0.65, "1.1"), (1.7, "2.9")])
def test_children_and_giants_in_centimeters_keep_their_size(again, scale, height):
    grown = person()
    other = replace(
        grown,
        skeleton=grown.skeleton.scaled(scale),
        root_positions=grown.root_positions * scale,
    )
    clip = again(other)
    assert clip.conventions.unit == 0.01
    assert noted(clip, f"person of {height}")


def test_arguments_overrule_what_is_detected(again):
    clip = again(person(), up="z", unit=0.01, read_as={"up": "x", "unit": 0.5})
    assert clip.conventions.unit == 0.5 and clip.conventions.up == "x"
    assert not noted(clip, "Vertical") and not noted(clip, "Unit")


def four_legs() -> Clip:
    """A body whose trunk lies across its four legs, 40 cm long."""
    names, parents, offsets = ["hips"], [-1], [[0.0, 0, 0.3]]
    ends = []
    for at, parent in ((0.0, 0), (0.4, None)):
        if parent is None:
            names.append("chest")
            parents.append(0)
            offsets.append([at, 0, 0])
            parent = len(names) - 1
        for side in (1.0, -1.0):
            for k, offset in enumerate(([0.0, 0.08 * side, 0], [0, 0, -0.15], [0, 0, -0.15])):
                names.append(f"l{len(names)}")
                parents.append(parent if k == 0 else len(names) - 2)
                offsets.append(offset)
            ends.append(len(names) - 1)
    skeleton = Skeleton(
        names=tuple(names),
        parents=tuple(parents),
        offsets=np.array(offsets),
        end_joints=tuple(ends),
        end_offsets=np.tile([0.02, 0, 0], (4, 1)),
    )
    path = np.tile([0.0, 0, 0.3], (5, 1)) + np.linspace(0, 1, 5)[:, None] * [1.0, 0, 0]
    return Clip(
        skeleton=skeleton, rotations=rot.identity(5, len(names)), root_positions=path, rate=30
    )


def test_a_body_on_four_legs_is_no_person(again):
    clip = again(four_legs(), up="z", unit=0.01)
    assert clip.conventions.up == "z"
    assert clip.conventions.unit == 0.01
    assert noted(clip, "no person")


def t_posed(clip: Clip, blend: int = 0) -> Clip:
    """The clip behind a T-pose, blended into over some frames."""
    weight = 0.7 ** np.arange(1, blend + 1)
    turned = np.array(clip.rotations)
    for k, w in enumerate(weight):
        turned[k, 1:] = rot.slerp(turned[k, 1:], rot.identity(len(clip.skeleton) - 1), w)
    turned = np.concatenate((rot.identity(1, len(clip.skeleton)), turned))
    return replace(
        clip,
        rotations=turned,
        root_positions=np.concatenate((clip.root_positions[:1], clip.root_positions)),
    )


def arms_down(frames: int = 200) -> Clip:
    clip = person(frames, rate=120.0)
    turned = np.array(clip.rotations)
    for name, angle in (("left_shoulder", -1.3), ("right_shoulder", 1.3)):
        j = clip.skeleton.index(name)
        turned[:, j] = rot.multiply(rot.from_rotvec([angle, 0, 0]), turned[:, j])
    return replace(clip, rotations=turned)


def test_a_t_pose_before_the_motion_is_dropped(again):
    clip = again(t_posed(arms_down()))
    assert clip.frames == 200
    assert noted(clip, "Dropped a T-pose before the motion: frame 0")
    assert rot.angle_between(clip.rotations, arms_down().rotations).max() < 1e-6


def test_a_t_pose_that_blends_into_the_motion_is_dropped_with_the_blend(again):
    clip = again(t_posed(arms_down(), blend=15))
    assert noted(clip, "blend")
    assert clip.frames == 201 - 30


def test_a_motion_that_leaves_a_t_pose_smoothly_is_kept(again):
    clip = arms_down()
    ramp = np.clip(np.arange(200) / 120.0, 0, 1)[:, None]
    eased = rot.slerp(rot.identity(200, len(clip.skeleton)), clip.rotations, ramp)
    assert again(replace(clip, rotations=eased)).frames == 200


def test_t_pose_can_be_kept_or_dropped_by_hand(again):
    assert again(t_posed(arms_down()), t_pose="keep").frames == 201
    assert again(arms_down(), t_pose="drop").frames == 199


def jumping(rate: float) -> Clip:
    """Three jumps with 9.81 m/s2, sampled at 120 Hz and labeled with another rate."""
    clip = person(1, rate=120.0)
    times = np.arange(432) / 120.0
    within = times % 1.2
    flight = (within > 0.4) & (within < 0.8)
    lift = np.where(flight, 0.5 * 9.81 * (within - 0.4) * (0.8 - within), 0.0)
    path = clip.skeleton.offsets[0] + lift[:, None] * [0.0, 0.0, 1.0]
    return Clip(
        skeleton=clip.skeleton,
        rotations=np.repeat(rot.identity(1, len(clip.skeleton)), 432, axis=0),
        root_positions=path,
        rate=rate,
    )


def test_flights_fall_with_gravity():
    clip = jumping(120.0)
    falls = free_fall(clip.skeleton, clip.rotations, clip.root_positions, clip.rate)
    np.testing.assert_allclose(falls, 9.81, rtol=1e-6)


@pytest.mark.parametrize(("rate", "suggested"), [(240.0, "rate=120"), (60.0, "rate=120")])
def test_a_rate_wrong_by_two_is_noticed_and_not_changed(again, rate, suggested):
    clip = again(jumping(rate))
    assert clip.rate == rate
    assert noted(clip, suggested)
    assert not noted(again(jumping(120.0)), "rate=")


def test_a_root_that_stays_at_zero_is_raised_to_the_ground(again):
    clip = person()
    clip = again(replace(clip, root_positions=np.zeros_like(clip.root_positions)))
    assert noted(clip, "root path is zero")
    pose = clip.forward_kinematics()
    assert min(pose.positions[..., 2].min(), pose.ends[..., 2].min()) == pytest.approx(0, abs=0.02)


@pytest.mark.clips
def test_real_people_stand_on_the_ground_in_their_files_unit(clips):
    expected = {"other_bvh/dab": "z", "other_bvh/wave_hello": "z", "other_bvh/zombie": "z"}
    folders = ("cmu_bvh", "cmu_3dsmax_bvh", "cmu_daz_bvh", "other_bvh")
    for path in sorted(p for folder in folders for p in clips.glob(f"{folder}/*.bvh")):
        clip = read_bvh(path)
        key = f"{path.parent.name}/{path.stem}"
        assert clip.conventions.up == expected.get(key, "y"), key
        pose = clip.forward_kinematics()
        heights = np.concatenate((pose.positions[..., 2], pose.ends[..., 2]), axis=1)
        # The end of the head lies below the crown, by a hand's breadth and more.
        assert 1.30 < np.percentile(np.ptp(heights, axis=1), 90) < 1.9, key
        assert -0.14 < heights.min() < 0.08, key


@pytest.mark.clips
def test_real_t_poses_are_dropped_and_real_motion_is_kept(clips):
    for path in sorted(clips.glob("cmu_bvh/*.bvh")):
        rows = read_bvh(path, t_pose="keep").frames
        assert read_bvh(path).frames == rows - 1, path
    for path in sorted(clips.glob("cmu_daz_bvh/*.bvh")):
        assert read_bvh(path).frames == read_bvh(path, t_pose="keep").frames - 30, path
    for folder in ("cmu_3dsmax_bvh", "other_bvh", "odd_bvh"):
        for path in sorted(clips.glob(f"{folder}/*.bvh")):
            assert read_bvh(path).frames == read_bvh(path, t_pose="keep").frames, path


@pytest.mark.clips
def test_the_daz_conversion_is_as_large_as_the_other_of_the_same_trial(clips):
    one = read_bvh(clips / "cmu_daz_bvh/02_01.bvh", t_pose="keep").root_positions[30:]
    two = read_bvh(clips / "cmu_bvh/02_01.bvh", t_pose="keep").root_positions[30:]
    assert np.linalg.norm(np.ptp(one, axis=0)) == pytest.approx(
        np.linalg.norm(np.ptp(two, axis=0)), rel=0.01
    )
