"""One reproducible run: a scene, its controllers, how long, and the seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from understudy.character import Character, retargeted
from understudy.character.body import SelfCollision
from understudy.character.soles import planted, standing
from understudy.control import Controller, Tracking
from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.scene import Ground, Scene, timestep_for


@dataclass(frozen=True, kw_only=True)
class Performance:
    """Everything needed to reproduce a take, and no results.

    Attributes:
        scene: Where it happens.
        controllers: What drives it; feedback controllers act in this order.
        duration: Simulated time [s].
        seed: Seed of every random choice; the same seed gives the same take, bit for bit.
    """

    scene: Scene
    controllers: tuple[Controller, ...] = ()
    duration: float
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "controllers", tuple(self.controllers))
        if not (np.isfinite(self.duration) and self.duration >= 0):
            raise InvalidValue(f"duration is {self.duration} s; it must be zero or positive.")
        numbers = self.steps * (self.scene.model.nq + self.scene.model.nv + self.scene.model.nu)
        if numbers > 1_000_000_000:
            raise InvalidValue(
                f"duration is {self.duration} s: {numbers * 8 / 1e9:.0f} GB of states; "
                "trim the clip or use a longer timestep."
            )

    @property
    def steps(self) -> int:
        """Number of physics steps."""
        return round(self.duration / self.scene.timestep)


def tracked(
    clip: Clip,
    character: Character,
    *,
    pelvis: str | None = None,
    ground: Ground | None = None,
    timestep: float | None = None,
    self_collision: SelfCollision = "off",
    seed: int = 0,
    **settings: object,
) -> Performance:
    """The performance of a character tracking a clip.

    Glitches of the clip are repaired, its joint angles carried over to the character and its feet
    set on the ground; a servo then follows it (see `Tracking`).

    Args:
        clip: Any clip.
        character: Any character.
        pelvis: "led", "assisted" or "free"; by default led for a body without legs, else assisted.
        ground: The floor; by default level ground for a body with feet, none without.
        timestep: Physics step [s]; by default the one nearest 2 ms that divides the frame period.
        self_collision: See `Scene`.
        seed: Seed of the performance.
        settings: Passed on to `Tracking`: law, stiffness, torque_limits, ...
    """
    clean = clip.repaired()
    reference = planted(standing(retargeted(clean, character), character), character)
    feet = any((link.role or "").endswith("_ankle") for link in character.links)
    if ground is None and feet:
        ground = Ground()
    scene = Scene(
        characters=(character,),
        ground=ground,
        timestep=timestep_for(reference.rate) if timestep is None else timestep,
        self_collision=self_collision,
    )
    tracking = Tracking(
        reference=reference,
        captured=clip.noted(*clean.notes[len(clip.notes) :]),
        pelvis=pelvis or ("assisted" if feet else "led"),
        **settings,  # type: ignore[arg-type]
    )
    return Performance(scene=scene, controllers=(tracking,), duration=reference.duration, seed=seed)
