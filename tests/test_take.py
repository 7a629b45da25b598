"""Takes turn back into clips that can be tracked again."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from understudy.character import Character
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.samples import sample
from understudy.performance import Performance, tracked
from understudy.scene import Scene
from understudy.simulate import simulate, track
from understudy.tuning import tracking_error


@pytest.fixture(scope="module")
def take():
    clip = sample("gesture").trimmed(0.5, 1.5)
    return track(clip, Character.from_clip(clip, plan="upper"))


def test_the_clip_of_a_take_has_the_rate_and_skeleton_of_what_was_tracked(take):
    clip = take.clip()
    assert clip.rate == pytest.approx(120.0)
    assert clip.skeleton == take.scene.characters[0].skeleton
    assert clip.frames == take.references[0].frames
    assert clip.synthetic


def test_every_frame_of_the_clip_is_a_simulated_state(take):
    clip = take.clip()
    np.testing.assert_array_equal(clip.root_positions, take.qpos[::4, :3])
    turned = take.qpos[::4, 3:].reshape(clip.rotations.shape)
    np.testing.assert_allclose(rot.angle_between(clip.rotations, turned), 0.0, atol=1e-7)


def test_body_poses_are_those_of_the_clips_forward_kinematics(take):
    times, placed, turned = take.poses(rate=120.0)
    pose = take.clip().forward_kinematics()
    bodies = list(take.scene.parts[0].bodies)
    np.testing.assert_allclose(times, take.clip().times, atol=1e-9)
    np.testing.assert_allclose(placed[:, bodies], pose.positions, atol=1e-9)
    np.testing.assert_allclose(rot.angle_between(turned[:, bodies], pose.rotations), 0, atol=1e-6)


def test_what_was_simulated_can_be_tracked_again(take):
    again = track(take.clip(), take.scene.characters[0])
    assert np.degrees(tracking_error(again)) < 0.5


def test_a_take_is_read_only(take):
    with pytest.raises(ValueError, match="read-only"):
        take.qpos[0, 0] = 1.0


def test_the_same_performance_gives_the_same_take_bit_for_bit():
    clip = sample("walk").trimmed(0.0, 0.5)
    performance = tracked(clip, Character.from_clip(clip))
    first, second = simulate(performance), simulate(performance)
    np.testing.assert_array_equal(first.qpos, second.qpos)
    np.testing.assert_array_equal(first.qvel, second.qvel)


def test_several_characters_perform_in_one_scene():
    from understudy.character import adult_man, child, retargeted
    from understudy.control import Tracking

    clip = sample("gesture").trimmed(0.5, 1.0)
    man, small = adult_man(plan="upper"), child(plan="upper8")
    scene = Scene(characters=(man, small), ground=None, timestep=1.0 / 480.0)
    controllers = tuple(
        Tracking(reference=retargeted(clip, body), character=k, pelvis="led")
        for k, body in enumerate((man, small))
    )
    take = simulate(Performance(scene=scene, controllers=controllers, duration=clip.duration))
    for k in range(2):
        assert np.degrees(tracking_error(take, k)) < 1.0
        assert take.clip(k).skeleton == scene.characters[k].skeleton


def test_a_free_body_that_walks_open_loop_falls():
    clip = sample("walk").trimmed(0.0, 3.0)
    take = track(clip, Character.from_clip(clip), pelvis="free")
    assert take.clip().root_positions[-1, 2] < 0.9 * take.clip().root_positions[0, 2]
    data = mujoco.MjData(take.model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = take.qpos[-1], take.qvel[-1], take.ctrl[-1]
    mujoco.mj_forward(take.model, data)
    np.testing.assert_array_equal(data.qfrc_actuator[:6], 0.0)


def test_a_clip_too_long_for_memory_is_refused_before_it_starts():
    clip = sample("gesture")
    performance = tracked(clip, Character.from_clip(clip, plan="upper"))
    with pytest.raises(InvalidValue, match="GB of states"):
        Performance(scene=performance.scene, duration=1e7)
    with pytest.raises(InvalidValue, match="duration"):
        Performance(scene=performance.scene, duration=float("nan"))


def test_the_score_tells_what_preparing_the_clip_changed():
    from dataclasses import replace

    from understudy.evaluate import score

    clip = sample("walk").trimmed(0.0, 1.5)
    character = Character.from_clip(clip)
    path = np.array(clip.root_positions)
    path[:, 0] += 0.15 * clip.times  # Its feet slide; planted ones do not.
    plain, sliding = (
        score(track(c, character)) for c in (clip, replace(clip, root_positions=path))
    )
    assert abs(plain.joint_error_as_read_deg - plain.joint_error_deg) < 0.5
    assert sliding.joint_error_as_read_deg > sliding.joint_error_deg + 0.5
    assert sliding.feet_as_read_mm > sliding.feet_mm + 5.0
