"""The runner's control laws (Hodgins et al. 1995, section Running), one step at a time.

Six states of the active leg, the one on the ground or on its way there: flight, loading, heel
contact, heel and toe contact, toe contact, unloading. At liftoff the legs change roles. The law is
plain scalar Python that also runs compiled; what it reads and keeps is laid out below by name.
"""

from __future__ import annotations

import math

from understudy.athletics.course import LEAD, MORE_DAMPING, MORE_LEAN, MORE_THRUST, followed_course
from understudy.athletics.gains import MIDDLE, NAMES
from understudy.athletics.standing_gains import SLOW, STANDING_NUMBERS
from understudy.control.legs import (
    foothold,
    hip_torques,
    leg_toward,
    mirrored_hip,
)
from understudy.control.machine import MACHINE, enter, state_of, timed
from understudy.control.quaternion import orientation, turned
from understudy.control.trajectory import bounded, ease, eased, followed, going, servo, share_of

FLIGHT, LOADING, HEEL, HEEL_TOE, TOE, UNLOADING = range(6)
STATES = ("flight", "loading", "heel", "heel and toe", "toe", "unloading")
LEFT, RIGHT = 0, 1

# Gains, in the order of `Gains`.
# fmt: off
(
    TOUCHDOWN_KNEE, TOUCHDOWN_FOOT, SPEED_PLACE, SIDE_PLACE, PLACE_APART, PLACE_AHEAD,
    PLACE_TURN, SPEED_MATCHING, KNEE_STIFFNESS, KNEE_DAMPING, KNEE_REST, KNEE_REST_THRUST,
    THRUST_AT, HEEL_ANKLE, HEEL_STIFFNESS, FLAT_ANKLE, FLAT_STIFFNESS, THRUST_ANKLE,
    THRUST_STIFFNESS, THRUST_TIME, ANKLE_DAMPING, TOE_STIFFNESS, PITCH, ROLL_STIFFNESS,
    ROLL_DAMPING, ROLL_SUPPORT, PITCH_STIFFNESS, PITCH_DAMPING, YAW_STIFFNESS, YAW_DAMPING,
    IDLE_REACTION, HIP_STIFFNESS, HIP_DAMPING, HIP_TURN, SWING_STIFFNESS, SWING_DAMPING,
    SWING_SHARE, IDLE_KNEE, IDLE_TIME, READY_KNEE, MIRROR, MIRROR_AHEAD, IDLE_APART,
    ARM_SWING, ARM_OFFSET, WAIST_STIFFNESS, WAIST_TURN, WAIST_LEAN,
    FLIGHT_GOAL, FLIGHT_THRUST
) = range(len(NAMES))
# fmt: on
GAINS = len(NAMES)

# Parameters: the body and where it is in the engine's arrays, then gains, slopes, those
# of slow steps, what `standing_law` reads, and the course.
# fmt: off
(
    P_QPOS, P_QVEL, P_CTRL, P_SENSORS, P_PELVIS, P_DT, P_GRAVITY, P_WEIGHT, P_SCALE,
    P_THIGH, P_SHANK, P_HIP, P_HEEL_X, P_HEEL_Z, P_FOOT
) = range(15)
# fmt: on
P_GAINS = 15
P_STANDING = P_GAINS + 3 * GAINS
P_COURSE = P_STANDING + STANDING_NUMBERS

