"""A ball to be thrown."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from understudy.scene import props

_COLOR = (0.78, 0.40, 0.29, 1.0)


@dataclass(frozen=True, kw_only=True)
class Ball:
    """A loose solid ball.

    Attributes:
        name: Its name in the model, also that of its free joint; site "<name>/center".
        position: Where its middle starts [m], world, 3 numbers.
        radius: [m].
        mass: [kg].
        friction: Coulomb coefficient.
        stiffness_time: Time constant of its contacts [s].
    """

    name: str = "ball"
    position: tuple[float, float, float]
    radius: float = 0.11
    mass: float = 0.43
    friction: float = props.FRICTION
    stiffness_time: float = props.STIFFNESS_TIME

    def __post_init__(self) -> None:
        props.check_name(self.name)
        position = props.vector(self.position, "position", 3, "m", what=self.name)
        object.__setattr__(self, "position", position)
        props.number(self.radius, "radius", 0.005, 5.0, "m", what=self.name)
        props.number(self.mass, "mass", 1e-3, 1e4, "kg", what=self.name)
        props.check_surface(self.friction, self.stiffness_time, self.name)

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add the ball to a scene that is being built."""
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        body = props.add_body(spec, self.name, self.position, props.turned(0.0))
        body.add_freejoint(name=self.name)
        props.weigh(body, self.mass, np.full(3, 0.4 * self.mass * self.radius**2))
        props.add_geom(
            body,
            f"{self.name}/solid",
            sphere,
            (self.radius,),
            _COLOR,
            friction=self.friction,
            stiffness_time=self.stiffness_time,
            grounded=True,
        )
        props.add_site(body, f"{self.name}/center", sphere, (self.radius + props.REACH,))
        props.add_touch(spec, self.name, f"{self.name}/center")
