"""Reads a motion clip of any supported format."""

from __future__ import annotations

import os
from pathlib import Path

from understudy.errors import ClipError
from understudy.motion.bvh import read_bvh
from understudy.motion.clip import Clip


def read(
    path: str | os.PathLike[str],
    *,
    up: str | None = None,
    unit: float | str | None = None,
    rate: float | None = None,
    t_pose: str = "auto",
    asf: str | os.PathLike[str] | None = None,
) -> Clip:
    """A motion clip in meters with z up, from a file of any supported format."""
    if Path(path).suffix.lower() == ".bvh":
        return read_bvh(path, up=up, unit=unit, rate=rate, t_pose=t_pose)
    raise ClipError(path, "is of no supported format; save it as BVH.")
