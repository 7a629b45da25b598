"""What happens to a body from outside: pushes and thrown balls at given times; open loop."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any

import mujoco
import numpy as np

from understudy.character import Character
from understudy.control.controller import Controls
from understudy.errors import InvalidValue, UnknownName, shown
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """Base of what acts on a scene from outside; its time of action is `time` [s]."""

    time: float

    def __post_init__(self) -> None:
        _positive(self.time, f"{type(self).__name__}: time", "s", zero=True)

    @property
    def begins(self) -> float:
        """When it begins to act [s]."""
        return self.time

    @property
    def pelvis(self) -> None:
        """It has no opinion on what holds the pelvis."""
        return None

    def fitted(self, reference: Clip, body: Character) -> tuple[Disturbance, Clip]:
        """Itself, aimed where it needs to know the motion, and the reference unchanged."""
        return self, reference

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Leave the model as it is."""

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""


@dataclass(frozen=True, kw_only=True)
class Push(Disturbance):
    """A constant force for a short while, at the center of mass of a link or a prop.

    Attributes:
        time: When it begins [s].
        on: The link or prop, by its name in the scene: "chest", "b/chest", "staff".
        impulse: Force times duration [N s], world, 3 numbers.
        duration: [s].
    """

    on: str = "chest"
    impulse: tuple[float, float, float]
    duration: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        _positive(self.duration, "Push: duration", "s")
        object.__setattr__(self, "impulse", _vector(self.impulse, "Push: impulse", "N s"))

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Find the body.

        Raises:
            UnknownName: The scene has no link or prop of that name.
            InvalidValue: It is fixed to the ground.
        """
        if model.body_weldid[_body(model, self.on, "Push")] == 0:
            raise InvalidValue(f"Push: {self.on!r} is fixed; a push would not move it.")

    def controls(self, scene: Scene, model: mujoco.MjModel, times: Array) -> Controls:
        """The force in every step, by how much of the step it covers: the impulse is exact."""
        dt, body = scene.timestep, _body(model, self.on, "Push")
        covered = np.minimum(times + dt, self.time + self.duration) - np.maximum(times, self.time)
        share = np.clip(covered, 0.0, dt) / dt
        pushes = np.zeros((len(times), model.nbody, 6))
        pushes[:, body, :3] = share[:, None] * (np.array(self.impulse) / self.duration)
        return Controls(np.zeros((len(times), model.nu)), pushes=pushes)


@dataclass(frozen=True, kw_only=True)
class Throw(Disturbance):
    """A ball thrown so that it arrives somewhere at a time; until it leaves it is held still.

    Attributes:
        time: When its middle arrives [s], if nothing is in its way.
        ball: Name of a prop with a free joint.
        at: Where to: the name of a link of the character, or a point [m], world, 3 numbers.
        flight: How long it flies [s]; less is faster.
        character: Whose link `at` is.
    """

    ball: str = "ball"
    at: str | tuple[float, float, float] = "chest"
    flight: float = 0.5
    character: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        _positive(self.flight, "Throw: flight", "s")
        if not isinstance(self.at, str):
            object.__setattr__(self, "at", _vector(self.at, "Throw: at", "m"))
        if self.flight > self.time:
            raise InvalidValue(
                f"Throw: a flight of {self.flight:g} s cannot arrive at {self.time:g} s; "
                "let it fly for less or arrive later."
            )

    @property
    def begins(self) -> float:
        """When the ball leaves [s]."""
        return self.time - self.flight

    def fitted(self, reference: Clip, body: Character) -> tuple[Throw, Clip]:
        """Aimed at where the clip has the link when the ball arrives.

        Raises:
            UnknownName: The body has no such link.
        """
        if not isinstance(self.at, str):
            return self, reference
        link = body.link(self.at)
        pose = reference.forward_kinematics()
        frame = min(round(self.time * reference.rate), reference.frames - 1)
        from understudy.motion import rotations as rot

        i = body.index(self.at)
        place = pose.positions[frame, i] + rot.rotate(pose.rotations[frame, i], link.com)
        return replace(self, at=tuple(place.tolist())), reference

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Find the ball.

        Raises:
            UnknownName: The scene has no such prop.
            InvalidValue: It is not loose, or the throw was not aimed.
        """
        joint = int(model.body_jntadr[_body(model, self.ball, "Throw")])
        if joint < 0 or model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_FREE:
            raise InvalidValue(
                f"Throw: {self.ball!r} is fixed; it needs a loose prop, like a Ball."
            )
        if isinstance(self.at, str):
            raise InvalidValue(
                f"Throw: at is {self.at!r}; give it to `tracked` as a task, which aims it, or name "
                "a point."
            )

    def velocity(self, position: Array, gravity: Array) -> Array:
        """Velocity [m/s] to leave with from a position [m], shape (3,)."""
        way = np.array(self.at, float) - position
        return way / self.flight - 0.5 * gravity * self.flight

    def controls(self, scene: Scene, model: mujoco.MjModel, times: Array) -> Controls:
        """Hold the ball against gravity, then give it its momentum within one step."""
        dt, body = scene.timestep, _body(model, self.ball, "Throw")
        joint = int(model.body_jntadr[body])
        dof, mass = int(model.jnt_dofadr[joint]), float(model.body_mass[body])
        position = model.qpos0[model.jnt_qposadr[joint] :][:3]
        step = round((self.time - self.flight) / dt)
        applied = np.zeros((len(times), model.nv))
        applied[:step, dof : dof + 3] = -mass * model.opt.gravity
        if step < len(times):
            # In the step that gives it speed gravity acts already.
            applied[step, dof : dof + 3] = mass * self.velocity(position, model.opt.gravity) / dt
        return Controls(np.zeros((len(times), model.nu)), applied)


