"""Central differences of every order: exact where they must be, and at the ends."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.control.differences import ORDERS, angular_velocities, velocities, weights
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot


def test_weights_are_the_published_ones():
    np.testing.assert_allclose(weights(3), [1 / 2], rtol=1e-15)
    np.testing.assert_allclose(weights(5), [2 / 3, -1 / 12], rtol=1e-15)
    np.testing.assert_allclose(weights(7), [3 / 4, -3 / 20, 1 / 60], rtol=1e-15)
    np.testing.assert_allclose(weights(9), [4 / 5, -1 / 5, 4 / 105, -1 / 280], rtol=1e-14)


@pytest.mark.parametrize("order", ORDERS)
def test_an_order_is_exact_for_polynomials_of_one_degree_less(order):
    t = np.arange(-20, 21) / 10.0
    inside = slice(order // 2, len(t) - order // 2)
    exact = (order - 1) * t ** (order - 2)
    found = velocities(t[:, None] ** (order - 1), 10.0, order)[:, 0]
    scale = np.abs(exact[inside]).max()
    np.testing.assert_allclose(found[inside] / scale, exact[inside] / scale, atol=1e-10)


@pytest.mark.parametrize("order", ORDERS)
def test_straight_motion_keeps_its_speed_up_to_the_ends(order):
    t = np.arange(30) / 60.0
    found = velocities(np.stack((2.0 * t, 1.0 - t), axis=1), 60.0, order)
    np.testing.assert_allclose(found, np.broadcast_to([2.0, -1.0], found.shape), atol=1e-12)


def test_an_end_takes_the_one_sided_difference():
    x = np.array([0.0, 1.0, 4.0, 9.0])[:, None]
    np.testing.assert_allclose(velocities(x, 1.0, 3)[:, 0], [1.0, 2.0, 4.0, 5.0])


@pytest.mark.parametrize("order", ORDERS)
def test_a_steady_spin_has_its_rate_in_the_world_at_every_frame(order):
    rate = np.array([1.0, -2.0, 0.5])
    t = np.arange(60) / 60.0
    spin = rot.multiply(rot.from_rotvec(t[:, None] * rate), rot.from_rotvec([0.3, 0.2, 0.1]))
    found = angular_velocities(spin, 60.0, order)
    # A quaternion difference of three points sees 2 sin(w dt / 2) / dt.
    tolerance = 2e-4 if order == 3 else 1e-6
    np.testing.assert_allclose(found, np.broadcast_to(rate, found.shape), atol=tolerance)


def test_signs_of_quaternions_do_not_matter():
    t = np.arange(20) / 60.0
    spin = rot.from_rotvec(t[:, None] * [0.0, 0.0, 3.0])
    flipped = np.where(np.arange(20)[:, None] % 3 == 0, -spin, spin)
    np.testing.assert_array_equal(
        angular_velocities(spin, 60.0, 5), angular_velocities(flipped, 60.0, 5)
    )


@pytest.mark.parametrize("order", [1, 2, 4, 21, 0, -3])
def test_other_orders_are_refused(order):
    with pytest.raises(InvalidValue, match="odd, from 3 to 19"):
        velocities(np.zeros((40, 3)), 60.0, order)


def test_a_clip_too_short_for_an_order_is_refused():
    with pytest.raises(InvalidValue, match="needs 10 frames; the clip has 9"):
        velocities(np.zeros((9, 3)), 60.0, 19)
