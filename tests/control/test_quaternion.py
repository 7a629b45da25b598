"""The scalar rotations of laws against the array ones of the motion package."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.control import quaternion as scalar
from understudy.motion import rotations as rot


@pytest.fixture(scope="module")
def pairs():
    rng = np.random.default_rng(3)
    q = rot.normalized(rng.normal(size=(200, 2, 4)))
    return q, rng.normal(size=(200, 3)) * rng.choice([1e-7, 1e-3, 1.0], size=(200, 1))


def test_products_and_turns_agree_with_the_array_functions(pairs):
    for (q, r), v in zip(*pairs, strict=True):
        np.testing.assert_allclose(scalar.composed(q, r), rot.multiply(q, r), atol=1e-14)
        np.testing.assert_allclose(scalar.rotated(q, v), rot.rotate(q, v), atol=1e-14)
        np.testing.assert_allclose(scalar.inverse(q), rot.conjugate(q), atol=0)


def test_exponential_and_logarithm_agree_and_undo_each_other(pairs):
    for (q, r), v in zip(*pairs, strict=True):
        np.testing.assert_allclose(scalar.exponential(*v), rot.from_rotvec(v), atol=1e-14)
        np.testing.assert_allclose(scalar.rotation_vector(*q), rot.to_rotvec(q), atol=1e-12)
        back = scalar.advanced(q, *scalar.between(q, r))
        if rot.angle_between(q, r) < 0.94 * np.pi:
            assert rot.angle_between(np.array(back), r) < 1e-7


def test_mixing_is_slerp(pairs):
    for (q, r), _ in zip(*pairs, strict=True):
        if rot.angle_between(q, r) < 0.9 * np.pi:
            mixed = np.array(scalar.mixed(q, r, 0.3))
            assert rot.angle_between(mixed, rot.slerp(q, r, np.array(0.3))) < 1e-7


def test_the_smallest_arc_turns_one_direction_into_the_other(pairs):
    directions = pairs[1][:100], pairs[1][100:]
    for u, v in zip(*directions, strict=True):
        turned = scalar.rotated(scalar.arc(*u, *v), u / np.linalg.norm(u))
        np.testing.assert_allclose(turned, v / np.linalg.norm(v), atol=1e-7)
    for u in np.eye(3):
        turned = scalar.rotated(scalar.arc(*u, *-u), u)
        np.testing.assert_allclose(turned, -u, atol=1e-12)


def test_a_vector_of_half_a_turn_or_more_is_shortened():
    q = scalar.advanced((1.0, 0.0, 0.0, 0.0), 9.0, 0.0, 0.0)
    assert np.linalg.norm(scalar.rotation_vector(*q)) == pytest.approx(0.95 * np.pi)
