"""Runs for searches: a performance with a judge, a law that only watches, and may end it early.

The judge keeps its sums in its own memory and sets the first number of it when it has seen enough
(a fall). Nothing is kept of the states, and the loop holds no lock: run one trial per thread.
"""

from __future__ import annotations

import mujoco
import numpy as np

from understudy.control import Compiled, Controls
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.simulate import open_loop_controls, prepared
from understudy.simulate.gears import STATE, looped

# Steps between looks at the judge's verdict.
_CHUNK = 200


def judged(performance: Performance, judge: Compiled) -> tuple[Array, list[Array]]:
    """Run a performance until its end or the judge's.

    Args:
        performance: Its feedback controllers are compiled laws.
        judge: A law besides; its memory begins with a flag that it sets to end the run.

    Returns:
        The judge's memory, and the memories of the performance's own laws.
    """
    model, data = prepared(performance)
    block = open_loop_controls(performance, model)
    given = block.applied
    applied = np.zeros((performance.steps, model.nv)) if given is None else np.array(given)
    block = Controls(block.ctrl, applied, block.pushes)
    states = np.empty((performance.steps + 1, mujoco.mj_stateSize(model, STATE)))
    laws = [c for c in performance.controllers if isinstance(c, Compiled)]
    run, memories = looped(performance, model, data, [*laws, judge], block, states)
    for first in range(0, performance.steps, _CHUNK):
        run(first, min(first + _CHUNK, performance.steps))
        if memories[-1][0] != 0.0 or not np.isfinite(memories[-1]).all():
            break
    return memories[-1], memories[:-1]
