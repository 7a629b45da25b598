"""The two searches of drive parameters: a random walk and CMA-ES."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from tqdm import tqdm

from understudy.character import Linkage
from understudy.control import Drive
from understudy.control.differences import ORDERS
from understudy.drive_tuning.trials import DriveTrial, TunedDrive
from understudy.errors import Diverged, InvalidValue, UnderstudyError, require
from understudy.fidelity import drive_error
from understudy.motion.clip import Clip
from understudy.motion.files import written
from understudy.performance import Performance, driven
from understudy.simulate import quiet_engine, simulate

Method = Literal["monte_carlo", "cma"]
METHODS: tuple[Method, ...] = ("monte_carlo", "cma")
# Wilke & Semwal 2017: frames per second of their clips, and the size of the simulated model over
# the clip's that their K_vc of 85 to 86 implies (K_vc = scale x frame rate).
PAPER_RATE, PAPER_SCALE = 60.0, 1.4286
# Their first points, section 2: K_f and K_vc of independent bodies and of physical skeletons.
PAPER_START = {
    "independent": (100.0, 75.0),
    "skeleton": (20.0, 100.0),
    "constrained": (20.0, 100.0),
    "tree": (20.0, 100.0),
}
# Largest share of the limit 2 / dt that a search tries. Errors fall up to the limit itself, but
# joined bodies tuned there fly apart on other clips (09_12 of the CMU motions from 0.995 on).
_MOST = 0.98
# CMA-ES: bounds and first widths of K_f dt / 2, of K_vc over rate and scale, and of n's number.
_LOW, _HIGH, _WIDTHS = (0.02, 0.5), (_MOST, 2.0), (0.25, 0.05, 1.0)
_CHUNK = 64


def tune_drive(
    clip: Clip,
    linkage: Linkage,
    *,
    method: Method = "monte_carlo",
    points: int = 100,
    runs: int = 1,
    evaluations: int = 90,
    max_order: int = 19,
    start: tuple[float, float] | None = None,
    rate: float = PAPER_RATE,
    scale: float = PAPER_SCALE,
    gravity: float | None = None,
    seed: int = 0,
    threads: int | None = None,
    checkpoint: str | Path | None = None,
    progress: bool = False,
) -> TunedDrive:
    """Search K_f, K_vc and n of the paper's law for the least error on a clip.

    The same seed gives the same numbers on any number of threads, stopped and resumed or not.

    Args:
        clip: The clip, on the linkage's skeleton.
        linkage: See `Linkage.from_clip`.
        method: "monte_carlo" (algorithm 1) or "cma".
        points: Points of a run of algorithm 1; each takes one simulation per order.
        runs: Runs of algorithm 1; each begins at the best of the one before.
        evaluations: Most simulations of CMA-ES.
        max_order: Greatest order n tried, odd, 3 to 19.
        start: First K_f [1/s] and K_vc; by default the paper's.
        rate: Frames per second to resample the clip to, one physics step each [Hz].
        scale: Size of the simulated model over the clip's; see `driven`.
        gravity: Downward acceleration [m/s^2]; by default the paper's 9.81 units/s^2.
        seed: Seed of the search.
        threads: Simulations at a time; all cores by default.
        checkpoint: JSON file of trials; read when it exists, written after every batch.
        progress: Show a progress bar on standard error.

    Raises:
        InvalidValue: A value out of range, or a first gain too large for the step (K_f dt >= 2).
        MissingExtra: "cma" without the package cma (extra `search`).
        UnderstudyError: The checkpoint belongs to another search or is not one, or every trial
            diverged.
    """
    if method not in METHODS:
        raise InvalidValue(f"method is {method!r}; it must be one of {', '.join(METHODS)}.")
    for name, value in (("points", points), ("runs", runs), ("evaluations", evaluations)):
        if not 1 <= value <= 1_000_000:
            raise InvalidValue(f"{name} is {value}; it must lie in 1 to 1000000.")
    if max_order not in ORDERS:
        raise InvalidValue(f"max_order is {max_order}; it must be odd, from 3 to 19.")
    base = driven(
        clip, linkage, law="paper", rate=rate, scale=scale, gravity=gravity, order=max_order
    )
    first = _first(linkage, rate * scale, start)
    _with(base, DriveTrial(gain=first[0], speed=first[1], order=3, error=0.0, variance=0.0))
    settings = {
        "clip": clip.name,
        "kind": linkage.kind,
        "method": method,
        "duration_s": base.duration,
        "rate_hz": float(rate),
        "scale": float(scale),
        "gravity_m_per_s2": base.scene.gravity * scale,
        "gravity_units_per_s2": base.scene.gravity * scale / linkage.unit,
        "unit_m": linkage.unit,
        "max_order": max_order,
        "start": list(first),
        "seed": seed,
    }
    walk = method == "monte_carlo"
    settings |= {"points": points} if walk else {}
    total = points * runs * len(_orders(max_order)) if walk else evaluations
    search = _Search(base, settings, checkpoint, threads)
    with (
        search,
        tqdm(
            total=total,
            desc="tune",
            unit="run",
            delay=2.0,
            disable=None if progress else True,
            leave=False,
        ) as b,
    ):
        search.tell = b.update
        if walk:
            for run in range(runs):
                trials = search.tried(_walk(first, points, max_order, rate, scale, (seed, run)))
                best = min(trials, key=lambda t: t.error)
                first = best.gain, best.speed
        else:
            _evolve(search, first, evaluations, max_order, rate, scale, seed)
    best = min(search.order_tried, key=lambda t: t.error)
    if not np.isfinite(best.error):
        raise UnderstudyError("Every trial diverged; begin at a smaller gain.")
    return TunedDrive(best=best, trials=tuple(search.order_tried), settings=settings)


# -- the two searches -------------------------------------------------------------------------

Point = tuple[float, float, int]  # K_f, K_vc, n


def _orders(max_order: int) -> list[int]:
    return [n for n in ORDERS if n <= max_order]


def _first(
    linkage: Linkage, per_second: float, start: tuple[float, float] | None
) -> tuple[float, float]:
    """First K_f and K_vc; the paper's K_vc is carried over to other rates and scales."""
    if start is None:
        gain, speed = PAPER_START[linkage.kind]
        return gain, speed * per_second / (PAPER_RATE * PAPER_SCALE)
    gain, speed = (float(value) for value in start)
    if not (np.isfinite([gain, speed]).all() and gain > 0 and speed > 0):
        raise InvalidValue(f"start is {start}; K_f and K_vc must be positive.")
    return gain, speed


