"""Training an athlete to start and to stop: CMA-ES over outings from standing, or to it.

Every candidate goes out at a slow, a middle and a fast speed. A generation draws speeds, friction
and how long the run lasts, so that a stop begins anywhere in a step. An outing that ends in a fall
ends the candidate. The runner's gains stay as they are; searched are those of `StandingGains`, and
for starts the slopes of the runner's below 2.5 m/s.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np

from understudy.athletics.course import Course
from understudy.athletics.gains import Schedule
from understudy.athletics.running import TIMESTEP, Running
from understudy.athletics.standing_gains import StandingGains, StandingSchedule
from understudy.athletics.standing_judge import Recorder, Samples, smoothed
from understudy.character import Athlete, athlete_man
from understudy.errors import UnknownName, require
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.scene import Ground, Scene
from understudy.simulate import quiet_engine
from understudy.simulate.trials import judged

Part = Literal["start", "stop"]

# Least and greatest value of the gains that are searched, by what they are for.
BOUNDS: dict[Part, dict[str, tuple[float, float]]] = {
    "start": {
        "lean_time": (0.20, 0.60),
        "lean_ahead": (0.15, 0.60),
        "lean_aside": (0.02, 0.10),
        "lean_pitch": (0.05, 0.40),
        "lean_dip": (0.0, 0.12),
        "lift_at": (0.03, 0.20),
        "push_at": (0.03, 0.35),
        "push": (0.0, 8.0),
        "push_hip": (0.5, 1.4),
        "push_knee": (0.7, 1.7),
        "push_time": (0.12, 0.35),
        "first_speed": (0.8, 2.0),
        "start_rate": (1.0, 2.8),
        "start_lead": (-0.12, 0.12),
        "start_thrust": (-0.3, 0.5),
        "start_lean": (0.0, 0.25),
    },
    "stop": {
        "pull": (0.8, 3.0),
        "lift": (60.0, 250.0),
        "sink": (10.0, 30.0),
        "stop_rate": (1.0, 3.0),
        "stop_lead": (0.0, 0.20),
        "stop_damping": (0.0, 40.0),
        "stop_thrust": (-0.9, 0.0),
        "stop_lean": (-0.3, 0.0),
        "stop_slow": (0.5, 2.2),
        "stop_speed": (1.2, 2.4),
        "step_time": (0.18, 0.35),
        "step_rise": (0.03, 0.10),
        "step_ahead": (-0.12, 0.05),
    },
}
# The same of the slopes of the runner's gains below 2.5 m/s, per m/s that is lacking.
SLOPES: dict[str, tuple[float, float]] = {
    "touchdown_knee": (-0.12, 0.12),
    "touchdown_foot": (-0.20, 0.05),
    "place_ahead": (-0.08, 0.08),
    "place_apart": (-0.01, 0.04),
    "speed_place": (0.0, 0.08),
    "side_place": (-0.03, 0.10),
    "speed_matching": (-0.07, 0.05),
    "knee_stiffness": (-80.0, 120.0),
    "knee_rest": (-0.12, 0.12),
    "knee_rest_thrust": (-0.10, 0.15),
    "thrust_at": (-0.12, 0.12),
    "thrust_ankle": (-0.10, 0.25),
    "thrust_stiffness": (-250.0, 50.0),
    "flat_ankle": (-0.10, 0.10),
    "flat_stiffness": (-300.0, 50.0),
    "pitch": (-0.03, 0.12),
    "swing_share": (-0.20, 0.20),
    "idle_knee": (-0.40, 0.10),
    "ready_knee": (-0.40, 0.10),
    "mirror": (-0.20, 0.20),
    "mirror_ahead": (-0.15, 0.25),
}
# Speeds of the three outings [m/s], friction, seconds at speed; how long it stands before a run and
# how long a stop is watched [s].
_SPEEDS, _FRICTION, _HOLD = ((2.5, 3.0), (3.0, 4.2), (4.2, 5.0)), (0.8, 1.0), (0.8, 1.6)
_BEGIN, _SETTLE = 0.3, 3.0
# What people do: gain and loss of speed [m/s^2], after how long [s].
_GAIN, _LOSS, _REACTION, _HALT = 1.4, 1.8, 0.35, 0.15
_FALL, _FELL, _WORST, _OUTSIDE = 30.0, 5.0, 0.3, 10.0


@dataclass(frozen=True, kw_only=True)
class Outing:
    """One run from standing, or to it, that every candidate makes.

    Attributes:
        part: Whether it starts or stops.
        speed: [m/s].
        friction: Of the ground.
        hold: How long the run lasts at its speed [s].
    """

    part: Part
    speed: float
    friction: float = 1.0
    hold: float = 1.2

    @property
    def change(self) -> float:
        """When the wish to start, or to stop, comes [s]."""
        return _BEGIN if self.part == "start" else self.hold

    @property
    def seconds(self) -> float:
        """How long it lasts [s]."""
        if self.part == "start":
            return _BEGIN + self.speed / 1.1 + 0.5 + self.hold
        return self.hold + self.speed / 1.5 + _SETTLE

    @property
    def course(self) -> Course:
        """What is asked for."""
        speeds = (0.0, self.speed) if self.part == "start" else (self.speed, 0.0)
        times = [0.0, self.change, self.change + 0.01]
        return Course(
            times=np.array(times),
            speeds=np.array([speeds[0], *speeds]),
            headings=np.zeros(3),
        )


def outings(part: Part, rng: np.random.Generator) -> tuple[Outing, ...]:
    """A slow, a middle and a fast one by chance."""
    return tuple(
        Outing(
            part=part,
            speed=float(rng.uniform(*speeds)),
            friction=float(rng.uniform(*_FRICTION)),
            hold=float(rng.uniform(*_HOLD)),
        )
        for speeds in _SPEEDS
    )


def gone(
    outing: Outing,
    schedule: Schedule,
    standing: StandingSchedule,
    body: Athlete,
    *,
    timestep: float = TIMESTEP,
) -> Samples:
    """One outing run and watched."""
    running = Running(course=outing.course, schedule=schedule, standing=standing)
    scene = Scene(characters=(body,), ground=Ground(friction=outing.friction), timestep=timestep)
    whole = Performance(scene=scene, controllers=(running,), duration=outing.seconds)
    memory, _ = judged(whole, Recorder(running=running, seconds=outing.seconds))
    return Samples.of(memory)


def cost_of(outing: Outing, seen: Samples) -> float:
    """The cost of one outing from what was seen of it."""
    if not np.isfinite(seen.rows).all() or len(seen.rows) < 2:
        return 2.0 * _FALL
    cost = _FALL * (1.0 - seen.seconds / outing.seconds) + _FELL * seen.fell + _looks(seen)
    if outing.part == "start":
        cost += _started(outing, seen)
    elif not seen.fell:
        cost += _stopped(outing, seen)
    return float(cost)


def _started(outing: Outing, seen: Samples) -> float:
    """What a start lacks: a gain of speed as people's, the speed itself at the end."""
    times, ahead = seen.times, smoothed(seen["east"])
    goal = np.clip((times - _BEGIN - _REACTION) * _GAIN, 0.0, outing.speed)
    cost = 2.0 * _mean(np.abs(ahead - goal)[times > _BEGIN])
    return cost + 3.0 * abs(_mean(ahead[times > outing.seconds - 0.8] - outing.speed))