# Memory: the machine's, then what follows, the gains at the present speed and the course's.
# fmt: off
(
    ACTIVE, TOUCHDOWN, LIFTOFF, THRUST, STANCE, FLIGHT_TIME,
    HIP_X_LEFT, HIP_X_RIGHT, HIP_Y_LEFT, HIP_Y_RIGHT, HIP_Z, KNEE_LEFT, KNEE_RIGHT,
    ANKLE, ANKLE_FROM, ANKLE_FROM_STIFFNESS, ANKLE_SINCE,
    WAS_ACTIVE_X, WAS_ACTIVE_Y, WAS_ACTIVE_KNEE, WAS_IDLE_X, WAS_IDLE_Y, WAS_IDLE_KNEE,
    IDLE_X, IDLE_Y, IDLE_Z, IDLE_ANKLE,
    HIP_RATE_LEFT, HIP_RATE_RIGHT, KNEE_RATE_LEFT, KNEE_RATE_RIGHT,
    MEAN_FLIGHT, LANDING_HEIGHT, LOADED
) = range(MACHINE, MACHINE + 34)
# fmt: on
M_GAINS = MACHINE + 34
M_COURSE = M_GAINS + GAINS

# Hinges in the athlete's order.
WAIST, NECK, LEFT_ARM, RIGHT_ARM, LEFT_LEG, RIGHT_LEG = 0, 3, 6, 12, 18, 24
HIP_X, HIP_Y, HIP_ZH, KNEE, ANKLE_H, BALL = range(6)

# Fastest change of a desired angle that a servo is told [rad/s].
_FASTEST = 15.0
# Servos that are not searched: hip z, ankle in the air, shoulder, elbow, neck, wrist.
_HIP_Z, _AIR_ANKLE, _SHOULDER, _ELBOW = (150.0, 8.0), (80.0, 3.0), (70.0, 3.0), (50.0, 2.0)
_NECK, _WRIST = 60.0, 3.0
_ARM_OUT, _ELBOW_BENT, _ELBOW_HANGING, _ELBOW_SWING = 0.15, 1.75, 0.25, 0.2
# A foot has left the ground when nothing presses on it for so long [s]: at a thrust it may hop.
_GONE = 0.006
# How much further back a foot is put per speed that the outer loop adds against a bias [s].
_BIAS_PLACE = 0.03
# Farthest that a foot is placed to a side of neutral [m]: beyond it the leg gets too short.
_WIDEST = 0.2
# How much of the trunk's lean the neck takes back.
_LEVEL = 0.8


def runner(time, state, ctrl, applied, p, m):  # type: ignore[no-untyped-def]
    """One step of the runner: senses, states, then every joint's torque."""
    yaw, body = attitude(state, p)
    roll, pitch = body[0], body[1]
    c, s = math.cos(yaw), math.sin(yaw)
    at = int(p[P_SENSORS]) + 6
    east, north = state.sensordata[at], state.sensordata[at + 1]
    speed, side_speed, error, turning, forward = followed_course(
        time, p[P_DT], p, P_COURSE, m, M_COURSE, state, int(p[P_PELVIS]), yaw, east, north
    )
    scheduled(p, m, forward)
    velocity = (c * east + s * north, c * north - s * east)
    wanted = (speed, side_speed, error, turning, forward)
    _transitions(time, state, p, m)
    leg = LEFT_LEG if m[ACTIVE] == LEFT else RIGHT_LEG
    idle = RIGHT_LEG if m[ACTIVE] == LEFT else LEFT_LEG
    active_x, active_y = _active(time, state, ctrl, p, m, leg, body, velocity, wanted)
    _idle(time, state, ctrl, p, m, idle, active_x, active_y, roll)
    if state_of(m) != FLIGHT:
        _attitude(state, ctrl, p, m, leg, body, wanted)
    upper_body(state, ctrl, p, m, pitch, 1.0)


def attitude(state, p):  # type: ignore[no-untyped-def]
    """Facing direction; roll, pitch and the rates about x, y, z of the heading frame."""
    pelvis, v = orientation(state.xquat, int(p[P_PELVIS])), int(p[P_QVEL])
    ox, oy, oz = turned(*pelvis, 1.0, 0.0, 0.0)
    _, _, lz = turned(*pelvis, 0.0, 1.0, 0.0)
    yaw = math.atan2(oy, ox)
    pitch = math.atan2(-oz, math.sqrt(ox * ox + oy * oy))
    roll = math.asin(bounded(lz / max(math.cos(pitch), 0.1), -1.0, 1.0))
    wx, wy, wz = turned(*pelvis, state.qvel[v + 3], state.qvel[v + 4], state.qvel[v + 5])
    c, s = math.cos(yaw), math.sin(yaw)
    return yaw, (roll, pitch, c * wx + s * wy, c * wy - s * wx, wz)


