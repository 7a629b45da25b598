"""The three gears: each steps a performance and yields how far it has come.

A gear takes the prepared model and data, the block of controls and the array of states, whose first
row is filled; it fills the rest and, where there is feedback, the controls that were applied.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import mujoco
import mujoco.rollout
import numpy as np

from understudy.control import Compiled, Controls, EngineState, PythonController
from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.performance import Performance

# Steps per engine call: long enough to cost nothing, short enough to show progress.
CHUNK, COMPILED_CHUNK = 512, 4096
STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS


def inputs(block: Controls) -> tuple[int, Array]:
    """What a rollout is given: which of the engine's inputs, and their values by step."""
    spec, columns = int(mujoco.mjtState.mjSTATE_CTRL), [block.ctrl]
    if block.applied is not None:
        spec |= int(mujoco.mjtState.mjSTATE_QFRC_APPLIED)
        columns.append(block.applied)
    if block.pushes is not None:
        spec |= int(mujoco.mjtState.mjSTATE_XFRC_APPLIED)
        columns.append(block.pushes.reshape(len(block.ctrl), -1))
    return spec, columns[0] if len(columns) == 1 else np.concatenate(columns, axis=1)


def rollout(
    model: mujoco.MjModel, data: mujoco.MjData, block: Controls, states: Array
) -> Iterator[int]:
    """Gear 1: yield the number of steps done after each chunk."""
    spec, controls = inputs(block)
    warmstart = data.qacc_warmstart.copy()[None]
    steps = len(controls)
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
    block: Controls,
    states: Array,
) -> Iterator[int]:
    """Gear 3: Python functions once per period; compiled laws run uncompiled beside them."""
    ctrl, applied, pushes = block.ctrl, block.applied, block.pushes
    assert applied is not None
    dt = performance.scene.timestep
    functions: list[tuple[Callable[[float, mujoco.MjData], None], int]] = []
    for controller in feedback:
        if isinstance(controller, PythonController):
            functions.append((controller.function, max(1, round(controller.period / dt))))
        else:
            functions.append((_as_function(controller, performance, model, data), 1))
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
        if pushes is not None:
            data.xfrc_applied[:] = pushes[step]
        mujoco.mj_step2(model, data)
        mujoco.mj_getState(model, data, states[step + 1], STATE)
        if (step + 1) % CHUNK == 0 or step + 1 == len(ctrl):
            yield step + 1


class Raised(Exception):
    """A controller's function raised an exception at a step."""

    def __init__(self, step: int):
        self.step = step


def _as_function(
    controller: Compiled, performance: Performance, model: mujoco.MjModel, data: mujoco.MjData
) -> Callable[[float, mujoco.MjData], None]:
    law, parameters, memory = controller.feedback(performance.scene, model)
    law = getattr(law, "py_func", law)
    state, memory = EngineState.of(data), np.array(memory, float)

    def function(time: float, data: mujoco.MjData) -> None:
        law(time, state, data.ctrl, data.qfrc_applied, parameters, memory)

    return function


def compiled(
    performance: Performance,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    feedback: list[Any],
    block: Controls,
    states: Array,
) -> Iterator[int]:
    """Gear 2: laws and engine in one compiled loop; it holds no lock, so threads run in parallel.

    Raises:
        InvalidValue: More laws than the loop has places for.
    """
    run, _ = looped(performance, model, data, feedback, block, states)
    for first in range(0, len(block.ctrl), COMPILED_CHUNK):
        last = min(first + COMPILED_CHUNK, len(block.ctrl))
        run(first, last)
        yield last


def looped(
    performance: Performance,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    feedback: list[Any],
    block: Controls,
    states: Array,
) -> tuple[Callable[[int, int], None], list[Array]]:
    """A function that runs steps `first` to `last` of gear 2, and every law's memory as it changes.

    Raises:
        InvalidValue: More laws than the loop has places for.
    """
    from understudy.control.compiling import compiled_law
    from understudy.simulate import loop

    if len(feedback) > loop.MOST_LAWS:
        raise InvalidValue(
            f"{len(feedback)} compiled laws in one performance; there is room for {loop.MOST_LAWS}."
        )
    parts = [controller.feedback(performance.scene, model) for controller in feedback]
    laws = [compiled_law(law) for law, _, _ in parts]
    steps_of: Any = loop.one if len(laws) == 1 else loop.several
    if len(laws) > 1:
        laws += [compiled_law(loop.idle)] * (loop.MOST_LAWS - len(laws))
    parameters_at, parameters = _joined([p for _, p, _ in parts])
    memory_at, memory = _joined([np.array(m, float) for _, _, m in parts])
    assert block.applied is not None
    steps = len(block.ctrl)
    pushes = np.zeros((steps, 0)) if block.pushes is None else block.pushes.reshape(steps, -1)

    def run(first: int, last: int) -> None:
        rest = (
            *(model._address, data._address, first, last, performance.scene.timestep),
            *(parameters_at, parameters, memory_at, memory),
            *(EngineState.of(data), data.act, data.ctrl, data.qfrc_applied, data.xfrc_applied),
            *(block.ctrl, block.applied, pushes, states),
        )
        steps_of(*laws, rest)

    return run, [memory[a:b] for a, b in pairwise(memory_at)]


def _joined(rows: list[Array]) -> tuple[Any, Array]:
    """Rows of numbers as one, and where each begins and the last ends."""
    flat = [np.ascontiguousarray(row, float).ravel() for row in rows]
    at = np.cumsum([0, *(len(row) for row in flat)], dtype=np.int64)
    return at, flat[0] if len(flat) == 1 else np.concatenate(flat)
