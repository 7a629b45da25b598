"""Planning anew from where the body is: for hits that are too much for a guidance's gains.

Where a body is far off its plan when a window begins, windows ahead are searched from the state it
is in, by samples about what the gains ask for, and the first window of the best run is done. The
body plans in a world of its own: by itself on the ground as the performance had it, with nothing
that happens to it later.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any

import mujoco
import numpy as np

from understudy.control import EngineState, Guidance, PythonController, Tracking
from understudy.control import guidance_law as law
from understudy.control.guidance import limit_commands
from understudy.errors import InvalidValue
from understudy.free_tracking.alone import by_itself
from understudy.free_tracking.goal import Goal
from understudy.free_tracking.search import Search
from understudy.free_tracking.windows import States, Windows
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.scene import Part, Scene

# Offset that costs as much as the third number [rad]; part of the cost so far that remains.
_EFFORT, _REST, _COSTS = 0.2, 0.8, 0.2


@dataclass(frozen=True, kw_only=True)
class Foresight:
    """How a body plans anew.

    Attributes:
        windows: How many windows it looks ahead.
        children: Samples in every window.
        elites: How many of them go on.
        spread: Standard deviation of the samples' offsets [rad].
        alarm: Cost of a deviation from the plan from which on it plans anew; a deviation of one
            scale costs one.
        most: Largest offset that the gains add to the plan [rad].
    """

    windows: int = 12
    children: int = 80
    elites: int = 30
    spread: float = 0.05
    alarm: float = 2.0
    most: float = 0.5

    def __post_init__(self) -> None:
        if not 1 <= self.elites <= self.children:
            raise InvalidValue(
                f"elites is {self.elites}; it must lie in 1 to {self.children}, the children."
            )
        if self.windows < 1:
            raise InvalidValue(f"windows is {self.windows}; it must be at least 1.")
        for name in ("spread", "alarm", "most"):
            if not getattr(self, name) >= 0.0:
                raise InvalidValue(f"{name} is {getattr(self, name)}; it must be zero or more.")


def replanned(performance: Performance, foresight: Foresight | None = None) -> Performance:
    """The performance with guidances that also plan anew where a body is far off its plan.

    It runs with Python between the engine's steps, about as fast as a person moves, and slower
    while it plans. What is changed in the result later, the ground or the body, it does not know.

    Args:
        performance: With guidances, as `freed` and `guided` give.
        foresight: How bodies plan.

    Raises:
        InvalidValue: Nothing in the performance is guided.
    """
    controllers, foresight = list(performance.controllers), foresight or Foresight()
    if not any(isinstance(one, Guidance) for one in controllers):
        raise InvalidValue("Nothing in the performance is guided; free its bodies first.")
    tracking = {c.character: c for c in controllers if isinstance(c, Tracking)}
    for k, one in enumerate(controllers):
        if isinstance(one, Guidance):
            controllers[k] = Replanning(
                world=by_itself(performance, tracking[one.character]),
                guidance=one,
                foresight=foresight,
                seed=performance.seed,
            )
    return replace(performance, controllers=tuple(controllers))


@dataclass(frozen=True, kw_only=True)
class Replanning(PythonController):
    """A guidance that plans anew; see `replanned`. Plain values make it, so take files hold it.

    Attributes:
        world: The body by itself, as it plans.
        guidance: What it follows while the body is near its plan.
        foresight: How it plans.
        seed: Of its chances.
        function: The `Planner` made of these.
        period: One step [s].
    """

    function: Any = field(init=False, repr=False)
    period: float = field(init=False)
    world: Performance = field(repr=False)
    guidance: Guidance = field(repr=False)
    foresight: Foresight
    seed: int = 0

    def __post_init__(self) -> None:
        own = replace(self.guidance, character=0)
        planner = Planner(self.world, own, self.foresight, self.seed)
        object.__setattr__(self, "function", planner)
        object.__setattr__(self, "period", self.world.scene.timestep)
        super().__post_init__()

    @property
    def facts(self) -> dict[str, Any]:
        """What a certificate says about it."""
        return {**self.guidance.facts, "replanning": asdict(self.foresight)}

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Leave the limits of the servos to the law; find the body."""
        limit_commands(scene, model, self.guidance.character)
        self.function.enter(scene.parts[self.guidance.character])


