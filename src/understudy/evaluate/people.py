"""How people run, from published measurements, at any speed of distance running.

In comes a speed, out goes one `People`: mean angle curves over the cycle and single figures with
their range and source, under the names that `understudy.evaluate.gait` uses. Each source is marked:
read in the paper itself, read in open data or pages that attribute the numbers to it, or computed
from such numbers (how is said). Angles are those of segments: thigh and shank along the bones from
the vertical, the foot from flat, the pelvis from standing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from understudy.errors import InvalidValue
from understudy.motion.rotations import Array

MEASURED = (2.5, 3.5, 4.5)
"""Speeds of the tables [m/s]."""
USABLE = (1.5, 6.0)
"""Speeds to ask for [m/s]; outside the tables by up to 0.5 they go on in a straight line, and
beyond that they stay."""
BEYOND = 0.5

_FUKUCHI = (
    "Fukuchi, Fukuchi & Duarte 2017 (PeerJ 5: e3298), 28 runners on a treadmill at 2.5, 3.5 and "
    "4.5 m/s"
)
_READ = "read in the paper"
_OPEN = "from open data that attribute it to the paper"
_MADE = "computed"

# Fukuchi et al. 2017, means of 28 runners and both legs, at 0, 5, ... 95 % of the cycle, degrees,
# at 2.5, 3.5 and 4.5 m/s: thigh forward of the vertical, knee flexion, foot toe up, pelvis anterior
# tilt over standing.
_THIGH = (
    [17, 19, 21, 17, 10, 1, -9, -16, -20, -19, -15, -8, 0, 10, 19, 26, 28, 26, 21, 17],
    [21, 22, 23, 16, 6, -6, -17, -25, -26, -23, -17, -9, 1, 14, 26, 33, 34, 32, 26, 22],
    [25, 25, 24, 16, 3, -11, -23, -30, -30, -26, -19, -10, 4, 19, 32, 39, 41, 38, 33, 27],
)
_KNEE = (
    [9, 21, 36, 42, 40, 32, 22, 15, 15, 24, 41, 60, 76, 87, 90, 82, 67, 46, 24, 9],
    [10, 23, 39, 43, 38, 28, 17, 11, 18, 35, 56, 76, 94, 104, 103, 92, 73, 50, 25, 10],
    [12, 24, 40, 43, 37, 26, 13, 11, 25, 45, 67, 88, 107, 116, 113, 99, 78, 54, 29, 13],
)
_FOOT = (
    [11, 2, 0, -1, -3, -9, -20, -36, -50, -63, -73, -82, -86, -82, -71, -54, -36, -17, 1, 12],
    [14, 2, -1, -2, -6, -17, -36, -55, -69, -79, -92, -103, -105, -97, -80, -60, -38, -16, 4, 15],
    [15, 2, -1, -3, -9, -25, -48, -68, -80, -94, -109, -118, -118, -105, -85, -62, -38, -15, 6, 18],
)
_TILT = (
    [6, 3, 1, 2, 2, 3, 5, 6, 8, 8, 6, 3, 1, 2, 2, 3, 5, 6, 8, 8],
    [6, 3, 3, 4, 5, 6, 7, 9, 10, 9, 6, 3, 3, 4, 5, 6, 7, 9, 10, 9],
    [6, 4, 4, 5, 6, 6, 8, 10, 11, 9, 6, 4, 4, 5, 6, 6, 8, 10, 11, 9],
)
# Standard deviation between runners [deg], middle of the ranges of the joint angles of 31 of them
# at 2.5 m/s: hip 5, knee 5 to 9, ankle 3 to 7.
_SD = {"hip": 5.0, "thigh": 5.0, "knee": 7.0, "ankle": 5.0}
_SD_NOTE = "standard deviation from the joint angles of 31 runners at 2.5 m/s"

# The same 28 runners: share of the cycle on the ground (force above 20 N), its standard deviation,
# steps per minute, step width [m] and its standard deviation.
_DUTY, _DUTY_SD = (0.385, 0.337, 0.322), (0.033, 0.023, 0.023)
_STEPS = (161.0, 171.0, 183.0)
_WIDTH, _WIDTH_SD = (0.10, 0.09, 0.08), 0.02
# At the events of the 1 % curves, degrees.
_EVENTS = {
    "knee_stance_peak_deg": ((42.0, 43.0, 43.0), "knee"),
    "knee_swing_peak_deg": ((90.0, 105.0, 117.0), "knee"),
    "knee_toe_off_deg": ((14.0, 11.0, 10.0), "knee"),
    "thigh_toe_off_deg": ((-19.0, -23.0, -27.0), "thigh"),
    "thigh_forward_peak_deg": ((28.0, 34.0, 41.0), "thigh"),
    "thigh_back_peak_deg": ((-20.0, -26.0, -31.0), "thigh"),
}


@dataclass(frozen=True, kw_only=True)
class Human:
    """One published figure.

    Attributes:
        mean: Mean over people.
        low: Lower end of the usual range; None where no spread is published.
        high: Upper end.
        source: Who measured it on whom, and what was computed.
        known: "read in the paper", "from open data ...", or "computed".
        at_speed: The speed it was measured at [m/s], where it is known at one only.
    """

    mean: float
    low: float | None = None
    high: float | None = None
    source: str
    known: str
    at_speed: float | None = None

    def holds(self, value: float) -> bool | None:
        """Whether a value lies in the range; None without a range."""
        if self.low is None or self.high is None:
            return None
        return self.low <= value <= self.high


@dataclass(frozen=True, kw_only=True)
class People:
    """How people run at one speed.

    Attributes:
        speed: The speed the values are for [m/s].
        asked: The speed that was asked for [m/s].
        figures: By name of the gait's figures.
        curves: Angles over the cycle at 0, 1, ... 100 % [rad], shape (101,), by name.
        curve_source: Of the curves.
    """

    speed: float
    asked: float
    figures: dict[str, Human] = field(repr=False)
    curves: dict[str, Array] = field(repr=False)
    curve_source: str = field(repr=False)

    @property
    def extrapolated(self) -> bool:
        """Whether the speed lies outside the measured ones."""
        return not MEASURED[0] <= self.asked <= MEASURED[-1]

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes; curves in degrees."""
        return {
            "speed_m_s": self.speed,
            "asked_m_s": self.asked,
            "extrapolated": self.extrapolated,
            "figures": {
                name: {
                    "mean": h.mean,
                    "low": h.low,
                    "high": h.high,
                    "source": h.source,
                    "known": h.known,
                    "at_speed_m_s": h.at_speed,
                }
                for name, h in self.figures.items()
            },
            "curves_deg": {
                name: np.degrees(curve).round(2).tolist() for name, curve in self.curves.items()
            },
            "curve_source": self.curve_source,
        }


