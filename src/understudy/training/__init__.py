"""Training an athlete: CMA-ES over scenarios, on all cores, with checkpoint and resume.

Every candidate runs the same few scenarios, each with a judge beside it; a generation draws their
chances (friction, side of the turn, push), the same for all its candidates. The gains searched and
their bounds are `BOUNDS`: ranges in which a gait looks like a person's, from the first generation
on. A free search finds a crouched gait instead.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np

from understudy.athletics import running_law as law
from understudy.athletics.course import Course
from understudy.athletics.gains import Gains, Schedule
from understudy.athletics.running import TIMESTEP, Running, steady_state
from understudy.athletics.running_judge import SHARES, SPEEDS, Judge, report
from understudy.character import Athlete, athlete_man
from understudy.control import Push
from understudy.errors import UnderstudyError, UnknownName, require
from understudy.evaluate.people import people
from understudy.motion.files import written
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.scene import Ground, Scene
from understudy.simulate import quiet_engine
from understudy.simulate.trials import judged
from understudy.training.scenarios import Scenario, first_scenarios, scenarios

# Least and greatest value of every gain at 3.5 m/s, and of its slope per m/s (none: it has none).
BOUNDS: dict[str, tuple[float, float, float, float]] = {
    "touchdown_knee": (0.15, 0.60, -0.10, 0.06),
    "touchdown_foot": (0.0, 0.40, -0.10, 0.10),
    "speed_place": (0.0, 0.35, 0.0, 0.0),
    "side_place": (0.0, 0.30, -0.05, 0.05),
    "place_apart": (-0.02, 0.09, 0.0, 0.0),
    "place_ahead": (-0.40, 0.10, -0.06, 0.06),
    "place_turn": (-0.10, 0.25, 0.0, 0.0),
    "speed_matching": (0.0, 1.0, -0.15, 0.15),
    "knee_stiffness": (110.0, 700.0, -60.0, 100.0),
    "knee_damping": (2.0, 30.0, 0.0, 0.0),
    "knee_rest": (0.10, 0.50, -0.10, 0.08),
    "knee_rest_thrust": (-0.30, 0.50, -0.08, 0.05),
    "thrust_at": (0.15, 0.55, -0.08, 0.04),
    "heel_ankle": (-0.20, 0.25, 0.0, 0.0),
    "heel_stiffness": (20.0, 400.0, 0.0, 0.0),
    "flat_ankle": (-0.20, 0.35, -0.05, 0.05),
    "flat_stiffness": (150.0, 900.0, -100.0, 100.0),
    "thrust_ankle": (-0.80, -0.25, -0.10, 0.05),
    "thrust_stiffness": (100.0, 700.0, -60.0, 120.0),
    "thrust_time": (0.02, 0.12, 0.0, 0.0),
    "ankle_damping": (1.0, 15.0, 0.0, 0.0),
    "toe_stiffness": (20.0, 150.0, 0.0, 0.0),
    "pitch": (-0.05, 0.20, -0.03, 0.03),
    "roll_stiffness": (500.0, 3500.0, 0.0, 0.0),
    "roll_damping": (30.0, 300.0, 0.0, 0.0),
    "roll_support": (-120.0, 20.0, 0.0, 0.0),
    "pitch_stiffness": (300.0, 2500.0, 0.0, 0.0),
    "pitch_damping": (30.0, 300.0, 0.0, 0.0),
    "yaw_stiffness": (10.0, 400.0, 0.0, 0.0),
    "yaw_damping": (5.0, 80.0, 0.0, 0.0),
    "idle_reaction": (0.0, 1.0, 0.0, 0.0),
    "hip_stiffness": (150.0, 800.0, 0.0, 0.0),
    "hip_damping": (15.0, 100.0, 0.0, 0.0),
    "hip_turn": (-0.5, 1.0, 0.0, 0.0),
    "swing_stiffness": (150.0, 800.0, 0.0, 0.0),
    "swing_damping": (5.0, 40.0, 0.0, 0.0),
    "swing_share": (0.4, 0.95, -0.10, 0.10),
    "idle_knee": (1.2, 2.4, -0.10, 0.35),
    "idle_time": (0.08, 0.36, -0.10, 0.04),
    "ready_knee": (0.9, 2.1, -0.10, 0.30),
    "mirror": (0.4, 1.2, -0.15, 0.15),
    "mirror_ahead": (-0.1, 0.6, -0.15, 0.15),
    "idle_apart": (-0.10, 0.20, 0.0, 0.0),
    "arm_swing": (0.5, 1.3, 0.0, 0.0),
    "arm_offset": (-0.75, -0.10, 0.0, 0.0),
    "waist_stiffness": (100.0, 800.0, 0.0, 0.0),
    "waist_turn": (-0.70, 0.0, 0.0, 0.0),
    "waist_lean": (-0.05, 0.20, 0.0, 0.0),
    "flight_goal": (0.08, 0.20, -0.02, 0.02),
    "flight_thrust": (0.0, 6000.0, 0.0, 0.0),
}

# What a candidate's reports cost: weight of each sum (`running_judge.report`).
WEIGHTS: dict[str, float] = {
    "strain": 8.0,
    "effort": 2e-6,
    "lean": 8.0,
    "near": 60.0,
    "stance": 25.0,
    "period": 6.0,
    "landing_knee": 6.0,
    "stance_knee": 4.0,
    "swing_knee": 2.0,
    "toe_off_knee": 3.0,
    "plantarflexion": 4.0,
    "thigh_back": 3.0,
    "peak": 1.0,
    "impact": 4.0,
    "travel": 8.0,
    "thigh_unlike": 6.0,
    "knee_unlike": 2.5,
    "ankle_unlike": 1.2,
    "landing": 0.4,
}
_FALL, _SPEED, _HEADING, _SIDE, _ROCKING, _NEAREST = 20.0, 5.0, 8.0, 1.0, 0.05, 30.0
# Speeds of the scenarios' first states [m/s]; they are made anew after so many generations.
_SPEEDS, _REFRESH = (2.5, 3.5, 4.5, 5.0), 15
# Curves that are held against people's, in the judge's order.
_LIKE = ("thigh", "knee", "ankle")
_WORST = 0.3  # share of the worst scenario besides the mean
_OUTSIDE = 10.0  # per squared overshoot of a bound
# Turns, pushes and slippery ground begin at this share of their strength and grow to the whole in
# so many generations.
_EASY, _GROWING = 0.6, 40


def rehearsed(
    scenario: Scenario, schedule: Schedule, body: Athlete, *, timestep: float = TIMESTEP
) -> tuple[dict[str, float], Array]:
    """One scenario run and judged: what was seen, and the runner's memory at the end."""
    running = Running(course=scenario.course, schedule=schedule)
    ground = Ground(friction=scenario.friction)
    scene = Scene(characters=(body,), ground=ground, timestep=timestep)
    pushes = (
        ()
        if scenario.push is None
        else (Push(time=scenario.pushed, on="pelvis", impulse=scenario.push),)
    )
    performance = Performance(
        scene=scene, controllers=(running, *pushes), duration=scenario.duration
    )
    memory, (own,) = judged(performance, Judge(running=running, people=_people()))
    return report(memory), own


