"""The certificate every take carries: what was measured, and in words what it means."""

from __future__ import annotations

import json
from os import PathLike
from typing import TYPE_CHECKING, Any

from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.score import Score, score, versions
from understudy.motion.files import written

if TYPE_CHECKING:
    from understudy.take import Take

SCHEMA = 1
"""Grows when a key changes its meaning or goes; new keys do not change it."""


def certificate(
    take: Take,
    *,
    scores: tuple[Score, ...] | None = None,
    measures: Measured | None = None,
) -> dict[str, Any]:
    """The certificate of a take; docs/evaluation.md has its table of keys.

    Args:
        take: The take.
        scores: One per character, to save measuring again.
        measures: What `measured(take)` gave, likewise.
    """
    if scores is None:
        scores = scored(take, measures=measures)
    shared = ("duration_s", "diverged_s", "real_time_factor", "seed", "versions")
    return {
        "kind": "understudy certificate",
        "schema": SCHEMA,
        "statement": " ".join(statement(s) for s in scores),
        "fully_physical": all(s.fully_physical for s in scores),
        "duration_s": take.duration,
        "step_s": 1.0 / take.rate,
        "diverged_s": take.diverged,
        "real_time_factor": scores[0].real_time_factor,
        "seed": take.seed,
        "versions": versions(),
        "facts": {key: _plain(value) for key, value in take.facts.items()},
        "characters": [
            {
                "statement": statement(s),
                "fully_physical": s.fully_physical,
                **{k: v for k, v in s.as_dict().items() if k not in shared},
            }
            for s in scores
        ],
    }


def scored(take: Take, *, measures: Measured | None = None) -> tuple[Score, ...]:
    """The score of every character of a take."""
    m = measured(take) if measures is None else measures
    return tuple(score(take, character=k, measures=m) for k in range(len(m.performers)))


def write_certificate(take: Take, path: str | PathLike[str]) -> None:
    """Write the certificate as JSON.

    Raises:
        UnderstudyError: The file cannot be written.
    """
    text = json.dumps(certificate(take), indent=2, ensure_ascii=False, allow_nan=False)
    with written(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def statement(s: Score) -> str:
    """In words, what holds the body up and whether the motion is fully physical."""
    force = (
        f"{_percent(s.root_force_mean_percent)} of body weight on average "
        f"(peak {_percent(s.root_force_peak_percent)})"
    )
    carried = f"carries {_percent(s.root_support_percent)} of the weight"
    if s.pelvis == "led":
        text = (
            f"The pelvis is led along the clip by an outside force of {force} that {carried}: "
            "the other links are simulated, balance is not."
        )
    elif s.fully_physical:
        text = "Nothing but contact holds the body: fully physical, no force on the root."
    else:
        text = f"An outside force on the root of {force} helps and {carried}: not fully physical."
    if s.fell_s is not None:
        text += f" It lost its balance: at {s.fell_s:.2f} s it had fallen away from the clip."
    if s.diverged_s is not None:
        text += f" The simulation diverged at {s.diverged_s:.3f} s and is kept up to then."
    return text


def _percent(value: float) -> str:
    return f"{value:.1f} %" if value < 10 else f"{value:.0f} %"


def _plain(value: Any) -> Any:
    """A fact as JSON takes it: NumPy numbers and arrays become plain ones."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, str | int | float | bool) or value is None:
        return value
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return str(value)