def scheduled(p, m, speed):  # type: ignore[no-untyped-def]
    """The gains at a speed, with what a start or a stop changes of them."""
    more, less = max(speed, SLOW) - MIDDLE, max(SLOW - speed, 0.0)
    for k in range(GAINS):
        value = p[P_GAINS + k] + more * p[P_GAINS + GAINS + k]
        m[M_GAINS + k] = value + less * p[P_GAINS + 2 * GAINS + k]
    m[M_GAINS + KNEE_DAMPING] += m[M_COURSE + MORE_DAMPING]
    m[M_GAINS + THRUST_STIFFNESS] *= 1.0 + m[M_COURSE + MORE_THRUST]
    m[M_GAINS + PITCH] += m[M_COURSE + MORE_LEAN]


# -- the state machine (figure 3) --------------------------------------------------------------


def _transitions(time, state, p, m):  # type: ignore[no-untyped-def]
    heel, ball, toes = _forces(state, p, m)
    force = heel + ball + toes
    leg = LEFT_LEG if m[ACTIVE] == LEFT else RIGHT_LEG
    now = state_of(m)
    if force >= 20.0:
        m[LOADED] = time
    if now == FLIGHT:
        if force > 5.0 and timed(m, time, 0.03):
            enter(m, LOADING, time)
            flight = bounded(time - m[LIFTOFF], 0.03, 0.25)
            m[MEAN_FLIGHT] += 0.25 * (flight - m[MEAN_FLIGHT])
            height = state.xpos[int(p[P_PELVIS]), 2]
            m[LANDING_HEIGHT] += 0.5 * (height - m[LANDING_HEIGHT])
            m[TOUCHDOWN] = time
    elif now == LOADING:
        if timed(m, time, 0.01) or _rate(state, p, leg + KNEE) > 1.0:
            enter(m, HEEL, time)
    elif now == HEEL:
        if ball > 10.0 or time - m[TOUCHDOWN] > 0.08:
            enter(m, HEEL_TOE, time)
            _ankle_from(m, time, m[M_GAINS + HEEL_ANKLE], m[M_GAINS + HEEL_STIFFNESS])
    elif now == HEEL_TOE:
        if time - m[TOUCHDOWN] > m[M_GAINS + THRUST_AT] * m[STANCE]:
            enter(m, TOE, time)
            m[THRUST] = time
            angle, stiffness = _flat_ankle(time, m)
            _ankle_from(m, time, angle, stiffness)
            idle = LEFT if m[ACTIVE] == RIGHT else RIGHT
            m[KNEE_LEFT + idle] = m[WAS_IDLE_KNEE]
    elif now == TOE:
        if time - m[LOADED] > _GONE or timed(m, time, 0.4):
            enter(m, UNLOADING, time)
    elif force < 1.0 or timed(m, time, 0.02):
        _lift_off(time, state, p, m)


