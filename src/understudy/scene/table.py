"""A table on four legs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco

from understudy.scene import props


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table that does not move.

    Attributes:
        name: Its name in the model; site "<name>/top" is the middle of its top, z up.
        position: Middle of the table on the ground [m], world: x, y, and z where it stands higher.
        size: Length along its own x and width along its y [m].
        height: Of the top [m].
        thickness: Of the top [m].
        heading: Turn of its x axis from world +x toward +y [rad].
        friction: Coulomb coefficient.
        stiffness_time: Time constant of its contacts [s].
    """

    name: str = "table"
    position: tuple[float, ...]
    size: tuple[float, float] = (1.2, 0.7)
    height: float = 0.74
    thickness: float = 0.03
    heading: float = 0.0
    friction: float = props.FRICTION
    stiffness_time: float = props.STIFFNESS_TIME

    def __post_init__(self) -> None:
        props.check_name(self.name)
        position = props.vector(self.position, "position", (2, 3), "m", what=self.name)
        object.__setattr__(self, "position", (*position, 0.0)[:3])
        size = props.vector(self.size, "size", 2, "m", what=self.name, low=0.1, high=20.0)
        object.__setattr__(self, "size", size)
        props.number(self.height, "height", 0.05, 5.0, "m", what=self.name)
        props.number(self.thickness, "thickness", 0.002, self.height, "m", what=self.name)
        props.number(self.heading, "heading", -100.0, 100.0, "rad", what=self.name)
        props.check_surface(self.friction, self.stiffness_time, self.name)

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add the table to a scene that is being built."""
        kinds = mujoco.mjtGeom
        body = props.add_body(spec, self.name, self.position, props.turned(self.heading))
        surface: dict[str, Any] = {"friction": self.friction, "stiffness_time": self.stiffness_time}
        x, y = (0.5 * side for side in self.size)
        thick = 0.5 * self.thickness
        props.add_geom(
            body,
            f"{self.name}/plate",
            kinds.mjGEOM_BOX,
            (x, y, thick),
            props.WOOD,
            pos=[0.0, 0.0, self.height - thick],
            **surface,
        )
        leg = min(0.025, 0.2 * min(x, y))
        half = 0.5 * (self.height - self.thickness)
        if half > 0.0:
            for k, (i, j) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1))):
                props.add_geom(
                    body,
                    f"{self.name}/leg{k + 1}",
                    kinds.mjGEOM_BOX,
                    (leg, leg, half),
                    props.DARK_WOOD,
                    pos=[i * (x - 2.0 * leg), j * (y - 2.0 * leg), half],
                    **surface,
                )
        reach = props.REACH
        props.add_site(body, f"{self.name}/top", pos=[0.0, 0.0, self.height])
        props.add_site(
            body,
            f"{self.name}/surface",
            kinds.mjGEOM_BOX,
            (x + reach, y + reach, 0.5 * self.height + reach),
            pos=[0.0, 0.0, 0.5 * self.height],
        )
        props.add_touch(spec, self.name, f"{self.name}/surface")
