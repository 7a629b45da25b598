"""The floor is found from the motion, whatever moves on it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.motion import ground
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import sample, samples
from understudy.motion.skeleton import Skeleton


def lifted(clip: Clip, height) -> Clip:
    path = np.array(clip.root_positions)
    path[:, 2] += height
    return replace(clip, root_positions=path)


@pytest.mark.parametrize("name", samples())
@pytest.mark.parametrize("height", [-0.4, 0.0, 1.3])
def test_grounding_undoes_a_lift(name, height):
    clip = sample(name)
    back = lifted(clip, height).grounded()
    np.testing.assert_allclose(back.root_positions, clip.root_positions, atol=1e-3)
    assert f"shifted by {-1000 * (height + ground.floor_height(clip)):+.1f} mm" in back.notes[-1]


def test_a_walk_with_a_few_bad_frames_keeps_its_floor():
    clip = sample("walk")
    dip = np.zeros(clip.frames)
    dip[100:104] = -0.3
    dip[300:330] = -0.2 * np.sin(np.linspace(0, np.pi, 30))
    assert abs(ground.floor_height(lifted(clip, dip))) < 0.003


def test_a_jump_does_not_move_the_floor():
    clip = sample("gesture")
    t = clip.times - 2.0
    hop = np.maximum(0.0, 3.0 * t - 4.905 * t**2) * (t > 0)
    jumped = lifted(clip, hop)
    assert abs(ground.floor_height(jumped)) < 1e-3
    contacts = ground.foot_contacts(jumped)
    assert contacts.airborne[round(2.3 * 120)]
    assert contacts.airborne.mean() == pytest.approx(0.61 / 6.0, abs=0.02)


def test_steps_up_are_not_the_floor():
    clip = sample("gesture")
    rise = np.where(clip.times > 2.0, 0.4, 0.0)
    assert abs(ground.floor_height(lifted(clip, rise))) < 1e-3


def test_leveling_takes_out_a_sloping_floor_and_leaves_jumps():
    clip = sample("walk")
    tilted = lifted(clip, 0.01 * clip.times)
    level = ground.grounded(tilted, level=True)
    apart = level.root_positions[60:-60, 2] - clip.root_positions[60:-60, 2]
    assert np.abs(apart).max() < 0.006
    assert "leveled" in level.notes[-1]


def test_a_given_floor_is_taken_as_it_is():
    clip = sample("walk")
    moved = ground.grounded(clip, floor=0.25)
    np.testing.assert_allclose(moved.root_positions[:, 2], clip.root_positions[:, 2] - 0.25)
    with pytest.raises(InvalidValue, match="floor is nan"):
        ground.grounded(clip, floor=float("nan"))


def test_a_body_of_any_shape_and_size_is_grounded():
    # A worm of five joints lying on the floor, wriggling sideways; and the same a hundred times
    # larger.
    for size in (0.02, 2.0):
        worm = Skeleton(
            names=tuple("abcde"), parents=(-1, 0, 1, 2, 3),
            offsets=size * np.array([[0.0, 0, 0]] + [[0.5, 0, 0]] * 4),
        )  # fmt: skip
        t = np.arange(240) / 120.0
        q = rot.identity(240, 5)
        q[:, 1:] = rot.from_rotvec(
            0.05 * np.sin(2 * np.pi * t[:, None, None]) * np.array([0.0, 0, 1.0])
        )
        path = np.tile([0.0, 0.0, 0.7], (240, 1))
        clip = Clip(skeleton=worm, rotations=q, root_positions=path, rate=120)
        np.testing.assert_allclose(clip.grounded().root_positions[:, 2], 0.0, atol=1e-6)


def test_a_clip_in_which_nothing_rests_says_so():
    clip = sample("gesture").trimmed(0.0, 0.5)
    falling = lifted(clip, 3.0 - 5.0 * clip.times)
    note = falling.grounded().notes[-1]
    assert "nothing rests" in note


def test_walking_feet_touch_in_turn_and_do_not_slide():
    contacts = ground.foot_contacts(sample("walk"))
    assert contacts.slide < 0.02
    left = [k for k, n in enumerate(contacts.points) if n.startswith("left")]
    touching = contacts.touching[:, left].any(axis=1)
    assert 0.5 < touching.mean() < 0.75
    assert not contacts.airborne.any()
    assert contacts.positions.shape[:2] == contacts.touching.shape == contacts.speeds.shape


def test_a_sliding_figure_is_measured_to_slide():
    clip = sample("drumming")
    path = np.array(clip.root_positions)
    path[:, 0] += 0.1 * clip.times
    assert ground.foot_contacts(replace(clip, root_positions=path)).slide == pytest.approx(0.1)


def test_a_sole_is_known_only_where_the_rest_pose_stands():
    body = sample("walk").skeleton
    assert ground.sole_height(body) == pytest.approx(0.0175)
    offsets = np.array(body.offsets)
    offsets[0] = 0.0
    assert ground.sole_height(replace(body, offsets=offsets)) == 0.0


@pytest.mark.clips
@pytest.mark.parametrize(
    ("file", "least", "most"),
    [("cmu_bvh/02_04.bvh", 30, 50), ("cmu_bvh/49_19.bvh", 10, 20), ("cmu_bvh/29_01.bvh", 28, 42),
     ("cmu_asfamc/14_21.amc", 5, 25), ("cmu_bvh/05_06.bvh", -80, 0)],
)  # fmt: skip
def test_real_floors_lie_where_the_feet_stand(clips: Path, file, least, most):
    from understudy.motion.read import read

    clip = read(clips / file)
    assert least < 1000 * ground.floor_height(clip) < most
    assert abs(ground.floor_height(clip.grounded())) < 1e-4


@pytest.mark.clips
def test_leveling_a_real_walk_keeps_its_feet_on_the_floor(clips: Path):
    from understudy.motion.read import read

    level = ground.grounded(read(clips / "cmu_bvh/02_01.bvh"), level=True)
    pose = level.forward_kinematics()
    lowest = np.concatenate((pose.positions, pose.ends), axis=1)[..., 2].min(axis=1)
    assert np.quantile(lowest, 0.1) > -0.01
    assert np.quantile(lowest, 0.9) < 0.02
