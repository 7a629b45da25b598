"""Ready-made bodies: adults, a child, and the long-armed creature.

The child has the proportions of a boy or girl of seven: stature 1.22 m and 23 kg (the medians of
the growth charts of the World Health Organization, 2007), a sitting height of 0.55 of stature
against 0.52 in adults, and a head of a sixth of stature against an eighth. Its segment masses are an
adult's by fraction, with the head's raised, since no table here measures children.

The alien follows the creature of Zordan & Hodgins (1999), a motion captured from a person played by
a body with long arms and small legs; its factors are our own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from understudy.character.anthropometry import Sex
from understudy.character.body import Character, Plan
from understudy.errors import UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.skeleton import Skeleton


def adult_woman(*, plan: Plan = "full", height: float = 1.65, mass: float = 61.0) -> Character:
    """A woman; height [m], mass [kg]."""
    return _person("adult_woman", figure(height, "female"), "female", mass, height, plan)


def adult_man(*, plan: Plan = "full", height: float = 1.78, mass: float = 75.0) -> Character:
    """A man; height [m], mass [kg]."""
    return _person("adult_man", figure(height, "male"), "male", mass, height, plan)


def child(*, plan: Plan = "full", height: float = 1.22, mass: float = 23.0) -> Character:
    """A child of about seven; height [m], mass [kg]."""
    skeleton = _stretched(
        figure(height, "female"),
        {"hip": 1.0, "knee": 0.93, "ankle": 0.93, "elbow": 0.95, "wrist": 0.95, "shoulder": 0.98},
    )
    return _person("child", skeleton, "female", mass, height, plan)


def alien(*, plan: Plan = "full", height: float = 1.60, mass: float = 55.0) -> Character:
    """A creature with arms 1.5 times and legs 0.65 times a man's; height [m] of that man."""
    skeleton = _stretched(
        figure(height, "male"), {"elbow": 1.5, "wrist": 1.5, "knee": 0.65, "ankle": 0.65}
    )
    return _person("alien", skeleton, "male", mass, height, plan)


BODIES: dict[str, Callable[[], Character]] = {
    "adult_woman": adult_woman,
    "adult_man": adult_man,
    "child": child,
    "alien": alien,
}


def body(name: str) -> Character:
    """A ready-made body by name.

    Raises:
        UnknownName: No such body; the text suggests the nearest.
    """
    if name not in BODIES:
        raise UnknownName("body", name, BODIES)
    return BODIES[name]()


def _person(
    name: str, skeleton: Skeleton, sex: Sex, mass: float, height: float, plan: Plan
) -> Character:
    stance = Clip(
        skeleton=skeleton,
        rotations=rot.identity(1, len(skeleton)),
        root_positions=skeleton.offsets[:1],
        rate=1.0,
        name=name,
        synthetic=True,
    )
    return Character.from_clip(stance, plan=plan, sex=sex, mass=mass, height=height)


def _stretched(skeleton: Skeleton, factors: dict[str, float]) -> Skeleton:
    """Offsets of joints (by kind, both sides) multiplied; the root is set back on its feet."""
    offsets = np.array(skeleton.offsets)
    before = skeleton.rest_positions()[:, 2].min()
    for i, name in enumerate(skeleton.names):
        offsets[i] *= factors.get(name.split("_")[-1], 1.0) if i else 1.0
    out = replace(skeleton, offsets=offsets)
    offsets[0, 2] -= out.rest_positions()[:, 2].min() - before
    return replace(skeleton, offsets=offsets)