def _lift_off(time, state, p, m):  # type: ignore[no-untyped-def]
    """The legs change roles, and every trajectory begins at the present angles and rates."""
    enter(m, FLIGHT, time)
    m[STANCE] = 0.5 * m[STANCE] + 0.5 * bounded(time - m[TOUCHDOWN], 0.1, 0.35)
    m[LIFTOFF] = time
    m[FLIGHT_TIME] = _expected_flight(state, p, m)
    m[ACTIVE] = RIGHT if m[ACTIVE] == LEFT else LEFT
    for side in range(2):
        leg = LEFT_LEG if side == LEFT else RIGHT_LEG
        m[HIP_X_LEFT + side] = _angle(state, p, leg + HIP_X)
        m[HIP_Y_LEFT + side] = _angle(state, p, leg + HIP_Y)
        m[KNEE_LEFT + side] = _angle(state, p, leg + KNEE)
        m[HIP_RATE_LEFT + side] = _rate(state, p, leg + HIP_Y)
        m[KNEE_RATE_LEFT + side] = _rate(state, p, leg + KNEE)
        if side == int(m[ACTIVE]):
            m[HIP_Z], m[ANKLE] = _angle(state, p, leg + HIP_ZH), _angle(state, p, leg + ANKLE_H)
        else:
            m[IDLE_ANKLE] = _angle(state, p, leg + ANKLE_H)
    active = int(m[ACTIVE])
    m[WAS_ACTIVE_X], m[WAS_IDLE_X] = m[HIP_X_LEFT + active], m[HIP_X_LEFT + 1 - active]
    m[WAS_ACTIVE_Y], m[WAS_IDLE_Y] = m[HIP_Y_LEFT + active], m[HIP_Y_LEFT + 1 - active]
    m[WAS_ACTIVE_KNEE], m[WAS_IDLE_KNEE] = m[KNEE_LEFT + active], m[KNEE_LEFT + 1 - active]


def _expected_flight(state, p, m):  # type: ignore[no-untyped-def]
    """How long a body flies that leaves the ground now and lands as high as the last times [s]."""
    rise = state.sensordata[int(p[P_SENSORS]) + 8]
    drop = state.xpos[int(p[P_PELVIS]), 2] - m[LANDING_HEIGHT]
    square = max(rise * rise + 2.0 * p[P_GRAVITY] * drop, 0.0)
    return bounded((rise + math.sqrt(square)) / p[P_GRAVITY], 0.03, 0.25)


def _forces(state, p, m):  # type: ignore[no-untyped-def]
    """Force on heel, ball and toes of the active foot [N]."""
    at = int(p[P_SENSORS]) + 3 * int(m[ACTIVE])
    return state.sensordata[at], state.sensordata[at + 1], state.sensordata[at + 2]


# -- the active leg ----------------------------------------------------------------------------


def _active(time, state, ctrl, p, m, leg, body, velocity, wanted):  # type: ignore[no-untyped-def]
    """Knee, ankle and toes of the active leg, in flight its hip too; what the idle hip mirrors."""
    x, y = _angle(state, p, leg + HIP_X), _angle(state, p, leg + HIP_Y)
    _put(ctrl, p, leg + BALL, -m[M_GAINS + TOE_STIFFNESS] * _angle(state, p, leg + BALL))
    if state_of(m) == FLIGHT:
        return _reach(time, state, ctrl, p, m, leg, body, velocity, wanted)
    _stance_knee(time, state, ctrl, p, m, leg)
    angle, stiffness = _stance_ankle(time, m)
    torque = stiffness * (angle - _angle(state, p, leg + ANKLE_H))
    torque -= m[M_GAINS + ANKLE_DAMPING] * _rate(state, p, leg + ANKLE_H)
    _put(ctrl, p, leg + ANKLE_H, torque)
    return x, y


