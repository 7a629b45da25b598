"""How well bows are held with nothing but the feet, what pushes do, and what the law costs.

    python benchmarks/bow.py [--repeats 7]

Bows by 60, 80 and 100 degrees (the line from pelvis to neck from the vertical), held for two
seconds. "tracking" follows the same balanced clip with servos and feedforward alone. A push lasts
0.1 s, from four sides, on pelvis and chest, in the hold and while standing still; the body has
fallen when its center of mass is 0.3 m from the middle of the soles or half as high as at first; it
survives when at the end it is within 40 mm of it. Cost: both advance the same scene in turns, in
one process and thread; the least CPU time of each counts.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import mujoco
import numpy as np

from understudy.character import Character, body
from understudy.character.footing import sole_of
from understudy.control import Balance, Push
from understudy.errors import Diverged
from understudy.motion.clip import Clip
from understudy.motion.samples.bowing import HELD, bow, trunk_tilt
from understudy.motion.skeleton import Skeleton
from understudy.performance import Performance, tracked
from understudy.simulate import open_loop_controls, prepared, simulate, simulate_many
from understudy.simulate.gears import STATE, compiled, rollout
from understudy.take import Take

ANGLES = (60.0, 80.0, 100.0)
BODIES = ("own", "adult_woman", "child", "alien")
SIDES = {"front": (-1, 0, 0), "behind": (1, 0, 0), "left": (0, -1, 0), "right": (0, 1, 0)}


def performer(name: str, clip: Clip) -> Character:
    return Character.from_clip(clip) if name == "own" else body(name)


def from_support(take: Take, every: int = 20) -> np.ndarray:
    """Center of mass from the middle of the soles [m], every so many steps."""
    scene, data, out = take.scene, mujoco.MjData(take.model), []
    who, part = scene.characters[0], scene.parts[0]
    for q in take.qpos[::every]:
        data.qpos[:] = q
        mujoco.mj_kinematics(take.model, data)
        mujoco.mj_comPos(take.model, data)
        soles = []
        for side in ("left", "right"):
            foot = part.bodies[who.index(f"{side}_ankle")]
            middle = sole_of(who, side).middle
            soles.append(data.xpos[foot] + data.xmat[foot].reshape(3, 3) @ middle)
        out.append(data.subtree_com[part.bodies[0]] - np.mean(soles, axis=0))
    return np.array(out)


def fell(take: Take | Diverged) -> float | None:
    """When it fell [s], or None."""
    take = take if isinstance(take, Take) else take.take
    away, every = from_support(take), 20
    down = np.linalg.norm(away[:, :2], axis=1) > 0.3
    down |= away[:, 2] < 0.5 * away[0, 2]
    first = np.flatnonzero(down)
    return float(first[0] * every / take.rate) if len(first) else None


def holds(name: str, angle: float, step: float | None = None) -> str:
    clip = bow(angle)
    take = simulate(tracked(clip, performer(name, clip), tasks=[Balance()], timestep=step))
    away = 1e3 * np.linalg.norm(from_support(take)[:, :2], axis=1)
    times = np.arange(len(away)) * 20 / take.rate
    inside = (times > HELD[0]) & (times < HELD[1])
    simulated = take.clip()
    hold = (simulated.times > HELD[0] + 0.1) & (simulated.times < HELD[1] - 0.1)
    part = take.scene.parts[0]
    helped = np.abs(take.model.actuator_gainprm[list(part.root_actuators)]).max()
    helped += np.abs(take.model.actuator_biasprm[list(part.root_actuators)]).max()
    helped += np.abs(take.qfrc_applied).max()
    return (
        f"{name:12s} {angle:4.0f} deg  dt {1e3 / take.rate:4.2f} ms  "
        f"tilt {trunk_tilt(simulated)[hold].mean():6.1f} deg  "
        f"root force {helped:.0f} N  center of mass {away[inside].mean():4.1f} mm mean, "
        f"{away[inside].max():4.1f} max of the hold, {away.max():4.1f} of all  "
        f"fell: {fell(take) or 'no'}"
    )


def pushes(name: str, what: str, impulse: float) -> str:
    """Survived pushes of one kind, with the law and by tracking alone."""
    if what == "standing":
        clip = bow(60.0).trimmed(0.0, 1.2).retimed(0.3)
    else:
        clip = bow(float(what)).trimmed(*HELD).retimed(0.5)
    base = tracked(clip, performer(name, clip), tasks=[Balance()])
    text = []
    for kind, with_law in (("balance", True), ("tracking", False)):
        controllers = base.controllers if with_law else base.controllers[:1]
        runs, labels = [], []
        for on in ("pelvis", "chest"):
            for side, way in SIDES.items():
                force = tuple(impulse * np.array(way, float))
                push = Push(time=0.3, on=on, impulse=force)
                runs.append(replace(base, controllers=(*controllers, push)))
                labels.append(f"{on} from {side}")
        lost, farthest = [], 0.0
        for label, take in zip(labels, simulate_many(runs), strict=True):
            if fell(take) is not None or isinstance(take, Diverged):
                lost.append(label)
                continue
            away = 1e3 * np.linalg.norm(from_support(take)[:, :2], axis=1)
            farthest = max(farthest, away.max())
            if away[-1] > 40.0:
                lost.append(f"{label} (ends {away[-1]:.0f} mm off)")
        text.append(
            f"{kind} {len(runs) - len(lost)} of {len(runs)}, {farthest:.0f} mm"
            + (f" [not: {', '.join(lost)}]" if lost else "")
        )
    label = what if what == "standing" else f"{what} deg"
    return f"{name:12s} {label:9s} {impulse:5.1f} N s  " + "; ".join(text)


def without_legs(clip: Clip) -> Clip:
    """What is captured when only the upper body is."""
    skeleton = clip.skeleton
    legs = ("hip", "knee", "ankle", "ball")
    kept = [i for i, name in enumerate(skeleton.names) if not name.endswith(legs)]
    ends = [k for k, joint in enumerate(skeleton.end_joints) if joint in kept]
    parents = [skeleton.parents[i] for i in kept]
    upper = Skeleton(
        names=tuple(skeleton.names[i] for i in kept),
        parents=tuple(-1 if p < 0 else kept.index(p) for p in parents),
        offsets=skeleton.offsets[kept],
        end_joints=tuple(kept.index(skeleton.end_joints[k]) for k in ends),
        end_offsets=skeleton.end_offsets[ends],
    )
    return replace(clip, skeleton=upper, rotations=clip.rotations[:, kept])


def uncaptured(angle: float) -> str:
    clip = bow(angle)
    character = Character.from_clip(clip)
    upper = without_legs(clip)
    law = simulate(tracked(upper, character, tasks=[Balance()]))
    alone = simulate(tracked(upper, character, pelvis="free"))
    away = 1e3 * np.linalg.norm(from_support(law)[:, :2], axis=1).max()
    return (
        f"legs never captured, {angle:3.0f} deg: balance {away:.1f} mm at most, fell "
        f"{fell(law) or 'never'}; tracking alone fell at {fell(alone):.2f} s"
    )


def cost(performance: Performance, repeats: int) -> float:
    """Least time of one step [us] of the stepping alone."""
    model, first = prepared(performance)
    feedback = [c for c in performance.controllers if hasattr(c, "feedback")]
    block = open_loop_controls(performance, model)
    best = np.inf
    for _ in range(repeats):
        states = np.empty((performance.steps + 1, mujoco.mj_stateSize(model, STATE)))
        data = mujoco.MjData(model)
        mujoco.mj_getState(model, first, states[0], STATE)
        mujoco.mj_setState(model, data, states[0], STATE)
        mujoco.mj_forward(model, data)
        ctrl = replace(
            block, ctrl=block.ctrl.copy(), applied=np.zeros((performance.steps, model.nv))
        )
        start = time.thread_time()
        if feedback:
            list(compiled(performance, model, data, feedback, ctrl, states))
        else:
            list(rollout(model, data, block, states))
        best = min(best, time.thread_time() - start)
    return 1e6 * best / performance.steps


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=7)
    arguments = parser.parse_args()
    print("held bows")
    for name in BODIES:
        for angle in ANGLES:
            print(holds(name, angle), flush=True)
    for step in (0.001, 0.002, 0.004):
        print(holds("own", 80.0, step), flush=True)
    print("legs")
    for angle in ANGLES:
        print(uncaptured(angle), flush=True)
    print("pushes of 0.1 s")
    own = performer("own", bow(60.0))
    for name in BODIES:
        who = performer(name, bow(60.0))
        # The same push for every body, to its size: 20 N s for the adult of 67 kg and 1.75 m.
        scale = (who.mass * who.height**0.5) / (own.mass * own.height**0.5)
        for what in ("standing", "60", "80", "100"):
            print(pushes(name, what, 20.0 * scale), flush=True)
    print("cost")
    balance = tracked(bow(80.0), own, tasks=[Balance()])
    alone = replace(balance, controllers=balance.controllers[:1])
    times = [[cost(p, 1) for p in (alone, balance)] for _ in range(arguments.repeats)]
    tracking, law = np.min(times, axis=0)
    print(f"tracking {tracking:.1f} us/step  balance {law:.1f} us/step  ratio {law / tracking:.3f}")


if __name__ == "__main__":
    main()
