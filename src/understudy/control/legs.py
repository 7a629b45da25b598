"""Legs for laws: closed-form kinematics, idle legs, and hips that turn the body.

A leg hangs on the pelvis by three hinges at the hip, in this order: x (to the left), flexion about
-y, z; then a knee that flexes about +y and an ankle that dorsiflexes about -y. Frames are x
forward, y left, z up. Scalar functions; they run as they are and compiled.
"""

from __future__ import annotations

import math

from understudy.control.trajectory import bounded


def ankle_of(hip_x, hip_y, knee, thigh, shank):  # type: ignore[no-untyped-def]
    """Place of the ankle from the hip [m], in the pelvis frame; the hip's turn about z is zero."""
    x = thigh * math.sin(hip_y) + shank * math.sin(hip_y - knee)
    down = thigh * math.cos(hip_y) + shank * math.cos(hip_y - knee)
    return x, math.sin(hip_x) * down, -math.cos(hip_x) * down


def leg_length(knee, thigh, shank):  # type: ignore[no-untyped-def]
    """From hip to ankle [m] at a flexion of the knee."""
    square = thigh * thigh + shank * shank + 2.0 * thigh * shank * math.cos(knee)
    return math.sqrt(max(square, 0.0))


def knee_for(length, thigh, shank):  # type: ignore[no-untyped-def]
    """Flexion of the knee at which the ankle is `length` from the hip, or as near as it gets."""
    cosine = (length * length - thigh * thigh - shank * shank) / (2.0 * thigh * shank)
    return math.acos(bounded(cosine, -1.0, 1.0))


def leg_angles(x, y, z, thigh, shank):  # type: ignore[no-untyped-def]
    """Hip x, hip y and knee that put the ankle at (x, y, z) from the hip: `ankle_of` undone.

    Beyond reach the straight leg points at the place.
    """
    knee = knee_for(math.sqrt(x * x + y * y + z * z), thigh, shank)
    hip_x, hip_y = leg_toward(x, y, z, knee, thigh, shank)
    return hip_x, hip_y, knee


def leg_toward(x, y, z, knee, thigh, shank):  # type: ignore[no-untyped-def]
    """Hip x and hip y with which the ankle lies in the direction (x, y, z), the knee given."""
    behind = math.atan2(shank * math.sin(knee), thigh + shank * math.cos(knee))
    return math.atan2(y, -z), math.atan2(x, math.sqrt(y * y + z * z)) + behind


def foothold(x, y, knee, thigh, shank, heel_x, heel_z, foot):  # type: ignore[no-untyped-def]
    """Where the ankle is when the heel touches at (x, y) from the hip over level ground [m].

    "The length of the leg at touchdown is fixed and is used to calculate the vertical distance from
    the hip to the heel": here the length is given by the knee.

    Args:
        x: Forward, hip to heel (equation 1).
        y: To the left, hip to heel (equation 2).
        knee: Its flexion at touchdown [rad].
        thigh: Length [m].
        shank: Length [m].
        heel_x: Heel forward of the ankle in the foot [m], negative.
        heel_z: Heel over the ankle [m], negative.
        foot: Toe-up pitch of the foot at touchdown [rad].
    """
    away_x = heel_x * math.cos(foot) - heel_z * math.sin(foot)
    length = leg_length(knee, thigh, shank)
    ax = x - away_x
    square = length * length - ax * ax - y * y
    return ax, y, -math.sqrt(max(square, 0.35 * length * length))


def mirrored_hip(start, other, other_start, share, offset):  # type: ignore[no-untyped-def]
    """Idle hip's angle (equations 3 and 4): its own at liftoff, less what the other has gained.

    The paper's has a share of 1 and an offset of 0.
    """
    return start - share * (other - other_start) + offset


def hip_axes(hip_x, hip_y):  # type: ignore[no-untyped-def]
    """Axes of the hip's y and z hinges in the pelvis frame; x is (1, 0, 0)."""
    sx, cx = math.sin(hip_x), math.cos(hip_x)
    sy, cy = math.sin(hip_y), math.cos(hip_y)
    return (0.0, -cx, -sx), (-sy, -sx * cy, cx * cy)


def hip_torques(tx, ty, tz, hip_x, hip_y):  # type: ignore[no-untyped-def]
    """A synergy: torques of the three hip hinges that turn the pelvis by (tx, ty, tz) [N m].

    The torque is given in the pelvis frame; the pelvis feels the opposite of what moves the thigh.
    """
    (bx, by, bz), (cx, cy, cz) = hip_axes(hip_x, hip_y)
    return -tx, -(bx * tx + by * ty + bz * tz), -(cx * tx + cy * ty + cz * tz)
