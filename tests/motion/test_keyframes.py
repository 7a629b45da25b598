"""Key poses in anatomical angles."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.errors import InvalidValue, UnknownName
from understudy.motion import edits
from understudy.motion import rotations as rot
from understudy.motion.figure import figure
from understudy.motion.keyframes import STANDING, Key, keyframed, rotation
from understudy.motion.mirror import partners, reflected


def posed(**pose):
    return keyframed([Key(time=0.0, pose=pose)], base={}).forward_kinematics()


def moved(joint: str, angle: str, degrees: float, point: str) -> np.ndarray:
    """How far `point` moves from the hanging-arm neutral pose when one angle is set."""
    neutral = {f"{s}_shoulder": {"flexion": 0.0} for s in ("left", "right")}
    i = figure().index(point)
    before = posed(**neutral).positions[0, i]
    angles = {angle: degrees}
    return posed(**(neutral | {joint: angles})).positions[0, i] - before


@pytest.mark.parametrize("side", ["left", "right"])
def test_angles_move_limbs_the_way_anatomy_names_them(side):
    outward = 1.0 if side == "left" else -1.0
    assert moved(f"{side}_hip", "flexion", 30, f"{side}_knee")[0] > 0.1
    assert outward * moved(f"{side}_hip", "abduction", 30, f"{side}_knee")[1] > 0.1
    assert outward * moved(f"{side}_hip", "rotation", 30, f"{side}_ball")[1] < -0.01
    assert moved(f"{side}_knee", "flexion", 30, f"{side}_ankle")[0] < -0.1
    assert moved(f"{side}_ankle", "flexion", 20, f"{side}_ball")[2] > 0.02
    assert moved(f"{side}_shoulder", "flexion", 30, f"{side}_elbow")[0] > 0.1
    assert outward * moved(f"{side}_shoulder", "abduction", 30, f"{side}_elbow")[1] > 0.1
    assert moved(f"{side}_elbow", "flexion", 30, f"{side}_wrist")[0] > 0.1
    assert moved("lower_back", "flexion", 30, "neck")[0] > 0.1
    assert moved("lower_back", "bend", 30, "neck")[1] > 0.1
    assert outward * moved("upper_back", "turn", 30, f"{side}_shoulder")[0] < -0.05


def test_a_neutral_arm_hangs_with_its_elbow_hinge_across():
    arms = posed(left_shoulder={"flexion": 0.0})
    shoulder, elbow = (
        arms.positions[0, figure().index(f"left_{p}")] for p in ("shoulder", "elbow")
    )
    np.testing.assert_allclose((elbow - shoulder)[:2], 0.0, atol=1e-12)
    assert elbow[2] < shoulder[2]


@pytest.mark.parametrize("part", ["shoulder", "elbow", "wrist", "hip", "knee", "ankle", "ball"])
def test_the_same_angles_on_both_sides_are_mirror_images(part):
    angles = {"flexion": 33.0} if part != "ball" else {"extension": 33.0}
    if part in ("shoulder", "hip"):
        angles |= {"abduction": 21.0, "rotation": -12.0}
    pose = {f"{s}_{part}": angles for s in ("left", "right")}
    clip = keyframed([Key(time=0.0, pose=pose)])
    p = clip.forward_kinematics().positions[0]
    image = reflected(p[list(partners(clip.skeleton))], np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(image, p, atol=1e-12)


def test_angles_may_be_arrays_and_vectors():
    many = rotation("left_knee", {"flexion": np.array([0.0, 45.0, 90.0])})
    np.testing.assert_allclose(np.degrees(rot.angle(many)), [0, 45, 90])
    np.testing.assert_allclose(rotation("neck", [0.0, 0.5, 0.0]), rot.from_rotvec([0, 0.5, 0]))


@pytest.mark.parametrize("ease", ["spline", "rest"])
def test_keyed_poses_are_reached_and_held(ease):
    keys = [
        Key(time=0.0, pose=STANDING, root=(0, 0, 0.9)),
        Key(time=0.5, pose={"left_knee": {"flexion": 60}}),
        Key(time=1.0, pose={"left_knee": {"flexion": 20}}, root=(0.3, 0, 0.9)),
        Key(time=1.5, pose={"neck": {"turn": 10}}),
    ]
    clip = keyframed(keys, rate=100.0, ease=ease)
    assert clip.frames == 151
    assert clip.synthetic
    bend = np.degrees(rot.angle(clip.joint("left_knee")))
    np.testing.assert_allclose(bend[[0, 50, 100, 150]], [60, 60, 20, 20], atol=1e-9)
    assert bend.max() <= 60 + 1e-6  # never beyond a key
    assert bend.min() >= 20 - 1e-6
    np.testing.assert_allclose(clip.root_positions[[0, 100], 0], [0.0, 0.3], atol=1e-12)
    speed = edits.joint_velocities(clip)[:, 0, 0]
    assert speed.min() >= -1e-3
    assert abs(speed[0]) < 0.05


def test_rest_ease_takes_minimum_jerk_time():
    clip = keyframed(
        [Key(time=0, pose={"neck": {"turn": 0}}), Key(time=1, pose={"neck": {"turn": 80}})],
        rate=100.0, ease="rest",
    )  # fmt: skip
    s = clip.times
    expected = 80 * s**3 * (10 - 15 * s + 6 * s**2)
    np.testing.assert_allclose(np.degrees(rot.angle(clip.joint("neck"))), expected, atol=1e-6)


def test_bad_keys_are_refused_with_the_reason():
    with pytest.raises(UnknownName, match="angle of left_knee"):
        rotation("left_knee", {"abduction": 3.0})
    with pytest.raises(UnknownName, match="joint named 'left_nee'"):
        keyframed([Key(time=0.0, pose={"left_nee": {"flexion": 1}})])
    with pytest.raises(InvalidValue, match="increase"):
        keyframed([Key(time=1.0), Key(time=1.0)])
    with pytest.raises(InvalidValue, match="at least one key"):
        keyframed([])
    with pytest.raises(InvalidValue, match="finite"):
        Key(time=float("nan"))
    with pytest.raises(InvalidValue, match="finite angle"):
        rotation("neck", {"turn": float("inf")})
    with pytest.raises(InvalidValue, match="ease is"):
        keyframed([Key(time=0.0)], ease="linear")  # type: ignore[arg-type]
    with pytest.raises(InvalidValue, match="rotation vector"):
        rotation("neck", [1.0, 2.0])
