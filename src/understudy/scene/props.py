"""What every prop has in common: a name, checked numbers, a body with sites and a touch sensor.

A prop of its own body has the body's name; its geoms, sites and sensor are "<name>/...". Sites are
hidden by their group, as the engine shows groups 0 to 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real
from typing import Any, Protocol

import mujoco
import numpy as np

from understudy.errors import InvalidValue, UnknownName, shown
from understudy.motion.rotations import Array

Color = tuple[float, float, float, float]
WOOD: Color = (0.62, 0.46, 0.31, 1.0)
DARK_WOOD: Color = (0.40, 0.29, 0.21, 1.0)
SEEN, HIDDEN = 1, 3  # groups of what is drawn but touches nothing, and of what is not drawn
# A surface presses back over this time [s]; hands and drums need it short.
STIFFNESS_TIME = 0.002
FRICTION = 0.8
# A prop's touch sensor reaches this far over its surface [m].
REACH = 0.01
# Props touch the ground as soles do: by their affinity to the ground's type only.
_GROUND_BIT = 1


class Prop(Protocol):
    """Anything that adds itself to a scene being built: a drum, a staff, a table."""

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add bodies, geoms and sensors to `spec`, under names of the prop's own."""


def number(
    value: object, name: str, low: float, high: float, unit: str, *, what: str = "prop"
) -> float:
    """A number between two bounds, both allowed.

    Raises:
        InvalidValue: It is none, or lies outside.
    """
    given = float(value) if isinstance(value, Real) and not isinstance(value, bool) else np.nan
    if not low <= given <= high:
        tail = f" {unit}" if unit else ""
        raise InvalidValue(
            f"{name} of {what} is {shown(value)}; it must be a number from {low:g} to "
            f"{high:g}{tail}."
        )
    return given


def vector(
    value: object,
    name: str,
    size: int | tuple[int, ...],
    unit: str,
    *,
    what: str = "prop",
    low: float = -1e4,
    high: float = 1e4,
) -> tuple[float, ...]:
    """So many finite numbers as a tuple.

    Raises:
        InvalidValue: They are others, or not numbers.
    """
    sizes = (size,) if isinstance(size, int) else size
    try:
        out = tuple(float(v) for v in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        out = ()
    if len(out) not in sizes or not all(low <= v <= high for v in out):
        counts = " or ".join(str(n) for n in sizes)
        tail = f" {unit}" if unit else ""
        raise InvalidValue(
            f"{name} of {what} is {shown(value)}; it must be {counts} numbers from {low:g} to "
            f"{high:g}{tail}."
        )
    return out


def direction(value: object, name: str, *, what: str) -> tuple[float, float, float]:
    """Three finite numbers as a unit vector.

    Raises:
        InvalidValue: They are others, or all zero.
    """
    out = np.array(vector(value, name, 3, "", what=what))
    length = float(np.linalg.norm(out))
    if length < 1e-9:
        raise InvalidValue(f"{name} of {what} is {shown(value)}; it must not be zero.")
    # A unit vector stays bitwise what it is, so that a stored prop reads back the same.
    out = out if abs(length - 1.0) < 1e-12 else out / length
    return float(out[0]), float(out[1]), float(out[2])


def check_holder(name: object, what: str) -> None:
    """Refuse what cannot be the name of a link.

    Raises:
        InvalidValue: It is no text.
    """
    if not isinstance(name, str) or not name:
        raise InvalidValue(f"held_by of {what} is {shown(name)}; it must be the name of a link.")


def check_name(name: object) -> None:
    """Refuse a name that the model could not tell from its own.

    Raises:
        InvalidValue: It is no text, empty, has a slash or is kept for the ground.
    """
    if not isinstance(name, str) or not name or not name.isprintable() or "/" in name:
        raise InvalidValue(f"name of a prop is {shown(name)}; it must be a word without '/'.")
    if name in ("world", "ground", "all"):
        raise InvalidValue(f"A prop cannot be named {name!r}: that name is taken.")


def check_surface(friction: object, stiffness_time: object, what: str) -> None:
    """Refuse a surface that no contact can have."""
    number(friction, "friction", 0.0, 10.0, "", what=what)
    number(stiffness_time, "stiffness_time", 0.001, 0.5, "s", what=what)


def turned(heading: float) -> Array:
    """Rotation about the vertical, from +x toward +y [rad], wxyz."""
    return np.array([np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)])


