"""Laws a take must obey, and how far it is from them.

In flight nothing outside touches the character, so the energy it gains is the work its joints do
and its center of mass falls freely. What differs is the error of the numerical integration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from understudy.evaluate.measure import Measured, measured_at
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take

SHORTEST_FLIGHT = 0.05
"""Contact-free stretches shorter than this are not called flights [s]."""
LONGEST_CHECK = 2.0
"""Flights are checked step by step, up to this much time in all [s]."""


@dataclass(frozen=True)
class EnergyBalance:
    """How well a stretch of contact-free motion keeps its books.

    Attributes:
        error: Energy gained minus work done by servos, applied forces and joint friction [J],
            the largest over the stretch.
        scale: Largest kinetic energy plus work done, what the error is compared with [J].
    """

    error: float
    scale: float

    @property
    def percent(self) -> float:
        """Error as a share of the energy in play [%]."""
        return 100.0 * self.error / self.scale if self.scale > 0 else 0.0


def flights(measured: Measured, character: int = 0) -> tuple[tuple[int, int], ...]:
    """Contact-free stretches of a character: first and last measured frame of each."""
    who = measured.performer(character)
    touching = np.zeros(measured.frames, bool)
    touching[measured.contacts.frame[measured.contacts.involving(who.bodies)]] = True
    edges = np.flatnonzero(np.diff(np.concatenate(([1], touching.astype(int), [1]))))
    pairs = zip(edges[::2], edges[1::2] - 1, strict=True)
    least = SHORTEST_FLIGHT * measured.rate
    return tuple((int(a), int(b)) for a, b in pairs if b - a >= least)


def energy_balance(take: Take, first: int, last: int) -> EnergyBalance:
    """Energy book-keeping of the whole scene from step `first` to step `last` of a take.

    Work is that of servos, applied forces, pushes, joint friction, limits and contacts: the force
    that acted over a step times the mean of the velocities before and after. What is left is the
    integration error.
    """
    steps = np.arange(first, last + 1)
    m = measured_at(take, steps, take.rate)
    before, after = take.qvel[steps[:-1]], take.qvel[steps[1:]]
    force = m.torque[:-1] + m.resistance[:-1] + m.push[:-1]
    power = force * 0.5 * (before + after)
    work = np.concatenate(([0.0], np.cumsum(power.sum(axis=1) / take.rate)))
    stored = m.kinetic + m.potential
    error = float(np.abs(stored - stored[0] - work).max())
    return EnergyBalance(error, float(m.kinetic.max() + np.abs(work).max()))


def energy_drift(take: Take, measured: Measured, character: int = 0) -> float | None:
    """Largest energy error over the flights of a character [%]; None when it never flew."""
    stretches = flights(measured, character)
    worst, left = None, LONGEST_CHECK
    for a, b in stretches:
        first, last = int(measured.steps[a]), int(measured.steps[b])
        last = min(last, first + int(left * take.rate))
        if last - first < 2:
            break
        left -= (last - first) / take.rate
        percent = energy_balance(take, first, last).percent
        worst = percent if worst is None else max(worst, percent)
    return worst


def free_fall_height(start: float, speed: float, time: Array, *, gravity: float = 9.81) -> Array:
    """Height of a body thrown upward at `speed` [m/s] from `start` [m], at `time` [s]."""
    return start + speed * time - 0.5 * gravity * np.square(time)


def pendulum_period(
    mass: float, distance: float, inertia: float, *, gravity: float = 9.81
) -> float:
    """Small-swing period [s] of a compound pendulum.

    Args:
        mass: [kg].
        distance: From the pivot to the center of mass [m].
        inertia: About the center of mass, along the pivot's axis [kg m^2].
        gravity: [m/s^2].
    """
    return float(2 * np.pi * np.sqrt((inertia + mass * distance**2) / (mass * gravity * distance)))


def servo_lag(stiffness: float, damping: float) -> float:
    """Delay of a servo that damps velocity itself rather than its error [s]: damping/stiffness.

    Its transfer function k/(I s^2 + d s + k) delays slow motion by d/k (Zordan & Hodgins 1999,
    equation 2, has no reference for velocity).
    """
    return damping / stiffness


def center_of_pressure(measured: Measured, character: int = 0) -> Array:
    """Center of pressure of the ground on a character [m], shape (frames, 2); NaN in flight."""
    who, table = measured.performer(character), measured.contacts
    mine = table.involving(who.bodies) & (table.bodies.min(axis=1) == 0)
    load = np.abs(table.force[mine, 2])
    total = np.bincount(table.frame[mine], load, measured.frames)
    with np.errstate(invalid="ignore", divide="ignore"):
        columns = [
            np.bincount(table.frame[mine], load * table.position[mine, axis], measured.frames)
            / total
            for axis in (0, 1)
        ]
    return np.stack(columns, axis=1)
