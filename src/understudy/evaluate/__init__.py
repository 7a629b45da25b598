"""Take -> numbers: scores, the certificate, forces and energy, plots.

In comes a `Take`; out go `Score` (how well it tracks and how physical it is), the certificate (the
same as a JSON document, with a sentence that says what it means), `Measured` (forces, torques and
energy frame by frame), contact events (what touched what, when and how hard), pushes, gait and
charts. `people` and `running` hold a gait against published measurements.
Definitions and formulas: docs/evaluation.md.
"""

from understudy.evaluate.certificate import certificate, write_certificate
from understudy.evaluate.events import ContactEvent, contact_events, contact_force
from understudy.evaluate.following import Following, following
from understudy.evaluate.gait import Gait, gait_of
from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.outcomes import Outcome, outcomes
from understudy.evaluate.overlap import overlap
from understudy.evaluate.pushes import PushEvent, push_events
from understudy.evaluate.score import Score, score

__all__ = [
    "ContactEvent",
    "Following",
    "Gait",
    "Measured",
    "Outcome",
    "PushEvent",
    "Score",
    "certificate",
    "contact_events",
    "contact_force",
    "following",
    "gait_of",
    "measured",
    "outcomes",
    "overlap",
    "push_events",
    "score",
    "write_certificate",
]
