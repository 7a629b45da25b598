"""The plots of a take: tracking error, hand speed, what holds the body, ground force, torque."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from understudy.evaluate import compare, feet
from understudy.evaluate.chart import STROKES, Bars, Chart, Series
from understudy.evaluate.events import ContactEvent, contact_force
from understudy.evaluate.force_plate import as_by_plate
from understudy.evaluate.measure import Measured
from understudy.evaluate.score import motion
from understudy.motion.clip import Clip
from understudy.motion.figure import plain_name
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take

_TIME = "Time [s]"


def joint_error(take: Take, m: Measured, character: int = 0) -> Chart | None:
    """Angle between simulated and reference joints over time; None without a reference."""
    reference = take.references[character]
    if reference is None:
        return None
    found = compare.compared(motion(take, m, character), reference)
    angles = np.degrees(found.joint_angles)
    lines = []
    if angles.shape[1]:
        worst = int(np.argmax(np.mean(angles**2, axis=0)))
        name = m.performer(character).joints[1 + worst]
        lines = [
            Series(name="all joints (rms)", x=found.times, y=np.sqrt(np.mean(angles**2, axis=1))),
            Series(name=f"{plain_name(name)} (largest)", x=found.times, y=angles[:, worst]),
        ]
    lines.append(Series(name="root", x=found.times, y=np.degrees(found.root_angles)))
    return Chart(
        title="Joint error",
        caption="Angle between simulated and tracked joint rotations, over all joints and for the "
        "joint that is furthest off; the root's orientation in the world.",
        x_label=_TIME,
        y_label="Error [deg]",
        series=tuple(lines),
        decimals=2,
    )


def hand_speed(take: Take, m: Measured, character: int = 0) -> tuple[Chart, ...]:
    """Speed of each hand in the clip as it was read, in the reference and as simulated.

    The comparison of Zordan & Hodgins 1999, figure 6: captured (made, where the clip was made) is
    the hand's joint in the clip as it was read; the reference, the paper's kinematic motion, is the
    prepared clip played back on the character; simulated is the take.
    """
    who = m.performer(character)
    charts = []
    reference, captured = take.references[character], take.captured[character]
    read = "made" if captured is not None and captured.synthetic else "captured"
    for side in ("left", "right"):
        role = f"{side}_wrist"
        link = next((k for k, x in enumerate(who.character.links) if x.role == role), None)
        if link is None:
            continue
        lines = [
            Series(
                name="simulated", x=m.times, y=_speed(m.body_positions[:, who.bodies[link]], m.rate)
            )
        ]
        if reference is not None:
            path = reference.forward_kinematics().positions[:, link]
            lines.append(_upto(take, "reference", reference, path))
        joint = getattr(who.character.links[link], "origin_joint", None)
        if captured is not None and joint in captured.skeleton.names:
            path = captured.forward_kinematics().positions[:, captured.skeleton.index(joint)]
            lines.append(_upto(take, read, captured, path))
        charts.append(
            Chart(
                title=f"{side.capitalize()} hand speed",
                caption=f"Speed of the wrist in the world: {read} (the clip as read), reference "
                "(the prepared clip on the character) and simulated; compare Zordan & Hodgins "
                "1999, figure 6.",
                x_label=_TIME,
                y_label="Speed [m/s]",
                series=tuple(lines),
                decimals=2,
            )
        )
    return tuple(charts)


def _upto(take: Take, name: str, clip: Clip, path: Array) -> Series:
    """Speed along a clip's path, no longer than the take."""
    keep = clip.times <= take.duration + 0.5 / clip.rate
    return Series(name=name, x=clip.times[keep], y=_speed(path, clip.rate)[keep])


def _speed(path: Array, rate: float) -> Array:
    """Speed along a path [m/s], shape (frames,); central differences."""
    if len(path) < 2:
        return np.zeros(len(path))
    return np.linalg.norm(np.gradient(path, 1.0 / rate, axis=0), axis=-1)


def root_assistance(take: Take, m: Measured, character: int = 0) -> Chart:
    """Outside force and torque on the root over time."""
    who = m.performer(character)
    force = 100.0 * m.root_force(character) / who.weight
    torque = 100.0 * m.root_torque(character) / (who.weight * who.height)
    return Chart(
        title="What holds the root",
        caption="Outside force on the root in % of body weight (BW), its upward part, and outside "
        "torque in % of body weight times height. Zero is fully physical.",
        x_label=_TIME,
        y_label="Force [% BW], torque [% BW x height]",
        series=(
            Series(name="force", x=m.times, y=np.linalg.norm(force, axis=1)),
            Series(name="upward part", x=m.times, y=force[:, 2]),
            Series(name="torque", x=m.times, y=np.linalg.norm(torque, axis=1)),
        ),
    )