@cache
def _people() -> Array:
    """How people run, as a judge takes it."""
    rows = [
        [people(speed).curves[name][: 100 : 100 // SHARES] for name in _LIKE] for speed in SPEEDS
    ]
    return np.array(rows)


def cost_of(seen: Mapping[str, float], duration: float) -> float:
    """The cost of one run from what was seen of it."""
    if not all(np.isfinite(value) for value in seen.values()):
        return 2.0 * _FALL
    cost = _FALL * (1.0 - min(1.0, seen["time"] / (duration - 0.002)))
    if seen["steps"] < 2 or seen["flight"] < 2:
        return cost + _FALL
    cost += _SPEED * np.sqrt(seen["speed"]) + _HEADING * np.sqrt(seen["heading"])
    cost += _SIDE * np.sqrt(seen["side"]) + _ROCKING * np.sqrt(seen["rocking"])
    cost += _NEAREST * max(0.0, 0.105 - seen["nearest"])
    return float(cost + sum(weight * seen[name] for name, weight in WEIGHTS.items()))


class Space:
    """The searched gains as numbers of 0 to 1; the others stay as they are in `start`."""

    def __init__(self, start: Schedule, names: Sequence[str] = ()):
        low, high, self.keys, self.start = [], [], [], start
        for name in names or BOUNDS:
            if name not in BOUNDS:
                raise UnknownName("gain", name, BOUNDS)
            least, most, least_slope, most_slope = BOUNDS[name]
            self.keys.append((name, "gain"))
            low.append(least)
            high.append(most)
            if most_slope > least_slope:
                self.keys.append((name, "slope"))
                low.append(least_slope)
                high.append(most_slope)
        self.low, self.high = np.array(low), np.array(high)

    def numbers(self, schedule: Schedule) -> Array:
        """A schedule as numbers; gains outside their bounds are moved to them."""
        values = [
            getattr(schedule.gains, name) if kind == "gain" else schedule.slopes.get(name, 0.0)
            for name, kind in self.keys
        ]
        return np.clip((np.array(values) - self.low) / (self.high - self.low), 0.0, 1.0)

    def schedule(self, numbers: Array) -> Schedule:
        """Numbers, cut to 0 to 1, as a schedule."""
        values = self.low + np.clip(numbers, 0.0, 1.0) * (self.high - self.low)
        gains, slopes = vars(self.start.gains).copy(), dict(self.start.slopes)
        for (name, kind), value in zip(self.keys, values.tolist(), strict=True):
            (gains if kind == "gain" else slopes)[name] = value
        return replace(self.start, gains=Gains(**gains), slopes=slopes)


@dataclass(frozen=True, kw_only=True)
class Trained:
    """The outcome of a search.

    Attributes:
        schedule: The best gains: the mean of the search's last distribution.
        history: One row per generation: number, evaluations, least and median cost, step size.
    """

    schedule: Schedule
    history: tuple[dict[str, float], ...] = field(repr=False)


def train(
    start: Schedule,
    *,
    names: Sequence[str] = (),
    body: Athlete | None = None,
    evaluations: int = 2000,
    population: int = 20,
    sigma: float = 0.05,
    seed: int = 0,
    threads: int = 2,
    checkpoint: Path | None = None,
    told: Callable[[dict[str, float]], None] | None = None,
) -> Trained:
    """Search gains by CMA-ES.

    Args:
        start: Where the search begins; with its steady states, from which runs begin.
        names: Gains to search, with their slopes; all by default.
        body: Who runs; a man by default.
        evaluations: Candidates to try, those of the checkpoint included.
        population: Candidates of a generation.
        sigma: First step size over the range of the bounds.
        seed: Of the search and of the scenarios' chances.
        threads: Runs at a time.
        checkpoint: File that keeps the search after every generation; a search goes on from it.
        told: Called with each generation's row.

    Raises:
        MissingExtra: The package `cma` is not installed.
        UnderstudyError: The checkpoint is of another search.
    """
    cma = require("cma", extra="search")
    athlete = athlete_man() if body is None else body
    space = Space(start, names)
    settings: dict[str, Any] = {
        "population": population,
        "seed": seed,
        "body": athlete.name,
        "sigma": sigma,
    }
    settings["gains"] = ", ".join(f"{name} {kind}" for name, kind in space.keys)
    saved = _read(checkpoint, settings)
    history: list[dict[str, float]] = list(saved.get("history", []))
    starts = tuple(saved.get("starts", start.starts))
    mean = np.array(saved["mean"]) if saved else space.numbers(start)
    options = {"popsize": population, "seed": seed + 1 + len(history), "verbose": -9}
    options |= {"CMA_diagonal": 0}
    search = cma.CMAEvolutionStrategy(mean, saved.get("sigma_now", sigma), options)
    if saved:
        _restore(search, saved)
    with quiet_engine(), ThreadPoolExecutor(threads) as pool:
        while len(history) * population < evaluations:
            rng = np.random.default_rng((seed, len(history)))
            if len(history) % _REFRESH == 0:
                starts = _states(space.schedule(search.mean), athlete, starts)
            grown = min(1.0, len(history) / _GROWING)
            hardness = _EASY + (1.0 - _EASY) * grown
            runs = scenarios(rng, hardness=hardness) if starts else first_scenarios(rng)
            asked = search.ask()
            gains = [replace(space.schedule(x), starts=starts) for x in asked]
            seen = list(pool.map(_tried, gains, repeat(runs), repeat(athlete)))
            costs = _costs(asked, runs, seen)
            search.tell(asked, costs)
            row = _row(len(history), population, costs, search.sigma, seen)
            history.append(row)
            if told is not None:
                told(row)
            if checkpoint is not None:
                _write(checkpoint, settings, search, history, space, starts)
    found = replace(space.schedule(search.mean), starts=starts)
    return Trained(schedule=found, history=tuple(history))


def _states(
    schedule: Schedule, body: Athlete, before: tuple[Mapping[str, Any], ...]
) -> tuple[Mapping[str, Any], ...]:
    """Steady states of a schedule at the speeds of the scenarios; those before where all fell."""
    made, fallen = steady_states(replace(schedule, starts=before), body, _SPEEDS, seconds=4.0)
    return before if len(fallen) == len(_SPEEDS) else made.starts


def _tried(schedule: Schedule, runs: Sequence[Scenario], body: Athlete) -> list[dict[str, float]]:
    """What was seen of one candidate in each scenario; after a fall the rest is not run."""
    out: list[dict[str, float]] = []
    for run in runs:
        out.append(rehearsed(run, schedule, body)[0])
        if out[-1]["fell"]:
            break
    return out


def _costs(asked: Sequence[Array], runs: Sequence[Scenario], seen: Sequence[Any]) -> list[float]:
    out = []
    for x, tried in zip(asked, seen, strict=True):
        own = [cost_of(one, run.duration) for one, run in zip(tried, runs, strict=False)]
        own += own[-1:] * (len(runs) - len(own))  # a run not made costs as much as the fall
        over = np.maximum(0.0, np.abs(np.asarray(x) - 0.5) - 0.5)
        out.append(float(np.mean(own) + _WORST * max(own) + _OUTSIDE * (over**2).sum()))
    return out


def _row(
    number: int,
    population: int,
    costs: Sequence[float],
    sigma: float,
    seen: Sequence[Sequence[Mapping[str, float]]],
) -> dict[str, float]:
    """A generation as one row of the table."""
    chosen = seen[int(np.argmin(costs))]
    row = {
        "generation": float(number),
        "evaluations": float((number + 1) * population),
        "least": float(min(costs)),
        "median": float(np.median(costs)),
        "sigma": float(sigma),
        "falls": float(np.mean([own[-1]["fell"] for own in seen])),
    }
    return row | {
        f"best_{name}": float(np.mean([one[name] for one in chosen]))
        for name in ("speed", "heading", "strain", "lean", "mean_landing_knee", "mean_peak")
    }


def _read(path: Path | None, settings: Mapping[str, Any]) -> dict[str, Any]:
    if path is None or not path.exists():
        return {}
    try:
        saved = json.loads(path.read_text(encoding="utf-8"))
        before = saved["settings"]
    except (OSError, ValueError, KeyError) as error:
        raise UnderstudyError(f"{path}: is not a training checkpoint ({error}).") from None
    if before != dict(settings):
        raise UnderstudyError(
            f"{path}: belongs to another search ({before}); give another file or remove it."
        )
    return saved


def _write(
    path: Path,
    settings: Mapping[str, Any],
    search: Any,
    history: Sequence[Mapping[str, float]],
    space: Space,
    starts: Sequence[Mapping[str, Any]],
) -> None:
    saved = {
        "settings": dict(settings),
        "history": list(history),
        "mean": np.asarray(search.mean).tolist(),
        "sigma_now": float(search.sigma),
        "covariance": np.asarray(search.C).tolist(),
        "schedule": replace(space.schedule(np.asarray(search.mean)), starts=()).as_json(),
        "starts": [dict(one) for one in starts],
    }
    with written(path) as temporary:
        temporary.write_text(json.dumps(saved), encoding="utf-8")


def _restore(search: Any, saved: Mapping[str, Any]) -> None:
    """Give a new search the shape of the saved one; its paths begin anew."""
    covariance = np.array(saved["covariance"])
    search.sm.C[:] = covariance
    search.sm.update_now(0)


def steady_states(
    schedule: Schedule, body: Athlete, speeds: Sequence[float], *, seconds: float = 12.0
) -> tuple[Schedule, tuple[float, ...]]:
    """The schedule with steady states to start from, and the speeds [m/s] at which runs fell.

    Each is the state at the last liftoff of the left foot of a run that reached its speed slowly.
    """
    found, fallen = [], []
    for speed in speeds:
        try:
            found.append(_steady(schedule, body, speed, seconds))
        except UnderstudyError:
            fallen.append(speed)
    others = [s for s in schedule.starts if s["athlete"] != body.name]
    return replace(schedule, starts=(*others, *found)), tuple(fallen)


def _steady(schedule: Schedule, body: Athlete, speed: float, seconds: float) -> Mapping[str, Any]:
    """A steady state at one speed [m/s].

    Raises:
        UnderstudyError: The run fell.
    """
    from understudy.simulate import simulate

    reach = 1.0 + abs(speed - 3.5) / 0.5
    course = Course(
        times=np.array([0.0, 1.0, reach + 0.1]),
        speeds=np.array([3.5, 3.5, speed]),
        headings=np.zeros(3),
    )
    running = Running(course=course, schedule=schedule)
    scene = Scene(characters=(body,), timestep=TIMESTEP)
    whole = Performance(scene=scene, controllers=(running,), duration=reach + seconds)
    seen, (memory,) = judged(whole, Judge(running=running))
    if report(seen)["fell"]:
        raise UnderstudyError(f"The run at {speed:g} m/s fell; train longer.")
    moment = float(memory[law.LIFTOFF])
    if memory[law.ACTIVE] != law.RIGHT:  # then the right foot left last; take the step before
        moment -= 1e-9
    raise_at = _liftoff(whole, running, moment)
    take = simulate(replace(whole, duration=raise_at))
    _, (kept,) = judged(replace(whole, duration=raise_at), Judge(running=running))
    part = scene.parts[0]
    return steady_state(
        *(body, speed, take.qpos[-1, part.qpos], take.qvel[-1, part.dofs], kept),
        float(take.times[-1]),
    )


def _liftoff(whole: Performance, running: Running, moment: float) -> float:
    """Duration that ends right after a liftoff of the left foot, not after `moment` [s]."""
    _, (memory,) = judged(replace(whole, duration=moment - 0.002), Judge(running=running))
    if memory[law.ACTIVE] == law.RIGHT:
        return float(memory[law.LIFTOFF]) + 2.0 * TIMESTEP
    return moment + 2.0 * TIMESTEP
