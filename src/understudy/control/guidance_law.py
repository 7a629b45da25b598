"""The law that `Guidance` runs: how a body is off its plan, and what to do about it, once a window.

Plain scalar functions, compiled by `simulate` and by the search that finds a guidance. The
parameters `p`: the head below; for every steered joint the place of its command and which offset
turns it about x, y and z (-1: none); number, mass, inertia and inertial orientation of every body;
for every joint of limited strength its places in ctrl, qpos and qvel, stiffness, damping and limit;
then one row per window: the posture planned for its start, the offsets, the help and, where there
is feedback, the gains.
"""

from __future__ import annotations

import math

from understudy.control.quaternion import (
    advanced,
    between,
    composed,
    exponential,
    inverse,
    orientation,
    quaternion_at,
    rotated,
    rotation_vector,
)

# Time step [s], steps in a window, windows; first dof of the root; root, left and right ankle as
# bodies; bodies, steered and limited joints, offsets; most that feedback adds [rad]; whether there
# is feedback.
STEP, EVERY, COUNT, DOF, ROOT, LEFT, RIGHT, BODIES, JOINTS, LIMITED, SIZE = range(11)
MOST, FEEDBACK = 11, 12
HEAD, JOINT, BODY, LIMIT = 13, 4, 9, 6
# A posture: center of mass, its velocity, angular momentum about it; the root's orientation and
# angular velocity; both ankles. A deviation has the root's turn as a rotation vector instead.
POSTURE, DEVIATION, HELP = 22, 21, 6

# Less is no deviation: on its plan a body moves as without feedback, bit for bit.
ROUNDING = 1e-10


def law(time, state, ctrl, applied, p, memory):  # type: ignore[no-untyped-def]
    """Turn the commands of the steered joints, by offsets chosen when a window begins."""
    step = int(time / p[STEP] + 0.5)
    window = step // int(p[EVERY])
    if window >= int(p[COUNT]):
        return
    if step == window * int(p[EVERY]):
        decide(state, p, window, memory)
    steer(ctrl, p, memory)
    spare(state, ctrl, p)
    first, helped = int(p[DOF]), row_of(p, window) + POSTURE + int(p[SIZE])
    for k in range(HELP):
        applied[first + k] += p[helped + k]


def row_of(p, window):  # type: ignore[no-untyped-def]
    """Where a window's numbers begin."""
    size = int(p[SIZE])
    width = POSTURE + size + HELP
    if p[FEEDBACK] > 0.0:
        width += size * (DEVIATION + size)
    return limits(p) + LIMIT * int(p[LIMITED]) + window * width


def limits(p):  # type: ignore[no-untyped-def]
    """Where the joints of limited strength begin."""
    return HEAD + JOINT * int(p[JOINTS]) + BODY * int(p[BODIES])


def decide(state, p, window, memory):  # type: ignore[no-untyped-def]
    """Choose a window's offsets: the planned ones, more where the body is off the plan.

    `memory` holds the offsets in force, those of the window before less its plan, and room for a
    posture and a deviation.
    """
    size, row = int(p[SIZE]), row_of(p, window)
    plan = row + POSTURE
    last = memory[size : 2 * size]
    now = memory[2 * size : 2 * size + POSTURE]
    off = memory[2 * size + POSTURE :]
    if p[FEEDBACK] == 0.0:
        for k in range(size):
            memory[k] = p[plan + k]
        return
    before = row_of(p, window - 1) + POSTURE
    for k in range(size):
        last[k] = memory[k] - p[before + k] if window > 0 else 0.0
    posture(state, p, now)
    deviation(now, p[row : row + POSTURE], off)
    at = plan + size + HELP
    for k in range(size):
        more = 0.0
        for j in range(DEVIATION):
            if abs(off[j]) > ROUNDING:
                more += p[at + j] * off[j]
        for j in range(size):
            more += p[at + DEVIATION + j] * last[j]
        memory[k] = p[plan + k] + min(max(more, -p[MOST]), p[MOST])
        at += DEVIATION + size


