"""Reads one BVH file with several libraries: python benchmarks/read_bvh.py [--frames 10000]

The file is generated: 31 joints, 96 channels, 6 decimals. Three times are taken for each library,
in turns, best of several: to the library's own first result (pybvh and pymotion stop at tables of
angles; this package has then turned axes and units and looked for a T-pose and a wrong rate), to
the local rotations as quaternions, and to the world positions of every joint in every frame. The
positions are compared. Libraries that are not installed are left out.
"""

from __future__ import annotations

import argparse
import platform
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from understudy.motion.bvh import read_bvh
from understudy.motion.bvh_writer import write_bvh
from understudy.motion.clip import Clip, Conventions
from understudy.motion.rotations import from_rotvec
from understudy.motion.skeleton import Skeleton

JOINTS = 31
Positions = np.ndarray[Any, Any]  # file units and axes, shape (frames, joints, 3)


def generated(path: Path, frames: int) -> None:
    """Write a file of a branching body of 31 joints that moves smoothly."""
    rng = np.random.default_rng(0)
    parents = (-1, *(max(0, k - 1 if k % 6 else k - 6) for k in range(1, JOINTS)))
    times = np.arange(frames)[:, None, None] / 120.0
    phase = rng.uniform(0.0, 6.3, (JOINTS, 3))
    clip = Clip(
        skeleton=Skeleton(
            names=tuple(f"joint{k}" for k in range(JOINTS)),
            parents=parents,
            offsets=rng.uniform(-0.3, 0.3, (JOINTS, 3)),
        ),
        rotations=from_rotvec(1.2 * np.sin(3.0 * times + phase)),
        root_positions=np.sin(times[:, 0] + phase[0]),
        rate=120.0,
        conventions=Conventions(up="z", unit=0.01, rotation_orders=("ZXY", "ZYX", "XYZ") * 11),
    )
    write_bvh(clip, path)


Calls = tuple[Callable[[], Any], Callable[[], Any], Callable[[], Positions]]


def ours(path: Path) -> Calls:
    def positions() -> Positions:
        # Axes and unit as in the file, so that numbers compare.
        return read_bvh(path, up="z", unit=1.0, t_pose="keep").forward_kinematics().positions

    return lambda: read_bvh(path), lambda: read_bvh(path).rotations, positions


def with_pybvh(path: Path) -> Calls:
    import pybvh

    return (
        lambda: pybvh.read_bvh_file(path, world_up="+z"),
        lambda: pybvh.read_bvh_file(path, world_up="+z").to_quat(),
        lambda: np.asarray(pybvh.read_bvh_file(path, world_up="+z").joint_positions()),
    )


def with_pymotion(path: Path) -> Calls:
    from pymotion.io.bvh import BVH
    from pymotion.ops.skeleton import fk

    def load() -> Any:
        bvh = BVH()
        bvh.load(str(path))
        return bvh

    def positions() -> Positions:
        rotations, places, parents, offsets, *_ = load().get_data()
        return fk(rotations, places[:, 0], offsets, parents)[0]

    return load, lambda: load().get_data(), positions


def with_bvhio(path: Path) -> Calls:
    import bvhio

    def load() -> Any:
        return bvhio.readAsHierarchy(str(path))

    def positions() -> Positions:
        # bvhio poses one frame at a time: every 100th frame shows the agreement.
        root = load()
        joints = {joint.Name: joint for joint, _, _ in root.layout()}
        frames = range(0, _frames(path), 100)
        out = np.full((_frames(path), JOINTS, 3), np.nan)
        for frame in frames:
            root.loadPose(frame)
            out[frame] = [list(joints[f"joint{k}"].PositionWorld) for k in range(JOINTS)]
        return out

    return load, load, positions  # its joints hold quaternions


def _frames(path: Path) -> int:
    with path.open() as file:
        return next(int(line.split()[1]) for line in file if line.startswith("Frames"))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    makers = {
        "understudy": ours,
        "pybvh": with_pybvh,
        "upc-pymotion": with_pymotion,
        "bvhio (FK of 1 % of frames)": with_bvhio,
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "generated.bvh"
        generated(path, options.frames)
        print(
            f"{options.frames} frames x {3 + 3 * JOINTS} channels, "
            f"{path.stat().st_size / 1e6:.1f} MB; Python {platform.python_version()}, "
            f"NumPy {np.__version__}, {platform.machine()}; best of {options.repeats}, "
            "processor seconds"
        )
        runs = {}
        for name, make in makers.items():
            try:
                runs[name] = make(path)
            except ImportError as error:
                print(f"{name}: not installed ({error}), left out")
        best = {name: [np.inf] * 3 for name in runs}
        found: dict[str, Positions] = {}
        for round_ in range(options.repeats):
            for name, calls in runs.items():
                if round_ and best[name][2] > 3.0:
                    continue  # once is enough for the slow ones
                for k, call in enumerate(calls):
                    start = time.process_time()
                    result = call()
                    best[name][k] = min(best[name][k], time.process_time() - start)
                found[name] = result
    mine, reference = best["understudy"], found["understudy"]
    titles = ("first result", "quaternions", "positions")
    print(f"{'':28s}" + "".join(f"{title:>18s}" for title in titles) + f"{'difference':>14s}")
    for name, times in best.items():
        cells = "".join(f"{t:9.3f} s{t / own:6.1f}x" for t, own in zip(times, mine, strict=True))
        difference = np.nanmax(np.abs(found[name] - reference)) * 0.01
        print(f"{name:28s}{cells}{difference:12.1e} m")


if __name__ == "__main__":
    main()
