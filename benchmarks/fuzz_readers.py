"""Throws broken motion files at every reader: python benchmarks/fuzz_readers.py [--inputs 200000]

Small files of every format are made, damaged in many ways and read. A reader may accept a file or
refuse it with an `UnderstudyError`; anything else (another exception, a warning, more than 2 s or
1 GiB) is a failure and ends in exit status 1. Where UNDERSTUDY_CLIPS names a folder of real
clips, their first frames are damaged too. The same seed gives the same inputs.
"""

from __future__ import annotations

import argparse
import io
import multiprocessing
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from understudy.errors import UnderstudyError
from understudy.motion import rotations as rot
from understudy.motion.bvh_writer import write_bvh
from understudy.motion.clip import Clip, Conventions
from understudy.motion.figure import LINKS, figure
from understudy.motion.npz import write_npz
from understudy.motion.read import read

SECONDS, MEMORY = 2.0, 1024**3
NASTY = (
    b"nan inf -inf 1e999 -1e308 1e30 0 -0 1e-320 999999999999 -1 2147483648 18446744073709551616 "
    b"0x10 1_0 1,5 1.2.3 --5 +7 1e 5. .5 \xff\xfe { } ROOT JOINT OFFSET CHANNELS MOTION Frames: "
    b"End Site Frame Time: Xposition Zrotation \x00 # : :root :bonedata begin end dof rx axis"
).split(b" ")

Seed = tuple[str, dict[str, bytes]]  # extension read, and the files beside each other


def person(frames: int = 9, seed: int = 0, **options: Any) -> Clip:
    """The standard figure moving smoothly, as a clip."""
    rng = np.random.default_rng(seed)
    skeleton = figure(1.75)
    times = np.arange(frames) / 30.0
    turn = 0.3 * np.sin(times[:, None, None] * 4 + rng.uniform(0, 6, (len(skeleton), 3)))
    path = skeleton.offsets[0] + np.stack((times, 0.1 * times, 0.02 * np.sin(9 * times)), axis=1)
    return Clip(
        skeleton=skeleton,
        rotations=rot.from_rotvec(turn),
        root_positions=path,
        rate=30.0,
        **options,
    )


def orientations_text(clip: Clip) -> bytes:
    """A clip on the standard figure as a table of segment orientations."""
    pose = clip.forward_kinematics()
    rows = ["time,segment,w,x,y,z,px,py,pz"]
    for k, time_ in enumerate(clip.times):
        for j, joint in enumerate(clip.skeleton.names):
            turn = ",".join(f"{v:.6f}" for v in pose.rotations[k, j])
            place = ",".join(f"{v:.4f}" for v in pose.positions[k, j]) if j == 0 else ",,"
            rows.append(f"{time_:.4f},{LINKS[joint]},{turn},{place}")
    return "\n".join(rows).encode() + b"\n"


ASF = b""":version 1.10
:name test
:units
  mass 1.0
  length 0.45
  angle deg
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lfemur
     direction 0.34 -0.94 0
     length 7.6
     axis 0 0 20 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name ltibia
     direction 0.34 -0.94 0
     length 7.3
     axis 0 0 20 XYZ
    dof rx
  end
  begin
     id 3
     name rfemur
     direction -0.34 -0.94 0
     length 7.6
     axis 0 0 -20 XYZ
    dof rx ry rz
  end
  begin
     id 4
     name rtibia
     direction -0.34 -0.94 0
     length 7.3
     axis 0 0 -20 XYZ
    dof rx
  end
:hierarchy
  begin
    root lfemur rfemur
    lfemur ltibia
    rfemur rtibia
  end
"""


def amc_text(frames: int = 6) -> bytes:
    """Joint values for the skeleton above."""
    rows = ["#!OML:ASF x.ASF", ":FULLY-SPECIFIED", ":DEGREES"]
    for k in range(frames):
        rows += [
            f"{k + 1}",
            f"root {0.1 * k:.3f} 16.5 {0.2 * k:.3f} 1.5 {k} -2",
            f"lfemur {3 * k} 1 {-k}",
            f"ltibia {20 + k}",
            f"rfemur {-3 * k} 1 {k}",
            f"rtibia {15 + k}",
        ]
    return "\n".join(rows).encode() + b"\n"