def people(speed: float) -> People:
    """How people run at a speed, interpolated between the measured ones.

    Args:
        speed: [m/s]; 2.5 to 4.5 is measured. From 2 to 5 the tables go on in a straight line, and
            further out the values of 2 and 5 stand.

    Raises:
        InvalidValue: Slower or faster than distance running.
    """
    low, high = USABLE
    if not low <= speed <= high:
        raise InvalidValue(
            f"speed is {speed} m/s; people's running is known from {low:g} to {high:g}."
        )
    used = float(np.clip(speed, MEASURED[0] - BEYOND, MEASURED[-1] + BEYOND))
    curves = _curves(used)
    return People(
        speed=used,
        asked=float(speed),
        figures={**_timing(used), **_angles(used, curves), **_single(), **_forces(used)},
        curves=curves,
        curve_source=f"{_FUKUCHI}, means of both legs; hip = thigh + pelvis tilt, ankle = foot - "
        f"thigh + knee; {_OPEN}",
    )


def _over_speed(values: Any, speed: float) -> Any:
    """Interpolated between the measured speeds; rows of `values` go with `MEASURED`."""
    rows = np.asarray(values, float)
    k = 0 if speed < MEASURED[1] else 1
    share = (speed - MEASURED[k]) / (MEASURED[k + 1] - MEASURED[k])
    return rows[k] + share * (rows[k + 1] - rows[k])


def _curves(speed: float) -> dict[str, Array]:
    """Angle curves at 0, 1, ... 100 % [rad]."""
    thigh, knee, foot, tilt = (
        _smooth(_over_speed(table, speed)) for table in (_THIGH, _KNEE, _FOOT, _TILT)
    )
    return {
        "hip": thigh + tilt,
        "thigh": thigh,
        "knee": knee,
        "ankle": foot - thigh + knee,
        "foot": foot,
        "pelvis": tilt,
    }


