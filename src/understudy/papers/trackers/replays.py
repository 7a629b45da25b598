"""A performance run again with something changed: pushed, on slippery ground, heavier, weaker.

Servo gains and feedforward stay those of the body that rehearsed; what answers is the performance's
own feedback.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from understudy.control import Controls, Push
from understudy.errors import Diverged, InvalidValue
from understudy.evaluate.following import following
from understudy.evaluate.measure import measured
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.scene import Scene
from understudy.simulate import simulate
from understudy.variations import Mass, Together
from understudy.variations.change import body_of

PUSHES = (50.0, 100.0)
"""Forces on the pelvis [N], each for 0.1 s."""
PUSH_LASTS = 0.1
DIRECTIONS = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0))
"""World directions of the pushes."""
MOMENTS = (0.25, 0.5, 0.75)
"""When the pushes begin, as shares of the performance."""
SLIPPERY, HEAVIER, LIGHTER, WEAKER = 0.6, 1.05, 0.95, 0.9
"""Friction of the ground; factors on all masses and on the servos' gains."""
_RATE = 60.0
"""Frames a second at which a replay is judged [Hz]."""


@dataclass(frozen=True, kw_only=True)
class Weakened:
    """Joint servos whose stiffness and damping are a factor of what their controller believes.

    Attributes:
        factor: On both.
        character: Whose joints.
    """

    factor: float
    character: int = 0

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Scale the gains; controllers before this one have set them."""
        joints = list(scene.parts[self.character].joint_actuators)
        model.actuator_gainprm[joints] *= self.factor
        model.actuator_biasprm[joints] *= self.factor

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""

    def controls(self, scene: Scene, model: mujoco.MjModel, times: Array) -> Controls:
        """Nothing to add."""
        return Controls(np.zeros((len(times), model.nu)))


def replays(performance: Performance) -> dict[str, tuple[int, int]]:
    """Run a performance of one character changed in every way.

    Args:
        performance: One that tracks a clip on the ground.

    Returns:
        For every kind of change: how many replays were never lost (see `Following`), and of how
        many.

    Raises:
        InvalidValue: No clip is tracked, or there is no ground.
    """
    return {
        name: (sum(kept(one) for one in each), len(each))
        for name, each in changed(performance).items()
    }


def changed(performance: Performance) -> Mapping[str, tuple[Performance, ...]]:
    """The changed performances by kind of change."""
    scene = performance.scene
    if scene.ground is None:
        raise InvalidValue("There is no ground in this scene, so nothing to slip or stand on.")
    root = body_of(performance, 0).links[0].name
    slippery = replace(scene, ground=replace(scene.ground, friction=SLIPPERY))

    def weighing(factor: float) -> Performance:
        parts = (Mass(link=root, by=factor), Mass(link="body", by=factor))
        return Together(*parts)(performance)

    return {
        **{f"push of {force:g} N": tuple(_pushed(performance, root, force)) for force in PUSHES},
        f"friction {SLIPPERY:g}": (replace(performance, scene=slippery),),
        "mass + 5 %": (weighing(HEAVIER),),
        "mass - 5 %": (weighing(LIGHTER),),
        "gains - 10 %": (_with(performance, Weakened(factor=WEAKER)),),
    }


def kept(performance: Performance) -> bool:
    """Whether a performance is never lost."""
    try:
        take = simulate(performance)
    except Diverged:
        return False
    return following(take, measures=measured(take, rate=_RATE)).lost_s is None


def _pushed(performance: Performance, link: str, force: float) -> Iterator[Performance]:
    for share in MOMENTS:
        for x, y, z in DIRECTIONS:
            size = force * PUSH_LASTS
            push = Push(
                time=share * performance.duration,
                on=link,
                impulse=(size * x, size * y, size * z),
                duration=PUSH_LASTS,
            )
            yield _with(performance, push)


def _with(performance: Performance, controller: Push | Weakened) -> Performance:
    return replace(performance, controllers=(*performance.controllers, controller))
