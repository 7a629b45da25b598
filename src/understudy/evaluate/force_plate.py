"""Contact forces as a force plate's are read: low-pass filtered before a peak is taken.

A hard sole meets a hard floor within one step of the engine, and the force of that step depends on
the step. Forces measured on people are smoothed before anyone reads a peak, so a peak is compared
with theirs only after the same. Sums over time, such as impulses, need no filter.
"""

from __future__ import annotations

import numpy as np
from scipy import signal

from understudy.motion.rotations import Array

CUTOFF = 20.0
"""Here the filter halves the power [Hz]. 99 % of that of people's gait lies below 15 Hz (Antonsson
& Mann 1985, J Biomech 18: 39)."""


def as_by_plate(force: Array, rate: float) -> Array:
    """A force over time, low-pass filtered without lag.

    A critically damped filter of the second order, forward and then backward (Robertson & Dowling
    2003, J Electromyogr Kinesiol 13: 569): its weights are positive and add up to 1, so a constant
    stays, an impulse is spread and kept, and a force that only pushes is never seen to pull, as it
    would be with a Butterworth filter. The ends are carried on as constants.

    Args:
        force: Any unit, shape (frames, ...).
        rate: Frames per second [Hz]; up to twice the cutoff nothing is filtered.
    """
    if rate <= 2.0 * CUTOFF or len(force) < 2:
        return np.array(force, float)
    # The power that each of four equal passes of one pole leaves at the cutoff: together a half.
    left = 0.5**0.25
    b = (1.0 - left * np.cos(2.0 * np.pi * CUTOFF / rate)) / (1.0 - left)
    pole = b - np.sqrt(b * b - 1.0)
    around = min(len(force) - 1, int(np.ceil(30.0 / (1.0 - pole))))
    return signal.filtfilt(
        [(1.0 - pole) ** 2],
        [1.0, -2.0 * pole, pole**2],
        np.asarray(force, float),
        axis=0,
        padtype="constant",
        padlen=around,
    )
