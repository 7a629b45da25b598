"""A runner with the shipped gains, row by row of what is asked of one.

    python benchmarks/running.py [--gains running.json] [--rows steady corner ...]

Runs last 60 s from the stored steady states; the judge of the training counts from 4 s on. Every
row prints what was found, what is wanted and whether it is so. Time against the bare engine: the
same controls, recorded and replayed by the engine's own loop, on one core.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

import understudy as us
from understudy.athletics.course import Course, track_400m
from understudy.athletics.gains import Schedule, shipped
from understudy.athletics.running_judge import Judge, report
from understudy.character import athlete_man
from understudy.control import Push
from understudy.evaluate.gait import Gait, gait_of
from understudy.evaluate.running import likeness
from understudy.performance import Performance, running
from understudy.scene import Ground
from understudy.simulate import open_loop_controls, prepared
from understudy.simulate.gears import rollout
from understudy.simulate.trials import judged

SPEEDS = (2.5, 3.0, 3.5, 4.0, 4.5, 5.0)
BODY = athlete_man()
GAINS = shipped()


def row(name: str, found: str, wanted: str, holds: bool) -> None:
    print(f"{name:<34} {found:<58} {wanted:<26} {'yes' if holds else 'NO'}", flush=True)


def run(course: Course, seconds: float, **given: object) -> Performance:
    given.setdefault("timestep", 0.001)
    friction = given.pop("friction", 1.0)
    return running(
        BODY,
        course,
        duration=seconds,
        schedule=GAINS,
        ground=Ground(friction=friction),  # type: ignore[arg-type]
        **given,  # type: ignore[arg-type]
    )


def seen(performance: Performance, begin: float = 4.0) -> dict[str, float]:
    return report(judged(performance, Judge(running=performance.controllers[0], begin=begin))[0])  # type: ignore[arg-type]


def yaw_of(take: us.Take) -> np.ndarray:
    w, x, y, z = take.qpos[:, 3:7].T
    return np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def averaged(values: np.ndarray, window: int) -> np.ndarray:
    return np.convolve(values, np.ones(window) / window, mode="valid")


def steady() -> None:
    """Sixty seconds at six speeds on two grounds; then what the judge saw of the gait."""
    stood = 0
    for friction in (1.0, 0.8):
        for speed in SPEEDS:
            one = seen(run(Course.steady(speed), 60.0, friction=friction))
            upright = not one["fell"]
            stood += upright
            name = f"{speed:g} m/s, friction {friction:g}"
            if not upright:
                row(name, f"fell after {one['time']:.1f} s", "60 s", False)
                continue
            off = 100.0 * (one["mean_speed"] / speed - 1.0)
            heading = np.degrees(np.sqrt(one["heading"]))
            row(
                f"{name}: speed, heading",
                f"{one['mean_speed']:.3f} m/s ({off:+.1f} %), {heading:.1f} deg rms",
                "3 %, 3 deg",
                abs(off) < 3.0 and heading < 3.0,
            )
            period, wanted = one["mean_period"], 0.25 - 0.032 * (speed - 2.5)
            flight, rate = period - one["mean_stance"], 1.0 / period
            row(
                "  stance, flight, step rate",
                f"{one['mean_stance']:.3f} s ({100 * (one['mean_stance'] / wanted - 1):+.0f} %), "
                f"{flight:.3f} s, {rate:.2f} Hz",
                f"{wanted:.3f} s 10 %, .08-.17, 2.6-3",
                abs(one["mean_stance"] / wanted - 1) < 0.1
                and 0.08 < flight < 0.17
                and 2.6 < rate < 3.0,
            )
            knee, swing, toe, lean = (
                np.degrees(one[f"mean_{k}"])
                for k in ("landing_knee", "swing_knee", "plantarflexion", "lean")
            )
            row(
                "  knee down, swing, toe-off, lean",
                f"{knee:.0f}, {swing:.0f}, {toe:.0f}, {lean:.0f} deg, "
                f"legs {1e3 * one['nearest']:.0f} mm apart",
                "12-30, 85-125, 12, 12, 90 mm",
                12 < knee < 30
                and 85 < swing < 125
                and toe > 12
                and lean < 12
                and one["nearest"] > 0.09,
            )
            row(
                "  force: peak, first 35 ms",
                f"{one['mean_peak']:.2f}, {one['mean_impact']:.2f} body weights",
                "2-3.2, less",
                2 < one["mean_peak"] < 3.2 and one["mean_impact"] < one["mean_peak"],
            )
    row("falls in 12 runs", f"{12 - stood}", "0", stood == 12)


def facing() -> None:
    """Heading as the pelvis has it, and averaged over a stride."""
    for speed in SPEEDS:
        take = us.simulate(run(Course.steady(speed), 20.0))
        gait = gait_of(take, start=4.0)
        stride = int(2000.0 / gait.figures()["step_rate_hz"].mean)
        yaw = np.degrees(yaw_of(take)[4000:])
        whole = averaged(yaw, stride)
        found = [float(np.sqrt(np.mean(a**2))) for a in (yaw, whole)]
        row(
            f"heading at {speed:g} m/s",
            f"pelvis {found[0]:.2f}, over a stride {found[1]:.2f} deg rms",
            "3 deg",
            found[0] < 3.0,
        )


def changing() -> None:
    """From 2.5 to 5 m/s and back."""
    course = Course(
        times=np.array([0.0, 3.0, 9.0, 13.0, 19.0]),
        speeds=np.array([2.5, 2.5, 5.0, 5.0, 2.5]),
        headings=np.zeros(5),
    )
    one = seen(run(course, 23.0))
    found = f"{'fell' if one['fell'] else 'no fall'}, {one['time']:.1f} s"
    rms = np.sqrt(one["speed"])
    row("2.5 to 5 to 2.5 m/s", f"{found}, speed {rms:.2f} m/s rms", "no fall", not one["fell"])


def laps() -> None:
    """A lap of 400 m: distance from the lane's center."""
    lane = track_400m()
    along = np.vstack((lane, lane[:1]))
    for speed in (4.0, 5.0):
        take = us.simulate(run(Course.along(lane, speed, closed=True), 400.0 / speed))
        low = take.qpos[:, 2] < 0.6
        last = int(np.argmax(low)) if low.any() else len(low)
        places = take.qpos[:last:20, :2]
        a, b = along[:-1], along[1:]
        way = b - a
        share = np.einsum("pij,ij->pi", places[:, None] - a, way) / (way**2).sum(1)
        near = a + np.clip(share, 0.0, 1.0)[..., None] * way
        aside = np.linalg.norm(places[:, None] - near, axis=2).min(axis=1)
        found = f"{'fell at ' + format(take.times[last - 1], '.1f') + ' s, ' if low.any() else ''}"
        found += f"{aside.max():.2f} m at most, {np.sqrt(np.mean(aside**2)):.2f} rms"
        row(f"lap at {speed:g} m/s", found, "0.5 m", not low.any() and aside.max() < 0.5)


