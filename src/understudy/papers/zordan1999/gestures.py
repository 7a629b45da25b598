"""Figures 1 and 7: one actor's gesture by bodies of other sizes, shapes and masses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from understudy.character import Character, retargeted
from understudy.character.bodies import BODIES
from understudy.evaluate import score
from understudy.evaluate.chart import Chart, Series
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.papers.filmstrip import Film
from understudy.papers.finding import Claim, Finding, Strip
from understudy.papers.sheets import Sheet
from understudy.papers.zordan1999.cast import Cast
from understudy.papers.zordan1999.finding import LAW_NAMES, hand_path, spread
from understudy.performance import tracked
from understudy.simulate import simulate
from understudy.take import Take

# The upper-body model, as in the paper's gestures, and the whole body.
PLANS = ("upper", "full")
LAWS = ("paper", "modern")
_SHOWN = "full"  # in pictures a body has legs


def gesturing(cast: Cast, *, quick: bool = False) -> Finding:
    """Every body, plan and law."""
    actor = Character.from_clip(cast.gesture)
    motion = retargeted(cast.gesture, actor)
    bodies = ("adult_man", "alien") if quick else tuple(BODIES)
    takes: dict[tuple[str, str, str], Take] = {}
    rows = []
    for name in bodies:
        for plan in PLANS:
            body = BODIES[name](plan=plan)  # type: ignore[call-arg]
            for law in LAWS[1:] if quick and plan == "full" else LAWS:
                take = simulate(tracked(cast.gesture, body, law=law))
                takes[name, plan, law] = take
                rows.append(_row(name, plan, law, body, take, motion))
    return _finding(cast, motion, takes, rows)


def raised(clip: Clip) -> Array:
    """Height of the right palm over its shoulder, in lengths of the arm, shape (frames,)."""
    skeleton, pose = clip.skeleton, clip.forward_kinematics()
    joints = [skeleton.index(f"right_{part}") for part in ("shoulder", "elbow", "wrist")]
    arm = float(np.linalg.norm(skeleton.offsets[joints[1:]], axis=1).sum())
    return (hand_path(clip)[:, 2] - pose.positions[:, joints[0], 2]) / arm


def likeness(take: Take, motion: Clip) -> float:
    """Correlation of the height of the hand with the actor's, at the lag that suits best."""
    mine, theirs = raised(take.clip(rate=motion.rate)), raised(motion)
    count = min(len(mine), len(theirs))
    best = -1.0
    for lag in range(round(0.25 * motion.rate)):
        a, b = mine[lag:count], theirs[: count - lag]
        if np.ptp(a) > 0 and np.ptp(b) > 0:
            best = max(best, float(np.corrcoef(a, b)[0, 1]))
    return best


def _row(
    name: str, plan: str, law: str, body: Character, take: Take, motion: Clip
) -> tuple[object, ...]:
    s = score(take)
    return (
        name.replace("_", " "),
        plan,
        law,
        body.height,
        body.mass,
        s.joint_error_deg,
        s.lag_ms,
        s.joint_error_without_lag_deg,
        likeness(take, motion),
        s.torque_peak_nm,
        s.root_force_mean_percent if plan == "full" else None,
    )


def _apart(takes: Mapping[tuple[str, str, str], Take], plan: str, law: str) -> float:
    """Mean angle by which the arms of different bodies differ from the first's [deg]."""
    chosen = [take for (_, p, k), take in takes.items() if (p, k) == (plan, law)]
    clips = [take.clip() for take in chosen]
    joints = [
        f"{side}_{part}" for side in ("left", "right") for part in ("shoulder", "elbow", "wrist")
    ]
    first, others = clips[0], clips[1:]
    angles = [
        rot.angle(rot.multiply(rot.conjugate(first.joint(j)), other.joint(j)))
        for other in others
        for j in joints
    ]
    return float(np.degrees(np.mean(angles)))


