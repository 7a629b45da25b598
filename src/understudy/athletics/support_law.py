"""Feet that bear an athlete: one virtual force and moment, given by hips, knees and ankles.

A synergy, as the paper has for the leg in flight: what the ground is to do to the body, where on
the soles and how hard, is turned into the torques of every joint of the legs. Where the pressure
must be follows from the capture point, over which the body would come to rest. Plain scalar
functions; they run as they are and compiled.
"""

from __future__ import annotations

import math

from understudy.athletics import running_law as law
from understudy.athletics.course import wrapped
from understudy.athletics.running_law import _angle, _put, _rate
from understudy.athletics.standing_gains import BODY_NUMBERS, STANDING_NUMBERS
from understudy.control.legs import hip_torques
from understudy.control.quaternion import inverse, orientation, rotated, turned
from understudy.control.trajectory import bounded

# The body: thighs (left, right; shank and foot follow in the engine's numbering), masses outboard
# of hip, knee and ankle, the sole's end, front and half width in the foot, the tallest height.
# fmt: off
(
    THIGH, _, LEG_MASS, _, _, BACK, FRONT, HALF, HEIGHT
) = range(law.P_STANDING, law.P_STANDING + BODY_NUMBERS)
# Gains, in the order of `StandingGains`.
(
    PULL, LIFT, SINK, TURN, SPIN, REACH, STRAIGHT,
    LEAN_TIME, LEAN_AHEAD, LEAN_ASIDE, LEAN_PITCH, LEAN_DIP, LIFT_AT,
    PUSH_AT, PUSH, PUSH_HIP, PUSH_KNEE, PUSH_TIME,
    FIRST_SPEED, START_RATE, START_LEAD, START_THRUST, START_LEAN,
    STOP_RATE, STOP_LEAD, STOP_DAMPING, STOP_THRUST, STOP_LEAN, STOP_SLOW, STOP_SPEED,
    STEP_TIME, STEP_RISE, STEP_APART, STEP_AHEAD
) = range(law.P_STANDING + BODY_NUMBERS, law.P_STANDING + STANDING_NUMBERS)
# fmt: on

# Most the feet give: of the weight up, of the load along the floor; moments [N m]: of attitude, and
# of bending where the soles end.
_UP, _ALONG, _MOMENT, _GIVE = (0.3, 1.9), 0.6, 120.0, 30.0
# Servo about the vertical and its most per load [m]; toes.
_TWIST, _TWIST_DAMPING, _GRIP = 80.0, 12.0, 0.018
_TOE_STIFFNESS, _TOE_DAMPING = 80.0, 2.0
# Loads go from foot to foot in this time [s]; least share of a foot that bears with the other.
_SHIFT, _LEAST_SHARE = 0.05, 0.03


def sole(state, p, side):  # type: ignore[no-untyped-def]
    """Middle of a sole [m] and the direction ahead along it, world."""
    body = int(p[THIGH + side]) + 2
    turn = orientation(state.xquat, body)
    x, y, z = turned(*turn, 0.5 * (p[BACK] + p[FRONT]), 0.0, p[law.P_HEEL_Z])
    ax, ay, _ = turned(*turn, 1.0, 0.0, 0.0)
    long = max(math.sqrt(ax * ax + ay * ay), 1e-6)
    place = state.xpos[body, 0] + x, state.xpos[body, 1] + y, state.xpos[body, 2] + z
    return place[0], place[1], place[2], ax / long, ay / long


def inside(p, foot, x, y):  # type: ignore[no-untyped-def]
    """The way (x, y) from a sole's middle, shortened so that it ends on the sole [m]."""
    _, _, _, ax, ay = foot
    long = 0.5 * (p[FRONT] - p[BACK])
    ahead = bounded(x * ax + y * ay, -long, long)
    aside = bounded(y * ax - x * ay, -p[HALF], p[HALF])
    return ahead * ax - aside * ay, ahead * ay + aside * ax


def between(left, right, x, y):  # type: ignore[no-untyped-def]
    """Where beside (x, y) the line from the right sole to the left is: 0 right, 1 left."""
    dx, dy = left[0] - right[0], left[1] - right[1]
    return ((x - right[0]) * dx + (y - right[1]) * dy) / max(dx * dx + dy * dy, 1e-6)


def outside(p, left, right, x, y):  # type: ignore[no-untyped-def]
    """The way from the nearest place that two soles hold to (x, y) [m]."""
    share = bounded(between(left, right, x, y), 0.0, 1.0)
    dx, dy = left[0] - right[0], left[1] - right[1]
    mx, my = x - right[0] - share * dx, y - right[1] - share * dy
    lx, ly = inside(p, left, mx, my)
    rx, ry = inside(p, right, mx, my)
    return mx - share * lx - (1.0 - share) * rx, my - share * ly - (1.0 - share) * ry


def shifted(p, left, right, load, x, y):  # type: ignore[no-untyped-def]
    """The left foot's share that brings the pressure toward (x, y), one step after `load`."""
    share = bounded(between(left, right, x, y), _LEAST_SHARE, 1.0 - _LEAST_SHARE)
    most = p[law.P_DT] / _SHIFT
    return load + bounded(share - load, -most, most)


def capture_point(state, p, height):  # type: ignore[no-untyped-def]
    """The place over which the center of mass would come to rest, the pressure being there [m]."""
    tree, at = int(p[law.P_PELVIS]), int(p[law.P_SENSORS]) + 6
    time = math.sqrt(max(height, 0.3) / p[law.P_GRAVITY])
    x = state.subtree_com[tree, 0] + time * state.sensordata[at]
    return x, state.subtree_com[tree, 1] + time * state.sensordata[at + 1]


