"""What `understudy athlete` tells: figures by name with their unit, a table, notes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from understudy.app.outcome import table
from understudy.app.track import folded

if TYPE_CHECKING:
    from understudy.athletics.course import Course
    from understudy.character import Athlete
    from understudy.control import Push

# Ends of names and the units they stand for.
_UNITS = {
    "_body_weights": "body weights",
    "_per_s": "1/s",
    "_m_s": "m/s",
    "_deg": "deg",
    "_mm": "mm",
    "_kg": "kg",
    "_m": "m",
    "_s": "s",
}
# Names that need more words on screen.
_LABELS = {
    "impact_body_weights": "impact, first 35 ms of a stance [body weights]",
    "legs_apart_least_m": "lower legs, least distance [m]",
    "heading_rms_deg": "facing, off the heading asked for, rms [deg]",
    "off_path_most_m": "off the path, at most [m]",
    "hip_curve_correlation": "hip, correlation with people's curve",
    "knee_curve_correlation": "knee, correlation with people's curve",
}
# A runner is said to have left a path when this far from it [m].
_OFF = 0.5


def figures(behavior: str, body: Athlete, seen: dict[str, float]) -> dict[str, Any]:
    """What a judge saw (`running_judge.report`), by name; None for what there was none of."""
    timed, landed, stood = (seen[name] > 0.0 for name in ("counted", "steps", "flight"))
    step, stance = seen["mean_period"], seen["mean_stance"]

    def known(value: float, by: bool) -> float | None:
        return value if by and math.isfinite(value) else None

    return {
        "behavior": behavior,
        "character": body.name.removeprefix("athlete_"),
        "height_m": body.height,
        "mass_kg": body.mass,
        "fell_at_s": seen["time"] if seen["fell"] else None,
        "mean_speed_m_s": known(seen["mean_speed"], timed),
        "stance_s": known(stance, stood),
        "flight_s": known(step - stance, landed and stood),
        "steps_per_s": known(1.0 / step if landed else math.nan, landed),
        "vertical_travel_m": known(seen["mean_travel"], landed),
        "peak_force_body_weights": known(seen["mean_peak"], stood),
        "impact_body_weights": known(seen["mean_impact"], stood),
        "legs_apart_least_m": known(seen["nearest"], timed),
        "knee_at_touchdown_deg": known(math.degrees(seen["mean_landing_knee"]), landed),
        "knee_in_swing_deg": known(math.degrees(seen["mean_swing_knee"]), landed),
        "plantarflexion_at_toe_off_deg": known(math.degrees(seen["mean_plantarflexion"]), stood),
        "trunk_lean_deg": known(math.degrees(seen["mean_lean"]), timed),
        "heading_rms_deg": known(math.degrees(math.sqrt(seen["heading"])), timed),
    }


def notes(
    found: dict[str, Any],
    course: Course,
    duration: float,
    *,
    pushes: Sequence[Push] = (),
    friction: float = 1.0,
    upper: bool = False,
) -> list[str]:
    """Sentences on one run: a fall first, then what could not be followed or measured."""
    from understudy.athletics.doubts import course_doubts, fall_reasons, path_doubt

    out: list[str] = []
    fell = found["fell_at_s"]
    if fell is not None:
        reasons = [*fall_reasons(course, fell, pushes=pushes, friction=friction)]
        reasons += ["the clip on the upper body"] * upper
        why = f"; likely because of {' and '.join(reasons)}" if reasons else ""
        out.append(f"Fell at {fell:.2f} s{why}.")
    out += course_doubts(course, duration)
    off = found.get("off_path_most_m")
    if off is not None and off > _OFF and fell is None:
        out.append(path_doubt(course, off))
    if found["steps_per_s"] is None or found["stance_s"] is None:
        out.append("Too few steps were run to measure every figure: they count from 0.5 s on.")
    if found["hip_curve_correlation"] is None:
        out.append("There is no gait page: no whole cycle of steps was run.")
    return out


def error_of(found: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """For machines, what went wrong in one line; empty if nobody fell."""
    fallen = [one for one in found if one["fell_at_s"] is not None]
    if not fallen:
        return {}
    first = fallen[0]["notes"][0]
    words = first if len(found) == 1 else f"{len(fallen)} of {len(found)} fell. {first}"
    return {"error": words, "status": 1}


def summary(found: Sequence[dict[str, Any]], files: dict[str, str]) -> str:
    """The table, the notes and the files, for people."""
    several = len(found) > 1
    heads = [str(one["character"]) for one in found] if several else ["value"]
    rows: list[tuple[str, ...]] = [("measured", *heads)]
    flat = [{k: v for k, v in one.items() if k != "notes"} | _flat(one) for one in found]
    for name in flat[0]:
        none = "no" if name == "fell_at_s" else "-"
        rows.append((label(name), *(_shown(one[name], none) for one in flat)))
    parts = [table(rows, right=range(1, len(rows[0])))]
    if lines := _noted(found):
        parts += ["", *lines]
    return "\n".join([*parts, "", "files:", *(f"  {path}" for path in files.values())])


def label(name: str) -> str:
    """A name as words with the unit in brackets: mean_speed_m_s is "mean speed [m/s]"."""
    if name in _LABELS:
        return _LABELS[name]
    for end, unit in _UNITS.items():
        if name.endswith(end):
            return f"{name.removesuffix(end).replace('_', ' ')} [{unit}]"
    return name.replace("_", " ")


def _noted(found: Sequence[dict[str, Any]]) -> list[str]:
    """What holds for all is said once; the rest begins with who."""
    lines = []
    for k, one in enumerate(found):
        for note in one["notes"]:
            shared = all(note in other["notes"] for other in found)
            if not shared:
                note = f"{chr(ord('a') + k)}, {one['character']}: {note}"
            if not (shared and k):
                lines += folded(note, "")
    return lines


def _flat(found: dict[str, Any]) -> dict[str, Any]:
    """The layer's figures as rows of their own."""
    if (upper := found.get("upper")) is None:
        return {}
    return {"upper": upper["clip"]} | {
        f"upper_{name}": upper[name] for name in ("joint_error_deg", "hands_mm")
    }


def _shown(value: Any, none: str) -> str:
    return f"{value:.3f}" if isinstance(value, float) else none if value is None else str(value)
