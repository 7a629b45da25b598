"""The laws of an athlete that stands, starts to run and stops, one step at a time.

Five modes beside running: standing on both feet; leaning before a run; pushing off with one foot;
shifting the load to one foot; stepping with the other to the capture point, over which the body
comes to rest. Running itself is `running_law`'s: a start enters it at a liftoff, a stop leaves it
at a touchdown.
"""

from __future__ import annotations

import math

from understudy.athletics import course as c
from understudy.athletics import running_law as law
from understudy.athletics import support_law as support
from understudy.athletics.course import COURSE_MEMORY, LEAST, commanded, wrapped
from understudy.athletics.running_law import (
    _angle,
    _drive,
    _hold,
    _in_pelvis,
    _lift_off,
    attitude,
    runner,
    scheduled,
    upper_body,
)
from understudy.athletics.support_law import bear, capture_point, outside, shifted, sole, toes
from understudy.control.legs import leg_angles
from understudy.control.machine import state_of
from understudy.control.trajectory import bounded, ease, share_of, toward

RUNNING, STANDING, LEANING, PUSHING, SHIFTING, STEPPING = range(6)

# Memory behind the course's: the mode, since when, which foot bears, whence the other swings, what
# height is wanted, how far the arms are up, the left foot's load, where to face, how far to lean,
# when the lean began and how long the push has lasted.
# fmt: off
STANDING_MEMORY = 13
(
    MODE, SINCE, BEARS, FROM_X, FROM_Y, FROM_Z, AT_HEIGHT, ARMS, LOAD, FACING, LEAN, LEANT, PUSHES
) = range(law.M_COURSE + COURSE_MEMORY, law.M_COURSE + COURSE_MEMORY + STANDING_MEMORY)
# fmt: on

# How long lean and thrust take to change by one, damping by twenty [s].
_CHANGING = 0.5
# Speed at which a start would gain no more [m/s].
_TOP = 7.0
# How fast height and lean come back [1/s]; how long arms take to come up and to sink [s].
_RISE, _STRAIGHTEN, _ARMS_UP, _ARMS_DOWN = 0.5, 0.4, 0.35, 0.8
# Servos of the free leg that are not searched: hip z, ankle.
_HIP_Z, _ANKLE = (80.0, 6.0), (80.0, 3.0)
# Expected stance and flight of the first step [s]; how long the pressure goes to the ball [s].
_STANCE, _FLIGHT, _TO_BALL, _LONGEST_PUSH = 0.24, 0.09, 0.06, 0.25
# Feet this far apart lengthwise are put together; a foot this near to the other goes beside it [m].
_TOGETHER, _BESIDE, _FARTHEST = 0.07, 0.08, (-0.4, 0.6)
# Part of the least distance of the feet under which one steps aside; how long standing takes to
# count as settled [s].
_NARROW, _SETTLED = 0.75, 0.3


def athlete(time, state, ctrl, applied, p, m):  # type: ignore[no-untyped-def]
    """One step of an athlete whose course may begin or end with standing."""
    rows = int(p[law.P_COURSE + c.C_ROWS])
    goal, _, _ = commanded(time, p, law.P_COURSE + c.C_TABLE, rows)
    yaw, body = attitude(state, p)
    if m[MODE] == RUNNING:
        _run(time, state, ctrl, applied, p, m, goal, yaw)
    if m[MODE] != RUNNING:
        _stand(time, state, ctrl, p, m, goal, yaw, body)
    _arms(state, ctrl, p, m, body[1])


def _run(time, state, ctrl, applied, p, m, goal, yaw):  # type: ignore[no-untyped-def]
    """The runner's law, its speed led; a foot that lands slowly enough in a stop stays."""
    _lead(goal, p, m)
    bias, was = m[law.M_COURSE + c.SPEED_BIAS], state_of(m)
    runner(time, state, ctrl, applied, p, m)
    if m[law.M_COURSE + c.LEAD] != 0.0:
        m[law.M_COURSE + c.SPEED_BIAS] = bias  # nothing to learn from a start or a stop
    if goal < LEAST and was == law.FLIGHT and state_of(m) == law.LOADING:
        at = int(p[law.P_SENSORS]) + 6
        ahead = math.cos(yaw) * state.sensordata[at] + math.sin(yaw) * state.sensordata[at + 1]
        if ahead < p[support.STOP_SPEED]:
            _land(time, state, p, m)


