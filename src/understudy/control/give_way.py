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
from understudy.control.disturbance import Disturbance
from understudy.control.quaternion import advanced, quaternion_at
from understudy.control.task import JOINT, TIMES, Task, error_of, joint_rows, spin_of
from understudy.errors import InvalidValue, shown
from understudy.motion.rotations import Array
from understudy.scene import Scene

_LEGS = ("hip", "knee", "ankle", "ball")


@dataclass(frozen=True, kw_only=True)
class GiveWay(Task):
    """Servo strength that falls at hits and recovers. Put it after all other controllers.

    Attributes:
        hits: Times of the hits [s]; see `after`.
        strength: What is left of the servos right after a hit, 0 to 1.
        fall: How fast strength falls [s].
        limp: How long it stays low [s].
        recovery: How long it takes to come back [s].
        give: Names of joints that give way; None for all but the legs', which go on standing.
    """

    hits: tuple[float, ...] = ()
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
        return cls(hits=tuple(one.time for one in disturbances), **settings)

    def share(self, times: Array) -> Array:
        """What is left of the strength at times [s], 0 to 1, shape (times,)."""
        numbers = self._numbers((0, 0, 0), 0)
        return np.array([strength_at(float(time), numbers) for time in times])

    def _numbers(self, slides: tuple[int, int, int], rows: int) -> Array:
        """What the law reads before the joints: the course of strength, the root, the hits."""
        course = (self.strength, self.fall, self.limp, self.recovery)
        return np.array([*self.times, *course, *slides, len(self.hits), rows, *self.hits])

    def check_joints(self, body: Character) -> None:
        """Refuse a body that lacks a joint named in `give`; it shares all others with tasks.

        Raises:
            UnknownName: Names the joint and those there are.
        """
        for joint in self.give or ():
            body.link(joint)

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, the hits and the servos, and nothing to remember."""
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
        numbers = self._numbers(slides, len(rows))
        return _law, np.concatenate((numbers, rows.ravel())), np.zeros(0)


_STRENGTH, _SLIDES, _HITS, _COUNT, _FIRST = (TIMES + k for k in (0, 4, 7, 8, 9))


def _law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """Replace every command by one that gives a share s of its torque, damping included."""
    s = strength_at(time, parameters)
    if s >= 1.0:
        return
    q, v = int(parameters[_SLIDES]), int(parameters[_SLIDES + 1])
    c = int(parameters[_SLIDES + 2])
    for axis in range(3):
        place, speed = state.qpos[q + axis], state.qvel[v + axis]
        ctrl[c + 2 * axis] = place + s * (ctrl[c + 2 * axis] - place)
        ctrl[c + 2 * axis + 1] = speed + s * (ctrl[c + 2 * axis + 1] - speed)
    first = _FIRST + int(parameters[_HITS])
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


def strength_at(time, parameters):  # type: ignore[no-untyped-def]
    """Share of the servos' torque at a time: the least that any hit leaves."""
    low, fall, limp, recovery = (
        parameters[_STRENGTH],
        parameters[_STRENGTH + 1],
        parameters[_STRENGTH + 2],
        parameters[_STRENGTH + 3],
    )
    least = 1.0
    for k in range(int(parameters[_HITS])):
        since = time - parameters[_FIRST + k]
        if since < 0.0 or since >= fall + limp + recovery:
            continue
        if since < fall:
            down = since / fall
        elif since < fall + limp:
            down = 1.0
        else:
            down = 0.5 + 0.5 * math.cos(math.pi * (since - fall - limp) / recovery)
        least = min(least, 1.0 - (1.0 - low) * down)
    return least
