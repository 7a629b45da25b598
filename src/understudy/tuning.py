"""Searches over performances: the overall stiffness by gradient (Zordan & Hodgins 1999, eq. 3).

The error of a tracked clip falls as the servos stiffen, toward a floor set by the servo's lag, so
the error alone sends the search to any upper bound. A cost on torque puts the optimum where more
stiffness no longer buys accuracy; a bound keeps the search among gains that simulate well.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize
from tqdm import tqdm

from understudy.control import Tracking
from understudy.errors import InvalidValue, UnderstudyError, expect
from understudy.motion import rotations as rot
from understudy.motion.files import written
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.simulate import simulate_many
from understudy.take import Take

# Beyond this the cost is all torque; a survey this fine has a trial every 1 % of stiffness.
MOST_WEIGHT, MOST_TRIALS = 1e4, 1000


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One stiffness and what it gave.

    Attributes:
        stiffness: Overall stiffness [1/s^2].
        error: Equation 3 per joint and frame: mean angle between desired and actual [rad].
        torque: Root mean square servo torque over joints and time, over body weight times height.
        cost: error + torque_weight * torque.
    """

    stiffness: float
    error: float
    torque: float
    cost: float


@dataclass(frozen=True, kw_only=True)
class Tuned:
    """The result of a search.

    Attributes:
        best: The trial of least cost.
        trials: Every trial, by stiffness.
        performance: The performance with the best stiffness.
        settings: What the search was asked.
    """

    best: Trial
    trials: tuple[Trial, ...]
    performance: Performance
    settings: dict[str, Any]


def tracking_error(take: Take, character: int = 0) -> float:
    """Equation 3 of Zordan & Hodgins 1999 per joint and frame [rad], the root left out."""
    reference, simulated = _reference(take, character), take.clip(character)
    frames = min(reference.frames, simulated.frames)
    angles = rot.angle_between(reference.rotations[:frames, 1:], simulated.rotations[:frames, 1:])
    return float(angles.mean()) if angles.size else 0.0


def servo_torques(take: Take, character: int = 0) -> Array:
    """Torque of every joint servo but the root's [N m], link frame, shape (frames, links - 1, 3).

    Evaluated from the recorded states and controls by the servo's own law,
    k log(actual^-1 commanded) - kd omega, bounded as the engine bounds it.
    """
    part, model = take.scene.parts[character], take.model
    actuators = list(part.joint_actuators)
    k, kd = model.actuator_gainprm[actuators, 0], -model.actuator_biasprm[actuators, 2]
    state = take.qpos[:, part.qpos]
    actual = state[:, 7:].reshape(len(state), -1, 4)
    columns = np.asarray(part.joint_controls, int)[:, None] + np.arange(4)
    error = rot.to_rotvec(rot.multiply(rot.conjugate(actual), take.ctrl[:, columns]))
    rates = take.qvel[:, part.dofs][:, 6:].reshape(len(state), -1, 3)
    torque = k[:, None] * error - kd[:, None] * rates
    limit = np.where(
        model.actuator_forcelimited[actuators].astype(bool),
        model.actuator_forcerange[actuators, 1],
        np.inf,
    )
    length = np.linalg.norm(torque, axis=-1, keepdims=True)
    return torque * np.minimum(1.0, limit[:, None] / np.maximum(length, 1e-12))


