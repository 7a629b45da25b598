"""What a window does, fitted on the samples that were simulated anyway, and the best answer to it.

A state z is a scaled deviation x and the scaled offsets of the window before; a window takes it to
x' = A z + B a + c, with offsets a. The regulator is the linear-quadratic one, backwards in time,
for deviations, offsets and changes of offsets.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from understudy.control.guidance_law import DEVIATION
from understudy.free_tracking.goal import PARTS
from understudy.motion.rotations import Array

# What is off at the end goes on to cost: a body that falls is as many times as dear.
_END = 5.0


class Moments(NamedTuple):
    """What samples of a window have in common: inputs (z, a, help), outputs x less what is known.

    Attributes:
        gram: Of the inputs about their mean, shape (inputs, inputs).
        cross: Of inputs and outputs, shape (inputs, DEVIATION).
        middle: Mean of the inputs.
        mean: Mean of the outputs.
    """

    gram: Array
    cross: Array
    middle: Array
    mean: Array

    @classmethod
    def of(cls, z: Array, a: Array, held: Array, x: Array, known: Dynamics) -> Moments:
        """Of samples.

        Args:
            z: States, shape (n, DEVIATION + axes).
            a: Their offsets, shape (n, axes).
            held: Their help, shape (n, 6); what it does is fitted too, and left out.
            x: Deviations at the end, shape (n, DEVIATION).
            known: What is known before, from an earlier pass or by `prior`.
        """
        inputs = np.concatenate((z, a, held), axis=1)
        change = x - z @ known.state.T - a @ known.offsets.T
        middle, mean = inputs.mean(axis=0), change.mean(axis=0)
        inputs = inputs - middle
        return cls(inputs.T @ inputs, inputs.T @ (change - mean), middle, mean)

    def beside(self, other: Moments, share: float = 1.0) -> Moments:
        """With what other samples, about their own means, say of the slopes."""
        gram, cross = self.gram + share * other.gram, self.cross + share * other.cross
        return self._replace(gram=gram, cross=cross)


class Dynamics(NamedTuple):
    """x' = A z + B a + c of one window."""

    state: Array
    offsets: Array
    rest: Array

    @classmethod
    def fitted(cls, samples: Moments, known: Dynamics, ridge: float) -> Dynamics:
        """By ridge regression toward what is known.

        Args:
            samples: Of the window.
            known: What they are counted from.
            ridge: Weight of it, in samples.
        """
        gram = samples.gram.copy()
        gram[np.diag_indices_from(gram)] += ridge
        slope = np.linalg.solve(gram, samples.cross).T
        width, size = known.state.shape[1], known.offsets.shape[1]
        return cls(
            known.state + slope[:, :width],
            known.offsets + slope[:, width : width + size],
            samples.mean - slope @ samples.middle,
        )


def prior(axes: int, window: float, scales: Array) -> Dynamics:
    """Before any sample: places follow velocities; momentum, turning and feet half persist."""
    out = np.zeros((DEVIATION, DEVIATION + axes))
    keep = np.repeat([1.0, 1.0, 0.5, 1.0, 0.5, 0.5], PARTS)
    out[:, :DEVIATION] = np.diag(keep)
    for place, velocity in ((0, 3), (9, 12)):
        for k in range(3):
            out[place + k, velocity + k] = window * scales[velocity + k] / scales[place + k]
    return Dynamics(out, np.zeros((DEVIATION, axes)), np.zeros(DEVIATION))


def regulator(
    dynamics: Sequence[Dynamics | None], cost: Array, effort: Array, change: Array
) -> tuple[list[Array | None], list[Array]]:
    """The best answer in every window, and what states are worth.

    Args:
        dynamics: Of every window; None where nothing is known.
        cost: Of a deviation, shape (DEVIATION, DEVIATION).
        effort: Of every offset squared, shape (axes,).
        change: Of every offset's change squared, shape (axes,).

    Returns:
        For every window K of a = K (z, 1), or None; and for every border P of the cost to the end
        (z, 1)' P (z, 1).
    """
    size = len(effort)
    wide = DEVIATION + size + 1
    stage = np.zeros((wide, wide))
    stage[:DEVIATION, :DEVIATION] = cost
    last = slice(DEVIATION, DEVIATION + size)
    gains: list[Array | None] = []
    values = [_END * stage]
    for one in reversed(dynamics):
        if one is None:
            gains.append(None)
            values.append(_END * stage)
            continue
        onward, into = np.zeros((wide, wide)), np.zeros((wide, size))
        onward[:DEVIATION, :-1], onward[:DEVIATION, -1] = one.state, one.rest
        onward[-1, -1] = 1.0
        into[:DEVIATION], into[last] = one.offsets, np.eye(size)
        inner = np.diag(effort + change) + into.T @ values[-1] @ into
        cross = into.T @ values[-1] @ onward
        cross[:, last] -= np.diag(change)
        gain: Array = -np.asarray(np.linalg.solve(inner, cross), float)
        value = onward.T @ values[-1] @ onward + cross.T @ gain + stage
        value[last, last] += np.diag(change)
        gains.append(gain)
        values.append(0.5 * (value + value.T))
    return gains[::-1], values[::-1]


def slopes(gains: Sequence[Array | None], axes: int) -> Array:
    """Gains without their constants, shape (windows, axes, DEVIATION + axes); zero for None."""
    nothing = np.zeros((axes, DEVIATION + axes))
    return np.array([nothing if gain is None else gain[:, :-1] for gain in gains])