def check_times(controllers: Iterable[Any], duration: float) -> None:
    """Refuse what would happen after the end.

    Raises:
        InvalidValue: Says what, and when the end is.
    """
    for one in controllers:
        if isinstance(one, Disturbance) and one.begins >= duration > 0.0:
            raise InvalidValue(
                f"{type(one).__name__}: begins at {one.begins:g} s; the performance lasts "
                f"{duration:g} s."
            )


def check_throws(controllers: Iterable[Any]) -> None:
    """Refuse two throws of one ball: it is held for the one while it flies for the other.

    Raises:
        InvalidValue: Names the ball and the times.
    """
    thrown: dict[str, float] = {}
    for throw in controllers:
        if isinstance(throw, Throw):
            if throw.ball in thrown:
                raise InvalidValue(
                    f"Throw: {throw.ball!r} is thrown to arrive at {thrown[throw.ball]:g} s and at "
                    f"{throw.time:g} s; a ball is thrown once: add another."
                )
            thrown[throw.ball] = throw.time


def _body(model: mujoco.MjModel, name: str, who: str) -> int:
    kind = mujoco.mjtObj.mjOBJ_BODY
    body = mujoco.mj_name2id(model, kind, name) if isinstance(name, str) else -1
    if body <= 0:
        known = [mujoco.mj_id2name(model, kind, k) for k in range(1, model.nbody)]
        raise UnknownName(f"link or prop for {who}", str(name), [n for n in known if n])
    return body


def _positive(value: object, name: str, unit: str, *, zero: bool = False) -> None:
    number = float(value) if isinstance(value, Real) else math.nan
    if not ((number >= 0.0 if zero else number > 0.0) and number < math.inf):
        least = "zero or positive" if zero else "positive"
        raise InvalidValue(f"{name} is {shown(value)} {unit}; it must be {least}.")


def _vector(value: Any, name: str, unit: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(number) for number in value)
    except (TypeError, ValueError):
        raise InvalidValue(
            f"{name} is {shown(value)}; it must be three numbers [{unit}]."
        ) from None
    if not np.isfinite([x, y, z]).all():
        raise InvalidValue(f"{name} is {shown(value)}; it must be finite numbers [{unit}].")
    return x, y, z
