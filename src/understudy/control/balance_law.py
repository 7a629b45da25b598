"""The law that `Balance` runs in every step; plain functions, compiled by `simulate`.

Its parameters `p`: begin, end, ease; the numbers below; then for either foot its body, the sole's
middle (3), tilt (4), half length and width; a row for each of six joints (see `task.joint_rows`);
number and mass of every body that moves with the pelvis; and one row of the reference per step.
"""

from __future__ import annotations

import math

from understudy.control.quaternion import (
    between,
    composed,
    inverse,
    orientation,
    quaternion_at,
    rotated,
)
from understudy.control.task import (
    JOINT,
    TIMES,
    error_of,
    given_torque,
    gravity_torque,
    put,
    spin_of,
    weight_at,
)

# Time step [s], rows of the reference, mass [kg], gravity [m/s^2], body that all hang on, pelvis,
# bodies; stiffness and damping of the center of mass along the floor [1/s^2, 1/s] and upward;
# of the pelvis' turn [N m/rad, N m s/rad]; part of the legs' servos that stays on.
STEP, COUNT, MASS, GRAVITY, TREE, ROOT, MANY = range(TIMES, TIMES + 7)
PULL, DRAG, LIFT, SINK, TURN, SPIN, SERVOS = range(TIMES + 7, TIMES + 14)
# Part of the sole that may bear; largest moment [N m] given where the feet are at their limit, and
# the largest wanted; how much of what is lacking there the moment takes over, the rest the force.
MARGIN, GIVE, MOST, SPLIT = range(TIMES + 14, TIMES + 18)
FEET, FOOT = TIMES + 18, 10
ROWS = FEET + 2 * FOOT
BODIES = ROWS + 6 * JOINT
# A row of the reference: center of mass from the middle of the feet, velocity, acceleration, change
# of angular momentum; the pelvis' orientation and spin; six joints' rotations and rates.
WIDTH = 4 * 3 + 7 + 6 * 7
# A center of mass lower than this part of where it should be has fallen.
FALLEN = 0.65
# A foot keeps at least this part of the load, and turns the body with this part of its own.
LEAST, GRIP = 0.05, 0.5


def law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """Change the commands of hips, knees and ankles so that the body keeps its balance."""
    weight = weight_at(time, parameters)
    if weight == 0.0:
        return
    p = parameters
    bodies = int(p[MANY])
    step = min(int(time / p[STEP] + 0.5), int(p[COUNT]) - 1)
    now = BODIES + 2 * bodies + step * WIDTH
    left, right = sole_at(state, p, FEET), sole_at(state, p, FEET + FOOT)
    height = state.subtree_com[int(p[TREE]), 2] - 0.5 * (left[2] + right[2])
    if height < FALLEN * p[now + 2]:
        memory[0] = 1.0
    if memory[0] > 0.0:
        go_limp(state, ctrl, p, weight)
        return
    force, moment = wanted(state, p, now, left, right)
    left_push, right_push = shared(state, p, left, right, force, moment)
    for k in range(6):
        push = left_push if k < 3 else right_push
        row = ROWS + k * JOINT
        torque = leg_torque(state, p, row, push)
        at = now + 19 + 7 * k
        ex, ey, ez = error_of(state, p, row, quaternion_at(p, at))
        x, y, z = spin_of(state, int(p[row + 3]))
        stiff, damp = p[SERVOS] * p[row + 5], p[row + 6]
        torque = (
            torque[0] + stiff * ex + damp * (p[at + 4] - x),
            torque[1] + stiff * ey + damp * (p[at + 5] - y),
            torque[2] + stiff * ez + damp * (p[at + 6] - z),
        )
        put(ctrl, p, row, given_torque(state, p, row, torque), weight)


def go_limp(state, ctrl, p, weight):  # type: ignore[no-untyped-def]
    """Legs of a body that fell: no torque but damping; pushing on would throw it into the air."""
    for k in range(6):
        row = ROWS + k * JOINT
        put(ctrl, p, row, quaternion_at(state.qpos, int(p[row + 2])), weight)


