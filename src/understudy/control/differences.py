"""Velocities by central differences of any odd order (Wilke & Semwal 2017, section 2).

Order n uses n points: f' = sum over k = 1 .. (n - 1) / 2 of c_k (f(t + k) - f(t - k)), exact for
polynomials of degree n - 1. Beyond the ends the motion is continued by odd reflection about its
last point, f(-k) = 2 f(0) - f(k), so that the end velocities are those of one-sided differences.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

ORDERS = tuple(range(3, 20, 2))


def checked_order(order: int, frames: int) -> int:
    """The order, if it is odd, from 3 to 19, and the motion is long enough for it.

    Raises:
        InvalidValue: It is none of these.
    """
    if order not in ORDERS:
        raise InvalidValue(f"order is {order}; it must be odd, from 3 to 19.")
    if frames <= order // 2:
        raise InvalidValue(
            f"A difference of order {order} needs {order // 2 + 1} frames; the clip has {frames}."
        )
    return order


def weights(order: int) -> Array:
    """c_1, c_2, ... of the central difference of an odd order, shape ((order - 1) / 2,)."""
    m = order // 2
    whole = factorial(m) ** 2
    return np.array(
        [
            (-1) ** (k + 1) * whole / (k * factorial(m - k) * factorial(m + k))
            for k in range(1, m + 1)
        ]
    )


def velocities(values: Array, rate: float, order: int) -> Array:
    """Time derivative of values, shape (frames, ...), per second; `rate` in frames per second."""
    m, n = checked_order(order, len(values)) // 2, len(values)
    if n == 1:
        return np.zeros_like(values)
    first, last = values[:1], values[-1:]
    padded = np.concatenate(
        (2.0 * first - values[m:0:-1], values, 2.0 * last - values[-2 : -m - 2 : -1])
    )
    return _differences(padded, rate, order)


def angular_velocities(rotations: Array, rate: float, order: int) -> Array:
    """World angular velocity [rad/s], shape (frames, ..., 3), of orientations (frames, ..., 4).

    The derivative of the quaternion is the central difference of its numbers, neighbors in one
    hemisphere; omega = 2 q' q^-1. Reflection about an end turns by the opposite rotation.
    """
    m, n = checked_order(order, len(rotations)) // 2, len(rotations)
    if n == 1:
        return np.zeros((*rotations.shape[:-1], 3))
    q = rot.continuous(rotations)

    def reflected(end: Array, inner: Array) -> Array:
        return rot.multiply(end, rot.multiply(rot.conjugate(inner), end))

    padded = np.concatenate(
        (reflected(q[:1], q[m:0:-1]), q, reflected(q[-1:], q[-2 : -m - 2 : -1]))
    )
    change = _differences(rot.continuous(padded), rate, order)
    return 2.0 * rot.multiply(change, rot.conjugate(q))[..., 1:]


def _differences(padded: Array, rate: float, order: int) -> Array:
    """Central differences of values that have (order - 1) / 2 extra frames at both ends."""
    m = order // 2
    n = len(padded) - 2 * m
    out = np.zeros((n, *padded.shape[1:]))
    for k, c in enumerate(weights(order), 1):
        out += c * (padded[m + k : m + k + n] - padded[m - k : m - k + n])
    return out * rate
