"""A run beside people and beside captured runs: one HTML page, or the same as JSON."""

from __future__ import annotations

import html as markup
import json
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from understudy.errors import InvalidValue
from understudy.evaluate.chart import SCRIPT, STYLE
from understudy.evaluate.gait import Gait, gait_of
from understudy.evaluate.running import (
    MOST_BESIDE,
    Likeness,
    beside_table,
    curves_table,
    figures_table,
    likeness,
    sources_list,
)
from understudy.evaluate.running import beside as curves_beside
from understudy.evaluate.running_charts import running_charts
from understudy.motion.files import written
from understudy.output.page import page

if TYPE_CHECKING:
    from understudy.motion.clip import Clip
    from understudy.take import Take

SCHEMA = 1
STEADY = 0.5
"""A gait that gains or loses more than this is on its way to another speed [m/s2]."""


def running_data(
    run: Gait | Clip | Take, *, beside: Sequence[Gait | Clip | Take] = ()
) -> dict[str, Any]:
    """The run beside people and the others, as plain values that JSON takes.

    Raises:
        InvalidValue: A motion without a whole cycle, or at no speed that people run.
    """
    first, *rest = _likenesses(run, beside)
    return {
        "kind": "understudy running",
        "schema": SCHEMA,
        "run": first.as_dict(),
        "beside": [one.as_dict() | {"with_run": _with(first, one)} for one in rest],
    }


def _with(first: Likeness, other: Likeness) -> list[dict[str, Any]]:
    """The run's curves against another's."""
    return [match.as_dict() for match in curves_beside(first.gait, other.gait).values()]


def running_page(
    run: Gait | Clip | Take,
    *,
    beside: Sequence[Gait | Clip | Take] = (),
    title: str | None = None,
) -> str:
    """The run beside people and the others, as one HTML page.

    Args:
        run: What to judge: a gait, or a clip or take to measure it in.
        beside: Up to three others, such as captured runs.
        title: Heading; by default the run's name.

    Raises:
        InvalidValue: A motion without a whole cycle, or at no speed that people run; more than
            three others.
    """
    found = _likenesses(run, beside)
    name = title or found[0].gait.name
    charts = "".join(chart.html() for chart in running_charts(found))
    body = "\n".join(
        (
            f'<header><p class="kicker">Running beside people</p><h1>{_text(name)}</h1>'
            f"<p>{_text(statement(found[0]))}</p></header>",
            f"<section><h2>Figures</h2>{figures_table(found)}{_beyond(found)}</section>",
            f"<section><h2>Curves</h2>{curves_table(found)}{beside_table(found)}{charts}</section>",
            f"<section><h2>Sources</h2>{sources_list(found)}{_methods(found)}</section>",
        )
    )
    return page(name, body, style=STYLE, script=SCRIPT)


def write_running(
    run: Gait | Clip | Take,
    path: str | PathLike[str],
    *,
    beside: Sequence[Gait | Clip | Take] = (),
    title: str | None = None,
) -> None:
    """Write the page (.html) or its numbers (.json).

    Raises:
        InvalidValue: Another suffix, or as for `running_page`.
        UnderstudyError: The file cannot be written.
    """
    kind = Path(path).suffix.lower()
    if kind == ".html":
        text = running_page(run, beside=beside, title=title)
    elif kind == ".json":
        text = json.dumps(running_data(run, beside=beside), indent=1)
    else:
        raise InvalidValue(f"{path}: a run beside people is written as .html or .json.")
    with written(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _likenesses(
    run: Gait | Clip | Take, beside: Sequence[Gait | Clip | Take]
) -> tuple[Likeness, ...]:
    if len(beside) > MOST_BESIDE:
        raise InvalidValue(
            f"{len(beside)} motions beside the run; {MOST_BESIDE} are as many as can be told apart."
        )
    return tuple(
        likeness(motion if isinstance(motion, Gait) else gait_of(motion))
        for motion in (run, *beside)
    )


def statement(found: Likeness) -> str:
    """What matters, in a few sentences."""
    gait, hip, knee = found.gait, found.curves["hip"], found.curves["knee"]
    judged = [m for m in found.figures.values() if m.inside is not None]
    within = sum(bool(m.inside) for m in judged)
    walks = "Walks or shuffles, a foot being down for half the time or more,"
    cycles = f"{len(gait.cycles)} cycle{'s' if len(gait.cycles) > 1 else ''}"
    return (
        f"{'Runs' if gait.runs else walks} at {gait.speed:.2f} m/s over {cycles}, told by "
        f"{gait.kind}. Over the cycle the hip correlates {hip.correlation:.2f} and the knee "
        f"{knee.correlation:.2f} with people's. {within} of {len(judged)} figures lie in the range "
        "of 95 % of people."
    )


def _beyond(found: Sequence[Likeness]) -> str:
    out = [
        f"{one.gait.name} runs at {one.people.asked:.2f} m/s: people are measured from 2.5 to "
        f"4.5 m/s; shown are values carried on to {one.people.speed:.2f} m/s."
        for one in found
        if one.people.extrapolated
    ]
    for one in found:
        gain = one.gait.figures()["acceleration_m_s2"].mean
        if abs(gain) > STEADY:
            what = "speeds up" if gain > 0 else "slows down"
            out.append(
                f"{one.gait.name} {what} by {abs(gain):.1f} m/s every second; people were measured "
                "at a steady speed."
            )
    return "".join(f"<p>{_text(text)}</p>" for text in out)


def _methods(found: Sequence[Likeness]) -> str:
    kinds = {one.gait.kind for one in found}
    text = "Usual ranges are two standard deviations either way."
    if "motion of the soles" in kinds:
        text += (
            " Clips have no forces: a foot stands while a point of its sole is low and slow, which "
            "puts touchdown and toe-off within some hundredths of a second."
        )
    if "contact forces" in kinds:
        text += " In simulations a foot stands while the ground bears more than 20 N on it."
    return f"<p>{_text(text)}</p>"


def _text(value: object) -> str:
    return markup.escape(str(value), quote=True)