def seeds() -> list[Seed]:
    """Small good files of every format."""
    out: list[Seed] = []
    with tempfile.TemporaryDirectory() as folder:
        for k, dialect in enumerate(
            (
                Conventions(),
                Conventions(up="z", unit=1.0, rotation_orders=("XYZ",) * 18),
                Conventions(unit=0.0254, channels=("ZYXxyz", *["xyzYXZ"] * 17)),
            )
        ):
            target = Path(folder) / "a.bvh"
            write_bvh(person(5 + k, k, conventions=dialect), target)
            out.append((".bvh", {".bvh": target.read_bytes()}))
        target = Path(folder) / "a.npz"
        write_npz(person(), target)
        out.append((".npz", {".npz": target.read_bytes()}))
    body = io.BytesIO()
    np.savez(
        body,
        poses=np.random.default_rng(0).normal(0, 0.2, (7, 66)),
        trans=np.zeros((7, 3)),
        mocap_framerate=np.array(120.0),
        gender=np.array("female"),
    )
    out.append((".npz", {".npz": body.getvalue()}))
    out.append((".csv", {".csv": orientations_text(person(6))}))
    out.append((".amc", {".amc": amc_text(), ".asf": ASF}))
    return out + _real_seeds()


def _real_seeds() -> list[Seed]:
    """The first frames of real clips, where a folder of them is named."""
    out: list[Seed] = []
    folder = Path(os.environ.get("UNDERSTUDY_CLIPS", ""))
    if not os.environ.get("UNDERSTUDY_CLIPS") or not folder.is_dir():
        return out
    for file in sorted(folder.glob("*/*.bvh")):
        lines = file.read_bytes().split(b"\n")
        start = next(k for k, line in enumerate(lines) if line.startswith(b"Frame Time"))
        out.append((".bvh", {".bvh": b"\n".join(lines[: start + 5]) + b"\n"}))
    for file in sorted(folder.glob("*/*.amc"))[:3]:
        start = b"\n".join(file.read_bytes().split(b"\n")[: 3 + 4 * 30]) + b"\n"
        asf = file.with_name(file.stem.split("_")[0] + ".asf")
        out.append((".amc", {".amc": start, ".asf": asf.read_bytes()}))
    return out


def damaged(data: bytes, rng: random.Random, others: list[bytes]) -> bytes:
    """A copy of `data` with one to four random faults."""
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        if not data:
            return data
        at = rng.randrange(len(data))
        span = rng.choice((1, 2, 8, 64, 512))
        kind = rng.randrange(10)
        if kind == 0:
            data = data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]
        elif kind == 1:
            data = data[:at] + data[at + span :]
        elif kind == 2:
            data = data[:at] + data[at : at + span] * rng.choice((2, 3, 50)) + data[at + span :]
        elif kind == 3:
            data = data[:at] + rng.randbytes(span) + data[at:]
        elif kind == 4:
            data = data[:at]
        elif kind == 5:
            data = data[:at] + rng.choice(NASTY) + data[at:]
        elif kind == 6:
            other = rng.choice(others)
            start = rng.randrange(len(other))
            data = data[:at] + other[start : start + 4 * span] + data[at:]
        elif kind == 7:
            data = _word_changed(data, at, rng)
        elif kind == 8:
            lines = data.split(b"\n")
            a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
            lines[a], lines[b] = lines[b], lines[a]
            data = b"\n".join(lines)
        else:
            data = data.replace(*rng.choice(((b"\n", b"\r\n"), (b" ", b"\t"), (b"\n", b" "))))
        data = data[:200_000]
    return data


def _word_changed(data: bytes, at: int, rng: random.Random) -> bytes:
    """The word near a place replaced by a nasty one."""
    match = re.compile(rb"[^\s,]+").search(data, at)
    if match is None:
        return data
    return data[: match.start()] + rng.choice(NASTY) + data[match.end() :]


def damaged_npz(data: bytes, rng: random.Random, others: list[bytes]) -> bytes:
    """An npz file with faults in its zip, or in one member that is then packed properly again."""
    if rng.random() < 0.4:
        return damaged(data, rng, others)
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = archive.namelist()
        victim = rng.choice(names)
        packing = rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))
        with zipfile.ZipFile(out, "w", packing) as copy:
            for name in names:
                content = archive.read(name)
                if name == victim:
                    if rng.random() < 0.1:
                        continue
                    content = _member_changed(content, rng, others)
                copy.writestr(name, content)
    return out.getvalue()


