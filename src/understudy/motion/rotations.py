"""Rotations as unit quaternions, wxyz, batched over leading axes.

Everything here is a closed form on arrays: a quaternion array has shape (..., 4), a vector array
(..., 3), and leading axes broadcast. Angles are radians. A quaternion q turns a vector v of the
child frame into the parent frame: v_parent = rotate(q, v_child).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

Array = np.ndarray[Any, np.dtype[np.float64]]


def identity(*shape: int) -> Array:
    """Identity rotations, shape (*shape, 4)."""
    out = np.zeros((*shape, 4))
    out[..., 0] = 1.0
    return out


def normalized(q: ArrayLike) -> Array:
    """Quaternions scaled to unit length; a zero quaternion becomes the identity."""
    q = np.asarray(q, float)
    length = np.linalg.norm(q, axis=-1, keepdims=True)
    unit = q / np.where(length > 0.0, length, 1.0)
    return np.where(length > 0.0, unit, identity())


def multiply(a: ArrayLike, b: ArrayLike) -> Array:
    """Composition a b: first b, then a."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    out = np.empty((*np.broadcast_shapes(a.shape[:-1], b.shape[:-1]), 4))
    out[..., 0] = aw * bw - ax * bx - ay * by - az * bz
    out[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    out[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    out[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return out


def conjugate(q: ArrayLike) -> Array:
    """Inverse of unit quaternions."""
    return np.asarray(q, float) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Vectors v, shape (..., 3), turned by q."""
    q, v = np.asarray(q, float), np.asarray(v, float)
    w, x, y, z = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    a, b, c = v[..., 0], v[..., 1], v[..., 2]
    # v + 2 w (u x v) + 2 u x (u x v) with u = (x, y, z); written out, np.cross is much slower.
    i, j, k = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    out = np.empty((*np.broadcast_shapes(q.shape[:-1], v.shape[:-1]), 3))
    out[..., 0] = a + w * i + (y * k - z * j)
    out[..., 1] = b + w * j + (z * i - x * k)
    out[..., 2] = c + w * k + (x * j - y * i)
    return out


def to_matrix(q: ArrayLike) -> Array:
    """Rotation matrices, shape (..., 3, 3)."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(m: ArrayLike) -> Array:
    """Quaternions of rotation matrices, shape (..., 3, 3) to (..., 4), w >= 0."""
    m = np.asarray(m, float)
    q = Rotation.from_matrix(m.reshape(-1, 3, 3)).as_quat(canonical=True, scalar_first=True)
    return q.reshape(*m.shape[:-2], 4)


def to_rotvec(q: ArrayLike) -> Array:
    """Rotation vectors [rad], shape (..., 3), length in [0, pi]."""
    q = np.asarray(q, float)
    q = np.where(q[..., :1] < 0.0, -q, q)
    s = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(s, q[..., :1])
    scale = np.where(s > 1e-9, 2.0 * half / np.where(s > 1e-9, s, 1.0), 2.0)
    return scale * q[..., 1:]


def from_rotvec(v: ArrayLike) -> Array:
    """Quaternions of rotation vectors [rad], shape (..., 3)."""
    v = np.asarray(v, float)
    theta = np.linalg.norm(v, axis=-1, keepdims=True)
    scale = 0.5 * np.sinc(theta / (2.0 * np.pi))
    return np.concatenate((np.cos(0.5 * theta), scale * v), axis=-1)


def from_euler(order: str, angles: ArrayLike) -> Array:
    """Quaternions of intrinsic Euler angles [rad], shape (..., len(order)).

    `order` lists the axes as a BVH file lists its channels: "ZXY" turns about z, then about the
    turned x, then about the twice turned y.
    """
    angles = np.asarray(angles, float)
    q: Array | None = None
    for k, axis in enumerate(order.upper()):
        one = np.zeros((*angles.shape[:-1], 4))
        one[..., 0] = np.cos(0.5 * angles[..., k])
        one[..., 1 + "XYZ".index(axis)] = np.sin(0.5 * angles[..., k])
        q = one if q is None else multiply(q, one)
    return identity(*angles.shape[:-1]) if q is None else q


def to_euler(q: ArrayLike, order: str) -> Array:
    """Intrinsic Euler angles [rad], shape (..., 3), of three different axes such as "ZXY".

    The middle angle lies in [-pi/2, pi/2]. At gimbal lock the third angle is zero; the rotation is
    still exact.
    """
    q = np.asarray(q, float)
    i, j, k = ("XYZ".index(axis) for axis in order.upper())
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    m = to_matrix(q)
    middle = np.arctan2(sign * m[..., i, k], np.hypot(m[..., i, i], m[..., i, j]))
    locked = np.hypot(m[..., i, i], m[..., i, j]) < 1e-9
    first = np.arctan2(-sign * m[..., j, k], m[..., k, k])
    third = np.arctan2(-sign * m[..., i, j], m[..., i, i])
    first = np.where(locked, np.arctan2(sign * m[..., k, j], m[..., j, j]), first)
    third = np.where(locked, 0.0, third)
    return np.stack((first, middle, third), axis=-1)


def slerp(a: ArrayLike, b: ArrayLike, weight: ArrayLike) -> Array:
    """Spherical interpolation from a (weight 0) to b (weight 1), the short way; weight (...)."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    w = np.asarray(weight, float)[..., None]
    return multiply(a, from_rotvec(w * to_rotvec(multiply(conjugate(a), b))))


def continuous(q: ArrayLike, axis: int = 0) -> Array:
    """The same rotations with signs chosen so that neighbors along `axis` share a hemisphere."""
    q = np.moveaxis(np.array(q, float), axis, 0)
    apart = np.einsum("...i,...i->...", q[1:], q[:-1]) < 0.0
    if np.any(apart):
        flipped = np.logical_xor.accumulate(apart, axis=0)[..., None]
        np.negative(q[1:], out=q[1:], where=flipped)
    return np.moveaxis(q, 0, axis)


def angle(q: ArrayLike) -> Array:
    """Rotation angle [rad] in [0, pi], shape (...)."""
    q = np.asarray(q, float)
    return 2.0 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), np.abs(q[..., 0]))


def angle_between(a: ArrayLike, b: ArrayLike) -> Array:
    """Geodesic angle [rad] between rotations, shape (...)."""
    return angle(multiply(conjugate(a), b))


def shortest_arc(u: ArrayLike, v: ArrayLike) -> Array:
    """The smallest rotation that turns direction u into direction v, shapes (..., 3)."""
    a, b = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
    a = a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-300)
    b = b / np.maximum(np.linalg.norm(b, axis=-1, keepdims=True), 1e-300)
    w = 1.0 + np.sum(a * b, axis=-1, keepdims=True)
    # Opposite directions: half a turn about any axis at right angles to u.
    other = np.where(np.abs(a[..., :1]) < 0.9, np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))
    opposite = np.concatenate((np.zeros_like(w), np.cross(a, other)), axis=-1)
    return normalized(np.where(w > 1e-9, np.concatenate((w, np.cross(a, b)), axis=-1), opposite))


def mean(q: ArrayLike, axis: int = 0) -> Array:
    """The average rotation along `axis` (largest eigenvector of the sum of outer products)."""
    q = np.moveaxis(np.asarray(q, float), axis, 0)
    outer = np.einsum("n...i,n...j->...ij", q, q)
    return np.linalg.eigh(outer)[1][..., -1]


def angular_velocity(q: ArrayLike, rate: float) -> Array:
    """Angular velocity [rad/s], shape (frames, ..., 3), in the parent frame of q.

    Central differences over two frames, one-sided at the ends; `rate` is frames per second.
    """
    q = np.asarray(q, float)
    if len(q) < 2:
        return np.zeros((*q.shape[:-1], 3))
    step = to_rotvec(multiply(q[1:], conjugate(q[:-1]))) * rate
    return np.concatenate((step[:1], 0.5 * (step[1:] + step[:-1]), step[-1:]))
