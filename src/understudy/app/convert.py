"""`understudy convert`: read a clip, edit it, write it in another format."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome
from understudy.app.reading import Reading, clip_from, inputs
from understudy.errors import InvalidValue
from understudy.motion.files import same_file

if TYPE_CHECKING:
    from understudy.motion.clip import Clip

EXAMPLE = "  understudy convert walk.bvh half_speed.glb --speed 0.5 --trim 0.5:2.0"


@dataclass(frozen=True, kw_only=True)
class Options(Reading):
    """Read a clip, edit it if asked, and write it in another format.

    Edits happen in this order: trim, mirror, speed, resample.

    Attributes:
        source: A motion file, or sample:NAME.
        target: The file to write; its ending picks the format (.bvh, .glb, .npz, .csv).
        trim: Keep the part from START to END.
        mirror: Exchange left and right.
        speed: Play this many times as fast.
        resample: Frames per second to write.
        json: Print one JSON object.
    """

    source: Positional[Annotated[str, arg(metavar="IN")]]
    target: Positional[Annotated[Path, arg(metavar="OUT")]]
    trim: Annotated[str | None, arg(metavar="START:END", help_behavior_hint="(seconds)")] = None
    mirror: bool = False
    speed: Annotated[float, arg(metavar="TIMES")] = 1.0
    resample: Annotated[float | None, arg(metavar="HZ", help_behavior_hint="(default: none)")] = (
        None
    )
    json: bool = False


def run(options: Options) -> Outcome:
    """Convert one file."""
    import understudy as us

    for source in inputs([options.source], options):
        if same_file(source, options.target):
            raise InvalidValue(
                f"{options.target}: is the file to be read; give the copy another name."
            )
    clip = edited(clip_from(options.source, options), options)
    us.write(clip, options.target)
    result: dict[str, Any] = {
        "clip": options.source,
        "written": str(options.target),
        "joints": len(clip.skeleton),
        "frames": clip.frames,
        "rate_hz": clip.rate,
        "duration_s": clip.duration,
        "notes": list(clip.notes),
    }
    text = [
        f"{options.target}: {len(clip.skeleton)} joints, {clip.frames} frames at {clip.rate:g} Hz, "
        f"{clip.duration:.2f} s"
    ]
    text += [f"  {note}" for note in clip.notes]
    return Outcome(result=result, text="\n".join(text))


def edited(clip: Clip, options: Options) -> Clip:
    """The clip after the edits the options ask for."""
    if options.trim is not None:
        clip = clip.trimmed(*span(options.trim))
    if options.mirror:
        clip = clip.mirrored()
    if options.speed != 1.0:
        clip = clip.retimed(options.speed)
    if options.resample is not None:
        clip = clip.resampled(options.resample)
    return clip


def span(text: str) -> tuple[float, float | None]:
    """Start and end [s] of "START:END"; either may be left out."""
    start, colon, end = text.partition(":")
    try:
        if not colon:
            raise ValueError
        return float(start or 0.0), float(end) if end else None
    except ValueError:
        raise InvalidValue(f"--trim is {text!r}; write START:END in seconds, as 0.5:2.0.") from None