def _walk(
    start: tuple[float, float],
    points: int,
    max_order: int,
    rate: float,
    scale: float,
    seed: tuple[int, int],
) -> list[Point]:
    """Every point of one run of algorithm 1: K_f and K_vc wander by up to 1 a simulation."""
    orders = _orders(max_order)
    count = points * len(orders)
    steps = np.random.default_rng(seed).uniform(-1.0, 1.0, (count - 1, 2))
    steps[:, 1] *= rate * scale / (PAPER_RATE * PAPER_SCALE)
    wandered = np.array(start) + np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0)))
    gains = _reflected(wandered[:, 0], 1.0, _MOST * 2.0 * rate)
    speeds = np.maximum(np.abs(wandered[:, 1]), 1e-3)
    turns = zip(gains, speeds, orders * points, strict=True)
    return [(float(gain), float(speed), n) for gain, speed, n in turns]


def _reflected(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """A walk folded back at both ends."""
    low = min(low, float(values[0]))
    span = high - low
    away = np.mod(values - low, 2.0 * span)
    return low + np.where(away > span, 2.0 * span - away, away)


def _evolve(
    search: _Search,
    start: tuple[float, float],
    evaluations: int,
    max_order: int,
    rate: float,
    scale: float,
    seed: int,
) -> None:
    """CMA-ES over K_f dt / 2, K_vc / (rate scale) and the number of the order.

    The best gains lie at the bound, so what is drawn beyond it is run at it: the search then gets
    there in a few generations, where a smooth map of the bounds approaches it ever more slowly.
    """
    cma = require("cma", extra="search")
    orders = _orders(max_order)
    low, high = [*_LOW, -0.5], [*_HIGH, len(orders) - 0.5]
    first = [start[0] / (2.0 * rate), start[1] / (rate * scale), min(1, len(orders) - 1)]
    first = [float(np.clip(v, a, b)) for v, a, b in zip(first, low, high, strict=True)]
    draws = np.random.default_rng(seed)
    evolution = cma.CMAEvolutionStrategy(
        first,
        1.0,
        {
            "CMA_stds": list(_WIDTHS),
            "verbose": -9,
            "verb_log": 0,
            "seed": float("nan"),  # the package leaves NumPy's own generator alone
            "randn": lambda *shape: draws.standard_normal(shape),
        },
    )
    left = evaluations
    while left > 0 and not evolution.stop():
        asked = evolution.ask()
        points: list[Point] = [
            (
                float(x[0] * 2.0 * rate),
                float(x[1] * rate * scale),
                orders[int(np.clip(np.rint(x[2]), 0, len(orders) - 1))],
            )
            for x in (np.clip(x, low, high) for x in asked)
        ]
        trials = search.tried(points[:left])
        left -= len(trials)
        if len(trials) < len(asked):
            break
        evolution.tell(asked, [min(t.error, 1e30) for t in trials])


# -- running them -----------------------------------------------------------------------------


class _Search:
    """Runs points in threads, one simulation each, and keeps what they gave."""

    def __init__(
        self,
        base: Performance,
        settings: dict[str, Any],
        checkpoint: str | Path | None,
        threads: int | None,
    ):
        self.base, self.settings, self.checkpoint = base, settings, checkpoint
        self.known = _read(checkpoint, settings)
        self.order_tried: list[DriveTrial] = []
        self.tell: Callable[[int], object] = lambda n: None
        self.pool = ThreadPoolExecutor(max(1, threads or os.cpu_count() or 1))
        self.quiet = quiet_engine()

    def __enter__(self) -> _Search:
        self.quiet.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self.pool.shutdown(cancel_futures=True)
        self.quiet.__exit__(*error)

    def tried(self, points: Sequence[Point]) -> list[DriveTrial]:
        """The trials of points, in their order; known ones are not run again."""
        out = []
        for chunk in _chunks(points):
            new = [p for p in dict.fromkeys(chunk) if p not in self.known]
            for point, trial in zip(new, self.pool.map(self._run, new), strict=True):
                self.known[point] = trial
                self.tell(1)
            if new:
                _write(self.checkpoint, self.settings, self.known)
            self.tell(len(chunk) - len(new))
            out += [self.known[p] for p in chunk]
        self.order_tried += out
        return out

    def _run(self, point: Point) -> DriveTrial:
        gain, speed, order = point
        trial = DriveTrial(gain=gain, speed=speed, order=order, error=np.inf, variance=np.inf)
        try:
            found = drive_error(simulate(_with(self.base, trial)))
        except Diverged:
            return trial
        return replace(trial, error=found.mean, variance=found.variance)


def _chunks(points: Sequence[Point]) -> Iterator[Sequence[Point]]:
    for first in range(0, len(points), _CHUNK):
        yield points[first : first + _CHUNK]


def _with(base: Performance, trial: DriveTrial) -> Performance:
    """The performance with a trial's parameters; refuses K_f dt >= 2."""
    (drive,) = base.controllers
    assert isinstance(drive, Drive)
    per_second = drive.reference.rate * drive.scale
    new = replace(
        drive, gain=trial.gain, order=trial.order, velocity_scale=trial.speed / per_second
    )
    new.check(base.scene)
    return replace(base, controllers=(new,))


def _read(path: str | Path | None, settings: dict[str, Any]) -> dict[Point, DriveTrial]:
    if path is None or not Path(path).exists():
        return {}
    try:
        saved = json.loads(Path(path).read_text(encoding="utf-8"))
        trials = [_from_plain(row) for row in saved["trials"]]
        before = saved["settings"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UnderstudyError(f"{path}: is not a checkpoint of this search ({error}).") from None
    if before != settings:
        raise UnderstudyError(
            f"{path}: belongs to another search ({before}); give another file or remove it."
        )
    return {(t.gain, t.speed, t.order): t for t in trials}


def _from_plain(row: Mapping[str, Any]) -> DriveTrial:
    """A trial from JSON, which knows no infinity: null stands for it."""
    values = {k: np.inf if v is None else float(v) for k, v in row.items()}
    return DriveTrial(**{**values, "order": int(row["order"])})  # type: ignore[arg-type]


def _write(
    path: str | Path | None, settings: dict[str, Any], trials: Mapping[Point, DriveTrial]
) -> None:
    if path is None:
        return
    rows = [
        {k: v if np.isfinite(v) else None for k, v in asdict(t).items()} for t in trials.values()
    ]
    with written(path) as temporary:
        text = json.dumps({"settings": settings, "trials": rows}, indent=1, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")
