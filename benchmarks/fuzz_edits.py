"""Throws broken edit files at their reader: python benchmarks/fuzz_edits.py [--inputs 20000]

Valid edit files are damaged in many ways (bytes, numbers, words, lines, whole values), read, and
where they still read, made into a performance; nothing is simulated. An edit file may be accepted
or refused with an `UnderstudyError` of one line that begins with the file's name; anything else
(another exception, a warning, more than 20 s) is a failure and ends in exit status 1. The same seed
gives the same inputs.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
import time
import traceback
import warnings
from collections import Counter
from functools import lru_cache
from pathlib import Path

from tqdm import tqdm

from understudy.edit import motions
from understudy.edit.edit import edit_of
from understudy.edit.source import EditError, parsed

SECONDS = 20.0
NAME = "fuzzed.toml"
VALUES = [
    "nan",
    "inf",
    "-inf",
    "0",
    "-0.0",
    "-1",
    "1e-320",
    "1e308",
    "1e300",
    "1e9",
    "-1e30",
    "2",
    "7",
    "0.5",
    "1e-9",
    "60.0",
    "0x7F",
    "9007199254740993",
    "99999999999999999999999999",
    "true",
    "1979-05-27",
    "1979-05-27T07:32:00Z",
    "[]",
    "[1.0]",
    "[[[]]]",
    "{}",
    "{a=1}",
    "''",
    '""',
    '"x"',
    '"a/b"',
    '"b/chest"',
    '"chest"',
    '"right_hand"',
    '"sample:walk"',
    '"all"',
    "[nan,1,2]",
    "[1,2,3]",
    "[1e9,0,1]",
    '["a","b"]',
    '[["chest","chest"]]',
]
JUNK = [
    "[",
    "]",
    "[[",
    "]]",
    "=",
    ",",
    ".",
    "#",
    '"',
    "'",
    '"""',
    "'''",
    "{",
    "}",
    "\\",
    "\x7f",
    "\u2028",
    "é",
    "-",
    "_",
    "a",
    "1",
    "\\u0041",
    "kind",
]
JUNK += ["\n", "\r\n", "\r", "\t", "\x00", " "]

SMALL = """\
title = "all there is"
seed = 3
contacts = [["right_hand", "drum"], ["chest", "ball"]]
[ground]
friction = 0.9
slope = 3.0
[ground.steps]
position = [1.0, 0.0]
count = 2
[[character]]
clip = "sample:gesture"
trim = [0.8, 1.3]
body = "own"
speed = 1.2
pelvis = "assisted"
[[character.offset]]
hand = "left"
time = 0.3
position = [0.15, 0.3, 1.0]
[[character.task]]
kind = "look_at"
target = "drum/skin"
span = [0.1, inf]
[[character.task]]
kind = "reach"
target = [0.3, -0.3, 1.2]
ease = 0.1
[[prop]]
kind = "drum"
position = [0.5, 0.0, 1.0]
[[prop]]
kind = "ball"
position = [2.0, 0.0, 1.0]
[[push]]
time = 0.1
on = "chest"
impulse = [10.0, 0.0, 0.0]
[[throw]]
time = 0.3
flight = 0.2
[give_way]
strength = 0.3
"""
PAIR = """\
timestep = 0.004
[[character]]
at = [0.0, 0.0]
  [[character.segment]]
  clip = "sample:gesture"
  trim = [0.0, 0.8]
  [[character.segment]]
  clip = "sample:clapping"
  trim = [0.0, 0.8]
  mirrored = true
  blend = 0.3
  time = 0.3
[[character]]
clip = "sample:clapping"
trim = [0.0, 0.9]
at = [0.8, 0.0]
heading = 180
plan = "full16"
  [[character.task]]
  kind = "upright"
[[meet]]
time = 0.5
hands = ["right", "left"]
window = 0.2
[[prop]]
kind = "staff"
held_by = "b/right_hand"
"""
SEEDS = (SMALL, PAIR)


def damaged(text: str, rng: random.Random) -> str:
    """The text with one to three things wrong."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        text = rng.choice((_value, _value, _value, _word, _junk, _line, _cut))(text, rng)
    return text


def _value(text: str, rng: random.Random) -> str:
    """Another value for a key."""
    places = list(re.finditer(r"(?<== ).*$", text, re.MULTILINE))
    if not places:
        return text
    one = rng.choice(places)
    new = rng.choice((rng.choice(VALUES), rng.choice(places)[0]))
    return text[: one.start()] + new + text[one.end() :]


def _word(text: str, rng: random.Random) -> str:
    """A word or a number in place of another."""
    places = list(re.finditer(r"[\w.]+", text))
    if not places:
        return text
    one, other = rng.choice(places), rng.choice((rng.choice(places)[0], rng.choice(VALUES)))
    return text[: one.start()] + other + text[one.end() :]


def _junk(text: str, rng: random.Random) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice(JUNK) + text[at + rng.choice((0, 0, 1, 3)) :]


def _line(text: str, rng: random.Random) -> str:
    """A line left out, twice, or somewhere else."""
    lines = text.split("\n")
    one = lines.pop(rng.randrange(len(lines)))
    for _ in range(rng.choice((0, 1, 1, 2))):
        lines.insert(rng.randrange(len(lines) + 1), one)
    return "\n".join(lines)


def _cut(text: str, rng: random.Random) -> str:
    return text[: rng.randrange(len(text) + 1)] if rng.random() < 0.2 else text


def outcome(text: str) -> str:
    """What became of a text: "performance", or "refused".

    Raises:
        Exception: Anything but a refusal in one line.
    """
    try:
        edit_of(parsed(text, NAME)).performance()
    except EditError as error:
        said = str(error)
        if not said.startswith(NAME) or "\n" in said:
            raise AssertionError(f"not one line of {NAME}: {said!r}") from error
        return "refused"
    return "performance"


def main() -> int:
    """Run; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--inputs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    warnings.simplefilter("error")
    motions.sample = lru_cache(motions.sample)  # clips never change
    rng, count, slowest = random.Random(options.seed), Counter[str](), 0.0
    for number in tqdm(range(options.inputs), disable=None):
        text = damaged(rng.choice(SEEDS), rng)
        began = time.monotonic()
        found, said = tried(text)
        spent = time.monotonic() - began
        slowest = max(slowest, spent)
        if found == "performance" and spent > SECONDS:
            found, said = "SLOW", f"{spent:.1f} s"
        count[found] += 1
        if said:
            Path(f"fuzzed_{number}.toml").write_text(text, encoding="utf-8")
            print(f"{found}: fuzzed_{number}.toml\n{said}", file=sys.stderr, flush=True)
    print(f"{options.inputs} inputs: {dict(count)}; slowest {slowest:.1f} s")
    return 1 if count["FAILED"] or count["SLOW"] else 0


def tried(text: str) -> tuple[str, str]:
    """`outcome`, or "FAILED" and how."""
    try:
        return outcome(text), ""
    except Exception:
        return "FAILED", traceback.format_exc()


if __name__ == "__main__":
    sys.exit(main())
