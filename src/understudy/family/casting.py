"""Which variation each member of a family gets, and whether the family fits on this machine."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from understudy.errors import InvalidValue, expect
from understudy.performance import Performance
from understudy.variations import PRESETS, Grip, Together, Variation, preset

MOST = 100_000
POSE_RATE = 15.0  # Hz; what the page and the sheet show
# Bytes: of a number in BVH text, of a GLB file's body, of a certificate.
_BVH_NUMBER, _GLB_BODY, _CERTIFICATE = 11, 400_000, 12_000


@dataclass(frozen=True, kw_only=True)
class Part:
    """What one member is to perform.

    Attributes:
        index: From 0.
        name: Stem of its files.
        kind: The preset or other alternative it took, or "varied".
        variation: Everything drawn.
    """

    index: int
    name: str
    kind: str
    variation: Together


@dataclass(frozen=True, kw_only=True)
class Casting:
    """How members are drawn: member i depends on the seed and on i, not on how many there are.

    Attributes:
        seed: Seed of all draws.
        turns: Alternatives that members take in turn.
        common: What every member gets besides.
        grip: See `Grip`; None leaves the performance's own.
    """

    seed: int
    turns: tuple[Variation, ...]
    common: tuple[Variation, ...] = ()
    grip: Grip | None = None

    def part(self, index: int) -> Part:
        """The part of one member."""
        rng = np.random.default_rng([self.seed, index])
        grip = () if self.grip is None else (self.grip,)
        own = (self.turns[index % len(self.turns)],) if self.turns else ()
        drawn = Together(*(v.drawn(rng) for v in (*grip, *own, *self.common)))
        kind = (getattr(own[0], "name", "") if own else "") or "varied"
        return Part(index=index, name=f"{index:03d}_{kind}", kind=kind, variation=drawn)

    def as_dict(self) -> dict[str, Any]:
        """Plain values that tell one casting from another."""
        return {
            "seed": self.seed,
            "turns": [v.as_dict() for v in self.turns],
            "common": [v.as_dict() for v in self.common],
            "grip": None if self.grip is None else self.grip.as_dict(),
        }


def casting(
    seed: int,
    variations: str | Variation | Sequence[str | Variation] | None,
    common: Variation | Sequence[Variation],
    grip: float | tuple[float, float] | None,
    *,
    linkage: bool = False,
) -> Casting:
    """The casting asked for; without any variation, all presets in turn.

    A linkage gets the presets of linkages.

    Raises:
        UnknownName: No preset of that name.
        InvalidValue: A seed that is none.
    """
    if not 0 <= seed < 2**63:
        raise InvalidValue(f"seed is {seed}; it must be zero or a positive whole number.")
    variations = (variations,) if isinstance(variations, str | Variation) else variations
    common = (common,) if isinstance(common, Variation) else common
    if variations is None:
        variations = () if common else tuple(PRESETS)
    turns = tuple(preset(v, linkage=linkage) if isinstance(v, str) else v for v in variations)
    for one in (*turns, *common):
        expect(one, Variation, "a variation", "a preset's name or a variation such as Limp")
    if not turns and not common:
        raise InvalidValue("Nothing is to be varied; name presets or give variations.")
    slider = None if grip is None else Grip(to=grip)
    return Casting(seed=seed, turns=turns, common=tuple(common), grip=slider)


def check_variations(performance: Performance, cast: Casting, count: int) -> None:
    """Refuse what some member could not do, before any runs: each alternative is tried once.

    Raises:
        UnknownName: A joint or link that the body does not have.
        InvalidValue: An amount or time range that does not fit.
    """
    for index in range(min(count, max(1, len(cast.turns)))):
        cast.part(index).variation(performance)


def check_size(performance: Performance, count: int, jobs: int, out: Path | None) -> None:
    """Refuse families too large for the disk or the memory at hand.

    Raises:
        InvalidValue: Says how much it would take, and how much there is.
    """
    if not 1 <= count <= MOST:
        raise InvalidValue(f"count is {count}; it must lie in 1 to {MOST}.")
    if jobs < 1:
        raise InvalidValue(f"jobs is {jobs}; it must be at least 1.")
    need, have = memory_needed(performance, count, jobs), _free_memory()
    if have is not None and need > have:
        raise InvalidValue(
            f"A family of {count} on {jobs} threads needs about {_gb(need)} of memory; {_gb(have)} "
            "are free. Ask for fewer, or trim the clip."
        )
    if out is None:
        return
    need, have = disk_needed(performance, count), _free_disk(out)
    if need > have:
        raise InvalidValue(
            f"A family of {count} needs about {_gb(need)} on disk; {_gb(have)} are free in {out}. "
            "Ask for fewer, or trim the clip."
        )


def memory_needed(performance: Performance, count: int, jobs: int) -> int:
    """Bytes of memory a family takes at most, about."""
    model = performance.scene.model
    take = performance.steps * 8 * (model.nq + model.nv + model.nu) * 4
    return jobs * take + 6 * count * _poses(performance)


def disk_needed(performance: Performance, count: int) -> int:
    """Bytes on disk a family takes, about."""
    captured = getattr(performance.controllers[0], "captured", None)
    reference = getattr(performance.controllers[0], "reference", None)
    rate = reference.rate if reference is not None else 60.0
    frames = performance.duration * rate + 1
    joints = len(captured.skeleton) if captured is not None else performance.scene.model.nbody
    motion = frames * (3 * joints * _BVH_NUMBER + 16 * performance.scene.model.nbody)
    return int(count * (motion + _GLB_BODY + _CERTIFICATE + 3 * _poses(performance)))


def _poses(performance: Performance) -> int:
    frames = int(performance.duration * POSE_RATE) + 1
    return frames * 2 * performance.scene.model.nbody * 3 * 4


def _free_disk(out: Path) -> int:
    folder = out.absolute()
    while not folder.exists():
        folder = folder.parent
    return shutil.disk_usage(folder).free


def _free_memory() -> int | None:
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def _gb(size: float) -> str:
    return f"{size / 1e9:.3g} GB"
