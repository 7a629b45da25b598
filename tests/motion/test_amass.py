"""AMASS: frames of the body model and of the world, rates, and what is approximate."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.errors import ClipError
from understudy.motion import rotations as rot
from understudy.motion.amass import JOINTS, read_amass, skeleton
from understudy.motion.clip import Clip

NAMES = [name for name, _ in JOINTS]
STAND = np.array([np.pi / 2, 0, 0])  # from the model's y up to the world's z up


@pytest.fixture
def saved(tmp_path):
    def read(poses: np.ndarray, *, drop: tuple[str, ...] = (), options=None, **arrays) -> Clip:
        content = {
            "poses": poses,
            "trans": np.tile([0, 0, 0.93], (len(poses), 1)),
            "mocap_framerate": np.array(120.0),
            "gender": np.array("male"),
            "betas": np.zeros(16),
            **arrays,
        }
        np.savez(tmp_path / "a.npz", **{k: v for k, v in content.items() if k not in drop})
        return read_amass(tmp_path / "a.npz", **(options or {}))

    return read


def standing(frames: int = 5, joints: int = 52) -> np.ndarray:
    poses = np.zeros((frames, 3 * joints))
    poses[:, :3] = STAND
    return poses


def places(clip: Clip) -> dict[str, np.ndarray]:
    positions = clip.forward_kinematics().positions[0]
    return dict(zip(clip.skeleton.names, positions - positions[0], strict=True))


def test_a_standing_body_stands_and_faces_where_the_model_does(saved):
    clip = saved(standing())
    at = places(clip)
    assert at["head"][2] > 0.4 and at["left_ankle"][2] < -0.7
    # The model's left (+x) stays +x; its front (+z) becomes -y.
    assert at["left_wrist"][0] > 0.6 and abs(at["left_wrist"][1]) < 1e-9
    assert at["left_foot"][1] < -0.05


def test_joint_rotations_are_those_of_the_model(saved):
    poses = standing()
    elbow = NAMES.index("left_elbow")
    poses[:, 3 * elbow : 3 * elbow + 3] = [0, -np.pi / 2, 0]  # forearm to the model's front
    clip = saved(poses)
    at = places(clip)
    forearm = at["left_wrist"] - at["left_elbow"]
    np.testing.assert_allclose(forearm / np.linalg.norm(forearm), [0, -1, 0], atol=1e-9)
    assert rot.angle(clip.joint("left_elbow")[0]) == pytest.approx(np.pi / 2)


def test_turning_the_root_turns_the_world_pose(saved):
    poses = standing()
    yaw = rot.from_euler("Z", [0.7])
    poses[:, :3] = rot.to_rotvec(rot.multiply(yaw, rot.from_rotvec(STAND)))
    before, after = places(saved(standing())), places(saved(poses))
    for name in NAMES:
        np.testing.assert_allclose(after[name], rot.rotate(yaw, before[name]), atol=1e-12)


def test_the_root_path_is_that_of_the_model(saved):
    trans = np.linspace(0.1, 0.5, 5)[:, None] * np.ones(3)
    path = saved(standing(), trans=trans).root_positions
    np.testing.assert_allclose(np.diff(path, axis=0), 0.1)
    # The model's pelvis rests .22 m beside its origin, in whatever axes the file is stored.
    np.testing.assert_allclose(path - trans, np.tile([0, -0.223, 0.028], (5, 1)))


def test_files_stored_with_y_up_are_turned(saved):
    poses = np.zeros((5, 66))
    trans = np.tile([0.3, 1.1, 0.2], (5, 1))
    clip = saved(poses, trans=trans, options={"up": "y"})
    at = places(clip)
    assert at["head"][2] > 0.4
    np.testing.assert_allclose(clip.root_positions[0], [0.3, -0.228, 0.877])


@pytest.mark.parametrize("joints", [22, 24, 52, 55])
def test_every_body_of_the_family_is_read(saved, joints):
    clip = saved(standing(joints=joints))
    assert clip.skeleton.names == tuple(NAMES)
    assert any("left out" in note for note in clip.notes) == (joints > 22)


def test_the_height_brings_the_feet_to_the_ground(saved):
    tall = skeleton(1.9, "male")
    still = Clip(
        skeleton=tall,
        rotations=rot.identity(1, len(tall)),
        root_positions=np.zeros((1, 3)),
        rate=30,
    ).forward_kinematics()
    legs = -min(still.positions[..., 2].min(), still.ends[..., 2].min())
    clip = saved(standing(), trans=np.tile([0, 0, legs - 0.028], (5, 1)))
    pose = clip.forward_kinematics()
    assert min(pose.positions[..., 2].min(), pose.ends[..., 2].min()) == pytest.approx(0, abs=1e-9)
    assert any("Height 1.90 m" in note for note in clip.notes)


def test_a_height_that_fits_nobody_is_assumed_with_a_note(saved):
    clip = saved(standing(), trans=np.zeros((5, 3)), gender=np.array("female"))
    assert any("Height 1.63 m assumed" in note for note in clip.notes)
    assert any("approximate" in note for note in clip.notes)


@pytest.mark.parametrize("name", ["mocap_framerate", "mocap_frame_rate", "fps"])
def test_the_rate_is_found_under_its_names(saved, name):
    clip = saved(
        standing(), drop=("mocap_framerate",) if name != "mocap_framerate" else (), **{name: 60}
    )
    assert clip.rate == 60.0


@pytest.mark.parametrize(
    ("arrays", "drop", "message"),
    [
        ({}, ("mocap_framerate",), "pass rate="),
        ({"mocap_framerate": 0.0}, (), "'mocap_framerate' is 0"),
        ({}, ("trans",), "has no array 'trans'"),
        ({"trans": np.zeros((4, 3))}, (), r"'trans' has shape \(4, 3\); expected \(5, 3\)"),
        ({"poses": np.zeros((5, 9))}, (), r"'poses' has shape \(5, 9\)"),
        ({"poses": np.zeros((0, 66)), "trans": np.zeros((0, 3))}, (), r"shape \(0, 66\)"),
        ({"poses": np.full((5, 66), np.nan)}, (), "not finite"),
        ({"poses": np.array(["a"] * 5)}, (), "holds no numbers"),
    ],
)
def test_files_that_do_not_fit_are_refused(saved, arrays, drop, message):
    with pytest.raises(ClipError, match=message):
        saved(standing(), drop=drop, **arrays) if "poses" not in arrays else saved(
            arrays["poses"], drop=drop, **{k: v for k, v in arrays.items() if k != "poses"}
        )
