"""A take in one HTML file: certificate, 3D player, plots, tables. No network, prints well."""

from __future__ import annotations

import html as markup
from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING

from understudy.errors import InvalidValue
from understudy.evaluate import tables
from understudy.evaluate.certificate import FULLY_PHYSICAL, called, scored, statement, verdict
from understudy.evaluate.chart import SCRIPT, STYLE
from understudy.evaluate.following import Following, following
from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.plots import all_charts
from understudy.evaluate.pushes import push_events, pushed
from understudy.evaluate.score import Score
from understudy.motion.figure import plain_name
from understudy.motion.files import written
from understudy.output.page import page
from understudy.output.player import player_html

if TYPE_CHECKING:
    from understudy.take import Take

Tile = tuple[str, str, str]  # label, value, what it means


def report_html(take: Take, *, title: str | None = None) -> str:
    """The report as one HTML page.

    Args:
        take: The take; one that diverged is reported up to then.
        title: Heading; by default the tracked clip's name, or the character's.
    """
    m = measured(take)
    scores = scored(take, measures=m)
    name = title or scores[0].clip or scores[0].character
    parts = [_header(take, name, scores), _player(take, name)]
    for k, s in enumerate(scores):
        heading = called(take, scores, k) + (f": {s.clip}" if s.clip else "")
        several = f"<h2>{_text(heading)}</h2>" if len(scores) > 1 else "<h2>Figures</h2>"
        parts.append(
            f'<section id="figures-{k}">{several}{_tiles(s, _followed(take, m, k))}</section>'
        )
        charts = "".join(chart.html() for chart in all_charts(take, m, k))
        parts.append(f"<section><h2>Over time</h2>{charts}</section>" if charts else "")
        parts.append(_joints(s))
        parts.append(tables.by_link(m, k))
        parts.append(_notes(take, k))
    parts += [tables.tasks(take, m), tables.contact_events(m), tables.pushes(take)]
    parts.append(_footer(take, scores))
    body = "\n".join(filter(None, parts))
    return page(name, body, style=_STYLE + STYLE, script=SCRIPT)


