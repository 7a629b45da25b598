"""A run with what its laws remembered at every step: a state machine's states, a plan's steps."""

from __future__ import annotations

import mujoco
import numpy as np

from understudy.control import Compiled, Controls
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.simulate import open_loop_controls, prepared
from understudy.simulate.gears import STATE, looped


def remembered(performance: Performance) -> list[Array]:
    """The memory of every law after each step of a run that is the same as `simulate`'s.

    Args:
        performance: Its feedback controllers are compiled laws.

    Returns:
        An array (steps, numbers) for each law, in the controllers' order.
    """
    model, data = prepared(performance)
    block = open_loop_controls(performance, model)
    applied = np.zeros((performance.steps, model.nv))
    if block.applied is not None:
        applied += block.applied
    states = np.empty((performance.steps + 1, mujoco.mj_stateSize(model, STATE)))
    laws = [c for c in performance.controllers if isinstance(c, Compiled)]
    controls = Controls(block.ctrl, applied, block.pushes)
    run, memories = looped(performance, model, data, laws, controls, states)
    rows: list[list[Array]] = [[] for _ in memories]
    for step in range(performance.steps):
        run(step, step + 1)
        for kept, memory in zip(rows, memories, strict=True):
            kept.append(memory.copy())
    return [np.array(kept) for kept in rows]
