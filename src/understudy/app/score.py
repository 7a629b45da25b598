"""`understudy score`: the certificate of a saved take."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from understudy.app.outcome import Outcome

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
    from understudy.evaluate import certificate
    from understudy.evaluate.certificate import scored

    take = us.load_take(options.take)
    scores = scored(take)
    found = certificate(take, scores=scores)
    text = "\n\n".join(str(score) for score in scores)
    return Outcome(result=found, text=f"{text}\n\n{found['statement']}")
