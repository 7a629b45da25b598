"""One clip performed: read, simulated, scored, and every file written, or none.

Files are made in a folder of their own and moved into place when all of them exist, so a run that
fails or is interrupted leaves what was there before untouched.
"""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from understudy.app.body import Body, character_for
from understudy.app.outcome import plain
from understudy.app.reading import Reading, clip_from
from understudy.errors import ControllerFailed, Diverged, InvalidValue, UnderstudyError, shown
from understudy.motion.files import same_file, writable

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.motion.clip import Clip
    from understudy.take import Take


@dataclass(frozen=True, kw_only=True)
class Job:
    """One clip to perform.

    Attributes:
        clip: What was typed: a file or a sample.
        name: Stem of the files to make.
        folder: Where they go.
        reading: How to read it.
        body: Who performs it.
        settings: Keyword arguments of `understudy.track`.
        seeds: Most seeds to try when the pelvis is free.
        kinds: Endings of the optional files wanted: ".mp4", ".png".
        keep: Files that are read by this job or another, so not to be written.
    """

    clip: str
    name: str
    folder: Path
    reading: Reading
    body: Body
    settings: dict[str, Any] = field(default_factory=dict)
    seeds: int = 1
    kinds: tuple[str, ...] = ()
    keep: tuple[Path, ...] = ()

    @property
    def targets(self) -> tuple[Path, ...]:
        """The files that a clip performed well leaves behind."""
        endings = ("_sim.bvh", "_sim.glb", ".take.npz", ".html", ".json", *self.kinds)
        return tuple(self.folder / f"{self.name}{ending}" for ending in endings)


@dataclass(frozen=True, kw_only=True)
class Row:
    """What became of one job; plain values only, so that it crosses processes.

    Attributes:
        clip: What was typed.
        name: Stem of the files.
        error: One line, or None.
        status: Exit status this clip alone would give.
        certificate: The score as JSON has it; empty after an error.
        files: Kind of file to its path.
        notes: What was detected in the clip or changed before the body performed it.
        wall_s: Wall time [s].
    """

    clip: str
    name: str
    error: str | None = None
    status: int = 0
    certificate: dict[str, Any] = field(default_factory=dict)
    files: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    wall_s: float = 0.0


def attempted(job: Job) -> Row:
    """`performed`, with anything it raises turned into the row's error."""
    from understudy.app.main import explained

    try:
        return performed(job)
    except Exception as error:
        message, status = explained(error)
        files = {}
        if isinstance(error, Diverged | ControllerFailed):
            files = kept(job.folder, job.name, job.keep, error)
            message = partial(message, files)
        return Row(clip=job.clip, name=job.name, error=message, status=status, files=files)


def performed(job: Job) -> Row:
    """Read, simulate, score and write one clip.

    Raises:
        UnderstudyError: As its subclasses say; nothing was written.
    """
    from understudy.evaluate import certificate

    started = time.monotonic()
    clip = clip_from(job.clip, job.reading)
    character = character_for(clip, job.body)
    take = taken(clip, character, job)
    found, (reference,) = certificate(take), take.references
    found["feasibility"] = foreseen(take)
    with staged(job.folder, job.name, keep=job.keep) as (folder, files):
        write_all(take, folder, job)
        text = json.dumps(plain(found), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / f"{job.name}.json").write_text(text + "\n", encoding="utf-8")
    return Row(
        clip=job.clip,
        name=job.name,
        status=int(cut_short(found)),
        certificate=found,
        files=files | searched(job),
        notes=() if reference is None else reference.notes,
        wall_s=time.monotonic() - started,
    )


def cut_short(certificate: Mapping[str, Any]) -> bool:
    """Whether a clip was performed, but not to its end."""
    followed = certificate["characters"][0]["following"]
    return bool(followed) and not followed["whole"]


def taken(clip: Clip, character: Character, job: Job) -> Take:
    """The take of a job."""
    import understudy as us
    from understudy.app.freeing import freed

    if job.settings.get("pelvis") != "free":
        return us.track(clip, character, **job.settings)
    return freed(clip, character, job.settings, seeds=job.seeds, folder=job.folder, name=job.name)


def searched(job: Job) -> dict[str, str]:
    """The files of a job's searches, by their ending; none where nothing was searched."""
    from understudy.app.freeing import searches

    if job.settings.get("pelvis") != "free":
        return {}
    first = job.settings.get("seed", 0)
    return searches(job.folder, job.name, range(first, first + job.seeds))


