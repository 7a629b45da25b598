"""The search for a guidance with which a performance needs no help.

Windows of a twentieth of a second; in each, children of the best states so far with offsets drawn
about a policy (L. Liu, M. van de Panne, K. Yin, Guided learning of control graphs, ACM Transactions
on Graphics 35 (2016), has the sampling). From what the children did, each window's dynamics are
fitted, and a linear-quadratic regulator on them is the policy of the next pass and its value
function the next pass's ranking. The first pass holds the pelvis with a weak wrench, which the
next ones take away.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from understudy.control import Guidance, Tracking
from understudy.control.guidance import axes, layout
from understudy.control.guidance_law import DEVIATION, HELP
from understudy.errors import InvalidValue
from understudy.free_tracking.dynamics import Dynamics, prior, regulator
from understudy.free_tracking.goal import Goal
from understudy.free_tracking.ladder import MARGIN, Ladder
from understudy.free_tracking.windows import States, Windows
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.simulate import open_loop_controls, prepared, quiet_engine


@dataclass(frozen=True, kw_only=True)
class Effort:
    """How hard a search tries.

    Attributes:
        window: Length of a window [s].
        children: Samples in every window.
        elites: How many of them go on.
        spread: Standard deviation of an offset of the trunk [rad]; hips and ankles get 1.2 of it.
        reach: Offset that costs as much as a deviation of one scale [rad].
        ridge: How firmly fits hold on to what is known before, per sample.
        passes: At most so many.
        most: Largest offset of the policy [rad].
    """

    window: float = 0.05
    children: int = 100
    elites: int = 60
    spread: float = 0.04
    reach: float = 0.2
    ridge: float = 0.006
    passes: int = 7
    most: float = 0.5


class Pass(NamedTuple):
    """What came of one pass.

    Attributes:
        number: From 0.
        scale: Mean scale of the help in the windows passed; 0 is free.
        reached: How far it came [s].
        done: Whether it came to the end.
        cost: Mean cost of the best run's deviations; infinite where none came to the end.
    """

    number: int
    scale: float
    reached: float
    done: bool
    cost: float


class _Crowd(NamedTuple):
    """The elites at a border, a row each: states, scaled deviations and offsets, summed cost, row
    of the parent, help, posture, cost of the deviation."""

    states: States
    off: Array
    offsets: Array
    total: Array
    parents: Any
    held: Array
    postures: Array
    cost: Array


class _Policy(NamedTuple):
    """Gains of a window, or None, and the value of states at its end."""

    gain: Array | None
    value: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """Part of a performance, to be searched by itself.

    Attributes:
        first: Step where it begins, the border of a window.
        last: Step where it ends.
        start: The state it begins in, one row; None for the performance's own first state.
        offsets: Those of the window before [rad], shape (axes,); None for none.
    """

    first: int
    last: int
    start: States | None = None
    offsets: Array | None = None


_FALL, _END = 2000.0, 320.0  # Least costs of the best state of a fall, and of an end far off.
_LOST = 20000.0  # A child this far off teaches nothing.
_HELP = np.repeat([100.0, 25.0], 3)  # Standard deviation of the help's chance [N, N m].
_KEEP, _INHERIT = 0.6, 0.3  # Parts of the offsets before, and of the parent's cost, that remain.
_WEIGHTS = {"hip": 1.2, "ankle": 1.2}


class Search:
    """A search, pass by pass.

    Args:
        performance: With a `Tracking` of the character whose pelvis nothing else holds.
        seed: The same gives the same guidance, bit for bit, on any number of threads.
        effort: How hard to try.
        threads: For the simulations.
        character: Which of the scene's characters.
        stretch: Part of the performance to search; by default all of it.

    Attributes:
        best: The guidance of the stretch with the least help so far, or None.
        states: Where it takes the body, a row per border of its windows.

    Raises:
        InvalidValue: Nothing tracks a clip there, or the body has no legs.
    """

    def __init__(
        self,
        performance: Performance,
        *,
        seed: int = 0,
        effort: Effort | None = None,
        threads: int = 2,
        character: int = 0,
        stretch: Stretch | None = None,
    ):
        self.performance, self.seed, self.threads = performance, seed, threads
        self.effort = Effort() if effort is None else effort
        self.character = character
        self._tracking = _tracking(performance, character)
        scene, dt = performance.scene, performance.scene.timestep
        every = max(1, round(self.effort.window / dt))
        self.window = every * dt
        part = Stretch(first=0, last=performance.steps) if stretch is None else stretch
        self.borders = [*range(part.first, part.last, every), part.last]
        self.windows = len(self.borders) - 1
        self.model, data = prepared(performance)
        self._start = States.of(data) if part.start is None else part.start
        self._before = part.offsets
        self._layout = layout(scene, self.model, character)
        links = scene.characters[character].links
        kinds = [(links[link].role or "").partition("_")[2] for link, _ in axes(scene, character)]
        weights = np.array([_WEIGHTS.get(kind, 1.0) for kind in kinds])
        self._sigma = self.effort.spread * weights
        self._penalty = (self._sigma / (self.effort.reach * weights)) ** 2
        self.ladder = Ladder.whole(self.windows, self.effort.children)
        self.dynamics: list[Dynamics | None] = [None] * self.windows
        self.best: Guidance | None = None
        self.states: States | None = None
        self.farthest = 0.0

    def passes(self, told: Callable[[int], None] | None = None) -> Iterator[Pass]:
        """Run passes until one is free or there are enough; yields what came of each.

        Args:
            told: Called with the number of windows done in a pass.
        """
        with (
            Windows(self.model, self._layout, threads=self.threads) as windows,
            quiet_engine(),
        ):
            goal = self._goal(windows)
            while not self.ladder.done and self.ladder.tried < self.effort.passes:
                yield self._pass(windows, goal, told or (lambda _: None))

    @property
    def reference(self) -> Clip:
        """The clip that is tracked."""
        return self._tracking.reference

    def _goal(self, windows: Windows) -> Goal:
        scene = self.performance.scene
        times = np.array(self.borders) * scene.timestep
        body, part = scene.characters[self.character], scene.parts[self.character]
        return Goal.of(windows, self._tracking.reference, body, part, times)

    def _pass(self, windows: Windows, goal: Goal, told: Callable[[int], None]) -> Pass:
        """All windows once, with the ladder's help."""
        rng = np.random.default_rng((self.seed, self.ladder.tried, self.borders[0]))
        known = prior(len(self._sigma), self.window, goal.scales)
        gains, values = regulator(self.dynamics, goal.cost, self._penalty, self._penalty)
        crowds, found = [self._first(windows, goal)], list(self.dynamics)
        for w in range(self.windows):
            policy = _Policy(gains[w], values[w + 1])
            crowd, found[w] = self._step(windows, goal, rng, w, crowds[-1], policy, known)
            if not len(crowd.cost) or crowd.cost.min() > _FALL:
                break
            crowds.append(crowd)
            told(w + 1)
        reached = len(crowds) - 1
        if reached == self.windows and crowds[-1].cost.min() > _END:
            reached -= 1
        return self._learned(goal, crowds, found, reached)

    def _learned(
        self, goal: Goal, crowds: list[_Crowd], found: list[Dynamics | None], reached: int
    ) -> Pass:
        """Take over what a pass found, and its best run if it came to the end."""
        done, ladder = reached == self.windows, self.ladder
        good = self.windows if done else max(0, reached - MARGIN)
        self.dynamics = found[:good] + self.dynamics[good:]
        cost = self._keep(goal, crowds) if done else np.inf
        self.ladder = ladder.after(reached)
        when = self.borders[reached] * self.performance.scene.timestep
        self.farthest = max(self.farthest, when)
        scale = float(ladder.scales[: max(1, reached)].mean())
        return Pass(ladder.tried, scale, when, done, cost)

    def _step(
        self,
        windows: Windows,
        goal: Goal,
        rng: np.random.Generator,
        w: int,
        crowd: _Crowd,
        policy: _Policy,
        known: Array,
    ) -> tuple[_Crowd, Dynamics | None]:
        """Window `w`: the elites of the next border, and the window's dynamics."""
        count, children = len(crowd.total), self.ladder.children
        parents = np.arange(children)  # every elite is a parent
        parents[count:] = rng.integers(0, count, max(0, children - count))
        z = np.concatenate((crowd.off, crowd.offsets), axis=1)[parents]
        offsets = self._offsets(rng, z, policy.gain)
        scale = float(self.ladder.scales[w])
        held = self._help(rng, goal, crowd, parents, scale)
        span = slice(*(border - self.borders[0] for border in self.borders[w : w + 2]))
        ctrl, applied = self.commands
        end, postures = windows.run(
            *(crowd.states, parents, offsets * self._sigma, held * scale),
            *(ctrl[span], applied[span]),
        )
        fine: Any = np.isfinite(postures).all(axis=1) & np.isfinite(end.qvel).all(axis=1)
        postures = np.where(fine[:, None], postures, goal.marks[w + 1])
        off = goal.deviations(postures, w + 1)
        cost = goal.costs(off)
        fine &= cost < _LOST
        dynamics = self.dynamics[w]
        if fine.sum() >= self.effort.children // 3:
            given = z[fine], offsets[fine], held[fine] / _HELP, off[fine]
            dynamics = Dynamics.fitted(*given, known, self.effort.ridge)
        rank = goal.joint_costs(end.qpos, w + 1) + _INHERIT * crowd.total[parents]
        if policy.gain is None:
            rank += cost + np.mean((offsets * self._sigma / 0.3) ** 2, axis=1)
        else:
            rank += _values(np.concatenate((off, offsets), axis=1), policy.value)
        order = np.argsort(np.where(fine, rank, np.inf), kind="stable")
        order = order[: min(self.effort.elites, int(fine.sum()))]
        rows: tuple[Any, ...] = (off, offsets, rank, parents, held * scale, postures, cost)
        return _Crowd(end.chosen(order), *(row[order] for row in rows)), dynamics

    @cached_property
    def commands(self) -> tuple[Array, Array]:
        """What all open-loop controllers ask for: controls and forces, a row per step."""
        steps = self.borders[0], self.borders[-1]
        block = open_loop_controls(self.performance, self.model, steps=steps)
        nothing = np.zeros((len(block.ctrl), self.model.nv))
        return block.ctrl, nothing if block.applied is None else block.applied

    def _first(self, windows: Windows, goal: Goal) -> _Crowd:
        """The first state alone."""
        states, size = self._start, len(self._sigma)
        postures = windows.postures(states.qpos, states.qvel)
        off = goal.deviations(postures, 0)
        before = np.zeros(size) if self._before is None else self._before / self._sigma
        return _Crowd(
            *(states, off, before[None], np.zeros(1), np.zeros(1, int)),
            *(np.zeros((1, HELP)), postures, goal.costs(off)),
        )

    def _offsets(self, rng: np.random.Generator, z: Array, gain: Array | None) -> Array:
        """Scaled offsets of all children: the policy's, where there is one, and chance."""
        noise = rng.standard_normal((len(z), len(self._sigma)))
        if gain is None:
            return _KEEP * z[:, DEVIATION:] + noise
        noise[: self.effort.elites // 2] = 0.0
        most = self.effort.most / self._sigma
        return np.clip(z @ gain[:, :-1].T + gain[:, -1], -most, most) + noise

    def _help(
        self, rng: np.random.Generator, goal: Goal, crowd: _Crowd, parents: Any, scale: float
    ) -> Array:
        """Help at full scale of all children, and chance."""
        if scale == 0.0:
            return np.zeros((len(parents), HELP))
        first = self.performance.scene.parts[self.character].qpos.start + 3
        root = crowd.states.qpos[:, first : first + 4]
        chance = rng.standard_normal((len(parents), HELP)) * _HELP
        chance[:, 3:] = rot.rotate(rot.conjugate(root[parents]), chance[:, 3:])
        return goal.pull(crowd.off, root)[parents] + chance

    def _keep(self, goal: Goal, crowds: list[_Crowd]) -> float:
        """Make the best run of a pass the guidance; returns its mean cost."""
        line, row = [], int(np.argmin(crowds[-1].total))
        for crowd in reversed(crowds):
            line.append((crowd, row))
            row = int(crowd.parents[row])
        line.reverse()
        gains, _ = regulator(self.dynamics, goal.cost, self._penalty, self._penalty)
        turned = self._sigma[:, None] / np.concatenate((goal.scales, self._sigma))
        size = len(self._sigma)
        nothing = np.zeros((size, DEVIATION + size))
        held = np.array([crowd.held[k] for crowd, k in line[1:]])
        weight = goal.mass * abs(self.performance.scene.gravity)
        shares = np.linalg.norm(held[:, :3], axis=1) / weight
        cost = float(np.mean([crowd.cost[k] for crowd, k in line[1:]]))
        share = float(shares.mean())
        if self.best is not None and self.best.found["help_percent"] < 100.0 * share:
            return cost
        rows = [crowd.states.chosen([k]) for crowd, k in line]
        self.states = States(*(np.concatenate(each) for each in zip(*rows, strict=True)))
        self.best = Guidance(
            window=self.window,
            offsets=np.array([crowd.offsets[k] * self._sigma for crowd, k in line[1:]]),
            help=held,
            postures=np.array([crowd.postures[k] for crowd, k in line[:-1]]),
            gains=np.array([nothing if g is None else g[:, :-1] * turned for g in gains]),
            character=self.character,
            found={
                "seed": self.seed,
                "passes": self.ladder.tried + 1,
                "help_scale": float(self.ladder.scales.mean()),
                "help_percent": 100.0 * share,
                "cost": cost,
            },
        )
        return cost


def _values(known: Array, value: Array) -> Array:
    """(z, 1)' P (z, 1) for rows z."""
    wide = np.concatenate((known, np.ones((len(known), 1))), axis=1)
    return np.einsum("ni,ij,nj->n", wide, value, wide)


def _tracking(performance: Performance, character: int) -> Tracking:
    for controller in performance.controllers:
        if isinstance(controller, Tracking) and controller.character == character:
            return controller
    raise InvalidValue(f"Nothing makes character {character} track a clip.")
