"""What output costs: pictures a second by each renderer, and seconds and bytes for every file.

Run: python benchmarks/render.py [CLIP] [--frames N]
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import understudy as us
from understudy.output import contact_sheet, still, write
from understudy.output.gl import backend
from understudy.output.pictures import arranged, drawn
from understudy.output.playback import playback
from understudy.output.renderer import opened

SIZES = ((640, 480), (960, 540), (1280, 720))


def timed(function, *args, **kwargs) -> tuple[float, float]:
    """Wall and CPU seconds of one call."""
    wall, cpu = time.perf_counter(), time.process_time()
    function(*args, **kwargs)
    return time.perf_counter() - wall, time.process_time() - cpu


def renderers(take: us.Take, frames: int) -> None:
    shown = arranged(playback(take), "beside", "follow")
    start = time.perf_counter()
    print(f"OpenGL backend: {backend()} (found out in {time.perf_counter() - start:.2f} s)")
    for name in ("software", "opengl") if backend() else ("software",):
        for width, height in SIZES:
            shot = shown.shot("follow", width / height)
            drawing = opened(
                shown.model,
                width,
                height,
                renderer=name,
                spec=shown.spec,
                samples=0,
                ghost_bodies=shown.ghost_bodies,
            )
            drawn(drawing, shown, shot, 0, "beside")

            def several(drawing=drawing, shot=shot) -> None:
                for k in range(frames):
                    drawn(drawing, shown, shot, k % shown.frames, "beside")

            wall, cpu = timed(several)
            drawing.close()
            print(
                f"{name:9} {width:4} x {height:<4} {frames / wall:6.1f} pictures/s, "
                f"{1000 * cpu / frames:5.0f} ms CPU each"
            )


def files(take: us.Take, folder: Path) -> None:
    for name in ("walk.bvh", "walk.glb", "walk.csv", "walk.npz", "walk.html"):
        wall, cpu = timed(write, take, folder / name)
        size = (folder / name).stat().st_size
        print(f"{name:10} {wall:6.3f} s wall {cpu:6.3f} s CPU {size / 1e6:6.2f} MB")
    for name, function in (
        ("still", lambda: still(take, 0.5 * take.duration, folder / "still.png")),
        ("sheet", lambda: contact_sheet(take, folder / "sheet.png")),
    ):
        wall, cpu = timed(function)
        print(f"{name:10} {wall:6.3f} s wall {cpu:6.3f} s CPU")
    if shutil.which("node"):
        script = Path(__file__).with_name("validate_gltf.js")
        subprocess.run(["node", script, folder / "walk.glb"], check=False)
    else:
        print("glTF validator skipped: there is no node")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("clip", nargs="?", help="a motion file; by default a made walk of 3 s")
    options.add_argument("--frames", type=int, default=10)
    given = options.parse_args()
    if given.clip:
        clip = us.read(given.clip)
    else:
        from understudy.motion.gait import walk

        clip = walk(3.0)
    take = us.track(clip, us.Character.from_clip(clip))
    print(f"{clip.name}: {take.duration:.2f} s, {take.model.nbody - 1} bodies")
    with tempfile.TemporaryDirectory() as folder:
        files(take, Path(folder))
    renderers(take, given.frames)


if __name__ == "__main__":
    main()
