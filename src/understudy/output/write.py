"""One function that writes a take or a clip to any kind of file, by the file's extension."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from understudy.errors import InvalidValue, expect, shown
from understudy.motion.clip import Clip

if TYPE_CHECKING:
    from understudy.take import Take

_Path = str | PathLike[str]


def write(thing: Take | Clip, *paths: _Path, character: int = 0) -> None:
    """Write a take or a clip to files; what each gets follows from its extension.

    =========  ===================================================================
    .bvh       the motion, to be read again; of a take, the simulated one, on the
               skeleton of the clip it came from (see `on_source_skeleton`)
    .glb       the motion on the character's skeleton, skinned with its shapes
    .csv       joint positions and angles on the character's skeleton, for spreadsheets
    .npz       a clip's arrays; of a take, all of it (`load_take` reads it)
    .html      a page that plays it in 3D, beside the reference (`us.write_report` adds
               scores and plots)
    .mp4 .gif  a video of the same
    .png       a sheet of twelve moments, reference above simulated
    =========  ===================================================================

    Args:
        thing: The take or clip.
        paths: Where to; missing folders are made. Either a whole file appears or none.
        character: Which of a take's characters .bvh, .glb and .csv are about.

    Raises:
        InvalidValue: An extension not listed; nothing is written then.
        MissingExtra: A video or picture needs a package that is not installed.
        UnderstudyError: A file cannot be written.
    """
    count = 1
    if not isinstance(thing, Clip):
        from understudy.take import Take

        expect(thing, Take, "thing", "a Take or a Clip")
        count = len(thing.scene.characters)
    if not paths:
        raise InvalidValue('write needs at least one path, as write(take, "walk.bvh").')
    for path in paths:
        expect(path, (str, PathLike), "path", "the name of a file")
    if not (isinstance(character, Integral) and 0 <= character < count):
        raise InvalidValue(
            f"character is {shown(character)}; this {type(thing).__name__.lower()} has {count}, "
            "counted from 0."
        )
    jobs = [(_writer(path), path) for path in paths]
    for job, path in jobs:
        job(thing, path, character)


def extensions() -> tuple[str, ...]:
    """The extensions that `write` knows, with their dots."""
    return tuple(_WRITERS)


def _writer(path: _Path) -> Callable[[Any, _Path, int], None]:
    kind = Path(path).suffix.lower()
    if kind not in _WRITERS:
        raise InvalidValue(
            f"{path}: cannot write {kind or 'a file without an extension'}; "
            f"known are {', '.join(_WRITERS)}."
        )
    return _WRITERS[kind]


def _clip(thing: Take | Clip, character: int) -> Clip:
    return thing if isinstance(thing, Clip) else thing.clip(character)


def on_source_skeleton(take: Take, character: int = 0) -> Clip:
    """The simulated motion on the full skeleton of the clip that the character was made from.

    Fingers and other joints that the body lacks move as in the clip. Another body (an adult, a
    child) has no such skeleton: its motion stays on its own, as `take.clip()` has it.
    """
    from understudy.character.retarget import restored

    body, source, motion = (
        take.scene.characters[character],
        take.captured[character],
        take.clip(character),
    )
    if source is None or source.skeleton != getattr(body, "source", None):
        return motion
    return restored(motion, source.repaired(), body)


def _bvh(thing: Take | Clip, path: _Path, character: int) -> None:
    from understudy.motion.bvh_writer import write_bvh

    write_bvh(thing if isinstance(thing, Clip) else on_source_skeleton(thing, character), path)


def _csv(thing: Take | Clip, path: _Path, character: int) -> None:
    from understudy.motion.table import write_csv

    write_csv(_clip(thing, character), path)


def _npz(thing: Take | Clip, path: _Path, character: int) -> None:
    if isinstance(thing, Clip):
        from understudy.motion.npz import write_npz

        write_npz(thing, path)
    else:
        from understudy.output.take_file import save_take

        save_take(thing, path)


def _glb(thing: Take | Clip, path: _Path, character: int) -> None:
    from understudy.output.gltf import solids_of, write_glb

    if isinstance(thing, Clip):
        write_glb(thing, path)
        return
    clip = thing.clip(character)
    solids = solids_of(thing, character, rate=clip.rate)
    write_glb(clip, path, character=thing.scene.characters[character], solids=solids)


def _html(thing: Take | Clip, path: _Path, character: int) -> None:
    from understudy.output.player import write_player

    write_player(thing, path)


def _video(thing: Take | Clip, path: _Path, character: int) -> None:
    from understudy.output.film import video

    video(thing, path)


def _png(thing: Take | Clip, path: _Path, character: int) -> None:
    from understudy.output.pictures import contact_sheet

    contact_sheet(thing, path)


_WRITERS: dict[str, Callable[[Any, _Path, int], None]] = {
    ".bvh": _bvh,
    ".glb": _glb,
    ".csv": _csv,
    ".npz": _npz,
    ".html": _html,
    ".mp4": _video,
    ".gif": _video,
    ".png": _png,
}
