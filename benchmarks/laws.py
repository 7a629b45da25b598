"""The lag of the paper's law, and what the modern one does, on real clips.

    UNDERSTUDY_CLIPS=... python benchmarks/laws.py [PATH ...]

Zordan & Hodgins 1999, equation 2: the damping works against the motion itself, so the motion lags
by kd / k at any stiffness.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from understudy import Character, read, score, track

CLIPS = ("cmu_bvh/02_05.bvh", "cmu_bvh/06_02.bvh", "cmu_asfamc/135_04.amc")


def main() -> None:
    folder = Path(os.environ.get("UNDERSTUDY_CLIPS", "."))
    for name in sys.argv[1:] or CLIPS:
        clip = read(folder / name)
        upper = Character.from_clip(clip, plan="upper")
        for law, settings in (
            ("paper", {"damping_time": 0.1}),
            ("paper", {"damping_time": 0.05}),
            ("paper", {"damping_time": 0.1, "stiffness": 1000.0}),
            ("modern", {}),
        ):
            result = score(track(clip, upper, law=law, **settings))
            told = " ".join(f"{k}={v}" for k, v in settings.items())
            print(
                f"{name:28s} {law:6s} {told:36s} lag {result.lag_ms:6.1f} ms  "
                f"error {result.joint_error_deg:5.2f} deg rms  "
                f"without lag {result.joint_error_without_lag_deg:5.2f}  "
                f"hands {result.hands_mm or 0.0:6.1f} mm",
                flush=True,
            )


if __name__ == "__main__":
    main()