def _lead(goal, p, m):  # type: ignore[no-untyped-def]
    """The desired speed changes faster where a run begins and ends; feet, knees, lean go along."""
    at, dt = law.M_COURSE + c.SPEED, p[law.P_DT]
    if goal < LEAST:
        # `followed_course` takes its own share off.
        usual = p[law.P_COURSE + c.C_ACCELERATION] * dt
        m[at] = max(m[at] - p[support.STOP_RATE] * dt, p[support.STOP_SLOW]) + usual
        damping, thrust = p[support.STOP_DAMPING], p[support.STOP_THRUST]
        _change(p, m, -p[support.STOP_LEAD], damping, thrust, p[support.STOP_LEAN])
    elif m[law.M_COURSE + c.LEAD] != 0.0:
        # As in people, the faster the run, the slower the gain.
        part = 1.0 - m[at] / _TOP
        m[at] = min(m[at] + part * p[support.START_RATE] * dt, goal)
        part = part if m[at] < goal else 0.0
        thrust, lean = part * p[support.START_THRUST], part * p[support.START_LEAN]
        _change(p, m, part * p[support.START_LEAD], 0.0, thrust, lean)
    else:
        _change(p, m, 0.0, 0.0, 0.0, 0.0)


def _change(p, m, lead, damping, thrust, lean):  # type: ignore[no-untyped-def]
    """Change the run toward what a start or a stop asks for."""
    own, most = law.M_COURSE, p[law.P_DT] / _CHANGING
    m[own + c.LEAD] = lead
    m[own + c.MORE_DAMPING] += bounded(damping - m[own + c.MORE_DAMPING], -20.0 * most, 20.0 * most)
    m[own + c.MORE_THRUST] = toward(m[own + c.MORE_THRUST], thrust, most)
    m[own + c.MORE_LEAN] = toward(m[own + c.MORE_LEAN], lean, most)


def _arms(state, ctrl, p, m, pitch):  # type: ignore[no-untyped-def]
    """Arms come up before a run and hang after it."""
    up = 1.0 if m[MODE] == RUNNING or m[MODE] == LEANING or m[MODE] == PUSHING else 0.0
    whole = _ARMS_UP if up == 1.0 else _ARMS_DOWN
    m[ARMS] = toward(m[ARMS], up, p[law.P_DT] / whole)
    if m[MODE] != RUNNING or m[ARMS] < 1.0:  # else the runner's law has moved them
        upper_body(state, ctrl, p, m, pitch, ease(m[ARMS]))


# -- from and to running -----------------------------------------------------------------------


def _land(time, state, p, m):  # type: ignore[no-untyped-def]
    """The foot that lands is the first that stands; the other steps beside or ahead of it."""
    foot = sole(state, p, int(m[law.ACTIVE]))
    m[AT_HEIGHT] = state.subtree_com[int(p[law.P_PELVIS]), 2] - foot[2]
    m[LEAN] = m[law.M_GAINS + law.PITCH]
    m[FACING] = m[law.M_COURSE + c.HEADING]
    m[LOAD] = 1.0 if m[law.ACTIVE] == law.LEFT else 0.0
    _step(time, state, p, m, STEPPING, m[law.ACTIVE])


def _leave(time, state, p, m):  # type: ignore[no-untyped-def]
    """The run begins as at a liftoff of the foot that pushed off."""
    m[law.ACTIVE], m[law.TOUCHDOWN] = m[BEARS], time - _STANCE
    m[law.STANCE], m[law.FLIGHT_TIME] = _STANCE, _FLIGHT
    _lift_off(time, state, p, m)
    own = law.M_COURSE
    m[own + c.SPEED], m[own + c.MEAN_SPEED] = p[support.FIRST_SPEED], p[support.FIRST_SPEED]
    m[own + c.MEAN_SIDE], m[own + c.TURNING] = 0.0, 0.0
    m[own + c.HEADING], m[own + c.LEAD] = m[FACING], 1e-9
    m[own + c.MORE_DAMPING], m[own + c.MORE_THRUST] = 0.0, p[support.START_THRUST]
    m[own + c.MORE_LEAN] = p[support.START_LEAN]
    m[MODE], m[SINCE] = RUNNING, time


