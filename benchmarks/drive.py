"""What the drive costs over the bare engine loop, and how closely it follows real clips.

    python benchmarks/drive.py [--clips FOLDER] [--repeats 9] [--seconds 10]

Cost: both loops advance the same model through the same states, in turns, in one process on one
core, in compiled code; the least time of each counts. "bare" only calls the engine's step, under
the recorded forces; "driven" is what `simulate` does (the law asked at every step, every state
recorded); "with targets" adds the differences and tables made once per run.

Fidelity: with a folder of CMU clips in BVH (its subfolder cmu_bvh, or itself), the modern law on
every clip of up to 20 s at 60 Hz, joined bodies, and the published law beside it.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import mujoco
import numpy as np

import understudy as us
from understudy.character.linkage import KINDS
from understudy.control import Controls, Drive
from understudy.fidelity import drive_error
from understudy.performance import Performance, driven
from understudy.simulate import prepared, simulate
from understudy.simulate.gears import compiled
from understudy.simulate.loop import step1, step2


def bare_loop():
    import numba

    @numba.njit(nogil=True)
    def loop(model, data, force, forces):
        for step in range(len(forces)):
            force[:] = forces[step]
            step1(model, data)
            step2(model, data)

    return loop


def cost(performance: Performance, loop, repeats: int) -> tuple[float, float, float]:
    """Seconds per step: bare, driven, and of making the targets, per step."""
    take = simulate(performance)
    (drive,) = performance.controllers
    assert isinstance(drive, Drive)
    forces = np.array(take.qfrc_applied[:-1])
    steps = len(forces)
    best = np.full(3, np.inf)
    model, data = prepared(performance)
    states = np.empty((steps + 1, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    ready = drive.feedback(performance.scene, model)

    class Ready:
        def feedback(self, scene, model):
            return ready

    def restart() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:] = take.qpos[0], take.qvel[0]
        mujoco.mj_forward(model, data)

    for _ in range(repeats):
        restart()
        started = time.perf_counter()
        loop(model._address, data._address, data.qfrc_applied, forces)
        best[0] = min(best[0], time.perf_counter() - started)
        assert np.array_equal(data.qpos, take.qpos[-1])
        restart()
        ctrl, applied = np.zeros((steps, model.nu)), np.zeros((steps, model.nv))
        started = time.perf_counter()
        list(compiled(performance, model, data, [Ready()], Controls(ctrl, applied), states))
        best[1] = min(best[1], time.perf_counter() - started)
        assert np.array_equal(data.qpos, take.qpos[-1])
        started = time.perf_counter()
        drive.feedback(performance.scene, model)
        best[2] = min(best[2], time.perf_counter() - started)
    return tuple(best / steps)


def costs(clip: us.Clip, repeats: int) -> None:
    print(f"{clip.name}, {clip.duration:g} s at {clip.rate:g} Hz, {len(clip.skeleton)} bodies")
    print(
        f"{'bodies':12s} {'law':7s} {'step ms':>8s} {'bare us':>8s} {'driven us':>9s} "
        f"{'ratio':>6s} {'x real time':>11s} {'with targets':>12s}"
    )
    loop = bare_loop()
    for kind in KINDS:
        linkage = us.Linkage.from_clip(clip, kind)
        for law in ("paper", "modern"):
            performance = driven(clip, linkage, law=law)
            bare, full, targets = cost(performance, loop, repeats)
            dt = performance.scene.timestep
            print(
                f"{kind:12s} {law:7s} {1e3 * dt:8.2f} {1e6 * bare:8.1f} {1e6 * full:9.1f} "
                f"{full / bare:6.3f} {dt / full:11.0f} {dt / (full + targets):12.0f}",
                flush=True,
            )


def fidelity(folder: Path) -> None:
    print("\njoined bodies, 60 Hz, scale 1; modern law: 9.81 m/s^2; paper's: 9.81 units/s^2")
    print(
        f"{'clip':8s} {'s':>6s} {'modern u^2':>10s} {'mm rms':>7s} {'gap u':>7s} {'gap mm':>7s} "
        f"{'x real time':>11s} {'paper u^2':>10s}"
    )
    worst = np.zeros(2)
    for path in sorted(folder.glob("*.bvh")):
        clip = us.read(path)
        if clip.duration > 20.0:
            print(f"{path.stem:8s} {clip.duration:6.2f} longer than 20 s")
            continue
        linkage = us.Linkage.from_clip(clip)
        performance = driven(clip, linkage, rate=60.0)
        simulate(performance)
        started = time.process_time()
        take = simulate(performance)
        speed = take.duration / (time.process_time() - started)
        error = drive_error(take)
        paper = drive_error(simulate(driven(clip, linkage, law="paper", rate=60.0)))
        worst = np.maximum(worst, (error.mean, error.gap_max))
        print(
            f"{path.stem:8s} {clip.duration:6.2f} {error.mean:10.2e} {error.rms_mm:7.2f} "
            f"{error.gap_max:7.4f} {error.gap_max_mm:7.2f} {speed:11.0f} {paper.mean:10.3f}",
            flush=True,
        )
    print(f"worst: {worst[0]:.2e} units^2 (goal 0.01), gap {worst[1]:.4f} units (goal 0.05)")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clips", default=os.environ.get("UNDERSTUDY_CLIPS", ""))
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--seconds", type=float, default=10.0)
    arguments = parser.parse_args()
    folder = Path(arguments.clips) if arguments.clips else None
    if folder is not None and (folder / "cmu_bvh").is_dir():
        folder = folder / "cmu_bvh"
    if folder is None:
        clip = us.sample("gesture")
    else:
        clip = us.read(sorted(folder.glob("*29_01.bvh") or folder.glob("*.bvh"))[0])
    costs(
        clip.trimmed(0.0, min(arguments.seconds, clip.duration)).resampled(60.0), arguments.repeats
    )
    if folder is not None:
        fidelity(folder)


if __name__ == "__main__":
    main()