def corners() -> None:
    """A right angle at 3.5 m/s and 0.5 rad/s, to either side."""
    ends = []
    for way in (1.0, -1.0):
        turn = way * np.pi / 2
        course = Course(
            times=np.array([0.0, 2.0, 2.0 + np.pi]),
            speeds=np.full(3, 3.5),
            headings=np.array([0.0, 0.0, turn]),
            turning=0.5,
        )
        take = us.simulate(run(course, 9.0))
        yaw = way * yaw_of(take)
        fell = bool((take.qpos[:, 2] < 0.6).any())
        reached = float(take.times[np.argmax(yaw > 0.9 * np.pi / 2)]) - 2.0
        place = take.qpos[-1, :2] * (1.0, way)
        over = np.degrees(yaw.max() - np.pi / 2)
        rate = float(np.max(averaged(np.gradient(yaw, 0.001), 720)))
        ends.append((reached, *place))
        row(
            f"corner to the {'left' if way > 0 else 'right'}",
            f"{'fell, ' if fell else ''}81 deg after {reached:.2f} s, {over:.0f} deg over, "
            f"{rate:.2f} rad/s",
            "no fall",
            not fell,
        )
    left, right = np.array(ends)
    apart = float(np.max(np.abs(left - right) / np.abs(left + right) * 2.0))
    row("  left against right", f"{100 * apart:.1f} % apart", "10 %", apart < 0.1)


def pushes() -> None:
    """70 N s on the pelvis from four sides at eight moments of a stride, 3.5 m/s."""
    for k, side in enumerate(("behind", "the right", "the front", "the left")):
        angle = k * np.pi / 2
        impulse = (70.0 * np.cos(angle), 70.0 * np.sin(angle), 0.0)
        fallen = []
        for phase in range(8):
            push = Push(time=2.0 + 0.09 * phase, on="pelvis", impulse=impulse)
            one = seen(run(Course.steady(3.5), 7.0, disturbances=(push,)))
            fallen += [phase] if one["fell"] else []
        found = f"{len(fallen)} of 8 fall" + (f" (at {fallen})" if fallen else "")
        row(f"70 N s from {side}", found, "none", not fallen)


