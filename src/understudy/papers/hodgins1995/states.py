"""Figures 2 and 3: the runner's body and the states of its active leg."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from understudy.athletics import running_law as law
from understudy.character import athlete_man, athlete_woman
from understudy.control.machine import STATE
from understudy.motion.rotations import Array
from understudy.papers.finding import Claim, Finding
from understudy.papers.hodgins1995 import published as paper
from understudy.papers.hodgins1995.runs import steady
from understudy.papers.hodgins1995.timeline import Timeline
from understudy.papers.sheets import Sheet
from understudy.simulate.remembered import remembered

SPEEDS = (2.5, 3.5, 5.0)
# A state of "very short duration" lasts no longer than this [s]; ours.
SHORT = 0.025
# Shown in the timeline [s].
_SHOWN = 1.5


def bodies() -> Finding:
    """The model: links, hinges, masses."""
    made = (athlete_man(), athlete_woman())
    rows = []
    for body in made:
        inertia = sum(float(np.trace(link.inertia)) for link in body.links)
        rows.append(
            (body.name, len(body.links), body.controlled_dof, body.height, body.mass, inertia)
        )
    man = made[0]
    feet = [len(man.hinges[man.index(f"left_{part}")]) for part in ("ankle", "ball")]
    return Finding(
        figure="2",
        title="The runner's body",
        setting="Segments of de Leva 1996; a motor per hinge, limited by measured human strength.",
        claims=(
            Claim(
                said=f"The runner has {paper.SEGMENTS} segments and {paper.DEGREES_OF_FREEDOM} "
                "controlled degrees of freedom.",
                measured=f"{len(man.links)} links, {man.controlled_dof} hinges, each with a motor",
                holds=(len(man.links), man.controlled_dof)
                == (paper.SEGMENTS, paper.DEGREES_OF_FREEDOM),
            ),
            Claim(
                said="Feet have two parts with one degree of freedom at the ball, and one at the "
                "ankle.",
                measured=f"{feet[0]} at the ankle, {feet[1]} at the ball",
                holds=feet == [1, 1],
            ),
        ),
        sheets=(
            Sheet(
                name="Figure 2",
                caption="The bodies.",
                head=(
                    "body",
                    "links",
                    "hinges",
                    "height [m]",
                    "mass [kg]",
                    "inertias, sum [kg m2]",
                ),
                rows=tuple(rows),
            ),
        ),
    )


def machine(*, quick: bool = False) -> Finding:
    """States over time at three speeds."""
    seconds = 2.0 if quick else 8.0
    memories = {v: remembered(steady(v, seconds))[0] for v in (SPEEDS[1:2] if quick else SPEEDS)}
    spells = {speed: _spells(memory) for speed, memory in memories.items()}
    rows = [
        (speed, *(1e3 * mean for mean in _means(own)), _thrust(memories[speed]))
        for speed, own in spells.items()
    ]
    shown = _timeline(memories[3.5], _means(spells[3.5]))
    return Finding(
        figure="3",
        title="States of the active leg",
        setting=f"A man at {', '.join(f'{v:g}' for v in spells)} m/s, {seconds:g} s each; the "
        "states "
        "are those the controller kept.",
        claims=_claims(spells, memories),
        charts=(shown,),
        sheets=(
            Sheet(
                name="Figure 3",
                caption="How long each state lasts [ms], and after what part of the expected "
                "stance "
                "the ankle thrusts.",
                head=("speed [m/s]", *law.STATES, "thrust at"),
                rows=tuple(rows),
            ),
        ),
        facts={
            f"state_ms_{speed:g}": list(row[1:7]) for speed, row in zip(spells, rows, strict=True)
        },
    )


def _spells(memory: Array) -> list[tuple[int, int, float]]:
    """Whole stays in a state: state, leg, how long [s]."""
    both = memory[:, [STATE, law.ACTIVE]].astype(int)
    edges = np.flatnonzero((np.diff(both, axis=0) != 0).any(axis=1)) + 1
    return [(*map(int, both[a]), 0.001 * (b - a)) for a, b in pairwise(edges)]  # type: ignore[misc]


def _means(spells: list[tuple[int, int, float]]) -> list[float]:
    """Mean time in every state [s]."""
    return [
        float(np.mean([lasted for state, _, lasted in spells if state == k] or [0.0]))
        for k in range(len(law.STATES))
    ]


def _thrust(memory: Array) -> float:
    """After what part of the expected stance the ankle thrusts, mean."""
    began = np.flatnonzero(np.diff(memory[:, law.THRUST]) > 0.0) + 1
    passed = memory[began, law.THRUST] - memory[began, law.TOUCHDOWN]
    return float(np.mean(passed / memory[began, law.STANCE]))


def _claims(
    spells: dict[float, list[tuple[int, int, float]]], memories: dict[float, Array]
) -> tuple[Claim, ...]:
    steps = [(a, b) for own in spells.values() for a, b in pairwise(own)]
    ordered = [b[0] == (a[0] + 1) % len(law.STATES) for a, b in steps]
    swapped = [(a[1] != b[1]) == (b[0] == law.FLIGHT) for a, b in steps]
    short = {v: [_means(own)[k] for k in (law.LOADING, law.UNLOADING)] for v, own in spells.items()}
    thrust = {v: _thrust(memory) for v, memory in memories.items()}
    low, high = paper.THRUST
    return (
        Claim(
            said="Flight, loading, heel contact, heel and toe contact, toe contact, unloading: "
            "each "
            "leads to the next.",
            measured=f"{sum(ordered)} of {len(ordered)} transitions in this order",
            holds=all(ordered),
        ),
        Claim(
            said="At liftoff the active and the idle leg switch roles.",
            measured=f"in {sum(swapped)} of {len(swapped)} transitions the legs switch at "
            "liftoff only",
            holds=all(swapped),
        ),
        Claim(
            said="Loading and unloading are of very short duration.",
            measured="; ".join(
                f"{v:g} m/s: {1e3 * a:.0f} and {1e3 * b:.0f} ms" for v, (a, b) in short.items()
            )
            + f" (at most {1e3 * SHORT:.0f})",
            holds=max(max(pair) for pair in short.values()) <= SHORT,
        ),
        Claim(
            said="The ankle thrusts after 30 to 50 % of the expected stance, depending on speed.",
            measured=", ".join(f"{100 * at:.0f} % at {v:g} m/s" for v, at in thrust.items()),
            holds=all(low - 0.005 <= at <= high + 0.005 for at in thrust.values()),
        ),
    )


def _timeline(memory: Array, means: list[float]) -> Timeline:
    times: Array = 0.001 * np.arange(len(memory), dtype=np.float64)
    last = np.searchsorted(times, min(times[-1], _SHOWN))
    whole = sum(means)
    return Timeline(
        title="States of the active leg at 3.5 m/s",
        caption="The left leg in one color, the right in the other; beside each state how much "
        "of a "
        "step it takes.",
        names=law.STATES,
        notes=tuple(f"{100 * mean / whole:.0f} %, {1e3 * mean:.0f} ms" for mean in means),
        times=times[: last + 1],
        states=memory[: last + 1, STATE].astype(int),
        legs=memory[: last + 1, law.ACTIVE].astype(int),
    )
