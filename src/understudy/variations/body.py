"""Variations of the body that performs: heavier and longer links.

Gains and feedforward stay those of the body that rehearsed, so the change has to be felt.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from understudy.character import Character, Link, retargeted
from understudy.character.planting import planted
from understudy.character.soles import standing
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.scene import Scene
from understudy.variations import driven
from understudy.variations.change import (
    Amount,
    Variation,
    body_of,
    exchanged,
    rehearsed,
    tracking_of,
)
from understudy.variations.intent import said, spoken
from understudy.variations.names import links_of

_MOST_KG = 1e4


@dataclass(frozen=True, kw_only=True)
class Mass(Variation):
    """Links lighter or heavier than they were, of the same shape; give one amount.

    Attributes:
        link: A link (or its joint), or a limb for all of its links.
        by: Factor on the mass.
        to: Mass of each link [kg].
        share: Mass of each link over that of the whole simulated body before.
    """

    link: str
    by: Amount | None = None
    to: Amount | None = None
    share: Amount | None = None

    def __post_init__(self) -> None:
        if len(list(self._amounts())) != 1:
            raise InvalidValue(f"Mass of {self.link!r}: give one of by, to and share.")
        for name, value in self._amounts():
            low = min(value) if isinstance(value, tuple) else value
            if not low > 0:
                raise InvalidValue(f"Mass: {name} is {value}; a mass must be positive.")
        self._check_amounts(1e-6, _MOST_KG if self.to is not None else 1e3)

    def _varied(self, performance: Performance) -> Performance:
        (name,) = (name for name, _ in self._amounts())
        amount = self._number(name)
        if drive := driven.drive_of(performance, self.character):
            return driven.weighed(performance, drive, self.link, name, amount)
        tracking = tracking_of(performance, self.character)
        body = body_of(performance, self.character)
        links = list(body.links)
        total = body.simulated_mass
        if tracking.rehearsal is not None:
            total = tracking.rehearsal.scene.characters[self.character].simulated_mass
        for i in links_of(body, self.link):
            own = links[i]
            mass = {"by": amount * own.mass, "to": amount, "share": amount * total}[name]
            if mass != own.mass:
                links[i] = replace(own, mass=mass, inertia=own.inertia * (mass / own.mass))
        if all(a is b for a, b in zip(links, body.links, strict=True)):
            return performance
        heavier = sum(k.mass for k in links) - body.simulated_mass
        new = replace(body, links=tuple(links), mass=body.mass + heavier)
        scene = _with_body(performance.scene, self.character, new)
        return exchanged(performance, tracking, rehearsed(performance, tracking), scene=scene)

    def __str__(self) -> str:
        if self.by is not None:
            return f"{spoken(self.link)}: mass x {said(self.by)}"
        if self.to is not None:
            return f"{spoken(self.link)}: mass {said(self.to)} kg"
        return f"{spoken(self.link)}: mass {said(self.share or 0.0)} x the body's unvaried mass"


@dataclass(frozen=True, kw_only=True)
class Length(Variation):
    """Links longer or shorter along their bone, of the same mass.

    The path of the hips and the planting of the feet are made anew for the changed legs.

    Attributes:
        link: A link (or its joint), or a limb for all of its links; not the root.
        by: Factor on the length.
    """

    link: str
    by: Amount

    def __post_init__(self) -> None:
        self._check_amounts(0.3, 3.0)

    def _varied(self, performance: Performance) -> Performance:
        if driven.drive_of(performance, self.character):
            raise InvalidValue("Length: the bodies of a linkage are as long as the clip's bones.")
        tracking = tracking_of(performance, self.character)
        body = body_of(performance, self.character)
        chosen = links_of(body, self.link)
        if 0 in chosen:
            raise InvalidValue(f"Length: {self.link!r} is the root, which is no bone.")
        factor = self._number("by")
        if factor == 1.0:
            return performance
        links = list(body.links)
        for i in chosen:
            _stretch(links, i, factor)
        new = replace(body, links=tuple(links), source=None)
        reference = retargeted(tracking.reference, new, actor=body)
        reference = planted(standing(reference, new), new).noted(f"{self}.")
        changed = replace(rehearsed(performance, tracking), reference=reference)
        scene = _with_body(performance.scene, self.character, new)
        return exchanged(performance, tracking, changed, scene=scene)

    def __str__(self) -> str:
        return f"{spoken(self.link)}: length x {said(self.by)}"


def _with_body(scene: Scene, which: int, body: Character) -> Scene:
    characters = list(scene.characters)
    characters[which] = body
    return replace(scene, characters=tuple(characters))


def _stretch(links: list[Link], i: int, factor: float) -> None:
    """Stretch link `i`, with what hangs on it, along the line from its joint to its far end."""
    own = links[i]
    children = [k for k, link in enumerate(links) if link.parent == i]
    points = [links[k].offset for k in children] + list(own.ends)
    axis = np.mean(points, axis=0) if points else own.com
    length = np.linalg.norm(axis)
    if length < 1e-6:
        raise InvalidValue(f"Length: the link {own.name!r} has no length to change.")
    axis = axis / length
    turn = np.eye(3) + (factor - 1.0) * np.outer(axis, axis)
    for k in children:
        links[k] = replace(links[k], offset=turn @ links[k].offset)
    # The second moment of mass stretches with the link; inertia follows from it.
    moment = 0.5 * np.trace(own.inertia) * np.eye(3) - own.inertia
    moment = turn @ moment @ turn
    shapes = []
    for shape in own.shapes:
        size = np.array(shape.size)
        if shape.kind != "mesh":
            size *= _along(shape.kind, shape.rotation, axis, factor)
        vertices = shape.vertices @ turn
        shapes.append(replace(shape, position=turn @ shape.position, size=size, vertices=vertices))
    links[i] = replace(
        own,
        ends=own.ends @ turn,
        com=turn @ own.com,
        inertia=np.trace(moment) * np.eye(3) - moment,
        shapes=tuple(shapes),
    )


def _along(kind: str, rotation: Array, axis: Array, factor: float) -> Array:
    """Factors on a shape's three sizes: only what lies along the axis grows."""
    local = np.abs(rot.rotate(rot.conjugate(rotation), axis))
    if kind == "capsule":
        return np.array([1.0, 1.0 + (factor - 1.0) * local[2], 1.0])
    return np.ones(3) if kind == "sphere" else 1.0 + (factor - 1.0) * local