def touchdown_place(time, p, m, velocity, wanted):  # type: ignore[no-untyped-def]
    """Hip to heel on the ground at touchdown, forward and to the left (equations 1 and 2) [m]."""
    vx, vy = velocity
    speed, side_speed, error, turning, forward = wanted
    x = 0.5 * (m[STANCE] * vx - p[P_FOOT])
    x += m[M_GAINS + SPEED_PLACE] * (vx - forward * math.cos(error))
    x -= _BIAS_PLACE * (speed - forward)
    y = 0.5 * m[STANCE] * vy
    y += m[M_GAINS + SIDE_PLACE] * (vy - speed * math.sin(error) - side_speed)
    # Ground speed matching: the leg reaches too far and comes back just before it touches, with a
    # share of the ground's speed when it does. All of it lies along the way of travel, wherever
    # the pelvis faces.
    whole = (1.0 - m[M_GAINS + SWING_SHARE]) * m[FLIGHT_TIME]
    left = bounded(m[FLIGHT_TIME] - (time - m[LIFTOFF]), -0.05, whole)
    back = left - 0.5 * left * left / whole if left > 0.0 else left
    going_at = math.sqrt(vx * vx + vy * vy)
    along = (m[M_GAINS + PLACE_AHEAD] - m[M_COURSE + LEAD]) / max(going_at, 1.0)
    along += m[M_GAINS + SPEED_MATCHING] * back
    x += along * vx
    y += along * vy
    y -= m[M_GAINS + PLACE_TURN] * forward * turning
    outward = 1.0 if m[ACTIVE] == LEFT else -1.0
    y = bounded(y, -_WIDEST, _WIDEST)
    return x, y + outward * (m[M_GAINS + PLACE_APART] - p[P_HIP])


def _reach(time, state, ctrl, p, m, leg, body, velocity, wanted):  # type: ignore[no-untyped-def]
    """The foot swings to where it will touch: the leg's joints act as one."""
    roll, pitch = body[0], body[1]
    knee = m[M_GAINS + TOUCHDOWN_KNEE]
    thigh, shank = p[P_THIGH], p[P_SHANK]
    foot = m[M_GAINS + TOUCHDOWN_FOOT]
    x, y = touchdown_place(time, p, m, velocity, wanted)
    ax, ay, az = foothold(x, y, knee, thigh, shank, p[P_HEEL_X], p[P_HEEL_Z], foot)
    px, py, pz = _in_pelvis(ax, ay, az, roll, pitch)
    hip_x, hip_y = leg_toward(px, py, pz, knee, thigh, shank)
    ankle = foot + pitch - hip_y + knee
    hip_z = 0.5 * m[M_GAINS + HIP_TURN] * bounded(wanted[2], -0.3, 0.3)
    side = int(m[ACTIVE])
    passed, whole = time - m[LIFTOFF], m[M_GAINS + SWING_SHARE] * m[FLIGHT_TIME]
    goal_x = eased(m[HIP_X_LEFT + side], hip_x, passed, whole)
    goal_y = eased(m[HIP_Y_LEFT + side], hip_y, passed, whole)
    goal_y += going(m[HIP_RATE_LEFT + side], passed, whole)
    goal_knee = eased(m[KNEE_LEFT + side], knee, passed, whole)
    goal_knee += going(m[KNEE_RATE_LEFT + side], passed, whole)
    kh, dh = m[M_GAINS + HIP_STIFFNESS], m[M_GAINS + HIP_DAMPING]
    _drive(state, ctrl, p, m, leg + HIP_X, goal_x, WAS_ACTIVE_X, kh, dh)
    _drive(state, ctrl, p, m, leg + HIP_Y, goal_y, WAS_ACTIVE_Y, kh, dh)
    _hold(state, ctrl, p, leg + HIP_ZH, eased(m[HIP_Z], hip_z, passed, whole), *_HIP_Z)
    k, d = m[M_GAINS + SWING_STIFFNESS], m[M_GAINS + SWING_DAMPING]
    _drive(state, ctrl, p, m, leg + KNEE, goal_knee, WAS_ACTIVE_KNEE, k, d)
    _hold(state, ctrl, p, leg + ANKLE_H, eased(m[ANKLE], ankle, passed, whole), *_AIR_ANKLE)
    return goal_x, goal_y


