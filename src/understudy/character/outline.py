"""What a person's links look like, and what of them touches.

Each link of a person is one rounded, tapering solid drawn through cross-sections. Lengths follow
the bones; girths follow stature. Widths over hips and shoulders come from the joints themselves.
The remaining girths are our own drawing after adult proportions, scaled to stature.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from understudy.character import anthropometry as human
from understudy.character.body import Shape
from understudy.character.masses import foot_points, head_length, limb_points, trunk_line
from understudy.character.solids import Section, capsule, loft
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.character.build import Figure

_X, _Y, _Z = np.eye(3)
SKIN = (0.82, 0.67, 0.56, 1.0)
HAIR = (0.26, 0.20, 0.17, 1.0)
SHIRT = (0.25, 0.42, 0.60, 1.0)
TROUSERS = (0.22, 0.25, 0.32, 1.0)
# Radius of the contact spheres of a sole, part of stature (2 cm for an adult).
SOLE_RADIUS = 0.011
SHOE = (0.13, 0.13, 0.15, 1.0)

# Half axes over stature at fractions of the bone: (fraction, across, deep). Across is side to side
# for the legs, front to back for arms held out.
_LIMBS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "thigh": ((0.0, 0.048, 0.053), (0.35, 0.044, 0.049), (0.75, 0.034, 0.037), (1.0, 0.030, 0.033)),
    "shank": ((0.0, 0.029, 0.031), (0.28, 0.032, 0.034), (0.65, 0.023, 0.025), (1.0, 0.018, 0.021)),
    "upper_arm": ((0.0, 0.030, 0.030), (0.30, 0.028, 0.028), (1.0, 0.021, 0.022)),
    "forearm": ((0.0, 0.022, 0.022), (0.25, 0.024, 0.023), (1.0, 0.016, 0.013)),
}
_COLORS = {"thigh": TROUSERS, "shank": TROUSERS, "upper_arm": SHIRT, "forearm": SKIN}
_DEEPEST = {"female": 0.94, "male": 1.0}


def dressed(figure: Figure) -> dict[str, tuple[Shape, ...]]:
    """Shapes of every link, in link frames, by role."""
    shapes: dict[str, list[Shape]] = {role: [] for role in figure.positions}
    _trunk(figure, shapes)
    _head(figure, shapes)
    for side in ("left", "right"):
        for name, role, start, end in limb_points(figure, side):
            if name == "hand":
                _hand(figure, shapes, side, role, start)
            else:
                _limb(figure, shapes, name, role, start, end)
        if f"{side}_ankle" in shapes:
            _foot(figure, shapes, side)
    return {role: tuple(own) for role, own in shapes.items()}


def _solid(
    name: str, sections: list[Section], origin: Array, rgba: tuple, *, across: Array, **ends
) -> Shape:
    vertices, faces = loft(sections, across=across, **ends)
    return Shape(
        kind="mesh",
        vertices=vertices - origin,
        faces=faces,
        density=human.DENSITY[name],
        rgba=rgba,
    )


def _carrier(shapes: dict[str, list[Shape]], role: str) -> str:
    from understudy.motion.figure import PARENTS

    while role not in shapes:
        role = PARENTS[role]
    return role


def _trunk(figure: Figure, shapes: dict[str, list[Shape]]) -> None:
    """Pelvis, abdomen and chest from the crotch to the shoulders."""
    at, h = figure.positions, figure.height
    bottom, top = trunk_line(figure)
    levels = human.trunk_points(figure.sex, bottom, top)
    hips = _half_width(at, "hip", 0.049 * h) + 0.043 * h
    shoulders = _half_width(at, "shoulder", 0.104 * h)
    woman = figure.sex == "female"
    waist, ribs = (0.069, 0.074) if woman else (0.077, 0.083)
    depth = _DEEPEST[figure.sex]

    def along(level: float) -> Array:
        return bottom + level * (top - bottom)

    xiphoid = _level(levels["abdomen"][0], bottom, top)
    navel = _level(levels["pelvis"][0], bottom, top)

    def piece(name: str, role: str, rows: list, rgba: tuple, domes: tuple) -> None:
        carrier = _carrier(shapes, role)
        sections = [Section(along(t), a, d * depth) for t, a, d in rows]
        origin = at[carrier]
        shapes[carrier].append(
            _solid(
                name,
                sections,
                origin,
                rgba,
                across=_Y,
                start_dome=domes[0] * h,
                end_dome=domes[1] * h,
                roundness=2.5,
            )
        )
        low, high = along(rows[0][0]), along(rows[-1][0])
        radius = 0.5 * (rows[0][2] + rows[-1][2])
        middle = 0.5 * (low + high) - origin
        half = max(0.4 * (rows[0][1] + rows[-1][1]) - radius, 1e-3)
        shapes[carrier].append(
            capsule(middle - half * _Y, middle + half * _Y, radius, use="collision", rgba=rgba)
        )

    piece(
        "pelvis",
        "pelvis",
        [
            (-0.05, 0.70 * hips, 0.055 * h),
            (0.05, hips, 0.066 * h),
            (navel, (waist + 0.004) * h, 0.058 * h),
        ],
        TROUSERS,
        (0.030, 0.025),
    )
    piece(
        "abdomen",
        "lower_back" if "lower_back" in shapes else "upper_back",
        [
            (navel - 0.03, waist * h, 0.056 * h),
            (0.5 * (navel + xiphoid), waist * h, 0.056 * h),
            (xiphoid, ribs * h, 0.060 * h),
        ],
        SHIRT,
        (0.030, 0.030),
    )
    # Shoulders as wide as their joints; a narrow skeleton still has ribs.
    yoke = max(shoulders, 0.9 * ribs * h)
    piece(
        "chest",
        "upper_back",
        [
            (xiphoid - 0.05, ribs * h * 0.97, 0.060 * h),
            (0.5 * (xiphoid + 0.85), 0.5 * (ribs * h + 0.9 * yoke) + 0.004 * h, 0.067 * h),
            (0.87, 0.93 * yoke, 0.057 * h),
            (0.93, 0.90 * yoke, 0.042 * h),
            (0.975, 0.58 * yoke, 0.033 * h),
            (1.01, 0.036 * h, 0.030 * h),
        ],
        SHIRT,
        (0.030, 0.004),
    )


def _half_width(at: dict[str, Array], joint: str, default: float) -> float:
    if f"left_{joint}" not in at or f"right_{joint}" not in at:
        return default
    return 0.5 * float(np.linalg.norm(at[f"left_{joint}"] - at[f"right_{joint}"]))


def _level(point: Array, bottom: Array, top: Array) -> float:
    way = top - bottom
    return float((point - bottom) @ way / (way @ way))


def _head(figure: Figure, shapes: dict[str, list[Shape]]) -> None:
    """Neck, skull with a jaw, hair, and eyes and a nose to see where it looks."""
    h = figure.height * figure.head
    _, top = trunk_line(figure)
    carrier = _carrier(shapes, "neck")
    origin = figure.positions[carrier]
    vertex = top[2] + head_length(figure)

    def at(z: float, x: float = 0.0) -> Array:
        return np.array([top[0] + x * h, top[1], vertex - z * h])

    skull = [
        Section(at(0.128, 0.020), 0.020 * h, 0.024 * h),
        Section(at(0.112, 0.016), 0.033 * h, 0.037 * h),
        Section(at(0.080, 0.010), 0.042 * h, 0.050 * h),
        Section(at(0.045, 0.006), 0.045 * h, 0.056 * h),
        Section(at(0.020, 0.002), 0.037 * h, 0.047 * h),
    ]
    neck = [
        Section(at(0.150, -0.006), 0.034 * h, 0.033 * h),
        Section(at(0.085, 0.006), 0.031 * h, 0.032 * h),
    ]
    solid = _solid("head", skull, origin, SKIN, across=_Y, start_dome=0.008 * h, end_dome=0.019 * h)
    shapes[carrier].append(solid)
    stem = _solid("head", neck, origin, SKIN, across=_Y, start_dome=0.012 * h, end_dome=0.0)
    # Within the skull the neck would count twice.
    shapes[carrier].append(Shape(kind="mesh", vertices=stem.vertices, faces=stem.faces, rgba=SKIN))
    cap = [
        Section(at(0.088, -0.030), 0.036 * h, 0.026 * h),
        Section(at(0.062, -0.016), 0.0455 * h, 0.043 * h),
        Section(at(0.036, -0.004), 0.0480 * h, 0.0545 * h),
        Section(at(0.020, -0.001), 0.0420 * h, 0.0510 * h),
    ]
    hair = _solid("head", cap, origin, HAIR, across=_Y, start_dome=0.010 * h, end_dome=0.026 * h)
    shapes[carrier].append(Shape(kind="mesh", vertices=hair.vertices, faces=hair.faces, rgba=HAIR))
    for y in (-0.019, 0.019):
        eye = at(0.066, 0.0545) - origin + y * h * _Y
        shapes[carrier].append(
            Shape(kind="sphere", position=eye, size=np.array([0.0055 * h, 0, 0]), rgba=HAIR)
        )
    nose = at(0.082, 0.060) - origin
    shapes[carrier].append(
        Shape(
            kind="ellipsoid",
            position=nose,
            size=np.array([0.010, 0.007, 0.013]) * h,
            rgba=SKIN,
        )
    )
    shapes[carrier].append(
        capsule(at(0.095, 0.012) - origin, at(0.055, 0.004) - origin, 0.048 * h, use="collision")
    )


def _limb(
    figure: Figure, shapes: dict[str, list[Shape]], name: str, role: str, start: Array, end: Array
) -> None:
    h = figure.height
    carrier = _carrier(shapes, role)
    origin = figure.positions[carrier]
    slim = 0.94 if figure.sex == "female" else 1.0
    rows = _LIMBS[name]
    sections = [Section(start + t * (end - start), slim * a * h, slim * d * h) for t, a, d in rows]
    across = _Y if name in ("thigh", "shank") else _X
    shapes[carrier].append(
        _solid(
            name,
            sections,
            origin,
            _COLORS[name],
            across=across,
            start_dome=0.9 * sections[0].across,
            end_dome=0.9 * sections[-1].across,
        )
    )
    radius = 0.5 * (sections[0].across + sections[-1].across)
    shapes[carrier].append(
        capsule(start - origin, end - origin, radius, use="collision", rgba=_COLORS[name])
    )


def _hand(
    figure: Figure, shapes: dict[str, list[Shape]], side: str, role: str, start: Array
) -> None:
    """Palm, fingers and thumb of a hand held out flat, palm down."""
    h = figure.height
    carrier = _carrier(shapes, role)
    origin = figure.positions[carrier]
    sign = 1.0 if side == "left" else -1.0
    length = human.LENGTHS["hand"] * h
    out = sign * _Y
    rows = ((0.02, 0.016, 0.012), (0.30, 0.023, 0.012), (0.50, 0.023, 0.010), (0.92, 0.017, 0.006))
    sections = [Section(start + t * length * out, a * h, d * h) for t, a, d in rows]
    shapes[carrier].append(
        _solid(
            "hand",
            sections,
            origin,
            SKIN,
            across=_X,
            start_dome=0.008 * h,
            end_dome=0.008 * h,
            roundness=2.6,
        )
    )
    root = start + 0.10 * length * out + 0.012 * h * _X - origin
    tip = start + 0.46 * length * out + 0.033 * h * _X - 0.004 * h * _Z - origin
    shapes[carrier].append(capsule(root, tip, 0.0075 * h, rgba=SKIN))
    near, far = start + 0.15 * length * out - origin, start + 0.85 * length * out - origin
    shapes[carrier].append(capsule(near, far, 0.012 * h, use="contact", rgba=SKIN))
    shapes[carrier].append(capsule(near, far, 0.016 * h, use="collision", rgba=SKIN))


def _foot(figure: Figure, shapes: dict[str, list[Shape]], side: str) -> None:
    """A shoe with a flat sole: heel and arch on the foot, the tip on the toes."""
    h = figure.height
    ankle_role, ball_role = f"{side}_ankle", f"{side}_ball"
    ankle = figure.positions[ankle_role]
    heel, tip = foot_points(figure, side)
    sole = ankle[2] + figure.sole_height
    top = ankle[2] + 0.012 * h
    length = tip[0] - heel[0]
    ball_x = figure.positions[ball_role][0] if ball_role in shapes else heel[0] + 0.70 * length
    wide, y = 0.5 * human.FOOT_WIDTH * h, ankle[1]

    def section(x: float, across: float, height: float) -> Section:
        # The loft's second half axis is vertical; the floor cuts the lower half off.
        return Section(np.array([x, y, sole + 0.35 * height]), across, 0.65 * height)

    ball_height = 0.50 * (top - sole)
    hind = [
        section(heel[0] + 0.07 * length, 0.62 * wide, 0.80 * (top - sole)),
        section(ankle[0], 0.72 * wide, 1.05 * (top - sole)),
        section(0.5 * (ankle[0] + ball_x), 0.85 * wide, 0.80 * (top - sole)),
        section(ball_x, wide, ball_height),
    ]
    fore = [
        section(ball_x, wide, ball_height),
        section(0.45 * ball_x + 0.55 * tip[0], 0.92 * wide, 0.40 * (top - sole)),
        section(tip[0] - 0.06 * length, 0.62 * wide, 0.30 * (top - sole)),
    ]
    thick = 0.5 * (ankle[2] - sole)

    # Spheres roll over heel and toes where a box would pivot on its edges.
    radius = SOLE_RADIUS * figure.height

    def sole_spheres(x: float, origin: Array) -> list[Shape]:
        centers = [np.array([x, y + side, sole + radius]) for side in (0.6 * wide, -0.6 * wide)]
        return [capsule(c - origin, c - origin, radius, use="contact", rgba=SHOE) for c in centers]

    parts = [("foot", ankle_role, hind, 0.07 * length, 0.4 * ball_height)]
    if ball_role in shapes:
        parts.append(("toes", ball_role, fore, 0.4 * ball_height, 0.06 * length))
    else:
        parts[0] = ("foot", ankle_role, [*hind, *fore[1:]], 0.07 * length, 0.06 * length)
    for name, role, sections, first, last in parts:
        origin = figure.positions[role]
        shapes[role].append(
            _solid(
                name,
                sections,
                origin,
                SHOE,
                across=_Y,
                start_dome=first,
                end_dome=last,
                roundness=2.6,
                floor=sole,
            )
        )
    origin = figure.positions[ankle_role]
    shapes[ankle_role] += sole_spheres(heel[0] + radius, origin)
    shapes[ankle_role] += sole_spheres(ball_x, origin)
    if ball_role in shapes:
        shapes[ball_role] += sole_spheres(tip[0] - radius, figure.positions[ball_role])
    else:
        shapes[ankle_role] += sole_spheres(tip[0] - radius, origin)
    low = np.array([ankle[0], y, sole + thick]) - origin
    high = np.array([ball_x, y, sole + 0.8 * thick]) - origin
    shapes[ankle_role].append(capsule(low, high, 0.8 * thick, use="collision", rgba=SHOE))
