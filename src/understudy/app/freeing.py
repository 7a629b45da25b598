"""A clip tracked with nothing to hold on to, with one seed or several; its search kept on disk."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from understudy.errors import InvalidValue, NotFound, UnderstudyError

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.motion.clip import Clip
    from understudy.take import Take

Found = TypeVar("Found")


def checkpoint(folder: Path, name: str, seed: int) -> Path:
    """Where the search of a clip with a seed is kept."""
    return folder / f"{name}.seed{seed}.search"


def searches(folder: Path, name: str, seeds: range) -> dict[str, str]:
    """The searches of a clip that are kept, by the ending of their file's name."""
    found: dict[str, str] = {}
    for path in sorted(folder.iterdir()) if folder.is_dir() else []:
        middle = path.name.removeprefix(f"{name}.seed").removesuffix(".search")
        ours = path.name == f"{name}.seed{middle}.search" and path.is_file()
        if ours and middle.isdecimal() and int(middle) in seeds:
            found[path.name.removeprefix(f"{name}.")] = str(path)
    return found


def freed(
    clip: Clip,
    character: Character,
    settings: Mapping[str, Any],
    *,
    seeds: int,
    folder: Path,
    name: str,
) -> Take:
    """The take of the first seed that is free, else of the one with the least help.

    Args:
        clip: The clip.
        character: The body.
        settings: Keyword arguments of `understudy.track`; `seed` is the first one tried.
        seeds: Most seeds to try.
        folder: Where the searches are kept; made if need be.
        name: Stem of their files.

    Raises:
        NotFound: No seed came half a second far; names the clip, and the first one's reason.
        UnderstudyError: The first seed failed in another way, and the others failed too.
    """
    import understudy as us

    best, tried = None, 0
    reason: UnderstudyError | None = None
    first = settings.get("seed", 0)
    with there(folder):
        for seed in range(first, first + seeds):
            tried += 1
            kept = checkpoint(folder, name, seed)
            own = {**settings, "seed": seed, "checkpoint": kept}
            try:
                take = resumed(lambda own=own: us.track(clip, character, **own), kept)
            except InvalidValue:
                raise
            except UnderstudyError as error:
                reason = reason or error
                continue
            if best is None or badness(take) < badness(best):
                best = take
            if badness(best)[0] == 0.0:
                break
    if best is None:
        assert reason is not None
        raise NotFound(f"{name}: {reason}") if isinstance(reason, NotFound) else reason
    if seeds > 1:
        best.facts["seeds_tried"] = tried
    return best


@contextlib.contextmanager
def there(folder: Path) -> Iterator[None]:
    """A folder to keep searches in; one that was made for them goes when there are none."""
    made = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        if made:
            with contextlib.suppress(OSError):
                folder.rmdir()


def resumed(search: Callable[[], Found], kept: Path) -> Found:
    """What a search finds that goes on from a file, and keeps itself there.

    A file that is damaged or of another search is begun anew; a line on standard error says what
    became of one that was there.

    Args:
        search: With `kept` as its checkpoint.
        kept: The file.

    Raises:
        InvalidValue: What is there is no file.
        UnderstudyError: What the search raises.
    """
    from understudy.free_tracking import UnusableSearch

    if kept.exists() and not kept.is_file():
        raise InvalidValue(f"{kept}: is no file; the search is to be kept there. Move it away.")
    before = kept.stat().st_mtime_ns if kept.is_file() else None
    try:
        found = search()
    except UnusableSearch:
        print(
            f"{kept}: was damaged or of another clip or other options; the search begins anew.",
            file=sys.stderr,
        )
        old = kept.rename(kept.with_name(f"{kept.name}.old"))
        try:
            return search()
        finally:  # What was there stays until there is something new.
            if kept.exists():
                old.unlink()
            else:
                old.rename(kept)
    if before is not None:
        # A search writes its file after every pass.
        done = kept.is_file() and kept.stat().st_mtime_ns == before
        print(
            f"{kept}: {'this finished search was used again' if done else 'was gone on from'}.",
            file=sys.stderr,
        )
    return found


def badness(take: Take) -> tuple[float, float]:
    """What takes of one clip are ranked by: help, 0 when free, more when it ends early; error."""
    from understudy.evaluate import following

    found = following(take)
    if found.free and found.whole:
        return 0.0, found.joint_position_mm
    early = found.lost_s is not None or not found.whole
    return found.help_percent + (1e3 if early else 1e-9), found.joint_position_mm