def steer(ctrl, p, offsets):  # type: ignore[no-untyped-def]
    """Turn every steered joint's command by its offsets, in the outboard link's frame."""
    for joint in range(int(p[JOINTS])):
        at = HEAD + JOINT * joint
        a = offsets[int(p[at + 1])] if p[at + 1] >= 0.0 else 0.0
        b = offsets[int(p[at + 2])] if p[at + 2] >= 0.0 else 0.0
        c = offsets[int(p[at + 3])] if p[at + 3] >= 0.0 else 0.0
        place = int(p[at])
        w, x, y, z = composed(quaternion_at(ctrl, place), exponential(a, b, c))
        ctrl[place], ctrl[place + 1], ctrl[place + 2], ctrl[place + 3] = w, x, y, z


def spare(state, ctrl, p):  # type: ignore[no-untyped-def]
    """Take back commands for which a servo would need more torque than it has.

    The engine could bound a servo's torque itself, but leaves out the damping of one at its limit,
    and now and then, by the last digit, does not. Here the damping stays, and with it long steps.
    """
    for joint in range(int(p[LIMITED])):
        at = limits(p) + LIMIT * joint
        c, v, k, kd, most = int(p[at]), int(p[at + 2]), p[at + 3], p[at + 4], p[at + 5]
        q = quaternion_at(state.qpos, int(p[at + 1]))
        ex, ey, ez = between(q, quaternion_at(ctrl, c))
        x, y, z = state.qvel[v], state.qvel[v + 1], state.qvel[v + 2]
        tx, ty, tz = k * ex - kd * x, k * ey - kd * y, k * ez - kd * z
        size = math.sqrt(tx * tx + ty * ty + tz * tz)
        if size > most:
            s = most / size
            ctrl[c], ctrl[c + 1], ctrl[c + 2], ctrl[c + 3] = advanced(
                q, (s * tx + kd * x) / k, (s * ty + kd * y) / k, (s * tz + kd * z) / k
            )


def posture(state, p, out):  # type: ignore[no-untyped-def]
    """Center of mass [m], its velocity [m/s], angular momentum [kg m^2/s], root and ankles."""
    root = int(p[ROOT])
    cx, cy, cz = state.subtree_com[root, 0], state.subtree_com[root, 1], state.subtree_com[root, 2]
    for k in range(POSTURE):
        out[k] = 0.0
    mass = 0.0
    for k in range(int(p[BODIES])):
        at = HEAD + JOINT * int(p[JOINTS]) + BODY * k
        body, m = int(p[at]), p[at + 1]
        w = state.cvel[body, 0], state.cvel[body, 1], state.cvel[body, 2]
        rx = state.xipos[body, 0] - cx
        ry = state.xipos[body, 1] - cy
        rz = state.xipos[body, 2] - cz
        vx = state.cvel[body, 3] + w[1] * rz - w[2] * ry
        vy = state.cvel[body, 4] + w[2] * rx - w[0] * rz
        vz = state.cvel[body, 5] + w[0] * ry - w[1] * rx
        turn = composed(orientation(state.xquat, body), quaternion_at(p, at + 5))
        i, j, n = rotated(inverse(turn), w)
        x, y, z = rotated(turn, (p[at + 2] * i, p[at + 3] * j, p[at + 4] * n))
        mass += m
        out[3] += m * vx
        out[4] += m * vy
        out[5] += m * vz
        # Moments about the center of mass: its own velocity adds nothing.
        out[6] += x + m * (ry * vz - rz * vy)
        out[7] += y + m * (rz * vx - rx * vz)
        out[8] += z + m * (rx * vy - ry * vx)
    out[0], out[1], out[2] = cx, cy, cz
    for k in range(3):
        out[3 + k] /= mass
        out[13 + k] = state.cvel[root, k]
        out[16 + k] = state.xpos[int(p[LEFT]), k]
        out[19 + k] = state.xpos[int(p[RIGHT]), k]
    for k in range(4):
        out[9 + k] = state.xquat[root, k]


def deviation(now, planned, out):  # type: ignore[no-untyped-def]
    """How far one posture is off another: differences, and the root's turn in the world."""
    for k in range(9):
        out[k] = now[k] - planned[k]
    turn = composed(quaternion_at(now, 9), inverse(quaternion_at(planned, 9)))
    out[9], out[10], out[11] = rotation_vector(turn[0], turn[1], turn[2], turn[3])
    for k in range(12, DEVIATION):
        out[k] = now[k + 1] - planned[k + 1]
