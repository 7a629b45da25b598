"""One page to browse a family side by side; a single file, no network, no library."""

from __future__ import annotations

import html
import json
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.family.casting import POSE_RATE
from understudy.family.figure import Bone, heading_of, plain
from understudy.family.member import FLAGS, Member, packed
from understudy.family.table import row
from understudy.motion.files import written

if TYPE_CHECKING:
    from understudy.family.family import Family


def write_page(made: Family, figure: tuple[Bone, ...], path: Path) -> None:
    """Write the page.

    Raises:
        UnderstudyError: The file cannot be written.
    """
    text = json.dumps(_content(made, figure), separators=(",", ":"), allow_nan=False)
    page = resources.files("understudy.family").joinpath("page.html").read_text("utf-8")
    page = page.replace("@TITLE@", html.escape(made.name), 1)
    page = page.replace("@DATA@", text.replace("<", "\\u003c"), 1)
    with written(path) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _content(made: Family, figure: tuple[Bone, ...]) -> dict[str, Any]:
    """What the page's script reads."""
    origin = np.array([*np.asarray(made.unvaried.poses[0, 0, :2], float), 0.0])
    tallest = float(np.percentile(made.unvaried.poses[..., 2].max(axis=1), 99))
    return {
        "name": made.name,
        "rate": POSE_RATE,
        "points": int(made.unvaried.poses.shape[1]),
        "height": max(tallest, 0.2),
        "bones": plain(figure),
        "heading": heading_of(made.unvaried.poses, figure),
        "flags": FLAGS,
        "floor": made.floor,
        "grip": None if made.cast.grip is None else made.cast.grip.to,
        "seed": made.cast.seed,
        "unvaried": _member(made.unvaried, origin),
        "members": [_member(m, origin) for m in made.members],
    }


def _member(member: Member, origin: Any) -> dict[str, Any]:
    figures = row(member)
    costs = {
        joint: [
            _short(own["force_change_n2"]),
            _short(own["torque_change_nm2"]),
            _short(own["torque_rms_unvaried_nm"]),
            _short(own["torque_rms_nm"]),
        ]
        for joint, own in member.cost.items()
    }
    numbers = {k: _short(v) if isinstance(v, float) else v for k, v in figures.items()}
    return {
        **numbers,
        "notes": list(member.notes),
        "statement": member.certificate["statement"],
        "cost": costs,
        "poses": packed(member.poses, origin),
    }


def _short(value: float) -> float:
    return float(f"{value:.4g}")
