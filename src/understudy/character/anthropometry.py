"""Masses, centers and inertias of human body segments for a given sex, mass and height.

Two published sets: de Leva (1996), which adjusts the gamma-ray data of Zatsiorsky and Seluyanov to
joint centers, and Dempster's cadaver data as tabulated by Winter (2009, table 4.1). Segments are
placed by anatomical landmarks of the neutral pose, so that a link's center of mass does not depend
on where a motion file happens to put its joints.

References:
    P. de Leva, Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, Journal of
        Biomechanics 29 (1996) 1223-1230.
    D. A. Winter, Biomechanics and Motor Control of Human Movement, 4th ed., Wiley 2009.
    R. Drillis, R. Contini, Body segment parameters, report 1166-03, New York University 1966.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from understudy.errors import InvalidValue
from understudy.motion.rotations import Array

Sex = Literal["female", "male"]
SegmentParameters = Literal["de_leva", "dempster"]

# Body-mass index of the default mass [kg/m2]: middle of the range the World Health Organization
# calls normal (18.5 to 25), close to de Leva's men (73.0 kg, 1.741 m: 24.1) and women (61.9 kg,
# 1.735 m: 20.6).
DEFAULT_BMI = 22.0

# Stature of the people measured [m] (de Leva 1996).
DE_LEVA_STATURE: dict[str, float] = {"female": 1.735, "male": 1.741}

# Foot length, width and ankle height over stature (Drillis and Contini 1966). The ankle at 0.25 and
# the ball at 0.70 of the foot's length from the heel are those of the standard figure.
FOOT_LENGTH = 0.152
FOOT_WIDTH = 0.055
ANKLE_HEIGHT = 0.039
ANKLE_POSITION = 0.25
BALL_POSITION = 0.70

# Bone lengths over stature (Drillis and Contini 1966).
LENGTHS: dict[str, float] = {
    "thigh": 0.245,
    "shank": 0.246,
    "upper_arm": 0.186,
    "forearm": 0.146,
    "hand": 0.108,
    "trunk": 0.288,
}

# Density of each segment [kg/m3]: Dempster 1955 as tabulated by Winter (2009, table 4.1).
DENSITY: dict[str, float] = {
    "pelvis": 1010.0,
    "abdomen": 1010.0,
    "chest": 920.0,
    "head": 1110.0,
    "upper_arm": 1070.0,
    "forearm": 1130.0,
    "hand": 1160.0,
    "thigh": 1050.0,
    "shank": 1090.0,
    "foot": 1100.0,
    "toes": 1100.0,
}


@dataclass(frozen=True, kw_only=True)
class Segment:
    """One segment relative to its own length, which runs from its first landmark to its second.

    Attributes:
        mass: Fraction of body mass.
        com: Distance of the center of mass from the first landmark, fraction of length.
        radii: Radii of gyration through the center of mass, fraction of length: about the
            sagittal axis (front to back), the transverse axis (side to side), the long axis.
            A zero long radius is replaced by that of a solid cylinder of the segment's density.
        length: Length of the people measured [m]; zero where the source gives none.
    """

    mass: float
    com: float
    radii: tuple[float, float, float]
    length: float = 0.0


def _segments(rows: str) -> dict[str, Segment]:
    """Parse rows of: name, mass %, com %, three radii %, length in millimeters."""
    out = {}
    for row in rows.split("\n"):
        name, *numbers = row.split()
        mass, com, sagittal, transverse, long, length = (float(n) for n in numbers)
        radii = (sagittal / 100, transverse / 100, long / 100)
        out[name] = Segment(mass=mass / 100, com=com / 100, radii=radii, length=length / 1000)
    return out


# de Leva 1996, table 4. Landmarks: head vertex to C7; chest C7 to xiphoid; abdomen xiphoid to
# navel; pelvis navel to mid-hip; limbs joint center to joint center; hand wrist to third knuckle;
# foot heel to toe tip.
DE_LEVA: dict[str, dict[str, Segment]] = {
    "female": _segments(
        """head 6.68 48.41 27.1 29.5 26.1 243.7
chest 15.45 50.50 46.6 31.4 44.9 228.0
abdomen 14.65 45.12 43.3 35.4 41.5 205.3
pelvis 12.47 49.20 43.3 40.2 44.4 181.5
upper_arm 2.55 57.54 27.8 26.0 14.8 275.1
forearm 1.38 45.59 26.1 25.7 9.4 264.3
hand 0.56 74.74 53.1 45.4 33.5 78.0
thigh 14.78 36.12 36.9 36.4 16.2 368.5
shank 4.81 43.52 26.7 26.3 9.2 438.6
foot 1.29 40.14 29.9 27.9 13.9 228.3"""
    ),
    "male": _segments(
        """head 6.94 50.02 30.3 31.5 26.1 242.9
