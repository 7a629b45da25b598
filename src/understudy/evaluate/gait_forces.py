"""The force of the ground under one foot from touchdown to toe-off, in body weights.

Peaks, slopes and curves are of forces filtered as a force plate's (`force_plate`); means and
impulses are sums over every physics step and need no filter.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from understudy.evaluate.feet import feet
from understudy.evaluate.force_plate import as_by_plate
from understudy.evaluate.gait_stances import Stance
from understudy.evaluate.measure import Measured
from understudy.motion.rotations import Array

EARLY = 0.25
"""The impact of the foot falls in this first part of a stance; people's at 10 to 15 %."""
DIP = 0.05
"""A peak is one when the force falls by this much after it [body weights]."""
GRAVITY = 9.81
"""[m/s2]."""


@dataclass(frozen=True, kw_only=True)
class StanceForce:
    """How the ground pushed one foot over one stance.

    Attributes:
        side: "left" or "right".
        start_s: Touchdown [s].
        peak: Largest upward force [BW].
        active: Largest after the first quarter of the stance [BW].
        impact: Peak within that quarter, before the force dips [BW]; None without one.
        mean: Mean upward force [BW].
        loading_rate: Steepest rise in the first quarter, over 10 ms [BW/s].
        braking: Impulse against the way of travel over mass [m/s], negative.
        pushing: Impulse along it [m/s].
        up: Upward force at 0, 1, ... 100 % of the stance [BW], shape (101,).
        along: Force along the way of travel, likewise.
    """

    side: str
    start_s: float
    peak: float
    active: float
    impact: float | None
    mean: float
    loading_rate: float
    braking: float
    pushing: float
    up: Array = field(repr=False)
    along: Array = field(repr=False)


def foot_forces(m: Measured, character: int = 0) -> dict[str, Array]:
    """Force of the ground on each foot [BW], world, by side, shape (frames, 3); unfiltered."""
    who = m.performer(character)
    return {
        side: m.ground_reaction(character, links=bodies) / who.weight
        for side, bodies in feet(who).items()
    }


def stance_force(times: Array, force: Array, stance: Stance, ahead: Array) -> StanceForce:
    """Force under a foot over a stance, as it is given.

    Args:
        times: Of every physics step [s], shape (frames,).
        force: Of the ground on that foot [BW], world, shape (frames, 3).
        stance: A whole stance.
        ahead: Unit vector of travel on the ground, shape (3,).
    """
    rows = slice(*np.searchsorted(times, (stance.start_s, stance.end_s)))
    up, along = force[rows, 2], force[rows] @ ahead
    frames, step = len(up), float(times[1] - times[0])
    early = max(1, round(EARLY * frames))
    share = np.linspace(0.0, frames - 1.0, 101)
    return StanceForce(
        side=stance.side,
        start_s=stance.start_s,
        peak=float(up.max()),
        active=float(up[early:].max(initial=0.0)),
        impact=impact_peak(up, early),
        mean=float(up.mean()),
        loading_rate=_steepest(up[:early], step),
        braking=float(np.minimum(along, 0.0).sum() * step * GRAVITY),
        pushing=float(np.maximum(along, 0.0).sum() * step * GRAVITY),
        up=np.interp(share, np.arange(frames), up),
        along=np.interp(share, np.arange(frames), along),
    )


def stance_by_plate(times: Array, force: Array, stance: Stance, ahead: Array) -> StanceForce:
    """The same with peaks, slopes and curves of the force filtered as a force plate's."""
    smooth = as_by_plate(force, 1.0 / float(times[1] - times[0]))
    each = stance_force(times, force, stance, ahead)
    return replace(
        stance_force(times, smooth, stance, ahead),
        mean=each.mean,
        braking=each.braking,
        pushing=each.pushing,
    )


def impact_peak(up: Array, early: int) -> float | None:
    """The largest peak of the first `early` values of a stance; None without one.

    A peak is higher than its neighbors, and the force falls by `DIP` before it rises above it.
    """
    found = None
    for k in range(1, min(early, len(up) - 1)):
        if up[k] < up[k - 1] or up[k] < up[k + 1]:
            continue
        above = np.flatnonzero(up[k:] > up[k])
        until = up[k : k + above[0]] if len(above) else up[k:]
        if up[k] - until.min() > DIP:
            found = max(found or 0.0, float(up[k]))
    return found


def _steepest(up: Array, step: float) -> float:
    """Steepest rise over 10 ms [1/s]."""
    span = min(max(1, round(0.01 / step)), len(up) - 1)
    if span < 1:
        return 0.0
    return float((up[span:] - up[:-span]).max() / (span * step))
