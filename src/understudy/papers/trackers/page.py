"""Published figures and this package's own, as one HTML page."""

from __future__ import annotations

import html as markup
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from understudy import __version__
from understudy.errors import InvalidValue
from understudy.output.page import page
from understudy.output.player import player_html
from understudy.output.take_file import load_take
from understudy.papers.sheets import STYLE, Sheet, as_html
from understudy.papers.trackers.published import DIFFERENT, TRACKERS
from understudy.papers.trackers.runs import (
    HEAD,
    SUMMARY_HEAD,
    Run,
    middle,
    reasons,
    summaries,
    survival,
    table,
    worst,
)

_TITLE = "Full-body tracking with nothing to hold on to"
_CHECKED = {
    "source": "read at its source",
    "quoted": "quoted from the paper's table",
    "memory": "from memory, not looked up",
}


def page_html(
    runs: Sequence[Run],
    *,
    takes: Mapping[tuple[str, int], Path] | None = None,
    players: int = 10,
    settings: str = "",
) -> str:
    """The page.

    Args:
        runs: Every run; failed ones are listed.
        takes: Take files by label and seed, for the players.
        players: Most players, of the worst runs.
        settings: What the runs had in common, in words.
    """
    done = [run for run in runs if not run.refused]
    clips = len({run.label for run in done})
    body = [
        f'<p class="kicker">{clips} clips, {len(done)} runs</p><h1>{_TITLE}</h1>',
        *([f"<p>{markup.escape(settings)}</p>"] if settings else []),
        "<h2>Summary</h2>",
        as_html(_summary(runs)),
        *_survival(runs),
        "<h2>Beside published trackers</h2>",
        as_html(_beside(done)),
        "<h3>What differs</h3><ul>",
        *(f"<li>{markup.escape(text)}</li>" for text in DIFFERENT),
        "</ul>",
        "<h2>Every run</h2>",
        as_html(_every(runs)),
        *_players(worst(runs, players), takes or {}),
        f'<p class="kicker">Made by understudy {__version__}.</p>',
    ]
    return page(_TITLE, "\n".join(body), style=STYLE + _STYLE)


def _summary(runs: Sequence[Run]) -> Sheet:
    return Sheet(
        name="Summary",
        caption="Medians over the free runs; cost over all. BW: body weight.",
        head=SUMMARY_HEAD,
        rows=tuple(summaries(runs)),
        notes=(
            "Score: root mean square force on the root that the cleaned clip's poses ask for and "
            "contact cannot give, in % of body weight, before any search. Free: no force on the "
            "root in any step, and never lost. Close: and the mean distance of its joints never "
            "exceeds 150 mm; a body that is free but not close may topple just when the clip ends. "
            "Settings were chosen on every other clip of the "
            "sorted list; the held-out half was only measured. An easy dynamic clip is counted in "
            "both groups.",
        ),
    )


def _survival(runs: Sequence[Run]) -> list[str]:
    rows = [(name, n, of, 100.0 * n / of) for name, n, of in survival(runs) if of]
    if not rows:
        return []
    sheet = Sheet(
        name="Replays with feedback",
        caption="Free takes performed again with their feedback, and something changed.",
        head=("change", "not lost", "replays", "%"),
        rows=tuple(rows),
    )
    return ["<h2>Robustness</h2>", as_html(sheet)]


def _beside(runs: Sequence[Run]) -> Sheet:
    rows = [_own(runs)] if runs else []
    for tracker in TRACKERS:
        notes = "; ".join(filter(None, (tracker.cost, tracker.differs)))
        rows.append(
            (
                f"{tracker.name}: {tracker.by}",
                tracker.motions,
                tracker.success_percent,
                tracker.global_mm,
                tracker.relative_mm,
                notes,
                f"{tracker.source} ({_CHECKED[tracker.checked]})",
            )
        )
    return Sheet(
        name="Published trackers",
        caption="Success: the joints' mean distance stays below 0.5 m; ours also without any force "
        "on the root. Mean distances of joints, ours over the successful runs.",
        head=(
            "Tracker",
            "motions",
            "success %",
            "global mm",
            "root-relative mm",
            "cost, and what differs",
            "source of the numbers",
        ),
        rows=tuple(rows),
    )


def _own(runs: Sequence[Run]) -> tuple[Any, ...]:
    good = [run for run in runs if run.success]
    cost = middle(run.cost for run in runs)
    return (
        "Understudy, measured here",
        f"{len({run.label for run in runs})} clips, each searched by itself",
        round(100.0 * len(good) / len(runs), 1),
        _mean(run.global_mm for run in good),
        _mean(run.relative_mm for run in good),
        "no training"
        + ("" if cost is None else f"; {cost:.1f} s on one core per second of motion")
        + "; the clip's own bones, human strength, MuJoCo",
        "this page",
    )


def _mean(values: Iterable[float | None]) -> float | None:
    found = [v for v in values if v is not None]
    return round(sum(found) / len(found), 1) if found else None


def _every(runs: Sequence[Run]) -> Sheet:
    return Sheet(
        name="Runs",
        caption="Help: root mean square outside force on the root, % of body weight. s free: time "
        "without it before the body was lost. Slide: of the feet, and of the cleaned clip's. "
        "Torque: the largest of any joint; the largest over a servo's limit (people's strength); "
        "time above that. Shake: joint accelerations over the clip's.",
        head=HEAD,
        rows=tuple(tuple(_number(cell) for cell in row) for row in table(runs)),
        notes=tuple(reasons(runs)),
    )


def _number(cell: str) -> str | float | None:
    """A cell as a number where it is one, so that its column is set as one."""
    try:
        return float(cell)
    except ValueError:
        return None if cell in ("", "-") else cell


def _players(runs: Sequence[Run], takes: Mapping[tuple[str, int], Path]) -> list[str]:
    parts = []
    for run in runs:
        path = takes.get((run.label, run.seed))
        if path is None or not path.exists():
            continue
        how = "free" if run.free else f"helped by {run.help_percent or 0.0:.1f} % of body weight"
        if run.lost_s is not None:
            how += f", lost at {run.lost_s:.2f} s"
        title = f"{run.name}, seed {run.seed}: {how}"
        try:
            player = player_html(load_take(path), title=title, autoplay=False)
        except InvalidValue:  # a body without any visible shape
            continue
        parts.append(
            f"<h3>{markup.escape(title)}</h3>"
            f'<iframe title="{markup.escape(title)}" sandbox="allow-scripts" loading="lazy" '
            f'srcdoc="{markup.escape(player)}"></iframe>'
        )
    return [f"<h2>The worst {len(parts)}</h2>", *parts] if parts else []


_STYLE = """
.wide td,.wide tbody th{vertical-align:top}
[aria-label="Published trackers"] tbody th{white-space:normal;min-width:10rem}
[aria-label="Published trackers"] td.words{min-width:8rem}
iframe{display:block;width:100%;height:clamp(18rem,45vw,28rem);border:1px solid var(--rule);
 border-radius:.4rem;background:#dfe6ee}
@media print{iframe{display:none}}
"""
