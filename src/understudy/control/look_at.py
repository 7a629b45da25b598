"""Looking at something: the neck turns the head, the rest of the body follows the clip."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from understudy.control.quaternion import (
    arc,
    composed,
    inverse,
    orientation,
    quaternion_at,
    rotated,
)
from understudy.control.reach import changing
from understudy.control.task import (
    TIMES,
    Task,
    commanded,
    gravity_torque,
    joint_rows,
    put,
    site_number,
    weight_at,
)
from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array
from understudy.scene import Scene

# The eyes in the head's frame, over the body's height: ahead of the neck's joint and above it
# (eye height .936 H, Drillis & Contini 1966; the joint lies at .848 H).
EYES = (0.05, 0.0, 0.088)


@dataclass(frozen=True, kw_only=True)
class LookAt(Task):
    """Turns the head so that the face points at a target.

    Attributes:
        target: A point [m], world, 3 numbers, or a named site of the scene, which may move.
        limit: How far the face turns from the chest's forward direction, sideways and up or down
            [rad]; what is farther behind or below is looked at as far as that. By default 75 and 45
            degrees, a comfortable part of what a neck can; eyes do the rest.
    """

    target: str | tuple[float, float, float]
    limit: tuple[float, float] = (math.radians(75.0), math.radians(45.0))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.target, str):
            point = frozen_array(self.target, (3,), "LookAt: target")
            object.__setattr__(self, "target", tuple(point.tolist()))
        limit = frozen_array(self.limit, (2,), "LookAt: limit")
        if not ((limit > 0.0) & (limit <= math.pi)).all():
            raise InvalidValue(
                f"LookAt: limit is {self.limit} rad; it must be two angles, each in 0 to pi."
            )
        object.__setattr__(self, "limit", tuple(limit.tolist()))

    @property
    def joints(self) -> tuple[str, ...]:
        """The neck."""
        return ("neck",)

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check the neck and a named target; see `Task.configure`.

        Raises:
            UnknownName: The character has no neck, or the scene no such site.
        """
        super().configure(scene, model)
        if isinstance(self.target, str):
            site_number(model, self.target, self.kind)

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, its target, and what it wanted last."""
        site, point = -1.0, np.zeros(3)
        if isinstance(self.target, str):
            site = float(site_number(model, self.target, self.kind))
        else:
            point = np.array(self.target)
        body = scene.characters[self.character]
        eyes = np.array(EYES) * body.height
        rows = joint_rows(scene, model, self.character, self.joints)
        head = (*self.times, scene.timestep, site, *point, *eyes, *self.limit)
        return _law, np.array([*head, *rows.ravel()]), np.zeros(8)


_DT, _SITE, _POINT, _ATEYES, _LIMIT, _ROW = (TIMES + k for k in (0, 1, 2, 5, 8, 10))


def _law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """The clip's head on the simulated chest, turned the short way until it faces the target."""
    weight = weight_at(time, parameters)
    if weight == 0.0:
        memory[0] = 0.0
        return
    body, dt = int(parameters[_ROW]), parameters[_DT]
    chest = orientation(state.xquat, int(parameters[_ROW + 1]))
    head = composed(chest, quaternion_at(ctrl, int(parameters[_ROW + 4])))
    eyes = (parameters[_ATEYES], parameters[_ATEYES + 1], parameters[_ATEYES + 2])
    ex, ey, ez = rotated(orientation(state.xquat, body), eyes)
    site = int(parameters[_SITE])
    tx, ty, tz = parameters[_POINT], parameters[_POINT + 1], parameters[_POINT + 2]
    if site >= 0:
        tx, ty, tz = state.site_xpos[site, 0], state.site_xpos[site, 1], state.site_xpos[site, 2]
    tx = tx - state.xpos[body, 0] - ex
    ty = ty - state.xpos[body, 1] - ey
    tz = tz - state.xpos[body, 2] - ez
    way = rotated(inverse(chest), (tx, ty, tz))
    way = within(way, parameters[_LIMIT], parameters[_LIMIT + 1])
    tx, ty, tz = rotated(chest, way)
    fx, fy, fz = rotated(head, (1.0, 0.0, 0.0))
    wanted = composed(inverse(chest), composed(arc(fx, fy, fz, tx, ty, tz), head))
    sx, sy, sz = changing(memory, 1, wanted, memory[0] > 0.0, dt)
    gx, gy, gz = gravity_torque(state, body, parameters[_ROW + 7])
    kd = parameters[_ROW + 6]
    torque = (gx + kd * sx, gy + kd * sy, gz + kd * sz)
    put(ctrl, parameters, _ROW, commanded(state, parameters, _ROW, wanted, torque), weight)
    memory[0] = 1.0


def within(way, sideways, upward):  # type: ignore[no-untyped-def]
    """A direction in the chest's frame, brought inside an ellipse of angles about ahead."""
    yaw = math.atan2(way[1], way[0])
    pitch = math.atan2(way[2], math.sqrt(way[0] * way[0] + way[1] * way[1]))
    over = math.sqrt((yaw / sideways) ** 2 + (pitch / upward) ** 2)
    if over <= 1.0:
        return way
    yaw, pitch = yaw / over, pitch / over
    return (
        math.cos(pitch) * math.cos(yaw),
        math.cos(pitch) * math.sin(yaw),
        math.sin(pitch),
    )
