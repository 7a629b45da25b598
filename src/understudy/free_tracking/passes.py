"""One pass of the search: all windows once, in each the best children of the best so far."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from understudy.control.guidance_law import DEVIATION, HELP
from understudy.free_tracking.dynamics import Dynamics, Moments, prior, regulator
from understudy.free_tracking.goal import Goal
from understudy.free_tracking.ladder import Ladder
from understudy.free_tracking.windows import States, Windows
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

# Least costs of the best state of a fall, of an end far off, and of straying from the goal.
_FALL, _END, _STRAY = 500.0, 320.0, 20.0
_AWAY = 50.0  # Least displacement of a fall: 0.2 m or 30 degrees.
_KEEP, _INHERIT = 0.6, 0.3  # Parts of the offsets before, and of the parent's cost, that remain.
_CAREFUL = 0.3  # Offset that costs one where nothing is known of what is to come [rad].
_ENOUGH = 3  # A fit takes at least one of so many children.
_SAME = 1e-8  # What is so little different from the rest of what is known is the same.
_SURE = 0.25  # Part of the elites of which a child does just what the policy says.

CHANCE = np.repeat([100.0, 25.0], 3)
"""Standard deviation of the help's chance: force [N], torque [N m]."""
LOST = 20000.0
"""A child this far off teaches nothing."""


@dataclass(frozen=True, kw_only=True)
class Effort:
    """How hard a search tries.

    Attributes:
        window: Length of a window, to the nearest step [s].
        children: Samples in every window of the first pass; see `ladder` for the later ones.
        elites: How many of them go on, and of fewer children as large a part.
        spread: Standard deviation of an offset of the trunk [rad]; hips and ankles get 1.2 of it.
        reach: Offset that costs as much as a deviation of one scale [rad].
        ridge: How firmly fits hold on to what is known before, per sample.
        passes: At most so many.
        most: Largest offset of the policy [rad].
        rounds: At most so many rounds of practice for the feedback of a free run.
        bodies: How many practice.
    """

    window: float = 0.05
    children: int = 100
    elites: int = 60
    spread: float = 0.04
    reach: float = 0.2
    ridge: float = 0.03
    passes: int = 10
    most: float = 0.5
    rounds: int = 6
    bodies: int = 50


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """What all passes of a search share.

    Attributes:
        effort: How hard it tries.
        window: Length of a window [s].
        borders: First step of every window, and the last one's end.
        ctrl: Controls that are laid down from the first border on, shape (steps, nu).
        applied: Forces that are laid down, shape (steps, nv).
        start: The first state.
        before: Scaled offsets of the window before, shape (axes,).
        root: Place of the pelvis' orientation in qpos.
        sigma: Standard deviation of every offset [rad], shape (axes,).
        penalty: Cost of every scaled offset squared, and of its change, shape (axes,).
    """

    effort: Effort
    window: float
    borders: Sequence[int]
    ctrl: Array
    applied: Array
    start: States
    before: Array
    root: slice
    sigma: Array
    penalty: Array

    @property
    def windows(self) -> int:
        """How many there are."""
        return len(self.borders) - 1

    def unit(self, goal: Goal) -> Array:
        """What a scaled gain of one is, in radians per unit, shape (axes, DEVIATION + axes)."""
        unit: Array = self.sigma[:, None] / np.concatenate((goal.scales, self.sigma))
        return unit

    def answers(
        self, goal: Goal, dynamics: Sequence[Dynamics | None]
    ) -> tuple[list[Array | None], list[Array]]:
        """The regulator's gains and values."""
        return regulator(dynamics, goal.cost, self.penalty, self.penalty)


