"""Options every command that reads a clip shares, and the one way a word becomes a clip."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import arg

if TYPE_CHECKING:
    from understudy.motion.clip import Clip

SAMPLE = "sample:"

AsInFile = "(default: as in the file)"


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How to read a clip.

    Attributes:
        up: Vertical axis of the file.
        unit: Meters per file unit, or cm, m, inch, cmu.
        rate: Frames per second of the file, when its header is wrong or it has none.
        t_pose: A leading T-pose frame: drop it when found, keep it, or drop it always.
        asf: Skeleton of an AMC file.
    """

    up: Annotated[
        Literal["x", "y", "z"] | None, arg(metavar="{x,y,z}", help_behavior_hint=AsInFile)
    ] = None
    unit: Annotated[str | None, arg(metavar="UNIT", help_behavior_hint=AsInFile)] = None
    rate: Annotated[float | None, arg(metavar="HZ", help_behavior_hint=AsInFile)] = None
    t_pose: Literal["auto", "keep", "drop"] = "auto"
    asf: Annotated[
        Path | None, arg(metavar="FILE", help_behavior_hint="(default: found beside the AMC)")
    ] = None


def clip_from(word: str, reading: Reading) -> Clip:
    """Read the clip a word names: a file, `sample:NAME`, or a sample's bare name.

    Raises:
        ClipError: The file is missing or cannot be read.
        UnknownName: No such sample; the text names the nearest one.
    """
    import understudy as us

    if word.startswith(SAMPLE):
        return us.sample(word.removeprefix(SAMPLE))
    if is_bare_sample(word):
        return us.sample(word)
    return us.read(
        word,
        up=reading.up,
        unit=_number_or_word(reading.unit),
        rate=reading.rate,
        t_pose=reading.t_pose,
        asf=reading.asf,
    )


def is_bare_sample(word: str) -> bool:
    """Whether a word names a bundled sample and no file."""
    import understudy as us

    return word in us.samples() and not Path(word).exists()


def stem(word: str) -> str:
    """Name for the files made from a clip argument: the sample's name or the file's stem."""
    return word.removeprefix(SAMPLE) if word.startswith(SAMPLE) else Path(word).stem


def _number_or_word(unit: str | None) -> float | str | None:
    if unit is None:
        return None
    try:
        return float(unit)
    except ValueError:
        return unit