def _step(time, state, p, m, mode, bears):  # type: ignore[no-untyped-def]
    """One foot bears, the other leaves the ground."""
    m[MODE], m[SINCE], m[BEARS] = mode, time, bears
    side = 1 - int(bears)
    x, y, z, _, _ = sole(state, p, side)
    leg = law.LEFT_LEG if side == law.LEFT else law.RIGHT_LEG
    m[law.WAS_IDLE_X] = _angle(state, p, leg + law.HIP_X)
    m[law.WAS_IDLE_Y] = _angle(state, p, leg + law.HIP_Y)
    m[law.WAS_IDLE_KNEE] = _angle(state, p, leg + law.KNEE)
    if mode == PUSHING:
        x, y = m[law.WAS_IDLE_Y], m[law.WAS_IDLE_KNEE]
    m[FROM_X], m[FROM_Y], m[FROM_Z] = x, y, z


# -- standing ----------------------------------------------------------------------------------


def _stand(time, state, ctrl, p, m, goal, yaw, body):  # type: ignore[no-untyped-def]
    """Balance over the feet; what the mode wants besides."""
    scheduled(p, m, p[support.FIRST_SPEED])
    left, right = sole(state, p, law.LEFT), sole(state, p, law.RIGHT)
    foot = left if m[BEARS] == law.LEFT else right
    facing = math.cos(m[FACING]), math.sin(m[FACING])
    dt = p[law.P_DT]
    m[AT_HEIGHT] = toward(m[AT_HEIGHT], p[support.STRAIGHT] * p[support.HEIGHT], _RISE * dt)
    m[LEAN] = toward(m[LEAN], 0.0, _STRAIGHTEN * dt)
    if m[MODE] == STANDING and time - m[SINCE] > _SETTLED:
        # Feet that stand do not turn: it faces where they let it.
        m[FACING] += dt / _SETTLED * wrapped(yaw - m[FACING])
    captured = capture_point(state, p, m[AT_HEIGHT])
    height, pitch, x, y = _wanted(time, p, m, left, right, foot, facing)
    pull = p[support.PULL]
    pressure = captured[0] + pull * (captured[0] - x), captured[1] + pull * (captured[1] - y)
    rise = 0.0
    if m[MODE] == PUSHING:
        pressure, rise = _pushed(state, p, m, foot, facing, pressure)
    if m[MODE] == STEPPING or m[MODE] == PUSHING:
        m[LOAD] = 1.0 if m[BEARS] == law.LEFT else 0.0
    else:
        m[LOAD] = shifted(p, left, right, m[LOAD], *pressure)
    twist, upward = m[FACING] - yaw, (height, rise)
    pressure = bear(state, ctrl, p, m[LOAD], left, right, pressure, upward, pitch, twist, body, yaw)
    if m[MODE] == STEPPING:
        _swing(time, state, ctrl, p, m, foot, captured, pressure, facing, yaw, body)
    elif m[MODE] == PUSHING:
        _throw(time, state, ctrl, p, m)
        load = _load(state, p, int(m[BEARS]))
        if m[PUSHES] > _LONGEST_PUSH or (load < 20.0 and m[PUSHES] > 0.03):
            _leave(time, state, p, m)
    elif m[MODE] == LEANING:
        if _ahead(state, p, foot, facing) > p[support.LIFT_AT]:
            m[LEANT], m[PUSHES] = m[SINCE], 0.0
            _step(time, state, p, m, PUSHING, m[BEARS])
    else:
        _next(time, state, p, m, goal, left, right, captured, facing)


def _wanted(time, p, m, left, right, foot, facing):  # type: ignore[no-untyped-def]
    """Height, pitch and where the capture point should be."""
    a, b = facing
    x, y = 0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1])
    height, pitch = m[AT_HEIGHT], m[LEAN]
    if m[MODE] == LEANING or m[MODE] == PUSHING:
        since = m[SINCE] if m[MODE] == LEANING else m[LEANT]
        share = ease(share_of(time - since, p[support.LEAN_TIME]))
        out = 1.0 if m[BEARS] == law.LEFT else -1.0
        ahead, aside = share * p[support.LEAN_AHEAD], share * out * p[support.LEAN_ASIDE]
        x, y = x + ahead * a - aside * b, y + ahead * b + aside * a
        height -= share * p[support.LEAN_DIP]
        pitch += share * p[support.LEAN_PITCH]
    elif m[MODE] != STANDING:
        x, y = foot[0], foot[1]
    return height, pitch, x, y