class Crowd(NamedTuple):
    """Bodies at a border, a row each.

    Attributes:
        states: Of the engine.
        off: Scaled deviations from the goal.
        offsets: Scaled offsets of the window before.
        total: Summed cost, the older the less.
        parents: Rows of the parents in the crowd before.
        held: Help in the window before [N, N m].
        postures: See `control.guidance_law`.
        cost: Of the deviations.
    """

    states: States
    off: Array
    offsets: Array
    total: Array
    parents: Any
    held: Array
    postures: Array
    cost: Array

    @property
    def known(self) -> Array:
        """What a policy knows of them, shape (n, DEVIATION + axes)."""
        return np.concatenate((self.off, self.offsets), axis=1)

    def chosen(self, rows: Any) -> Crowd:
        """Some of them, in the order of `rows`."""
        return Crowd(self.states.chosen(rows), *(array[rows] for array in self[1:]))


def telling(noise: Array, known: Array) -> Array:
    """Chance of which a fit learns most: without a mean, of unit variance, all uncorrelated.

    Drawn freely, a few offsets are by chance much like one another and like what is known of their
    parents, and a fit cannot tell which of them did what.

    Args:
        noise: Of every child, shape (n, axes).
        known: What else a fit is given, shape (n, any).

    Returns:
        The noise, less what of it lies in `known` and its mean, and made orthogonal; as it was
        where there are too few children.
    """
    wide = np.concatenate((np.ones((len(noise), 1)), known), axis=1)
    basis, triangle = np.linalg.qr(wide)
    size = np.abs(np.diag(triangle))
    basis = basis[:, : len(size)][:, size > _SAME * size.max()]
    if len(noise) - basis.shape[1] < noise.shape[1]:
        return noise
    out, triangle = np.linalg.qr(noise - basis @ (basis.T @ noise))
    return np.asarray(out * np.sign(np.diag(triangle)) * np.sqrt(len(noise)))