def bear(state, ctrl, p, share, left, right, pressure, upward, pitch, twist, body, yaw):  # type: ignore[no-untyped-def]
    """Torques of the feet that bear; a foot without load is left alone.

    Args:
        state: The engine's.
        ctrl: Changed in place.
        p: Parameters.
        share: The left foot's of the load.
        left: Its `sole`.
        right: The other's.
        pressure: Where the center of pressure should be [m]; it is as near as the soles reach.
        upward: Height [m] and upward acceleration besides [m/s^2] that are wanted.
        pitch: Forward lean of the pelvis that is wanted [rad].
        twist: How far the pelvis is to turn to the left [rad].
        body: Attitude and its rates (`running_law.attitude`).
        yaw: Facing direction [rad].

    Returns:
        Where the pressure is [m].
    """
    tree = int(p[law.P_PELVIS])
    x, y, z = state.subtree_com[tree, 0], state.subtree_com[tree, 1], state.subtree_com[tree, 2]
    mx, my = right[0] + share * (left[0] - right[0]), right[1] + share * (left[1] - right[1])
    lx, ly = inside(p, left, pressure[0] - mx, pressure[1] - my)
    rx, ry = inside(p, right, pressure[0] - mx, pressure[1] - my)
    px, py = mx + share * lx + (1.0 - share) * rx, my + share * ly + (1.0 - share) * ry
    tall = max(z - share * left[2] - (1.0 - share) * right[2], 0.3)
    up = p[LIFT] * (upward[0] - tall) + upward[1]
    up -= p[SINK] * state.sensordata[int(p[law.P_SENSORS]) + 8]
    fz = p[law.P_WEIGHT] * bounded(1.0 + up / p[law.P_GRAVITY], *_UP)
    tx, ty, tz = _moment(p, pitch, twist, body, yaw, fz)
    # Where the soles end, the body bends toward where the pressure should be.
    tx += bounded((py - pressure[1]) * fz, -_GIVE, _GIVE)
    ty += bounded((pressure[0] - px) * fz, -_GIVE, _GIVE)
    fx = bounded((-ty - (px - x) * fz) / tall, -_ALONG * fz, _ALONG * fz)
    fy = bounded((tx - (py - y) * fz) / tall, -_ALONG * fz, _ALONG * fz)
    if share > 0.0:
        push = (share * fx, share * fy, share * fz, share * tz)
        _leg(state, ctrl, p, law.LEFT, left[0] + lx, left[1] + ly, left[2], push)
    if share < 1.0:
        rest = 1.0 - share
        push = (rest * fx, rest * fy, rest * fz, rest * tz)
        _leg(state, ctrl, p, law.RIGHT, right[0] + rx, right[1] + ry, right[2], push)
    return px, py


def _moment(p, pitch, twist, body, yaw, load):  # type: ignore[no-untyped-def]
    """What turns the pelvis upright, to its lean and to where it should face, world [N m]."""
    roll, now, roll_rate, pitch_rate, yaw_rate = body
    tx = bounded(-p[TURN] * roll - p[SPIN] * roll_rate, -_MOMENT, _MOMENT)
    ty = bounded(p[TURN] * (pitch - now) - p[SPIN] * pitch_rate, -_MOMENT, _MOMENT)
    tz = _TWIST * wrapped(twist) - _TWIST_DAMPING * yaw_rate
    a, b = math.cos(yaw), math.sin(yaw)
    return a * tx - b * ty, b * tx + a * ty, bounded(tz, -_GRIP * load, _GRIP * load)


def _leg(state, ctrl, p, side, px, py, pz, push):  # type: ignore[no-untyped-def]
    """Torques of a leg under a push of the floor at (px, py, pz) [m]: force [N], twist [N m]."""
    leg = law.LEFT_LEG if side == law.LEFT else law.RIGHT_LEG
    fx, fy, fz, twist = push
    own = 1.0 / p[law.P_SCALE]
    for k in range(3):
        body = int(p[THIGH + side]) + k
        ox, oy, oz = px - state.xpos[body, 0], py - state.xpos[body, 1], pz - state.xpos[body, 2]
        weight = p[law.P_GRAVITY] * p[LEG_MASS + k]
        gx = state.subtree_com[body, 0] - state.xpos[body, 0]
        gy = state.subtree_com[body, 1] - state.xpos[body, 1]
        tx = oy * fz - oz * fy - gy * weight
        ty = oz * fx - ox * fz + gx * weight
        tz = ox * fy - oy * fx + twist
        if k == 0:
            back = inverse(orientation(state.xquat, int(p[law.P_PELVIS])))
            bx, by, bz = rotated(back, (tx, ty, tz))
            x, y = _angle(state, p, leg + law.HIP_X), _angle(state, p, leg + law.HIP_Y)
            hx, hy, hz = hip_torques(bx, by, bz, x, y)
            _put(ctrl, p, leg + law.HIP_X, own * hx)
            _put(ctrl, p, leg + law.HIP_Y, own * hy)
            _put(ctrl, p, leg + law.HIP_ZH, own * hz)
        else:
            ax, ay, az = turned(*orientation(state.xquat, body), 0.0, 1.0, 0.0)
            about = ax * tx + ay * ty + az * tz
            _put(ctrl, p, leg + law.HIP_ZH + k, -own * about if k == 1 else own * about)
    toes(state, ctrl, p, leg)


def toes(state, ctrl, p, leg):  # type: ignore[no-untyped-def]
    """The passive joint at the ball of a foot."""
    angle, rate = _angle(state, p, leg + law.BALL), _rate(state, p, leg + law.BALL)
    _put(ctrl, p, leg + law.BALL, -_TOE_STIFFNESS * angle - _TOE_DAMPING * rate)
