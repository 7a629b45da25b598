"""The certificate every take carries: what was measured, and in words what it means."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from os import PathLike
from typing import TYPE_CHECKING, Any

from understudy.errors import InvalidValue
from understudy.evaluate.events import ContactEvent, contact_events
from understudy.evaluate.feet import footfalls, without_footfalls
from understudy.evaluate.following import following
from understudy.evaluate.layered import layered
from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.outcomes import outcomes
from understudy.evaluate.pushes import push_events, pushed
from understudy.evaluate.score import FAR_OFF, Score, score, versions
from understudy.motion.figure import plain_name
from understudy.motion.files import written

if TYPE_CHECKING:
    from understudy.take import Take

SCHEMA = 2
"""Grows when a key changes its meaning or goes; new keys do not change it."""
TIMES = ("cpu_seconds", "search_cpu_seconds")
"""Facts that differ from run to run."""


LONG_FLIGHT = 0.3
"""A held body without contact for more than this share of the time does not stand by itself."""
HEAVY_SUPPORT = 20.0
"""A root that carries more than this of the weight [%] says that the feet cannot."""
MOST_EVENTS = 500
"""A certificate lists this many contact events, those of the largest impulse."""
FULLY_PHYSICAL = "Fully physical"
"""The verdict on a body that nothing but contact holds, and that did not fall."""


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
    m = measured(take) if measures is None else measures
    if scores is None:
        scores = scored(take, measures=m)
    shared = ("duration_s", "diverged_s", "real_time_factor", "seed", "versions")
    factor = scores[0].real_time_factor
    # What differs from run to run stands apart.
    timing = {name: take.facts[name] for name in TIMES if name in take.facts}
    events, pushes = without_footfalls(m, contact_events(m)), push_events(take)
    return {
        "kind": "understudy certificate",
        "schema": SCHEMA,
        "statement": _all_said(take, scores, pushed(pushes)),
        "fully_physical": all(s.fully_physical for s in scores),
        "duration_s": take.duration,
        "step_s": 1.0 / take.rate,
        "diverged_s": take.diverged,
        "real_time_factor": factor,
        "timing": {} if factor is None else {"real_time_factor": factor, **timing},
        "seed": take.seed,
        "versions": versions(),
        "facts": {key: _plain(value) for key, value in take.facts.items() if key not in TIMES},
        "tasks": [asdict(one) for one in outcomes(take, m)],
        "pushes": [push.as_dict() for push in pushes],
        "contacts": [event.as_dict() for event in foremost(events, MOST_EVENTS)],
        "contacts_in_all": len(events),
        "feet_on_ground": [foot.as_dict() for foot in footfalls(m)],
        "characters": [
            {
                "prefix": take.scene.prefix(k),
                "statement": statement(s),
                "fully_physical": s.fully_physical,
                **{key: v for key, v in s.as_dict().items() if key not in shared},
                "following": None
                if take.references[k] is None
                else following(take, character=k, measures=m).as_dict(),
                "upper_body": _upper_body(take, k),
            }
            for k, s in enumerate(scores)
        ],
    }


def _upper_body(take: Take, character: int) -> dict[str, Any] | None:
    """How a runner follows the clip laid on its upper body; None without one."""
    try:
        return layered(take, character=character).as_dict()
    except InvalidValue:
        return None


def scored(take: Take, *, measures: Measured | None = None) -> tuple[Score, ...]:
    """The score of every character of a take."""
    m = measured(take) if measures is None else measures
    return tuple(score(take, character=k, measures=m) for k in range(len(m.performers)))


def called(take: Take, scores: Sequence[Score], character: int) -> str:
    """A character's name; where there are several, with the letter of its names in the model."""
    name = scores[character].character
    letter = take.scene.prefix(character).rstrip("/") or "a"
    return f"{name} ({letter})" if len(scores) > 1 else name


