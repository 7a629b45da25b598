"""Searches for the drive's parameters K_f, K_vc and n that follow a clip best (equation 4).

Two searches over one objective, the squared position error of the paper's law:

- `monte_carlo`: algorithm 1 of Wilke & Semwal 2017, a random walk of K_f and K_vc that tries every
  order n in turn. The walk does not depend on results, so all points of a run are drawn first and
  run as one batch on all cores.
- `cma`: CMA-ES (Hansen), which needs a tenth of the simulations.

An explicit step bears K_f dt < 2 only. The published walk may leave that range, where the bodies
fly apart; here it is reflected at both ends of it, so that no simulation is wasted.

In: a clip and a linkage. Out: the trial of least error, as keyword arguments of `driven`.
"""

from understudy.drive_tuning.search import METHODS, PAPER_RATE, PAPER_SCALE, Method, tune_drive
from understudy.drive_tuning.transfer import Transferred, transferred
from understudy.drive_tuning.trials import (
    DriveTrial,
    TunedDrive,
    parameters_of,
    read_parameters,
    write_parameters,
)

__all__ = [
    "METHODS",
    "PAPER_RATE",
    "PAPER_SCALE",
    "DriveTrial",
    "Method",
    "Transferred",
    "TunedDrive",
    "parameters_of",
    "read_parameters",
    "transferred",
    "tune_drive",
    "write_parameters",
]
