"""`understudy fetch`: real motions by name, from their public sources."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome, table
from understudy.app.performing import staged
from understudy.errors import InvalidValue

EXAMPLE = "  understudy fetch cmu/02_01 --out clips"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Download named motions from their public sources, or list the names.

    Each is checked against a known checksum and kept in the user's cache; the terms of its owners
    are printed.

    Attributes:
        names: Motions to download. Without a name they are listed.
        out: Folder to copy the files to.
        json: Print one JSON object.
    """

    names: Positional[
        Annotated[tuple[str, ...], arg(metavar="[NAME ...]", help_behavior_hint="(optional)")]
    ] = ()
    out: Annotated[
        Path | None, arg(metavar="DIR", help_behavior_hint="(default: leave them in the cache)")
    ] = None
    json: bool = False


def run(options: Options) -> Outcome:
    """List or download."""
    import understudy as us
    from understudy.motion import fetch as sources

    if options.out is not None and not options.names:
        raise InvalidValue("--out needs names: say which motions to download.")
    known = {name: sources.source(name) for name in options.names or sources.fetchable()}
    listed = {name: {"motion": s.motion, "terms": s.terms} for name, s in known.items()}
    if not options.names:
        rows = [("motion", "MB", "what it is")]
        rows += [(name, f"{s.size / 1e6:.1f}", s.motion) for name, s in known.items()]
        return Outcome(result={"motions": listed, "files": {}}, text=table(rows, right=(1,)))
    files = {name: placed(us.fetch(name), options.out) for name in options.names}
    terms = dict.fromkeys(s.terms for s in known.values())
    text = "\n".join([*files.values(), "", *terms])
    return Outcome(result={"motions": listed, "files": files}, text=text)


def placed(file: Path, folder: Path | None) -> str:
    """Copy a file into a folder, if one is given; its final path."""
    if folder is None:
        return str(file)
    with staged(folder, file.stem) as (inside, _):
        shutil.copy(file, inside / file.name)
    return str(folder / file.name)
