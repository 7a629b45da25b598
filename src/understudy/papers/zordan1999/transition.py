"""Figure 5: from patty-cake to a slap."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from understudy.character import retargeted
from understudy.control import Tracking
from understudy.evaluate.chart import Chart, Series
from understudy.evaluate.events import ContactEvent, contact_events
from understudy.motion.clip import Clip
from understudy.motion.reaching import HandTarget, Meet, meeting, reach
from understudy.motion.rotations import Array
from understudy.motion.samples import sample
from understudy.motion.samples.partner import CLAPS, SLAP, boundaries, clap_times
from understudy.papers.filmstrip import Film
from understudy.papers.finding import Claim, Finding, Strip
from understudy.papers.sheets import Sheet
from understudy.papers.zordan1999.cast import paper_child
from understudy.papers.zordan1999.finding import LAW_NAMES, hand_of, hand_path, speed_of
from understudy.papers.zordan1999.patty_cake import APART, PAIRS, touching
from understudy.performance import together, tracked
from understudy.simulate import simulate
from understudy.take import Take

# The children stand this near [m]: the slapping arm is short.
DISTANCE = 0.50
# The blend begins at the third clap with the partner, and the slap's wind-up is this far on [s].
START, BLEND, INTO = clap_times()[2] + 0.06, 0.45, 0.35
MET = START + SLAP - INTO
# Middle of the partner's cheek in the frame of its head, in statures of the body.
CHEEK = (0.030, 0.050, 0.070)
# The middle of the hand aims at this far inside the cheek's surface [m].
THROUGH = 0.012


@dataclass(frozen=True, kw_only=True)
class Motions:
    """The motions of the child that slaps, on one timeline, and its partner's.

    Attributes:
        before: Patty-cake alone, motion a.
        after: The slap alone, as the splice places it, motion b; it begins at `START`.
        blend: Both, joined: what is tracked.
        partner: Who is slapped.
    """

    before: Clip = field(repr=False)
    after: Clip = field(repr=False)
    blend: Clip = field(repr=False)
    partner: Clip = field(repr=False)


def motions() -> Motions:
    """Make them: claps met by offsets, then the splice, then the hand brought to the cheek."""
    body = paper_child()
    clap, slap = (retargeted(sample(name), body) for name in ("patty_cake", "slap"))
    a = clap.placed(at=(0.0, 0.0))
    # The partner stops at the end of the third segment, own hands together.
    b = clap.placed(at=(DISTANCE, 0.0), heading=np.pi).trimmed(0.0, boundaries()[3])
    meets = [
        Meet(time=time, hands=pair, apart=APART)
        for time, kind in zip(clap_times()[:3], CLAPS, strict=False)
        for pair in PAIRS[kind]
    ]
    a, b = meeting(a, b, meets)
    joined = a.spliced(slap, at=START, blend=BLEND, start=INTO)
    # The same placement without the blend: the slap from the moment it could begin.
    alone = a.spliced(slap, at=START, blend=1.0 / a.rate, start=INTO)
    target = HandTarget(time=MET, joint="right_wrist", position=cheek(b), window=0.35)
    blend, _ = reach(joined, [target])
    after, _ = reach(alone, [target])
    return Motions(before=a, after=after, blend=blend, partner=b)


def cheek(partner: Clip) -> Array:
    """Where the hand's middle is to be when it slaps, world [m], (3,)."""
    from understudy.motion import rotations as rot

    pose, i = partner.forward_kinematics(), partner.skeleton.index("neck")
    stature = paper_child().height
    spot = np.array(CHEEK) * stature * [1.0, 1.0, 1.0]
    return pose.positions[-1, i] + rot.rotate(pose.rotations[-1, i], spot)


def slapping(*, quick: bool = False) -> Finding:
    """The transition under both laws, with the claps before it and the slap."""
    made = motions()
    laws = ("paper",) if quick else ("modern", "paper")
    takes = {law: played(made, law) for law in laws}
    return _finding(made, takes, {law: _slap(take) for law, take in takes.items()})


def played(made: Motions, law: str) -> Take:
    """Both children, whose hands touch, and the right hand and the partner's head."""
    body = paper_child()
    one, two = (tracked(clip, body, law=law) for clip in (made.blend, made.partner))
    return simulate(together(one, two, contacts=(*touching(), ("right_hand", "b/head"))))


def _slap(take: Take) -> ContactEvent | None:
    return next(iter(contact_events(take, "right_hand", "b/head")), None)


def _peak(path: Array, rate: float, first: float, last: float) -> float:
    """Greatest speed between two times [m/s]."""
    times = np.arange(len(path)) / rate
    return float(speed_of(path, rate)[(times >= first) & (times <= last)].max())


def _away(made: Motions, take: Take, time: float, *, lag: float = 0.0) -> float:
    """Distance of the simulated hand, so much later [s], from the desired at a time [mm]."""
    here = hand_of(take)[round((time + lag) * take.rate)]
    there = hand_path(made.blend)[round(time * made.blend.rate)]
    return 1e3 * float(np.linalg.norm(here - there))


def _lag(take: Take) -> float:
    """By how much the law lags, its damping over stiffness [s]; the modern one does not."""
    tracking = take.performance.controllers[0] if take.performance else None
    literal = isinstance(tracking, Tracking) and tracking.law == "paper"
    return tracking.kd_over_k if isinstance(tracking, Tracking) and literal else 0.0


