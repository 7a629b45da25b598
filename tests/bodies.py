"""Small hand-made bodies with closed-form behavior."""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from understudy.character import Character, Link
from understudy.motion.clip import Clip
from understudy.motion.rotations import identity

LENGTH, MASS, INERTIA = 0.6, 2.0, 0.02


def rod(name: str, parent: int, offset: tuple[float, float, float]) -> Link:
    """A link whose center of mass hangs `LENGTH` below its joint."""
    return Link(
        name=name,
        joint=f"{name}_joint",
        role=None,
        parent=parent,
        offset=np.array(offset),
        ends=np.array([[0.0, 0.0, -LENGTH]]),
        mass=MASS,
        com=np.array([0.0, 0.0, -LENGTH]),
        inertia=np.eye(3) * INERTIA,
    )


def chain(links: int = 2) -> Character:
    """A block with a chain of rods hanging from it."""
    root = replace(rod("block", -1, (0.0, 0.0, 3.0)), com=np.zeros(3))
    rods = [rod("rod1", 0, (0.0, 0.0, 0.0))]
    rods += [rod(f"rod{k}", k - 1, (0.0, 0.0, -LENGTH)) for k in range(2, links)]
    return Character(name="chain", links=(root, *rods), mass=MASS * links, height=1.0)


def still(character: Character, *, seconds: float = 2.0, rate: float = 100.0) -> Clip:
    """A clip in which the character holds its neutral pose at its rest position."""
    frames = round(seconds * rate) + 1
    skeleton = character.skeleton
    return Clip(
        skeleton=skeleton,
        rotations=identity(frames, len(skeleton)),
        root_positions=np.tile(skeleton.offsets[0], (frames, 1)),
        rate=rate,
        name="still",
    )


@dataclass(frozen=True)
class Pinned:
    """Holds a character's root where it starts (by inertia beyond measure), joints at an angle."""

    angle: float = 0.0

    def configure(self, scene, model) -> None:
        model.dof_armature[scene.parts[0].dofs.start : scene.parts[0].dofs.start + 6] = 1e12

    def start(self, scene, data: mujoco.MjData) -> None:
        part = scene.parts[0]
        data.qpos[part.qpos.start : part.qpos.start + 3] = scene.characters[0].links[0].offset
        first = part.qpos.start + 7
        data.qpos[first : first + 4] = [
            np.cos(self.angle / 2),
            0.0,
            np.sin(self.angle / 2),
            0.0,
        ]

    def controls(self, scene, model, times):
        from understudy.control import Controls

        return Controls(np.zeros((len(times), model.nu)))
