"""What a candidate of a search goes through: courses, ground and pushes, drawn by chance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from understudy.athletics.course import Course

# Friction of the most slippery ground; fastest turn [rad/s] and its onset [rad/s^2]; push [N s].
_SLIPPERY, _TURN, _BENDING, _PUSH = 0.7, 0.5, 1.2, 75.0
# The long run's seconds, and how much less than 1 its friction is.
_LONG, _FAST_SLIPPERY = 8.0, (0.1, 0.25)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """One run that every candidate makes.

    Attributes:
        name: For tables.
        course: What is asked for.
        duration: [s].
        friction: Of the ground.
        push: Impulse on the pelvis [N s], world, or None.
        pushed: When [s].
    """

    name: str
    course: Course
    duration: float
    friction: float = 1.0
    push: tuple[float, float, float] | None = None
    pushed: float = 1.0


def first_scenarios(rng: np.random.Generator) -> tuple[Scenario, ...]:
    """For gains without steady states: all begin at 3.5 m/s, two change speed, and all turn."""
    out = []
    for name, speed, turning, ready, turn, end in (
        ("slow", 2.5, _TURN, 1.5, 3.2, 4.8),
        ("middle", 3.5, 1.25 * _TURN, 0.5, 1.5, 4.5),
        ("fast", 5.0, 0.5 * _TURN, 2.5, 4.6, 6.0),
    ):
        way = rng.choice((-1.0, 1.0)) * turning * (end - turn)
        rows = [(0.0, 3.5, 0.0), (0.4, 3.5, 0.0), (ready, speed, 0.0), (turn, speed, 0.0)]
        out.append(_scenario(rng, name, [*rows, (end, speed, way)]))
    return tuple(out)


def scenarios(rng: np.random.Generator, *, hardness: float = 1.0) -> tuple[Scenario, ...]:
    """From steady states: middle, slow and fast with a turn, long and fast, a change, two pushes.

    Ways, moments and friction are drawn evenly: the gains know no side. One push comes from a side,
    the other from anywhere.

    Args:
        rng: Draws the chances.
        hardness: Of turns, pushes and slippery ground, 0 to 1.
    """
    out = []
    for name, speed, turning, turn, straight, later in (
        ("middle", 3.5, _TURN, 0.5, 2.9, 3.5),
        ("slow", 2.5, 0.8 * _TURN, 0.5, 2.3, 3.0),
        ("fast", 5.0, 0.4 * _TURN, 1.4, 2.8, 4.5),
    ):
        way = rng.choice((-1.0, 1.0)) * rng.uniform(0.5, 1.0) * turning * (straight - turn)
        way *= hardness
        rows = [(0.0, speed, 0.0), (turn, speed, 0.0), (straight, speed, way)]
        out.append(_scenario(rng, name, [*rows, (straight + 1.0, later, way)], hardness))
    speed = rng.choice((4.5, 5.0))
    long = _scenario(rng, "long", [(0.0, speed, 0.0), (_LONG, speed, 0.0)], hardness)
    out.append(replace(long, friction=1.0 - hardness * float(rng.uniform(*_FAST_SLIPPERY))))
    slower, faster = rng.choice((2.5, 4.0, 5.0), 2, replace=False)
    rows = [(0.0, slower, 0.0), (0.4, slower, 0.0), (2.8, faster, 0.0), (3.8, faster, 0.0)]
    out.append(_scenario(rng, "changing", rows, hardness))
    for name, toward in (
        ("pushed aside", 0.5 * np.pi * rng.choice((-1.0, 1.0))),
        ("pushed", 0.5 * np.pi * rng.integers(4)),
    ):
        pushed = _scenario(rng, name, [(0.0, 3.5, 0.0), (3.2, 3.5, 0.0)], hardness)
        angle, strength = toward + rng.uniform(-0.3, 0.3), hardness * _PUSH
        impulse = (strength * np.cos(angle), strength * np.sin(angle), 0.0)
        out.append(replace(pushed, push=impulse, pushed=float(rng.uniform(0.4, 1.15))))
    return tuple(out)


def _scenario(
    rng: np.random.Generator,
    name: str,
    rows: Sequence[tuple[float, float, float]],
    hardness: float = 0.5,
) -> Scenario:
    """A course of rows of time, speed and heading, on a friction drawn by chance."""
    times, speeds, headings = np.array(rows).T
    course = Course(
        times=times,
        speeds=speeds,
        headings=headings,
        acceleration=1.2,
        turning=1.2 * _TURN,
        bending=_BENDING,
    )
    friction = 1.0 - hardness * float(rng.uniform(0.0, 1.0 - _SLIPPERY))
    return Scenario(name=name, course=course, duration=float(times[-1]), friction=friction)