def _finding(
    cast: Cast,
    motion: Clip,
    takes: Mapping[tuple[str, str, str], Take],
    rows: list[tuple[object, ...]],
) -> Finding:
    def column(k: int, law: str) -> list[float]:
        return [float(str(row[k])) for row in rows if row[2] == law]

    alike, alike_paper = min(column(8, "modern")), min(column(8, "paper"))
    error, lag = max(column(5, "modern")), column(6, "paper")
    without = max(column(7, "paper"))
    torques = column(9, "modern")
    bodies = list(dict.fromkeys(name for name, _, _ in takes))
    apart = _apart(takes, "upper", "paper")
    return Finding(
        figure="1 and 7",
        title="Gestures on different bodies",
        setting=f"{cast.source}, {motion.duration:.1f} s"
        f"{'' if cast.captured else ' (made, not captured)'}, by {len(bodies)} bodies. Stiffness "
        "3000 /s^2 times each joint's outboard inertia under both laws; damping 0.1 s of it under "
        "the paper's.",
        claims=(
            Claim(
                said="Tracking keeps the overall characteristics of the motion.",
                measured=f"height of the hand correlates with the actor's by {alike_paper:.3f} "
                f"(paper's law, at its lag) and {alike:.3f} (modern law) or more; joint angles off "
                f"by {error:.2f} degrees rms or less (modern), {without:.1f} without the lag "
                "(paper's)",
                holds=min(alike, alike_paper) > 0.9,
            ),
            Claim(
                said="It imposes the dynamics of the animated character.",
                measured=f"one motion takes peak torques of {min(torques):.0f} to "
                f"{max(torques):.0f} N m; under the paper's law it lags by {min(lag):.0f} to "
                f"{max(lag):.0f} ms, and arms of different bodies differ by {apart:.1f} degrees",
                holds=max(torques) > 1.5 * min(torques) and apart > 0.1,
            ),
            Claim(
                said="One capture drives bodies with different dynamics.",
                measured=f"all {len(rows)} runs of {', '.join(b.replace('_', ' ') for b in bodies)}"
                f" are within {max(column(5, 'paper')):.1f} degrees rms",
                holds=max(column(5, "paper")) < 20.0,
            ),
        ),
        charts=(_chart(takes, motion, bodies), _laws(takes, motion, bodies[0])),
        strips=(_strip(takes, motion, bodies, cast),),
        sheets=(
            Sheet(
                name="Figures 1 and 7",
                caption="Errors against the clip on each body's own skeleton.",
                head=(
                    "body",
                    "plan",
                    "law",
                    "height [m]",
                    "mass [kg]",
                    "joint error, rms [deg]",
                    "lag [ms]",
                    "error without lag [deg]",
                    "likeness of hand height",
                    "peak torque [N m]",
                    "root force, mean [% of weight]",
                ),
                rows=tuple(rows),
                notes=(
                    "Upper body: the pelvis is led along its path and there are no legs, as in the "
                    "paper's gestures.",
                ),
            ),
        ),
        facts={"likeness_min": min(alike, alike_paper), "joint_error_modern_max_deg": error},
    )


def _chart(takes: Mapping[tuple[str, str, str], Take], motion: Clip, bodies: list[str]) -> Chart:
    series = [Series(name="actor", x=motion.times, y=raised(motion))]
    for name in bodies:
        clip = takes[name, "upper", "modern"].clip()
        series.append(Series(name=name.replace("_", " "), x=clip.times, y=raised(clip)))
    return Chart(
        title="Figures 1 and 7: height of the right hand over its shoulder",
        caption="In lengths of each one's arm; upper bodies, modern law.",
        x_label="Time [s]",
        y_label="Height [arm lengths]",
        series=tuple(series),
        decimals=2,
    )


def _laws(takes: Mapping[tuple[str, str, str], Take], motion: Clip, name: str) -> Chart:
    series = [Series(name="actor", x=motion.times, y=raised(motion))]
    for law in LAWS:
        clip = takes[name, "upper", law].clip()
        series.append(Series(name=LAW_NAMES[law], x=clip.times, y=raised(clip)))
    return Chart(
        title=f"The same by the {name.replace('_', ' ')} under both laws",
        caption="The paper's law lags by its damping over stiffness, a tenth of a second.",
        x_label="Time [s]",
        y_label="Height [arm lengths]",
        series=tuple(series),
        decimals=2,
    )


def _strip(
    takes: Mapping[tuple[str, str, str], Take], motion: Clip, bodies: list[str], cast: Cast
) -> Strip:
    times = spread(0.12 * motion.duration, 0.9 * motion.duration, 6)
    films = [Film(title=f"the actor's skeleton: {cast.source}", thing=motion, times=times)]
    films += [
        Film(title=name.replace("_", " "), thing=takes[name, _SHOWN, "modern"], times=times)
        for name in bodies
    ]
    films.append(
        Film(
            title=f"{bodies[0].replace('_', ' ')}, upper body alone, the paper's law",
            thing=takes[bodies[0], "upper", "paper"],
            times=times,
        )
    )
    return Strip(
        alt="The actor's skeleton and four bodies make the same gesture.",
        films=tuple(films),
        scale="one",
    )
