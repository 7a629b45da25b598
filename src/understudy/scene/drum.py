"""A drum on a stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from understudy.motion import rotations as rot
from understudy.scene import props

_SHELL, _SKIN, _RIM = (0.53, 0.25, 0.20, 1.0), (0.93, 0.90, 0.82, 1.0), (0.34, 0.30, 0.28, 1.0)
_RIM_WIDTH = 0.008  # m


@dataclass(frozen=True, kw_only=True)
class Drum:
    """A drum that does not move, with a post to the ground below it.

    Attributes:
        name: Its name in the model; site "<name>/skin" is the middle of the skin, z outward.
        position: Middle of the skin [m], world, 3 numbers.
        radius: Of the shell [m].
        depth: Height of the shell [m].
        normal: Direction the skin faces, world, 3 numbers of any length.
        friction: Coulomb coefficient.
        stiffness_time: Time constant of its contacts [s]; the engine takes no less than two steps.
    """

    name: str = "drum"
    position: tuple[float, float, float]
    radius: float = 0.18
    depth: float = 0.25
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)
    friction: float = props.FRICTION
    stiffness_time: float = props.STIFFNESS_TIME

    def __post_init__(self) -> None:
        props.check_name(self.name)
        position = props.vector(self.position, "position", 3, "m", what=self.name)
        object.__setattr__(self, "position", position)
        props.number(self.radius, "radius", 0.02, 2.0, "m", what=self.name)
        props.number(self.depth, "depth", 0.01, 3.0, "m", what=self.name)
        object.__setattr__(self, "normal", props.direction(self.normal, "normal", what=self.name))
        props.check_surface(self.friction, self.stiffness_time, self.name)

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add the drum to a scene that is being built."""
        kinds = mujoco.mjtGeom
        body = props.add_body(spec, self.name, self.position, props.upright(self.normal))
        surface: dict[str, Any] = {"friction": self.friction, "stiffness_time": self.stiffness_time}
        half = 0.5 * self.depth
        props.add_geom(
            body,
            f"{self.name}/shell",
            kinds.mjGEOM_CYLINDER,
            (self.radius, half),
            _SHELL,
            pos=[0.0, 0.0, -half],
            **surface,
        )
        # What is only to be seen: the skin a hair over the shell, and the rim around it.
        looks = (
            ("head", self.radius - _RIM_WIDTH, 0.001, 0.0, _SKIN),
            ("rim", self.radius + 0.4 * _RIM_WIDTH, 0.010, -0.0105, _RIM),
            ("foot", self.radius + 0.3 * _RIM_WIDTH, 0.006, 0.006 - self.depth, _RIM),
        )
        for name, radius, thick, height, color in looks:
            geom = props.add_geom(
                body,
                f"{self.name}/{name}",
                kinds.mjGEOM_CYLINDER,
                (radius, thick),
                color,
                pos=[0.0, 0.0, height],
            )
            geom.group = props.SEEN
        self._add_stand(body)
        props.add_site(
            body,
            f"{self.name}/skin",
            kinds.mjGEOM_CYLINDER,
            (self.radius + props.REACH, 2 * props.REACH),
        )
        props.add_touch(spec, self.name, f"{self.name}/skin")

    def _add_stand(self, body: mujoco.MjsBody) -> None:
        """A post on a round foot, where there is room below the shell."""
        middle = np.array(self.position) - 0.5 * self.depth * np.array(self.normal)
        top = middle[2] - 0.3 * self.depth
        if top < 0.05:
            return
        # The stand is upright in the frame of a body that leans.
        back = rot.conjugate(props.upright(self.normal))
        parts = (("post", 0.018, 0.5 * top, 0.5 * top), ("base", 0.75 * self.radius, 0.008, 0.008))
        for name, radius, half, height in parts:
            place = np.array([middle[0], middle[1], height]) - np.array(self.position)
            geom = props.add_geom(
                body,
                f"{self.name}/{name}",
                mujoco.mjtGeom.mjGEOM_CYLINDER,
                (radius, half),
                _RIM,
                pos=rot.rotate(back, place),
                quat=back,
            )
            geom.group = props.SEEN
