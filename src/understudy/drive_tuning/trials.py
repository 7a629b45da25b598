"""What a search of drive parameters tried and found, and the best of it as a file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from understudy.errors import UnderstudyError
from understudy.motion.files import written

_FORMAT = "understudy drive parameters 1"


@dataclass(frozen=True, kw_only=True)
class DriveTrial:
    """One simulation of a search.

    Attributes:
        gain: K_f [1/s].
        speed: K_vc, clip velocities per frame to simulated ones per second.
        order: Order n of the central differences.
        error: Equation 4 [units^2]; infinite where the simulation diverged.
        variance: Variance over joints of their mean squared errors [units^4].
    """

    gain: float
    speed: float
    order: int
    error: float
    variance: float


@dataclass(frozen=True, kw_only=True)
class TunedDrive:
    """The result of a search.

    Attributes:
        best: The trial of least error, the first of equals.
        trials: Every trial in the order of the search.
        settings: What was searched: clip, linkage, method, rate, gravity, scale, unit, seed, ...
    """

    best: DriveTrial
    trials: tuple[DriveTrial, ...] = field(repr=False)
    settings: dict[str, Any] = field(repr=False)

    @property
    def parameters(self) -> dict[str, Any]:
        """Keyword arguments of `driven` that use the best trial on any clip."""
        return parameters_of(self.best, self.settings)

    def simulations_to(self, error: float) -> int | None:
        """How many simulations the search took to reach an error [units^2]; None if it did not."""
        for count, trial in enumerate(self.trials, 1):
            if trial.error <= error:
                return count
        return None

    def __str__(self) -> str:
        s, b = self.settings, self.best
        return (
            f"{s['kind']}: squared error {b.error:.4g} units^2 (variance {b.variance:.3g}) at K_f "
            f"{b.gain:.4g} /s, K_vc {b.speed:.4g}, n {b.order}, after {len(self.trials)} "
            f"simulations of {s['duration_s']:.4g} s [1 unit = {1e3 * s['unit_m']:.4g} mm, gravity "
            f"{s['gravity_units_per_s2']:.4g} units/s^2, scale {s['scale']:g}, step "
            f"{1e3 / s['rate_hz']:.4g} ms]"
        )


def parameters_of(trial: DriveTrial, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Keyword arguments of `driven` for a trial of a search with these settings."""
    per_second = settings["rate_hz"] * settings["scale"]
    return {
        "law": "paper",
        "rate": settings["rate_hz"],
        "scale": settings["scale"],
        "gravity": settings["gravity_m_per_s2"],
        "gain": trial.gain,
        "order": trial.order,
        "velocity_scale": trial.speed / per_second,
    }


def write_parameters(tuned: TunedDrive, path: str | Path) -> None:
    """Save the best parameters as a small JSON; `read_parameters` gives them back to `driven`.

    Raises:
        UnderstudyError: The file cannot be written.
    """
    saved = {
        "format": _FORMAT,
        "driven": tuned.parameters,
        "K_vc": tuned.best.speed,
        "error_units2": tuned.best.error,
        "variance_units4": tuned.best.variance,
        "simulations": len(tuned.trials),
        "search": tuned.settings,
    }
    with written(path) as temporary:
        text = json.dumps(saved, indent=2, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")


def read_parameters(path: str | Path) -> dict[str, Any]:
    """Keyword arguments of `driven` from a file: `driven(clip, linkage, **read_parameters(path))`.

    Raises:
        UnderstudyError: The file cannot be read or is none of `write_parameters`.
    """
    try:
        saved = json.loads(Path(path).read_text(encoding="utf-8"))
        kept = saved["driven"]
        if saved["format"] != _FORMAT:
            raise ValueError(f"format {saved['format']!r}")
        names = ("rate", "scale", "gravity", "gain", "velocity_scale")
        numbers = {name: float(kept[name]) for name in names}
        return {"law": str(kept["law"]), "order": int(kept["order"]), **numbers}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UnderstudyError(f"{path}: holds no drive parameters ({error}).") from None
