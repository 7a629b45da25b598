"""A walk on the standard figure, from published normative gait curves.

The pelvis, hip, knee and ankle curves of Pinzone, Schwartz, Thomason & Baker (2014, Gait & Posture
40: 286) give every segment's attitude over the stride. The stance foot rolls over its heel, stands
flat, and rolls over its ball and toes without sliding; the pelvis path follows from it; both legs
are then closed onto their feet exactly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import ROLES, figure
from understudy.motion.keyframes import rotation
from understudy.motion.limbs import place_foot
from understudy.motion.rotations import Array

# Pinzone et al. 2014, mean of two gait services, self-selected speed, degrees at 0, 5, ... 95 % of
# the stride that begins with this leg's heel strike.
_OBLIQUITY = [1.4, 2.6, 4.2, 4.7, 3.8, 2.0, 0.4, -0.4, -0.6, -0.8]
_OBLIQUITY += [-1.4, -2.6, -4.1, -4.7, -3.8, -2.1, -0.5, 0.3, 0.6, 0.8]
_TURN = [5.5, 4.9, 4.1, 3.8, 3.2, 2.0, 0.4, -1.5, -3.4, -5.0]
_TURN += [-5.7, -5.2, -4.5, -4.3, -3.6, -2.3, -0.6, 1.4, 3.4, 5.0]
_TILT = [12.5, 12.0, 11.3, 11.1, 11.5, 12.0, 12.2, 12.5, 12.8, 12.8]
_TILT += [12.5, 11.9, 11.2, 11.0, 11.3, 11.8, 12.1, 12.5, 12.8, 12.8]
_HIP = [36.6, 35.9, 33.0, 27.8, 21.9, 16.1, 10.5, 5.3, 0.6, -3.5]
_HIP += [-6.0, -5.1, 0.5, 10.2, 20.3, 28.3, 33.8, 36.7, 37.3, 36.5]
_KNEE = [6.1, 13.8, 19.4, 19.0, 16.0, 12.6, 9.5, 7.1, 6.0, 7.4]
_KNEE += [12.4, 22.4, 37.3, 52.7, 61.0, 58.9, 48.9, 33.2, 16.1, 5.0]
_ANKLE = [-2.3, -5.3, -1.8, 2.6, 5.5, 7.4, 8.9, 10.3, 11.6, 12.3]
_ANKLE += [10.0, 0.0, -14.4, -16.8, -9.4, -2.8, 0.8, 1.6, 0.9, -0.1]

# A usual speed [m/s], at which Orendurff et al. 2004 measured the body to rise and fall by 40 to 48
# and to move sideways by 39 to 46 mm. For a person of 1.75 m; lengths scale with height.
_SPEED = 1.32
_RISE = 0.043
_SIDEWAYS = 0.021
# The pelvis is carried this much lower than the curves have it [m], so that no knee locks.
_SOFT_KNEES = 0.005
_PERSON = 1.75
# The phase at which the curves carry the toe tip off the floor, and how much of the stride the
# swing path takes to leave and to meet the floor's.
_TOE_OFF = 0.595
_BLEND = 0.08
# Urbanus et al. 2022: toe-out 5.2 +- 5.5 degrees. Donelan et al. 2001: step width .13 leg lengths.
_TOE_OUT = 5.2
_STEP_WIDTH = 0.13
# The swinging foot passes this much closer to the other leg, and its toes clear the floor [m].
_PASSING, _CLEARANCE = 0.015, 0.022


def _curve(values: list[float], phase: Array) -> Array:
    """A periodic curve [rad] through 20 values [deg] at equal steps, at stride phases in cycles.

    The Fourier series of the values (ten harmonics), which passes through them.
    """
    series = np.fft.rfft(np.radians(values)) / len(values)
    k = np.arange(len(series))
    weight = np.where((k == 0) | (k == len(series) - 1), 1.0, 2.0)
    return np.real(np.exp(2j * np.pi * np.outer(phase, k)) @ (weight * series))


def _ramp(x: Array, low: float, high: float) -> Array:
    """0 below `low`, 1 above `high`, smooth (twice differentiable) between."""
    s = np.clip((x - low) / (high - low), 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)


class _Foot:
    """How a foot carries over a stride, at the phases of a grid from its heel strike [cycles].

    In the foot's plane: x forward and z up [m]; pitch is toe up [rad].
    """

    def __init__(self, height: float, phase: Array):
        # Of the standard figure: ball and toe tip from the ankle. The heel pad rolls about a center
        # behind the ankle that is as high as the ball.
        self.rise = 0.039 * height
        ball = np.array([0.45 * 0.152, 0.012 - 0.039]) * height
        heel = np.array([-0.19 * 0.152, 0.012 - 0.039]) * height
        tip = np.array([0.30 * 0.152, -0.002]) * height
        pitch = _leg_attitude(phase)[2]
        # Flat between 9 and 28 % of the stride, where the curves are within 2 degrees of it.
        self.pitch = pitch * (1.0 - _ramp(phase, 0.02, 0.10) * (1.0 - _ramp(phase, 0.26, 0.44)))
        up, down = np.maximum(self.pitch, 0.0), np.minimum(self.pitch, 0.0)
        # The toes stay flat while the ball bends by up to about 40 degrees, then roll over the tip;
        # in swing they straighten.
        most = np.radians(40.0)
        bend = most * np.tanh(-down / most)
        self.bend = bend * (1.0 - _ramp(phase, _TOE_OFF, 0.85)) * (1.0 - _ramp(phase, 0.85, 0.95))
        on_heel = heel - _pitched(heel, up)
        on_toes = ball + tip - _pitched(tip, down + bend) - _pitched(ball, down)
        # Ankle [m] from where the flat foot has it, shape (phases, 2). Each pivot stays where the
        # flat foot puts it, so nothing slides.
        self.ankle = np.where(self.pitch[:, None] > 0.0, on_heel, on_toes)


def _leg_attitude(phase: Array) -> tuple[Array, Array, Array]:
    """Thigh and shank forward of the vertical, and the foot's pitch, toe up [rad]."""
    thigh = _curve(_HIP, phase) - _curve(_TILT, phase)
    shank = thigh - _curve(_KNEE, phase)
    return thigh, shank, shank + _curve(_ANKLE, phase)


