"""What tracking costs over the bare engine loop, and how many times real time it runs.

    python benchmarks/tracking_cost.py [--seconds 10] [--repeats 7]

Both loops advance the same model from the same state with the same controls, in turns, in one
process on one core; the least thread CPU time of each counts. "bare" calls `mj_step(model, data)`
and sets nothing; "tracking" is what `simulate` does after the controls exist (one rollout with all
states recorded); "control" is what computing the controls cost, once per run.
"""

from __future__ import annotations

import argparse
import time

import mujoco
import numpy as np

from understudy import Character, sample
from understudy.performance import tracked
from understudy.simulate import _rollout, open_loop_controls, prepared


def thread_seconds(work) -> float:
    start = time.thread_time()
    work()
    return time.thread_time() - start


def measure(plan: str, seconds: float, repeats: int) -> str:
    clip = sample("gesture" if plan.startswith("upper") else "walk")
    character = Character.from_clip(clip, plan=plan)
    performance = tracked(clip, character)
    model, start = prepared(performance)
    started = time.process_time()
    block = open_loop_controls(performance, model)
    control = (time.process_time() - started) / performance.duration
    steps = min(performance.steps, round(seconds / performance.scene.timestep))
    ctrl = block.ctrl[:steps]
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    states = np.empty((steps + 1, mujoco.mj_stateSize(model, spec)))
    mujoco.mj_getState(model, start, states[0], spec)
    data = mujoco.MjData(model)

    def reset() -> None:
        mujoco.mj_resetData(model, data)
        mujoco.mj_setState(model, data, states[0], spec)

    def loop() -> None:
        # The same controls are in force, set beforehand every 8 steps: setting them is not timed
        # below, so that the bare loop is the engine alone on the same motion.
        for _ in range(8):
            mujoco.mj_step(model, data)

    def bare() -> float:
        reset()
        total = 0.0
        for first in range(0, steps - 7, 8):
            data.ctrl[:] = ctrl[first]
            total += thread_seconds(loop)
        return total / (steps // 8 * 8)

    def tracking() -> float:
        reset()
        return thread_seconds(lambda: list(_rollout(model, data, ctrl, None, states))) / steps

    bare_best = tracking_best = np.inf
    for _ in range(repeats):
        bare_best = min(bare_best, bare())
        tracking_best = min(tracking_best, tracking())
    dt = performance.scene.timestep
    return (
        f"{plan:7s} nv {model.nv:3d}  dt {1e3 * dt:.2f} ms  bare {1e6 * bare_best:6.2f} us/step  "
        f"tracking {1e6 * tracking_best:6.2f} us/step  ratio {tracking_best / bare_best:.3f}  "
        f"{dt / tracking_best:.0f} x real time; "
        f"with control {1 / (tracking_best / dt + control):.0f} x"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--repeats", type=int, default=7)
    arguments = parser.parse_args()
    for plan in ("upper", "upper8", "full", "full16"):
        print(measure(plan, arguments.seconds, arguments.repeats), flush=True)


if __name__ == "__main__":
    main()
