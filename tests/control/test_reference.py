"""A reference between its frames."""

from __future__ import annotations

import numpy as np
import pytest

from bodies import chain, still
from understudy.control.reference import sampled
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip


def swinging(rate: float = 120.0) -> Clip:
    """A smooth motion with known velocities: each joint turns sinusoidally about its own axis."""
    clip = still(chain(3), seconds=1.0, rate=rate)
    t = clip.times
    turned = np.array(clip.rotations)
    axes = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]])
    for joint, axis in enumerate(axes):
        turned[:, joint] = rot.from_rotvec(np.sin(3.0 * t + joint)[:, None] * axis)
    path = np.column_stack((np.sin(2.0 * t), t, np.zeros_like(t)))
    return Clip(skeleton=clip.skeleton, rotations=turned, root_positions=path, rate=rate)


@pytest.mark.parametrize("method", ["spline", "slerp"])
def test_the_reference_passes_through_every_frame(method):
    clip = swinging(30.0)
    out = sampled(clip, clip.times, interpolation=method)
    np.testing.assert_allclose(rot.angle_between(out.rotations, clip.rotations), 0, atol=1e-7)
    np.testing.assert_allclose(out.positions, clip.root_positions, atol=1e-12)


def test_spline_velocities_are_those_of_the_motion():
    clip = swinging()
    t = np.linspace(0.05, 0.95, 400)
    out = sampled(clip, t)
    np.testing.assert_allclose(out.velocities[:, 0], 2.0 * np.cos(2.0 * t), atol=1e-4)
    np.testing.assert_allclose(out.velocities[:, 1], 1.0, atol=1e-9)
    for joint, axis in enumerate([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]]):
        expected = 3.0 * np.cos(3.0 * t + joint)[:, None] * np.array(axis)
        np.testing.assert_allclose(out.rates[:, joint], expected, atol=1e-3)


@pytest.mark.parametrize("method", ["spline", "slerp"])
def test_rates_are_the_derivative_of_the_rotations(method):
    clip = swinging(40.0)
    t = np.arange(20) * 0.04 + 0.1093  # Never at a frame, where slerp has a corner.
    h = 1e-6
    before = sampled(clip, t - h, interpolation=method)
    after = sampled(clip, t + h, interpolation=method)
    step = rot.to_rotvec(rot.multiply(rot.conjugate(before.rotations), after.rotations))
    here = sampled(clip, t, interpolation=method)
    np.testing.assert_allclose(here.rates, step / (2 * h), atol=1e-4)


def test_the_reference_rests_before_its_start_and_after_its_end():
    clip = swinging()
    out = sampled(clip, np.array([-1.0, 5.0]))
    np.testing.assert_array_equal(out.rates, 0.0)
    np.testing.assert_array_equal(out.velocities, 0.0)
    np.testing.assert_allclose(out.positions, clip.root_positions[[0, -1]])


def test_a_single_frame_is_held():
    clip = still(chain(2), seconds=0.0)
    out = sampled(clip, np.linspace(0.0, 1.0, 5))
    assert out.qpos().shape == (5, 3 + 4 * 2)
    assert out.qvel().shape == (5, 3 + 3 * 2)
    np.testing.assert_array_equal(out.qvel(), 0.0)
