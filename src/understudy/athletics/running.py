"""Running without a clip (Hodgins et al. 1995): the user gives speed and facing, or a path.

    performance = running(athlete_man(), Course.steady(3.5), duration=20.0)
    take = simulate(performance)

The control laws are in `running_law`; this module gives them a body, gains, a course and a first
state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import mujoco
import numpy as np

from understudy.athletics import running_law as law
from understudy.athletics import standing_law as stand
from understudy.athletics.course import COURSE_MEMORY, HEADING, LEAST, Course
from understudy.athletics.gains import NAMES, Gains, Schedule, shipped
from understudy.athletics.standing import at_rest, standing_memory, standing_parameters
from understudy.athletics.standing_gains import StandingSchedule, shipped_standing
from understudy.character import Athlete, athlete
from understudy.control.machine import SINCE
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.scene import Scene

# The body the gains are named for: mass [kg] times height [m].
NAMED_BODY = 70.0 * 1.75
TIMESTEP = 0.001
# A made-up first flight: upward speed [m/s] at 3.5 m/s and per m/s, hips ahead and behind [rad].
_CLIMB, _AHEAD, _BEHIND = (0.40, 0.095), (0.60, -0.097), (-0.30, -0.008)
_TIMES = (SINCE, law.TOUCHDOWN, law.LIFTOFF, law.THRUST, law.LOADED, law.ANKLE_SINCE)


@dataclass(frozen=True, kw_only=True)
class Running:
    """Controller of one athlete that runs.

    Attributes:
        course: Where to and how fast.
        schedule: Gains over speed; by default those that come with the package.
        standing: Gains of starts and stops; the same.
        character: Which of the scene's characters.
        offset: Added to the place where the course begins [m]: x, y.
    """

    course: Course = field(default_factory=Course)
    schedule: Schedule = field(default_factory=shipped, repr=False)
    standing: StandingSchedule = field(default_factory=shipped_standing, repr=False)
    character: int = 0
    offset: tuple[float, float] = (0.0, 0.0)

    def athlete(self, scene: Scene) -> Athlete:
        """The body it drives.

        Raises:
            InvalidValue: The scene's character is no athlete.
        """
        if not 0 <= self.character < len(scene.characters):
            raise InvalidValue(
                f"Running: character is {self.character}; the scene has {len(scene.characters)}."
            )
        body = scene.characters[self.character]
        if not isinstance(body, Athlete):
            raise InvalidValue(f"Running: {body.name!r} is no athlete; use athlete_man().")
        return body

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check that the character is an athlete."""
        self.athlete(scene)

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Put the athlete on its course in a steady run, or in a made-up flight before one."""
        body, part = self.athlete(scene), scene.parts[self.character]
        place, heading, speed = self.course.start
        if speed < LEAST:
            qpos, qvel = at_rest(body, self.standing.gains)
        else:
            qpos, qvel, _ = self._first(body, speed)
        turn = rot.from_rotvec(np.array([0.0, 0.0, heading]))
        qpos[:3] = rot.rotate(turn, qpos[:3])
        qpos[:2] += place + np.array(self.offset)
        qpos[3:7] = rot.multiply(turn, qpos[3:7])
        qvel[:3] = rot.rotate(turn, qvel[:3])
        data.qpos[part.qpos], data.qvel[part.dofs] = qpos, qvel

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, the body and gains, and what the law remembers of the run before."""
        body = self.athlete(scene)
        speed = self.course.start[2]
        memory = self._first(body, speed)[2]
        own = self.course.memory()
        # Biases are the run's, the place and heading the course's.
        for k in (law.M_COURSE + 2, law.M_COURSE + 3):
            own[k - law.M_COURSE] = memory[k]
        memory = np.concatenate((memory[: law.M_COURSE], own))
        parameters = self._parameters(scene, model)
        if not self.course.stands:
            return law.runner, parameters, memory
        more = standing_memory(parameters, runs=speed >= LEAST, heading=own[HEADING])
        return stand.athlete, parameters, np.concatenate((memory, more))

    def _parameters(self, scene: Scene, model: mujoco.MjModel) -> Array:
        body, part = self.athlete(scene), scene.parts[self.character]
        first = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, part.prefix + "left_heel")
        gravity = abs(float(model.opt.gravity[2]))
        out = np.zeros(law.P_GAINS)
        out[law.P_QPOS], out[law.P_QVEL] = part.qpos.start, part.dofs.start
        out[law.P_CTRL], out[law.P_SENSORS] = part.joint_controls[0], model.sensor_adr[first]
        out[law.P_PELVIS], out[law.P_DT] = part.bodies[0], scene.timestep
        out[law.P_GRAVITY], out[law.P_WEIGHT] = gravity, body.mass * gravity
        out[law.P_SCALE] = body.mass * body.height / NAMED_BODY
        out[law.P_THIGH] = -float(body.link("left_knee").offset[2])
        out[law.P_SHANK] = -float(body.link("left_ankle").offset[2])
        out[law.P_HIP] = float(body.link("left_hip").offset[1])
        foot = model.site(part.prefix + "left_heel").pos
        ball = model.site(part.prefix + "left_ball").pos
        out[law.P_HEEL_X], out[law.P_HEEL_Z] = foot[0], body.sole_height
        out[law.P_FOOT] = ball[0] - foot[0]
        upright = standing_parameters(body, part.bodies, out, self.standing.gains)
        gains = (self.schedule.rows().ravel(), self.standing.row())
        return np.concatenate((out, *gains, upright, self.course.parameters()))

    def _first(self, body: Athlete, speed: float) -> tuple[Array, Array, Array]:
        """Positions, velocities and memory at time zero, facing +x at the origin."""
        own = [s for s in self.schedule.starts if s["athlete"] == body.name]
        starts = own or list(self.schedule.starts)
        if not starts:
            return made_up(body, self.schedule.at(speed), speed)
        near = min(starts, key=lambda s: abs(float(s["speed"]) - speed))
        arrays = (np.array(near[name], float) for name in ("qpos", "qvel", "memory"))
        qpos, qvel, memory = arrays
        # Another body's state: the same angles, its pelvis higher or lower by its legs.
        name, height = near["athlete"].removeprefix("athlete_"), near.get("height")
        higher = float(body.links[0].offset[2]) - _pelvis_height(name, height)
        qpos[2] += higher
        memory[law.LANDING_HEIGHT] += higher
        # A run a little faster or slower than the stored one is the same but for its speed.
        qvel[0] += speed - float(near["speed"])
        return qpos, qvel, memory


