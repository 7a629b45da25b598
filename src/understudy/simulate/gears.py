"""The three gears: each steps a performance and yields how far it has come.

A gear takes the prepared model and data, the block of controls and the array of states, whose first
row is filled; it fills the rest and, where there is feedback, the controls that were applied.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mujoco
import mujoco.rollout
import numpy as np

from understudy.control import Compiled, PythonController
from understudy.motion.rotations import Array
from understudy.performance import Performance

CHUNK = 512  # Steps per engine call: long enough to cost nothing, short enough to show progress.
STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


def rollout(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    ctrl: Array,
    applied: Array | None,
    states: Array,
) -> Iterator[int]:
    """Gear 1: yield the number of steps done after each chunk."""
    spec = int(mujoco.mjtState.mjSTATE_CTRL)
    controls = ctrl
    if applied is not None:
        spec |= int(mujoco.mjtState.mjSTATE_QFRC_APPLIED)
        controls = np.concatenate((ctrl, applied), axis=1)
    warmstart = data.qacc_warmstart.copy()[None]
    steps = len(ctrl)
    for first in range(0, steps, CHUNK):
        last = min(first + CHUNK, steps)
        mujoco.rollout.rollout(
            model,
            data,
            states[first : first + 1],
            controls[None, first:last],
            control_spec=spec,
            initial_warmstart=warmstart,
            state=states[None, first + 1 : last + 1],
            nstep=last - first,
        )
        warmstart = data.qacc_warmstart.copy()[None]
        yield last


def stepped(
    performance: Performance,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    feedback: list[Any],
    ctrl: Array,
    applied: Array | None,
    states: Array,
) -> Iterator[int]:
    """Gear 3: Python functions once per period; compiled laws run uncompiled beside them."""
    assert applied is not None
    dt = performance.scene.timestep
    functions: list[tuple[Callable[[float, mujoco.MjData], None], int]] = []
    for controller in feedback:
        if isinstance(controller, PythonController):
            functions.append((controller.function, max(1, round(controller.period / dt))))
        else:
            functions.append((_as_function(controller, performance, model), 1))
    # What each function set when last asked: which entries, and to what.
    held: list[tuple[Any, Any, Any, Any]] = [(False, 0.0, False, 0.0)] * len(functions)
    for step in range(len(ctrl)):
        mujoco.mj_step1(model, data)
        for i, (function, every) in enumerate(functions):
            data.ctrl[:], data.qfrc_applied[:] = ctrl[step], applied[step]
            if step % every == 0:
                try:
                    function(step * dt, data)
                except Exception as error:
                    raise Raised(step) from error
                held[i] = (
                    data.ctrl != ctrl[step],
                    data.ctrl.copy(),
                    data.qfrc_applied != applied[step],
                    data.qfrc_applied.copy(),
                )
            set_ctrl, to_ctrl, set_applied, to_applied = held[i]
            ctrl[step] = np.where(set_ctrl, to_ctrl, ctrl[step])
            applied[step] = np.where(set_applied, to_applied, applied[step])
        data.ctrl[:], data.qfrc_applied[:] = ctrl[step], applied[step]
        mujoco.mj_step2(model, data)
        mujoco.mj_getState(model, data, states[step + 1], STATE)
        if (step + 1) % CHUNK == 0 or step + 1 == len(ctrl):
            yield step + 1


class Raised(Exception):
    """A controller's function raised an exception at a step."""

    def __init__(self, step: int):
        self.step = step


def _as_function(
    controller: Compiled, performance: Performance, model: mujoco.MjModel
) -> Callable[[float, mujoco.MjData], None]:
    law, parameters, memory = controller.feedback(performance.scene, model)
    law = getattr(law, "py_func", law)

    def function(time: float, data: mujoco.MjData) -> None:
        law(
            time,
            data.qpos,
            data.qvel,
            data.xpos,
            data.cvel,
            data.ctrl,
            data.qfrc_applied,
            parameters,
            memory,
        )

    return function


@functools.cache
def engine_steps() -> tuple[Any, Any]:
    """The engine's `mj_step1` and `mj_step2` as C functions of two addresses."""
    folder = Path(mujoco.__path__[0])
    patterns = ("libmujoco*.so*", "libmujoco*.dylib", "mujoco.dll")
    path = next(path for pattern in patterns for path in sorted(folder.glob(pattern)))
    library = ctypes.CDLL(str(path))
    for function in (library.mj_step1, library.mj_step2):
        function.argtypes, function.restype = [ctypes.c_void_p, ctypes.c_void_p], None
    return library.mj_step1, library.mj_step2


@functools.cache
def _compiled_loop(law: Any) -> Any:
    """One numba loop around a law and the engine; it holds no lock, so threads run in parallel."""
    import numba

    step1, step2 = engine_steps()

    @numba.njit(nogil=True)
    def loop(model, data, first, last, dt, arrays, parameters, memory, ctrl, applied, out):  # type: ignore[no-untyped-def]
        qpos, qvel, xpos, cvel, act, control, force = arrays
        nq, nv, na = qpos.size, qvel.size, act.size
        for step in range(first, last):
            step1(model, data)
            law(step * dt, qpos, qvel, xpos, cvel, ctrl[step], applied[step], parameters, memory)
            control[:] = ctrl[step]
            force[:] = applied[step]
            step2(model, data)
            out[step + 1, 0] = (step + 1) * dt
            out[step + 1, 1 : 1 + nq] = qpos
            out[step + 1, 1 + nq : 1 + nq + nv] = qvel
            out[step + 1, 1 + nq + nv : 1 + nq + nv + na] = act

    return loop


@functools.cache
def _in_sequence(laws: tuple[Any, ...]) -> Any:
    """Several laws as one, each with its own stretch of parameters and memory."""
    import numba

    first, rest = laws[0], laws[1:]
    if not rest:

        @numba.njit
        def last_law(time, qpos, qvel, xpos, cvel, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
            first(time, qpos, qvel, xpos, cvel, ctrl, applied, parameters[0], memory[0])

        return last_law
    following = _in_sequence(rest)

    @numba.njit
    def law(time, qpos, qvel, xpos, cvel, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
        first(time, qpos, qvel, xpos, cvel, ctrl, applied, parameters[0], memory[0])
        following(time, qpos, qvel, xpos, cvel, ctrl, applied, parameters[1:], memory[1:])

    return law


def compiled(
    performance: Performance,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    feedback: list[Any],
    ctrl: Array,
    applied: Array | None,
    states: Array,
) -> Iterator[int]:
    """Gear 2: laws and engine in one compiled loop."""
    parts = [controller.feedback(performance.scene, model) for controller in feedback]
    loop = _compiled_loop(_in_sequence(tuple(law for law, _, _ in parts)))
    parameters = tuple(np.ascontiguousarray(p, float) for _, p, _ in parts)
    memory = tuple(np.array(m, float) for _, _, m in parts)
    arrays = (
        data.qpos,
        data.qvel,
        data.xpos,
        data.cvel,
        data.act,
        data.ctrl,
        data.qfrc_applied,
    )
    address = (model._address, data._address)
    for first in range(0, len(ctrl), CHUNK):
        last = min(first + CHUNK, len(ctrl))
        loop(
            *address,
            first,
            last,
            performance.scene.timestep,
            arrays,
            parameters,
            memory,
            ctrl,
            applied,
            states,
        )
        yield last
