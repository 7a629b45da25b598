"""Tables of a report about contact and pushes, as pieces of HTML."""

from __future__ import annotations

import html as markup
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from understudy.evaluate.certificate import foremost
from understudy.evaluate.events import ContactEvent
from understudy.evaluate.events import contact_events as every_contact
from understudy.evaluate.feet import footfalls, without_footfalls
from understudy.evaluate.measure import Measured
from understudy.evaluate.outcomes import outcomes
from understudy.evaluate.plots import contact_timeline
from understudy.evaluate.pushes import push_events
from understudy.motion.figure import plain_name

if TYPE_CHECKING:
    from understudy.take import Take

MOST_EVENTS = 60  # rows of the table of contact events


def _text(value: object) -> str:
    return markup.escape(str(value), quote=True)


def table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table whose first column names the rows."""
    columns = "".join(f'<th scope="col">{_text(h)}</th>' for h in head)
    body = "".join(
        f'<tr><th scope="row">{_text(row[0])}</th>'
        + "".join(f"<td>{_text(cell)}</td>" for cell in row[1:])
        + "</tr>"
        for row in rows
    )
    return (
        f'<div class="wide" tabindex="0" role="region" aria-label="{_text(caption)}">'
        f"<table><caption>{_text(caption)}</caption><thead><tr>{columns}</tr></thead>"
        f"<tbody>{body}</tbody></table></div>"
    )


def by_link(m: Measured, character: int) -> str:
    """What every link of a character bore in all."""
    who, points, rows = m.performer(character), m.contacts, []
    for link, body in zip(who.links, who.bodies, strict=True):
        mine = points.involving(np.array([body]))
        if not mine.any():
            continue
        force = np.linalg.norm(points.force_on(np.array([body]), m.frames), axis=1)
        seconds = len(np.unique(points.frame[mine & (points.depth > 0)])) / m.rate
        normal = np.abs(np.sum(points.force[mine] * points.normal[mine], axis=1))
        slip = float(np.sum(normal * points.slip[mine]) / max(normal.sum(), 1e-12))
        rows.append(
            (
                plain_name(link),
                f"{seconds:.2f}",
                f"{force.max():.0f}",
                f"{force.sum() / m.rate:.1f}",
                f"{1e3 * max(0.0, float(points.depth[mine].max())):.1f}",
                f"{1e3 * slip:.0f}",
            )
        )
    if not rows:
        return ""
    head = ("Link", "Time [s]", "Peak force [N]", "Impulse [N s]", "Depth [mm]", "Slide [mm/s]")
    words = (
        "What touched. Impulse is force times time; compare it rather than peak force, which "
        "depends on how hard the surfaces are."
    )
    made = table("Contacts by link", head, rows)
    return f"<section><h2>Contacts</h2><p>{words}</p>{made}</section>"


def contact_events(m: Measured) -> str:
    """What touched what and when, feet on the ground summed up."""
    events, feet = without_footfalls(m, every_contact(m)), footfalls(m)
    shown, chart = foremost(events, MOST_EVENTS), contact_timeline(m, events)
    parts = [chart.html()] if chart is not None else []
    if shown:
        few = f", the {len(shown)} largest of {len(events)}" if len(shown) < len(events) else ""
        parts.append(table(f"Contact events{few}", _EVENT_HEAD, map(_event_row, shown)))
    if feet:
        rows = [
            (
                plain_name(foot.foot),
                str(foot.touchdowns),
                f"{foot.stance_mean_s:.3f}",
                f"{foot.impulse_mean_ns:.1f}",
                f"{foot.peak_force_n:.0f}",
                f"{foot.peak_force_percent:.0f}",
                f"{foot.spike_force_n:.0f}",
                f"{foot.penetration_mm:.1f}",
            )
            for foot in feet
        ]
        parts.append(table("Feet on the ground, with their toes", _FEET_HEAD, rows))
    if not parts:
        return ""
    return f'<section id="contact-events"><h2>Contact events</h2>{"".join(parts)}</section>'


_EVENT_HEAD = (
    "Between",
    "Start [s]",
    "Time [s]",
    "Impulse [N s]",
    "Peak force [N]",
    "Depth [mm]",
    "Closing [m/s]",
)
_FEET_HEAD = (
    "Foot",
    "Touchdowns",
    "Mean stance [s]",
    "Mean impulse [N s]",
    "Peak force [N]",
    "Peak [% BW]",
    "In one step [N]",
    "Depth [mm]",
)


def _event_row(event: ContactEvent) -> tuple[str, ...]:
    return (
        " - ".join(plain_name(name) for name in event.between),
        f"{event.start_s:.3f}",
        f"{event.duration_s:.3f}",
        f"{event.impulse_ns:.2f}",
        f"{event.peak_force_n:.0f}",
        f"{event.penetration_mm:.1f}",
        f"{event.approach_m_s:.2f}",
    )


def tasks(take: Take, m: Measured) -> str:
    """How well every task was done; nothing where there were none."""
    rows = [
        (
            one.task,
            f"{one.start_s:.2f} to {one.end_s:.2f}",
            one.what,
            f"{one.mean:.1f} {one.unit}",
            f"{one.most:.1f} {one.unit}",
        )
        for one in outcomes(take, m)
    ]
    if not rows:
        return ""
    head = ("Task", "Fully on [s]", "What", "Mean", "At most")
    made = table("How far tasks were from their goals", head, rows)
    return f'<section id="tasks"><h2>Tasks</h2>{made}</section>'


def pushes(take: Take) -> str:
    """Every push; nothing where there were none."""
    rows = [
        (
            plain_name(push.link),
            f"{push.start_s:.3f}",
            f"{push.duration_s:.3f}",
            f"{push.impulse_ns:.2f}",
            f"{push.peak_force_n:.0f}",
        )
        for push in push_events(take)
    ]
    if not rows:
        return ""
    head = ("Link", "Start [s]", "Time [s]", "Impulse [N s]", "Peak force [N]")
    made = table("Forces from outside, given on purpose", head, rows)
    return f'<section id="pushes"><h2>Pushes</h2>{made}</section>'
