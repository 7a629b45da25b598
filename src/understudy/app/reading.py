"""Options every command that reads a clip shares, and the one way a word becomes a clip."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import arg

from understudy.errors import ClipError, InvalidValue

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
        InvalidValue: A sample, with options on how to read a file.
    """
    import understudy as us

    if word.startswith(SAMPLE) or _is_bare(word):
        return _sample(word, reading)
    return us.read(
        word,
        up=reading.up,
        unit=_number_or_word(reading.unit),
        rate=reading.rate,
        t_pose=reading.t_pose,
        asf=reading.asf,
    )


def _sample(word: str, reading: Reading) -> Clip:
    import understudy as us

    name = word.removeprefix(SAMPLE)
    if name == word and name not in us.samples():
        near = difflib.get_close_matches(word, us.samples(), n=1)
        hint = f" Did you mean sample:{near[0]}?" if near else ""
        raise ClipError(word, f"no such file, and no sample of that name.{hint}")
    for option in Reading.__dataclass_fields__:
        if getattr(reading, option) != getattr(Reading(), option):
            flag = option.replace("_", "-")
            raise InvalidValue(f"--{flag} says how to read a file; {word} is a sample.")
    return us.sample(name)


def _is_bare(word: str) -> bool:
    """Whether a word could be a sample's name, and is no file."""
    return word.isidentifier() and not Path(word).exists()


def inputs(words: Sequence[str], *options: object) -> tuple[Path, ...]:
    """The files a command reads, which it must not write: clips, their ASF, a mapping."""
    files = [Path(word) for word in words if not word.startswith(SAMPLE)]
    for given in options:
        files += [Path(file) for name in ("asf", "mapping") if (file := getattr(given, name, None))]
    return tuple(file for file in files if file.exists())


def expanded(words: Sequence[str]) -> tuple[str, ...]:
    """The words, with the motion files in a folder, by name, in place of a folder.

    Raises:
        InvalidValue: A folder holds no motion file.
    """
    found: list[str] = []
    for word in words:
        if word.startswith(SAMPLE) or not Path(word).is_dir():
            found.append(word)
            continue
        files = sorted(path for path in Path(word).iterdir() if _is_motion(path))
        if not files:
            raise InvalidValue(f"{word}: holds no motion file (.bvh, .amc, .npz, .csv).")
        found += [str(path) for path in files]
    return tuple(found)


def _is_motion(path: Path) -> bool:
    """Whether a file's name says that it is a clip, and, for a table, its first lines."""
    kind = path.suffix.lower()
    if not path.is_file() or path.name.startswith(".") or path.name.endswith(".take.npz"):
        return False
    if kind not in (".csv", ".tsv"):
        return kind in (".bvh", ".amc", ".npz")
    from understudy.motion.orientations import is_orientations

    with path.open("rb") as file:
        return is_orientations(file.read(65536).decode("utf-8", "replace"))


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
