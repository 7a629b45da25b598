"""Tracks every clip of a folder with nothing to hold on to, and says what came of it.

    python benchmarks/free_tracking.py FOLDER [--out DIR] [--seeds 0 1] [--limit 5] [--only walk]

Two processes of one thread each. Every finished clip and seed is a line of DIR/runs.jsonl and a
take file beside it; what is there is not done again, so a stopped benchmark goes on. At the end a
table, summaries by group, and DIR/index.html with the published figures of other trackers and
players of the worst. With --replays every free take is performed again with its feedback, pushed,
on slippery ground, heavier, lighter and weaker.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import understudy as us
from understudy.app.outcome import plain
from understudy.app.outcome import table as columns
from understudy.app.workers import each
from understudy.errors import InvalidValue
from understudy.motion.files import written
from understudy.papers.trackers import Run, page_html, replays, run_of, summaries, table
from understudy.papers.trackers.runs import HEAD, SUMMARY_HEAD, flight, missing, reasons, survival


@dataclass(frozen=True, kw_only=True)
class Job:
    """One clip, one seed."""

    path: Path
    label: str
    number: int
    seed: int
    limit: float | None
    pelvis: str
    replays: bool
    out: Path

    @property
    def take(self) -> Path:
        """Where its take goes."""
        return self.out / "takes" / f"{self.label.replace('/', '_')}_{self.seed}.take.npz"


def main() -> None:
    options = parsed()
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"  # the workers', who read it before they start
    options.out.mkdir(parents=True, exist_ok=True)
    kept = options.out / "runs.jsonl"
    settings = {key: getattr(options, key) for key in ("limit", "pelvis", "replays")}
    runs = read(kept, settings)
    jobs = list(wanted(options))
    have = {(run.label, run.seed) for run in runs}
    left = [job for job in jobs if (job.label, job.seed) not in have]
    started = time.monotonic()
    try:
        for index, found in each(attempted, left, jobs=options.jobs):
            job = left[index]
            run = found or Run(label=job.label, number=job.number, seed=job.seed, error="it died")
            runs.append(run)
            with kept.open("a", encoding="utf-8") as file:
                file.write(json.dumps(plain(run.as_dict())) + "\n")
            said = "  ".join(cell for cell in table([run])[0] if cell)
            print(f"[{len(runs)}/{len(have) + len(left)}] {said}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        print(f"stopped; {kept} keeps what is finished", file=sys.stderr)
    mine = {(job.label, job.seed) for job in jobs}
    shown = [run for run in runs if (run.label, run.seed) in mine]
    print(text(shown))
    if left:
        print(f"{time.monotonic() - started:.0f} s of wall time for {len(left)} runs")
    takes = {(job.label, job.seed): job.take for job in jobs}
    page = options.out / "index.html"
    with written(page) as temporary:
        temporary.write_text(page_html(shown, takes=takes, settings=said_of(options)), "utf-8")
    print(page)


def parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, help="folder of BVH and ASF/AMC files")
    parser.add_argument("--out", type=Path, default=Path("free_tracking"))
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--limit", type=float, help="track at most so many seconds of a clip")
    parser.add_argument("--only", nargs="+", default=[], help="parts of file names")
    parser.add_argument("--pelvis", default="free", choices=("free", "assisted"))
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--replays", action="store_true", help="also disturb the free takes")
    return parser.parse_args()


def said_of(options: argparse.Namespace) -> str:
    """What the runs have in common."""
    length = "whole clips" if options.limit is None else f"at most {options.limit:g} s of each clip"
    seeds = ", ".join(str(seed) for seed in options.seeds)
    return (
        f"Pelvis {options.pelvis}, human torque limits, {length}, seeds {seeds}. Processor time is "
        "that of one thread, compiling the laws (once per process) left out."
    )


def wanted(options: argparse.Namespace) -> Iterator[Job]:
    """Every clip and seed asked for, seed by seed."""
    files = sorted(p for p in options.folder.rglob("*") if p.suffix.lower() in (".bvh", ".amc"))
    for seed in options.seeds:
        for number, path in enumerate(files):
            label = str(path.relative_to(options.folder))
            if options.only and not any(part in label for part in options.only):
                continue
            yield Job(
                path=path,
                label=label,
                number=number,
                seed=seed,
                limit=options.limit,
                pelvis=options.pelvis,
                replays=options.replays,
                out=options.out,
            )


def read(path: Path, settings: dict[str, object]) -> list[Run]:
    """The runs that are finished; a fresh file is begun with the settings."""
    if not path.exists():
        path.write_text(json.dumps({"settings": settings}) + "\n", encoding="utf-8")
        return []
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line]
    if lines[0].get("settings") != settings:
        sys.exit(f"{path}: was made with {lines[0].get('settings')}; give another --out.")
    return [Run.from_dict(line) for line in lines[1:]]


def attempted(job: Job) -> Run:
    """Track one clip; what goes wrong becomes the run's error."""
    try:
        return tracked(job)
    except us.UnderstudyError as error:
        return Run(label=job.label, number=job.number, seed=job.seed, error=str(error))


@cache
def warm() -> None:
    """Let this process compile the laws, which is not counted."""
    clip = us.sample("gesture").trimmed(1.0, 1.2)
    us.track(clip, us.Character.from_clip(clip), pelvis="free", threads=1)


def tracked(job: Job) -> Run:
    own = {}
    if job.pelvis == "free":
        warm()
        own["threads"] = 1
    started = time.process_time()
    clip = us.read(job.path)
    if job.limit is not None and clip.duration > job.limit:
        clip = clip.trimmed(0.0, job.limit)
    character = us.Character.from_clip(clip)
    asked = {"pelvis": job.pelvis, "torque_limits": "human", "seed": job.seed}
    try:
        take = us.track(clip, character, **asked, **own)
    except InvalidValue:
        raise
    except us.UnderstudyError as error:
        return in_vain(job, us.tracked(clip, character, **asked), str(error))
    spent = time.process_time() - started
    job.take.parent.mkdir(parents=True, exist_ok=True)
    us.write(take, job.take)
    run = run_of(take, job.label, number=job.number, cpu_s=spent)
    survived = replays(take.performance) if job.replays and run.free else {}
    return replace(run, seed=job.seed, survived=survived)


def in_vain(job: Job, performance: us.Performance, error: str) -> Run:
    """A run of a clip that no search came to the end of."""
    return Run(
        label=job.label,
        number=job.number,
        seed=job.seed,
        seconds=performance.duration,
        score_percent=missing(performance),
        flight_s=flight(performance),
        error=error,
    )


def text(runs: list[Run]) -> str:
    """The tables for a terminal."""

    def cell(value: object) -> str:
        if value is None:
            return "-"
        return f"{value:.2f}" if isinstance(value, float) else str(value)

    parts = [columns([HEAD, *table(runs)], right=range(1, len(HEAD)))]
    parts += reasons(runs)
    rows = [tuple(cell(value) for value in row) for row in summaries(runs)]
    if rows:
        parts += ["", columns([SUMMARY_HEAD, *rows], right=range(2, len(SUMMARY_HEAD)))]
    changes = [(name, str(n), str(of), f"{100 * n / of:.0f}") for name, n, of in survival(runs)]
    if changes:
        head = ("change", "not lost", "replays", "%")
        parts += ["", columns([head, *changes], right=range(1, 4))]
    return "\n".join(parts)


if __name__ == "__main__":
    main()