def sole_at(state, p, foot):  # type: ignore[no-untyped-def]
    """Middle of a sole [m], then the directions ahead and to the left along it, world."""
    body = int(p[foot])
    turn = orientation(state.xquat, body)
    x, y, z = rotated(turn, (p[foot + 1], p[foot + 2], p[foot + 3]))
    flat = composed(turn, inverse(quaternion_at(p, foot + 4)))
    ahead, aside = rotated(flat, (1.0, 0.0, 0.0)), rotated(flat, (0.0, 1.0, 0.0))
    return (
        state.xpos[body, 0] + x,
        state.xpos[body, 1] + y,
        state.xpos[body, 2] + z,
        ahead[0],
        ahead[1],
        aside[0],
        aside[1],
    )


def velocity_of(state, p, bodies):  # type: ignore[no-untyped-def]
    """Velocity of the center of mass [m/s]."""
    tree = int(p[TREE])
    cx, cy, cz = state.subtree_com[tree, 0], state.subtree_com[tree, 1], state.subtree_com[tree, 2]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(bodies):
        b, m = int(p[BODIES + 2 * k]), p[BODIES + 2 * k + 1]
        rx, ry, rz = state.xipos[b, 0] - cx, state.xipos[b, 1] - cy, state.xipos[b, 2] - cz
        wx, wy, wz = state.cvel[b, 0], state.cvel[b, 1], state.cvel[b, 2]
        x += m * (state.cvel[b, 3] + wy * rz - wz * ry)
        y += m * (state.cvel[b, 4] + wz * rx - wx * rz)
        z += m * (state.cvel[b, 5] + wx * ry - wy * rx)
    mass = p[MASS]
    return x / mass, y / mass, z / mass


def wanted(state, p, now, left, right):  # type: ignore[no-untyped-def]
    """Force [N] on the center of mass and moment [N m] about it that bring the body back."""
    tree, root = int(p[TREE]), int(p[ROOT])
    k, d, kz, dz = p[PULL], p[DRAG], p[LIFT], p[SINK]
    ox = p[now] + 0.5 * (left[0] + right[0]) - state.subtree_com[tree, 0]
    oy = p[now + 1] + 0.5 * (left[1] + right[1]) - state.subtree_com[tree, 1]
    oz = p[now + 2] + 0.5 * (left[2] + right[2]) - state.subtree_com[tree, 2]
    vx, vy, vz = velocity_of(state, p, int(p[MANY]))
    m, g = p[MASS], p[GRAVITY]
    up = kz * oz + dz * (p[now + 5] - vz) + p[now + 8]
    force = (
        m * (k * ox + d * (p[now + 3] - vx) + p[now + 6]),
        m * (k * oy + d * (p[now + 4] - vy) + p[now + 7]),
        m * (g + within(up, 0.5 * g)),
    )
    turn = orientation(state.xquat, root)
    ex, ey, ez = rotated(turn, between(turn, quaternion_at(p, now + 12)))
    k, d = p[TURN], p[SPIN]
    moment = (
        k * ex + d * (p[now + 16] - state.cvel[root, 0]) + p[now + 9],
        k * ey + d * (p[now + 17] - state.cvel[root, 1]) + p[now + 10],
        k * ez + d * (p[now + 18] - state.cvel[root, 2]) + p[now + 11],
    )
    return force, moment


def room(p, foot, sole, x, y):  # type: ignore[no-untyped-def]
    """How far the pressure can go along the direction (x, y) from a sole's middle [m]."""
    along = abs(sole[3] * x + sole[4] * y)
    across = abs(sole[5] * x + sole[6] * y)
    return p[MARGIN] * min(p[foot + 8] / max(along, 1e-6), p[foot + 9] / max(across, 1e-6))


