"""A pelvis moved a little, so that the ground can give what the motion takes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import understudy as us
from understudy.character import Character, adult_woman, retargeted
from understudy.character.planting import planted
from understudy.character.soles import sole_paths, standing
from understudy.control.feedforward import REACH, required
from understudy.control.supported import MOST_SHIFT, supported
from understudy.motion.clip import Clip
from understudy.motion.samples import sample
from understudy.scene import Ground, Scene

BODY, FLOOR, RATE = adult_woman(), Ground(), 120.0
SCENE = Scene(characters=(BODY,), ground=FLOOR)


def lack(clip: Clip, body: Character = BODY) -> float:
    """Root mean square of the force the ground cannot give [% of body weight]."""
    scene = SCENE if body is BODY else Scene(characters=(body,), ground=FLOOR)
    need = required(scene, scene.model, 0, clip, contact=True, reach=REACH, smoothing=0.125)
    force = np.linalg.norm(need.root[:, :3], axis=1)
    return float(100.0 * np.sqrt(np.mean(force**2)) / (body.simulated_mass * 9.81))


def statue(heights: Any) -> Clip:
    """The body in one pose, its feet this high over the floor [m], shape (frames,)."""
    pose = standing(retargeted(sample("gesture").trimmed(0.0, 0.2), BODY), BODY)
    frames = len(heights)
    path = np.repeat(pose.root_positions[:1], frames, axis=0)
    path[:, 2] += heights
    turned = np.repeat(pose.rotations[:1], frames, axis=0)
    return replace(pose, rotations=turned, root_positions=path, rate=RATE)


def flight(gravity: float) -> np.ndarray:
    """Heights of feet in half a second of a flight under this gravity, 5 cm up at its ends."""
    time = np.arange(61) / RATE
    return 0.05 + 0.5 * gravity * time * (0.5 - time)


def test_a_body_that_stands_stays():
    still = statue(np.zeros(100))
    assert supported(still, BODY, FLOOR) is still


def test_a_flight_under_the_wrong_gravity_is_bent_to_the_right_one():
    wrong = statue(flight(12.0))
    right = supported(wrong, BODY, FLOOR)
    assert lack(right) < 0.4 * lack(wrong)
    moved = np.linalg.norm(right.root_positions - wrong.root_positions, axis=1)
    assert 0.003 < moved.max() < MOST_SHIFT
    assert right.notes[-1].startswith("Moved the pelvis by up to")


def test_a_flight_under_the_right_gravity_stays():
    right = statue(flight(9.81))
    assert supported(right, BODY, FLOOR) is right


def test_a_body_without_a_support_is_left_where_it_is():
    heights = np.zeros(240)
    heights[80:160] = 0.3
    ramp = np.convolve(np.pad(heights, 20, mode="edge"), np.hanning(41) / np.hanning(41).sum())
    hanging = statue(ramp[40:-40])
    out = supported(hanging, BODY, FLOOR)
    np.testing.assert_allclose(
        out.root_positions[100:140], hanging.root_positions[100:140], atol=6e-3
    )


@pytest.mark.parametrize("name", ["walk", "bow"])
def test_feet_stay_where_they_were_planted(name):
    clip = sample(name).trimmed(0.0, 2.0)
    body = Character.from_clip(clip)
    before = planted(standing(retargeted(clip, body), body), body)
    after = supported(before, body, FLOOR)
    old, new = sole_paths(before, body), sole_paths(after, body)
    low = old[..., 2] < 0.02
    np.testing.assert_allclose(new[low], old[low], atol=2e-3)
    assert lack(after, body) <= lack(before, body)


def test_the_same_clip_gives_the_same_bytes():
    clip = statue(flight(11.0))
    first, second = supported(clip, BODY, FLOOR), supported(clip, BODY, FLOOR)
    assert first.rotations.tobytes() == second.rotations.tobytes()
    assert first.root_positions.tobytes() == second.root_positions.tobytes()


@pytest.mark.clips
@pytest.mark.parametrize(("name", "part"), [("02_04", 0.6), ("35_17", 0.6), ("02_01", 0.8)])
def test_captured_motion_lacks_far_less_for_a_few_millimeters(name, part, clips):
    clip = us.read(clips / "cmu_bvh" / f"{name}.bvh")
    body = Character.from_clip(clip)
    before = planted(standing(retargeted(clip.repaired(), body), body), body)
    after = supported(before, body, FLOOR)
    assert lack(after, body) < part * lack(before, body)
    moved = np.linalg.norm(after.root_positions - before.root_positions, axis=1)
    assert moved.mean() < 0.008
