"""A law that only watches a runner and sums what training is about.

It keeps its own account of steps from the touch sensors and does not trust the runner's states. The
sums are turned into a cost by `training`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from understudy.athletics import running_law as law
from understudy.athletics.course import C_ROWS, C_TABLE, LEAST, commanded, wrapped
from understudy.athletics.running import Running
from understudy.control.quaternion import orientation, turned
from understudy.control.trajectory import bounded
from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array
from understudy.scene import Scene

# What the memory holds: a flag first (`simulate.trials`), then sums over time and over steps.
SUMS = (
    *("fell", "time", "counted"),
    *("speed", "heading", "side", "rocking", "effort", "strain", "lean", "near", "nearest"),
    *("steps", "stance", "period", "flight", "landing_knee", "stance_knee", "swing_knee"),
    *("toe_off_knee", "plantarflexion", "thigh_back", "peak", "impact", "travel"),
    *("thigh_unlike", "knee_unlike", "ankle_unlike", "compared", "landing", "mean_landing"),
    *("mean_speed", "mean_stance", "mean_period", "mean_landing_knee", "mean_stance_knee"),
    *("mean_swing_knee", "mean_plantarflexion", "mean_peak", "mean_impact", "mean_travel"),
    *("mean_lean", "mean_thigh_back", "mean_toe_off_knee"),
)
_AT = {name: k for k, name in enumerate(SUMS)}
# fmt: off
(
    FELL, TIME, COUNTED, SPEED, HEADING, SIDE, ROCKING, EFFORT, STRAIN, LEAN, NEAR, NEAREST,
    STEPS, STANCE, PERIOD, FLIGHT, LANDING_KNEE, STANCE_KNEE, SWING_KNEE, TOE_OFF_KNEE,
    PLANTARFLEXION, THIGH_BACK, PEAK, IMPACT, TRAVEL,
    THIGH_UNLIKE, KNEE_UNLIKE, ANKLE_UNLIKE, COMPARED, LANDING, MEAN_LANDING,
    MEAN_SPEED, MEAN_STANCE, MEAN_PERIOD, MEAN_LANDING_KNEE, MEAN_STANCE_KNEE, MEAN_SWING_KNEE,
    MEAN_PLANTARFLEXION, MEAN_PEAK, MEAN_IMPACT, MEAN_TRAVEL, MEAN_LEAN, MEAN_THIGH_BACK,
    MEAN_TOE_OFF_KNEE
) = range(44)
# Running account: smoothed velocity, then per foot (left, right).
SMOOTH_FORWARD, SMOOTH_SIDE, LAST_TOUCHDOWN, HIGHEST, LOWEST, COMMAND = range(44, 50)
(
    DOWN, SINCE, LAST, MOST, FIRST_MOST, LATER_MOST, KNEE_MOST, SWING_MOST,
    LANDED, STRIDE, ANKLE_WAS, ANKLE_FORWARD
) = range(50, 74, 2)
# fmt: on
SIZE = 74
# Curves of people: thigh, knee, ankle at even shares of the cycle, at these speeds [m/s].
CURVES, SHARES, SPEEDS = 3, 20, (2.5, 3.5, 4.5)

# Parameters: chest, thighs, knees, ankles and balls (left, right), when to begin to count [s],
# whether people's curves are there; then the torque limits, lowest and highest of every hinge;
# then the curves; then the runner's parameters.
J_CHEST, J_THIGH, J_KNEE, J_ANKLE, J_BALL, J_BEGIN, J_LIKE, J_LIMITS = 0, 1, 3, 5, 7, 9, 10, 11
HINGES = 30
J_PEOPLE = J_LIMITS + 2 * HINGES
J_RUNNER = J_PEOPLE + len(SPEEDS) * CURVES * SHARES


@dataclass(frozen=True, kw_only=True)
class Judge:
    """Watches one runner.

    Attributes:
        running: The controller it watches.
        begin: When it begins to count [s]; falls count always.
        people: How people run: thigh, knee and ankle [rad] at even shares of the cycle at 2.5,
            3.5 and 4.5 m/s, shape (3, 3, 20), or None for no comparison.
    """

    running: Running
    begin: float = 0.5
    people: Array | None = field(default=None, repr=False)

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Leave the model as it is."""

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The watching law, where the body is, and empty sums."""
        body = self.running.athlete(scene)
        part = scene.parts[self.running.character]
        if body.controlled_dof != HINGES:
            raise InvalidValue(f"A runner has {HINGES} hinges, not {body.controlled_dof}.")
        _, own, _ = self.running.feedback(scene, model)
        out = np.zeros(J_RUNNER)
        places = ((J_THIGH, "hip"), (J_KNEE, "knee"), (J_ANKLE, "ankle"), (J_BALL, "ball"))
        for at, role in places:
            for k, side in enumerate(("left", "right")):
                out[at + k] = part.bodies[body.index(f"{side}_{role}")]
        out[J_CHEST] = part.bodies[body.index("upper_back")]
        out[J_BEGIN] = self.begin
        limits = model.actuator_forcerange[list(part.joint_actuators)]
        out[J_LIMITS:J_PEOPLE] = limits.ravel()
        if self.people is not None:
            out[J_LIKE] = 1.0
            out[J_PEOPLE:J_RUNNER] = frozen_array(
                self.people, (len(SPEEDS), CURVES, SHARES), "people"
            ).ravel()
        memory = np.zeros(SIZE)
        speed = self.running.course.start[2]
        memory[[SMOOTH_FORWARD, COMMAND, NEAREST, LOWEST]] = speed, speed, 1.0, 10.0
        memory[LAST_TOUCHDOWN] = -1e-9
        return watch, np.concatenate((out, own)), memory


def watch(time, state, ctrl, applied, p, m):  # type: ignore[no-untyped-def]
    """Sum what happens in one step."""
    pelvis, at = int(p[J_RUNNER + law.P_PELVIS]), J_RUNNER + law.P_COURSE
    dt = p[J_RUNNER + law.P_DT]
    _, _, up = turned(*orientation(state.xquat, pelvis), 0.0, 0.0, 1.0)
    height = state.xpos[pelvis, 2]
    speed, heading, _ = commanded(time, p, at + C_TABLE, int(p[at + C_ROWS]))
    if speed < LEAST:
        # Nothing to count, and half a second more to begin.
        m[LAST_TOUCHDOWN] = -time - 0.5
    late = time - abs(m[LAST_TOUCHDOWN]) > 0.9
    # Written so that what is not a number counts as fallen.
    if not (0.6 < height < 1.5) or not up > 0.6 or late:
        m[FELL] = 1.0
    if m[FELL] != 0.0:
        return
    m[TIME] = time
    m[COMMAND] += dt / 0.5 * (speed - m[COMMAND])
    _motion(state, p, m, dt, heading)
    if time >= p[J_BEGIN] and speed >= LEAST:
        m[COUNTED] += dt
        _posture(state, ctrl, p, m, pelvis, dt, heading)
    m[HIGHEST] = max(m[HIGHEST], state.subtree_com[pelvis, 2])
    m[LOWEST] = min(m[LOWEST], state.subtree_com[pelvis, 2])
    for side in range(2):
        _foot(time, state, p, m, side)
        _ankle_speed(state, p, m, side, dt, heading)
        if p[J_LIKE] > 0.0 and time >= p[J_BEGIN] and m[STRIDE + side] > 0.0:
            _compare(time, state, p, m, side, dt, heading)


def _motion(state, p, m, dt, heading):  # type: ignore[no-untyped-def]
    """Velocity along and across the commanded heading, smoothed over about a step."""
    sensors = int(p[J_RUNNER + law.P_SENSORS]) + 6
    east, north = state.sensordata[sensors], state.sensordata[sensors + 1]
    c, s = math.cos(heading), math.sin(heading)
    m[SMOOTH_FORWARD] += dt / 0.5 * (c * east + s * north - m[SMOOTH_FORWARD])
    m[SMOOTH_SIDE] += dt / 0.5 * (c * north - s * east - m[SMOOTH_SIDE])


def _posture(state, ctrl, p, m, pelvis, dt, heading):  # type: ignore[no-untyped-def]
    ox, oy, _ = turned(*orientation(state.xquat, pelvis), 1.0, 0.0, 0.0)
    m[SPEED] += dt * (m[SMOOTH_FORWARD] - m[COMMAND]) ** 2
    m[MEAN_SPEED] += dt * m[SMOOTH_FORWARD]
    m[HEADING] += dt * wrapped(math.atan2(oy, ox) - heading) ** 2
    m[SIDE] += dt * m[SMOOTH_SIDE] ** 2
    v = int(p[J_RUNNER + law.P_QVEL])
    for k in range(3):
        m[ROCKING] += dt * state.qvel[v + 3 + k] ** 2
    c = int(p[J_RUNNER + law.P_CTRL])
    for k in range(HINGES):
        low, high = p[J_LIMITS + 2 * k], p[J_LIMITS + 2 * k + 1]
        torque = ctrl[c + k]
        m[EFFORT] += dt * bounded(torque, low, high) ** 2
        m[STRAIN] += dt * min(max(torque / high - 1.0, torque / low - 1.0, 0.0), 1.0)
    chest = int(p[J_CHEST])
    cx, cy, cz = turned(*orientation(state.xquat, chest), 0.0, 0.0, 1.0)
    lean = math.atan2(cx * math.cos(heading) + cy * math.sin(heading), cz)
    m[MEAN_LEAN] += dt * lean
    m[LEAN] += dt * (max(0.0, lean - 0.17) + max(0.0, 0.02 - lean))
    apart = _apart(state, p)
    m[NEAR] += dt * max(0.0, 0.105 - apart)
    m[NEAREST] = min(m[NEAREST], apart)


def _apart(state, p):  # type: ignore[no-untyped-def]
    """Least distance between points of the two lower legs [m]: knee, shank, ankle, ball."""
    least = 1.0
    for i in range(5):
        lx, ly, lz = _point(state, p, 0, i)
        for j in range(5):
            rx, ry, rz = _point(state, p, 1, j)
            square = (lx - rx) ** 2 + (ly - ry) ** 2 + (lz - rz) ** 2
            least = min(least, square)
    return math.sqrt(least)


def _point(state, p, side, number):  # type: ignore[no-untyped-def]
    if number == 4:
        ball = int(p[J_BALL + side])
        return state.xpos[ball, 0], state.xpos[ball, 1], state.xpos[ball, 2]
    knee, ankle, share = int(p[J_KNEE + side]), int(p[J_ANKLE + side]), number / 3.0
    x = state.xpos[knee, 0] + share * (state.xpos[ankle, 0] - state.xpos[knee, 0])
    y = state.xpos[knee, 1] + share * (state.xpos[ankle, 1] - state.xpos[knee, 1])
    z = state.xpos[knee, 2] + share * (state.xpos[ankle, 2] - state.xpos[knee, 2])
    return x, y, z


def _foot(time, state, p, m, side):  # type: ignore[no-untyped-def]
    """Touchdown and toe-off of one foot, and what was between them."""
    sensors = int(p[J_RUNNER + law.P_SENSORS]) + 3 * side
    force = (
        state.sensordata[sensors] + state.sensordata[sensors + 1] + state.sensordata[sensors + 2]
    ) / p[J_RUNNER + law.P_WEIGHT]
    leg = law.LEFT_LEG if side == 0 else law.RIGHT_LEG
    q = int(p[J_RUNNER + law.P_QPOS]) + 7 + leg
    knee = state.qpos[q + law.KNEE]
    if force > 0.03:
        m[LAST + side] = time
    if m[DOWN + side] == 0.0:
        m[SWING_MOST + side] = max(m[SWING_MOST + side], knee)
        if force > 0.03 and time - m[SINCE + side] > 0.1:
            _touchdown(time, p, m, side, knee)
    else:
        m[KNEE_MOST + side] = max(m[KNEE_MOST + side], knee)
        m[MOST + side] = max(m[MOST + side], force)
        if time - m[SINCE + side] < 0.035:
            m[FIRST_MOST + side] = max(m[FIRST_MOST + side], force)
        else:
            m[LATER_MOST + side] = max(m[LATER_MOST + side], force)
        if time - m[LAST + side] > 0.012:
            _toe_off(time, state, p, m, side, q)


def _touchdown(time, p, m, side, knee):  # type: ignore[no-untyped-def]
    m[STRIDE + side] = time - m[LANDED + side] if m[LANDED + side] > 0.0 else 0.0
    m[LANDED + side] = time
    counts = time >= p[J_BEGIN] and m[LAST_TOUCHDOWN] > 0.0
    if counts:
        period = time - m[LAST_TOUCHDOWN]
        wanted = 2.78 + 0.12 * (m[COMMAND] - 3.5)
        m[PERIOD] += max(0.0, abs(1.0 / max(period, 0.05) - wanted) - 0.06)
        m[MEAN_PERIOD] += period
        m[LANDING_KNEE] += max(0.0, abs(knee - 0.36) - 0.10)
        m[MEAN_LANDING_KNEE] += knee
        m[SWING_KNEE] += max(0.0, abs(m[SWING_MOST + side] - 1.80) - 0.20)
        m[MEAN_SWING_KNEE] += m[SWING_MOST + side]
        m[TRAVEL] += max(0.0, m[HIGHEST] - m[LOWEST] - 0.085)
        m[MEAN_TRAVEL] += m[HIGHEST] - m[LOWEST]
        m[LANDING] += max(0.0, m[ANKLE_FORWARD + side] - 1.0)
        m[MEAN_LANDING] += m[ANKLE_FORWARD + side]
        m[STEPS] += 1.0
    m[HIGHEST], m[LOWEST] = 0.0, 10.0
    m[LAST_TOUCHDOWN] = time
    m[DOWN + side], m[SINCE + side] = 1.0, time
    m[KNEE_MOST + side], m[MOST + side] = knee, 0.0
    m[FIRST_MOST + side], m[LATER_MOST + side] = 0.0, 0.0


def _toe_off(time, state, p, m, side, q):  # type: ignore[no-untyped-def]
    if time >= p[J_BEGIN] + 0.3 and m[LAST_TOUCHDOWN] > 0.0:
        stance = m[LAST + side] - m[SINCE + side]
        wanted = 0.25 - 0.032 * (m[COMMAND] - 2.5)
        m[STANCE] += max(0.0, abs(stance - wanted) - 0.01)
        m[MEAN_STANCE] += stance
        m[STANCE_KNEE] += max(0.0, m[KNEE_MOST + side] - 0.80)
        m[MEAN_STANCE_KNEE] += m[KNEE_MOST + side]
        m[TOE_OFF_KNEE] += max(0.0, state.qpos[q + law.KNEE] - 0.35)
        m[MEAN_TOE_OFF_KNEE] += state.qpos[q + law.KNEE]
        m[PLANTARFLEXION] += max(0.0, 0.28 + state.qpos[q + law.ANKLE_H])
        m[MEAN_PLANTARFLEXION] -= state.qpos[q + law.ANKLE_H]
        m[THIGH_BACK] += max(0.0, 0.25 + state.qpos[q + law.HIP_Y])
        m[MEAN_THIGH_BACK] += state.qpos[q + law.HIP_Y]
        m[PEAK] += max(0.0, m[MOST + side] - 2.9)
        m[MEAN_PEAK] += m[MOST + side]
        m[IMPACT] += max(0.0, m[FIRST_MOST + side] / max(m[LATER_MOST + side], 0.5) - 0.85)
        m[MEAN_IMPACT] += m[FIRST_MOST + side]
        m[FLIGHT] += 1.0
    m[DOWN + side], m[SINCE + side], m[SWING_MOST + side] = 0.0, time, 0.0


def _ankle_speed(state, p, m, side, dt, heading):  # type: ignore[no-untyped-def]
    """Forward speed of an ankle over the ground, over the last 10 ms."""
    ankle = int(p[J_ANKLE + side])
    along = math.cos(heading) * state.xpos[ankle, 0] + math.sin(heading) * state.xpos[ankle, 1]
    if m[TIME] > 2.0 * dt:
        m[ANKLE_FORWARD + side] += (
            dt / 0.01 * ((along - m[ANKLE_WAS + side]) / dt - m[ANKLE_FORWARD + side])
        )
    m[ANKLE_WAS + side] = along


def _compare(time, state, p, m, side, dt, heading):  # type: ignore[no-untyped-def]
    """Squared differences of thigh, knee and ankle from people's at this share of the cycle."""
    share = (time - m[LANDED + side]) / m[STRIDE + side]
    thigh, knee = int(p[J_THIGH + side]), int(p[J_KNEE + side])
    c, s = math.cos(heading), math.sin(heading)
    forward = c * (state.xpos[knee, 0] - state.xpos[thigh, 0])
    forward += s * (state.xpos[knee, 1] - state.xpos[thigh, 1])
    down = state.xpos[thigh, 2] - state.xpos[knee, 2]
    leg = law.LEFT_LEG if side == 0 else law.RIGHT_LEG
    q = int(p[J_RUNNER + law.P_QPOS]) + 7 + leg
    off = math.atan2(forward, down) - _people(p, 0, share, m[COMMAND])
    m[THIGH_UNLIKE] += dt * off * off
    off = state.qpos[q + law.KNEE] - _people(p, 1, share, m[COMMAND])
    m[KNEE_UNLIKE] += dt * off * off
    off = state.qpos[q + law.ANKLE_H] - _people(p, 2, share, m[COMMAND])
    m[ANKLE_UNLIKE] += dt * off * off
    m[COMPARED] += dt


