"""Performance -> Take: the only place that steps the engine.

Three gears, the fastest the controllers allow:

1. every controller is open loop: one block of controls, run by `mujoco.rollout`;
2. some are compiled laws: one numba loop calls the laws and the engine's `mj_step1`, `mj_step2`;
3. some are Python functions: asked once per period, the engine runs in between.

All three give the same states for the same controls.
"""

from __future__ import annotations

import copy
import os
import time as clock
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import mujoco
import mujoco.rollout
import numpy as np
from tqdm import tqdm

from understudy.character import Character
from understudy.control import (
    Compiled,
    Controls,
    Disturbance,
    Drive,
    OpenLoop,
    PythonController,
    Task,
    Tracking,
)
from understudy.errors import ControllerFailed, Diverged, InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.performance import Performance, tracked
from understudy.simulate.gears import STATE, Raised, compiled, inputs, rollout, stepped
from understudy.take import Take

_BAD = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
    mujoco.mjtWarning.mjWARN_BADCTRL,
)


def prepared(performance: Performance) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The model with every controller's gains, and the first state.

    Raises:
        InvalidValue: A loose prop begins inside something; see `Scene.check_start`.
    """
    model = copy.copy(performance.scene.model)
    for controller in performance.controllers:
        controller.configure(performance.scene, model)
    data = mujoco.MjData(model)
    for part, body in zip(performance.scene.parts, performance.scene.characters, strict=True):
        if isinstance(body, Character):  # Until a controller says otherwise, it stands.
            data.qpos[part.qpos.start : part.qpos.start + 3] = body.links[0].offset
    for controller in performance.controllers:
        controller.start(performance.scene, data)
    with quiet_engine():
        mujoco.mj_forward(model, data)
    performance.scene.check_start(model, data)
    return model, data


def open_loop_controls(
    performance: Performance, model: mujoco.MjModel, *, steps: tuple[int, int] | None = None
) -> Controls:
    """The sum of what the open-loop controllers ask for, one row per step.

    Args:
        performance: Whose controllers.
        model: With their gains.
        steps: First step and the one after the last; by default all.
    """
    first, last = (0, performance.steps) if steps is None else steps
    times = np.arange(first, last, dtype=np.float64) * performance.scene.timestep
    ctrl, applied, pushes = np.zeros((len(times), model.nu)), None, None
    for controller in performance.controllers:
        if isinstance(controller, OpenLoop):
            block = controller.controls(performance.scene, model, times)
            ctrl += block.ctrl
            applied = _added(applied, block.applied)
            pushes = _added(pushes, block.pushes)
    return Controls(ctrl, applied, pushes)


def _added(total: Array | None, block: Array | None) -> Array | None:
    return block if total is None else total if block is None else total + block


def simulate(performance: Performance, *, progress: bool = False) -> Take:
    """Run a performance.

    Args:
        performance: What to run.
        progress: Show a progress bar on standard error.

    Returns:
        The take, one frame per step and the first state.

    Raises:
        Diverged: A state went bad. Carries the time, the link, and the take up to then.
        ControllerFailed: A Python controller raised; carries the time and the take up to then.
        InvalidValue: A controller is of no known kind.
    """
    started = clock.process_time()
    model, data = prepared(performance)
    feedback = []
    for controller in performance.controllers:
        if isinstance(controller, PythonController | Compiled):
            feedback.append(controller)
        elif not isinstance(controller, OpenLoop):
            raise InvalidValue(f"{type(controller).__name__} is not a controller.")
    block = open_loop_controls(performance, model)
    states = np.empty((performance.steps + 1, mujoco.mj_stateSize(model, STATE)))
    mujoco.mj_getState(model, data, states[0], STATE)
    if feedback:  # laws may add forces, and change the block where they do
        applied = (
            np.zeros((performance.steps, model.nv)) if block.applied is None else block.applied
        )
        block = Controls(block.ctrl, np.array(applied), block.pushes)
    if not feedback:
        run = rollout(model, data, block, states)
    elif all(isinstance(controller, Compiled) for controller in feedback):
        run = compiled(performance, model, data, feedback, block, states)
    else:
        run = stepped(performance, model, data, feedback, block, states)
    done, bad = 0, False
    with (
        quiet_engine(),
        tqdm(
            total=performance.steps,
            unit="step",
            delay=2.0,
            disable=None if progress else True,
            leave=False,
        ) as bar,
    ):
        try:
            for done in run:
                bar.update(done - bar.n)
                bad = any(data.warning[kind].number for kind in _BAD)
                if bad or not np.isfinite(states[done]).all():
                    bad = True
                    break
        except Raised as raised:
            step, error = raised.step, raised.__cause__
            take = _take(performance, model, states[: step + 1], block)
            raise ControllerFailed(step * performance.scene.timestep, error, take) from error
    good = _good(states, done) if bad else performance.steps + 1
    take = _take(performance, model, states[:good], block)
    take.facts["cpu_seconds"] = clock.process_time() - started
    if bad:
        raise _diverged(model, take)
    return take


def track(clip: Clip, character: Character, *, progress: bool = False, **settings: Any) -> Take:
    """Make a character perform a clip: `simulate(tracked(clip, character, ...))`.

    Args:
        clip: Any clip; it is repaired, retargeted and set on the ground first.
        character: Any character.
        progress: Show a progress bar on standard error.
        settings: See `understudy.performance.tracked`.

    Raises:
        Diverged: The simulation blew up; carries the take up to then.
    """
    return simulate(tracked(clip, character, **settings), progress=progress)


def simulate_many(
    performances: Sequence[Performance], *, threads: int | None = None
) -> list[Take | Diverged]:
    """Run several performances as one batch on all cores.

    Every take is bitwise what `simulate` gives, on any number of threads.

    Args:
        performances: Open-loop performances of scenes with the same model sizes and duration; or
            performances of any scenes with compiled laws.
        threads: Threads; all cores by default.

    Returns:
        In the order given, a take, or the `Diverged` of a run that went bad.

    Raises:
        InvalidValue: A controller is a Python function, or open-loop runs differ in size.
    """
    if not performances:
        return []
    controllers = [c for p in performances for c in p.controllers]
    if any(not isinstance(c, OpenLoop | Compiled) for c in controllers):
        raise InvalidValue("Only open-loop and compiled controllers run as a batch.")
    if any(isinstance(c, Compiled) for c in controllers):
        return _in_threads(performances, threads or os.cpu_count() or 1)
    started = clock.process_time()
    ready = [prepared(p) for p in performances]
    models = [model for model, _ in ready]
    blocks = [open_loop_controls(p, m) for p, m in zip(performances, models, strict=True)]
    sizes = {(m.nq, m.nv, m.nu, len(b.ctrl)) for m, b in zip(models, blocks, strict=True)}
    if len(sizes) > 1:
        raise InvalidValue("A batch needs models of the same sizes and runs of the same length.")
    steps, nstate = len(blocks[0].ctrl), mujoco.mj_stateSize(models[0], STATE)
    states = np.empty((len(models), steps + 1, nstate))
    for (model, data), row in zip(ready, states, strict=True):
        mujoco.mj_getState(model, data, row[0], STATE)
    spec, controls = _batched(blocks, models[0])
    pool = [
        mujoco.MjData(models[0]) for _ in range(min(threads or os.cpu_count() or 1, len(models)))
    ]
    with quiet_engine():
        record = states[:, 1:].copy()
        mujoco.rollout.rollout(
            models,
            pool,
            states[:, 0],
            controls,
            control_spec=spec,
            initial_warmstart=np.stack([data.qacc_warmstart for _, data in ready]),
            state=record,
            nstep=steps,
        )
    states[:, 1:] = record
    out: list[Take | Diverged] = []
    for performance, model, block, row in zip(performances, models, blocks, states, strict=True):
        good = _good(row, steps) if _went_bad(row) else steps + 1
        take = _take(performance, model, row[:good], block)
        take.facts["cpu_seconds"] = (clock.process_time() - started) / len(performances)
        if good <= steps:
            out.append(_diverged(model, take))
        else:
            out.append(take)
    return out


def _batched(blocks: Sequence[Controls], model: mujoco.MjModel) -> tuple[int, Array]:
    """Inputs of all runs of a batch: what one run has, all have, if only zeros."""
    steps = len(blocks[0].ctrl)
    applied = any(block.applied is not None for block in blocks)
    pushed = any(block.pushes is not None for block in blocks)
    forces, pushes = np.zeros((steps, model.nv)), np.zeros((steps, model.nbody, 6))
    filled = [
        Controls(
            block.ctrl,
            (forces if block.applied is None else block.applied) if applied else None,
            (pushes if block.pushes is None else block.pushes) if pushed else None,
        )
        for block in blocks
    ]
    given = [inputs(block) for block in filled]
    return given[0][0], np.stack([controls for _, controls in given])


def _in_threads(performances: Sequence[Performance], threads: int) -> list[Take | Diverged]:
    """One simulation per thread: the compiled loop holds no lock."""

    def run(performance: Performance) -> Take | Diverged:
        try:
            return simulate(performance)
        except Diverged as error:
            return error

    started = clock.process_time()
    with quiet_engine(), ThreadPoolExecutor(min(threads, len(performances))) as pool:
        out = list(pool.map(run, performances))
    # The clock is the process's: a run alone does not know its own share.
    share = (clock.process_time() - started) / len(performances)
    for result in out:
        take = result.take if isinstance(result, Diverged) else result
        if take is not None:
            take.facts["cpu_seconds"] = share
    return out


def _went_bad(states: Array) -> bool:
    time = states[:, 0]
    return not np.isfinite(states).all() or bool((np.diff(time) <= 0.0).any())


def _diverged(model: mujoco.MjModel, take: Take) -> Diverged:
    """The error that carries a partial take."""
    moment = float(take.times[-1])
    partial = replace(take, diverged=moment)
    return Diverged(moment, _worst(model, take.qvel[-1]), partial)


@contextmanager
def quiet_engine() -> Iterator[None]:
    """Keep the engine from printing warnings and writing its log: the take says what happened."""
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def _good(states: Array, done: int) -> int:
    """Number of leading states before the run went bad (at least the first).

    The engine resets a state that went bad, and a rollout repeats its last record; both show as
    time that does not advance.
    """
    part = states[: done + 1]
    time = part[:, 0]
    stalled = np.flatnonzero(np.diff(time) <= 0.0)
    wild = np.flatnonzero(~(np.isfinite(part).all(axis=1) & (np.abs(part) < 1e8).all(axis=1)))
    last = min([done, *(int(i) for i in stalled[:1]), *(int(i) - 1 for i in wild[:1])])
    return max(1, last)


def _worst(model: mujoco.MjModel, qvel: Array) -> str:
    """Name of the link that moved fastest when the run went bad."""
    if not len(qvel):
        return "the scene"
    body = model.dof_bodyid[int(np.argmax(np.abs(qvel)))]
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, int(body)) or f"body {body}"


def _take(performance: Performance, model: mujoco.MjModel, states: Array, block: Controls) -> Take:
    frames, nq, nv = len(states), model.nq, model.nv

    def held(array: Array | None, *shape: int) -> Array:
        """One row per frame: the last control stands for the last frame too."""
        if array is None or not len(array):
            return np.broadcast_to(0.0, (frames, *shape))
        return array[np.minimum(np.arange(frames), len(array) - 1)]

    references: list[Any] = [None] * len(performance.scene.characters)
    captured: list[Any] = [None] * len(performance.scene.characters)
    facts: dict[str, Any] = {}
    for controller in performance.controllers:
        if isinstance(controller, Tracking | Drive):
            references[controller.character] = controller.reference
            captured[controller.character] = controller.captured
        facts |= getattr(controller, "facts", {})
        if isinstance(controller, Drive):
            facts |= controller.settings(performance.scene)
    asked = [repr(c) for c in performance.controllers if isinstance(c, Task | Disturbance)]
    if asked:
        facts["tasks"] = asked
    return Take(
        scene=performance.scene,
        performance=performance,
        model=model,
        rate=1.0 / performance.scene.timestep,
        times=np.arange(frames, dtype=np.float64) * performance.scene.timestep,
        qpos=states[:, 1 : 1 + nq],
        qvel=states[:, 1 + nq : 1 + nq + nv],
        ctrl=held(block.ctrl, model.nu),
        qfrc_applied=held(block.applied, nv),
        xfrc_applied=held(block.pushes, model.nbody, 6),
        references=tuple(references),
        captured=tuple(captured),
        seed=performance.seed,
        facts=facts,
    )
