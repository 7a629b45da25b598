"""Whose a geometry is: the link, prop or part of the world that a contact is said to be with."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from understudy.errors import UnknownName
from understudy.evaluate.contacts import Integers

if TYPE_CHECKING:
    from understudy.scene import Scene
    from understudy.take import Take

WORLD = "world"
"""Name of what is fixed, has no name of its own and belongs to no prop."""


@dataclass(frozen=True, kw_only=True)
class Owners:
    """Names of all that can touch, and which geometries and bodies are theirs.

    Attributes:
        names: Links of the characters in order, then props, then what else there is ("ground").
        of_geom: Index of its name for each geometry of the model, shape (geoms,).
        of_body: The same for each body, shape (bodies,).
    """

    names: tuple[str, ...]
    of_geom: Integers = field(repr=False)
    of_body: Integers = field(repr=False)

    def index(self, name: str) -> int:
        """Place of a name.

        Raises:
            UnknownName: Nothing in the scene has it.
        """
        if name not in self.names:
            raise UnknownName("link, prop or ground", name, self.names)
        return self.names.index(name)


def owners(take: Take) -> Owners:
    """The owners of a take's geometries."""
    return owners_in(take.scene, take.model)


def owners_in(scene: Scene, model: mujoco.MjModel) -> Owners:
    """The owners of the geometries of a scene's model.

    A link is its body's name, with "b/" and so on for further characters. What a prop attached
    carries the prop's name: its body is called that, or its bodies and geoms begin with it and a
    slash. A geom of the world is called by its own name.
    """
    kinds = mujoco.mjtObj
    props = tuple(
        name for prop in scene.props if isinstance(name := getattr(prop, "name", None), str)
    )

    def named(kind: Any, number: int) -> str:
        name = _prop_of(mujoco.mj_id2name(model, kind, number) or "", props)
        # Steps are ground: "ground/step1".
        return "ground" if name.startswith("ground/") else name

    limbs = {body for part in scene.parts for body in part.bodies}
    bodies = [WORLD]
    for body in range(1, model.nbody):
        if body in limbs:
            bodies.append(mujoco.mj_id2name(model, kinds.mjOBJ_BODY, body))
            continue
        parent = int(model.body_parentid[body])
        unnamed = f"body {body}" if parent == 0 else bodies[parent]
        bodies.append(named(kinds.mjOBJ_BODY, body) or unnamed)
    geoms = [
        bodies[body] if body else named(kinds.mjOBJ_GEOM, geom) or WORLD
        for geom, body in enumerate(model.geom_bodyid)
    ]
    links = [bodies[body] for part in scene.parts for body in part.bodies]
    names = tuple(dict.fromkeys((*links, *props, *bodies[1:], *geoms, WORLD)))
    place = {name: k for k, name in enumerate(names)}
    return Owners(
        names=names,
        of_geom=np.array([place[name] for name in geoms], dtype=np.int64),
        of_body=np.array([place[name] for name in bodies], dtype=np.int64),
    )


def _prop_of(name: str, props: tuple[str, ...]) -> str:
    """The prop's name for what a prop attached, whoever holds it; any other name as it is."""
    whole = name
    while name:
        if name.split("/")[0] in props:
            return name.split("/")[0]
        name = name.partition("/")[2]
    return whole