def _pitched(point: Array, pitch: Array) -> Array:
    """A point (x, z) of a part pitched toe up, shape (phases, 2)."""
    c, s = np.cos(pitch), np.sin(pitch)
    return np.stack((c * point[0] - s * point[1], s * point[0] + c * point[1]), axis=-1)


class _Stride:
    """One leg's stride and the pelvis over it, as periodic splines of the phase [cycles].

    `length` is the stride [m] and `time` its duration [s]. Paths are relative to a point that moves
    at the mean speed.
    """

    def __init__(self, height: float):
        skeleton = figure(height)
        thigh_length = -skeleton.offsets[skeleton.index("left_knee")][2]
        shank_length = -skeleton.offsets[skeleton.index("left_ankle")][2]
        hip = skeleton.offsets[skeleton.index("left_hip")]
        # A grid beyond both ends, so that derivatives there need no wrapping.
        n = 600
        phase = np.arange(-20, n + 21) / n
        thigh, shank, _ = _leg_attitude(phase)
        leg = np.stack(
            (
                thigh_length * np.sin(thigh) + shank_length * np.sin(shank),
                -thigh_length * np.cos(thigh) - shank_length * np.cos(shank),
            ),
            axis=-1,
        )
        turn, up = _curve(_TURN, phase), _curve(_OBLIQUITY, phase)
        to_ankle = leg + np.stack((hip[1] * np.sin(turn), hip[2] + hip[1] * np.sin(up)), axis=-1)
        foot = _Foot(height, phase)
        planted = foot.ankle + np.array([0.0, foot.rise])
        scale = height / _PERSON
        self.length, pelvis = _pelvis_path(phase, planted - to_ankle)
        self.time = self.length / (_SPEED * np.sqrt(scale))
        top = pelvis[:, 1].max() - _SOFT_KNEES * scale
        below = pelvis[:, 1].max() - pelvis[:, 1]
        pelvis[:, 1] = top - below * _RISE * scale / below.max()
        half_step = 0.5 * _STEP_WIDTH * (thigh_length + shank_length)
        out = np.radians(_TOE_OUT)
        on_floor = np.stack(
            (planted[:, 0] * np.cos(out), half_step + planted[:, 0] * np.sin(out), planted[:, 1]),
            axis=-1,
        )
        passing = scale * _ramp(phase, 0.64, 0.80) * (1.0 - _ramp(phase, 0.80, 0.96))
        # The leg reaches forward a little bent, so that it need not lock to meet the floor.
        reach = 1.0 - 0.006 * _ramp(phase, 0.82, 0.92)
        x, z = (pelvis + to_ankle + (reach[:, None] - 1.0) * leg).T
        in_air = np.stack((x, half_step - _PASSING * passing, z + _CLEARANCE * passing), axis=-1)
        ankle = _landed(phase, on_floor, in_air, self.length)
        inside = slice(20, 20 + n + 1)
        moving = self.length * phase
        closed = {
            "ankle": ankle - moving[:, None] * np.array([1.0, 0.0, 0.0]),
            "pelvis": pelvis - moving[:, None] * np.array([1.0, 0.0]),
            "pitch": foot.pitch,
            "bend": foot.bend,
        }
        self._splines = {}
        for name, values in closed.items():
            loop = np.array(values[inside])
            loop[-1] = loop[0]
            self._splines[name] = CubicSpline(phase[inside], loop, bc_type="periodic")

    def __call__(self, name: str, phase: Array) -> Array:
        return self._splines[name](phase % 1.0)