def _smooth(values: Array) -> Array:
    """A periodic cubic spline through 20 values [deg], at 101 shares of the cycle [rad]."""
    loop = np.radians(np.append(values, values[0]))
    return CubicSpline(np.linspace(0.0, 1.0, 21), loop, bc_type="periodic")(np.arange(101) / 100.0)


def _spread(mean: float, sd: float, source: str, known: str, at: float | None = None) -> Human:
    """A figure with the range of two standard deviations, in which 95 % of people lie."""
    return Human(
        mean=float(mean),
        low=float(mean - 2.0 * sd),
        high=float(mean + 2.0 * sd),
        source=source,
        known=known,
        at_speed=at,
    )


def _timing(speed: float) -> dict[str, Human]:
    duty, sd = float(_over_speed(_DUTY, speed)), float(_over_speed(_DUTY_SD, speed))
    rate = float(_over_speed(_STEPS, speed)) / 60.0
    stride = 2.0 / rate
    made = f"{_FUKUCHI}: from duty factor and stride time"
    return {
        "duty": _spread(duty, sd, f"{_FUKUCHI}, force above 20 N", _OPEN),
        "stance_s": _spread(duty * stride, sd * stride, made, _MADE),
        "flight_s": _spread((0.5 - duty) * stride, sd * stride, made, _MADE),
        "step_rate_hz": Human(mean=rate, source=made, known=_MADE),
        "step_length_m": Human(mean=speed / rate, source=made, known=_MADE),
        "step_width_m": _spread(_over_speed(_WIDTH, speed), _WIDTH_SD, _FUKUCHI, _OPEN),
    }


def _angles(speed: float, curves: dict[str, Array]) -> dict[str, Human]:
    source = f"{_FUKUCHI}; {_SD_NOTE}"
    out = {
        name: _spread(_over_speed(values, speed), _SD[curve], source, _MADE)
        for name, (values, curve) in _EVENTS.items()
    }
    toe_off = 100.0 * float(_over_speed(_DUTY, speed))
    ankle, share = np.degrees(curves["ankle"]), np.arange(101)
    off = -float(np.interp(toe_off, share, ankle))
    peak = float(ankle[share <= toe_off].max())
    knee, foot = (float(np.degrees(curves[name][0])) for name in ("knee", "foot"))
    return {
        "knee_touchdown_deg": _spread(knee, _SD["knee"], source, _OPEN),
        "foot_touchdown_deg": Human(mean=foot, source=_FUKUCHI, known=_OPEN),
        **out,
        "plantarflexion_toe_off_deg": _spread(
            off, _SD["ankle"], f"{source}; foot - thigh + knee at the end of stance", _MADE
        ),
        "ankle_stance_peak_deg": _spread(
            peak, _SD["ankle"], f"{source}; largest foot - thigh + knee in stance", _MADE
        ),
    }


def _single() -> dict[str, Human]:
    """Figures known at one speed only."""
    bramah = "Bramah et al. 2018 (Am J Sports Med 46: 3023), 36 healthy runners at 3.2 m/s"
    return {
        "com_rise_m": _spread(
            0.077, 0.012, "Malisoux et al. 2023, 860 runners at 2.75 m/s", _OPEN, 2.75
        ),
        "trunk_touchdown_deg": _spread(3.9, 2.9, bramah, _READ, 3.2),
        "trunk_stance_peak_deg": _spread(9.5, 2.9, bramah, _READ, 3.2),
    }


def _forces(speed: float) -> dict[str, Human]:
    mean = 0.5 / float(_over_speed(_DUTY, speed))
    keller = "Keller et al. 1996 (Clin Biomech 11: 253), 13 men and 10 women"
    return {
        "force_mean_bw": Human(
            mean=mean, source=f"{_FUKUCHI}: 0.5 over the duty factor", known=_MADE
        ),
        "force_active_bw": Human(
            mean=0.5 * np.pi * mean,
            source=f"{_FUKUCHI}: a half sine with the mean force 0.5 over the duty factor",
            known=_MADE,
        ),
        "force_peak_bw": Human(
            # 1.2 BW at 1.5 m/s, rising linearly to about 2.5 BW at 6 m/s.
            mean=1.2 + 1.3 * (speed - 1.5) / 4.5,
            source=f"{keller}: straight line from 1.2 BW at 1.5 m/s (walking) to 2.5 BW at 6 m/s; "
            "slow jogging lies above it",
            known=_READ,
        ),
        "loading_rate_bw_s": Human(mean=19.0, low=8.0, high=30.0, source=keller, known=_READ),
    }
