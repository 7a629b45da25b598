"""A staff held in a hand."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from understudy.scene import props


@dataclass(frozen=True, kw_only=True)
class Staff:
    """A straight round staff, fixed in a hand; the hand feels its mass and inertia.

    Attributes:
        name: Its name in the model; sites "<name>/grip", "<name>/head" (the end `direction` points
            to) and "<name>/foot", all with z along the staff.
        held_by: The link that holds it; of a second character "b/right_hand".
        length: [m].
        mass: [kg].
        radius: [m].
        grip: Where along it the hand holds it: 0 at the foot, 1 at the head.
        direction: From foot to head in the link's frame, 3 numbers of any length. The thumb points
            along x where the palm, in the neutral T-pose, faces down.
        offset: From the middle of the hand to the staff, in the link's frame [m], 3 numbers.
        friction: Coulomb coefficient.
        stiffness_time: Time constant of its contacts [s].
    """

    name: str = "staff"
    held_by: str = "right_hand"
    length: float = 1.5
    mass: float = 0.8
    radius: float = 0.015
    grip: float = 0.5
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    friction: float = props.FRICTION
    stiffness_time: float = props.STIFFNESS_TIME

    def __post_init__(self) -> None:
        props.check_name(self.name)
        props.check_holder(self.held_by, self.name)
        props.number(self.length, "length", 0.05, 10.0, "m", what=self.name)
        props.number(self.mass, "mass", 1e-3, 100.0, "kg", what=self.name)
        props.number(self.radius, "radius", 0.002, 0.2, "m", what=self.name)
        props.number(self.grip, "grip", 0.0, 1.0, "", what=self.name)
        object.__setattr__(
            self, "direction", props.direction(self.direction, "direction", what=self.name)
        )
        offset = props.vector(self.offset, "offset", 3, "m", what=self.name, low=-2.0, high=2.0)
        object.__setattr__(self, "offset", offset)
        props.check_surface(self.friction, self.stiffness_time, self.name)

    @property
    def inertia(self) -> tuple[float, float, float]:
        """Of a solid cylinder about its middle, the last axis along it [kg m2]."""
        across = self.mass * (3.0 * self.radius**2 + self.length**2) / 12.0
        return across, across, 0.5 * self.mass * self.radius**2

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add the staff to the hand that holds it.

        Raises:
            UnknownName: No link has the name of `held_by`.
        """
        kinds = mujoco.mjtGeom
        hand = props.holder(spec, self.held_by, self.name)
        held = props.grip(spec, self.held_by) + np.array(self.offset)
        middle = held + (0.5 - self.grip) * self.length * np.array(self.direction)
        turn = props.upright(self.direction)
        body = props.add_body(spec, self.name, middle, turn, parent=hand)
        props.weigh(body, self.mass, np.array(self.inertia))
        half = 0.5 * self.length
        props.add_geom(
            body,
            f"{self.name}/shaft",
            kinds.mjGEOM_CAPSULE,
            (self.radius, half - self.radius),
            props.WOOD,
            friction=self.friction,
            stiffness_time=self.stiffness_time,
        )
        for name, height in (
            ("grip", (self.grip - 0.5) * self.length),
            ("head", half),
            ("foot", -half),
        ):
            props.add_site(body, f"{self.name}/{name}", pos=[0.0, 0.0, height])
        props.add_site(
            body,
            f"{self.name}/surface",
            kinds.mjGEOM_CAPSULE,
            (self.radius + props.REACH, half - self.radius),
        )
        props.add_touch(spec, self.name, f"{self.name}/surface")
