"""`understudy samples`: the motions that come with the package."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome, table
from understudy.app.performing import staged
from understudy.errors import InvalidValue

EXAMPLE = "  understudy samples walk gesture --out clips"


@dataclass(frozen=True, kw_only=True)
class Options:
    """List the bundled sample motions, or write the named ones as BVH files.

    Attributes:
        names: Samples to write; all of them with the word all. Without a name they are listed.
        out: Folder for the files.
        json: Print one JSON object.
    """

    names: Positional[
        Annotated[tuple[str, ...], arg(metavar="[NAME ...]", help_behavior_hint="(optional)")]
    ] = ()
    out: Annotated[Path | None, arg(metavar="DIR", help_behavior_hint="(default: here)")] = None
    json: bool = False


def run(options: Options) -> Outcome:
    """List or write."""
    import understudy as us

    if options.out is not None and not options.names:
        raise InvalidValue("--out needs names: say which samples to write, or all.")
    wanted = us.samples() if "all" in options.names else options.names
    clips = {name: us.sample(name) for name in wanted or us.samples()}
    result = {
        name: {"duration_s": clip.duration, "rate_hz": clip.rate, "notes": list(clip.notes)}
        for name, clip in clips.items()
    }
    if not wanted:
        rows = [("sample", "seconds", "what it is")]
        rows += [(n, f"{c.duration:.1f}", c.notes[-1] if c.notes else "") for n, c in clips.items()]
        text = table(rows, right=(1,)) + "\n\nUse one as sample:NAME, or write it with --out."
        return Outcome(result={"samples": result, "files": {}}, text=text)
    files: dict[str, str] = {}
    for name, clip in clips.items():
        with staged(options.out or Path(), name) as (folder, made):
            us.write(clip, folder / f"{name}.bvh")
        files[name] = made["bvh"]
    return Outcome(result={"samples": result, "files": files}, text="\n".join(files.values()))