@cache
def _pelvis_height(name: str, height: float | None) -> float:
    """Of a ready-made athlete that stands [m]."""
    return float(athlete(name, height=height).links[0].offset[2])


def made_up(body: Athlete, gains: Gains, speed: float) -> tuple[Array, Array, Array]:
    """A flight as between two steps, right leg ahead: positions, velocities, memory."""
    more = speed - 3.5
    nq, nv = body.widths
    qpos, qvel = np.zeros(nq), np.zeros(nv)
    qpos[2], qpos[3] = float(body.links[0].offset[2]) - 0.008, 1.0
    qvel[0], qvel[2] = speed, _CLIMB[0] + _CLIMB[1] * more
    right, left = qpos[7 + law.RIGHT_LEG :], qpos[7 + law.LEFT_LEG :]
    right[law.HIP_Y], right[law.KNEE] = _AHEAD[0] + _AHEAD[1] * more, gains.ready_knee
    left[law.HIP_Y], left[law.KNEE], left[law.ANKLE_H] = _BEHIND[0] + _BEHIND[1] * more, 0.25, -0.3
    for arm, hip, out in ((law.LEFT_ARM, right, 1.0), (law.RIGHT_ARM, left, -1.0)):
        swing = gains.arm_swing * (hip[law.HIP_Y] - 0.3) + gains.arm_offset
        qpos[7 + arm] = np.clip(swing, -1.2, 1.2)
        qpos[8 + arm], qpos[10 + arm] = 0.15 * out, 1.5
    qpos[7 + law.WAIST + 1] = gains.waist_lean
    memory = np.zeros(law.M_COURSE + COURSE_MEMORY)
    memory[law.ACTIVE], memory[law.STANCE], memory[law.FLIGHT_TIME] = law.RIGHT, 0.22, 0.10
    memory[law.MEAN_FLIGHT], memory[law.LANDING_HEIGHT] = 0.15, 0.97 * float(qpos[2])
    hips = (float(left[law.HIP_Y]), float(right[law.HIP_Y]))
    memory[law.HIP_Y_LEFT], memory[law.HIP_Y_RIGHT] = hips
    memory[law.WAS_ACTIVE_Y], memory[law.WAS_IDLE_Y] = hips[1], hips[0]
    knees = (0.25, gains.ready_knee)
    memory[law.KNEE_LEFT], memory[law.KNEE_RIGHT] = knees
    memory[law.WAS_ACTIVE_KNEE], memory[law.WAS_IDLE_KNEE] = knees[1], knees[0]
    return qpos, qvel, memory


def steady_state(
    body: Athlete, speed: float, qpos: Array, qvel: Array, memory: Array, time: float
) -> Mapping[str, Any]:
    """A state of a run to start others from, as plain values for `Schedule.starts`."""
    kept = np.array(memory)
    kept[list(_TIMES)] -= time
    moved = np.array(qpos)
    moved[:2] = 0.0
    assert len(NAMES) == law.GAINS
    return {
        "athlete": body.name,
        "height": body.height,
        "speed": speed,
        "qpos": moved.tolist(),
        "qvel": np.asarray(qvel).tolist(),
        "memory": kept.tolist(),
    }
