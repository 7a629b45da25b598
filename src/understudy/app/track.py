"""`understudy track`: a simulated body performs one clip or many."""

from __future__ import annotations

import os
import sys
import textwrap
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from glob import escape
from pathlib import Path
from typing import Annotated, Any, Literal

from tyro.conf import Positional, arg

from understudy.app.body import Body, check_body
from understudy.app.outcome import Interrupted, Outcome, table
from understudy.app.performing import Job, Row, attempted, cut_short, ready, spared, status
from understudy.app.reading import Reading, expanded, inputs, stem
from understudy.app.workers import each
from understudy.errors import InvalidValue

EXAMPLE = """\
  understudy track sample:gesture
  understudy track *.bvh --out out --jobs 2 --json > scores.json
  understudy track walk.bvh --character child --law paper --video"""

MISSING = """\
missing: the force that the clip needs and the ground cannot give, root mean square, in % of body
weight. Up to 7: nearly all such clips stand free; up to 20: many; more: seldom one, as the scene
is."""

HELP_FROM_ABOVE = """\
help: outside force on the pelvis, mean / peak, in % of body weight. 0: nothing but contact holds
the body. A mean up to 5: it almost stands by itself; 5 to 30: a light hand from above; more: it is
held up. A led pelvis always is."""

FREELY = """\
s free: time without any outside force before the body was lost. CoM, global: distance of the center
of mass (root mean square) and of the joints (mean) from the prepared clip's, in the world."""

CUT_SHORT = "It ends before the clip does: from there on no help that was tried was enough."
_SPENT = ("cpu_seconds", "search_cpu_seconds")
_DIED = "its process died, perhaps for lack of memory; trim the clip or lower --jobs."


@dataclass(frozen=True, kw_only=True)
class Options(Body, Reading):
    """Make a simulated body perform motion clips, and report how well it did.

    For each clip: NAME_sim.bvh (on the clip's own skeleton), NAME_sim.glb, NAME.take.npz,
    NAME.html (report) and NAME.json (certificate). A clip that fails changes no file and stops no
    other.

    Attributes:
        clips: Motion files, folders of them, or samples as sample:NAME.
        law: modern (follows without lag) or paper (Zordan & Hodgins 1999).
        pelvis: led along its path (usual without legs), assisted softly (usual), or free: nothing
            holds it, and how to stay on its feet is searched.
        seeds: With a free pelvis: seeds to try from --seed on, until one needs no help.
        budget: With a free pelvis: most seconds each search may take, once compiled.
        stiffness: Servo stiffness per inertia [1/s^2].
        torque_limits: Bound every joint by human strength (usual with a free pelvis), or not.
        self_collision: Let the arms touch trunk and legs (pairs), or not.
        seed: Seed of every random choice.
        out: Folder for the files.
        stills: Also NAME.png, reference and simulated poses, one above the other.
        video: Also NAME.mp4.
        jobs: Clips at a time.
        json: Print one JSON object.
    """

    clips: Positional[
        Annotated[tuple[str, ...], arg(metavar="CLIP [CLIP ...]", help_behavior_hint="(required)")]
    ]
    law: Literal["modern", "paper"] = "modern"
    pelvis: Annotated[
        Literal["led", "assisted", "free"] | None,
        arg(metavar="{led,assisted,free}", help_behavior_hint="(default: by the body's legs)"),
    ] = None
    stiffness: Annotated[float | None, arg(metavar="K", help_behavior_hint="(default: 3000)")] = (
        None
    )
    seeds: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: 1)")] = None
    budget: Annotated[float | None, arg(metavar="S", help_behavior_hint="(default: none)")] = None
    torque_limits: Annotated[
        Literal["off", "human"] | None,
        arg(metavar="{off,human}", help_behavior_hint="(default: by the pelvis)"),
    ] = None
    self_collision: Literal["off", "pairs"] = "off"
    seed: int = 0
    out: Annotated[
        Path | None, arg(metavar="DIR", help_behavior_hint="(default: NAME_understudy)")
    ] = None
    stills: bool = False
    video: bool = False
    jobs: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: one per core)")] = (
        None
    )
    json: bool = False