def upright(normal: Sequence[float]) -> Array:
    """The shortest rotation that takes z to a direction, wxyz."""
    quat, axis = np.zeros(4), np.array(normal, float)
    mujoco.mju_quatZ2Vec(quat, axis / np.linalg.norm(axis))
    return quat


def holder(spec: mujoco.MjSpec, name: str, what: str) -> mujoco.MjsBody:
    """The body that holds a prop.

    Raises:
        UnknownName: No such link; the text suggests the nearest.
    """
    body = spec.body(name) if name != "world" else None
    if body is None:
        links = [b.name for b in spec.bodies if b.name and b.name != "world"]
        raise UnknownName(f"link to hold {what}", name, links)
    return body


def grip(spec: mujoco.MjSpec, name: str) -> Array:
    """Where a link holds things, in its frame [m]: the middle of a hand, else its mass center."""
    site = spec.site(name.replace("_hand", "_palm")) if name.endswith("_hand") else None
    return np.array(site.pos if site is not None else spec.body(name).ipos)


def palm_depth(spec: mujoco.MjSpec, name: str) -> float:
    """From where a link holds things down to its surface, along its -z [m]."""
    place = grip(spec, name)[2]
    shapes = (g for g in spec.body(name).geoms if g.group >= HIDDEN)
    depths = [
        float(g.size[0]) - g.pos[2] + place
        for g in shapes
        if g.type == mujoco.mjtGeom.mjGEOM_CAPSULE
    ]
    return min(depths, default=0.0)


def add_body(
    spec: mujoco.MjSpec,
    name: str,
    position: Sequence[float] | Array,
    rotation: Array,
    *,
    parent: mujoco.MjsBody | None = None,
) -> mujoco.MjsBody:
    """A prop's body, on the world or on a link.

    Raises:
        InvalidValue: The name is taken.
    """
    if spec.body(name) is not None:
        raise InvalidValue(f"Two things of the scene are named {name!r}; give the prop another.")
    return (parent or spec.worldbody).add_body(
        name=name, pos=np.asarray(position, float), quat=rotation
    )


def weigh(body: mujoco.MjsBody, mass: float, inertia: Array) -> None:
    """Give a body a mass [kg] and principal inertias [kg m2] about its origin."""
    body.explicitinertial = True
    body.mass, body.inertia = mass, np.asarray(inertia, float)
    body.ipos, body.iquat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])


def add_geom(
    body: mujoco.MjsBody,
    name: str,
    kind: mujoco.mjtGeom,
    size: Sequence[float],
    color: Color,
    *,
    friction: float = FRICTION,
    stiffness_time: float = STIFFNESS_TIME,
    grounded: bool = False,
    **place: Any,
) -> mujoco.MjsGeom:
    """A solid of a prop; it touches nothing by itself but, if `grounded`, the ground."""
    half = np.zeros(3)
    half[: len(size)] = size
    return body.add_geom(
        name=name,
        type=kind,
        size=half,
        rgba=np.array(color),
        contype=0,
        conaffinity=_GROUND_BIT if grounded else 0,
        condim=3,
        friction=[friction, 0.005, 0.0001],
        solref=[stiffness_time, 1.0],
        **place,
    )


def add_site(
    body: mujoco.MjsBody,
    name: str,
    kind: mujoco.mjtGeom = mujoco.mjtGeom.mjGEOM_SPHERE,
    size: Sequence[float] = (0.005,),
    **place: Any,
) -> mujoco.MjsSite:
    """A named place on a prop."""
    half = np.full(3, 0.005)
    half[: len(size)] = size
    return body.add_site(name=name, type=kind, size=half, group=HIDDEN, **place)


def add_touch(spec: mujoco.MjSpec, name: str, site: str) -> None:
    """The sensor "<name>/touch": summed normal force [N] of a prop's contacts within a site."""
    spec.add_sensor(
        name=f"{name}/touch",
        type=mujoco.mjtSensor.mjSENS_TOUCH,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname=site,
    )