def _stance_knee(time, state, ctrl, p, m, leg):  # type: ignore[no-untyped-def]
    """The knee is a passive spring."""
    rest = m[M_GAINS + KNEE_REST]
    if state_of(m) >= TOE:
        passed = time - m[THRUST]
        rest = eased(rest, m[M_GAINS + KNEE_REST_THRUST], passed, m[M_GAINS + THRUST_TIME])
    torque = m[M_GAINS + KNEE_STIFFNESS] * (rest - _angle(state, p, leg + KNEE))
    torque -= m[M_GAINS + KNEE_DAMPING] * _rate(state, p, leg + KNEE)
    _put(ctrl, p, leg + KNEE, torque)


def _stance_ankle(time, m):  # type: ignore[no-untyped-def]
    """Rest angle and stiffness of the ankle; from toe contact on it thrusts."""
    now = state_of(m)
    if now <= HEEL:
        return m[M_GAINS + HEEL_ANKLE], m[M_GAINS + HEEL_STIFFNESS]
    if now == HEEL_TOE:
        return _flat_ankle(time, m)
    share = ease(share_of(time - m[ANKLE_SINCE], m[M_GAINS + THRUST_TIME]))
    # A flight too short calls for a stronger thrust, one too long for a weaker.
    short = bounded(m[M_GAINS + FLIGHT_GOAL] - m[MEAN_FLIGHT], -0.05, 0.05)
    stiffness = m[M_GAINS + THRUST_STIFFNESS] + m[M_GAINS + FLIGHT_THRUST] * short
    return _between(m, share, m[M_GAINS + THRUST_ANKLE], stiffness)


def _flat_ankle(time, m):  # type: ignore[no-untyped-def]
    share = ease(share_of(time - m[ANKLE_SINCE], 0.03))
    return _between(m, share, m[M_GAINS + FLAT_ANKLE], m[M_GAINS + FLAT_STIFFNESS])


def _between(m, share, angle, stiffness):  # type: ignore[no-untyped-def]
    a, k = m[ANKLE_FROM], m[ANKLE_FROM_STIFFNESS]
    return a + share * (angle - a), k + share * (stiffness - k)


def _ankle_from(m, time, angle, stiffness):  # type: ignore[no-untyped-def]
    m[ANKLE_SINCE], m[ANKLE_FROM], m[ANKLE_FROM_STIFFNESS] = time, angle, stiffness


# -- the stance hip: attitude ------------------------------------------------------------------


def _attitude(state, ctrl, p, m, leg, body, wanted):  # type: ignore[no-untyped-def]
    """Servos in the stance hip turn the body to the desired roll, pitch and yaw."""
    roll, pitch, roll_rate, pitch_rate, yaw_rate = body
    error, turning, forward = wanted[2], wanted[3], wanted[4]
    lean = -forward * turning / p[P_GRAVITY]  # into the turn
    outward = 1.0 if m[ACTIVE] == LEFT else -1.0
    tx = m[M_GAINS + ROLL_STIFFNESS] * (lean - roll) - m[M_GAINS + ROLL_DAMPING] * roll_rate
    tx += outward * m[M_GAINS + ROLL_SUPPORT]
    ty = m[M_GAINS + PITCH_STIFFNESS] * (m[M_GAINS + PITCH] - pitch)
    ty -= m[M_GAINS + PITCH_DAMPING] * pitch_rate
    tz = m[M_GAINS + YAW_STIFFNESS] * bounded(error, -0.4, 0.4)
    tz -= m[M_GAINS + YAW_DAMPING] * (yaw_rate - turning)
    heel, ball, toes = _forces(state, p, m)
    load = bounded((heel + ball + toes) / (0.6 * p[P_WEIGHT]), 0.0, 1.0)
    if state_of(m) == LOADING or state_of(m) == UNLOADING:
        load *= 0.5
    bx, by, bz = _in_pelvis(tx, ty, tz, roll, pitch)
    share = m[M_GAINS + IDLE_REACTION]
    bx, by, bz = bx + share * m[IDLE_X], by + share * m[IDLE_Y], bz + share * m[IDLE_Z]
    x, y = _angle(state, p, leg + HIP_X), _angle(state, p, leg + HIP_Y)
    hx, hy, hz = hip_torques(load * bx, load * by, load * bz, x, y)
    _put(ctrl, p, leg + HIP_X, hx)
    _put(ctrl, p, leg + HIP_Y, hy)
    _put(ctrl, p, leg + HIP_ZH, hz)


