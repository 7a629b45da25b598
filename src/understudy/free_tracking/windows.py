"""Many bodies through one window, on all cores: the only simulation of the search.

Every child starts from its parent's state with offsets and help of its own. The solver's warm start
goes with the state, so a chain of windows is, bit for bit, one contiguous run.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import mujoco
import numpy as np

from understudy.control import EngineState
from understudy.control.compiling import compiled
from understudy.control.guidance_law import POSTURE, posture
from understudy.motion.rotations import Array


class States(NamedTuple):
    """States of several bodies: positions, velocities and the solver's warm start, a row each."""

    qpos: Array
    qvel: Array
    warm: Array

    def chosen(self, rows: Any) -> States:
        """Some of them, in the order of `rows`."""
        return States(*(array[rows] for array in self))

    @classmethod
    def of(cls, data: mujoco.MjData) -> States:
        """The one that `data` is in."""
        return cls(*(np.array(a)[None] for a in (data.qpos, data.qvel, data.qacc_warmstart)))


class Windows:
    """Runs windows of one model on a pool of threads; a context that closes the pool.

    Args:
        model: With all gains.
        layout: Parameters of the law of guidance; see `control.guidance.layout`.
        threads: Any number of them gives the same bits.
    """

    def __init__(self, model: mujoco.MjModel, layout: Array, *, threads: int):
        self.model, self._layout = model, np.ascontiguousarray(layout)
        self._bodies = [mujoco.MjData(model) for _ in range(threads)]
        self._pool = ThreadPoolExecutor(threads)

    def __enter__(self) -> Windows:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown()

    def run(
        self, start: States, parents: Any, offsets: Array, held: Array, ctrl: Array, applied: Array
    ) -> tuple[States, Array]:
        """One window.

        Args:
            start: Of the parents.
            parents: Row of `start` of every child, shape (children,).
            offsets: [rad], shape (children, axes).
            held: Force and torque on the pelvis, shape (children, 6).
            ctrl: Commands laid down for every step, shape (steps, nu).
            applied: Forces laid down for every step, shape (steps, nv).

        Returns:
            The children's states at the end, and their postures there, shape (children, POSTURE).
        """
        from understudy.free_tracking.children import run_children

        run, count = compiled(run_children), len(parents)
        end = States(*(np.empty((count, array.shape[1])) for array in start))
        out = np.empty((count, POSTURE))
        rows = np.ascontiguousarray(parents, np.int64)
        given = (tuple(start), tuple(end))
        cuts = [count * k // len(self._bodies) for k in range(len(self._bodies) + 1)]

        def part(k: int) -> None:
            data = self._bodies[k]
            run(
                *(self.model._address, data._address, cuts[k], cuts[k + 1], rows, *given),
                EngineState.of(data),
                (data.qacc_warmstart, data.ctrl, data.qfrc_applied),
                *(offsets, held, ctrl, applied, self._layout, out),
            )

        list(self._pool.map(part, range(len(self._bodies))))
        return end, out

    def postures(self, qpos: Array, qvel: Array) -> Array:
        """Postures of given states, shape (states, POSTURE)."""
        out, data = np.empty((len(qpos), POSTURE)), self._bodies[0]
        state = EngineState.of(data)
        for k in range(len(qpos)):
            data.qpos[:], data.qvel[:] = qpos[k], qvel[k]
            for stage in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_comVel):
                stage(self.model, data)
            posture(state, self._layout, out[k])
        return out
