"""How starts and stops go: speeds, friction, time steps, moments of the step. Prints a table.

    python benchmarks/standing.py [--threads 2]

A start goes from standing to the speed; a stop from a steady run at it, asked for at four moments
0.1 s apart. Nothing is asserted.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ThreadPoolExecutor
from itertools import product

from understudy.athletics.gains import shipped
from understudy.athletics.standing_gains import shipped_standing
from understudy.athletics.standing_judge import start_and_stop
from understudy.character import athlete
from understudy.simulate import quiet_engine
from understudy.standing_training import Outing, gone

SPEEDS, FRICTIONS, STEPS = (2.5, 3.0, 3.5, 4.0, 4.5, 5.0), (1.0, 0.8), (0.001, 0.0005)
HOLDS = {"start": (2.0,), "stop": (0.9, 1.0, 1.1, 1.2)}


def one(case: tuple[str, float, float, float, str]) -> str:
    """One row of the table: how many stayed up, and the slowest of them."""
    part, step, friction, speed, who = case
    held, falls = [], 0
    for hold in HOLDS[part]:
        outing = Outing(part=part, speed=speed, friction=friction, hold=hold)  # type: ignore[arg-type]
        seen = gone(outing, shipped(), shipped_standing(), athlete(who), timestep=step)
        falls += seen.fell
        if not seen.fell:
            found = start_and_stop(seen, outing.course)
            held.append([found[f"{part}_s"], found[f"{part}_m"], found["residual_speed_m_s"]])
    row = f"{part:6} {speed:4.1f} m/s  friction {friction:.1f}  step {1000 * step:.1f} ms  {who:6}"
    row += f"{len(held)} of {len(HOLDS[part])} stay up"
    for name, values in zip(("s", "m", "m/s at the end"), zip(*held, strict=True), strict=False):
        known = [value for value in values if value is not None]
        row += f"  {max(known):.2f} {name}" if known else "  -"
    return row


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--who", default="man", choices=("man", "woman"))
    options = parser.parse_args()
    cases = product(("start", "stop"), STEPS, FRICTIONS, SPEEDS, (options.who,))
    with quiet_engine(), ThreadPoolExecutor(options.threads) as pool:
        for row in pool.map(one, cases):
            print(row, flush=True)


if __name__ == "__main__":
    main()
