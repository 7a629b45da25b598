"""Mass, center of mass and inertia of each link of a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from understudy.character import anthropometry as human
from understudy.character.anthropometry import MassProperties, Segment, combined
from understudy.character.body import Shape
from understudy.errors import InvalidValue
from understudy.motion.figure import PARENTS
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.character.build import Figure

_UP = np.array([0.0, 0.0, 1.0])


def link_properties(figure: Figure, table: dict[str, Segment]) -> dict[str, MassProperties]:
    """Published segments placed in the neutral T-pose and shared out to the links, by role.

    A segment whose own joint is missing rides on the link inboard of it; an arm or leg that is
    missing altogether has no mass.
    """
    parts: dict[str, list[MassProperties]] = {role: [] for role in figure.positions}

    def give(role: str, part: MassProperties) -> None:
        while role not in parts:
            role = PARENTS[role]
        parts[role].append(part)

    bottom, top = trunk_line(figure)
    trunk = human.trunk_points(figure.sex, bottom, top)
    for name, role in (("pelvis", "pelvis"), ("abdomen", "lower_back"), ("chest", "upper_back")):
        # A back of one joint is rigid from the navel up: the abdomen goes with the chest.
        carrier = "upper_back" if role == "lower_back" and "lower_back" not in parts else role
        give(carrier, _segment(figure, table, name, *trunk[name]))
    give("neck", _segment(figure, table, "head", top + head_length(figure) * _UP, top))
    for side in ("left", "right"):
        for name, role, start, end in limb_points(figure, side):
            give(role, _segment(figure, table, name, start, end))
        if f"{side}_ankle" in parts:
            for role, part in zip(
                (f"{side}_ankle", f"{side}_ball"), _foot(figure, table, side, parts), strict=True
            ):
                if part is not None:
                    give(role, part)
    return {role: _in_link(combined(own), figure.positions[role]) for role, own in parts.items()}


def head_length(figure: Figure) -> float:
    """From C7 to the vertex [m]."""
    length = human.DE_LEVA[figure.sex]["head"].length / human.DE_LEVA_STATURE[figure.sex]
    return length * figure.height * figure.head


def trunk_line(figure: Figure) -> tuple[Array, Array]:
    """Mid-hip and C7 in the neutral T-pose [m]."""
    at, height = figure.positions, figure.height
    if "left_hip" in at and "right_hip" in at:
        bottom = 0.5 * (at["left_hip"] + at["right_hip"])
    else:
        bottom = at["pelvis"] - 0.02 * height * _UP
    # C7 lies 0.030 of stature above the shoulder centers of the standard figure.
    if "left_shoulder" in at and "right_shoulder" in at:
        top = 0.5 * (at["left_shoulder"] + at["right_shoulder"]) + 0.03 * height * _UP
    elif "neck" in at:
        top = at["neck"]
    else:
        top = bottom + (human.LENGTHS["trunk"] + 0.03) * height * _UP
    if np.linalg.norm(top - bottom) < 0.1 * height:
        top = bottom + (human.LENGTHS["trunk"] + 0.03) * height * _UP
    return bottom, top


def limb_points(figure: Figure, side: str) -> list[tuple[str, str, Array, Array]]:
    """Segment, role of its link, first and second landmark [m] of one arm and one leg."""
    at = figure.positions
    out = []
    lateral = np.array([0.0, 1.0 if side == "left" else -1.0, 0.0])
    for chain, way in (
        ((("upper_arm", "shoulder"), ("forearm", "elbow"), ("hand", "wrist")), lateral),
        ((("thigh", "hip"), ("shank", "knee")), -_UP),
    ):
        start = at.get(f"{side}_{chain[0][1]}")
        if start is None:
            continue
        for k, (segment, kind) in enumerate(chain):
            following = chain[k + 1][1] if k + 1 < len(chain) else "ankle"
            end = at.get(f"{side}_{following}") if segment != "hand" else None
            if end is None:
                end = start + way * _length(figure, segment)
            out.append((segment, f"{side}_{kind}", start, end))
            start = end
    return out


def _length(figure: Figure, segment: str) -> float:
    """Length [m] of a segment the skeleton does not show, from stature."""
    if segment == "hand":  # wrist to third knuckle
        hand = human.DE_LEVA[figure.sex]["hand"].length
        return hand / human.DE_LEVA_STATURE[figure.sex] * figure.height
    return human.LENGTHS[segment] * figure.height


def foot_points(figure: Figure, side: str) -> tuple[Array, Array]:
    """Heel and toe tip in the neutral T-pose [m], half way up to the ankle."""
    at, length = figure.positions, human.FOOT_LENGTH * figure.height
    ankle = at[f"{side}_ankle"]
    ahead = (human.BALL_POSITION - human.ANKLE_POSITION) * length
    ball = at.get(f"{side}_ball")
    if ball is not None:
        ahead = max(float(ball[0] - ankle[0]), 0.3 * ahead)
    middle = 0.5 * figure.sole_height
    heel = ankle + np.array([-human.ANKLE_POSITION * length, 0.0, middle])
    tip = ankle + np.array([ahead + (1 - human.BALL_POSITION) * length, 0.0, middle])
    return heel, tip


def _foot(
    figure: Figure, table: dict[str, Segment], side: str, parts: dict[str, list[MassProperties]]
) -> tuple[MassProperties, MassProperties | None]:
    heel, tip = foot_points(figure, side)
    if f"{side}_ball" in parts:
        return human.foot_and_toes(heel, tip, table=table, mass=figure.mass)
    return _segment(figure, table, "foot", heel, tip), None


def _segment(
    figure: Figure, table: dict[str, Segment], name: str, start: Array, end: Array
) -> MassProperties:
    return human.segment_properties(name, start, end, table=table, mass=figure.mass)


def _in_link(part: MassProperties, origin: Array) -> MassProperties:
    return MassProperties(mass=part.mass, com=part.com - origin, inertia=part.inertia)


def measured_properties(
    shapes: dict[str, tuple[Shape, ...]], *, total: float | None = None
) -> dict[str, MassProperties]:
    """Mass properties of solids, as MuJoCo integrates them, by the same keys.

    Args:
        shapes: Shapes per link; those of zero density count for nothing.
        total: When given, all masses and inertias are scaled to add up to this [kg].

    Raises:
        InvalidValue: More solids, or stranger ones, than the engine builds.
    """
    import mujoco

    from understudy.character.model import add_shape

    spec = mujoco.MjSpec()
    names = list(shapes)
    for k, name in enumerate(names):
        body = spec.worldbody.add_body(name=f"b{k}")
        body.add_freejoint()
        for n, shape in enumerate(shapes[name]):
            if shape.density > 0:
                add_shape(spec, body, f"g{k}_{n}", shape)
    try:
        model = spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise InvalidValue(
            f"The engine cannot build this body of {len(names)} links ({str(error).strip()}). "
            "Drop joints with a mapping (--mapping)."
        ) from None
    scale = 1.0 if total is None else total / float(model.body_mass[1:].sum())
    out = {}
    for k, name in enumerate(names, 1):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.body_iquat[k])
        axes = turn.reshape(3, 3)
        inertia = axes @ np.diag(model.body_inertia[k]) @ axes.T
        out[name] = MassProperties(
            mass=float(model.body_mass[k]) * scale,
            com=np.array(model.body_ipos[k]),
            inertia=0.5 * (inertia + inertia.T) * scale,
        )
    return out