def _all_said(take: Take, scores: Sequence[Score], pushes: str) -> str:
    """The statements of all characters, each under its name, then what pushed them."""
    several = len(scores) > 1
    said = [
        f"{called(take, scores, k)}: {statement(s)}" if several else statement(s)
        for k, s in enumerate(scores)
    ]
    return " ".join(filter(None, (*said, pushes)))


def foremost(events: tuple[ContactEvent, ...], most: int) -> tuple[ContactEvent, ...]:
    """Those of the largest impulse, at most so many, in their order."""
    if len(events) <= most:
        return events
    largest = sorted(range(len(events)), key=lambda k: -events[k].impulse_ns)[:most]
    return tuple(events[k] for k in sorted(largest))


def write_certificate(take: Take, path: str | PathLike[str]) -> None:
    """Write the certificate as JSON.

    Raises:
        UnderstudyError: The file cannot be written.
    """
    text = json.dumps(certificate(take), indent=2, ensure_ascii=False, allow_nan=False)
    with written(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def statement(s: Score) -> str:
    """In words: whether it fell, what holds the body up, what the clip asks that is not there."""
    parts = [_held(s), _unheld(s), _furthest(s)]
    if s.fell_s is not None:
        parts.insert(0, f"It fell at {s.fell_s:.2f} s: from then on it is away from the clip.")
    if s.diverged_s is not None:
        parts.append(f"The simulation diverged at {s.diverged_s:.3f} s and is kept up to then.")
    return " ".join(filter(None, parts))


def verdict(s: Score) -> str:
    """The same in a few words, for a heading."""
    if s.fell_s is not None:
        return f"It fell at {s.fell_s:.2f} s"
    return FULLY_PHYSICAL if s.fully_physical else "Not fully physical"


def _held(s: Score) -> str:
    force = (
        f"{_percent(s.root_force_mean_percent)} of body weight on average "
        f"(peak {_percent(s.root_force_peak_percent)})"
    )
    carried = (
        f"carries {_percent(s.root_support_percent)} of the weight"
        if s.root_support_percent > 0.0
        else "carries none of the weight"
    )
    if s.pelvis == "led":
        return (
            f"The pelvis is led along the clip by an outside force of {force} that {carried}: "
            "the other links are simulated, balance is not."
        )
    if not s.fully_physical and s.pelvis == "free":
        return (
            f"The least help that was found is an outside force on the root of {force}; it "
            f"{carried}: not fully physical."
        )
    if not s.fully_physical:
        return f"An outside force on the root of {force} helps and {carried}: not fully physical."
    if s.fell_s is not None:
        return "Nothing but contact holds the body; it lost its balance."
    return "Nothing but contact holds the body: fully physical, no force on the root."


def _unheld(s: Score) -> str:
    """What it means when a body that has a floor is mostly off it, or is carried from above."""
    if s.flight_s is None or s.fully_physical:
        return ""
    if s.flight_s > LONG_FLIGHT * s.duration_s:
        # A body that jumps needs no support aloft; one that stands in the air does.
        jumps = "it jumps, " if s.root_support_percent < 0.5 * HEAVY_SUPPORT else ""
        return (
            f"The clip leaves the floor for {s.flight_s:.1f} s of {s.duration_s:.1f} s: {jumps}its "
            "height drifts, or it stands on something that is not in the scene."
        )
    if s.root_support_percent > HEAVY_SUPPORT:
        return (
            f"The feet carry only {max(0.0, 100.0 - s.root_support_percent):.0f} % of the weight: "
            "the clip's height drifts, it leans or stands on something that is not in the scene, "
            "or this body is not strong enough."
        )
    return ""


def _furthest(s: Score) -> str:
    if s.joint_error_peak_deg is None or s.joint_error_peak_deg <= FAR_OFF:
        return ""
    joint = plain_name(s.joint_error_peak_joint or "")
    return (
        f"Furthest from the clip: {joint}, {s.joint_error_peak_deg:.0f} degrees at "
        f"{s.joint_error_peak_s:.2f} s."
    )


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
