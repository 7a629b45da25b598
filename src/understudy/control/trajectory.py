"""Smooth desired values and the servos that follow them (Hodgins et al. 1995, equation 6).

Scalar functions for laws; they run as they are and compiled. "The desired values used in the
proportional-derivative servos are computed as trajectories from the current value of the joint to
the desired value computed by the control laws."
"""

from __future__ import annotations


def bounded(value, low, high):  # type: ignore[no-untyped-def]
    """The value, or the bound it passes; not a number stays so."""
    if value < low:
        return low
    if value > high:
        return high
    return value


def ease(share):  # type: ignore[no-untyped-def]
    """A cubic from 0 to 1 with no slope at its ends; constant before and behind."""
    s = bounded(share, 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def share_of(elapsed, duration):  # type: ignore[no-untyped-def]
    """How much of a duration has passed, 0 to 1; all of one that is not positive."""
    if duration <= 0.0:
        return 1.0
    return bounded(elapsed / duration, 0.0, 1.0)


def eased(start, goal, elapsed, duration):  # type: ignore[no-untyped-def]
    """The desired value `elapsed` seconds into a trajectory from `start` to `goal`."""
    return start + (goal - start) * ease(share_of(elapsed, duration))


def going(rate, elapsed, duration):  # type: ignore[no-untyped-def]
    """How far a joint that moves at `rate` goes on before it turns toward its goal.

    Added to `eased`, it makes the trajectory begin at the present rate; it is gone at the end.
    """
    s = share_of(elapsed, duration)
    return rate * duration * s * (1.0 - s) * (1.0 - s)


def toward(value, goal, most):  # type: ignore[no-untyped-def]
    """The value one step nearer to its goal, by no more than `most`."""
    return value + bounded(goal - value, -most, most)


def servo(k, kv, desired, angle, desired_rate, rate):  # type: ignore[no-untyped-def]
    """Torque of equation 6: tau = k (theta_d - theta) + k_v (theta_dot_d - theta_dot) [N m].

    Args:
        k: Stiffness [N m/rad].
        kv: Damping [N m s/rad].
        desired: Desired angle [rad].
        angle: Angle [rad].
        desired_rate: Its desired rate [rad/s].
        rate: Its rate [rad/s].
    """
    return k * (desired - angle) + kv * (desired_rate - rate)


def followed(memory, at, desired, dt, fastest):  # type: ignore[no-untyped-def]
    """Rate of a desired value from one step to the next [rad/s], at most `fastest` either way.

    `memory[at]` keeps the value; write the current one there where a new trajectory begins.
    """
    rate = bounded((desired - memory[at]) / dt, -fastest, fastest)
    memory[at] = desired
    return rate
