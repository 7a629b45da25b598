"""Clips check themselves, stay as they are, and know forward kinematics."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip, Conventions
from understudy.motion.figure import figure


def random_clip(frames: int = 12, seed: int = 0, rate: float = 30.0) -> Clip:
    body, chance = figure(), np.random.default_rng(seed)
    return Clip(
        skeleton=body,
        rotations=chance.normal(size=(frames, len(body), 4)),
        root_positions=chance.normal(size=(frames, 3)),
        rate=rate,
    )


def test_forward_kinematics_agrees_with_scipy_joint_by_joint():
    clip = random_clip()
    pose, body = clip.forward_kinematics(), clip.skeleton
    for frame in range(clip.frames):
        local = Rotation.from_quat(clip.rotations[frame], scalar_first=True)
        world, place = [], []
        for i, parent in enumerate(body.parents):
            world.append(local[i] if parent < 0 else world[parent] * local[i])
            place.append(
                clip.root_positions[frame]
                if parent < 0
                else place[parent] + world[parent].apply(np.array(body.offsets[i]))
            )
        np.testing.assert_allclose(pose.positions[frame], place, atol=1e-12)
        theirs = np.array([w.as_quat(scalar_first=True) for w in world])
        assert rot.angle_between(pose.rotations[frame], theirs).max() < 1e-6
        for k, j in enumerate(body.end_joints):
            end = place[j] + world[j].apply(np.array(body.end_offsets[k]))
            np.testing.assert_allclose(pose.ends[frame, k], end, atol=1e-12)


def test_rest_clip_stands_in_the_rest_pose():
    body = figure()
    clip = Clip(
        skeleton=body, rotations=rot.identity(3, len(body)),
        root_positions=np.tile(body.offsets[0], (3, 1)), rate=10,
    )  # fmt: skip
    np.testing.assert_allclose(clip.forward_kinematics().positions[1], body.rest_positions())
    assert clip.duration == pytest.approx(0.2)
    np.testing.assert_allclose(clip.times, [0, 0.1, 0.2])


def test_bones_keep_their_length_in_any_pose():
    clip = random_clip(seed=3)
    p, body = clip.forward_kinematics().positions, clip.skeleton
    for i, parent in enumerate(body.parents[1:], 1):
        length = np.linalg.norm(p[:, i] - p[:, parent], axis=-1)
        np.testing.assert_allclose(length, np.linalg.norm(body.offsets[i]), atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rotations": np.zeros((12, 3, 4))}, "rotations has shape"),
        ({"rotations": np.zeros((12, 18, 4))}, "zero quaternion"),
        ({"rotations": np.full((12, 18, 4), np.nan)}, "rotations has values that are not finite"),
        ({"root_positions": np.zeros((5, 3))}, "12 frames of rotations and 5"),
        ({"root_positions": np.full((12, 3), np.inf)}, "root_positions has values"),
        ({"root_positions": np.zeros((12, 2))}, "root_positions has shape"),
        ({"rate": 0.0}, "rate is 0"),
        ({"rate": float("nan")}, "rate is nan"),
        ({"rate": -30.0}, "rate is -30"),
    ],
)
def test_bad_clips_are_refused_with_the_reason(changes, message):
    with pytest.raises(InvalidValue, match=message):
        dataclasses.replace(random_clip(), **changes)


def test_a_clip_without_frames_is_refused():
    with pytest.raises(InvalidValue):
        dataclasses.replace(
            random_clip(), rotations=np.zeros((0, 18, 4)), root_positions=np.zeros((0, 3))
        )


def test_clip_arrays_are_copied_and_read_only():
    q, p = rot.identity(2, 18), np.zeros((2, 3))
    clip = Clip(skeleton=figure(), rotations=q, root_positions=p, rate=1)
    q[:], p[:] = 5.0, 5.0
    assert clip.root_positions[0, 0] == 0.0
    assert clip.rotations[0, 0, 0] == 1.0
    for array in (clip.rotations, clip.root_positions, clip.forward_kinematics().positions):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        clip.rate = 2  # type: ignore[misc]


def test_rotations_become_unit_and_continuous():
    clip = random_clip(60)
    np.testing.assert_allclose(np.linalg.norm(clip.rotations, axis=-1), 1.0, atol=1e-12)
    assert (np.sum(clip.rotations[1:] * clip.rotations[:-1], axis=-1) >= 0).all()


def test_joints_are_found_by_name_and_notes_add_up():
    clip = random_clip()
    assert clip.joint("neck").shape == (12, 4)
    with pytest.raises(UnknownName):
        clip.joint("nek")
    assert clip.noted("a").noted("b", "c").notes == ("a", "b", "c")
    assert clip.renamed("x").name == "x"
    assert clip.notes == ()


def test_axis_change_of_conventions_turns_the_file_up():
    for up, vector in (("x", [1, 0, 0]), ("y", [0, 1, 0]), ("z", [0, 0, 1])):
        turned = rot.rotate(Conventions(up=up).axis_change, vector)
        np.testing.assert_allclose(turned, [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(
        rot.rotate(Conventions(up="y").axis_change, [1.0, 2.0, 3.0]), [1, -3, 2], atol=1e-12
    )
    assert Conventions(rotation_orders=("XYZ",)).order(0) == "XYZ"
    assert Conventions(rotation_orders=("XYZ",)).order(5) == "ZXY"


@pytest.mark.parametrize("bad", [{"up": "w"}, {"unit": 0.0}, {"unit": float("inf")}])
def test_bad_conventions_are_refused(bad):
    with pytest.raises(InvalidValue):
        Conventions(**bad)
