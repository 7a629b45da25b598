"""`understudy score`: the certificate of a saved take."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome

SHOWN = 20  # contact events printed, those of the largest impulse
EXAMPLE = "  understudy score out/gesture.take.npz"


@dataclass(frozen=True, kw_only=True)
class Options:
    """Print the certificate of a saved take: how close, how physical, how much help.

    Attributes:
        take: A take file, NAME.take.npz.
        json: Print one JSON object: the certificate.
    """

    take: Positional[Annotated[Path, arg(metavar="TAKE")]]
    json: bool = False


def run(options: Options) -> Outcome:
    """Score every character of the take."""
    import understudy as us
    from understudy.evaluate import certificate, measured
    from understudy.evaluate.certificate import called, scored

    take = us.load_take(options.take)
    measures = measured(take)
    scores = scored(take, measures=measures)
    found = certificate(take, scores=scores, measures=measures)
    shown = [
        str(score).replace(score.character, called(take, scores, k), 1)
        for k, score in enumerate(scores)
    ]
    parts = [*shown, _contacts(found), found["statement"]]
    return Outcome(result=found, text="\n\n".join(filter(None, parts)))


def _contacts(found: dict[str, Any]) -> str:
    """Contact events, then feet on the ground, in lines of at most 80 characters."""
    listed = sorted(found["contacts"], key=lambda event: -event["impulse_ns"])[:SHOWN]
    rows = [
        (
            " - ".join(event["between"]),
            f"{event['start_s']:8.3f} s {1e3 * event['duration_s']:6.0f} ms "
            f"{event['impulse_ns']:8.2f} N s {event['peak_force_n']:7.0f} N peak "
            f"{event['penetration_mm']:5.1f} mm",
        )
        for event in sorted(listed, key=lambda event: event["start_s"])
    ]
    more = found["contacts_in_all"] - len(rows)
    feet = [
        (
            foot["foot"],
            f"{foot['touchdowns']} on the ground, mean {1e3 * foot['stance_mean_s']:.0f} ms, "
            f"{foot['impulse_mean_ns']:.0f} N s, peak {foot['peak_force_n']:.0f} N "
            f"({foot['peak_force_percent']:.0f} % of body weight)",
        )
        for foot in found["feet_on_ground"]
    ]
    if not rows and not feet:
        return ""
    width = max(len(label) for label, _ in (*rows, *feet))
    lines = [f"  {label:<{width}}  {text}" for label, text in rows]
    lines += [f"  and {more} smaller ones; --json lists them"] if more > 0 else []
    lines += [f"  {label:<{width}}  {text}" for label, text in feet]
    return "\n".join(["contacts", *lines])