def run(options: Options) -> Outcome:
    """Perform every clip; one row each."""
    if not options.clips:
        raise InvalidValue("give at least one clip, as: understudy track sample:gesture")
    options = replace(options, clips=expanded(options.clips))
    count = cores() if options.jobs is None else options.jobs
    if count < 1:
        raise InvalidValue(f"--jobs is {count}; it must be at least 1.")
    if options.out is not None and options.out.exists() and not options.out.is_dir():
        raise InvalidValue(f"{options.out}: is a file; --out needs a folder.")
    check_body(options)
    check_search(options)
    jobs = jobs_for(options)
    check_targets(jobs)
    rows: dict[int, Row] = {}
    before = searched(jobs)
    try:
        _collect(jobs, count, rows)
    except KeyboardInterrupt as stop:
        done = [rows[index] for index in sorted(rows)]
        status_ = getattr(stop, "status", Interrupted().status)
        raise Interrupted(result=result(done), status=status_, kept=spoken(jobs, before)) from stop
    ordered = [rows[index] for index in range(len(jobs))]
    return Outcome(result=result(ordered), text=text(ordered), status=status(ordered))


def searched(jobs: Sequence[Any]) -> dict[Path, int]:
    """Files of searches that are there, of jobs with a folder and a name; when written [ns]."""
    found = (path for job in jobs for path in job.folder.glob(f"{escape(job.name)}.*.search"))
    return {path: path.stat().st_mtime_ns for path in found if path.is_file()}


def spoken(jobs: Sequence[Any], before: dict[Path, int]) -> str:
    """What an interrupt says is kept; `before` is what was searched before the jobs began."""
    if searched(jobs).items() - before.items():
        more = "and the search as far as it came: the same command goes on with it"
        return f"finished files are kept, {more}"
    return "finished files are kept"


def check_search(options: Options) -> None:
    """Refuse settings of a search where nothing is searched, or that leave nothing to search.

    Raises:
        InvalidValue: Says which.
    """
    if options.pelvis == "free" and options.plan.startswith("upper"):
        raise InvalidValue(
            f"--plan {options.plan} leaves the legs out; only a body with legs can be free."
        )
    for name, value in (("seeds", options.seeds), ("budget", options.budget)):
        if value is None:
            continue
        if options.pelvis != "free":
            raise InvalidValue(f"--{name} is for --pelvis free.")
        if not 0 < value < float("inf"):
            raise InvalidValue(f"--{name} is {value}; it must be positive.")


def check_targets(jobs: Sequence[Job]) -> None:
    """Refuse, before the work, what could not be written or must not be written over.

    Raises:
        UnderstudyError: A folder or file that cannot be written; a file that is read; one that two
            clips would share.
    """
    for folder in dict.fromkeys(job.folder for job in jobs):
        ready(folder)
    owners: dict[Path, Job] = {}
    for job in jobs:
        for target in job.targets:
            spared(target, job.keep)
            other = owners.setdefault(target, job)
            if other is not job:
                raise InvalidValue(
                    f"{target}: would be made of both {other.clip} and {job.clip}; rename one."
                )


def _collect(jobs: Sequence[Job], count: int, rows: dict[int, Row]) -> None:
    """Perform every clip, `count` at a time, and say how each went; fills `rows` by number."""
    with closing(each(attempted, jobs, jobs=count)) as finished:
        for index, found in finished:
            job = jobs[index]
            row = found or Row(clip=job.clip, name=job.name, error=_DIED, status=1)
            rows[index] = row
            if len(jobs) > 1:
                print(f"[{len(rows)}/{len(jobs)}] {row.name}: {summary(row)}", file=sys.stderr)
            elif row.error:
                print(f"understudy track: {row.error}", file=sys.stderr)
            elif early(row):
                print(f"understudy track: {until(row)}", file=sys.stderr)