def _pelvis_path(phase: Array, seen: Array) -> tuple[float, Any]:
    """Stride length [m] and pelvis path (phases, 2) that fit what the stance leg shows of it.

    Both legs do the same half a stride apart, so the path is steady motion plus harmonics of the
    step: least squares over stance, less heavily where the other leg also carries.
    """
    weight = _ramp(phase, -0.02, 0.13) * (1.0 - _ramp(phase, 0.48, 0.64))
    waves = [w(2.0 * np.pi * k * phase) for k in (2, 4) for w in (np.cos, np.sin)]
    basis = np.stack((np.ones_like(phase), phase, *waves), axis=-1)
    along = np.linalg.lstsq(basis * weight[:, None], seen[:, 0] * weight, rcond=None)[0]
    level = np.delete(basis, 1, axis=1)
    rise = np.linalg.lstsq(level * weight[:, None], seen[:, 1] * weight, rcond=None)[0]
    return float(along[1]), np.stack((basis @ along, level @ rise), axis=-1)


def _landed(phase: Array, on_floor: Array, in_air: Array, length: float) -> Array:
    """The ankle path: on the floor in stance, then through the air to the next stance.

    The swing is the pelvis-borne path, bent near both ends so that position, velocity and
    acceleration meet the floor's at toe-off and at heel strike.
    """
    step = phase[1] - phase[0]
    start, lift, land = (int(np.searchsorted(phase, p - 1e-9)) for p in (0.0, _TOE_OFF, 1.0))
    next_floor = on_floor[start - 1 : start + 2] + np.array([length, 0.0, 0.0])
    path = np.array(in_air)
    for at, floor, away in ((lift, on_floor[lift - 1 : lift + 2], 1.0), (land, next_floor, -1.0)):
        gap = floor - in_air[at - 1 : at + 2]
        slope, curvature = (gap[2] - gap[0]) / (2 * step), (gap[2] - 2 * gap[1] + gap[0]) / step**2
        s = np.clip(away * (phase - phase[at]) / _BLEND, 0.0, 1.0)[:, None]
        path += _faded(s, gap[1], away * slope * _BLEND, curvature * _BLEND**2)
    path[:lift] = on_floor[:lift]
    path[land:] = on_floor[start : start + len(path) - land]
    path[land:, 0] += length
    path[:start] = path[land - start : land]
    path[:start, 0] -= length
    return path


def _faded(s: Array, value: Array, slope: Array, curvature: Array) -> Array:
    """The quintic over s in [0, 1] that starts with these and ends at rest at zero."""
    rest = (1.0 - s) ** 3
    return rest * (
        value * (1.0 + 3.0 * s + 6.0 * s * s)
        + slope * s * (1.0 + 3.0 * s)
        + 0.5 * curvature * s * s
    )