def foreseen(take: Take) -> dict[str, Any] | None:
    """What the ground cannot give to the motion; None where there is no ground."""
    from understudy.feasibility import assess

    if take.performance is None or take.scene.ground is None:
        return None
    return assess(take.performance).as_dict()


def write_all(take: Take, folder: Path, job: Job) -> None:
    """Every file of one take but its certificate, into `folder`."""
    import understudy as us

    stem = folder / job.name
    files = (f"{stem}_sim.bvh", f"{stem}_sim.glb", f"{stem}.take.npz")
    us.write(take, *files, *(f"{stem}{kind}" for kind in job.kinds))
    us.write_report(take, f"{stem}.html")


def ready(folder: Path) -> None:
    """Refuse a folder that files could not be written to, before the work; makes nothing.

    Raises:
        UnderstudyError: It, or what it would be made in, is a file or may not be written.
    """
    place = folder
    while not place.exists() and place != place.parent:
        place = place.parent
    if not place.is_dir():
        raise UnderstudyError(f"{place}: is a file; --out needs a folder.")
    writable(folder / "file")
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        reason = error.strerror or error
        raise UnderstudyError(f"{folder}: cannot be written: {reason}.") from None


def check_name(name: str) -> None:
    """Refuse a stem that is no part of a file's name, or a path to elsewhere.

    Raises:
        InvalidValue: Says so.
    """
    if not name.strip() or name.startswith(".") or any(c in name for c in "/\\\0\n"):
        raise InvalidValue(
            f"--name is {shown(name)}; it must be the stem of a file's name, without a folder."
        )


def spared(target: Path, keep: Iterable[Path]) -> None:
    """Refuse a file that is read, or a folder or a device of that name.

    Raises:
        UnderstudyError: Names it.
    """
    writable(target)
    for source in keep:
        if same_file(target, source):
            raise InvalidValue(f"{source}: would be written over; choose another --out.")


@contextmanager
def staged(
    folder: Path, name: str, *, keep: Iterable[Path] = ()
) -> Iterator[tuple[Path, dict[str, str]]]:
    """A temporary folder inside `folder`, whose files move into `folder` when the block succeeds.

    Yields the temporary folder and a mapping, filled at the end, of each file's ending to its path.

    Raises:
        UnderstudyError: The folder cannot be made or written, or a file of `keep` is in the way;
            names the place that was asked for, not the temporary one.
    """
    inside = ""
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{name[:40]}-", dir=folder) as inside:
            files: dict[str, str] = {}
            yield Path(inside), files
            ready_made = sorted(Path(inside).iterdir())
            for made_file in ready_made:
                spared(folder / made_file.name, keep)
            for made_file in ready_made:
                final = folder / made_file.name
                made_file.replace(writable(final))
                files[made_file.name.removeprefix(name).lstrip("._")] = str(final)
    except (FileExistsError, NotADirectoryError) as error:
        raise UnderstudyError(f"{error.filename}: is a file; --out needs a folder.") from None
    except UnderstudyError as error:
        if inside and inside in str(error):
            raise UnderstudyError(str(error).replace(inside, str(folder))) from error
        raise
    except OSError as error:
        place = str(error.filename or folder).replace(inside or "\0", str(folder))
        reason = error.strerror or error
        raise UnderstudyError(f"{place}: cannot be written: {reason}.") from error
    finally:
        if made and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def partial(message: str, files: dict[str, str]) -> str:
    """The message with where the take up to then is, and how to look at it."""
    said = message.replace("; the take up to then is kept.", ".")
    if not files:
        return said
    path = files["take.npz"]
    return f"{said} The take up to then: {path}; see it with: understudy render {quote(path)}"


def kept(
    folder: Path, name: str, keep: Iterable[Path], error: Diverged | ControllerFailed
) -> dict[str, str]:
    """Write the take of a run that ended early, beside where its files would be."""
    import understudy as us

    if error.take is None:
        return {}
    path = folder / f"{name}_until_{error.time:.3f}s.take.npz"
    try:
        spared(path, keep)
        us.write(error.take, path)
    except UnderstudyError:
        return {}
    return {"take.npz": str(path)}


def status(rows: Sequence[Any]) -> int:
    """Of rows that have one each: 0 when all went well, what all share when all failed, else 1."""
    found = {row.status for row in rows}
    return found.pop() if len(found) == 1 else 1
