"""`understudy perform`: runs what edit files describe."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from understudy.app.outcome import Interrupted, Outcome, plain, table
from understudy.app.performing import kept, partial, ready, spared, staged, status
from understudy.app.track import HELP_FROM_ABOVE, counted, folded, searched, spoken, unique
from understudy.errors import ControllerFailed, Diverged, InvalidValue, NotFound

if TYPE_CHECKING:
    from understudy.edit import Edit
    from understudy.performance import Performance
    from understudy.take import Take

EXAMPLE = """\
  drum.toml:
    contacts = [["right_hand", "drum"]]

    [[character]]
    clip = "sample:strike"
    body = "adult_man"

    [[prop]]
    kind = "drum"
    position = [0.45, -0.15, 0.95]

  understudy perform drum.toml
  understudy perform edits/*.toml --out out --stills --json > results.json"""

TASKED = """\
Joints that tasks move on purpose count among the degrees."""

# Contact events listed on the terminal; the certificate has them all.
MOST_LISTED = 24


@dataclass(frozen=True, kw_only=True)
class Options:
    """Run edit files: clips, bodies, props, tasks, offsets, transitions and pushes in one text.

    docs/edit_file.md has the format. For each file: NAME_sim.bvh and NAME_sim.glb (of a second
    character NAME_b_sim.bvh and so on), NAME.take.npz, NAME.html (report) and NAME.json
    (certificate, with every contact). All files are read and checked before the first is simulated.

    Attributes:
        edits: Edit files (TOML).
        out: Folder for the files.
        stills: Also NAME.png, reference and simulated poses, one above the other.
        video: Also NAME.mp4.
        json: Print one JSON object.
    """

    edits: Positional[
        Annotated[tuple[Path, ...], arg(metavar="EDIT [EDIT ...]", help_behavior_hint="(required)")]
    ]
    out: Annotated[
        Path | None, arg(metavar="DIR", help_behavior_hint="(default: NAME_understudy)")
    ] = None
    stills: bool = False
    video: bool = False
    json: bool = False


@dataclass(frozen=True, kw_only=True)
class Job:
    """One edit file to run.

    Attributes:
        edit: What it says.
        name: Stem of the files to make.
        folder: Where they go.
        kinds: Endings of the optional files wanted: ".mp4", ".png".
        keep: Files that are read by this job or another, so not to be written.
    """

    edit: Edit
    name: str
    folder: Path
    kinds: tuple[str, ...] = ()
    keep: tuple[Path, ...] = ()

    @property
    def motions(self) -> tuple[str, ...]:
        """Stems of each character's own files."""
        letters = [chr(ord("a") + k) for k in range(len(self.edit.character))]
        return tuple(f"{self.name}{f'_{c}' if c != 'a' else ''}_sim" for c in letters)

    @property
    def targets(self) -> tuple[Path, ...]:
        """The files that it leaves behind."""
        own = [f"{stem}{ending}" for stem in self.motions for ending in (".bvh", ".glb")]
        whole = (".take.npz", ".html", ".json", *self.kinds)
        return tuple(self.folder / name for name in (*own, *(self.name + kind for kind in whole)))


@dataclass(frozen=True, kw_only=True)
class Row:
    """What became of one edit file.

    Attributes:
        path, name, title: The file, the stem of what was made, and what it is.
        error: One line, or None.
        status: Exit status it alone would give.
        certificate: The certificate as JSON has it; empty after an error.
        files: Kind of file to its path.
        notes: What was changed before the bodies performed.
        tasked: Whether a task moves joints away from the clip.
        wall_s: Wall time [s].
    """

    path: str
    name: str
    title: str = ""
    error: str | None = None
    status: int = 0
    certificate: dict[str, Any] | None = None
    files: dict[str, str] | None = None
    notes: tuple[str, ...] = ()
    tasked: bool = False
    wall_s: float = 0.0


def run(options: Options) -> Outcome:
    """Run every edit file in turn.

    Raises:
        EditError: A mistake in any of them; nothing is simulated and nothing written then.
    """
    if not options.edits:
        raise InvalidValue("give at least one edit file, as: understudy perform drum.toml")
    if options.out is not None and options.out.exists() and not options.out.is_dir():
        raise InvalidValue(f"{options.out}: is a file; --out needs a folder.")
    jobs = jobs_for(options)
    for job in jobs:
        ready(job.folder)
        for target in job.targets:
            spared(target, job.keep)
    for job in jobs[1:]:
        made(job.edit)  # the first is about to be made anyway
    rows: list[Row] = []
    before = searched(jobs)
    try:
        for job in jobs:
            rows.append(attempted(job))
            _say(rows, len(jobs))
    except KeyboardInterrupt as stop:
        code = getattr(stop, "status", Interrupted().status)
        kept = spoken(jobs, before)
        raise Interrupted(result=result(rows), status=code, kept=kept) from stop
    return Outcome(result=result(rows), text=text(rows), status=status(rows))


def _say(rows: Sequence[Row], count: int) -> None:
    """One line on standard error on the last of `count` files: of one, only what went wrong."""
    row = rows[-1]
    if count > 1:
        said = f"failed: {row.error}" if row.error else f"done in {row.wall_s:.1f} s"
        print(f"[{len(rows)}/{count}] {row.name}: {said}", file=sys.stderr)
    elif row.error:
        print(f"understudy perform: {row.error}", file=sys.stderr)


def jobs_for(options: Options) -> list[Job]:
    """One job per edit file, each with a name of its own."""
    from understudy.edit import read_edit
    from understudy.edit.motions import files_of

    edits = [read_edit(path) for path in options.edits]
    wanted = ((".png", options.stills), (".mp4", options.video))
    keep = [*options.edits, *(Path(file) for edit in edits for file in files_of(edit))]
    names = unique([path.stem for path in options.edits])
    return [
        Job(
            edit=edit,
            name=name,
            folder=options.out or Path(f"{name}_understudy"),
            kinds=tuple(kind for kind, yes in wanted if yes),
            keep=tuple(keep),
        )
        for edit, name in zip(edits, names, strict=True)
    ]


def made(edit: Edit) -> Performance:
    """What an edit describes, ready to be simulated.

    Raises:
        EditError: As `Edit.performance`; or a loose prop begins inside something.
    """
    from understudy.simulate import prepared

    performance = edit.performance()
    try:
        prepared(performance)
    except InvalidValue as error:
        names = [repr(getattr(prop, "name", None)) for prop in edit.prop]
        said = str(error)
        number = next((k for k, name in enumerate(names) if said.startswith(name)), None)
        raise edit.source.error(() if number is None else ("prop", number), said) from error
    return performance


def attempted(job: Job) -> Row:
    """`performed`, with a simulation that ended early, or a search in vain, as the row's error.

    Raises:
        UnderstudyError: Anything else that a person has to put right.
    """
    try:
        return performed(job)
    except (Diverged, ControllerFailed) as error:
        files = kept(job.folder, job.name, job.keep, error)
        said = partial(str(error), files)
    except NotFound as error:
        files, said = {}, str(error)
    path = str(job.edit.source.path)
    return Row(path=path, name=job.name, error=f"{path}: {said}", status=1, files=files)


def performed(job: Job) -> Row:
    """Simulate, score and write one edit.

    Raises:
        UnderstudyError: As its subclasses say; nothing was written.
    """
    import understudy as us
    from understudy.app.freeing import searches
    from understudy.evaluate import certificate

    started = time.monotonic()
    performance = made(job.edit)
    take = us.simulate(upheld(performance, job), progress=True)
    found = certificate(take)
    with staged(job.folder, job.name, keep=job.keep) as (folder, files):
        write_all(take, folder, job)
        text = json.dumps(plain(found), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / f"{job.name}.json").write_text(text + "\n", encoding="utf-8")
    seed = performance.seed
    notes = [note for clip in take.references if clip is not None for note in clip.notes]
    return Row(
        path=str(job.edit.source.path),
        name=job.name,
        title=job.edit.title,
        certificate=found,
        files=files | searches(job.folder, job.name, range(seed, seed + 1)),
        notes=tuple(dict.fromkeys(notes)),
        tasked=any(performer.task for performer in job.edit.character),
        wall_s=time.monotonic() - started,
    )


def upheld(performance: Performance, job: Job) -> Performance:
    """The performance with a guidance for every free body; the search of a single one is kept."""
    from understudy.app.freeing import checkpoint, resumed, there
    from understudy.free_tracking import guided, unheld

    if len(unheld(performance)) != 1:
        return guided(performance, progress=True)
    kept = checkpoint(job.folder, job.name, performance.seed)
    with there(job.folder):
        return resumed(lambda: guided(performance, checkpoint=kept, progress=True), kept)


def write_all(take: Take, folder: Path, job: Job) -> None:
    """Every file of one take but its certificate, into `folder`."""
    import understudy as us

    for k, stem in enumerate(job.motions):
        us.write(take, *(folder / f"{stem}{kind}" for kind in (".bvh", ".glb")), character=k)
    us.write(take, *(folder / f"{job.name}{kind}" for kind in (".take.npz", *job.kinds)))
    title = job.edit.title or job.edit.source.path.stem
    us.write_report(take, folder / f"{job.name}.html", title=title)


# -- what is said ------------------------------------------------------------------------------


def result(rows: Sequence[Row]) -> dict[str, Any]:
    """What `--json` prints."""
    failed = [row for row in rows if row.error]
    answer: dict[str, Any] = {
        "edits": [
            {
                "edit": row.path,
                "name": row.name,
                "title": row.title,
                "error": row.error,
                "files": row.files or {},
                "notes": row.notes,
                "wall_s": round(row.wall_s, 3),
                "certificate": row.certificate,
            }
            for row in rows
        ],
        "failed": len(failed),
        "status": status(rows) if rows else 0,
    }
    if failed and len(failed) == len(rows):
        answer["error"] = failed[0].error
    return answer


HEAD = ("edit", "character", "seconds", "joints deg rms", "lag ms", "help %")
EVENT = ("between", "at s", "for s", "impulse N s", "peak N", "depth mm")


def figures(row: Row) -> list[tuple[str, ...]]:
    """The row's cells, a line for each character."""
    if row.certificate is None:
        return [(row.name, "", "failed", *[""] * (len(HEAD) - 3))]
    lines = []
    for one in row.certificate["characters"]:
        held = f"{one['root_force_mean_percent']:.0f} / {one['root_force_peak_percent']:.0f}"
        letter = one["prefix"].rstrip("/")
        lines.append(
            (
                "" if lines else row.name,
                f"{letter}: {one['character']}" if letter else one["character"],
                f"{row.certificate['duration_s']:.2f}",
                _number(one["joint_error_deg"], ".2f"),
                _number(one["lag_ms"], "z.0f"),
                ("0" if one["fully_physical"] else held)
                + ("" if one["fell_s"] is None else ", fell"),
            )
        )
    return lines


def events(row: Row) -> str:
    """What touched what, as a table; the strongest where there are many; empty where nothing."""
    found = [] if row.certificate is None else row.certificate["contacts"]
    if not found:
        return ""
    least = sorted((event["impulse_ns"] for event in found), reverse=True)[:MOST_LISTED][-1]
    shown = [event for event in found if event["impulse_ns"] >= least][:MOST_LISTED]
    cells = [
        (
            " - ".join(event["between"]),
            f"{event['start_s']:.3f}",
            f"{event['duration_s']:.3f}",
            f"{event['impulse_ns']:.2f}",
            f"{event['peak_force_n']:.0f}",
            f"{event['penetration_mm']:.1f}",
        )
        for event in shown
    ]
    left = row.certificate["contacts_in_all"] - len(shown) if row.certificate else 0
    more = f"\n({left} weaker: in {row.name}.json)" if left else ""
    return table([EVENT, *cells], right=range(1, len(EVENT))) + more


def tasks(found: Sequence[dict[str, Any]]) -> str:
    """How far every task was from its goal while it had taken over, as a table."""
    lines = [
        (
            one["task"],
            f"{one['start_s']:.2f} - {one['end_s']:.2f}",
            one["what"],
            f"{one['mean']:.1f}",
            f"{one['most']:.1f}",
            one["unit"],
        )
        for one in found
    ]
    return table([("task", "at s", "what", "mean", "at most", ""), *lines], right=(3, 4))


def text(rows: Sequence[Row]) -> str:
    """The table, what it means, what touched what, where the files are; empty when all failed."""
    if all(row.error for row in rows):
        return "" if len(rows) == 1 else f"All {len(rows)} edits failed."
    lines = [cells for row in rows for cells in figures(row)]
    parts = [table([HEAD, *lines], right=range(2, len(HEAD))), "", HELP_FROM_ABOVE]
    parts += [TASKED] if any(row.tasked for row in rows) else []
    for row in rows:
        if row.error:
            parts += ["", *folded(row.error)]
            continue
        parts += ["", f"{row.name}: {row.title}"] if row.title else []
        if row.certificate and row.certificate["tasks"]:
            parts += ["", f"{row.name}: tasks", tasks(row.certificate["tasks"])]
        touched = events(row)
        if touched:
            parts += ["", f"{row.name}: contacts", touched]
        if len(rows) == 1 and row.certificate:
            parts += ["", *folded(row.certificate["statement"])]
            parts += [line for note in row.notes for line in folded(note, "  ")]
        elif row.notes:
            parts += ["", f"{row.name}: {counted(len(row.notes), 'note')} in {row.name}.html."]
    parts += ["", "files:", *(f"  {path}" for row in rows for path in (row.files or {}).values())]
    failed = sum(row.error is not None for row in rows)
    if failed:
        parts += ["", f"{failed} of {counted(len(rows), 'edit')} failed."]
    return "\n".join(parts)


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)
