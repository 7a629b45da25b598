"""Ready-made bodies: adults, a child, and the long-armed creature.

The child is about seven: its head is a quarter larger for its stature than an adult's (a sixth of
stature against less than a seventh), its legs a twentieth shorter. No table here measures children;
segment masses are an adult's but for the head, which goes with its volume.

The alien follows the creature of Zordan & Hodgins (1999): a person's motion played by a body with
long arms and small legs. Its factors are our own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from understudy.character.anthropometry import Sex
from understudy.character.body import Character, Plan
from understudy.character.build import from_clip
from understudy.character.outline import HAIR, SHIRT, SKIN, TROUSERS
from understudy.errors import UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure
from understudy.motion.skeleton import Skeleton

Color = tuple[float, float, float, float]
_GREEN: Color = (0.52, 0.68, 0.42, 1.0)
_MOSS: Color = (0.28, 0.42, 0.25, 1.0)
_PLUM: Color = (0.42, 0.30, 0.48, 1.0)
_DARK_PLUM: Color = (0.27, 0.20, 0.33, 1.0)


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
        {"knee": 0.95, "ankle": 0.95, "elbow": 0.95, "wrist": 0.95, "shoulder": 0.95, "ball": 0.95},
    )
    return _person("child", skeleton, "female", mass, height, plan, head=1.25)


def alien(*, plan: Plan = "full", height: float = 1.75, mass: float = 55.0) -> Character:
    """A creature with arms 1.5 and legs 0.62 times those of a man of a height [m]."""
    skeleton = _stretched(
        figure(height, "male"), {"elbow": 1.5, "wrist": 1.5, "knee": 0.62, "ankle": 0.62}
    )
    creature = _person("alien", skeleton, "male", mass, height, plan, head=1.3)
    return _colored(creature, {SKIN: _GREEN, HAIR: _MOSS, SHIRT: _PLUM, TROUSERS: _DARK_PLUM})


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
    name: str,
    skeleton: Skeleton,
    sex: Sex,
    mass: float,
    height: float,
    plan: Plan,
    head: float = 1.0,
) -> Character:
    stance = Clip(
        skeleton=skeleton,
        rotations=rot.identity(1, len(skeleton)),
        root_positions=skeleton.offsets[:1],
        rate=1.0,
        name=name,
        synthetic=True,
    )
    return from_clip(stance, plan=plan, sex=sex, mass=mass, height=height, head=head)


def _colored(character: Character, colors: dict[Color, Color]) -> Character:
    """The same body in other colors."""
    links = []
    for link in character.links:
        shapes = [replace(s, rgba=colors.get(s.rgba, s.rgba)) for s in link.shapes]
        links.append(replace(link, shapes=tuple(shapes)))
    return replace(character, links=tuple(links))


def _stretched(skeleton: Skeleton, factors: dict[str, float]) -> Skeleton:
    """Offsets of joints (by kind, both sides) multiplied; the root is set back on its feet."""
    offsets = np.array(skeleton.offsets)
    before = skeleton.rest_positions()[:, 2].min()
    for i, name in enumerate(skeleton.names):
        offsets[i] *= factors.get(name.split("_")[-1], 1.0) if i else 1.0
    out = replace(skeleton, offsets=offsets)
    offsets[0, 2] -= out.rest_positions()[:, 2].min() - before
    return replace(skeleton, offsets=offsets)