def _looks(seen: Samples) -> float:
    """What does not look like a person: bounce, lean, roll, turning, drift, too great torques."""
    over = {
        "bounce": 80.0 * _over(seen["z"], 0.90, 1.075),
        "lean": 30.0 * _over(seen["pitch"], -0.08, 0.35),
        "roll": 30.0 * _over(seen["roll"], -0.08, 0.08),
        "turn": 15.0 * _over(seen["yaw"], -0.08, 0.08),
        "drift": _mean(np.abs(smoothed(seen["north"]))) + 0.5 * _over(seen["y"], -0.2, 0.2),
        "strain": 3.0 * float(seen["strain"][-1]),
    }
    return sum(over.values())


def _stopped(outing: Outing, seen: Samples) -> float:
    """What a stop lacks: loss of speed as people's, rest soon after, quiet, feet together."""
    after, ahead = seen.times > outing.change, smoothed(seen["east"])
    since, speed = seen.times[after] - outing.change, seen.speed[after]
    goal = np.clip(outing.speed - (since - _HALT) * _LOSS, 0.0, outing.speed)
    moving = np.nonzero(speed > 0.05)[0]
    rest = float(since[moving[-1]]) if len(moving) else 0.0
    cost = 1.5 * max(0.0, rest - outing.speed / _LOSS - 1.0)
    cost += _mean(np.abs(ahead[after] - goal)) + 4.0 * _mean(speed[-30:])
    lengthwise = abs(seen["left_x"][-1] - seen["right_x"][-1])
    sideways = abs(seen["left_y"][-1] - seen["right_y"][-1])
    return cost + 3.0 * max(0.0, lengthwise - 0.03) + 3.0 * max(0.0, sideways - 0.24)


def _mean(values: Array) -> float:
    return float(values.mean()) if len(values) else 0.0


def _over(values: Array, low: float, high: float) -> float:
    """By how much values are outside two bounds, on average."""
    return float((np.maximum(low - values, 0.0) + np.maximum(values - high, 0.0)).mean())