def ground_reaction(take: Take, m: Measured, character: int = 0) -> Chart | None:
    """Upward ground force over time, per foot where there are feet; None without ground."""
    if take.scene.ground is None:
        return None
    who = m.performer(character)
    total = as_by_plate(m.ground_reaction(character)[:, 2] / who.weight, m.rate)
    lines = [
        Series(
            name=f"{side} foot",
            x=m.times,
            y=as_by_plate(m.ground_reaction(character, links=bodies)[:, 2] / who.weight, m.rate),
        )
        for side, bodies in feet.feet(who).items()
    ]
    rest = total - sum((line.y for line in lines), np.zeros(m.frames))
    if not lines or np.abs(rest).max(initial=0.0) > 1e-3:
        lines.append(Series(name="elsewhere" if lines else "body", x=m.times, y=rest))
    return Chart(
        title="Ground reaction",
        caption="Upward force of the ground in body weights, filtered as a force plate's. A "
        "standing body has 1 in all.",
        x_label=_TIME,
        y_label="Force [body weights]",
        series=tuple(lines),
        decimals=2,
    )


def contact_timeline(m: Measured, events: Sequence[ContactEvent]) -> Chart | None:
    """Force between the pairs of some events over time; None without events.

    As many pairs as lines can be told apart, those of the largest impulse.
    """
    total: dict[tuple[str, str], float] = {}
    for event in events:
        total[event.between] = total.get(event.between, 0.0) + event.impulse_ns
    pairs = sorted(total, key=lambda pair: -total[pair])[: len(STROKES)]
    if not pairs:
        return None
    return Chart(
        title="Contact forces",
        caption="Size of the force between two things that touch"
        + ("." if len(pairs) == len(total) else f", for {len(pairs)} of {len(total)} pairs."),
        x_label=_TIME,
        y_label="Force [N]",
        series=tuple(
            Series(
                name=" - ".join(plain_name(name) for name in pair),
                x=m.times,
                y=np.linalg.norm(contact_force(m, *pair), axis=1),
            )
            for pair in pairs
        ),
        decimals=0,
    )


def joint_torques(take: Take, m: Measured, character: int = 0) -> Bars | None:
    """Peak torque of every joint, with the human limit where the character has one."""
    who = m.performer(character)
    vectors = m.joint_torques(character)
    if vectors.shape[1] == 0:
        return None
    limits = [
        np.nan if link.torque_limit is None else float(np.max(link.torque_limit))
        for link in who.character.links[1:]
    ]
    return Bars(
        title="Peak joint torque",
        caption="Largest torque each joint gave.",
        label="Torque [N m]",
        names=who.joints[1:],
        values=np.linalg.norm(vectors, axis=2).max(axis=0),
        marks=np.array(limits),
        mark_name="strength of a person about the joint's strongest axis",
    )


def against_stiffness(
    stiffness: Array, error: Array, torque: Array, *, label: str = "Stiffness [1/s^2]"
) -> tuple[Chart, Chart]:
    """Joint error and peak torque against stiffness, on a logarithmic axis.

    Args:
        stiffness: Values tried, shape (trials,); sorted here.
        error: Joint error of each [deg], shape (trials,).
        torque: Peak joint torque of each [N m], shape (trials,).
        label: Name of the horizontal axis.
    """
    order = np.argsort(stiffness)
    x = np.asarray(stiffness, float)[order]

    def chart(title: str, caption: str, y_label: str, values: Array) -> Chart:
        line = Series(name=title.lower(), x=x, y=np.asarray(values, float)[order])
        return Chart(
            title=title,
            caption=caption,
            x_label=label,
            y_label=y_label,
            series=(line,),
            x_scale="log",
        )

    return (
        chart(
            "Joint error",
            "Stiffer servos follow more closely, down to the floor set by their lag.",
            "Error [deg rms]",
            error,
        ),
        chart("Peak torque", "What that stiffness costs.", "Torque [N m]", torque),
    )


def all_charts(take: Take, m: Measured, character: int = 0) -> tuple[Chart | Bars, ...]:
    """Every plot that exists for this take, in reading order."""
    found = (
        joint_error(take, m, character),
        root_assistance(take, m, character),
        ground_reaction(take, m, character),
        *hand_speed(take, m, character),
        joint_torques(take, m, character),
    )
    return tuple(chart for chart in found if chart is not None)
