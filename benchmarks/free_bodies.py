"""Lets other bodies perform clips with nothing to hold on to: which can, and with how much help.

    python benchmarks/free_bodies.py CLIP [CLIP ...] [--limit 3] [--seed 0] [--only child woman]

The clip's own body first; then 20 % heavier (with the strength that goes with it), a third
stronger, a third weaker; then a woman and a child, to whom the clip is scaled: the path by the
length of the legs, and, for "in time", the speed by its square root, as gravity wants it.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import understudy as us
from understudy.app.outcome import table
from understudy.character.bodies import adult_woman, child
from understudy.evaluate.following import following
from understudy.feasibility import assess

STRONGER, WEAKER, HEAVIER = 1.33, 0.67, 1.2
HEAD = (
    *("clip", "body", "s", "kg", "score %", "help % BW", "s free", "joints deg", "CoM mm"),
    *("global mm", "of limit %", "CPU-s/s"),
)


class Case(NamedTuple):
    """A clip, who performs it, and settings of the tracking."""

    clip: us.Clip
    body: us.Character
    settings: dict[str, Any]


def own(clip: us.Clip) -> Case:
    return Case(clip, us.Character.from_clip(clip), {})


def heavier(clip: us.Clip) -> Case:
    mass = us.Character.from_clip(clip).mass
    return Case(clip, us.Character.from_clip(clip, mass=HEAVIER * mass), {})


def strong(factor: float) -> Callable[[us.Clip], Case]:
    def case(clip: us.Clip) -> Case:
        body = us.Character.from_clip(clip)
        joints = tuple((link.joint, factor) for link in body.links[1:])
        return Case(clip, body, {"strengths": joints})

    return case


def other(made: Callable[[], us.Character], *, in_time: bool) -> Callable[[us.Clip], Case]:
    def case(clip: us.Clip) -> Case:
        body, scale = made(), made().height / us.Character.from_clip(clip).height
        return Case(clip.retimed(scale**-0.5) if in_time else clip, body, {})

    return case


CASES: dict[str, Callable[[us.Clip], Case]] = {
    "own": own,
    "heavier": heavier,
    "stronger": strong(STRONGER),
    "weaker": strong(WEAKER),
    "woman": other(adult_woman, in_time=False),
    "child": other(child, in_time=False),
    "child in time": other(child, in_time=True),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("clips", nargs="+", help="motion files or sample:NAME")
    parser.add_argument("--limit", type=float, default=3.0, help="seconds of a clip")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", default=list(CASES), choices=list(CASES))
    parser.add_argument("--out", default=None, help="folder for take files")
    options = parser.parse_args()
    rows = []
    for name in options.clips:
        clip = us.sample(name[7:]) if name.startswith("sample:") else us.read(name)
        clip = clip.trimmed(0.0, min(options.limit, clip.duration))
        for kind in options.only:
            rows.append(row(clip, kind, options.seed, options.out))
            print("  ".join(rows[-1]), flush=True)
    print(table([HEAD, *rows], right=range(2, len(HEAD))))


def row(clip: us.Clip, kind: str, seed: int, out: str | None) -> tuple[str, ...]:
    case, started = CASES[kind](clip), time.process_time()
    try:
        take = us.track(case.clip, case.body, pelvis="free", seed=seed, threads=1, **case.settings)
    except us.UnderstudyError as error:
        return (clip.name, kind, f"{case.clip.duration:.2f}", str(error), *[""] * (len(HEAD) - 4))
    cost = (time.process_time() - started) / take.duration
    if out is not None:
        us.write(take, f"{out}/{clip.name}_{kind.replace(' ', '_')}.take.npz")
    found, scores = following(take), us.score(take)
    assert take.performance is not None
    foreseen = assess(take.performance).score
    strength = max(scores.strength_percent.values(), default=0.0)
    numbers = (
        *(take.duration, case.body.mass, foreseen, found.help_percent, found.free_s),
        *(scores.joint_error_deg, found.com_mm, found.joint_position_mm, strength, cost),
    )
    return (clip.name, kind, *("-" if n is None else f"{n:.1f}" for n in numbers))


if __name__ == "__main__":
    main()