chest 15.96 50.66 50.5 32.0 46.5 242.1
abdomen 16.33 45.02 48.2 38.3 46.8 215.5
pelvis 11.17 61.15 61.5 55.1 58.7 145.7
upper_arm 2.71 57.72 28.5 26.9 15.8 281.7
forearm 1.62 45.74 27.6 26.5 12.1 268.9
hand 0.61 79.00 62.8 51.3 40.1 86.2
thigh 14.16 40.95 32.9 32.9 14.9 422.2
shank 4.33 43.95 25.1 24.6 10.2 440.3
foot 1.37 44.15 25.7 24.5 12.4 258.1"""
    ),
}

# Winter 2009, table 4.1 (Dempster), both sexes alike. The trunk's mass is listed as thorax, abdomen
# and pelvis; the radii of the three are those of solid cylinders of their length (the table gives
# none), a zero long radius likewise. The head is listed from C7 to the ear canal with its center at
# the latter, here as half the way from vertex to C7. The foot is listed from ankle to ball (0.48 of
# its length), center half way, radius 0.475 of that; here as fractions of heel to toe tip.
_DEMPSTER_ROWS = """head 8.1 50.0 24.8 24.8 0 243.0
chest 21.6 50.0 0 0 0 242.1
abdomen 13.9 50.0 0 0 0 215.5
pelvis 14.2 50.0 0 0 0 145.7
upper_arm 2.8 43.6 32.2 32.2 0 0
forearm 1.6 43.0 30.3 30.3 0 0
hand 0.6 50.6 29.7 29.7 0 0
thigh 10.0 43.3 32.3 32.3 0 0
shank 4.65 43.3 30.2 30.2 0 0
foot 1.45 47.5 22.8 22.8 0 0"""
DEMPSTER: dict[str, dict[str, Segment]] = {
    sex: _segments(_DEMPSTER_ROWS) for sex in ("female", "male")
}

TRUNK = ("pelvis", "abdomen", "chest")
PAIRED = ("upper_arm", "forearm", "hand", "thigh", "shank", "foot")


@dataclass(frozen=True, kw_only=True)
class MassProperties:
    """Mass [kg], center of mass [m], shape (3,), and inertia about it [kg m2], shape (3, 3)."""

    mass: float
    com: Array
    inertia: Array

    def about(self, point: Array) -> Array:
        """Inertia about another point [kg m2], shape (3, 3) (parallel axes)."""
        d = self.com - point
        return self.inertia + self.mass * (d @ d * np.eye(3) - np.outer(d, d))


def combined(parts: list[MassProperties]) -> MassProperties:
    """Several bodies fixed to each other, all given in one frame."""
    mass = sum(p.mass for p in parts)
    if mass <= 0:
        return MassProperties(mass=0.0, com=np.zeros(3), inertia=np.zeros((3, 3)))
    com = sum((p.mass * p.com for p in parts), np.zeros(3)) / mass
    inertia = sum((p.about(com) for p in parts), np.zeros((3, 3)))
    return MassProperties(mass=mass, com=com, inertia=inertia)


def segments(parameters: SegmentParameters, sex: Sex) -> dict[str, Segment]:
    """The table of segments for a sex ("female" or "male").

    Raises:
        InvalidValue: Another sex or another table.
    """
    tables = {"de_leva": DE_LEVA, "dempster": DEMPSTER}
    if parameters not in tables:
        raise InvalidValue(
            f"segment_parameters is {parameters!r}; it must be 'de_leva' or 'dempster'."
        )
    if sex not in tables[parameters]:
        raise InvalidValue(f"sex is {sex!r}; it must be 'female' or 'male'.")
    table = tables[parameters][sex]
    # The women's fractions add up to 0.9999 as printed.
    total = sum(s.mass * (2 if name in PAIRED else 1) for name, s in table.items())
    return {name: replace(s, mass=s.mass / total) for name, s in table.items()}


def with_head(table: dict[str, Segment], size: float) -> dict[str, Segment]:
    """The table with a head of another size: mass by the cube, the rest shares the remainder."""
    head = table["head"]
    mass = head.mass * size**3
    left = (1.0 - mass) / (1.0 - head.mass)
    out = {name: replace(s, mass=s.mass * left) for name, s in table.items()}
    return out | {"head": replace(head, mass=mass)}


def default_mass(height: float) -> float:
    """Body mass [kg] at `DEFAULT_BMI` for a height [m]."""
    return DEFAULT_BMI * height**2


def segment_properties(
    name: str, start: Array, end: Array, *, table: dict[str, Segment], mass: float
) -> MassProperties:
    """One segment between two points of the neutral pose, x forward, y left, z up.

    Args:
        name: Row of the table.
        start: First landmark [m], shape (3,).
        end: Second landmark [m], shape (3,).
        table: From `segments`.
        mass: Body mass [kg].
    """
    segment = table[name]
    length = float(np.linalg.norm(end - start))
    own = segment.mass * mass
    axes = _segment_axes(name, (end - start) / length)
    sagittal, transverse, long = _radii(segment, name, own, length)
    moments = own * np.array([sagittal, transverse, long]) ** 2
    return MassProperties(
        mass=own,
        com=start + segment.com * (end - start),
        inertia=axes.T @ np.diag(moments) @ axes,
    )


def foot_and_toes(
    heel: Array, tip: Array, *, table: dict[str, Segment], mass: float
) -> tuple[MassProperties, MassProperties]:
    """The foot split at the ball into two bodies whose sum is the table's foot.

    The share and the centers are those of a wedge that tapers towards the toes at the rate that
    puts its center where the table has the foot's. The inertia left after the distance of the two
    centers is shared by mass, so mass, center and inertia of the pair are exactly the table's.
    """
    whole = segment_properties("foot", heel, tip, table=table, mass=mass)
    c, b = table["foot"].com, BALL_POSITION
    taper = (0.5 - c) / (1 / 3 - c / 2)
    volume = 1 - taper / 2
    share = ((1 - b) - taper * (1 - b * b) / 2) / volume
    toe_center = ((1 - b * b) / 2 - taper * (1 - b**3) / 3) / (volume * share)
    length = float(np.linalg.norm(tip - heel))
    # No more apart than leaves each part a slenderness of its own (a tenth of the length).
    along = (tip - heel) / length
    variance = (np.trace(whole.inertia) / 2 - along @ whole.inertia @ along) / whole.mass
    apart = (toe_center - c) / (1 - share) * length
    limit = np.sqrt(max(variance - (0.1 * length) ** 2, 0.0) / (share * (1 - share)))
    apart = min(apart, float(limit))
    shift = apart * along
    left = whole.inertia - whole.mass * share * (1 - share) * (
        shift @ shift * np.eye(3) - np.outer(shift, shift)
    )
    foot = MassProperties(
        mass=whole.mass * (1 - share), com=whole.com - share * shift, inertia=(1 - share) * left
    )
    toes = MassProperties(
        mass=whole.mass * share, com=whole.com + (1 - share) * shift, inertia=share * left
    )
    return foot, toes


def trunk_points(sex: Sex, bottom: Array, top: Array) -> dict[str, tuple[Array, Array]]:
    """First and second landmark of pelvis, abdomen and chest on the line from mid-hip to C7.

    The levels of navel and xiphoid divide the line as in de Leva's table.
    """
    lengths = [segments("de_leva", sex)[name].length for name in TRUNK]
    levels = np.concatenate(([0.0], np.cumsum(lengths))) / sum(lengths)
    at = [bottom + level * (top - bottom) for level in levels]
    return {name: (at[i + 1], at[i]) for i, name in enumerate(TRUNK)}


def _radii(segment: Segment, name: str, mass: float, length: float) -> Array:
    """Radii of gyration [m] about sagittal, transverse and long axis."""
    radii = np.array(segment.radii) * length
    if segment.radii[2] == 0:
        radius2 = mass / (DENSITY[name] * np.pi * length)
        radii[2] = np.sqrt(radius2 / 2)
        if segment.radii[0] == 0:
            radii[:2] = np.sqrt(radius2 / 4 + length**2 / 12)
    return radii


def _segment_axes(name: str, along: Array) -> Array:
    """Rows: sagittal, transverse and long axis of a segment lying along a direction."""
    # An arm held out in the T-pose has turned about the sagittal axis, so that its transverse axis
    # is vertical; a foot lies forward, so that its sagittal axis is vertical.
    hints = [np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])]
    if name == "foot":
        hints.reverse()
    sagittal = max(hints, key=lambda h: np.sqrt(1 - min(1.0, (h @ along) ** 2)) > 0.1)
    sagittal = sagittal - along * (sagittal @ along)
    sagittal /= np.linalg.norm(sagittal)
    return np.stack([sagittal, np.cross(along, sagittal), along])
