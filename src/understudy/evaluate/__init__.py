"""Take -> numbers: scores, the certificate, forces and energy, plots.

In comes a `Take`; out go `Score` (how well it tracks and how physical it is), the certificate (the
same as a JSON document, with a sentence that says what it means), `Measured` (forces, torques and
energy frame by frame) and charts. Definitions and formulas: docs/evaluation.md.
"""

from understudy.evaluate.certificate import certificate, write_certificate
from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.score import Score, score

__all__ = ["Measured", "Score", "certificate", "measured", "score", "write_certificate"]
