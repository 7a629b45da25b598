"""What a controller is: three kinds, one for each gear of `simulate`.

A controller decides the controls and never steps the engine. Which of the three it is decides how
fast the simulation runs, not what it computes:

1. `OpenLoop` samples its whole reference once and returns one block for the run.
2. `Compiled` is a scalar step function compiled by numba that runs beside the engine's steps.
3. `Callable` is any Python function, asked for its controls once a period.

Several controllers may share a performance. Open-loop blocks are laid down first; the feedback
controllers then change the entries they own, in the order given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, runtime_checkable

import mujoco

from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.scene import Scene


@dataclass(frozen=True, eq=False)
class Controls:
    """A block of controls, one row per physics step.

    Attributes:
        ctrl: Actuator controls, shape (steps, nu).
        applied: Generalized forces added to the servos', shape (steps, nv), or None for none.
        pushes: World force [N] at the center of mass and torque [N m] on every body, shape
            (steps, nbody, 6), or None for none.
    """

    ctrl: Array
    applied: Array | None = None
    pushes: Array | None = None


class EngineState(NamedTuple):
    """What a law sees: views of the engine's arrays after positions and velocities are computed.

    Attributes:
        qpos: Positions, shape (nq,).
        qvel: Velocities, shape (nv,).
        xpos: Body positions [m], world, shape (nbody, 3).
        xquat: Body orientations, wxyz, shape (nbody, 4).
        xipos: Centers of mass of the bodies [m], shape (nbody, 3).
        cvel: Body velocities as the engine has them, shape (nbody, 6): angular [rad/s], then linear
            [m/s] of the point of the body that is at `subtree_com` of its tree's root.
        subtree_com: Center of mass of every body and all outboard of it [m], shape (nbody, 3).
        site_xpos: Site positions [m], shape (nsite, 3).
        sensordata: Sensors; those of forces are one step old.
    """

    qpos: Array
    qvel: Array
    xpos: Array
    xquat: Array
    xipos: Array
    cvel: Array
    subtree_com: Array
    site_xpos: Array
    sensordata: Array

    @classmethod
    def of(cls, data: mujoco.MjData) -> EngineState:
        """Views of the arrays of `data`."""
        return cls(*(getattr(data, name) for name in cls._fields))


@runtime_checkable
class Controller(Protocol):
    """What every controller can do: set up the model it will control, and the first state."""

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Write gains and limits into `model`, a private copy of the scene's."""

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Write the first state of what it controls into `data.qpos` and `data.qvel`."""


@runtime_checkable
class OpenLoop(Controller, Protocol):
    """Gear 1: the whole reference at once."""

    def controls(self, scene: Scene, model: mujoco.MjModel, times: Array) -> Controls:
        """Controls for steps that begin at `times` [s]; entries it does not own are zero."""
        ...


@runtime_checkable
class Compiled(Controller, Protocol):
    """Gear 2: a law in numba, called once a step between the engine's two halves.

    The law is a plain function `law(time, state, ctrl, applied, parameters, memory)`: the time in
    seconds, an `EngineState`, and the step's `ctrl` and `applied` to be changed in place.
    `parameters` and `memory` are float arrays of its own, shape (n,); memory carries state from
    step to step. It may call other plain functions of its module: scalars, tuples and loops that
    numba takes. `simulate` compiles it; nothing else is needed.
    """

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, its parameters, and its memory at time zero."""
        ...


@dataclass(frozen=True, kw_only=True)
class PythonController:
    """Gear 3: any function of time and state.

    Attributes:
        function: `function(time, data) -> None`; it changes `data.ctrl` or `data.qfrc_applied` in
            place.
        period: Time between calls [s]; controls are held in between.
    """

    function: Callable[[float, mujoco.MjData], None]
    period: float = 1.0 / 120.0

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InvalidValue(f"function is {self.function!r}; it must be callable.")
        if not (isinstance(self.period, int | float) and 0.0 < self.period <= 1e3):
            raise InvalidValue(f"period is {self.period!r} s; it must lie in 0 to 1000.")

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Leave the model as it is."""

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""
