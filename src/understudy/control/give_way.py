"""Giving way to a hit: servo strength falls at once and comes back, and with it the motion.

While it lasts every servo, the one that helps the pelvis included, pulls with a fraction of its
torque, stiffness and damping alike: the body goes where the hit sends it, and is taken back to the
clip as strength returns.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Real
from typing import Any

import mujoco
import numpy as np

from understudy.character import Character
from understudy.control.disturbance import Disturbance, Throw
from understudy.control.quaternion import advanced, quaternion_at
from understudy.control.task import JOINT, TIMES, Task, error_of, joint_rows, spin_of
from understudy.errors import InvalidValue, UnknownName, shown
from understudy.motion.rotations import Array
from understudy.scene import Scene

_LEGS = ("hip", "knee", "ankle", "ball")
# How long before and after its time a prop may hit [s], and from which force on it has [N].
_BEFORE, _AFTER, _FELT = 0.35, 0.15, 1.0


@dataclass(frozen=True, kw_only=True)
class GiveWay(Task):
    """Servo strength that falls at hits and recovers. Put it after all other controllers.

    Attributes:
        hits: Times of the hits [s]; see `after`.
        touches: Names of props that hit, and about when [s]: strength falls when the prop first
            touches something within 0.35 s before that and 0.15 s after.
        strength: What is left of the servos right after a hit, 0 to 1.
        fall: How fast strength falls [s].
        limp: How long it stays low [s].
        recovery: How long it takes to come back [s].
        give: Names of joints that give way; None for all but the legs', which go on standing.
    """

    hits: tuple[float, ...] = ()
    touches: tuple[tuple[str, float], ...] = ()
    strength: float = 0.15
    fall: float = 0.02
    limp: float = 0.15
    recovery: float = 0.6
    give: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        times = tuple(self.hits) if isinstance(self.hits, Iterable) else (self.hits,)
        numbers = [float(t) if isinstance(t, Real) else math.nan for t in times]
        if not all(0.0 <= t < math.inf for t in numbers):
            raise InvalidValue(f"GiveWay: hits is {shown(self.hits)}; it must be times [s].")
        object.__setattr__(self, "hits", tuple(sorted(numbers)))
        touches = tuple((str(prop), float(time)) for prop, time in self.touches)
        object.__setattr__(self, "touches", touches)
        if not 0.0 <= self.strength <= 1.0:
            raise InvalidValue(f"GiveWay: strength is {self.strength}; it must lie in 0 to 1.")
        for name in ("fall", "limp", "recovery"):
            value = getattr(self, name)
            if not 0.0 <= value <= 60.0:
                raise InvalidValue(f"GiveWay: {name} is {shown(value)} s; it must lie in 0 to 60.")
        if self.give is not None:
            object.__setattr__(self, "give", tuple(self.give))

    @classmethod
    def after(cls, *disturbances: Disturbance, **settings: Any) -> GiveWay:
        """One that gives way to these pushes and throws; settings as for `GiveWay`."""
        throws = tuple((one.ball, one.time) for one in disturbances if isinstance(one, Throw))
        hits = tuple(one.time for one in disturbances if not isinstance(one, Throw))
        return cls(hits=hits, touches=throws, **settings)

    def share(self, times: Array) -> Array:
        """What is left of the strength at times [s], 0 to 1, shape (times,).

        Props are taken to hit at the times given: nothing is simulated yet.
        """
        numbers = self._numbers((0, 0, 0), 0, [])
        struck = np.array([time for _, time in self.touches])
        return np.array([strength_at(float(time), numbers, struck) for time in times])

    def _numbers(
        self, slides: tuple[int, int, int], rows: int, sensors: list[tuple[float, float, float]]
    ) -> Array:
        """What the law reads before the joints: the course of strength, the root, the hits."""
        course = (self.strength, self.fall, self.limp, self.recovery)
        counts = (len(self.hits), len(self.touches), rows)
        watched = [number for sensor in sensors for number in sensor]
        return np.array([*self.times, *course, *slides, *counts, *self.hits, *watched])

    def _sensors(self, model: mujoco.MjModel) -> list[tuple[float, float, float]]:
        """Place of every prop's touch sensor, and between which times it counts [s]."""
        out = []
        for prop, time in self.touches:
            name = f"{prop}/touch"
            number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SENSOR, name)
            if number < 0:
                kind = mujoco.mjtObj.mjOBJ_SENSOR
                names = [mujoco.mj_id2name(model, kind, k) or "" for k in range(model.nsensor)]
                valid = [n.removesuffix("/touch") for n in names if n.endswith("/touch")]
                raise UnknownName("prop for GiveWay", prop, valid)
            out.append((float(model.sensor_adr[number]), time - _BEFORE, time + _AFTER))
        return out

    def check_joints(self, body: Character) -> None:
        """Refuse a body that lacks a joint named in `give`; it shares all others with tasks.

        Raises:
            UnknownName: Names the joint and those there are.
        """
        for joint in self.give or ():
            body.link(joint)

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, the hits and the servos, and when each prop first touched something."""
        part, body = scene.parts[self.character], scene.characters[self.character]
        joints = self.give
        if joints is None:
            kinds = [(link.joint, (link.role or "").partition("_")[2]) for link in body.links[1:]]
            joints = tuple(joint for joint, kind in kinds if kind not in _LEGS)
        rows = joint_rows(scene, model, self.character, joints)
        root, servo = np.zeros(JOINT), part.root_actuators[3]
        root[:] = (
            part.bodies[0],
            0,
            part.qpos.start + 3,
            part.dofs.start + 3,
            part.root_controls[6],
            model.actuator_gainprm[servo, 0],
            -model.actuator_biasprm[servo, 2],
            0.0,
        )
        slides = (part.qpos.start, part.dofs.start, part.root_controls[0])
        rows = np.concatenate((root[None], rows))
        numbers = self._numbers(slides, len(rows), self._sensors(model))
        never = np.full(len(self.touches), -1.0)
        return _law, np.concatenate((numbers, rows.ravel())), never


_STRENGTH, _SLIDES, _HITS, _TOUCHES, _COUNT, _FIRST = (TIMES + k for k in (0, 4, 7, 8, 9, 10))


def _law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """Replace every command by one that gives a share s of its torque, damping included."""
    feel(time, state, parameters, memory)
    s = strength_at(time, parameters, memory)
    if s >= 1.0:
        return
    q, v = int(parameters[_SLIDES]), int(parameters[_SLIDES + 1])
    c = int(parameters[_SLIDES + 2])
    for axis in range(3):
        place, speed = state.qpos[q + axis], state.qvel[v + axis]
        ctrl[c + 2 * axis] = place + s * (ctrl[c + 2 * axis] - place)
        ctrl[c + 2 * axis + 1] = speed + s * (ctrl[c + 2 * axis + 1] - speed)
    first = _FIRST + int(parameters[_HITS]) + 3 * int(parameters[_TOUCHES])
    for k in range(int(parameters[_COUNT])):
        row = first + JOINT * k
        stiffness, damping = parameters[row + 5], parameters[row + 6]
        if stiffness <= 0.0:
            continue
        at = int(parameters[row + 4])
        # k e' - kd omega = s (k e - kd omega), so e' = s e + (1 - s) (kd / k) omega.
        ex, ey, ez = error_of(state, parameters, row, quaternion_at(ctrl, at))
        wx, wy, wz = spin_of(state, int(parameters[row + 3]))
        lag = (1.0 - s) * damping / stiffness
        ctrl[at], ctrl[at + 1], ctrl[at + 2], ctrl[at + 3] = advanced(
            quaternion_at(state.qpos, int(parameters[row + 2])),
            s * ex + lag * wx,
            s * ey + lag * wy,
            s * ez + lag * wz,
        )


def feel(time, state, parameters, memory):  # type: ignore[no-untyped-def]
    """Remember when each prop first touched something while it was expected to hit."""
    first = _FIRST + int(parameters[_HITS])
    for k in range(int(parameters[_TOUCHES])):
        at = first + 3 * k
        due = parameters[at + 1] <= time <= parameters[at + 2]
        if memory[k] < 0.0 and due and state.sensordata[int(parameters[at])] > _FELT:
            memory[k] = time


def strength_at(time, parameters, touched):  # type: ignore[no-untyped-def]
    """Share of the servos' torque at a time: the least that any hit or touch leaves."""
    low, fall, limp, recovery = (
        parameters[_STRENGTH],
        parameters[_STRENGTH + 1],
        parameters[_STRENGTH + 2],
        parameters[_STRENGTH + 3],
    )
    least = 1.0
    hits = int(parameters[_HITS])
    for k in range(hits + int(parameters[_TOUCHES])):
        moment = parameters[_FIRST + k] if k < hits else touched[k - hits]
        since = time - moment
        if moment < 0.0 or since < 0.0 or since >= fall + limp + recovery:
            continue
        if since < fall:
            down = since / fall
        elif since < fall + limp:
            down = 1.0
        else:
            down = 0.5 + 0.5 * math.cos(math.pi * (since - fall - limp) / recovery)
        least = min(least, 1.0 - (1.0 - low) * down)
    return least
