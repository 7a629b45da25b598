"""Tracks every clip of a folder and prints what came of it.

    UNDERSTUDY_CLIPS=... python benchmarks/track_clips.py [--plan upper] [--law modern] [NAME ...]

One line a clip, then medians. Refused files print their one line.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

from understudy import Character, read, score, track
from understudy.errors import Diverged, UnderstudyError


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="parts of file names to take")
    parser.add_argument("--plan", default="upper")
    parser.add_argument("--law", default="modern")
    parser.add_argument("--pelvis", default=None)
    arguments = parser.parse_args()
    folder = Path(os.environ["UNDERSTUDY_CLIPS"])
    files = sorted(p for p in folder.rglob("*") if p.suffix in (".bvh", ".amc"))
    rows = []
    for path in files:
        label = str(path.relative_to(folder))
        if arguments.names and not any(n in label for n in arguments.names):
            continue
        try:
            started = time.process_time()
            clip = read(path)
            character = Character.from_clip(clip, plan=arguments.plan)
            take = track(clip, character, law=arguments.law, pelvis=arguments.pelvis)
            result = score(take).as_dict()
            spent = time.process_time() - started
        except Diverged as error:
            print(f"{label:40s} DIVERGED {error}", flush=True)
            continue
        except UnderstudyError as error:
            print(f"{label:40s} refused: {error}", flush=True)
            continue
        rows.append(result)
        print(f"{label:40s} {take.duration:6.2f} s  cpu {spent:5.1f} s  {line(result)}", flush=True)
    if rows:
        print(f"\n{len(rows)} clips, medians: {line(median(rows))}")


def line(row: dict) -> str:
    return "  ".join(f"{k} {row[k]:.2f}" for k in KEYS if isinstance(row.get(k), (int, float)))


def median(rows: list[dict]) -> dict:
    out = {}
    for key in KEYS:
        values = [r[key] for r in rows if isinstance(r.get(key), (int, float))]
        if values:
            out[key] = float(np.median(values))
    return out


KEYS = (
    "joint_error_deg",
    "joint_error_as_read_deg",
    "hands_mm",
    "feet_mm",
    "feet_as_read_mm",
    "root_position_mm",
    "lag_ms",
    "root_force_mean_percent",
    "foot_slide_by_height_mm_s",
    "clip_foot_slide_mm_s",
    "penetration_mm",
)


if __name__ == "__main__":
    main()
