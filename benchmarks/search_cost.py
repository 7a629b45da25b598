"""What the search for a free performance costs, beside the bare engine loop.

    python benchmarks/search_cost.py [CLIP ...] [--seeds 0] [--repeats 5]

For every clip: the seconds of motion that are simulated for one second of it (they do not depend on
the machine), the processor time of a search on one thread, and that of `mujoco.rollout` for as many
steps. The latter performs the take that was found, open loop, before and after the search, in the
same process: what a machine is worth changes from hour to hour, the ratio does not.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np

import understudy as us
from understudy.control import Controls
from understudy.free_tracking.windows import Windows
from understudy.simulate import prepared
from understudy.simulate.gears import rollout


def counted() -> list[int]:
    """A list whose only entry grows by the steps that searches simulate from now on."""
    steps, run = [0], Windows.run

    def counting(self: Windows, *given: Any) -> Any:
        steps[0] += len(given[1]) * len(given[4])
        return run(self, *given)

    Windows.run = counting  # type: ignore[method-assign]
    return steps


def bare(take: us.Take, repeats: int) -> float:
    """Processor time of a step of the bare loop through the take [s], the median."""
    assert take.performance is not None
    model, data = prepared(take.performance)
    states = np.empty((take.frames, 1 + model.nq + model.nv))
    states[0] = np.concatenate(([0.0], data.qpos, data.qvel))
    block = Controls(np.array(take.ctrl[:-1]), np.array(take.qfrc_applied[:-1]))
    times = []
    for _ in range(repeats):
        started = time.process_time()
        for _ in rollout(model, data, block, states):
            pass
        times.append((time.process_time() - started) / (take.frames - 1))
    return float(np.median(times))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("clips", nargs="*", type=Path, help="files; the bundled walk by default")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    clips = {path.name: us.read(path) for path in options.clips} or {"walk": us.sample("walk")}
    start = us.sample("gesture").trimmed(1.0, 1.2)
    us.track(start, us.Character.from_clip(start), pelvis="free", threads=1)  # compiles the laws
    steps = counted()
    rows, before = [], 0.0
    print("clip, seed: simulated s/s, us a step, search CPU-s/s, bare CPU-s/s, ratio")
    for name, clip in clips.items():
        for seed in options.seeds:
            body, done = us.Character.from_clip(clip), steps[0]
            take = us.track(clip, body, pelvis="free", seed=seed, threads=1)
            count, spent = steps[0] - done, take.facts["search_cpu_seconds"]
            after = bare(take, options.repeats)
            loop = count * (0.5 * (before + after) if before else after)
            before = after
            row = np.array([count * take.scene.timestep, spent, loop]) / clip.duration
            rows.append(row)
            print(
                f"{name}, {seed}: {row[0]:.0f}, {1e6 * spent / count:.0f}, {row[1]:.2f}, "
                f"{row[2]:.2f}, {row[1] / row[2]:.2f}",
                flush=True,
            )
    middle = np.median(rows, axis=0)
    print(f"median: {middle[0]:.0f} s/s, {middle[1]:.2f} and {middle[2]:.2f} CPU-s/s")


if __name__ == "__main__":
    main()
