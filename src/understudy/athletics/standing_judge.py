"""A law that only watches an athlete start and stop, and what its samples say.

It keeps a sample of the body every 10 ms and sets its flag when the body falls, so that a trial
(`simulate.trials`) ends there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from understudy.athletics import running_law as law
from understudy.athletics.course import LEAST, Course
from understudy.athletics.running import Running
from understudy.athletics.running_law import attitude
from understudy.motion.rotations import Array
from understudy.scene import Scene

# Time between samples [s].
PERIOD = 0.01
# What a sample holds: center of mass [m] and its velocity [m/s], lean, roll and facing of the
# pelvis [rad], places of the ankles [m], all in the world, and the mean over the run so far of how
# far torques are asked beyond what the motors give, over that.
COLUMNS = (
    *("x", "y", "z", "east", "north", "up", "pitch", "roll", "yaw"),
    *("left_x", "left_y", "right_x", "right_y", "strain"),
)
# Memory: the flag, time, samples so far, strain; then the samples. Parameters: the ankles' bodies,
# torque limits, then the runner's.
_FELL, _TIME, _COUNT, _STRAIN, _FIRST = range(5)
_WIDTH = len(COLUMNS)
_ANKLES, _LIMITS, _HINGES = 0, 2, 30
_RUNNER = _LIMITS + 2 * _HINGES
# A speed under which a body rests [m/s], and the part of a desired speed that counts as reached.
RESTS, REACHED = 0.05, 0.95


@dataclass(frozen=True, kw_only=True)
class Recorder:
    """Watches one athlete.

    Attributes:
        running: The controller it watches.
        seconds: For how long.
    """

    running: Running
    seconds: float

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Leave the model as it is."""

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The watching law, where the body is, and room for the samples."""
        body, part = self.running.athlete(scene), scene.parts[self.running.character]
        _, own, _ = self.running.feedback(scene, model)
        ankles = [float(part.bodies[body.index(f"{side}_ankle")]) for side in ("left", "right")]
        limits = model.actuator_forcerange[list(part.joint_actuators)].ravel()
        room = np.zeros(_FIRST + _WIDTH * (int(self.seconds / PERIOD) + 2))
        return watch, np.concatenate((ankles, limits, own)), room


def watch(time, state, ctrl, applied, p, m):  # type: ignore[no-untyped-def]
    """Take a sample when one is due."""
    runner = p[_RUNNER:]
    pelvis, sensors = int(runner[law.P_PELVIS]), int(runner[law.P_SENSORS]) + 6
    yaw, body = attitude(state, runner)
    # Written so that what is not a number counts as fallen.
    if not (0.55 < state.xpos[pelvis, 2] < 1.6) or not (abs(body[0]) < 1.0 and abs(body[1]) < 1.1):
        m[_FELL] = 1.0
    if m[_FELL] != 0.0:
        return
    m[_TIME] = time
    first = int(runner[law.P_CTRL])
    for k in range(_HINGES):
        low, high = p[_LIMITS + 2 * k], p[_LIMITS + 2 * k + 1]
        torque = ctrl[first + k]
        m[_STRAIN] += min(max(torque / high - 1.0, torque / low - 1.0, 0.0), 1.0)
    count = int(m[_COUNT])
    at = _FIRST + _WIDTH * count
    if time < count * PERIOD - 1e-9 or at + _WIDTH > m.size:
        return
    m[_COUNT] += 1.0
    for i in range(3):
        m[at + i] = state.subtree_com[pelvis, i]
        m[at + 3 + i] = state.sensordata[sensors + i]
    m[at + 6], m[at + 7], m[at + 8] = body[1], body[0], yaw
    for side in range(2):
        ankle = int(p[_ANKLES + side])
        m[at + 9 + 2 * side] = state.xpos[ankle, 0]
        m[at + 10 + 2 * side] = state.xpos[ankle, 1]
    m[at + 13] = m[_STRAIN] * runner[law.P_DT] / max(time, PERIOD)


@dataclass(frozen=True, kw_only=True)
class Samples:
    """What was seen.

    Attributes:
        fell: Whether the body fell.
        seconds: Until when it was seen.
        rows: A sample every 10 ms, shape (samples, len(COLUMNS)).
    """

    fell: bool
    seconds: float
    rows: Array = field(repr=False)

    @classmethod
    def of(cls, memory: Array) -> Samples:
        """From the law's memory."""
        count = int(memory[_COUNT])
        rows = memory[_FIRST : _FIRST + _WIDTH * count].reshape(count, _WIDTH)
        return cls(fell=bool(memory[_FELL] != 0.0), seconds=float(memory[_TIME]), rows=rows)

    def __getitem__(self, name: str) -> Array:
        """One column by name, shape (samples,)."""
        return self.rows[:, COLUMNS.index(name)]

    @property
    def times(self) -> Array:
        """When the samples were taken [s]."""
        return PERIOD * np.arange(len(self.rows), dtype=np.float64)

    @property
    def speed(self) -> Array:
        """Of the center of mass over the ground [m/s]."""
        return np.hypot(self["east"], self["north"])


def smoothed(values: Array, seconds: float = 0.37) -> Array:
    """Means over about one step to either side of each value."""
    count = max(1, round(seconds / PERIOD))
    weights = np.convolve(np.ones(len(values)), np.ones(count), mode="same")
    sums: Array = np.convolve(np.asarray(values, float), np.ones(count), mode="same")
    return sums / weights


def onsets(course: Course) -> tuple[float | None, float | None]:
    """When a course first asks to start from standing, and when it last asks to stop [s]."""
    times = np.arange(0.0, float(course.times[-1]) + PERIOD, PERIOD)
    runs = np.interp(times, course.times, course.speeds) >= LEAST
    changes = np.diff(runs.astype(int))
    starts, stops = times[1:][changes > 0], times[1:][changes < 0]
    return (
        float(starts[0]) if len(starts) else None,
        float(stops[-1]) if len(stops) and not runs[-1] else None,
    )


def start_and_stop(seen: Samples, course: Course) -> dict[str, float | None]:
    """How a start and a stop went; None for what did not happen.

    Returns:
        `start_s` and `start_m`: from the wish to run until the mean speed over a step is 95 % of
        the highest that is asked for, and how far that took. `stop_s` and `stop_m`: from the wish
        to stop until the body rests, slower than 0.05 m/s from then on, and how far.
        `residual_speed_m_s`: the mean speed over the last half second.
    """
    began, stopped = onsets(course)
    out: dict[str, float | None] = dict.fromkeys(
        ("start_s", "start_m", "stop_s", "stop_m", "residual_speed_m_s")
    )
    way = np.concatenate(([0.0], np.cumsum(PERIOD * seen.speed[1:])))
    if began is not None:
        late = (seen.times >= began) & (smoothed(seen.speed) >= REACHED * course.speeds.max())
        if late.any():
            k = int(np.argmax(late))
            out["start_s"] = float(seen.times[k] - began)
            out["start_m"] = float(way[k] - way[np.searchsorted(seen.times, began)])
    if stopped is not None and not seen.fell and seen.seconds > stopped:
        moving = np.nonzero(seen.speed > RESTS)[0]
        k = int(moving[-1]) if len(moving) else 0
        if k < len(seen.rows) - 1:
            out["stop_s"] = max(float(seen.times[k] - stopped), 0.0)
            out["stop_m"] = float(way[k] - way[np.searchsorted(seen.times, stopped)])
        out["residual_speed_m_s"] = float(seen.speed[-50:].mean())
    return out
