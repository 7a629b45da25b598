"""A drum stroke at 3 m/s with and without contact, at steps of 1, 2 and 4 ms.

    python benchmarks/drum.py

The clip's hand passes the plane of the skin and goes on for 6 cm: without contact the hand goes
through the drum, with contact it stops at the skin. Peak force and duration depend on the step and
on how stiff the surface is; the impulse of the impact must not.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from understudy.character.bodies import adult_man
from understudy.evaluate.events import contact_force
from understudy.evaluate.overlap import overlap
from understudy.motion import rotations as rot
from understudy.motion.samples import sample
from understudy.motion.samples.striking import DRUM, HITS
from understudy.performance import Performance, tracked
from understudy.scene import Drum
from understudy.simulate import simulate
from understudy.take import Take

HAND, NAME = "right_hand", "drum"
# An impact is over this long after the first touch [s]; then the hand is pushed up and leaves.
IMPACT = 0.1


def played(step: float, *, plan: str = "upper", contact: bool = True) -> Take:
    """Four strokes tracked by a man at a step [s]."""
    whole = tracked(sample("strike"), adult_man(plan=plan), timestep=step)  # type: ignore[arg-type]
    scene = replace(
        whole.scene,
        props=(Drum(name=NAME, position=placed(whole)),),
        contacts=((HAND, NAME),) if contact else (),
    )
    return simulate(replace(whole, scene=scene))


def placed(performance: Performance) -> tuple[float, float, float]:
    """Where the skin is for a body of another height than the figure's."""
    reference = performance.controllers[0].reference  # type: ignore[attr-defined]
    pose, link = reference.forward_kinematics(), reference.skeleton.index("right_wrist")
    frames = [round(hit * reference.rate) for hit in HITS]
    figure = sample("strike")
    there = figure.forward_kinematics().positions[frames, figure.skeleton.index("right_wrist")]
    here = pose.positions[frames, link]
    x, y, z = np.array(DRUM) + np.mean(here - there, axis=0)
    return float(x), float(y), float(z)


def main() -> None:
    for plan in ("upper", "full"):
        print(f"plan {plan}")
        for step in (0.001, 0.002, 0.004):
            through = 1000.0 * overlap(played(step, plan=plan, contact=False), HAND, NAME)
            take = played(step, plan=plan)
            deep = 1000.0 * overlap(take, HAND, NAME)
            force = np.linalg.norm(contact_force(take, HAND, NAME), axis=1)
            speed = -np.gradient(palm(take), step)
            rows = []
            for hit in HITS:
                window = np.flatnonzero(np.abs(take.times - hit) < 0.25)
                touching = window[force[window] > 0.0]
                first = touching[0]
                span = touching[touching < first + round(IMPACT / step)]
                rows.append(
                    (
                        speed[max(first - 1, 0)],
                        deep[window].max(),
                        through[window].max(),
                        force[span].sum() * step,
                        force[span].max(),
                        1000.0 * step * (touching[-1] - first + 1),
                    )
                )
            table = np.array(rows)
            print(
                f"  step {1000 * step:.0f} ms  arrives at {table[:, 0].min():.2f} to "
                f"{table[:, 0].max():.2f} m/s  deep {table[:, 1].max():5.2f} mm  without contact "
                f"{table[:, 2].min():5.1f} to {table[:, 2].max():.1f} mm  impulse "
                f"{' '.join(f'{v:.2f}' for v in table[:, 3])} N s  peak {table[:, 4].mean():5.0f} N"
                f"  touching {table[:, 5].mean():4.0f} ms",
                flush=True,
            )


def palm(take: Take) -> np.ndarray:
    """Height of the middle of the palm at every step [m]."""
    clip = take.clip(rate=take.rate)
    pose, link = clip.forward_kinematics(), clip.skeleton.index("right_wrist")
    turned, middle = pose.rotations[:, link], np.array([0.0, -0.089, -0.021])
    return (pose.positions[:, link] + rot.rotate(turned, middle))[:, 2]


if __name__ == "__main__":
    main()