def tune(
    performance: Performance,
    *,
    torque_weight: float = 1.0,
    bounds: tuple[float, float] = (10.0, 1e5),
    survey: int = 9,
    iterations: int = 12,
    checkpoint: str | Path | None = None,
    progress: bool = False,
) -> Tuned:
    """Search the overall stiffness of a tracking performance.

    A survey of the bounds in equal ratios finds the valley; a bounded quasi-Newton search on the
    logarithm of stiffness, with central differences, finds its bottom. Trials run as batches on
    all cores and are kept in `checkpoint`, so a search that was stopped goes on where it was.

    Args:
        performance: One that has a `Tracking` controller.
        torque_weight: Cost of torque: radians of error worth one body weight times height.
        bounds: Least and greatest stiffness [1/s^2].
        survey: Number of trials of the survey, at least 2.
        iterations: Most steps of the gradient search.
        checkpoint: JSON file of trials; read when it exists, written after every batch.
        progress: Show a progress bar on standard error.

    Raises:
        InvalidValue: Nothing to tune, or bounds out of order.
        UnderstudyError: The checkpoint belongs to another search or is not one, or every trial
            diverged.
    """
    expect(performance, Performance, "performance", "a Performance, as `tracked` gives")
    low, high = bounds
    if not 0 < low < high <= 1e7:
        raise InvalidValue(f"bounds are {bounds}; they must rise and lie in 0 to 1e7.")
    if not 0.0 <= torque_weight <= MOST_WEIGHT:
        raise InvalidValue(
            f"torque_weight is {torque_weight}; it must lie in 0 to {MOST_WEIGHT:g}."
        )
    if not 2 <= survey <= MOST_TRIALS:
        raise InvalidValue(f"survey is {survey}; it must lie in 2 to {MOST_TRIALS}.")
    if not 0 <= iterations <= MOST_TRIALS:
        raise InvalidValue(f"iterations is {iterations}; it must lie in 0 to {MOST_TRIALS}.")
    which = [i for i, c in enumerate(performance.controllers) if isinstance(c, Tracking)]
    if not which:
        raise InvalidValue("The performance has no Tracking controller to tune.")
    base = performance.controllers[which[0]]
    assert isinstance(base, Tracking)
    settings = {
        "clip": base.reference.name,
        "frames": base.reference.frames,
        "law": base.law,
        "pelvis": base.pelvis,
        "torque_weight": torque_weight,
        "bounds": [low, high],
    }
    known = _read(checkpoint, settings)

    def with_stiffness(value: float) -> Performance:
        controllers = list(performance.controllers)
        controllers[which[0]] = replace(base, stiffness=value)
        return replace(performance, controllers=tuple(controllers))

    def evaluate(values: Sequence[float]) -> list[float]:
        wanted = [v for v in dict.fromkeys(float(f"{v:.6g}") for v in values) if v not in known]
        runs = simulate_many([with_stiffness(v) for v in wanted])
        for value, take in zip(wanted, runs, strict=True):
            if isinstance(take, Take):
                known[value] = _trial(value, take, base.character, torque_weight)
            else:
                known[value] = Trial(stiffness=value, error=np.inf, torque=np.inf, cost=np.inf)
            bar.update(1)
        _write(checkpoint, settings, known)
        return [known[float(f"{v:.6g}")].cost for v in values]

    hidden = None if progress else True  # None: shown on a terminal only
    with tqdm(desc="tune", unit="run", delay=2.0, disable=hidden, leave=False) as bar:
        grid = list(np.geomspace(low, high, survey))
        costs = evaluate(grid)
        if not np.isfinite(costs).any():
            raise UnderstudyError("Every trial diverged; lower the bounds or the time step.")
        # From the survey alone, not from later trials: a resumed search then takes the same steps.
        start = np.log(grid[int(np.argmin(costs))])
        h = 0.05

        def cost_and_slope(x: Array) -> tuple[float, Array]:
            left, right = max(x[0] - h, np.log(low)), min(x[0] + h, np.log(high))
            at, below, above = evaluate([float(np.exp(v)) for v in (x[0], left, right)])
            if not np.isfinite([at, below, above]).all():
                return 1e6, np.array([1.0])
            return at, np.array([(above - below) / (right - left)])

        minimize(
            cost_and_slope,
            np.array([start]),
            jac=True,
            method="L-BFGS-B",
            bounds=[(np.log(low), np.log(high))],
            options={"maxiter": iterations, "ftol": 1e-6},
        )
    trials = tuple(sorted(known.values(), key=lambda t: t.stiffness))
    best = min(trials, key=lambda t: t.cost)
    return Tuned(
        best=best,
        trials=trials,
        performance=with_stiffness(best.stiffness),
        settings=settings,
    )


def _reference(take: Take, character: int):  # type: ignore[no-untyped-def]
    reference = take.references[character]
    if reference is None:
        raise InvalidValue("This take has no reference clip to compare with.")
    return reference


def _trial(stiffness: float, take: Take, character: int, weight: float) -> Trial:
    body = take.scene.characters[character]
    error = tracking_error(take, character)
    torques = np.linalg.norm(servo_torques(take, character), axis=-1)
    scale = body.mass * 9.81 * body.height
    torque = float(np.sqrt((torques**2).mean()) / scale)
    return Trial(stiffness=stiffness, error=error, torque=torque, cost=error + weight * torque)


def _read(path: str | Path | None, settings: dict[str, Any]) -> dict[float, Trial]:
    if path is None or not Path(path).exists():
        return {}
    try:
        saved = json.loads(Path(path).read_text(encoding="utf-8"))
        # A trial that diverged has no numbers; JSON knows no infinity, so it is null there.
        trials = [
            Trial(**{k: np.inf if v is None else float(v) for k, v in t.items()})
            for t in saved["trials"]
        ]
        before = saved["settings"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UnderstudyError(f"{path}: is not a tuning checkpoint ({error}).") from None
    if before != settings:
        raise UnderstudyError(
            f"{path}: belongs to another search ({before}); give another file or remove it."
        )
    return {t.stiffness: t for t in trials}


def _write(path: str | Path | None, settings: dict[str, Any], trials: dict[float, Trial]) -> None:
    if path is None:
        return
    rows = [{k: v if np.isfinite(v) else None for k, v in vars(t).items()} for t in trials.values()]
    saved = {"settings": settings, "trials": rows}
    with written(path) as temporary:
        temporary.write_text(json.dumps(saved, indent=1), encoding="utf-8")