def write_report(take: Take, path: str | PathLike[str], *, title: str | None = None) -> None:
    """Write the report to a file.

    Raises:
        UnderstudyError: The file cannot be written.
    """
    text = report_html(take, title=title)
    with written(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _text(value: object) -> str:
    return markup.escape(str(value), quote=True)


def _header(take: Take, name: str, scores: Sequence[Score]) -> str:
    heading = "; ".join(dict.fromkeys(verdict(s) for s in scores))
    kind = "good" if heading == FULLY_PHYSICAL else "held"
    words = "".join(
        f"<p>{f'<b>{_text(called(take, scores, k))}.</b> ' if len(scores) > 1 else ''}"
        f"{_text(statement(s))}</p>"
        for k, s in enumerate(scores)
    )
    outside = pushed(push_events(take))
    words += f"<p>{_text(outside)}</p>" if outside else ""
    return (
        f'<header><p class="kicker">Simulated performance, {take.duration:.2f} s</p>'
        f'<h1>{_text(name)}</h1><div class="verdict {kind}"><b>{heading}</b>{words}</div></header>'
    )


def _player(take: Take, name: str) -> str:
    try:
        player = player_html(take, title=name)
    except InvalidValue as error:  # a body without any visible shape
        return f'<p class="player">No picture: {_text(error)}</p>'
    return (
        '<section class="player"><h2 class="unseen">The motion in 3D</h2>'
        f'<iframe title="3D player of {_text(name)}" sandbox="allow-scripts" '
        f'srcdoc="{_text(player)}"></iframe>'
        '<p class="onpaper">The 3D player is interactive; open this file in a browser.</p>'
        "</section>"
    )


def _followed(take: Take, m: Measured, character: int) -> Following | None:
    if take.references[character] is None:
        return None
    return following(take, character=character, measures=m)


def _tiles(s: Score, f: Following | None = None) -> str:
    groups = (
        ("Tracking", _tracking_tiles(s)),
        ("On its own feet", [] if f is None or s.pelvis != "free" else _free_tiles(f)),
        ("Help from outside", _root_tiles(s)),
        ("Contact", _contact_tiles(s)),
        ("Effort", _effort_tiles(s)),
    )
    out = []
    for heading, tiles in groups:
        if not tiles:
            continue
        cells = "".join(
            f"<div><dt>{_text(label)}</dt><dd><b>{value}</b><span>{_text(note)}</span></dd></div>"
            for label, value, note in tiles
        )
        out.append(f'<h3>{heading}</h3><dl class="tiles">{cells}</dl>')
    return "".join(out)


def _tracking_tiles(s: Score) -> list[Tile]:
    tiles: list[Tile] = []
    if s.joint_error_deg is not None:
        note = f"rms; median {s.joint_error_median_deg:.2f}°"
        if s.joint_error_as_read_deg is not None:
            note += f"; {s.joint_error_as_read_deg:.2f}° rms off the clip as read"
        tiles.append(("Joint error", _value(s.joint_error_deg, "°", 2), note))
    if s.lag_ms is not None and s.joint_error_without_lag_deg is not None:
        note = f"{s.joint_error_without_lag_deg:.2f}° rms without it"
        tiles.append(("Lag", _value(s.lag_ms, "ms", 1), note))
    if s.joint_position_mm is not None:
        note = f"mean; {s.joint_position_aligned_mm:.1f} mm seen from the root"
        tiles.append(("Joint position", _value(s.joint_position_mm, "mm", 1), note))
    if s.root_position_mm is not None:
        note = f"mean; orientation {s.root_rotation_deg:.2f}° rms"
        tiles.append(("Root", _value(s.root_position_mm, "mm", 1), note))
    if s.hands_mm is not None:
        tiles.append(("Hands", _value(s.hands_mm, "mm", 1), "mean distance"))
    if s.feet_mm is not None:
        tiles.append(("Feet", _value(s.feet_mm, "mm", 1), "mean distance"))
    return tiles


def _free_tiles(f: Following) -> list[Tile]:
    until = "to the end" if f.lost_s is None else f"lost at {f.lost_s:.2f} s"
    shake = [] if f.shake is None else [("Shake", f"{f.shake:.2f}", "accelerations, clip's = 1")]
    return [
        ("Free", _value(f.free_s, "s", 2), f"no outside force; {until}"),
        ("Center of mass", _value(f.com_mm, "mm", 1), f"rms; peak {f.com_peak_mm:.0f} mm"),
        ("Joints from the root", _value(f.joint_relative_mm, "mm", 1), "mean; root not turned"),
        *shake,
    ]


def _root_tiles(s: Score) -> list[Tile]:
    return [
        ("Pelvis", s.pelvis, _PELVIS.get(s.pelvis, "")),
        (
            "Root force",
            _value(s.root_force_mean_percent, "% BW", 1),
            f"mean; peak {s.root_force_peak_percent:.0f} % of body weight",
        ),
        (
            "Support",
            _value(s.root_support_percent, "% BW", 1),
            "mean upward part of that force",
        ),
        (
            "Root torque",
            _value(s.root_torque_mean_percent, "% BW·H", 1),
            f"mean; peak {s.root_torque_peak_percent:.0f} % of weight by height",
        ),
    ]


_PELVIS = {
    "led": "an outside force moves it along the clip",
    "assisted": "an outside force helps it",
    "free": "nothing holds it",
}


def _contact_tiles(s: Score) -> list[Tile]:
    if s.ground_force_mean_percent is None:
        return []
    tiles: list[Tile] = [
        (
            "Ground force",
            _value(s.ground_force_mean_percent, "% BW", 0),
            f"mean; peak {s.ground_force_peak_percent:.0f} %; in one step, unfiltered, "
            f"{s.ground_force_spike_percent:.0f} %",
        ),
        ("Penetration", _value(s.penetration_mm, "mm", 1), _clip_penetration(s)),
    ]
    if s.foot_slide_mm_s is not None:
        tiles.append(("Foot slide", _value(s.foot_slide_mm_s, "mm/s", 0), "while loaded"))
    if s.foot_slide_by_height_mm_s is not None:
        own = s.clip_foot_slide_mm_s
        note = "while low and slow" + ("" if own is None else f"; the clip {own:.0f} mm/s")
        tiles.append(
            ("Foot slide, as in clips", _value(s.foot_slide_by_height_mm_s, "mm/s", 0), note)
        )
    return tiles


def _clip_penetration(s: Score) -> str:
    own = "" if s.clip_penetration_mm is None else f"; the clip {s.clip_penetration_mm:.0f} mm"
    return f"deepest; mean {s.penetration_mean_mm:.1f} mm{own}"


def _effort_tiles(s: Score) -> list[Tile]:
    tiles: list[Tile] = []
    if s.torque_peak_joint is not None:
        where = plain_name(s.torque_peak_joint)
        tiles += [
            (
                "Joint torque",
                _value(s.torque_peak_nm, "N m", 0),
                f"peak ({where}); mean {s.torque_mean_nm:.1f} N m",
            ),
            (
                "Joint power",
                _value(s.power_mean_w, "W", 0),
                f"mean of absolute powers; peak sum {s.power_peak_w:.0f} W",
            ),
        ]
    if s.energy_drift_percent is not None:
        tiles.append(("Energy drift", _value(s.energy_drift_percent, "%", 2), "in flight"))
    if s.real_time_factor is not None:
        digits = 0 if s.real_time_factor >= 10.0 else 2
        speed = _value(s.real_time_factor, "&times;", digits)
        tiles.append(("Speed", speed, "real time, to simulate"))
    return tiles


def _value(value: float, unit: str, decimals: int) -> str:
    gap = "" if unit == "°" else "&#8239;"
    return f"{value:.{decimals}f}{gap}<small>{unit}</small>"


def _joints(s: Score) -> str:
    names = list(s.torque_peaks_nm) or list(s.joint_errors_deg)
    if not names:
        return ""

    def cell(values: dict[str, float], name: str, decimals: int) -> str:
        return f"{values[name]:.{decimals}f}" if name in values else "-"

    rows = [
        (
            plain_name(name),
            cell(s.joint_errors_deg, name, 2),
            cell(s.torque_means_nm, name, 1),
            cell(s.torque_peaks_nm, name, 1),
            cell(s.strength_percent, name, 0),
        )
        for name in names
    ]
    head = ("Joint", "Error, rms [°]", "Mean [N m]", "Peak [N m]", "Of human limit [%]")
    table = tables.table("Error and torque of every joint", head, rows)
    return f"<section><h2>Joints</h2>{table}</section>"


def _notes(take: Take, character: int) -> str:
    out = []
    captured, reference = take.captured[character], take.references[character]
    body = take.scene.characters[character]
    seen: set[str] = set()
    for heading, notes in (
        ("Reading the clip", () if captured is None else captured.notes),
        ("Preparing it for the character", () if reference is None else reference.notes),
        ("The character", getattr(body, "notes", ())),
    ):
        fresh = [note for note in notes if note not in seen]
        seen |= set(fresh)
        if fresh:
            items = "".join(f"<li>{_text(note)}</li>" for note in fresh)
            out.append(f"<h3>{heading}</h3><ul>{items}</ul>")
    return f"<section><h2>Notes</h2>{''.join(out)}</section>" if out else ""


def _footer(take: Take, scores: Sequence[Score]) -> str:
    facts = {
        **{key: value for key, value in take.facts.items() if not isinstance(value, dict | list)},
        "seed": take.seed,
        "physics step": f"{1e3 / take.rate:.3g} ms",
        "measured at": f"{scores[0].frame_rate_hz:.4g} Hz",
        **scores[0].versions,
    }

    def shown(key: str, value: object) -> str:
        if isinstance(value, float):
            return f"{value:.4g}{_FACT_UNITS.get(key, '')}"
        return str(value).replace("_", " ")

    def named(key: str) -> str:
        return _FACT_NAMES.get(key, key.replace("_", " "))

    items = "".join(
        f"<div><dt>{_text(named(key))}</dt><dd>{_text(shown(key, value))}</dd></div>"
        for key, value in facts.items()
    )
    return f'<footer><h2>How it was made</h2><dl class="facts">{items}</dl></footer>'


_FACT_NAMES = {"cpu_seconds": "processor time"}
_FACT_UNITS = {"stiffness": " /s²", "damping_time": " s", "cpu_seconds": " s"}

_STYLE = """
.verdict{padding:.75rem 1rem;background:var(--panel);border-left:4px solid var(--held);
 border-radius:0 .4rem .4rem 0}
.verdict.good{border-color:var(--good)}.verdict b{color:var(--held)}
.verdict.good b{color:var(--good)}
.verdict p{margin:.2rem 0 0}
.unseen{position:absolute;width:1px;height:1px;overflow:hidden;clip-path:inset(50%);margin:0}
.player{margin-top:1.25rem}
.player iframe{display:block;width:100%;height:clamp(20rem,58vw,36rem);border:1px solid var(--rule);
 border-radius:.4rem;background:#dfe6ee}
.onpaper{display:none}
.tiles{display:grid;grid-template-columns:repeat(auto-fill,minmax(10.5rem,1fr));gap:.6rem;margin:0}
.tiles div{padding:.6rem .8rem;background:var(--panel);border-radius:.4rem}
.tiles dt{font-size:.8125rem;color:var(--dim)}
.tiles dd{margin:0}
.tiles b{display:block;font-size:1.35rem;font-weight:600;line-height:1.25;
 font-variant-numeric:tabular-nums}
.tiles b small{font-size:.8125rem;font-weight:400;margin-left:.05rem}
.tiles span{font-size:.8125rem;color:var(--dim);line-height:1.3;display:block}
.facts{display:grid;grid-template-columns:repeat(auto-fill,minmax(13rem,1fr));gap:.3rem 2rem;
 font-size:.875rem;margin:0}
.facts div{display:flex;justify-content:space-between;gap:1rem;border-bottom:1px solid var(--rule)}
.facts dt{color:var(--dim)}.facts dd{margin:0;overflow-wrap:anywhere;text-align:right}
@media print{.player iframe{display:none}.onpaper{display:block}
 .tiles div,.verdict{break-inside:avoid}}
"""
