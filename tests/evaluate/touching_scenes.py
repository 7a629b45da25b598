"""A small body beside things that move on their own, for contact whose mechanics is closed form."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from bodies import chain, still
from understudy.control import Controls, Tracking
from understudy.performance import Performance
from understudy.scene import Ground, Scene
from understudy.simulate import simulate
from understudy.take import Take

BIT = 1


@dataclass(frozen=True, kw_only=True)
class Loose:
    """A free ball or box; the ground and every `Fixed` touch it."""

    name: str = "ball"
    position: tuple[float, float, float] = (3.0, 0.0, 1.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    size: tuple[float, ...] = (0.1,)
    mass: float = 2.0
    solref: tuple[float, float] = (0.01, 1.0)

    def attach(self, spec: mujoco.MjSpec) -> None:
        kinds = mujoco.mjtGeom
        body = spec.worldbody.add_body(name=self.name, pos=self.position)
        body.add_freejoint(name=self.name)
        body.add_geom(
            name=f"{self.name}/solid",
            type=kinds.mjGEOM_SPHERE if len(self.size) == 1 else kinds.mjGEOM_BOX,
            size=[*self.size, 0, 0][:3],
            mass=self.mass,
            contype=BIT,
            conaffinity=BIT,
            solref=self.solref,
            priority=2,
        )


@dataclass(frozen=True, kw_only=True)
class Fixed:
    """A block fixed to the world, as geoms of the world (two halves) and no body."""

    name: str = "table"
    position: tuple[float, float, float] = (3.0, 0.0, 0.5)
    half: float = 0.3

    def attach(self, spec: mujoco.MjSpec) -> None:
        for k, side in enumerate((-1, 1)):
            spec.worldbody.add_geom(
                name=f"{self.name}/{k}",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=[self.half / 2, self.half, 0.1],
                pos=np.add(self.position, [side * self.half / 2, 0, 0]),
                contype=BIT,
                conaffinity=BIT,
                solref=[0.01, 1.0],
            )


@dataclass(frozen=True)
class Thrown:
    """Gives loose props their velocity at the start."""

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        for prop in scene.props:
            if isinstance(prop, Loose):
                first = scene.model.joint(prop.name).dofadr[0]
                data.qvel[first : first + 3] = prop.velocity

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Nothing to set."""

    def controls(self, scene: Scene, model: mujoco.MjModel, times: np.ndarray) -> Controls:
        return Controls(np.zeros((len(times), model.nu)))


def played(
    *props: object, seconds: float = 1.0, ground: Ground | None = None, timestep: float = 0.001
) -> Take:
    """What props do by themselves, far from a body that hangs still."""
    body = chain(2)
    clip = still(body, seconds=seconds)
    scene = Scene(characters=(body,), ground=ground, props=props, timestep=timestep)  # type: ignore[arg-type]
    led = Tracking(reference=clip, pelvis="led")
    return simulate(Performance(scene=scene, controllers=(led, Thrown()), duration=seconds))