def _next(time, state, p, m, goal, left, right, captured, facing):  # type: ignore[no-untyped-def]
    """Whether to step, to put the feet together or to start."""
    a, b = facing
    x = captured[0] - 0.5 * (left[0] + right[0])
    y = captured[1] - 0.5 * (left[1] + right[1])
    ahead, aside = a * x + b * y, a * y - b * x
    apart = a * (left[0] - right[0]) + b * (left[1] - right[1])
    wide = a * (left[1] - right[1]) - b * (left[0] - right[0])
    passed = time - m[SINCE]
    out_x, out_y = outside(p, left, right, *captured)
    near = law.LEFT if apart * ahead > 0.0 else law.RIGHT
    if abs(apart) < _TOGETHER:
        near = law.LEFT if aside > 0.0 else law.RIGHT
    if math.sqrt(out_x * out_x + out_y * out_y) > p[support.REACH] and passed > 0.08:
        # The foot farther from the capture point steps; where they are level, the one on its side.
        bears = law.LEFT if aside > 0.0 else law.RIGHT
        if abs(apart) > 0.1:
            bears = near
        elif abs(a * out_x + b * out_y) < abs(a * out_y - b * out_x):
            bears = 1 - bears
        _step(time, state, p, m, STEPPING, bears)
    elif m[MODE] == SHIFTING:
        foot = left if m[BEARS] == law.LEFT else right
        off_x, off_y = captured[0] - foot[0], captured[1] - foot[1]
        if math.sqrt(off_x * off_x + off_y * off_y) < 0.045 or passed > 0.8:
            _step(time, state, p, m, STEPPING, m[BEARS])
    elif abs(apart) > _TOGETHER or wide < _NARROW * p[support.STEP_APART]:
        if abs(ahead) < 0.06 + 0.5 * abs(apart) and abs(aside) < 0.10 and passed > 0.15:
            m[MODE], m[SINCE], m[BEARS] = SHIFTING, time, near
    elif goal >= LEAST and abs(ahead) < 0.06 and passed > 0.1:
        m[MODE], m[SINCE], m[BEARS] = LEANING, time, law.LEFT


def _load(state, p, side):  # type: ignore[no-untyped-def]
    """Force on a foot [N]."""
    at = int(p[law.P_SENSORS]) + 3 * side
    return state.sensordata[at] + state.sensordata[at + 1] + state.sensordata[at + 2]


def _ahead(state, p, foot, facing):  # type: ignore[no-untyped-def]
    """How far the body is ahead of a foot [m]."""
    tree = int(p[law.P_PELVIS])
    x, y = state.subtree_com[tree, 0] - foot[0], state.subtree_com[tree, 1] - foot[1]
    return facing[0] * x + facing[1] * y


# -- the foot that pushes off, and the leg that swings ----------------------------------------


def _pushed(state, p, m, foot, facing, pressure):  # type: ignore[no-untyped-def]
    """Where the pressure should be in a push, and how fast the body should rise.

    The body falls ahead over the heel; then the pressure goes to the ball and the leg lengthens.
    """
    if _ahead(state, p, foot, facing) > p[support.PUSH_AT] or m[PUSHES] > 0.0:
        m[PUSHES] += p[law.P_DT]
    share = ease(share_of(m[PUSHES], _TO_BALL))
    a, b = facing
    ahead = (share - 0.5) * (p[support.FRONT] - p[support.BACK])
    aside = a * (pressure[1] - foot[1]) - b * (pressure[0] - foot[0])
    place = foot[0] + ahead * a - aside * b, foot[1] + ahead * b + aside * a
    return place, share * p[support.PUSH]


