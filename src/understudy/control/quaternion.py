"""Rotations for laws: scalar functions that run as they are and compiled.

A quaternion is four numbers w, x, y, z, a vector three; `motion.rotations` has the same on arrays.
"""

from __future__ import annotations

import math


def turned(w, x, y, z, a, b, c):  # type: ignore[no-untyped-def]
    """The vector (a, b, c) turned by the quaternion (w, x, y, z)."""
    i, j, k = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return a + w * i + y * k - z * j, b + w * j + z * i - x * k, c + w * k + x * j - y * i


def product(aw, ax, ay, az, bw, bx, by, bz):  # type: ignore[no-untyped-def]
    """The quaternion a b."""
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def rotation_vector(w, x, y, z):  # type: ignore[no-untyped-def]
    """The rotation vector of a unit quaternion, the short way."""
    sign = -1.0 if w < 0.0 else 1.0
    square = x * x + y * y + z * z
    if square < 0.01:  # up to 11 degrees the series of asin(s) / s is right to ten digits
        series = 1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + square * (15.0 / 336.0)))
        scale = 2.0 * sign * (series + square**4 * (105.0 / 3456.0))
    else:
        length = math.sqrt(square)
        scale = 2.0 * sign * math.atan2(length, abs(w)) / length
    return scale * x, scale * y, scale * z


def exponential(a, b, c):  # type: ignore[no-untyped-def]
    """The quaternion of the rotation vector (a, b, c)."""
    angle = math.sqrt(a * a + b * b + c * c)
    scale = 0.5 - angle * angle / 48.0 if angle < 1e-3 else math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), scale * a, scale * b, scale * c


def between(q, r):  # type: ignore[no-untyped-def]
    """Rotation vector from q to r in the frame of q: r = q exp(v)."""
    w, x, y, z = composed(inverse(q), r)
    return rotation_vector(w, x, y, z)


def advanced(q, a, b, c):  # type: ignore[no-untyped-def]
    """q exp(v) for a vector v = (a, b, c) in the frame of q, shortened to under half a turn."""
    length = math.sqrt(a * a + b * b + c * c)
    most = 0.95 * math.pi
    if length > most:
        a, b, c = a * most / length, b * most / length, c * most / length
    return composed(q, exponential(a, b, c))


def mixed(q, r, weight):  # type: ignore[no-untyped-def]
    """Slerp from q (weight 0) to r (weight 1), the short way."""
    a, b, c = between(q, r)
    return advanced(q, weight * a, weight * b, weight * c)


def arc(ux, uy, uz, vx, vy, vz):  # type: ignore[no-untyped-def]
    """The smallest rotation that turns direction u into direction v, which have any length."""
    size = math.sqrt((ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz))
    w = size + ux * vx + uy * vy + uz * vz
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    if w < 1e-9 * size or size == 0.0:  # opposite: half a turn about any axis across
        w = 0.0
        if abs(ux) > abs(uz):
            x, y, z = -uy, ux, 0.0
        else:
            x, y, z = 0.0, -uz, uy
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if length == 0.0:
        return 1.0, 0.0, 0.0, 0.0
    return w / length, x / length, y / length, z / length


def quaternion_at(array, k):  # type: ignore[no-untyped-def]
    """The four numbers of a row of numbers that begin at place k."""
    return array[k], array[k + 1], array[k + 2], array[k + 3]


def orientation(rotations, body):  # type: ignore[no-untyped-def]
    """The quaternion of one body of an array of shape (bodies, 4)."""
    return rotations[body, 0], rotations[body, 1], rotations[body, 2], rotations[body, 3]


def inverse(q):  # type: ignore[no-untyped-def]
    """The opposite rotation."""
    return q[0], -q[1], -q[2], -q[3]


def composed(q, r):  # type: ignore[no-untyped-def]
    """q r: first r, then q."""
    return product(q[0], q[1], q[2], q[3], r[0], r[1], r[2], r[3])


def rotated(q, v):  # type: ignore[no-untyped-def]
    """The vector v turned by q."""
    return turned(q[0], q[1], q[2], q[3], v[0], v[1], v[2])
