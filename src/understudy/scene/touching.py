"""What collides besides the ground: explicit contact pairs between the parts that are named.

Only named parts cost anything. A link touches with the shapes that are seen, so that a palm is as
thick as it looks; a foot with its soles, on which it also stands.

A hand at 3 m/s goes 6 mm in a step of 2 ms, so it would be that deep before it is first seen to
touch. The engine's speculative contacts stop it at the surface, but only shapes that go farther in
a step than they are thick; a palm therefore has two thin plates under it. Together with the
distance from which surfaces press, a stroke ends within 2 mm (`benchmarks/drum.py`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Literal

import mujoco
import numpy as np

from understudy.character import Character, Linkage
from understudy.errors import InvalidValue, UnknownName, shown
from understudy.motion.rotations import Array
from understudy.scene import props

# Surfaces press from where they get in one step at this speed [m/s]: 2 mm at a step of 2 ms.
_PRESSING_SPEED = 1.0
# Part of the needed force a contact gives at once, and at a depth of 1 mm.
_IMPEDANCE = (0.99, 0.999, 0.001, 0.5, 2.0)
DEEP = 0.02  # a loose prop that begins deeper than this in something is there by mistake [m]
_PLATE = 0.002  # half thickness of a palm's plates [m]
# Along a hand, the plates' ends; across it, their half width over the hand's.
_KNUCKLES, _WIDTH = (0.0, 0.30, 0.97), 0.8

Contacts = tuple[tuple[str, str], ...] | Literal["all"]


@dataclass(frozen=True, kw_only=True)
class _Side:
    """One thing that can touch.

    Attributes:
        name: As the user says it.
        character: Number of the character it is a link of, or None for a prop.
        geoms: Names of its geoms in the model.
        apart: Names of what it never touches: neighbors it is joined to.
        fixed: Whether it cannot move.
        friction, stiffness_time: Of its surface.
    """

    name: str
    character: int | None
    geoms: tuple[str, ...]
    apart: frozenset[str] = frozenset()
    fixed: bool = False
    friction: float = props.FRICTION
    stiffness_time: float = props.STIFFNESS_TIME


def checked(contacts: object, names: Iterable[str]) -> Contacts:
    """The contacts of a scene as pairs of names that exist.

    Raises:
        InvalidValue: They are neither "all" nor pairs of two different names.
        UnknownName: A name is of no link and no prop; the text suggests the nearest.
    """
    if isinstance(contacts, str):
        if contacts != "all":
            raise InvalidValue(f"contacts is {contacts!r}; it must be pairs of names, or 'all'.")
        return "all"
    if not isinstance(contacts, Sequence):
        raise InvalidValue(f"contacts is {shown(contacts)}; it must be pairs of names, or 'all'.")
    valid, out = tuple(names), []
    for pair in contacts:
        good = not isinstance(pair, str) and isinstance(pair, Sequence) and len(pair) == 2
        if not (good and all(isinstance(name, str) for name in pair)):
            raise InvalidValue(f"A pair of contacts is {shown(pair)}; it must be two names.")
        for name in pair:
            if name not in valid:
                raise UnknownName("link or prop", name, valid)
        if pair[0] == pair[1]:
            raise InvalidValue(f"contacts has {pair[0]!r} touch itself; name two parts.")
        out.append((pair[0], pair[1]))
    return tuple(out)


def link_names(characters: Sequence[Any], prefixes: Sequence[str]) -> list[str]:
    """Names of every link of every character, as the model has them."""
    return [
        prefix + name
        for character, prefix in zip(characters, prefixes, strict=True)
        for name in (
            character.names
            if isinstance(character, Linkage)
            else [link.name for link in character.links]
        )
    ]


def add_pairs(
    spec: mujoco.MjSpec,
    contacts: Contacts,
    characters: Sequence[Any],
    prefixes: Sequence[str],
    things: Sequence[Any],
) -> None:
    """Add the contact pairs to a scene in which everything else is attached.

    Raises:
        InvalidValue: A pair that can never touch, because both are fixed or are joined.
    """
    sides: dict[str, _Side] = {}
    for k, (character, prefix) in enumerate(zip(characters, prefixes, strict=True)):
        for side in _links(spec, k, character, prefix):
            sides[side.name] = side
    for prop in things:
        side = _prop(spec, prop, sides)
        if side is not None:
            sides[side.name] = side
    if contacts == "all":
        chosen = [pair for pair in combinations(sides.values(), 2) if _may_touch(*pair)]
    else:
        named = {tuple(sorted(pair)): pair for pair in contacts}
        chosen = [(sides[a], sides[b]) for a, b in named.values()]
        for a, b in chosen:
            _refuse(a, b)
    plated = _plated(spec, characters, prefixes, {side.name for pair in chosen for side in pair})
    for a, b in chosen:
        _pair(spec, a, b, plated)
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SPECULATIVE)


def _plated(
    spec: mujoco.MjSpec, characters: Sequence[Any], prefixes: Sequence[str], touching: set[str]
) -> dict[str, tuple[str, ...]]:
    """Add thin plates to the palms of hands that touch; names of the plates by hand."""
    out = {}
    for character, prefix in zip(characters, prefixes, strict=True):
        for link in getattr(character, "links", ()):
            name = prefix + link.name
            palm = next((s for s in link.shapes if s.kind == "mesh" and s.density > 0), None)
            if name in touching and (link.role or "").endswith("_wrist") and palm is not None:
                out[name] = _add_plates(spec.body(name), name, palm.vertices)
    return out


def _add_plates(body: mujoco.MjsBody, name: str, corners: Array) -> tuple[str, ...]:
    """Two thin boxes flush with the underside of a hand that points along its y axis.

    Args:
        body: The hand.
        name: Its name.
        corners: Of the visible hand, in its frame [m], shape (n, 3).
    """
    side = 1.0 if corners[:, 1].mean() > 0 else -1.0
    width = float(np.abs(corners[:, 0]).max())
    under = corners[(np.abs(corners[:, 0]) < 0.2 * width) & (corners[:, 2] < 0.0)]
    along = side * under[:, 1]
    order = np.argsort(along)
    knots = np.array(_KNUCKLES) * float(along.max())
    lows = np.interp(knots, along[order], under[order, 2])
    names = []
    for k in range(2):
        step = np.array([0.0, side * (knots[k + 1] - knots[k]), lows[k + 1] - lows[k]])
        length = float(np.linalg.norm(step))
        middle = np.array([0.0, side * (knots[k] + knots[k + 1]), lows[k] + lows[k + 1]]) / 2.0
        tilt = np.arctan2(side * step[2], side * step[1])
        up = np.array([0.0, -np.sin(tilt), np.cos(tilt)])
        plate = body.add_geom(
            name=f"{name}_plate{k}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[_WIDTH * width, 0.5 * length, _PLATE],
            pos=middle + _PLATE * up,
            quat=[np.cos(tilt / 2), np.sin(tilt / 2), 0.0, 0.0],
            contype=0,
            conaffinity=0,
            mass=0.0,
            group=props.HIDDEN,
        )
        names.append(plate.name)
    return tuple(names)


def _links(spec: mujoco.MjSpec, number: int, character: Any, prefix: str) -> Iterable[_Side]:
    if isinstance(character, Linkage):
        for name in character.names:
            geoms = tuple(geom.name for geom in spec.body(prefix + name).geoms)
            yield _Side(name=prefix + name, character=number, geoms=geoms)
        return
    for link in character.links:
        near = {character.links[link.parent].name} if link.parent >= 0 else set()
        near |= {other.name for other in character.links if _parent(character, other) == link.name}
        yield _Side(
            name=prefix + link.name,
            character=number,
            geoms=tuple(f"{prefix}{link.name}_{k}" for k in _touching(link)),
            apart=frozenset(prefix + name for name in near),
        )


def _parent(character: Character, link: Any) -> str | None:
    return character.links[link.parent].name if link.parent >= 0 else None


def _touching(link: Any) -> list[int]:
    """Numbers of the shapes a link touches props and other bodies with."""
    foot = (link.role or "").endswith(("_ankle", "_ball"))
    hand = (link.role or "").endswith("_wrist")
    shapes = list(enumerate(link.shapes))
    if foot:
        return [k for k, shape in shapes if shape.use != "visible"]
    solid = [
        k
        for k, shape in shapes
        if shape.use == "visible" and (shape.density > 0 or (hand and shape.kind == "capsule"))
    ]
    return solid or [k for k, shape in shapes if shape.use == "visible"] or [k for k, _ in shapes]


def _prop(spec: mujoco.MjSpec, prop: Any, sides: Mapping[str, _Side]) -> _Side | None:
    name = getattr(prop, "name", None)
    if not isinstance(name, str) or spec.body(name) is None:
        return None
    body, held = spec.body(name), getattr(prop, "held_by", None)
    apart = frozenset({held, *sides[held].apart}) if held else frozenset()
    return _Side(
        name=name,
        character=None,
        geoms=tuple(geom.name for geom in body.geoms if geom.group == 0),
        apart=apart,
        fixed=not held and not body.joints,
        friction=getattr(prop, "friction", props.FRICTION),
        stiffness_time=getattr(prop, "stiffness_time", props.STIFFNESS_TIME),
    )


def _may_touch(a: _Side, b: _Side) -> bool:
    """Whether "all" takes in a pair: two links of one character are left out."""
    same = a.character is not None and a.character == b.character
    return not (same or (a.fixed and b.fixed) or b.name in a.apart or a.name in b.apart)


def _refuse(a: _Side, b: _Side) -> None:
    if a.fixed and b.fixed:
        raise InvalidValue(f"contacts pairs {a.name!r} and {b.name!r}, which are both fixed.")
    if b.name in a.apart or a.name in b.apart:
        raise InvalidValue(
            f"contacts pairs {a.name!r} and {b.name!r}, which are joined and always overlap."
        )


def _pair(spec: mujoco.MjSpec, a: _Side, b: _Side, plates: Mapping[str, tuple[str, ...]]) -> None:
    """Pairs of all geoms of two sides, with the stiffer surface and the greater friction."""
    time = max(min(a.stiffness_time, b.stiffness_time), 2.0 * spec.option.timestep)
    friction = max(a.friction, b.friction)
    for one in (*a.geoms, *plates.get(a.name, ())):
        for two in (*b.geoms, *plates.get(b.name, ())):
            spec.add_pair(
                name=f"{one}~{two}",
                geomname1=one,
                geomname2=two,
                condim=3,
                friction=[friction, friction, 0.005, 0.0001, 0.0001],
                solref=[time, 1.0],
                solimp=_IMPEDANCE,
                margin=_PRESSING_SPEED * spec.option.timestep,
            )


def loose_bodies(model: mujoco.MjModel, things: Sequence[Any]) -> set[int]:
    """Body numbers of the props that have a free joint."""
    out = set()
    for prop in things:
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, getattr(prop, "name", ""))
        joint = int(model.body_jntadr[body]) if body > 0 else -1
        if joint >= 0 and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            out.add(body)
    return out


def name_of(model: mujoco.MjModel, body: int, geom: int) -> str:
    """Name of a body, or of a geom of the world."""
    kinds = mujoco.mjtObj
    if body == 0:
        return (mujoco.mj_id2name(model, kinds.mjOBJ_GEOM, geom) or "world").partition("/")[0]
    return mujoco.mj_id2name(model, kinds.mjOBJ_BODY, body) or f"body {body}"
