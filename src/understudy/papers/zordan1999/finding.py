"""What was measured of one figure, and the paths that the measurements are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from understudy.evaluate.chart import Chart
from understudy.motion import rotations as rot
from understudy.motion.arm import palm
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.papers.filmstrip import Film
from understudy.papers.sheets import Sheet
from understudy.take import Take

# In sentences; tables say "paper" and "modern".
LAW_NAMES = {"paper": "the paper's law", "modern": "modern law"}


@dataclass(frozen=True, kw_only=True)
class Claim:
    """Something the paper says, and what was found.

    Attributes:
        said: By the paper, in words of ours.
        measured: In one line, with numbers.
        holds: Whether the numbers bear it out.
    """

    said: str
    measured: str
    holds: bool


@dataclass(frozen=True, kw_only=True)
class Strip:
    """Rows of pictures that belong together.

    Attributes:
        alt: What is seen, in words.
        films: The rows.
        scale: See `films_html`.
    """

    alt: str
    films: tuple[Film, ...] = field(repr=False)
    scale: str = "own"


@dataclass(frozen=True, kw_only=True, eq=False)
class Finding:
    """One figure, or a part of one, run again.

    Attributes:
        figure: "4", or "8, staff".
        title: Short.
        setting: How it was made: clip, body, gains; a sentence or two.
        claims: What the paper says, each with what was found.
        charts: The figure's curves.
        strips: Pictures.
        sheets: All numbers.
        facts: Plain numbers worth keeping.
    """

    figure: str
    title: str
    setting: str
    claims: tuple[Claim, ...]
    charts: tuple[Chart, ...] = ()
    strips: tuple[Strip, ...] = field(default=(), repr=False)
    sheets: tuple[Sheet, ...] = ()
    facts: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """With its word: "Figure 4", "Figures 1 and 7"."""
        return f"{'Figures' if ' and ' in self.figure else 'Figure'} {self.figure}"


def hand_path(clip: Clip, side: str = "right") -> Array:
    """Path of the middle of a palm [m], world, of a clip on a character's skeleton, (frames, 3)."""
    joint = f"{side}_wrist"
    pose, i = clip.forward_kinematics(), clip.skeleton.index(joint)
    return pose.positions[:, i] + rot.rotate(pose.rotations[:, i], palm(clip.skeleton, joint))


def hand_of(take: Take, side: str = "right", *, character: int = 0) -> Array:
    """Path of the middle of a palm at every step of a take [m], world, shape (frames, 3)."""
    return hand_path(take.clip(character, rate=take.rate), side)


def at_times(path: Array, times: Array, wanted: Array) -> Array:
    """A path (frames, 3) at other times [s], linear between its own."""
    return np.stack([np.interp(wanted, times, path[:, k]) for k in range(3)], axis=-1)


def speed_of(path: Array, rate: float) -> Array:
    """Speed along a path [m/s], by central differences, shape (frames,)."""
    return np.linalg.norm(np.gradient(path, 1.0 / rate, axis=0), axis=1)


def acceleration_of(path: Array, rate: float) -> Array:
    """Size of the acceleration along a path [m/s^2], by second differences, (frames - 2,)."""
    return np.linalg.norm(np.diff(path, n=2, axis=0), axis=1) * rate * rate


def spread(first: float, last: float, count: int) -> tuple[float, ...]:
    """So many even moments from the first to the last [s]."""
    return tuple(float(t) for t in np.linspace(first, last, count))