def walk(duration: float = 5.0, rate: float = 120.0, height: float = 1.75) -> Clip:
    """Level walking at a natural cadence along +x, in full stride from the first frame.

    Args:
        duration: [s].
        rate: Frames per second [Hz].
        height: Stature [m].
    """
    skeleton, stride = figure(height), _Stride(height)
    frames = round(duration * rate) + 1
    # Begins in the middle of left single support.
    phase = np.arange(frames) / rate / stride.time + 0.3
    turn, up = _curve(_TURN, phase), _curve(_OBLIQUITY, phase)
    forward = _curve(_TILT, phase) - np.radians(np.mean(_TILT))
    turned = rot.identity(frames, len(ROLES))
    # The striking side turned forward is the pelvis turned to the other side.
    turned[:, 0] = rot.from_euler("ZYX", np.stack((-turn, forward, up), axis=-1))
    pelvis = stride("pelvis", phase)
    sway = _SIDEWAYS * height / _PERSON * np.sin(2.0 * np.pi * (phase - 0.06))
    root = np.stack((phase * stride.length + pelvis[:, 0], sway, pelvis[:, 1]), axis=-1)
    for side, sign, shift in (("left", 1.0, 0.0), ("right", -1.0, 0.5)):
        ankle = stride("ankle", phase + shift) * np.array([1.0, sign, 1.0])
        ankle[:, 0] += phase * stride.length
        pitch, bend = stride("pitch", phase + shift), stride("bend", phase + shift)
        yaw = sign * np.radians(_TOE_OUT)
        foot = rot.from_euler("ZY", np.stack((np.full(frames, yaw), -pitch), axis=-1))
        place_foot(turned, skeleton, side, root, ankle, foot)
        turned[:, skeleton.index(f"{side}_ball")] = rot.from_euler("Y", -bend[:, None])
    for joint, angles in _upper_body(phase, turn, up, forward).items():
        turned[:, skeleton.index(joint)] = rotation(joint, angles)
    return Clip(
        skeleton=skeleton,
        rotations=turned,
        root_positions=root - np.array([root[0, 0], 0.0, 0.0]),
        rate=rate,
        name="walk",
        synthetic=True,
        notes=(
            "Made from the normative gait curves of Pinzone et al. 2014; not captured.",
            f"Walks at {stride.length / stride.time:.2f} m/s, strides of {stride.length:.2f} m.",
        ),
    )


def _upper_body(
    phase: Array, turn: Array, up: Array, forward: Array
) -> dict[str, dict[str, Array]]:
    """Angles [deg] of trunk, head and arms over the left leg's stride.

    The chest turns against the pelvis, the head looks ahead, and each arm swings with the other
    side's leg: about 30 degrees at the shoulder (Perry & Burnfield 2010), bending more in front.
    """
    turn, up, forward = np.degrees(turn), np.degrees(up), np.degrees(forward)
    steps = np.cos(4.0 * np.pi * (phase - 0.06))
    angles = {
        "lower_back": {"turn": 0.6 * turn, "bend": 0.6 * up, "flexion": 2.0 - 0.5 * forward},
        "upper_back": {"turn": 0.9 * turn, "bend": 0.5 * up, "flexion": 2.0 + 0.8 * steps},
        "neck": {"turn": -0.4 * turn, "bend": -0.1 * up, "flexion": -2.5 - 0.6 * steps},
    }
    for side, shift in (("left", 0.0), ("right", 0.5)):
        swing = -np.cos(2.0 * np.pi * (phase + shift - 0.02))
        later = -np.cos(2.0 * np.pi * (phase + shift - 0.08))
        second = np.cos(4.0 * np.pi * (phase + shift - 0.02))
        angles[f"{side}_shoulder"] = {
            "flexion": -4.0 + 15.0 * swing + 1.0 * second,
            "abduction": 7.0 + 0.8 * later,
            "rotation": 6.0 + 5.0 * swing,
        }
        angles[f"{side}_elbow"] = {
            "flexion": 23.0 + 11.0 * later + 2.0 * second,
            "pronation": 18.0 + 6.0 * swing,
        }
        angles[f"{side}_wrist"] = {"flexion": 5.0 - 4.0 * later, "deviation": 2.0 * swing}
    return angles
