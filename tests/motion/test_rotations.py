"""Rotations against closed forms and scipy."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from understudy.motion import rotations as rot

ORDERS = ["".join(order) for order in permutations("XYZ")]


def some(n: int, seed: int = 0) -> np.ndarray:
    return rot.normalized(np.random.default_rng(seed).normal(size=(n, 4)))


def same(a: np.ndarray, b: np.ndarray) -> float:
    """Largest angle between two arrays of rotations [rad]."""
    return float(np.max(rot.angle_between(a, b)))


def test_identity_leaves_vectors_alone():
    v = np.random.default_rng(0).normal(size=(5, 3))
    np.testing.assert_array_equal(rot.rotate(rot.identity(5), v), v)
    assert rot.identity(2, 3).shape == (2, 3, 4)


def test_multiply_and_rotate_agree_with_scipy():
    a, b = some(200), some(200, 1)
    v = np.random.default_rng(2).normal(size=(200, 3))
    ours = rot.rotate(rot.multiply(a, b), v)
    theirs = Rotation.from_quat(a, scalar_first=True) * Rotation.from_quat(b, scalar_first=True)
    np.testing.assert_allclose(ours, theirs.apply(v), atol=1e-13)


def test_leading_axes_broadcast():
    q, v = some(6).reshape(2, 3, 4), np.ones(3)
    assert rot.rotate(q, v).shape == (2, 3, 3)
    assert rot.multiply(q, rot.identity()).shape == (2, 3, 4)
    np.testing.assert_allclose(rot.rotate(q, v)[1, 2], rot.rotate(q[1, 2], v), atol=1e-15)


def test_conjugate_is_the_inverse():
    q = some(100)
    assert same(rot.multiply(q, rot.conjugate(q)), rot.identity(100)) < 1e-7


def test_matrices_round_trip_and_are_proper():
    q = some(100)
    m = rot.to_matrix(q)
    np.testing.assert_allclose(np.linalg.det(m), 1.0, atol=1e-12)
    assert same(rot.from_matrix(m), q) < 1e-7


def test_rotation_vectors_round_trip_for_tiny_and_half_turns():
    axis = np.array([0.6, 0.0, 0.8])
    for angle in (0.0, 1e-12, 1e-6, 0.3, 3.0, np.pi - 1e-9, np.pi):
        v = angle * axis
        np.testing.assert_allclose(rot.to_rotvec(rot.from_rotvec(v)), v, atol=1e-9)


def test_rotation_vector_of_either_sign_is_the_short_way():
    q = some(100)
    np.testing.assert_allclose(rot.to_rotvec(q), rot.to_rotvec(-q), atol=1e-15)
    assert np.linalg.norm(rot.to_rotvec(q), axis=-1).max() <= np.pi + 1e-12


@pytest.mark.parametrize("order", ORDERS)
def test_euler_angles_agree_with_scipy_in_every_order(order):
    angles = np.random.default_rng(3).uniform(-1.5, 1.5, size=(300, 3))
    q = rot.from_euler(order, angles)
    theirs = Rotation.from_euler(order, angles).as_quat(scalar_first=True)
    assert same(q, theirs) < 1e-7
    np.testing.assert_allclose(rot.to_euler(q, order), angles, atol=1e-9)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_euler_angles_are_exact_at_gimbal_lock(order, sign):
    angles = np.random.default_rng(4).uniform(-3, 3, size=(50, 3))
    angles[:, 1] = sign * np.pi / 2
    q = rot.from_euler(order, angles)
    back = rot.to_euler(q, order)
    assert np.isfinite(back).all()
    assert same(rot.from_euler(order, back), q) < 1e-6
    # And just beside it.
    angles[:, 1] += sign * 1e-7
    q = rot.from_euler(order, angles)
    assert same(rot.from_euler(order, rot.to_euler(q, order)), q) < 1e-6


def test_euler_of_fewer_axes_is_the_composition():
    q = rot.from_euler("ZY", np.array([0.3, -0.4]))
    both = rot.multiply(rot.from_rotvec([0, 0, 0.3]), rot.from_rotvec([0, -0.4, 0]))
    assert same(q, both) < 1e-7


def test_slerp_agrees_with_scipy_and_goes_the_short_way():
    a, b = some(40), some(40, 1)
    for k in range(40):
        w = np.linspace(0, 1, 7)
        ours = rot.slerp(a[k], b[k], w)
        keys = Rotation.from_quat([a[k], b[k]], scalar_first=True)
        assert same(ours, Slerp([0, 1], keys)(w).as_quat(scalar_first=True)) < 1e-7
    assert same(rot.slerp(a, b, np.full(40, 0.3)), rot.slerp(a, -b, np.full(40, 0.3))) < 1e-7


def test_slerp_turns_at_constant_speed():
    a, b = rot.identity(), rot.from_rotvec([0.0, 2.0, 0.0])
    angles = rot.angle_between(a, rot.slerp(a, b, np.linspace(0, 1, 11)))
    np.testing.assert_allclose(np.diff(angles), 0.2, atol=1e-12)


def test_continuous_keeps_rotations_and_shares_hemispheres():
    q = some(1)[0] * np.where(np.arange(50) % 3 == 0, -1.0, 1.0)[:, None]
    out = rot.continuous(q)
    assert (np.sum(out[1:] * out[:-1], axis=-1) > 0).all()
    assert same(out, q) < 1e-7
    np.testing.assert_array_equal(rot.continuous(q[None], axis=1)[0], out)


@settings(deadline=None, max_examples=60)
@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_shortest_arc_turns_one_direction_into_the_other(numbers):
    u, v = np.array(numbers[:3]), np.array(numbers[3:])
    if min(np.linalg.norm(u), np.linalg.norm(v)) < 1e-3:
        return
    turned = rot.rotate(rot.shortest_arc(u, v), u / np.linalg.norm(u))
    np.testing.assert_allclose(turned, v / np.linalg.norm(v), atol=2e-4)


def test_shortest_arc_of_opposite_directions_is_half_a_turn():
    for u in np.eye(3):
        q = rot.shortest_arc(u, -u)
        np.testing.assert_allclose(rot.rotate(q, u), -u, atol=1e-12)
        assert abs(rot.angle(q) - np.pi) < 1e-9


def test_mean_of_a_spread_about_an_axis_is_its_middle():
    angles = np.array([-0.4, -0.1, 0.1, 0.4])[:, None] + 0.7
    q = rot.from_rotvec(angles * np.array([0.0, 0.0, 1.0]))
    q[::2] *= -1.0
    assert same(rot.mean(q), rot.from_rotvec([0.0, 0.0, 0.7])) < 1e-7


def test_angular_velocity_of_steady_spin_is_exact():
    rate, omega = 50.0, np.array([0.4, -1.0, 2.0])
    t = np.arange(20) / rate
    q = rot.multiply(rot.from_rotvec(t[:, None] * omega), some(1)[0])
    np.testing.assert_allclose(rot.angular_velocity(q, rate), np.tile(omega, (20, 1)), atol=1e-9)
    assert rot.angular_velocity(q[:1], rate).shape == (1, 3)


def test_normalizing_a_zero_quaternion_gives_the_identity():
    np.testing.assert_array_equal(rot.normalized(np.zeros(4)), [1, 0, 0, 0])
