"""The step functions of the drive: what pushes every rigid body, from its state and its target.

Plain scalar functions that read like the paper; `simulate` has them compiled, and they run as they
are, too. For one body with target velocities v*, w* of the next frame (Wilke & Semwal 2017,
equations 1 and 2, and the analogous torque):

    F = K_f m (v* - v) + K_p m (x* - x) + m g
    T = K_f I (w* - w) + K_p I log(q^-1 q*)

The paper's law has the first term of each alone. A strength from 0 to 1 multiplies both.

The numbers come in one row of floats: a header, a stretch per body that does not change, then a
stretch per step and body.
"""

from __future__ import annotations

from understudy.control.quaternion import product, rotation_vector, turned

# Header: bodies, rows, rows per second, K_f, K_p, upward acceleration.
HEADER = 6
# A body: address in qpos, in qvel, parent, body id, mass, 3 inertias, share of K_p, rest
# orientation in its parent's frame (4), its joint in its own frame (3).
BODY = 16
# A step of a body: v* (3), w* (3), x* (3), q* (4), strength.
ROW = 14


def wrench(parameters, b, r, place, turn, velocity, spin):  # type: ignore[no-untyped-def]
    """World force at the center of mass and torque in the body frame, of one body.

    `b` and `r` are where its stretches begin; `spin` is its angular velocity in its own frame.
    """
    gain, stiffness, lift = parameters[3], parameters[4], parameters[5]
    strength, m = parameters[r + 13], parameters[b + 4]
    w, x, y, z = turn
    # F = K_f m (v* - v); the torque likewise, in the body frame, where I is diagonal.
    fx = gain * (parameters[r] - velocity[0])
    fy = gain * (parameters[r + 1] - velocity[1])
    fz = gain * (parameters[r + 2] - velocity[2]) + lift
    tx, ty, tz = turned(w, -x, -y, -z, parameters[r + 3], parameters[r + 4], parameters[r + 5])
    tx, ty, tz = gain * (tx - spin[0]), gain * (ty - spin[1]), gain * (tz - spin[2])
    k = stiffness * parameters[b + 8]
    if k != 0.0:
        fx += k * (parameters[r + 6] - place[0])
        fy += k * (parameters[r + 7] - place[1])
        fz += k * (parameters[r + 8] - place[2])
        qw, qx, qy, qz = product(
            w,
            -x,
            -y,
            -z,
            parameters[r + 9],
            parameters[r + 10],
            parameters[r + 11],
            parameters[r + 12],
        )
        ex, ey, ez = rotation_vector(qw, qx, qy, qz)
        tx, ty, tz = tx + k * ex, ty + k * ey, tz + k * ez
    s = strength * m
    return (
        s * fx,
        s * fy,
        s * fz,
        strength * parameters[b + 5] * tx,
        strength * parameters[b + 6] * ty,
        strength * parameters[b + 7] * tz,
    )


def row_at(parameters, time):  # type: ignore[no-untyped-def]
    """Number of the row of targets that holds at a time."""
    return min(int(time * parameters[2] + 0.5), int(parameters[1]) - 1)


def free_law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """Bodies with free joints: coordinates are those of the center of mass, forces too."""
    qpos, qvel = state.qpos, state.qvel
    n = int(parameters[0])
    row = row_at(parameters, time)
    for j in range(n):
        b = HEADER + BODY * j
        r = HEADER + BODY * n + ROW * (row * n + j)
        if parameters[r + 13] == 0.0:
            continue  # an uncontrolled body
        q, v = int(parameters[b]), int(parameters[b + 1])
        fx, fy, fz, tx, ty, tz = wrench(
            parameters,
            b,
            r,
            (qpos[q], qpos[q + 1], qpos[q + 2]),
            (qpos[q + 3], qpos[q + 4], qpos[q + 5], qpos[q + 6]),
            (qvel[v], qvel[v + 1], qvel[v + 2]),
            (qvel[v + 3], qvel[v + 4], qvel[v + 5]),
        )
        applied[v] += fx
        applied[v + 1] += fy
        applied[v + 2] += fz
        applied[v + 3] += tx
        applied[v + 4] += ty
        applied[v + 5] += tz