def _member_changed(content: bytes, rng: random.Random, others: list[bytes]) -> bytes:
    kind = rng.randrange(4)
    if kind == 0:
        return damaged(content, rng, others)
    if kind == 1:  # another type of the same width or any
        new = rng.choice((b"|O", b"<f4", b"<i8", b">f8", b"<U9", b"<c16", b"<M8", b"|V8", b"<f99"))
        return re.sub(rb"'descr': '[^']*'", b"'descr': '" + new + b"'", content)
    if kind == 2:
        shape = rng.choice((b"(999999999999,)", b"(10, 10000000000)", b"()", b"(0,)", b"(-1,)"))
        return re.sub(rb"'shape': \([^)]*\)", b"'shape': " + shape, content)
    array = bytearray(content)
    for _ in range(3):
        if len(array) > 136:
            k = rng.randrange(128, len(array) - 8)
            array[k : k + 8] = np.array(rng.choice((np.nan, np.inf, 1e300, 0.0, -1.0))).tobytes()
    return bytes(array)


class _TooSlow(BaseException):
    """Raised by the alarm inside a read; not an Exception, so nothing swallows it."""


def _ring(*_: Any) -> None:
    raise _TooSlow


def fuzz(task: tuple[int, int, int]) -> tuple[Counter[str], float, int, list[str]]:
    """Read inputs number `first` to `last` of a seed.

    Returns:
        Counts by outcome, the longest read [s], the most memory of the process [bytes], failures.
    """
    seed, first, last = task
    base = seeds()
    texts = [data for _, files in base for data in files.values()]
    counts: Counter[str] = Counter()
    failures: list[str] = []
    slowest = 0.0
    signal.signal(signal.SIGALRM, _ring)
    memory_folder = "/dev/shm" if Path("/dev/shm").is_dir() else None
    with tempfile.TemporaryDirectory(dir=memory_folder) as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        for number in range(first, last):
            rng = random.Random(f"{seed}:{number}")
            # Real clips are many; half of the inputs stay with the made ones.
            kind, files = rng.choice(base[:7] if rng.random() < 0.5 else base)
            victim = rng.choice(sorted(files))
            for extension, content in files.items():
                if extension == victim:
                    change = damaged_npz if extension == ".npz" else damaged
                    content = change(content, rng, texts)
                (Path(folder) / f"x{extension}").write_bytes(content)
            start = time.perf_counter()
            signal.setitimer(signal.ITIMER_REAL, SECONDS)
            try:
                clip = read(Path(folder) / f"x{kind}")
                outcome = "read" if np.isfinite(clip.root_positions).all() else "not finite"
            except UnderstudyError as error:
                outcome = "refused" if "\n" not in str(error) else "long text"
            except _TooSlow:
                outcome = "too slow"
            except Exception as error:
                outcome = f"crash {type(error).__name__}"
                where = traceback.extract_tb(error.__traceback__)[-1]
                failures.append(f"{number} {kind}: {error!r} at {where.filename}:{where.lineno}")
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
            if outcome in ("too slow", "long text", "not finite"):
                failures.append(f"{number} {kind}: {outcome}")
            slowest = max(slowest, time.perf_counter() - start)
            counts[f"{kind} {outcome}"] += 1
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return counts, slowest, memory, failures


def main() -> int:
    from tqdm import tqdm

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--inputs", type=int, default=200_000)
    parser.add_argument("--seed", type=int, default=1999)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    block = 1000
    tasks = [
        (options.seed, first, min(first + block, options.inputs))
        for first in range(0, options.inputs, block)
    ]
    counts: Counter[str] = Counter()
    slowest, memory, failures = 0.0, 0, []
    start = time.perf_counter()
    with multiprocessing.Pool(options.workers) as pool:
        for got, slow, most, bad in tqdm(pool.imap_unordered(fuzz, tasks), total=len(tasks)):
            counts += got
            slowest, memory = max(slowest, slow), max(memory, most)
            failures += bad
    for outcome, count in sorted(counts.items()):
        print(f"{outcome:24s} {count:8d}")
    refused = sum(n for outcome, n in counts.items() if outcome.endswith("refused"))
    accepted = sum(n for outcome, n in counts.items() if outcome.endswith("read"))
    print(
        f"{sum(counts.values())} inputs, {accepted} read, {refused} refused, "
        f"{len(failures)} failures; slowest {slowest:.2f} s, most memory {memory / 2**20:.0f} MiB, "
        f"{time.perf_counter() - start:.0f} s in all"
    )
    for failure in failures[:20]:
        print("FAILURE", failure, file=sys.stderr)
    return 1 if failures or memory > MEMORY else 0


if __name__ == "__main__":
    sys.exit(main())
