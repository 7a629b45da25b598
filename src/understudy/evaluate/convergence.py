"""How searches for the drive's parameters converged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.drive_tuning import TunedDrive
from understudy.evaluate.chart import Chart, Series

_NAMES = {"monte_carlo": "algorithm 1 (Monte Carlo)", "cma": "CMA-ES"}


def convergence(searches: Sequence[TunedDrive]) -> Chart:
    """Least error so far against simulations, one line per search of the same clip and linkage."""
    s = searches[0].settings
    lines = []
    for search in searches:
        errors = np.minimum.accumulate([t.error for t in search.trials])
        name = f"{_NAMES[search.settings['method']]}: {search.best.error:.3g}"
        counts = np.arange(1.0, len(errors) + 1.0)
        lines.append(Series(name=name, x=counts, y=np.where(np.isfinite(errors), errors, np.nan)))
    return Chart(
        title=f"Tuning {s['kind']} on {s['clip']}",
        caption=f"Least squared error so far, equation 4, over {s['duration_s']:.1f} s. 1 unit = "
        f"{1e3 * s['unit_m']:.1f} mm, gravity {s['gravity_units_per_s2']:.3g} units/s^2, scale "
        f"{s['scale']:g}, step {1e3 / s['rate_hz']:.3g} ms.",
        x_label="Simulations",
        y_label="Least e^2 so far [units^2]",
        series=tuple(lines),
        x_scale="log",
        decimals=3,
    )
