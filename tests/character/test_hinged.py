"""Upper-body hinges that follow a clip."""

from __future__ import annotations

import numpy as np
import pytest

import understudy as us
from understudy.character import athlete_man, athlete_woman
from understudy.character.hinged import UPPER, pointing, upper_angles
from understudy.motion.clip import Clip


def posed(angles):
    """A clip of an athlete whose upper body has these hinge angles."""
    body = athlete_man()
    state = np.zeros((len(angles), body.widths[0]))
    state[:, 2], state[:, 3], state[:, 7 : 7 + UPPER] = 1.0, 1.0, angles
    return Clip(
        skeleton=body.skeleton,
        rotations=body.local_rotations(state),
        root_positions=state[:, :3],
        rate=100.0,
    )


def swings(frames=200, seed=3):
    """Slow angles within all hinges' limits, elbows bent."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 2.0, frames)[:, None]
    waves = np.sin(2.0 * np.pi * (0.4 * time + rng.random(UPPER)))
    middle = np.array([0.0] * 6 + [0.4, 0.1, 0.0, 1.2, 0.0, 0.0] * 2)
    return middle + 0.3 * waves


def test_angles_come_back_from_the_clip_they_pose():
    angles = swings()
    assert upper_angles(posed(angles), athlete_man()) == pytest.approx(angles, abs=0.01)


def test_standing_with_hanging_arms_is_zero():
    found = upper_angles(posed(np.zeros((20, UPPER))), athlete_man())
    assert found == pytest.approx(np.zeros((20, UPPER)), abs=1e-6)


def test_arms_of_a_sample_are_shown_within_a_degree():
    clip, body = us.sample("gesture"), athlete_woman()
    away = pointing(clip, body, upper_angles(clip, body))
    assert away.shape == (clip.frames, 6)
    assert np.degrees(np.sqrt(np.mean(away**2))) < 1.0


def test_angles_stay_within_the_limits_of_the_hinges():
    angles = np.tile(np.zeros(UPPER), (20, 1))
    angles[:, 9] = -0.5  # an elbow bent backward
    assert upper_angles(posed(angles), athlete_man())[:, 9].min() >= 0.0


def test_a_straight_arm_does_not_twist_about_itself():
    angles = swings()
    angles[:, [9, 15]] = 0.01 * np.random.default_rng(0).random((len(angles), 2))
    found = upper_angles(posed(angles), athlete_man())
    assert np.abs(np.diff(found[:, [8, 14]], axis=0)).max() < 0.1