def inside(p, foot, sole, x, y):  # type: ignore[no-untyped-def]
    """The way (x, y) from a sole's middle, shortened so that it ends on the sole [m]."""
    ahead = within(sole[3] * x + sole[4] * y, p[MARGIN] * p[foot + 8])
    aside = within(sole[5] * x + sole[6] * y, p[MARGIN] * p[foot + 9])
    return ahead * sole[3] + aside * sole[5], ahead * sole[4] + aside * sole[6]


def within(value, most):  # type: ignore[no-untyped-def]
    """The value, at most `most` either way."""
    return min(max(value, -most), most)


def shared(state, p, left, right, force, moment):  # type: ignore[no-untyped-def]
    """What the floor should do to either foot: where it pushes [m] and how hard [N], 6 numbers."""
    tree = int(p[TREE])
    ex, ey = left[0] - right[0], left[1] - right[1]
    apart = max(math.sqrt(ex * ex + ey * ey), 1e-6)
    ex, ey = ex / apart, ey / apart
    nx, ny = ey, -ex
    cx = state.subtree_com[tree, 0] - 0.5 * (left[0] + right[0])
    cy = state.subtree_com[tree, 1] - 0.5 * (left[1] + right[1])
    h = max(state.subtree_com[tree, 2] - 0.5 * (left[2] + right[2]), 1e-3)
    fx, fy, fz = force
    tx, ty = within(moment[0], p[MOST]), within(moment[1], p[MOST])
    # The center of pressure that gives force and moment, from the middle of the feet ...
    x, y = cx - (ty + h * fx) / fz, cy + (tx - h * fy) / fz
    # ... and inside the feet, ahead of the line between them and along it.
    most = min(room(p, FEET, left, nx, ny), room(p, FEET + FOOT, right, nx, ny))
    side = min(room(p, FEET, left, ex, ey), room(p, FEET + FOOT, right, ex, ey))
    ahead = within(x * nx + y * ny, most)
    along = within(x * ex + y * ey, 0.5 * apart + side)
    x, y = along * ex + ahead * nx - cx, along * ey + ahead * ny - cy
    # What cannot be had there: the moment gives a part of it, up to a limit, the force the rest.
    tx = within(tx + p[SPLIT] * (y * fz + h * fy - tx), p[GIVE])
    ty = within(ty + p[SPLIT] * (-x * fz - h * fx - ty), p[GIVE])
    fx, fy = -(ty + x * fz) / h, (tx - y * fz) / h
    share = min(max(0.5 + along / apart, LEAST), 1.0 - LEAST)
    rest = 1.0 - share
    along -= (share - rest) * 0.5 * apart
    x, y = along * ex + ahead * nx, along * ey + ahead * ny
    lx, ly = inside(p, FEET, left, x, y)
    rx, ry = inside(p, FEET + FOOT, right, x, y)
    # About the vertical one foot pushes ahead and the other back.
    twist = within(-moment[2] / apart, GRIP * min(share, rest) * fz)
    return (
        (
            left[0] + lx,
            left[1] + ly,
            left[2],
            share * fx + twist * nx,
            share * fy + twist * ny,
            share * fz,
        ),
        (
            right[0] + rx,
            right[1] + ry,
            right[2],
            rest * fx - twist * nx,
            rest * fy - twist * ny,
            rest * fz,
        ),
    )


def leg_torque(state, p, row, push):  # type: ignore[no-untyped-def]
    """Torque at a leg's joint under a push of the floor, in its body's frame [N m]."""
    body = int(p[row])
    x, y, z = (
        push[0] - state.xpos[body, 0],
        push[1] - state.xpos[body, 1],
        push[2] - state.xpos[body, 2],
    )
    fx, fy, fz = push[3], push[4], push[5]
    back = inverse(orientation(state.xquat, body))
    tx, ty, tz = rotated(back, (fy * z - fz * y, fz * x - fx * z, fx * y - fy * x))
    gx, gy, gz = gravity_torque(state, body, p[row + 7])
    return tx + gx, ty + gy, tz + gz
