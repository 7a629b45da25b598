"""How much help from outside every preset of a family needs, and how far it moves the body.

    python benchmarks/presets.py [--clip sample:walk] [--each 10] [--seed 7] [--grip 0.5]

Help is the mean outside force on the assisted pelvis, in percent of body weight.
"""

from __future__ import annotations

import argparse

import numpy as np

import understudy as us
from understudy.family.member import Member
from understudy.family.table import row
from understudy.variations import PRESETS


def line(name: str, members: list[Member]) -> str:
    """One row: means over the members, the spread of the help, and the flags."""
    rows = [row(member) for member in members]
    held = [one["help_percent"] for one in rows]
    away = np.mean([one["away_mm"] for one in rows])
    flags = sorted({flag for one in rows for flag in one["flags"]})
    spread = f"{min(held):.0f} to {max(held):.0f}"
    return f"| `{name}` | {np.mean(held):.0f} | {spread} | {away:.0f} | {', '.join(flags)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clip", default="sample:walk")
    parser.add_argument("--each", type=int, default=10)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--grip", type=float, default=0.5)
    given = parser.parse_args()
    sample = given.clip.removeprefix("sample:")
    clip = us.read(given.clip) if sample == given.clip else us.sample(sample)
    performance = us.tracked(clip, us.Character.from_clip(clip))
    made = us.family(performance, given.each * len(PRESETS), seed=given.seed, grip=given.grip)
    print("| preset | help % | least to most | away [mm] | flags |\n|---|---|---|---|---|")
    print(line("unvaried", [made.unvaried]))
    for name in PRESETS:
        print(line(name, [member for member in made.members if member.kind == name]))


if __name__ == "__main__":
    main()