def likenesses() -> None:
    """Curves over the cycle and footfalls, against people at the same speed."""
    for speed in (2.5, 3.5, 4.5):
        gait: Gait = gait_of(us.simulate(run(Course.steady(speed), 8.0)), start=3.0)
        match = likeness(gait)
        hip, knee = match.curves["hip"], match.curves["knee"]
        figures = gait.figures()
        row(
            f"curves at {speed:g} m/s: hip, knee",
            f"{hip.correlation:.2f}, {knee.correlation:.2f}; ankle "
            f"{match.curves['ankle'].correlation:.2f}; "
            f"rms {hip.rms_deg:.0f}, {knee.rms_deg:.0f} deg",
            "0.90",
            min(hip.correlation, knee.correlation) >= 0.9,
        )
        forward = figures["landing_forward_m_s"].mean
        row("  ankle over ground at touchdown", f"{forward:.1f} m/s forward", "1", forward < 1.5)


def torques() -> None:
    """Share of the time in which a command passes the motor's limit."""
    limits = np.array(
        [BODY.torque_range(i, k) for i, own in enumerate(BODY.hinge_names) for k in range(len(own))]
    )
    names = [name for own in BODY.hinge_names for name in own]
    for speed in (2.5, 3.5, 5.0):
        ctrl = us.simulate(run(Course.steady(speed), 8.0)).ctrl[3000:-1]
        over = (ctrl > limits[:, 1]) | (ctrl < limits[:, 0])
        share = 100.0 * over.mean(axis=0)
        most = np.maximum(ctrl / limits[:, 1], ctrl / limits[:, 0]).max(axis=0)
        worst = np.argsort(share)[::-1][:3]
        text = ", ".join(f"{names[k]} {share[k]:.1f} % to {most[k]:.1f}x" for k in worst)
        any_over = 100.0 * over.any(axis=1).mean()
        row(
            f"torque clipped at {speed:g} m/s",
            f"{any_over:.1f} %: {text}"[:58],
            "0 at 3.5",
            any_over < 0.1,
        )


def timesteps() -> None:
    """The same outcome with half the time step."""
    for speed in (2.5, 3.5, 5.0):
        both = [seen(run(Course.steady(speed), 20.0, timestep=dt)) for dt in (0.001, 0.0005)]
        found = "; ".join(
            f"{'fell' if b['fell'] else 'ok'} {b['mean_speed']:.2f} m/s "
            f"{1e3 * b['mean_stance']:.0f} ms"
            for b in both
        )
        row(f"steps of 1 and 0.5 ms at {speed:g}", found, "same", not any(b["fell"] for b in both))


def speed() -> None:
    """Times real time, and the law's share over the bare engine loop, the least of five."""
    whole = run(Course.steady(3.5), 10.0)
    us.simulate(replace(whole, duration=0.1))
    with_law, bare = [], []
    for _ in range(5):
        begun = time.perf_counter()
        take = us.simulate(whole)
        with_law.append(time.perf_counter() - begun)
        model, data = prepared(whole)
        block = replace(open_loop_controls(whole, model), ctrl=np.array(take.ctrl[:-1]))
        states = np.empty(
            (whole.steps + 1, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        )
        mujoco.mj_getState(model, data, states[0], mujoco.mjtState.mjSTATE_FULLPHYSICS)
        begun = time.perf_counter()
        for _ in rollout(model, data, block, states):
            pass
        bare.append(time.perf_counter() - begun)
    times, more = 10.0 / min(with_law), 100.0 * (min(with_law) / min(bare) - 1.0)
    row(
        "speed on one core",
        f"{times:.0f}x real time, {more:.0f} % over the bare loop",
        "25x, 35 %",
        times > 25 and more < 35,
    )


ROWS: dict[str, Callable[[], None]] = {
    "steady": steady,
    "facing": facing,
    "changing": changing,
    "laps": laps,
    "corners": corners,
    "pushes": pushes,
    "people": likenesses,
    "torques": torques,
    "timesteps": timesteps,
    "speed": speed,
}


def main() -> None:
    global GAINS
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gains", type=Path, help="another running.json")
    parser.add_argument("--rows", nargs="*", choices=tuple(ROWS), default=tuple(ROWS))
    given = parser.parse_args()
    if given.gains is not None:
        GAINS = Schedule.from_json(json.loads(given.gains.read_text(encoding="utf-8")))
    for name in given.rows:
        ROWS[name]()


if __name__ == "__main__":
    main()