class OnePass:
    """One pass.

    Args:
        course: What all passes share.
        goal: What is wanted.
        windows: Where children are simulated.
        dynamics: Of every window, from earlier passes, or None.
        ladder: How much help.
        seed: Of its chances; the number of tries and the first border enter too.

    Attributes:
        crowds: The elites at every border that was reached.
        dynamics: Of every window, fitted anew where it came by.
    """

    def __init__(
        self,
        course: Course,
        goal: Goal,
        windows: Windows,
        *,
        dynamics: Sequence[Dynamics | None],
        ladder: Ladder,
        seed: int,
    ):
        self._course, self._goal, self._windows, self._ladder = course, goal, windows, ladder
        self._rng = np.random.default_rng((seed, ladder.tried, course.borders[0]))
        self._gains, self._values = course.answers(goal, dynamics)
        self._prior = prior(len(course.sigma), course.window, goal.scales)
        self.dynamics = list(dynamics)
        self.crowds = [self._first()]

    @property
    def reached(self) -> int:
        """How many windows it came through; not the last one if it ends far off."""
        borders = len(self.crowds) - 1
        ends_badly = borders == self._course.windows and self.crowds[-1].cost.min() > _END
        return borders - 1 if ends_badly else borders

    @property
    def strayed(self) -> int:
        """The window in which it began to stray from where it did not find back."""
        last = self.reached
        while last > 0 and self.crowds[last].cost.min() > _STRAY:
            last -= 1
        return last

    @property
    def _elites(self) -> int:
        effort = self._course.effort
        part = self._ladder.children * effort.elites / effort.children
        return min(effort.elites, round(part))

    def run(self, told: Callable[[int], None]) -> None:
        """Go on until the end or a fall; `told` hears the number of windows done."""
        for w in range(self._course.windows):
            crowd = self._step(w)
            if not len(crowd.cost) or self._fallen(crowd):
                return
            self.crowds.append(crowd)
            told(w + 1)

    def line(self) -> list[tuple[Crowd, int]]:
        """The best run: the crowd and row at every border."""
        out, row = [], int(np.argmin(self.crowds[-1].total))
        for crowd in reversed(self.crowds):
            out.append((crowd, row))
            row = int(crowd.parents[row])
        return out[::-1]

    def _fallen(self, crowd: Crowd) -> bool:
        """Whether even the best is far off, in place too: a jerk of the clip is no fall."""
        best = int(np.argmin(crowd.cost))
        place = self._goal.displacements(crowd.off[best : best + 1])[0]
        return bool(crowd.cost[best] > _FALL and place > _AWAY)

    def _first(self) -> Crowd:
        """The first state alone."""
        states = self._course.start
        postures = self._windows.postures(states.qpos, states.qvel)
        off = self._goal.deviations(postures, 0)
        return Crowd(
            *(states, off, self._course.before[None], np.zeros(1), np.zeros(1, int)),
            *(np.zeros((1, HELP)), postures, self._goal.costs(off)),
        )

    def _step(self, w: int) -> Crowd:
        """The elites at the end of window `w`; fits its dynamics."""
        crowd, course = self.crowds[-1], self._course
        count, children = len(crowd.total), self._ladder.children
        parents = np.arange(children)  # every elite is a parent
        parents[count:] = self._rng.integers(0, count, max(0, children - count))
        offsets = self._offsets(crowd.known[parents], self._gains[w])
        held, scale = self._help(w, parents), self._ladder.scales[w]
        span = slice(*(border - course.borders[0] for border in course.borders[w : w + 2]))
        end, postures = self._windows.run(
            *(crowd.states, parents, offsets * course.sigma, held * scale),
            *(course.ctrl[span], course.applied[span]),
        )
        fine: Any = np.isfinite(postures).all(axis=1) & np.isfinite(end.qvel).all(axis=1)
        postures = np.where(fine[:, None], postures, self._goal.marks[w + 1])
        off = self._goal.deviations(postures, w + 1)
        cost = self._goal.costs(off)
        fine &= cost < LOST
        total = _INHERIT * crowd.total[parents]
        born = Crowd(end, off, offsets, total, parents, held * scale, postures, cost)
        born = born._replace(total=total + self._rank(w, born))
        if fine.sum() * _ENOUGH >= children:
            given = crowd.known[parents][fine], offsets[fine], held[fine] / CHANCE, off[fine]
            known = self.dynamics[w] or self._prior
            ridge = course.effort.ridge * len(given[0])
            self.dynamics[w] = Dynamics.fitted(Moments.of(*given, known), known, ridge)
        order = np.argsort(np.where(fine, born.total, np.inf), kind="stable")
        return born.chosen(order[: min(self._elites, int(fine.sum()))])

    def _offsets(self, known: Array, gain: Array | None) -> Array:
        """Scaled offsets of all children: the policy's, where there is one, and chance."""
        sigma, effort = self._course.sigma, self._course.effort
        noise = self._rng.standard_normal((len(known), len(sigma)))
        if gain is None:
            return _KEEP * known[:, DEVIATION:] + telling(noise, known)
        sure = int(_SURE * self._elites)
        noise[:sure] = 0.0
        noise[sure:] = telling(noise[sure:], known[sure:])
        most = effort.most / sigma
        return np.clip(known @ gain[:, :-1].T + gain[:, -1], -most, most) + noise

    def _help(self, w: int, parents: Any) -> Array:
        """Whole help of all children, and chance; nothing where the ladder has none."""
        if self._ladder.scales[w] == 0.0:
            return np.zeros((len(parents), HELP))
        crowd = self.crowds[-1]
        root = crowd.states.qpos[:, self._course.root]
        chance = self._rng.standard_normal((len(parents), HELP)) * CHANCE
        chance[:, 3:] = rot.rotate(rot.conjugate(root[parents]), chance[:, 3:])
        return self._goal.pull(crowd.off, root)[parents] + chance

    def _rank(self, w: int, born: Crowd) -> Array:
        """What children are worth, the less the better, but for their parents' part."""
        cost = self._goal.joint_costs(born.states.qpos, w + 1)
        if self._gains[w] is None:
            careful = (born.offsets * self._course.sigma / _CAREFUL) ** 2
            return cost + born.cost + careful.mean(axis=1)
        wide = np.concatenate((born.known, np.ones((len(cost), 1))), axis=1)
        return cost + np.einsum("ni,ij,nj->n", wide, self._values[w + 1], wide)