def _rows(made: Motions, takes: dict[str, Take]) -> list[tuple[object, ...]]:
    end = START + BLEND
    rows: list[tuple[object, ...]] = []
    for name, clip, span in (
        ("patty-cake alone, a", made.before, (0.0, end)),
        ("slap alone, b", made.after, (START + 0.05, made.after.duration)),
        ("blend, desired", made.blend, (0.0, made.blend.duration)),
    ):
        path = hand_path(clip)
        inside = _peak(path, clip.rate, START, end) if "blend" in name else None
        rows.append((name, _peak(path, clip.rate, *span), inside, None, None, None, None))
    for law, take in takes.items():
        path = hand_of(take)
        rows.append(
            (
                f"simulated, {LAW_NAMES[law]}",
                _peak(path, take.rate, 0.0, take.duration),
                _peak(path, take.rate, START, end),
                *(_away(made, take, time) for time in (end, end + 0.15, end + 0.3)),
                _away(made, take, end + 0.15, lag=_lag(take)),
            )
        )
    return rows


def _finding(
    made: Motions, takes: dict[str, Take], slaps: dict[str, ContactEvent | None]
) -> Finding:
    rows = _rows(made, takes)
    limit = max(float(str(row[1])) for row in rows[:2])
    ratios = {str(row[0]): float(str(row[2])) / limit for row in rows[2:]}
    worst = max(ratios.values())
    late = {law: None if e is None else 1e3 * (e.start_s - MET) for law, e in slaps.items()}
    literal = rows[-1]
    told = "; ".join(
        f"{LAW_NAMES[law]}: "
        + (
            "missed"
            if e is None
            else f"{1e3 * (e.start_s - MET):+.0f} ms from its time, {e.impulse_ns:.2f} N s"
        )
        for law, e in slaps.items()
    )
    return Finding(
        figure="5",
        title="From patty-cake to a slap",
        setting=f"Two children of {paper_child().height:.2f} m, {DISTANCE:g} m apart. Equation 4 "
        f"from {START:.2f} to {START + BLEND:.2f} s, out of the third clap with the partner; the "
        f"hand is brought to the partner's cheek by an offset at {MET:.2f} s.",
        claims=(
            Claim(
                said="The blend of joint angles is continuous.",
                measured=f"greatest hand speed in the blend {ratios['blend, desired']:.2f} of the "
                "greatest of both motions (goal: 1.3)",
                holds=ratios["blend, desired"] <= 1.3,
            ),
            Claim(
                said="The simulation smooths the transition.",
                measured="; ".join(
                    f"{name.split(', ')[1]} {ratio:.2f}"
                    for name, ratio in ratios.items()
                    if "simulated" in name
                )
                + " of that speed (goal: 1.3)",
                holds=worst <= 1.3,
            ),
            Claim(
                said="It goes on changing the motion after the blend's end.",
                measured=f"{literal[0]}: hand {literal[3]:.0f} mm from the desired place at the "
                f"end, {literal[4]:.0f} mm after 0.15 s, {literal[5]:.0f} mm after 0.3 s "
                f"({literal[6]:.0f} mm after 0.15 s with its lag taken out)",
                holds=float(str(literal[6])) > 10.0,
            ),
            Claim(
                said="The child slaps its partner in the face.",
                measured=f"contact of hand and head: {told}",
                holds=all(e is not None for e in slaps.values()),
            ),
        ),
        charts=tuple(
            _chart(made, takes, k, name) for k, name in ((0, "forward"), (1, "to the left"))
        ),
        strips=(
            Strip(
                alt="Two children clap; then one slaps the other.",
                films=tuple(
                    Film(
                        title=LAW_NAMES[law],
                        thing=take,
                        times=(2.5, 3.0, 3.25, 3.5, 3.7, MET, MET + 0.12, MET + 0.4),
                        view="side",
                        heading=0.0,
                    )
                    for law, take in takes.items()
                ),
            ),
        ),
        sheets=(
            Sheet(
                name="Figure 5",
                caption="Speed of the slapping hand, and how far simulation and blend are apart.",
                head=(
                    "motion",
                    "peak speed [m/s]",
                    "peak in the blend [m/s]",
                    "apart at the end [mm]",
                    "0.15 s later",
                    "0.3 s later",
                    "0.15 s later, less lag",
                ),
                rows=tuple(rows),
            ),
        ),
        facts={"transition_speed_ratio": worst, "slap_late_ms": late},
    )


def _chart(made: Motions, takes: dict[str, Take], axis: int, name: str) -> Chart:
    first, last = START - 0.5, MET + 0.5
    curves: list[tuple[str, Array, Array]] = []
    for law, take in takes.items():
        curves.append((f"simulated, {LAW_NAMES[law]}", take.times, hand_of(take)))
    curves += [
        ("blend, desired", made.blend.times, hand_path(made.blend)),
        ("patty-cake, a", made.before.times, hand_path(made.before)),
        ("slap, b", made.after.times, hand_path(made.after)),
    ]
    series = []
    for label, times, path in curves:
        begin = START + 0.01 if label.startswith("slap") else first
        near = (times >= begin) & (times <= last)
        series.append(Series(name=label, x=times[near], y=100.0 * path[near, axis]))
    return Chart(
        title=f"Figure 5: the right hand, {name}",
        caption=f"The blend is from {START:.2f} to {START + BLEND:.2f} s; the slap is due at "
        f"{MET:.2f} s.",
        x_label="Time [s]",
        y_label=f"Position {name} [cm]",
        series=tuple(series),
    )
