"""Which clips stand in for the paper's captures, and the bodies of its children."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from understudy.character import Character
from understudy.character.bodies import child
from understudy.errors import ClipError, UnderstudyError
from understudy.motion.clip import Clip
from understudy.motion.read import read
from understudy.motion.samples import sample

# Captured gestures, best first: a man directs traffic, a wave, talk with both hands, a punch.
GESTURES = ("13_26", "13_18", "wave_hello", "18_08", "02_05")
# The liveliest so many seconds of a longer one are used [s].
LASTS = 8.0
# Of the adult: the paper's child, as tall as 0.6 of 1.75 m.
CHILD_SCALE = 0.6


@dataclass(frozen=True, kw_only=True)
class Cast:
    """The clips.

    Attributes:
        gesture: For figures 1, 6 and 7.
        source: What it was read from: a file's name, or sample:gesture.
        captured: Whether it is a capture.
    """

    gesture: Clip = field(repr=False)
    source: str
    captured: bool


def casting(folder: Path | None, *, seconds: float | None = None) -> Cast:
    """Find a captured gesture in a folder and below it, or take the bundled one.

    Args:
        folder: Where to look; None for the bundled sample.
        seconds: Keep only so much of it [s].

    Raises:
        ClipError: No such folder.
    """
    if folder is not None and not folder.is_dir():
        raise ClipError(str(folder), "no such folder.")
    clip, source = _gesture(folder)
    clip = liveliest(clip, LASTS if seconds is None else seconds)
    return Cast(gesture=clip, source=source, captured=not clip.synthetic)


def _gesture(folder: Path | None) -> tuple[Clip, str]:
    for name in GESTURES if folder is not None else ():
        assert folder is not None
        for ending in ("bvh", "amc"):
            for path in sorted(folder.rglob(f"{name}.{ending}")):
                try:
                    clip = read(path)
                    if Character.from_clip(clip).humanoid:
                        return clip.renamed(path.stem), path.stem
                except UnderstudyError:
                    continue
    return sample("gesture"), "sample:gesture"


def liveliest(clip: Clip, seconds: float) -> Clip:
    """The part of a clip, so many seconds long, in which its joints turn most."""
    if clip.duration <= seconds:
        return clip
    turning = np.abs(np.diff(clip.rotations, axis=0)).sum(axis=(1, 2))
    count = round(seconds * clip.rate)
    whole = np.concatenate(([0.0], np.cumsum(turning)))
    first = int(np.argmax(whole[count:] - whole[:-count]))
    return clip.trimmed(first / clip.rate, first / clip.rate + seconds)


@cache
def paper_child() -> Character:
    """A child 0.6 times as tall as the samples' actor, with a child's proportions."""
    return child(height=CHILD_SCALE * 1.75, mass=17.0)