class Planner:
    """The function of a `Replanning`: called in every step, it decides when a window begins.

    Args:
        world: The body by itself, as it plans.
        guidance: Of the body there.
        foresight: How it plans.
        seed: Of its chances.
    """

    def __init__(self, world: Performance, guidance: Guidance, foresight: Foresight, seed: int):
        self._guidance, self._foresight, self._seed = guidance, foresight, seed
        self._part = world.scene.parts[0]
        search, scene = Search(world, threads=1), world.scene
        self._model, self._course = search.model, search.course
        self._here = scene.parts[0]
        _, self._parameters, self._memory = guidance.feedback(scene, search.model)
        self._body = mujoco.MjData(search.model)
        self._windows = Windows(search.model, search.layout, threads=1)
        times = np.array(search.borders) * scene.timestep
        goal = Goal.of(self._windows, search.reference, scene.characters[0], self._here, times)
        marks = np.concatenate((guidance.postures, goal.marks[len(guidance.postures) :]))
        self._goal = replace(goal, marks=marks)
        self._step, self._every = scene.timestep, round(guidance.window / scene.timestep)
        self.planned = 0

    def enter(self, part: Part) -> None:
        """Take a body's place in the arrays of the scene it performs in."""
        self._part = part

    def __call__(self, time: float, data: mujoco.MjData) -> None:
        """Turn the commands, as `guidance_law.law` does; `planned` counts windows planned anew."""
        step = round(time / self._step)
        window, size = step // self._every, self._guidance.offsets.shape[1]
        if step == 0:
            self._memory[:], self.planned = 0.0, 0
        if window >= len(self._guidance.offsets):
            return
        self._look(data)
        state = EngineState.of(self._body)
        if step == window * self._every:
            before = np.array(self._memory[:size])
            law.decide(state, self._parameters, window, self._memory)
            off = self._memory[2 * size + law.POSTURE :] / self._goal.scales
            if self._goal.costs(off[None])[0] > self._foresight.alarm:
                self._memory[:size] = self._plan(window, off, before)
                self.planned += 1
        self._steer(state, data, window)

    def _look(self, data: mujoco.MjData) -> None:
        """Bring the body of this world to where the one that performs is."""
        mine, its, body = self._here, self._part, self._body
        body.qpos[mine.qpos], body.qvel[mine.dofs] = data.qpos[its.qpos], data.qvel[its.dofs]
        body.qacc_warmstart[mine.dofs] = data.qacc_warmstart[its.dofs]
        for stage in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_comVel):
            stage(self._model, body)

    def _steer(self, state: EngineState, data: mujoco.MjData, window: int) -> None:
        """Lay the offsets in force on the commands of the body that performs."""
        here, there = _commands(self._here), _commands(self._part)
        ctrl = np.zeros(self._model.nu)
        ctrl[here] = data.ctrl[there]
        law.steer(ctrl, self._parameters, self._memory)
        law.spare(state, ctrl, self._parameters)
        data.ctrl[there] = ctrl[here]
        first = self._part.dofs.start
        data.qfrc_applied[first : first + law.HELP] += self._guidance.help[window]

    def _plan(self, window: int, off: Array, before: Array) -> Array:
        """Offsets for a window [rad], from a scaled deviation and the offsets before, (axes,)."""
        own, ahead = self._guidance, self._foresight
        rng = np.random.default_rng((self._seed, window))
        if window > 0:
            before = before - own.offsets[window - 1]
        known, states = np.concatenate((off, before))[None], States.of(self._body)
        total, first = np.zeros(1), np.zeros((1, len(before)))
        last = min(window + ahead.windows, len(own.offsets))
        for w in range(window, last):
            parents = np.arange(ahead.children) % len(total)
            more = self._sampled(rng, w, known[parents], len(total))
            born, known, cost = self._tried(w, states, parents, more)
            total = cost + _REST * total[parents]
            first = own.offsets[w] + more if w == window else first[parents]
            best = np.argsort(total, kind="stable")[: ahead.elites]
            states, known = born.chosen(best), known[best]
            total, first = total[best], first[best]
        return first[0]

    def _sampled(self, rng: np.random.Generator, w: int, known: Array, parents: int) -> Array:
        """Offsets beyond the plan [rad]: the gains', and chance for all but one of each parent."""
        size, sigma = self._guidance.offsets.shape[1], self._course.sigma
        unit = np.concatenate((self._goal.scales, np.ones(size)))
        most = self._foresight.most
        asked = np.clip((known * unit) @ self._guidance.gains[w].T, -most, most)
        noise = rng.standard_normal(asked.shape) * self._foresight.spread * sigma / sigma.mean()
        noise[:parents] = 0.0
        return asked + noise

    def _tried(
        self, w: int, states: States, parents: Any, more: Array
    ) -> tuple[States, Array, Array]:
        """States at a window's end, what is known of them, and their cost."""
        course, goal, own = self._course, self._goal, self._guidance
        span = slice(course.borders[w], course.borders[w + 1])
        held = np.repeat(own.help[w : w + 1], len(more), axis=0)
        end, postures = self._windows.run(
            *(states, parents, own.offsets[w] + more, held),
            *(course.ctrl[span], course.applied[span]),
        )
        fine: Any = np.isfinite(postures).all(axis=1) & np.isfinite(end.qvel).all(axis=1)
        off = goal.deviations(np.where(fine[:, None], postures, goal.marks[w + 1]), w + 1)
        cost = goal.costs(off) + goal.joint_costs(end.qpos, w + 1)
        cost += _COSTS * np.sum((more / _EFFORT) ** 2, axis=1)
        return end, np.concatenate((off, more), axis=1), np.where(fine, cost, np.inf)


def _commands(part: Part) -> list[int]:
    """Places of a body's joint commands."""
    return [first + k for first in part.joint_controls for k in range(4)]