def _throw(time, state, ctrl, p, m):  # type: ignore[no-untyped-def]
    """The free leg swings ahead for the first step of a run."""
    share = ease(share_of(time - m[SINCE], p[support.PUSH_TIME]))
    hip = m[FROM_X] + share * (p[support.PUSH_HIP] - m[FROM_X])
    knee = m[FROM_Y] + share * (p[support.PUSH_KNEE] - m[FROM_Y])
    _free(state, ctrl, p, m, 0.0, hip, knee, 0.0)


def _swing(time, state, ctrl, p, m, foot, captured, pressure, facing, yaw, body):  # type: ignore[no-untyped-def]
    """The free foot swings to where the capture point will be when it lands."""
    side = 1 - int(m[BEARS])
    passed, whole = time - m[SINCE], p[support.STEP_TIME]
    rest = max(whole - passed, 0.0)
    grows = math.exp(rest * math.sqrt(p[law.P_GRAVITY] / max(m[AT_HEIGHT], 0.3)))
    x = pressure[0] + grows * (captured[0] - pressure[0]) - foot[0]
    y = pressure[1] + grows * (captured[1] - pressure[1]) - foot[1]
    x, y = _landing(p, side, foot, x, y, facing)
    share = share_of(passed, whole)
    x = m[FROM_X] + ease(share) * (x - m[FROM_X])
    y = m[FROM_Y] + ease(share) * (y - m[FROM_Y])
    z = m[FROM_Z] + ease(share) * (foot[2] - m[FROM_Z])
    # It lands with a little speed, later if the ground is lower.
    z += 4.0 * p[support.STEP_RISE] * share * (1.0 - share) - 0.3 * max(passed - whole, 0.0)
    thigh, middle = int(p[support.THIGH + side]), 0.5 * (p[support.BACK] + p[support.FRONT])
    x -= facing[0] * middle + state.xpos[thigh, 0]
    y -= facing[1] * middle + state.xpos[thigh, 1]
    z -= p[law.P_HEEL_Z] + state.xpos[thigh, 2]
    a, b = math.cos(yaw), math.sin(yaw)
    x, y, z = _in_pelvis(a * x + b * y, a * y - b * x, z, body[0], body[1])
    hip_x, hip_y, knee = leg_angles(x, y, z, p[law.P_THIGH], p[law.P_SHANK])
    _free(state, ctrl, p, m, hip_x, hip_y, knee, body[1] - hip_y + knee)
    if _load(state, p, side) > 20.0 and passed > 0.5 * whole:
        m[MODE], m[SINCE] = STANDING, time


def _landing(p, side, foot, x, y, facing):  # type: ignore[no-untyped-def]
    """Where the free sole lands [m], the capture point being (x, y) from the other by then."""
    a, b = facing
    out = 1.0 if side == law.LEFT else -1.0
    ahead = bounded(a * x + b * y + p[support.STEP_AHEAD], *_FARTHEST)
    if abs(ahead) < _BESIDE:
        ahead = 0.0
    aside = out * bounded(out * (a * y - b * x) + 0.03, p[support.STEP_APART], 0.5)
    return foot[0] + a * ahead - b * aside, foot[1] + b * ahead + a * aside


def _free(state, ctrl, p, m, hip_x, hip_y, knee, ankle):  # type: ignore[no-untyped-def]
    """Servos of the leg that does not bear [rad]."""
    leg = law.RIGHT_LEG if m[BEARS] == law.LEFT else law.LEFT_LEG
    k, d = m[law.M_GAINS + law.HIP_STIFFNESS], m[law.M_GAINS + law.HIP_DAMPING]
    _drive(state, ctrl, p, m, leg + law.HIP_X, hip_x, law.WAS_IDLE_X, k, d)
    _drive(state, ctrl, p, m, leg + law.HIP_Y, hip_y, law.WAS_IDLE_Y, k, d)
    _hold(state, ctrl, p, leg + law.HIP_ZH, 0.0, *_HIP_Z)
    k, d = m[law.M_GAINS + law.SWING_STIFFNESS], m[law.M_GAINS + law.SWING_DAMPING]
    _drive(state, ctrl, p, m, leg + law.KNEE, knee, law.WAS_IDLE_KNEE, k, d)
    _hold(state, ctrl, p, leg + law.ANKLE_H, ankle, *_ANKLE)
    toes(state, ctrl, p, leg)
