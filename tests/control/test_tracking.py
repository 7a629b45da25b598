"""What the two laws do, where theory says it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from understudy.character import Character, body, retargeted
from understudy.control import Tracking, gains
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.samples import sample
from understudy.performance import Performance, tracked
from understudy.scene import Scene
from understudy.simulate import simulate, track
from understudy.tuning import servo_torques, tracking_error


@pytest.fixture(scope="module")
def gesture():
    return sample("gesture").trimmed(0.5, 3.0)


@pytest.fixture(scope="module")
def upper(gesture):
    return Character.from_clip(gesture, plan="upper")


def heavier(character: Character, factor: float) -> Character:
    links = tuple(
        replace(link, mass=link.mass * factor, inertia=link.inertia * factor)
        for link in character.links
    )
    return replace(character, links=links, mass=character.mass * factor)


def joint_lag(take) -> float:
    """Delay [s] of the simulated joints that fits the reference best."""
    reference, simulated = take.references[0], take.clip()
    step = 1.0 / simulated.rate
    lags = np.arange(0, round(0.25 / step))
    frames = reference.frames - len(lags)
    errors = [
        rot.angle_between(
            reference.rotations[:frames, 1:], simulated.rotations[lag : lag + frames, 1:]
        ).mean()
        for lag in lags
    ]
    return float(lags[int(np.argmin(errors))] * step)


def test_doubling_every_mass_and_gain_gives_the_same_motion(gesture, upper):
    # Gains follow outboard inertia; the joints' armature is the one inertia that does not scale.
    takes = []
    for character in (upper, heavier(upper, 2.0)):
        scene = Scene(characters=(character,), ground=None, timestep=1.0 / 480.0)
        scene.model.dof_armature[:] = 0.0
        reference = retargeted(gesture, character)
        tracking = Tracking(reference=reference, pelvis="led", law="paper", stiffness=400.0)
        takes.append(simulate(Performance(scene=scene, controllers=(tracking,), duration=2.0)))
    np.testing.assert_allclose(takes[0].qpos, takes[1].qpos, atol=1e-8)
    np.testing.assert_allclose(2.0 * servo_torques(takes[0]), servo_torques(takes[1]), atol=1e-5)


def test_the_papers_law_lags_by_kd_over_k(gesture, upper):
    for damping_time in (0.1, 0.06):
        take = track(gesture, upper, law="paper", stiffness=3000.0, damping_time=damping_time)
        assert joint_lag(take) == pytest.approx(damping_time, abs=0.015)


def test_the_modern_law_has_no_lag_and_little_error(gesture, upper):
    take = track(gesture, upper, law="modern")
    assert joint_lag(take) <= 0.005
    assert np.degrees(tracking_error(take)) < 0.5


def test_velocity_reference_and_inverse_dynamics_follow_even_a_compliant_body(gesture, upper):
    with_both = track(gesture, upper, stiffness=1000.0, feedforward="inverse_dynamics")
    without = track(gesture, upper, stiffness=1000.0, feedforward="none")
    assert np.degrees(tracking_error(with_both)) < 0.3
    assert tracking_error(without) > 3.0 * tracking_error(with_both)


def test_the_error_of_the_papers_law_falls_with_stiffness(gesture, upper):
    errors = [
        tracking_error(track(gesture, upper, law="paper", stiffness=s))
        for s in (100.0, 400.0, 1600.0)
    ]
    assert errors[0] > errors[1] > errors[2]


def test_the_papers_bodies_have_the_papers_degrees_of_freedom(gesture):
    for plan, dof in (("upper8", 24), ("upper", 27), ("full16", 48)):
        character = Character.from_clip(gesture, plan=plan)
        scene = Scene(characters=(character,))
        assert 3 * len(scene.parts[0].joint_actuators) == dof


def test_gains_follow_the_inertia_outboard_of_each_joint(upper):
    scene = Scene(characters=(upper,), ground=None)
    inertia = gains.outboard_inertia(scene.model, scene.parts[0])
    stiffness = gains.joint_stiffness(scene, scene.model, 0, 250.0)
    np.testing.assert_allclose(stiffness, 250.0 * inertia[1:])
    named = dict(zip((link.joint for link in upper.links), inertia, strict=True))
    assert named["left_shoulder"] > named["left_elbow"] > named["left_wrist"] > 0


def test_stance_legs_get_what_standing_needs():
    scene = Scene(characters=(body("adult_man"),))
    man = scene.characters[0]
    k = gains.joint_stiffness(scene, scene.model, 0, 10.0)
    load = man.mass * 9.81 * man.height / gains.STANCE_REFERENCE
    for link, gain in zip(man.links[1:], k, strict=True):
        if link.joint.endswith("_ankle"):
            assert gain == pytest.approx(gains.STANCE_STIFFNESS["ankle"] * load)


def test_torque_limits_hold_in_the_engine(gesture, upper):
    fast = gesture.retimed(6.0)
    take = track(fast, upper, torque_limits="human")
    torque = np.linalg.norm(servo_torques(take), axis=-1)
    limits = np.array([np.max(link.torque_limit) for link in upper.links[1:]])
    assert (torque <= limits * (1 + 1e-9)).all()
    free = np.linalg.norm(servo_torques(track(fast, upper)), axis=-1)
    assert (free.max(axis=0) > limits).any()


def test_a_led_pelvis_keeps_to_its_path(gesture, upper):
    take = track(gesture, upper)
    off = take.clip().root_positions - take.references[0].root_positions
    assert np.abs(off).max() < 0.002


def test_a_walk_stands_on_its_feet_with_little_help():
    clip = sample("walk").trimmed(0.5, 2.5)
    take = track(clip, Character.from_clip(clip), pelvis="assisted")
    part = take.scene.parts[0]
    sunk = take.references[0].root_positions[:, 2] - take.clip().root_positions[:, 2]
    # The root servo is a spring: how far the pelvis hangs below its path is what it carries.
    body_weight = take.scene.characters[0].mass * 9.81
    k = -take.model.actuator_biasprm[part.root_actuators[2], 1]
    assert abs(k * sunk[60:].mean()) < 0.25 * body_weight
    assert np.degrees(tracking_error(take)) < 2.0


def test_any_character_performs_any_clip(gesture):
    for name in ("adult_woman", "child", "alien"):
        take = track(gesture, body(name))
        assert take.diverged is None
        assert np.degrees(tracking_error(take)) < 3.0


def test_settings_outside_their_range_are_refused(gesture, upper):
    reference = retargeted(gesture, upper)
    with pytest.raises(InvalidValue, match="law is 'old'"):
        Tracking(reference=reference, law="old")
    with pytest.raises(InvalidValue, match="stiffness"):
        Tracking(reference=reference, stiffness=-1.0)
    with pytest.raises(InvalidValue, match="feedforward"):
        Tracking(reference=reference, law="paper", feedforward="inverse_dynamics")
    with pytest.raises(InvalidValue, match="retarget"):
        performance = tracked(gesture, upper)
        stranger = Tracking(reference=retargeted(gesture, Character.from_clip(gesture)))
        simulate(replace(performance, controllers=(stranger,)))
