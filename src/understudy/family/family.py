"""Families: many variations of one performance, simulated in parallel, written as they finish."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from tqdm import tqdm

from understudy.character import Linkage
from understudy.errors import InvalidValue, MissingExtra, UnderstudyError, shown
from understudy.family.casting import (
    Casting,
    Part,
    casting,
    check_size,
    check_variations,
)
from understudy.family.member import (
    FLAGS,
    Member,
    Unvaried,
    kept_member,
    performed,
    write_member,
)
from understudy.family.table import write_csv, write_json
from understudy.motion.files import written
from understudy.performance import Performance
from understudy.simulate import simulate
from understudy.variations import Together, Variation

_SETTINGS = "settings.json"
UNVARIED = "unvaried"


@dataclass(frozen=True, kw_only=True, eq=False)
class Family:
    """The members of a family and where their files are.

    Attributes:
        name: Of the clip.
        unvaried: The performance as it was, at the family's grip.
        members: In order.
        cast: How they were drawn; `cast.part(i).variation` is member i's.
        folder: Where the files are, or None.
        reused: How many members were found finished.
        floor: Whether a floor is simulated.
    """

    name: str
    unvaried: Member
    members: tuple[Member, ...] = field(repr=False)
    cast: Casting = field(repr=False)
    folder: Path | None = None
    reused: int = 0
    floor: bool = True

    def flagged(self) -> dict[str, int]:
        """How many members carry each flag."""
        return {flag: sum(flag in m.flags for m in self.members) for flag in FLAGS}


def family(
    performance: Performance,
    count: int = 100,
    *,
    seed: int = 0,
    variations: str | Variation | Sequence[str | Variation] | None = None,
    common: Variation | Sequence[Variation] = (),
    grip: float | tuple[float, float] | None = 0.5,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    progress: bool = False,
) -> Family:
    """Draw, simulate, score and write a family of varied performances.

    Member i is the same whatever the count and the number of threads: same seed, same bytes. With
    `out`, members found finished there are kept, so an interrupted family goes on.

    Args:
        performance: One that tracks a clip, such as `tracked(clip, character)`.
        count: How many members.
        seed: Seed of all draws.
        variations: Presets by name, or variations with ranges, which members take in turn; all
            presets when neither these nor `common` are given.
        common: Variations that every member gets.
        grip: The strength slider, see `Grip`: 1 tracks, 0 lets the effects spread; a pair is drawn
            from, None leaves the performance's stiffness.
        out: Folder for the files; None keeps only the figures.
        jobs: Threads; all cores by default.
        progress: Show a progress bar on standard error.

    Raises:
        UnknownName: A joint, link or preset that does not exist.
        InvalidValue: An amount out of range, or a family too large for the memory or disk.
        UnderstudyError: The folder holds another family, or cannot be written.
    """
    if not isinstance(performance, Performance):
        raise InvalidValue(
            f"family got {shown(performance)}; give a performance: us.tracked(clip, character)."
        )
    jobs = _cores() if jobs is None else jobs
    folder = None if out is None else Path(out)
    linkage = isinstance(performance.scene.characters[0], Linkage)
    cast = casting(seed, variations, common, grip, linkage=linkage)
    check_size(performance, count, jobs, folder)
    check_variations(performance, cast, count)
    name = _name(performance)
    if folder is not None:
        _claim(folder, performance, cast, name)
    start = Together() if not isinstance(grip, int | float) else Together(cast.grip or Together())
    base = start(performance)
    unvaried = Unvaried(performance=base, take=simulate(base, progress=progress))
    unvaried.ready()
    parts = [cast.part(index) for index in range(count)]
    work = _Work(performance=performance, unvaried=unvaried, folder=folder)
    first = work(Part(index=-1, name=UNVARIED, kind=UNVARIED, variation=start))
    done: dict[int, Member] = {}
    with tqdm(
        total=count, desc=name, unit="take", delay=2.0, disable=None if progress else True
    ) as bar:
        if folder is not None:
            done = {p.index: m for p in parts if (m := kept_member(p, folder / "members"))}
            bar.update(len(done))
        reused = len(done)
        for member in _in_threads(work, [p for p in parts if p.index not in done], jobs):
            done[member.index] = member
            bar.update(1)
    made = Family(
        name=name,
        unvaried=first,
        members=tuple(done[index] for index in range(count)),
        cast=cast,
        folder=folder,
        reused=reused,
        floor=performance.scene.ground is not None,
    )
    if folder is not None:
        write_overview(made, performance, folder)
    return made


def write_overview(made: Family, performance: Performance, folder: Path) -> None:
    """family.json, family.csv, family.html and, where Pillow is installed, family.png."""
    from understudy.family.figure import figure_of
    from understudy.family.page import write_page
    from understudy.family.sheet import write_sheet

    write_json(made, folder / "family.json")
    write_csv(made, folder / "family.csv")
    shape = figure_of(performance.scene.characters[0])
    write_page(made, shape, folder / "family.html")
    with suppress(MissingExtra):
        write_sheet(made, shape, folder / "family.png")


@dataclass(frozen=True, kw_only=True)
class _Work:
    """One member, start to finish, in one thread."""

    performance: Performance
    unvaried: Unvaried
    folder: Path | None

    def __call__(self, part: Part) -> Member:
        member, take = performed(part, self.unvaried, self.performance)
        if self.folder is not None:
            write_member(member, take, self.folder / "members", self.unvaried)
        return member


def _in_threads(work: _Work, parts: list[Part], jobs: int) -> Iterator[Member]:
    """Members as they finish; few are in the works at a time, so memory stays bounded."""
    if jobs == 1:
        yield from map(work, parts)
        return
    waiting = iter(parts)
    with ThreadPoolExecutor(jobs) as pool:
        running: set[Future[Member]] = {pool.submit(work, p) for p in islice(waiting, jobs)}
        try:
            while running:
                finished, running = wait(running, return_when=FIRST_COMPLETED)
                running |= {pool.submit(work, p) for p in islice(waiting, len(finished))}
                for future in finished:
                    yield future.result()
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _claim(folder: Path, performance: Performance, cast: Casting, name: str) -> None:
    """Make the folder this family's, or refuse when it is another's."""
    if folder.exists() and not folder.is_dir():
        raise InvalidValue(f"{folder}: is a file; a family needs a folder.")
    wanted = {"clip": name, "performance": _fingerprint(performance), **cast.as_dict()}
    wanted = json.loads(json.dumps(wanted))
    path = folder / _SETTINGS
    if path.exists():
        try:
            before = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise UnderstudyError(f"{path}: is not a family's settings ({error}).") from None
        if before != wanted:
            other = [key for key in wanted if before.get(key) != wanted[key]]
            raise UnderstudyError(
                f"{folder}: holds another family (different {', '.join(other)}); give another "
                "folder, or remove it."
            )
        return
    try:
        (folder / "members").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnderstudyError(f"{folder}: cannot be made: {error.strerror}.") from None
    with written(path) as temporary:
        temporary.write_text(json.dumps(wanted, indent=1), encoding="utf-8")


def _fingerprint(performance: Performance) -> str:
    """Tells performances apart: body, clip, settings."""
    digest = hashlib.sha256()
    for character in performance.scene.characters:
        if isinstance(character, Linkage):
            digest.update(f"{character.kind} {character.locks}".encode())
            digest.update(character.masses.tobytes() + character.radii.tobytes())
            continue
        for link in character.links:
            digest.update(f"{link.name} {link.mass!r}".encode())
            digest.update(link.offset.tobytes() + link.com.tobytes() + link.inertia.tobytes())
    for controller in performance.controllers:
        reference = getattr(controller, "reference", None)
        if reference is not None:
            digest.update(reference.rotations.tobytes() + reference.root_positions.tobytes())
        digest.update(json.dumps(getattr(controller, "facts", {}), sort_keys=True).encode())
    scene = performance.scene
    facts: tuple[Any, ...] = (performance.duration, performance.seed, scene.timestep, scene.gravity)
    digest.update(repr((*facts, scene.ground, scene.self_collision)).encode())
    return digest.hexdigest()[:16]


def _name(performance: Performance) -> str:
    for controller in performance.controllers:
        reference = getattr(controller, "reference", None)
        if reference is not None:
            return reference.name
    return "performance"


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