# -- the idle leg (equations 3 and 4) ----------------------------------------------------------


def _idle(time, state, ctrl, p, m, leg, active_x, active_y, roll):  # type: ignore[no-untyped-def]
    """The idle leg, shortened, mirrors the active hip so that their torques cancel."""
    active = int(m[ACTIVE])
    own = 1 - active
    outward = 1.0 if own == LEFT else -1.0
    passed, whole = time - m[LIFTOFF], m[M_GAINS + IDLE_TIME]
    begun = ease(share_of(passed, whole))
    goal_y = mirrored_hip(
        m[HIP_Y_LEFT + own],
        active_y,
        m[HIP_Y_LEFT + active],
        m[M_GAINS + MIRROR],
        begun * m[M_GAINS + MIRROR_AHEAD],
    )
    goal_y = bounded(goal_y + going(m[HIP_RATE_LEFT + own], passed, whole), -0.7, 1.6)
    # The legs must pass each other: half of equation 3, half upright in the world and outward.
    plain = mirrored_hip(
        m[HIP_X_LEFT + own],
        active_x,
        m[HIP_X_LEFT + active],
        0.5,
        begun * outward * m[M_GAINS + IDLE_APART],
    )
    goal_x = 0.5 * plain - 0.5 * begun * roll + 0.5 * (1.0 - begun) * m[HIP_X_LEFT + own]
    if state_of(m) >= TOE:
        late, rest = time - m[THRUST], (1.0 - m[M_GAINS + THRUST_AT]) * m[STANCE]
        goal_knee = eased(m[KNEE_LEFT + own], m[M_GAINS + READY_KNEE], late, rest)
    else:
        goal_knee = eased(m[KNEE_LEFT + own], m[M_GAINS + IDLE_KNEE], passed, whole)
        goal_knee += going(m[KNEE_RATE_LEFT + own], passed, whole)
    kh, dh = m[M_GAINS + HIP_STIFFNESS], m[M_GAINS + HIP_DAMPING]
    tx = _drive(state, ctrl, p, m, leg + HIP_X, goal_x, WAS_IDLE_X, kh, dh)
    ty = _drive(state, ctrl, p, m, leg + HIP_Y, goal_y, WAS_IDLE_Y, kh, dh)
    _hold(state, ctrl, p, leg + HIP_ZH, 0.0, *_HIP_Z)
    k, d = m[M_GAINS + SWING_STIFFNESS], m[M_GAINS + SWING_DAMPING]
    _drive(state, ctrl, p, m, leg + KNEE, goal_knee, WAS_IDLE_KNEE, k, d)
    goal_ankle = eased(m[IDLE_ANKLE], 0.0, passed, whole)
    _hold(state, ctrl, p, leg + ANKLE_H, goal_ankle, *_AIR_ANKLE)
    _put(ctrl, p, leg + BALL, -m[M_GAINS + TOE_STIFFNESS] * _angle(state, p, leg + BALL))
    # What the pelvis feels of it, with the sign reversed: about x, and about the y hinge's axis.
    x = _angle(state, p, leg + HIP_X)
    m[IDLE_X], m[IDLE_Y], m[IDLE_Z] = tx, -math.cos(x) * ty, -math.sin(x) * ty


# -- arms, waist, neck -------------------------------------------------------------------------


