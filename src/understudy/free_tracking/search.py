"""The search for a guidance with which a performance needs no help.

Windows of a twentieth of a second; in each, children of the best states so far with offsets drawn
about a policy (sampling: L. Liu, M. van de Panne, K. Yin, Guided learning of control graphs for
physics-based characters, ACM Transactions on Graphics 35 (2016)). From what the children did, each
window's dynamics are fitted; a linear-quadratic regulator on them is the next pass's policy and its
value function the next pass's ranking. The first pass helps the pelvis, the next ones less. What
came through is practiced before a pass that is to do better than one that fell, and at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from understudy.control import Guidance, Tracking
from understudy.control.guidance import axes, layout, limit_commands
from understudy.errors import InvalidValue
from understudy.free_tracking.dynamics import Dynamics, slopes
from understudy.free_tracking.goal import Goal
from understudy.free_tracking.ladder import MARGIN, Ladder
from understudy.free_tracking.passes import Course, Effort, OnePass
from understudy.free_tracking.practice import Plan, practiced
from understudy.free_tracking.windows import States, Windows
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.simulate import open_loop_controls, prepared, quiet_engine

_WEIGHTS = {"hip": 1.2, "ankle": 1.2}


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
        fallen: The guidance of the run that came farthest, up to where it was lost, until there is
            one that came to the end; or None.
        fallen_states: Where that takes the body.
        ladder: How much help the next pass gives.
        dynamics: What is known of every window.
        farthest: How far any pass came [s].

    Raises:
        InvalidValue: Nothing tracks a clip there, the body has no legs, or the seed is no whole
            number from 0 on.
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
        self.performance, self.seed, self.threads = performance, _seed(seed), threads
        self.effort = Effort() if effort is None else effort
        self.character = character
        self._tracking = _tracking(performance, character)
        self.model, data = prepared(performance)
        limit_commands(performance.scene, self.model, character)
        self.layout = layout(performance.scene, self.model, character)
        part = Stretch(first=0, last=performance.steps) if stretch is None else stretch
        self.course = self._course(part, States.of(data) if part.start is None else part.start)
        self.ladder = Ladder.first(self.windows, self.effort.children)
        self.dynamics: list[Dynamics | None] = [None] * self.windows
        self.best: Guidance | None = None
        self.states: States | None = None
        self.fallen: Guidance | None = None
        self.fallen_states: States | None = None
        self.farthest = 0.0

    @property
    def windows(self) -> int:
        """Number of windows."""
        return self.course.windows

    @property
    def borders(self) -> Sequence[int]:
        """First step of every window, and the last one's end."""
        return self.course.borders

    @property
    def commands(self) -> tuple[Array, Array]:
        """What all open-loop controllers ask for: controls and forces, a row per step."""
        return self.course.ctrl, self.course.applied

    @property
    def reference(self) -> Clip:
        """The clip that is tracked."""
        return self._tracking.reference

    @property
    def practice_is_next(self) -> bool:
        """Whether the best run is to be practiced: it is free, or the pass after it fell."""
        if self.best is None or self.effort.rounds == 0 or self.best.found["rounds"]:
            return False
        return self.ladder.free or self.ladder.fell

    def passes(self, told: Callable[[int], None] | None = None) -> Iterator[None]:
        """Run passes until one is free or there are enough, and practice; yields after each.

        What `told` raises ends the pass at work; where it came farthest is kept.

        Args:
            told: Called with the number of windows done in a pass.
        """
        scene = self.performance.scene
        times = np.array(self.borders) * scene.timestep
        body, part = scene.characters[self.character], scene.parts[self.character]
        with Windows(self.model, self.layout, threads=self.threads) as windows, quiet_engine():
            goal = Goal.of(windows, self._tracking.reference, body, part, times)
            told = told or (lambda _: None)
            while True:
                if self.practice_is_next:
                    self._practice(goal, windows, told)
                elif self.ladder.free or self.ladder.tried >= self.effort.passes:
                    return
                else:
                    self._pass(goal, windows, told)
                yield

    def _course(self, part: Stretch, start: States) -> Course:
        scene, dt = self.performance.scene, self.performance.scene.timestep
        every = max(1, round(self.effort.window / dt))
        block = open_loop_controls(self.performance, self.model, steps=(part.first, part.last))
        nothing = np.zeros((len(block.ctrl), self.model.nv))
        links = scene.characters[self.character].links
        roles = [links[link].role or "" for link, _ in axes(scene, self.character)]
        weights = np.array([_WEIGHTS.get(role.partition("_")[2], 1.0) for role in roles])
        sigma, first = self.effort.spread * weights, scene.parts[self.character].qpos.start + 3
        return Course(
            effort=self.effort,
            window=every * dt,
            borders=(*range(part.first, part.last, every), part.last),
            ctrl=block.ctrl,
            applied=nothing if block.applied is None else block.applied,
            start=start,
            before=np.zeros(len(sigma)) if part.offsets is None else part.offsets / sigma,
            root=slice(first, first + 4),
            sigma=sigma,
            penalty=np.full(len(weights), (self.effort.spread / self.effort.reach) ** 2),
        )

    def _pass(self, goal: Goal, windows: Windows, told: Callable[[int], None]) -> None:
        """Run one pass, and take over what it found."""
        one = OnePass(
            *(self.course, goal, windows),
            dynamics=self.dynamics,
            ladder=self.ladder,
            seed=self.seed,
        )
        try:
            one.run(told)
        finally:
            self._keep_fallen(goal, one)
        reached = one.reached
        done = reached == self.windows
        good = self.windows if done else max(0, one.strayed - MARGIN)
        self.dynamics = one.dynamics[:good] + self.dynamics[good:]
        cost = self._keep(goal, one) if done else np.inf
        self.ladder = self.ladder.after(reached, strayed=one.strayed, cost=cost)
        when = self.borders[reached] * self.performance.scene.timestep
        self.farthest = max(self.farthest, when)

    def _practice(self, goal: Goal, windows: Windows, told: Callable[[int], None]) -> None:
        """Practice the best run: its feedback gets better, and the next pass knows more."""
        assert self.best is not None and self.states is not None
        plan = Plan.of(self.course, goal, windows, self.best, self.states)
        gains, self.dynamics, rounds = practiced(
            *(self.course, goal, windows, plan), seed=self.seed, told=told
        )
        found = {**self.best.found, "rounds": rounds}
        self.best = replace(self.best, gains=gains * self.course.unit(goal), found=found)

    def _keep(self, goal: Goal, one: OnePass) -> float:
        """Make the best run of a pass the guidance if none needs less help; returns its cost."""
        own, states = self._guidance(goal, one)
        found = own.found["help_percent"], own.found["cost"]
        known = {} if self.best is None else self.best.found
        if not known or found <= (known["help_percent"], known["cost"]):
            self.best, self.states = own, states
        return found[1]

    def _keep_fallen(self, goal: Goal, one: OnePass) -> None:
        """Keep the best run of a pass that did not come to the end if none came farther."""
        before = 0 if self.fallen is None else len(self.fallen.offsets)
        if self.best is None and len(one.crowds) - 1 > before:
            self.fallen, self.fallen_states = self._guidance(goal, one)

    def _guidance(self, goal: Goal, one: OnePass) -> tuple[Guidance, States]:
        """The best run of a pass, as far as it came, and where it takes the body."""
        line = one.line()
        held = np.array([crowd.held[k] for crowd, k in line[1:]])
        weight = goal.mass * abs(self.performance.scene.gravity)
        rows = [crowd.states.chosen([k]) for crowd, k in line]
        states = States(*(np.concatenate(each) for each in zip(*rows, strict=True)))
        sigma = self.course.sigma
        own = Guidance(
            window=self.course.window,
            offsets=np.array([crowd.offsets[k] * sigma for crowd, k in line[1:]]),
            help=held,
            postures=np.array([crowd.postures[k] for crowd, k in line[:-1]]),
            gains=self._gains(goal)[: len(held)],
            character=self.character,
            found={
                "seed": self.seed,
                "passes": self.ladder.tried + 1,
                "rounds": 0,
                "help_scale": float(self.ladder.scales.mean()),
                "help_percent": 100.0 * float(np.linalg.norm(held[:, :3], axis=1).mean()) / weight,
                "cost": float(np.mean([crowd.cost[k] for crowd, k in line[1:]])),
            },
        )
        return own, states

    def _gains(self, goal: Goal) -> Array:
        """The regulator's gains in radians per unit; none where nothing is known."""
        gains, _ = self.course.answers(goal, self.dynamics)
        return slopes(gains, len(self.course.sigma)) * self.course.unit(goal)


def _seed(value: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
        raise InvalidValue(f"seed is {value}; it must be a whole number from 0 on.")
    return int(value)


def _tracking(performance: Performance, character: int) -> Tracking:
    for controller in performance.controllers:
        if isinstance(controller, Tracking) and controller.character == character:
            return controller
    raise InvalidValue(f"Nothing makes character {character} track a clip.")