def jobs_for(options: Options) -> list[Job]:
    """One job per clip, each with a name of its own."""
    settings: dict[str, Any] = {
        "law": options.law,
        "pelvis": options.pelvis,
        "self_collision": options.self_collision,
        "seed": options.seed,
    }
    for name in ("stiffness", "torque_limits", "budget"):
        if (value := getattr(options, name)) is not None:
            settings[name] = value
    if options.pelvis == "free":
        count = len(options.clips)
        at_once = min(count, options.jobs or cores())
        settings |= {"threads": max(1, cores() // at_once), "progress": count == 1}
    reading = Reading(**{name: getattr(options, name) for name in Reading.__dataclass_fields__})
    body = Body(**{name: getattr(options, name) for name in Body.__dataclass_fields__})
    wanted = ((".png", options.stills), (".mp4", options.video))
    names = unique([stem(clip) for clip in options.clips])
    keep = inputs(options.clips, options)
    return [
        Job(
            clip=clip,
            name=name,
            folder=options.out or Path(f"{name}_understudy"),
            reading=reading,
            body=body,
            settings=settings,
            seeds=options.seeds or 1,
            kinds=tuple(kind for kind, yes in wanted if yes),
            keep=keep,
        )
        for clip, name in zip(options.clips, names, strict=True)
    ]


def unique(names: Sequence[str]) -> list[str]:
    """The names, with a number added to those that came before, be it in other letter case."""
    given = {name.casefold() for name in names}
    taken: set[str] = set()
    found = []
    for name in names:
        fresh, k = name, 1
        while fresh.casefold() in taken or (fresh != name and fresh.casefold() in given):
            k += 1
            fresh = f"{name}_{k}"
        taken.add(fresh.casefold())
        found.append(fresh)
    return found


def cores() -> int:
    """Processor cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def result(rows: Sequence[Row]) -> dict[str, Any]:
    """What `--json` prints."""
    failed = [row for row in rows if row.error]
    answer: dict[str, Any] = {
        "clips": [
            {
                "clip": row.clip,
                "name": row.name,
                "error": row.error,
                "files": row.files,
                "notes": row.notes,
                "wall_s": round(row.wall_s, 3),
                "certificate": row.certificate or None,
            }
            for row in rows
        ],
        "failed": len(failed),
        "status": status(rows),
    }
    if failed and len(failed) == len(rows):
        answer["error"] = failed[0].error
    return answer


def summary(row: Row) -> str:
    """One line on one clip."""
    if row.error:
        return f"failed: {row.error}"
    found = cells(row)
    chosen = FREE_BRIEF if free([row]) else BRIEF
    return ", ".join(f"{name} {found[name]}" for name in chosen)


HEAD = (
    *("clip", "seconds", "joints deg rms", "hands mm", "feet mm", "lag ms"),
    *("missing %", "help %"),
)
FREE_HEAD = (
    *("clip", "seconds", "s free", "joints deg rms", "CoM mm", "global mm"),
    *("CPU s", "missing %", "help %"),
)
"""Columns where the pelvis is free: how far off the body is in the world, and the cost."""
BRIEF = ("joints deg rms", "hands mm", "lag ms", "help %")
FREE_BRIEF = ("s free", "joints deg rms", "global mm", "help %")


def free(rows: Sequence[Row]) -> bool:
    """Whether all clips that were performed had a free pelvis."""
    done = [row.certificate["characters"][0] for row in rows if not row.error]
    return bool(done) and all(one["pelvis"] == "free" and one["following"] for one in done)


def early(row: Row) -> bool:
    """Whether a clip was performed, but not to its end."""
    return not row.error and cut_short(row.certificate)


def hurried(row: Row) -> list[str]:
    """Of a search that ended by its budget, or of a clip performed in part: one line on it."""
    guidance = row.certificate["facts"].get("guidance", {})
    budget = guidance.get("out_of_time_s")
    if budget is not None:
        helped = row.certificate["characters"][0]["following"]["help_percent"] > 0.0
        more = "need less help" if helped else "be harder to push over"
        more = "come farther" if early(row) else more
        return [f"The budget of {budget:g} s ended the search: with more it may {more}."]
    return [CUT_SHORT] if early(row) else []


def until(row: Row) -> str:
    """Of a clip performed in part: one line on how far."""
    followed = row.certificate["characters"][0]["following"]
    return (
        f"{row.name}: performed until {followed['duration_s']:.1f} of {followed['clip_s']:.1f} s; "
        "no run that was tried came farther. Try another seed or a longer budget."
    )


def figures(row: Row, head: Sequence[str] = HEAD) -> tuple[str, ...]:
    """The row's cells after its name."""
    if row.error:
        return ("failed", *[""] * (len(head) - 2))
    found = cells(row)
    return tuple(found[name] for name in head[1:])


def cells(row: Row) -> dict[str, str]:
    """Every figure of a clip that was performed, under its column's name."""
    whole, one = row.certificate, row.certificate["characters"][0]
    followed = one["following"] or {}

    def number(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    held = f"{one['root_force_mean_percent']:.0f} / {one['root_force_peak_percent']:.0f}"
    return {
        "seconds": number(whole["duration_s"], ".2f")
        + (f" of {followed['clip_s']:.2f}" if early(row) else ""),
        "s free": number(followed.get("free_s"), ".2f"),
        "joints deg rms": number(one["joint_error_deg"], ".2f"),
        "hands mm": number(one["hands_mm"], ".1f"),
        "feet mm": number(one["feet_mm"], ".1f"),
        "CoM mm": number(followed.get("com_mm"), ".1f"),
        "global mm": number(one["joint_position_mm"], ".1f"),
        "lag ms": number(one["lag_ms"], "z.0f"),
        "CPU s": number(sum(whole["timing"].get(name, 0.0) for name in _SPENT), ".1f"),
        "missing %": number((whole["feasibility"] or {}).get("score_percent"), ".0f"),
        "help %": ("0" if one["fully_physical"] else held)
        + ("" if one["fell_s"] is None else ", fell"),
    }


def text(rows: Sequence[Row]) -> str:
    """The table, what it means, and where the files are; empty when a lone clip failed."""
    done = [row for row in rows if not row.error]
    if not done:
        return "" if len(rows) == 1 else f"All {len(rows)} clips failed."
    head = FREE_HEAD if free(rows) else HEAD
    lines = [(row.name, *figures(row, head)) for row in rows]
    parts = [table([head, *lines], right=range(1, len(head)))]
    parts += ["", *([FREELY] if free(rows) else []), HELP_FROM_ABOVE]
    if len(rows) == 1:
        parts += ["", *folded(done[0].certificate["statement"])]
        parts += hurried(done[0])
        foreseen = done[0].certificate["feasibility"]
        parts += folded(expected(done[0])) if foreseen else []
        parts += [line for note in done[0].notes for line in folded(note, "  ")]
    elif count := sum(len(row.notes) for row in done):
        parts += ["", f"{counted(count, 'note')} on what was read and changed: in each NAME.html."]
    parts += ["", "files:", *(f"  {line}" for line in listed(done))]
    if any(name.endswith(".search") for row in done for name in row.files):
        parts += [
            "The same command goes on from the .search, or uses it again once it is finished."
        ]
    if len(done) < len(rows):
        parts += ["", f"{len(rows) - len(done)} of {len(rows)} clips failed."]
    return "\n".join(parts)


def expected(row: Row) -> str:
    """What was foreseen of a clip; of one that was free after all, not the help it did not need."""
    from understudy.feasibility import NEEDS_HELP

    said = f"Foreseen from the clip: missing {row.certificate['feasibility']['statement']}"
    followed = row.certificate["characters"][0]["following"]
    if row.certificate["fully_physical"] and followed and followed["free"]:
        return said.replace(NEEDS_HELP, "such clips seldom stand free; this one did")
    return said


def counted(number: int, thing: str) -> str:
    """A number of things, in words that fit it."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def folded(sentence: str, indent: str = "") -> list[str]:
    """A sentence as lines for a terminal."""
    held = sentence.replace(" %", "\u00a0%")  # a number stays on the line of its sign
    lines = textwrap.wrap(held, 96, initial_indent=indent, subsequent_indent=indent)
    return [line.replace("\u00a0", " ") for line in lines]


def listed(rows: Sequence[Row]) -> list[str]:
    """Where the files are: each one for a few clips, by pattern for many."""
    paths = [Path(path) for row in rows for path in row.files.values()]
    if len(rows) <= 2:
        return [str(path) for path in paths]
    endings = [Path(path).name.removeprefix(rows[0].name) for path in rows[0].files.values()]
    folders = dict.fromkeys(str(path.parent) for path in paths)
    return [f"{folder}/NAME{{{','.join(endings)}}}" for folder in folders]
