"""What tracking costs over the bare engine loop, and how many times real time it runs.

    python benchmarks/tracking_cost.py [--seconds 10] [--repeats 7]

Both loops advance the same model through the same states, in turns, in one process on one core;
the least time of each counts. "bare" is the sum of the `mj_step(model, data)` calls alone;
"tracking" is what `simulate` does once the controls exist (rollouts with all states recorded);
"with control" adds the reference, its inverse dynamics and contact forces, computed once per run.
"""

from __future__ import annotations

import argparse
import time

import mujoco
import numpy as np

from understudy import Character, sample
from understudy.control import Controls
from understudy.performance import tracked
from understudy.simulate import open_loop_controls, prepared
from understudy.simulate.gears import rollout


def seconds(work) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def measure(plan: str, duration: float, repeats: int) -> str:
    clip = sample("gesture" if plan.startswith("upper") else "walk")
    character = Character.from_clip(clip, plan=plan)
    performance = tracked(clip, character)
    model, start = prepared(performance)
    started = time.process_time()
    block = open_loop_controls(performance, model)
    control = (time.process_time() - started) / performance.duration
    steps = min(performance.steps, round(duration / performance.scene.timestep))
    ctrl = block.ctrl[:steps]
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    states = np.empty((steps + 1, mujoco.mj_stateSize(model, spec)))
    mujoco.mj_getState(model, start, states[0], spec)
    data = mujoco.MjData(model)

    def reset() -> None:
        mujoco.mj_resetData(model, data)
        mujoco.mj_setState(model, data, states[0], spec)

    def bare() -> float:
        # The same trajectory step for step: controls are set between the timed steps, and what
        # reading the clock costs is taken off.
        reset()
        step, clock, target = mujoco.mj_step, time.perf_counter_ns, data.ctrl
        total = 0
        for row in ctrl:
            target[:] = row
            before = clock()
            step(model, data)
            total += clock() - before
        before = clock()
        for _ in range(10_000):
            clock()
        reading = (clock() - before) / 10_000
        return (total / steps - reading) * 1e-9

    def tracking() -> float:
        reset()
        return seconds(lambda: list(rollout(model, data, Controls(ctrl), states))) / steps

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