def upper_body(state, ctrl, p, m, pitch, share):  # type: ignore[no-untyped-def]
    """Arms swing with the opposite hip (equation 5); the waist turns against the hips.

    At a share of 1 they are a runner's, at 0 the arms hang and the chest is upright.
    """
    left, right = _angle(state, p, LEFT_LEG + HIP_Y), _angle(state, p, RIGHT_LEG + HIP_Y)
    _arm(state, ctrl, p, m, LEFT_ARM, right, 1.0, share)
    _arm(state, ctrl, p, m, RIGHT_ARM, left, -1.0, share)
    k = m[M_GAINS + WAIST_STIFFNESS]
    turn = share * m[M_GAINS + WAIST_TURN] * (left - right)
    _put(ctrl, p, WAIST, -k * _angle(state, p, WAIST))
    lean = share * m[M_GAINS + WAIST_LEAN]
    _put(ctrl, p, WAIST + 1, k * (lean - _angle(state, p, WAIST + 1)))
    _put(ctrl, p, WAIST + 2, 0.5 * k * (turn - _angle(state, p, WAIST + 2)))
    for i in range(0, 3, 2):
        _put(ctrl, p, NECK + i, -_NECK * _angle(state, p, NECK + i))
    # The head looks ahead, however far the trunk leans.
    ahead = -_LEVEL * (pitch + _angle(state, p, WAIST + 1))
    _put(ctrl, p, NECK + 1, _NECK * (ahead - _angle(state, p, NECK + 1)))


def _arm(state, ctrl, p, m, arm, hip, outward, share):  # type: ignore[no-untyped-def]
    swing = m[M_GAINS + ARM_SWING] * (hip - 0.3) + m[M_GAINS + ARM_OFFSET]
    swing = share * bounded(swing, -1.2, 1.2)
    elbow = _ELBOW_HANGING + share * (_ELBOW_BENT - _ELBOW_HANGING) + _ELBOW_SWING * swing
    _hold(state, ctrl, p, arm, swing, *_SHOULDER)
    _hold(state, ctrl, p, arm + 1, outward * _ARM_OUT, *_SHOULDER)
    _hold(state, ctrl, p, arm + 2, 0.0, *_SHOULDER)
    _hold(state, ctrl, p, arm + 3, elbow, *_ELBOW)
    for i in range(2):
        _put(ctrl, p, arm + 4 + i, -_WRIST * _angle(state, p, arm + 4 + i))


# -- reading and writing joints ----------------------------------------------------------------


def _angle(state, p, hinge):  # type: ignore[no-untyped-def]
    return state.qpos[int(p[P_QPOS]) + 7 + hinge]


def _rate(state, p, hinge):  # type: ignore[no-untyped-def]
    return state.qvel[int(p[P_QVEL]) + 6 + hinge]


def _put(ctrl, p, hinge, torque):  # type: ignore[no-untyped-def]
    """A torque for a body of 70 kg and 1.75 m, on this body."""
    ctrl[int(p[P_CTRL]) + hinge] = p[P_SCALE] * torque


def _hold(state, ctrl, p, hinge, goal, k, d):  # type: ignore[no-untyped-def]
    """A servo to a desired angle that is taken as resting."""
    angle, rate = _angle(state, p, hinge), _rate(state, p, hinge)
    _put(ctrl, p, hinge, servo(k, d, goal, angle, 0.0, rate))


def _drive(state, ctrl, p, m, hinge, goal, kept, k, d):  # type: ignore[no-untyped-def]
    """A servo along a trajectory; its last value is in the memory at `kept`. The torque [N m]."""
    desired_rate = followed(m, kept, goal, p[P_DT], _FASTEST)
    torque = servo(k, d, goal, _angle(state, p, hinge), desired_rate, _rate(state, p, hinge))
    _put(ctrl, p, hinge, torque)
    return torque


def _in_pelvis(x, y, z, roll, pitch):  # type: ignore[no-untyped-def]
    """A vector of the heading frame in the pelvis frame (yaw, then pitch, then roll)."""
    c, s = math.cos(pitch), math.sin(pitch)
    x, z = c * x - s * z, s * x + c * z
    c, s = math.cos(roll), math.sin(roll)
    return x, c * y + s * z, c * z - s * y
