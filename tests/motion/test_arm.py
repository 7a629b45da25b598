"""Inverse kinematics of an arm: gradient, known answers, natural joints, odd chains."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.motion import samples
from understudy.motion.arm import (
    POSITION,
    Arm,
    Objective,
    Posture,
    arm_of,
    moved,
    palm,
    place,
    posture,
    solved,
)
from understudy.motion.clip import Clip
from understudy.motion.skeleton import Skeleton


@pytest.fixture(scope="module")
def gesture() -> Clip:
    return samples.sample("gesture")


def at(clip: Clip, frame: int, joint: str = "right_wrist") -> tuple[Arm, Posture]:
    arm = arm_of(clip, joint)
    pose = posture(arm, clip.skeleton, clip.rotations[frame], clip.root_positions[frame], arm.hand)
    return arm, pose


def turned(before: Posture, after: Posture) -> float:
    return float(np.degrees(rot.angle(rot.from_matrix(before.hand().T @ after.hand()))))


def test_a_posture_is_the_clips_own_forward_kinematics(gesture):
    for joint in ("left_wrist", "right_wrist"):
        arm, pose = at(gesture, 200, joint)
        kinematics, wrist = gesture.forward_kinematics(), gesture.skeleton.index(joint)
        turn = kinematics.rotations[200, wrist]
        expected = kinematics.positions[200, wrist] + rot.rotate(turn, arm.hand)
        assert np.allclose(place(arm, pose), expected, atol=1e-12)
        assert np.allclose(pose.hand(), rot.to_matrix(turn), atol=1e-12)


@pytest.mark.parametrize("weight", POSITION)
@pytest.mark.parametrize("size", [1e-6, 0.3, 1.5])
def test_the_gradient_is_that_of_finite_differences(gesture, weight, size):
    arm, pose = at(gesture, 200)
    objective = Objective(arm, pose, place(arm, pose) + np.array([0.2, -0.1, 0.15]))
    objective.weight = weight
    chance = np.random.default_rng(3)
    for _ in range(5):
        x = size * chance.normal(size=9)
        numeric = approx_fprime(x, lambda y: objective(y)[0], 1e-7)
        _, gradient = objective(x)
        assert np.abs(gradient - numeric).max() < 1e-5 * np.abs(gradient).max() + 1e-6


def test_near_places_are_reached_with_the_hand_as_it_was(gesture):
    chance = np.random.default_rng(4)
    for frame in range(0, gesture.frames, 90):
        arm, pose = at(gesture, frame)
        # Toward the shoulder and a little aside, where the wrist can follow.
        goal = place(arm, pose) + 0.15 * (pose.shoulder - place(arm, pose))
        goal = goal + 0.03 * chance.normal(size=3)
        after = moved(pose, solved(arm, pose, goal))
        assert np.linalg.norm(place(arm, after) - goal) < 1e-4
        assert turned(pose, after) < 2.0


@pytest.mark.parametrize("part", [0.5, 0.8, 0.95, 0.999])
def test_places_within_reach_are_met_to_a_tenth_of_a_millimeter(gesture, part):
    chance = np.random.default_rng(5)
    arm, pose = at(gesture, 300)
    for _ in range(6):
        way = chance.normal(size=3)
        goal = pose.shoulder + part * arm.reach(pose.point) * way / np.linalg.norm(way)
        after = moved(pose, solved(arm, pose, goal))
        assert np.linalg.norm(place(arm, after) - goal) < 1e-4


def test_where_the_hand_is_already_nothing_turns(gesture):
    arm, pose = at(gesture, 200)
    assert np.abs(solved(arm, pose, place(arm, pose))).max() < 1e-6


def test_the_elbow_bends_about_its_own_axis_and_not_backward(gesture):
    arm, pose = at(gesture, 200)
    upper, lower = (v / np.linalg.norm(v) for v in (arm.upper, arm.lower))
    across = np.cross(arm.hinge, upper)
    for fraction in (0.55, 0.75, 0.9):
        goal = pose.shoulder + fraction * (place(arm, pose) - pose.shoulder)
        goal = goal + np.array([0.1, 0.05, 0.0])
        after = moved(pose, solved(arm, pose, goal))
        before, now = pose.elbow @ lower, after.elbow @ lower
        assert abs((now - before) @ arm.hinge) < 0.15
        assert now @ across > -0.05


def test_the_palm_lies_half_way_to_the_far_end_of_the_hand(gesture):
    skeleton = gesture.skeleton
    end = skeleton.end_offsets[skeleton.end_joints.index(skeleton.index("left_wrist"))]
    assert np.allclose(palm(skeleton, "left_wrist"), 0.5 * end)


def test_joints_of_no_length_are_passed():
    names = ("root", "arm", "twist", "fore", "fore2", "hand", "finger")
    offsets = np.array(
        [[0, 0, 1], [0, 0.2, 0], [0, 0, 0], [0, 0.3, 0], [0, 0, 0], [0, 0.25, 0], [0, 0.1, 0]]
    )
    skeleton = Skeleton(names=names, parents=(-1, 0, 1, 2, 3, 4, 5), offsets=offsets)
    turns = 0.4 * np.random.default_rng(6).normal(size=(3, 7, 3))
    clip = Clip(
        skeleton=skeleton,
        rotations=rot.from_rotvec(turns),
        root_positions=np.zeros((3, 3)),
        rate=30.0,
    )
    arm = arm_of(clip, "hand")
    assert [names[i] for i in arm.path] == ["twist", "fore", "fore2", "hand"]
    assert [names[i] for i in arm.joints] == ["twist", "fore2", "hand"]
    _, pose = at(clip, 1, "hand")
    assert np.allclose(
        place(arm, pose),
        0.5 * clip.forward_kinematics().positions[1, 5:].sum(axis=0),
    )
    goal = pose.shoulder + 0.8 * (place(arm, pose) - pose.shoulder)
    assert np.linalg.norm(place(arm, moved(pose, solved(arm, pose, goal))) - goal) < 1e-4


def test_an_arm_that_never_bends_still_bends_forward():
    rest = samples.sample("gesture")
    still = Clip(
        skeleton=rest.skeleton,
        rotations=rot.identity(2, len(rest.skeleton)),
        root_positions=rest.root_positions[:2],
        rate=30.0,
    )
    for joint in ("left_wrist", "right_wrist"):
        arm, pose = at(still, 0, joint)
        goal = pose.shoulder + 0.7 * (place(arm, pose) - pose.shoulder)
        after = moved(pose, solved(arm, pose, goal))
        lower = after.upper @ after.elbow @ arm.lower
        # Turning about the hinge from the upper arm's direction is forward or as it was.
        assert np.linalg.norm(place(arm, after) - goal) < 1e-4
        assert np.cross(after.upper @ arm.upper, lower) @ (after.upper @ arm.hinge) > -1e-3


def test_a_joint_without_an_arm_is_refused(gesture):
    with pytest.raises(UnknownName, match="right_wrist"):
        arm_of(gesture, "right_wrst")
    with pytest.raises(InvalidValue, match="'lower_back' cannot be placed"):
        arm_of(gesture, "lower_back")
