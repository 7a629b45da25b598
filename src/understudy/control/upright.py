"""Keeping a held thing upright (Zordan & Hodgins 1999, section 4.2, the staff).

Where the clip's own wrist would be tracked, a servo with feedback keeps the axis of what is held
vertical; the rest of the body moves as captured. The hand's turn about that axis stays the clip's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from understudy.control.gains import outboard_inertia
from understudy.control.quaternion import (
    arc,
    composed,
    inverse,
    orientation,
    quaternion_at,
    rotated,
)
from understudy.control.task import (
    TIMES,
    Task,
    error_of,
    given_torque,
    gravity_torque,
    joint_rows,
    put,
    spin_of,
    weight_at,
)
from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array
from understudy.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Upright(Task):
    """Keeps an axis of a hand, and what it holds, vertical.

    Attributes:
        hand: "left" or "right".
        axis: What is to point up, in the hand's frame; by default a held staff's, which points to
            the thumb, (1, 0, 0).
        stiffness: Of the wrist, over the inertia of the hand and what it holds [1/s^2]: 200 sways
            twice a second.
        damping_ratio: 1 comes back without swinging over.
    """

    hand: str = "right"
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    stiffness: float = 200.0
    damping_ratio: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.hand not in ("left", "right"):
            raise InvalidValue(f"Upright: hand is {self.hand!r}; it must be 'left' or 'right'.")
        axis = frozen_array(self.axis, (3,), "axis")
        length = float(np.linalg.norm(axis))
        if length < 1e-9:
            raise InvalidValue("Upright: axis is zero; it must be a direction in the hand's frame.")
        object.__setattr__(self, "axis", tuple((axis / length).tolist()))
        for name, value, most in (
            ("stiffness", self.stiffness, 1e5),
            ("damping_ratio", self.damping_ratio, 100.0),
        ):
            if not 0.0 < value <= most:
                raise InvalidValue(f"Upright: {name} is {value}; it must lie in 0 to {most:g}.")

    @property
    def joints(self) -> tuple[str, ...]:
        """The wrist."""
        return (f"{self.hand}_wrist",)

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, its gains, and nothing to remember."""
        rows = joint_rows(scene, model, self.character, self.joints)
        inertia = outboard_inertia(model, scene.parts[self.character])
        own = float(inertia[scene.characters[self.character].index(self.joints[0])])
        k = self.stiffness * own
        kd = 2.0 * self.damping_ratio * np.sqrt(self.stiffness) * own
        return _law, np.array([*self.times, *self.axis, k, kd, *rows.ravel()]), np.zeros(0)


def _law(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """tau = k e - kd omega, e from the axis to the vertical, omega in the world: plus weight."""
    weight = weight_at(time, parameters)
    if weight == 0.0:
        return
    ax, ay, az = parameters[TIMES], parameters[TIMES + 1], parameters[TIMES + 2]
    k, kd = parameters[TIMES + 3], parameters[TIMES + 4]
    row = TIMES + 5
    body = int(parameters[row])
    parent = orientation(state.xquat, int(parameters[row + 1]))
    # Where the clip's wrist would put the hand, turned the short way until the axis points up.
    hand = composed(parent, quaternion_at(ctrl, int(parameters[row + 4])))
    x, y, z = rotated(hand, (ax, ay, az))
    wanted = composed(inverse(parent), composed(arc(x, y, z, 0.0, 0.0, 1.0), hand))
    ex, ey, ez = error_of(state, parameters, row, wanted)
    # The hand's spin in the world, in its own frame: it must come to rest there, not in the arm.
    spin = (state.cvel[body, 0], state.cvel[body, 1], state.cvel[body, 2])
    wx, wy, wz = rotated(inverse(orientation(state.xquat, body)), spin)
    # About the axis it follows the clip: there the joint's own spin is damped.
    jx, jy, jz = spin_of(state, int(parameters[row + 3]))
    along = (jx - wx) * ax + (jy - wy) * ay + (jz - wz) * az
    wx, wy, wz = wx + along * ax, wy + along * ay, wz + along * az
    gx, gy, gz = gravity_torque(state, body, parameters[row + 7])
    torque = (k * ex - kd * wx + gx, k * ey - kd * wy + gy, k * ez - kd * wz + gz)
    put(ctrl, parameters, row, given_torque(state, parameters, row, torque), weight)