class StandingSpace:
    """The searched gains as numbers of 0 to 1; the others stay as they are in `start`."""

    def __init__(self, part: Part, start: StandingSchedule, names: Sequence[str] = ()):
        self.start = start
        bounds = dict(BOUNDS[part])
        if part == "start":
            bounds |= {f"slow_{name}": pair for name, pair in SLOPES.items()}
        known = list(bounds)
        for name in names:
            if name not in known:
                raise UnknownName("gain", name, known)
        self.keys = list(names or known)
        self.low, self.high = np.array([bounds[key] for key in self.keys]).T

    def numbers(self, standing: StandingSchedule) -> Array:
        """Gains as numbers; those outside their bounds are moved to them."""
        held = vars(standing.gains) | {
            f"slow_{name}": standing.slow.get(name, 0.0) for name in SLOPES
        }
        values = np.array([held[key] for key in self.keys])
        return np.clip((values - self.low) / (self.high - self.low), 0.0, 1.0)

    def schedule(self, numbers: Array) -> StandingSchedule:
        """Numbers, cut to 0 to 1, as gains."""
        values = self.low + np.clip(numbers, 0.0, 1.0) * (self.high - self.low)
        gains, slow = vars(self.start.gains).copy(), dict(self.start.slow)
        for key, value in zip(self.keys, values.tolist(), strict=True):
            own = key.removeprefix("slow_")
            (gains if own == key else slow)[own] = value
        return replace(self.start, gains=StandingGains(**gains), slow=slow)


@dataclass(frozen=True, kw_only=True)
class TrainedStanding:
    """The outcome of a search.

    Attributes:
        standing: The mean of the search's last distribution.
        history: One row per generation, as `training.Trained` has.
    """

    standing: StandingSchedule
    history: tuple[dict[str, float], ...] = field(repr=False)


def train_standing(
    part: Part,
    start: StandingSchedule,
    schedule: Schedule,
    *,
    names: Sequence[str] = (),
    body: Athlete | None = None,
    evaluations: int = 480,
    population: int = 16,
    sigma: float = 0.04,
    seed: int = 0,
    threads: int = 2,
    told: Callable[[dict[str, float]], None] | None = None,
    kept: Callable[[StandingSchedule], None] | None = None,
) -> TrainedStanding:
    """Search the gains of starts and stops by CMA-ES.

    Args:
        part: What is searched: starts or stops.
        start: Where the search begins.
        schedule: The runner's gains, with the steady state that tells the slowest run's bias.
        names: Gains to search, slopes with "slow_" before the name; all by default.
        body: Who runs; a man by default.
        evaluations: Candidates to try.
        population: Candidates of a generation.
        sigma: First step size over the range of the bounds.
        seed: Of the search and of the outings' chances.
        threads: Runs at a time.
        told: Called with each generation's row.
        kept: Called with each generation's mean.

    Raises:
        MissingExtra: The package `cma` is not installed.
    """
    cma = require("cma", extra="search")
    athlete = athlete_man() if body is None else body
    space = StandingSpace(part, start, names)
    options = {"popsize": population, "seed": seed + 1, "verbose": -9}
    search = cma.CMAEvolutionStrategy(space.numbers(start), sigma, options)
    history: list[dict[str, float]] = []
    with quiet_engine(), ThreadPoolExecutor(threads) as pool:
        while len(history) * population < evaluations:
            runs = outings(part, np.random.default_rng((seed, len(history))))
            asked = search.ask()
            one = partial(_tried, space, schedule=schedule, runs=runs, body=athlete)
            tried = list(pool.map(one, asked))
            costs = [cost for cost, _ in tried]
            search.tell(asked, costs)
            history.append(
                {
                    "generation": float(len(history)),
                    "evaluations": float((len(history) + 1) * population),
                    "least": min(costs),
                    "median": float(np.median(costs)),
                    "sigma": float(search.sigma),
                    "falls": float(np.mean([fell for _, fell in tried])),
                }
            )
            if told is not None:
                told(history[-1])
            if kept is not None:
                kept(space.schedule(search.mean))
    return TrainedStanding(standing=space.schedule(search.mean), history=tuple(history))


def _tried(
    space: StandingSpace, x: Array, schedule: Schedule, runs: Sequence[Outing], body: Athlete
) -> tuple[float, bool]:
    """The cost of a candidate, and whether it fell; after a fall it runs no more."""
    standing, costs, fell = space.schedule(x), list[float](), False
    for run in runs:
        if fell:
            costs.append(costs[-1] + 10.0)
            continue
        seen = gone(run, schedule, standing, body)
        costs.append(cost_of(run, seen))
        fell = seen.fell
    over = np.maximum(0.0, np.abs(np.asarray(x) - 0.5) - 0.5)
    cost = float(np.mean(costs)) + _WORST * max(costs) + _OUTSIDE * float((over**2).sum())
    return cost, fell
