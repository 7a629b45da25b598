"""Drive parameters tuned on one clip, used on others."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from understudy.character import Linkage
from understudy.errors import Diverged
from understudy.fidelity import drive_error
from understudy.motion.clip import Clip
from understudy.performance import driven
from understudy.simulate import quiet_engine, simulate


@dataclass(frozen=True, kw_only=True)
class Transferred:
    """Parameters tuned on one clip used on another: a row of the paper's table 2.

    Attributes:
        clip: Name of the clip.
        kind: Kind of linkage.
        duration: [s].
        travel: Greatest distance of the root from where it began, over ground [units].
        error: Equation 4 [units^2], infinite where the simulation diverged.
        variance: Over joints [units^4].
        gap: Largest joint gap [units].
    """

    clip: str
    kind: str
    duration: float
    travel: float
    error: float
    variance: float
    gap: float


def transferred(
    clips: Sequence[Clip],
    parameters: Mapping[str, Mapping[str, Any]],
    *,
    unit: float | None = None,
    threads: int | None = None,
) -> list[Transferred]:
    """Errors on clips of parameters tuned elsewhere (table 2), clip by clip, kind by kind.

    Args:
        clips: Any clips.
        parameters: Keyword arguments of `driven` by kind of linkage.
        unit: Meters per unit; by default each clip's own.
        threads: Simulations at a time; all cores by default.
    """

    def run(pair: tuple[Clip, str]) -> Transferred:
        clip, kind = pair
        linkage = Linkage.from_clip(clip, kind, unit=unit)  # type: ignore[arg-type]
        ground = clip.root_positions[:, :2]
        away = np.linalg.norm(ground - ground[0], axis=1).max() / linkage.unit
        row = Transferred(
            clip=clip.name,
            kind=kind,
            duration=clip.duration,
            travel=float(away),
            error=np.inf,
            variance=np.inf,
            gap=np.inf,
        )
        try:
            found = drive_error(simulate(driven(clip, linkage, **parameters[kind])))
        except Diverged:
            return row
        return replace(row, error=found.mean, variance=found.variance, gap=found.gap_max)

    pairs = [(clip, kind) for clip in clips for kind in parameters]
    with quiet_engine(), ThreadPoolExecutor(max(1, threads or os.cpu_count() or 1)) as pool:
        return list(pool.map(run, pairs))
