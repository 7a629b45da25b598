"""A box: fixed, loose or held."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from understudy.scene import props

_COLOR = (0.47, 0.55, 0.49, 1.0)


@dataclass(frozen=True, kw_only=True)
class Box:
    """A box: fixed where it has no mass, loose where it has one, or held in a hand.

    Attributes:
        name: Its name in the model, also that of a loose box's free joint; sites "<name>/center"
            and "<name>/top".
        position: Its middle [m], world, 3 numbers; of a held box in the link's frame from the
            middle of the hand, where None lays it against the palm.
        size: Its sides [m], 3 numbers.
        mass: [kg]; None for a box that does not move. A held box needs one.
        heading: Turn of its x axis from world +x (or the link's) toward +y [rad].
        held_by: The link that holds it, or None; of a second character "b/right_hand".
        friction: Coulomb coefficient.
        stiffness_time: Time constant of its contacts [s].
    """

    name: str = "box"
    position: tuple[float, float, float] | None = None
    size: tuple[float, float, float] = (0.3, 0.3, 0.3)
    mass: float | None = None
    heading: float = 0.0
    held_by: str | None = None
    friction: float = props.FRICTION
    stiffness_time: float = props.STIFFNESS_TIME

    def __post_init__(self) -> None:
        props.check_name(self.name)
        set_ = object.__setattr__
        set_(self, "size", props.vector(self.size, "size", 3, "m", what=self.name, low=0.005))
        if self.mass is not None:
            props.number(self.mass, "mass", 1e-3, 1e4, "kg", what=self.name)
        if self.held_by is not None:
            props.check_holder(self.held_by, self.name)
            props.number(self.mass, "mass", 1e-3, 100.0, "kg", what=f"{self.name}, which is held,")
        if self.position is not None or self.held_by is None:
            position = props.vector(self.position, "position", 3, "m", what=self.name)
            set_(self, "position", position)
        props.number(self.heading, "heading", -100.0, 100.0, "rad", what=self.name)
        props.check_surface(self.friction, self.stiffness_time, self.name)

    @property
    def inertia(self) -> tuple[float, float, float]:
        """Of the solid about its middle, along its axes [kg m2]; zero without a mass."""
        a, b, c = (side**2 * (self.mass or 0.0) / 12.0 for side in self.size)
        return b + c, a + c, a + b

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add the box to a scene that is being built.

        Raises:
            UnknownName: No link has the name of `held_by`.
        """
        half = 0.5 * np.array(self.size)
        place = np.zeros(3) if self.position is None else np.array(self.position)
        parent = None
        if self.held_by is not None:
            parent = props.holder(spec, self.held_by, self.name)
            if self.position is None:
                place = np.array([0.0, 0.0, -half[2] - props.palm_depth(spec, self.held_by)])
            place = place + props.grip(spec, self.held_by)
        body = props.add_body(spec, self.name, place, props.turned(self.heading), parent=parent)
        loose = self.mass is not None and self.held_by is None
        if loose:
            body.add_freejoint(name=self.name)
        if self.mass is not None:
            props.weigh(body, self.mass, np.array(self.inertia))
        props.add_geom(
            body,
            f"{self.name}/solid",
            mujoco.mjtGeom.mjGEOM_BOX,
            tuple(half),
            _COLOR,
            friction=self.friction,
            stiffness_time=self.stiffness_time,
            grounded=loose,
        )
        props.add_site(
            body, f"{self.name}/center", mujoco.mjtGeom.mjGEOM_BOX, tuple(half + props.REACH)
        )
        props.add_site(body, f"{self.name}/top", pos=[0.0, 0.0, half[2]])
        props.add_touch(spec, self.name, f"{self.name}/center")