def tree_wrenches(time, qpos, body_pos, body_vel, parameters, memory):  # type: ignore[no-untyped-def]
    """World force and torque at every center of mass of a tree, left in `memory`.

    A body's ten places there: its orientation, force, torque.
    """
    n = int(parameters[0])
    row = row_at(parameters, time)
    # The engine gives velocities at the center of mass of the whole tree.
    total, cx, cy, cz = 0.0, 0.0, 0.0, 0.0
    for j in range(n):
        b = HEADER + BODY * j
        i, m = int(parameters[b + 3]), parameters[b + 4]
        total += m
        cx, cy, cz = cx + m * body_pos[i, 0], cy + m * body_pos[i, 1], cz + m * body_pos[i, 2]
    cx, cy, cz = cx / total, cy / total, cz / total
    for j in range(n):
        b, at = HEADER + BODY * j, 10 * j
        r = HEADER + BODY * n + ROW * (row * n + j)
        q, p, i = int(parameters[b]), int(parameters[b + 2]), int(parameters[b + 3])
        if p < 0:
            w, x, y, z = qpos[q + 3], qpos[q + 4], qpos[q + 5], qpos[q + 6]
        else:
            up = 10 * p
            w, x, y, z = product(
                memory[up],
                memory[up + 1],
                memory[up + 2],
                memory[up + 3],
                parameters[b + 9],
                parameters[b + 10],
                parameters[b + 11],
                parameters[b + 12],
            )
            w, x, y, z = product(w, x, y, z, qpos[q], qpos[q + 1], qpos[q + 2], qpos[q + 3])
        memory[at], memory[at + 1], memory[at + 2], memory[at + 3] = w, x, y, z
        dx, dy, dz = body_pos[i, 0] - cx, body_pos[i, 1] - cy, body_pos[i, 2] - cz
        ox, oy, oz = body_vel[i, 0], body_vel[i, 1], body_vel[i, 2]
        fx, fy, fz, tx, ty, tz = wrench(
            parameters,
            b,
            r,
            (body_pos[i, 0], body_pos[i, 1], body_pos[i, 2]),
            (w, x, y, z),
            (
                body_vel[i, 3] + oy * dz - oz * dy,
                body_vel[i, 4] + oz * dx - ox * dz,
                body_vel[i, 5] + ox * dy - oy * dx,
            ),
            turned(w, -x, -y, -z, ox, oy, oz),
        )
        memory[at + 4], memory[at + 5], memory[at + 6] = fx, fy, fz
        tx, ty, tz = turned(w, x, y, z, tx, ty, tz)
        memory[at + 7], memory[at + 8], memory[at + 9] = tx, ty, tz


def tree_law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """A tree of ball joints: a joint carries the wrenches of all bodies beyond it."""
    n = int(parameters[0])
    body_pos = state.xpos
    tree_wrenches(time, state.qpos, body_pos, state.cvel, parameters, memory)
    for j in range(n):  # torques about the world's origin, so that they add up
        at, i = 10 * j, int(parameters[HEADER + BODY * j + 3])
        fx, fy, fz = memory[at + 4], memory[at + 5], memory[at + 6]
        memory[at + 7] += body_pos[i, 1] * fz - body_pos[i, 2] * fy
        memory[at + 8] += body_pos[i, 2] * fx - body_pos[i, 0] * fz
        memory[at + 9] += body_pos[i, 0] * fy - body_pos[i, 1] * fx
    for j in range(n - 1, -1, -1):
        b, at = HEADER + BODY * j, 10 * j
        v, p, i = int(parameters[b + 1]), int(parameters[b + 2]), int(parameters[b + 3])
        w, x, y, z = memory[at], memory[at + 1], memory[at + 2], memory[at + 3]
        fx, fy, fz = memory[at + 4], memory[at + 5], memory[at + 6]
        # The joint's place, about which the torque acts; the root's is its center of mass.
        hx, hy, hz = turned(w, x, y, z, parameters[b + 13], parameters[b + 14], parameters[b + 15])
        hx, hy, hz = hx + body_pos[i, 0], hy + body_pos[i, 1], hz + body_pos[i, 2]
        tx = memory[at + 7] - (hy * fz - hz * fy)
        ty = memory[at + 8] - (hz * fx - hx * fz)
        tz = memory[at + 9] - (hx * fy - hy * fx)
        tx, ty, tz = turned(w, -x, -y, -z, tx, ty, tz)
        if p < 0:
            applied[v] += fx
            applied[v + 1] += fy
            applied[v + 2] += fz
            v += 3
        else:
            for k in range(4, 10):
                memory[10 * p + k] += memory[at + k]
        applied[v] += tx
        applied[v + 1] += ty
        applied[v + 2] += tz
