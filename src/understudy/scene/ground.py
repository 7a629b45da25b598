"""Level ground at z = 0."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from understudy.errors import InvalidValue


@dataclass(frozen=True, kw_only=True)
class Ground:
    """A level plane at z = 0.

    Attributes:
        friction: Coulomb coefficient between sole and ground.
        stiffness_time: Time constant of the contact [s]; the engine takes no less than two steps.
            Soles sink about 1 mm under an adult at 0.006 and 8 mm at 0.02.
    """

    friction: float = 1.0
    stiffness_time: float = 0.006

    def __post_init__(self) -> None:
        if not (np.isfinite(self.friction) and self.friction >= 0):
            raise InvalidValue(f"friction is {self.friction}; it must be zero or positive.")
        if not 0.001 <= self.stiffness_time <= 0.5:
            raise InvalidValue(
                f"stiffness_time is {self.stiffness_time} s; it must lie between 0.001 and 0.5."
            )

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add the plane to a scene that is being built."""
        spec.worldbody.add_geom(
            name="ground",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 1.0],
            friction=[self.friction, 0.005, 0.0001],
            solref=[self.stiffness_time, 1.0],
            priority=1,
            contype=1,
            conaffinity=1,
            rgba=[0.82, 0.84, 0.86, 1.0],
        )
