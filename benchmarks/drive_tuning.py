"""Tuning the drive of rigid bodies: errors, cost of the searches, order of the forces.

    UNDERSTUDY_CLIPS=... python benchmarks/drive_tuning.py [--points N]

Prints the figures that Wilke & Semwal 2017 publish beside those measured here. Theirs is 141_15,
19.4 s at 60 Hz; here it is a clip of its length: the named clip, and its beginning backward again
after its end until 19.4 s are full. CPU seconds are those of the process: both cores together.
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from understudy import Linkage, drive_error, driven, read, simulate
from understudy.drive_tuning import tune_drive
from understudy.papers.wilke2017.cast import with_paper_names
from understudy.papers.wilke2017.figures import kick_table
from understudy.papers.wilke2017.published import TABLE_1

SECONDS = 1165 / 60.0
LIMITS = {"independent": 60.0, "skeleton": None, "constrained": 150.0}


def filled(clip, seconds):
    """The clip at 60 Hz, there and back again until it is long enough."""
    clip = clip.resampled(60.0)
    count = round(seconds * 60.0) + 1
    there_and_back = np.concatenate((np.arange(clip.frames), np.arange(clip.frames - 2, 0, -1)))
    frames = np.resize(there_and_back, count)
    return replace(
        clip, rotations=clip.rotations[frames], root_positions=clip.root_positions[frames]
    )


def timed(work):
    """What it gives, its CPU seconds and its wall seconds."""
    cpu, wall = time.process_time(), time.monotonic()
    out = work()
    return out, time.process_time() - cpu, time.monotonic() - wall


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--points", type=int, default=100, help="points of algorithm 1")
    parser.add_argument(
        "--clips", nargs="*", default=["cmu_asfamc/127_02.amc", "cmu_bvh/02_05.bvh"]
    )
    options = parser.parse_args()
    folder = Path(os.environ.get("UNDERSTUDY_CLIPS", "."))
    warm = read(folder / options.clips[0]).trimmed(0.0, 1.0)
    simulate(driven(warm, Linkage.from_clip(warm, "independent"), law="paper", rate=60.0))
    for name in options.clips:
        clip = filled(read(folder / name), SECONDS)
        print(
            f"\n{name}, {clip.duration:.1f} s at 60 Hz, 1 unit = 56.44 mm, gravity 9.81 units/s^2, "
            "scale 1.4286, step 1/60 s, the paper's law"
        )
        for kind, row in TABLE_1.items():
            linkage = Linkage.from_clip(clip, kind)
            found, cpu, wall = timed(lambda k=linkage, c=clip: tune_drive(c, k, method="cma"))
            whole = drive_error(simulate(driven(clip, linkage, **found.parameters)))
            print(
                f"  {kind:12s} CMA-ES      e^2 {found.best.error:.3f} (paper {row.error}) at K_f "
                f"{found.best.gain:.1f}, K_vc {found.best.speed:.1f}, n {found.best.order}; "
                f"{len(found.trials)} simulations, {cpu:.1f} s CPU, {wall:.1f} s; "
                f"largest gap {whole.gap_max:.3f} units",
                flush=True,
            )
            if name != options.clips[0]:
                continue
            points = options.points
            walk, cpu, wall = timed(lambda k=linkage, c=clip, p=points: tune_drive(c, k, points=p))
            limit = f" (goal {LIMITS[kind]:g})" if LIMITS[kind] else ""
            print(
                f"  {kind:12s} algorithm 1 e^2 {walk.best.error:.3f} at K_f {walk.best.gain:.1f}, "
                f"K_vc {walk.best.speed:.1f}, n {walk.best.order}; {len(walk.trials)} simulations, "
                f"{cpu:.1f} s CPU, {wall:.1f} s; for 900: {900 * cpu / len(walk.trials):.1f} s "
                f"CPU{limit}; CMA-ES was there after {found.simulations_to(walk.best.error)} "
                "simulations",
                flush=True,
            )
    kick = folder / "cmu_asfamc" / "135_04.amc"
    if kick.exists():
        _, facts = kick_table(with_paper_names(read(kick)), {})
        print(
            f"\n135_04, RightFoot x 1.2, 200 frames about its greatest speed, K_f 24.19: Spearman "
            f"with table 3's forces {facts['table_3_spearman_force']:.3f}, torques "
            f"{facts['table_3_spearman_torque']:.3f}"
        )


if __name__ == "__main__":
    main()