def _people(p, curve, share, speed):  # type: ignore[no-untyped-def]
    """People's angle at a share of the cycle and a speed, linear in both."""
    at = bounded(share, 0.0, 0.9999) * SHARES
    k, part = int(at), at - int(at)
    fast = bounded(speed - SPEEDS[0], 0.0, 1.9999)
    row, more = int(fast), fast - int(fast)
    value = 0.0
    for i in range(2):
        first = J_PEOPLE + ((row + i) * CURVES + curve) * SHARES
        angle = (1.0 - part) * p[first + k] + part * p[first + (k + 1) % SHARES]
        value += (more if i else 1.0 - more) * angle
    return value


def report(memory: Array) -> dict[str, float]:
    """Sums as means: what was seen, by name; angles [rad], times [s], forces [body weights]."""
    sums = {name: float(memory[k]) for name, k in _AT.items()}
    counted, steps, stances = (max(sums[k], 1e-9) for k in ("counted", "steps", "flight"))
    per_step = {"period", "landing_knee", "swing_knee", "travel", "landing"}
    likes = {"thigh_unlike", "knee_unlike", "ankle_unlike"}
    per_time = {"speed", "heading", "side", "rocking", "effort", "strain", "lean", "near"}
    out = {}
    for name, value in sums.items():
        plain = name.removeprefix("mean_")
        timed = name in per_time or name in ("mean_speed", "mean_lean")
        by = counted if timed else steps if plain in per_step else stances
        whole = name in ("fell", "time", "counted", "nearest", "steps", "flight", "compared")
        if name in likes:
            out[name] = math.sqrt(value / max(sums["compared"], 1e-9))
        else:
            out[name] = value if whole else value / by
    return out
