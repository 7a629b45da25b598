"""Drives of the paper's clips: in its units, at its gains."""

from __future__ import annotations

from typing import Any

from understudy.character import Linkage
from understudy.drive_tuning import PAPER_RATE, PAPER_SCALE
from understudy.motion.clip import Clip
from understudy.papers.wilke2017 import published
from understudy.performance import PAPER_GRAVITY, driven
from understudy.simulate import simulate
from understudy.take import Take

# A unit of the BVH conversion of the CMU motions: 0.45 units to the inch [m].
UNIT = 0.0254 / 0.45
GRAVITY = PAPER_GRAVITY * UNIT


def linkage_of(clip: Clip, kind: str, **settings: Any) -> Linkage:
    """A linkage of a clip in the paper's unit."""
    return Linkage.from_clip(clip, kind, unit=UNIT, **settings)  # type: ignore[arg-type]


def published_gains(kind: str, scale: float) -> dict[str, Any]:
    """The published gains as keyword arguments of `driven`."""
    row = published.TABLE_1[kind]
    return {
        "law": "paper",
        "rate": PAPER_RATE,
        "gravity": GRAVITY,
        "scale": scale,
        "gain": row.gain,
        "order": row.order,
        "velocity_scale": row.speed / (scale * PAPER_RATE),
    }


def driven_take(clip: Clip, kind: str = "constrained", **settings: Any) -> Take:
    """A drive at the published K_f of the linkage and the clip's own speed, unless told."""
    weighing = settings.pop("masses", "one")
    locks = settings.pop("locks", ())
    linkage = linkage_of(clip, kind, masses=weighing)
    if locks:
        linkage = linkage.locked(*locks)
    if "law" not in settings:
        settings = published_gains(kind, PAPER_SCALE) | {"velocity_scale": 1.0} | settings
    return simulate(driven(clip, linkage, **settings))
