"""A state machine in a law's memory: what state, since when, and the ways out of it.

The paper (Hodgins et al. 1995, figure 3) leaves a state by an event that is felt ("ball of foot
touches ground") or by time ("percentage of stance phase complete"). A law keeps the state and the
time it began in two places of its memory and writes every transition as one condition. Scalar
functions; they run as they are and compiled.
"""

from __future__ import annotations

# Places of the machine in a law's memory: state number, when it began [s].
STATE, SINCE = 0, 1
MACHINE = 2


def state_of(memory):  # type: ignore[no-untyped-def]
    """Number of the state."""
    return int(memory[STATE])


def time_in(memory, time):  # type: ignore[no-untyped-def]
    """How long the state has lasted [s]."""
    return time - memory[SINCE]


def enter(memory, state, time):  # type: ignore[no-untyped-def]
    """Go to a state."""
    memory[STATE] = state
    memory[SINCE] = time


def timed(memory, time, least):  # type: ignore[no-untyped-def]
    """A timed way out: whether the state has lasted `least` seconds."""
    return time - memory[SINCE] >= least


def sensed(value, threshold, memory, time, least):  # type: ignore[no-untyped-def]
    """A sensed way out: a value over its threshold, after `least` seconds in the state."""
    return value > threshold and time - memory[SINCE] >= least
