"""Task controllers: what they hold, how a hit body comes back, and what they cost.

    python benchmarks/tasks.py [--repeats 9] [--clips FOLDER]

With a folder of BVH files, those of six seconds and more are pushed too, three seconds in.

Cost: the same scene, steps and controls, in turns, in one process on one core: "tracked" is the
engine loop of `simulate` without tasks (open-loop controls), "with task" the compiled loop that
asks the law at every step; the least time of each counts. References and tables, made once per run,
are left out of both.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

import understudy as us
from understudy.character import adult_man
from understudy.control import GiveWay, HandOn, LookAt, Push, Reach, Task, Tracking, Upright
from understudy.evaluate import compare
from understudy.motion import rotations as rot
from understudy.performance import Performance
from understudy.scene import Staff
from understudy.simulate import open_loop_controls, prepared, simulate_many
from understudy.simulate.gears import compiled, rollout


def staff() -> None:
    clip = us.sample("staff")
    body = us.Character.from_clip(clip)

    def tilt(take: us.Take) -> tuple[np.ndarray, np.ndarray]:
        times, _, turned = take.poses(120.0)
        up = rot.rotate(turned[:, take.model.body("staff").id], np.array([0.0, 0.0, 1.0]))[:, 2]
        return times, np.degrees(np.arccos(np.clip(np.abs(up), 0.0, 1.0)))

    print("staff: angle from vertical [deg]")
    for name, tasks in (("clip's wrist", []), ("Upright", [Upright()])):
        times, angle = tilt(us.track(clip, body, props=[Staff()], tasks=tasks))
        seen = angle[times > 0.7]
        print(f"  {name:<14} rms {np.sqrt(np.mean(seen**2)):6.2f}  most {seen.max():6.2f}")
    for grip in (0.5, 0.35):
        knock = Push(time=3.0, on="staff", impulse=(3.5, 3.5, 0.0))
        times, angle = tilt(
            us.track(clip, body, props=[Staff(grip=grip)], tasks=[Upright(), knock])
        )
        late = times[(times > 3.0) & (angle > 3.0)]
        back = late.max() - 3.0 if len(late) else 0.0
        print(
            f"  5 N s at {grip:g}     most {angle[times > 3.0].max():6.2f}  "
            f"within 3 deg after {back:.2f} s"
        )


def hits(folder: Path | None) -> None:
    print("hit and recover: 10 pushes of 50 to 100 N s from all sides, pelvis assisted")
    print("  degrees off the clip; from 1.5 s after the push in brackets without it")
    print(f"  {'clip':<12}{'joint at most':>16}{'then, rms':>16}{'then, worst':>16}{'root mm':>9}")
    clips = {name: (us.sample(name), 2.0) for name in ("gesture", "walk")}
    for path in sorted(folder.rglob("*.bvh")) if folder else ():
        clip = us.read(path)
        if clip.duration >= 6.0:
            clips[path.stem] = clip.trimmed(0.0, 6.0), 3.0
    for name, (clip, at) in clips.items():
        body = us.Character.from_clip(clip)
        pushes = [
            Push(
                time=at,
                on=("chest", "abdomen")[k % 2],
                impulse=(
                    (50.0 + 50.0 * k / 9.0) * np.cos(0.2 * np.pi * k),
                    (50.0 + 50.0 * k / 9.0) * np.sin(0.2 * np.pi * k),
                    0.0,
                ),
            )
            for k in range(10)
        ]
        made = [us.tracked(clip, body, tasks=[push, GiveWay.after(push)]) for push in pushes]
        takes = simulate_many([*made, us.tracked(clip, body, tasks=[GiveWay()])])
        rows = [_off(take, at) for take in takes if isinstance(take, us.Take)]
        (hit, rms, worst, root), plain = np.max(rows[:-1], axis=0), rows[-1]
        lost = "" if len(rows) == 11 else f"  {11 - len(rows)} diverged"
        print(
            f"  {name:<12}{hit:>16.1f}{rms:>8.2f} ({plain[1]:.2f}){worst:>9.1f} ({plain[2]:.1f})"
            f"{root:>9.0f}{lost}"
        )


def _off(take: us.Take, at: float) -> tuple[float, float, float, float]:
    """Worst joint within a second of a hit, then rms and worst joint [deg] and root [mm]."""
    reference = take.references[0]
    assert reference is not None
    found = compare.compared(take.clip(rate=reference.rate), reference)
    angles = np.degrees(np.column_stack((found.joint_angles, found.root_angles)))
    hit = (found.times > at) & (found.times < at + 1.0)
    late = found.times >= at + 1.5
    rms = np.sqrt(np.mean(np.square(angles), axis=1))
    root = 1e3 * found.root_distances[late].max()
    return angles[hit].max(), rms[late].max(), angles[late].max(), root


def cost(repeats: int) -> None:
    print("cost of a step [us], full body on the ground")
    print(f"  {'task':<22}{'tracked':>9}{'with task':>11}{'ratio':>8}")
    clip = us.sample("gesture").trimmed(0.0, 3.0)
    cases: list[tuple[str, list[Task]]] = [
        ("Upright", [Upright()]),
        ("Reach", [Reach(target=(0.42, -0.2, 1.2))]),
        ("HandOn", [HandOn(target=(0.4, -0.2, 1.1))]),
        ("LookAt", [LookAt(target=(2.0, 1.0, 1.0))]),
        ("GiveWay, weak", [GiveWay(hits=(0.0,), limp=60.0)]),
        ("Reach, LookAt, GiveWay", [Reach(target=(0.42, -0.2, 1.2)), LookAt(target=(2, 1, 1)),
                                    GiveWay(hits=(0.0,), limp=60.0)]),
    ]  # fmt: skip
    try:
        from understudy.control import Balance

        cases.insert(4, ("Balance", [Balance()]))
    except ImportError:
        pass
    for name, tasks in cases:
        performance = us.tracked(clip, adult_man(), tasks=tasks)
        plain, driven = _step_costs(performance, repeats)
        print(f"  {name:<22}{plain:>9.1f}{driven:>11.1f}{driven / plain:>8.3f}")


def _step_costs(performance: Performance, repeats: int) -> tuple[float, float]:
    """Microseconds a step: the recorded controls replayed open loop, and with the laws asked."""
    take = us.simulate(performance)
    model, data = prepared(performance)
    block = open_loop_controls(performance, model)
    steps = performance.steps
    laws = [c for c in performance.controllers if not isinstance(c, Tracking)]
    ready = [law.feedback(performance.scene, model) for law in laws]  # type: ignore[attr-defined]

    class Ready:
        def __init__(self, made):
            self.made = made

        def feedback(self, scene, model):
            law, parameters, memory = self.made
            return law, parameters, memory.copy()

    states = np.empty((steps + 1, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    best = np.full(2, np.inf)
    for _ in range(repeats):
        for k in range(2):
            mujoco.mj_resetData(model, data)
            data.qpos[:], data.qvel[:] = take.qpos[0], take.qvel[0]
            mujoco.mj_forward(model, data)
            mujoco.mj_getState(model, data, states[0], mujoco.mjtState.mjSTATE_FULLPHYSICS)
            if k == 0:
                run = rollout(model, data, replace(block, ctrl=np.array(take.ctrl[:-1])), states)
            else:
                fresh = replace(block, ctrl=block.ctrl.copy(), applied=np.zeros((steps, model.nv)))
                run = compiled(
                    performance, model, data, [Ready(made) for made in ready], fresh, states
                )
            started = time.process_time()
            list(run)
            best[k] = min(best[k], time.process_time() - started)
    return 1e6 * best[0] / steps, 1e6 * best[1] / steps


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--clips", type=Path)
    given = parser.parse_args()
    staff()
    hits(given.clips)
    cost(given.repeats)
