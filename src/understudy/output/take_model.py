"""What a take's model has that its scene does not tell: gains, limits, options of the engine."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from understudy.errors import UnderstudyError, shown

LARGEST = 1e10
"""Beyond this the engine itself calls a state bad (its mjMAXVAL); no number of a take is larger."""
_STEPS = (1e-7, 100.0)  # Of the engine [s].
_OPTIONS: dict[str, range] = {
    "integrator": range(len(mujoco.mjtIntegrator.__members__)),
    "cone": range(len(mujoco.mjtCone.__members__)),
    "jacobian": range(len(mujoco.mjtJacobian.__members__)),
    "solver": range(len(mujoco.mjtSolver.__members__)),
    "iterations": range(1, 100_001),
    "disableflags": range(2**31),
    "enableflags": range(2**31),
}
# Nothing of these is less than nothing.
_NOT_NEGATIVE = {
    *("body_mass", "body_inertia", "body_subtreemass", "dof_armature", "dof_damping"),
    *("dof_frictionloss", "dof_M0", "dof_invweight0", "body_invweight0", "geom_friction"),
    *("geom_size", "geom_rbound", "jnt_stiffness"),
}


def changes(before: mujoco.MjModel, after: mujoco.MjModel) -> dict[str, Any]:
    """Numbers of a model that differ from the scene's, by name."""
    out: dict[str, Any] = {}
    for name in dir(before):
        if name.startswith("_"):
            continue
        old = getattr(before, name)
        if isinstance(old, np.ndarray) and old.dtype.kind == "f" and old.size:
            new = getattr(after, name)
            if new.shape == old.shape and not np.array_equal(old, new):
                out[name] = np.array(new)
    for name in _OPTIONS:
        if getattr(before.opt, name) != getattr(after.opt, name):
            out[f"opt.{name}"] = int(getattr(after.opt, name))
    if before.opt.timestep != after.opt.timestep:
        out["opt.timestep"] = float(after.opt.timestep)
    return out


def set_number(model: mujoco.MjModel, name: Any, value: Any) -> None:
    """Set one number of a model; only such as cannot lead the engine astray.

    Raises:
        UnderstudyError: It is no number of a model, or one that none has.
    """
    option = name.removeprefix("opt.") if isinstance(name, str) else ""
    if name == "opt.timestep":
        low, high = _STEPS
        if not (_number(value) and low <= value <= high):
            raise UnderstudyError(f"{name} is {shown(value)}; it must be {low:g} to {high:g} s.")
        model.opt.timestep = float(value)
        return
    if option in _OPTIONS and option != name:
        allowed = _OPTIONS[option]
        if not (isinstance(value, int) and value in allowed):
            raise UnderstudyError(
                f"{name} is {shown(value)}; it must be a whole number, {allowed[0]} to "
                f"{allowed[-1]}."
            )
        setattr(model.opt, option, int(value))
        return
    held = getattr(model, name, None) if option and not name.startswith("_") else None
    if not (isinstance(held, np.ndarray) and held.dtype.kind == "f"):
        raise UnderstudyError(f"changes {shown(name)} of the model, which is none of its numbers.")
    _check(name, np.asarray(value), held.shape)
    held[:] = value


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _check(name: str, values: np.ndarray, shape: tuple[int, ...]) -> None:
    """Refuse numbers of a model that do not fit, or that no body has."""
    if values.shape != shape:
        raise UnderstudyError(
            f"changes {name!r} of the model to shape {values.shape}, which does not fit {shape}."
        )
    if values.dtype.kind not in "fiu" or not (np.abs(values) <= LARGEST).all():
        raise UnderstudyError(
            f"{name} of the model has values that are not finite, or beyond {LARGEST:g}."
        )
    if name in _NOT_NEGATIVE and (values < 0.0).any():
        raise UnderstudyError(
            f"{name} of the model is {values.min():g} somewhere; it must not be negative."
        )
