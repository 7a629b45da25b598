"""Practice: what a search found is performed again and again, disturbed, for better feedback.

A search knows what a window does only near the runs it went on with. Here some bodies perform the
plan by its gains, while chance pushes the pelvis and turns the offsets. What they do, in all rounds
so far and in the windows beside too, is fitted anew, and the regulator gives the gains of the next
round. A body that is lost begins again on the plan; when few are, that was practice enough.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from understudy.control import Guidance
from understudy.control.guidance_law import DEVIATION, HELP
from understudy.free_tracking.dynamics import Dynamics, Moments, prior, regulator, slopes
from understudy.free_tracking.goal import Goal
from understudy.free_tracking.passes import CHANCE, LOST, Course
from understudy.free_tracking.windows import States, Windows
from understudy.motion.rotations import Array

_PUSH, _OFTEN = 0.5, 0.5  # Size of a push, in the help's chance; how often there is one.
_LOST = 60.0  # Cost of a deviation from the plan from which a body begins again.
_LEAST = 2  # Rounds that teach something in any case.
_FEW = 0.5  # So few lost per second that a body performs are few [1/s].
_BESIDE = 0.5  # What a sample of the window before or after counts.
_FIRM = 1.0  # Weight of the prior, in samples.
# Offsets cost so much more than in the search, which tries what it asks for: here fits are trusted
# blindly, and gains that ask for more than they say shake.
_CALM = 3.0
_ENOUGH = 3  # A fit takes at least one of so many bodies.


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """What is practiced.

    Attributes:
        states: At every border.
        off: Scaled deviations from the goal there, shape (borders, DEVIATION).
        offsets: Scaled offsets of every window, after those of the window before the first.
        help: [N, N m], shape (windows, 6).
        gains: Scaled, shape (windows, axes, DEVIATION + axes).
        most: Largest offset that gains add [rad].
    """

    states: States
    off: Array
    offsets: Array
    help: Array
    gains: Array
    most: float

    @classmethod
    def of(
        cls, course: Course, goal: Goal, windows: Windows, guidance: Guidance, states: States
    ) -> Plan:
        """A guidance and where it takes the body, a row per border."""
        postures = windows.postures(states.qpos, states.qvel)
        off = [goal.deviations(one[None], border)[0] for border, one in enumerate(postures)]
        return cls(
            states=states,
            off=np.array(off),
            offsets=np.concatenate((course.before[None], guidance.offsets / course.sigma)),
            help=guidance.help,
            gains=guidance.gains / course.unit(goal),
            most=guidance.most,
        )


def practiced(
    course: Course,
    goal: Goal,
    windows: Windows,
    plan: Plan,
    *,
    seed: int,
    told: Callable[[int], None],
) -> tuple[Array, list[Dynamics | None], int]:
    """Scaled gains that practice teaches, dynamics, and how many rounds it took.

    Gains have the shape (windows, axes, DEVIATION + axes).

    Args:
        course: What is performed.
        goal: What is wanted.
        windows: Where bodies are simulated.
        plan: What is practiced.
        seed: Of the chances; the first border enters too.
        told: Hears the number of windows done in a round.
    """
    known, gains = prior(len(course.sigma), course.window, goal.scales), plan.gains
    dynamics: list[Dynamics | None] = []
    so_far: list[Moments | None] = [None] * course.windows
    rounds, few = 0, False
    while rounds < course.effort.rounds and not few:
        rng = np.random.default_rng((seed, rounds, course.borders[0], course.windows))
        one = _Round(course, goal, windows, plan, gains, rng)
        seen = one.seen(known, told)
        so_far = [_both(new, old) for new, old in zip(seen, so_far, strict=True)]
        dynamics = [_fitted(so_far, w, known) for w in range(course.windows)]
        gains = _regulated(course, goal, dynamics)
        rounds += 1
        few = rounds >= _LEAST and one.lost < _FEW * course.windows * course.window
    return gains, dynamics, rounds


class _Round:
    """All bodies once through all windows.

    Attributes:
        lost: How often a body was lost, in the mean over all.
    """

    def __init__(
        self,
        course: Course,
        goal: Goal,
        windows: Windows,
        plan: Plan,
        gains: Array,
        rng: np.random.Generator,
    ):
        self._course, self._goal, self._windows, self._plan = course, goal, windows, plan
        self._gains, self._rng = gains, rng
        count, axes = course.effort.bodies, len(course.sigma)
        self._states = plan.states.chosen(np.zeros(count, int))
        self._off = np.repeat(plan.off[:1], count, axis=0)
        self._more = np.zeros((count, axes))
        self.lost = 0.0

    def seen(self, known: Dynamics, told: Callable[[int], None]) -> list[Moments | None]:
        """What every window was seen to do."""
        out = []
        for w in range(self._course.windows):
            out.append(self._window(w, known))
            told(w + 1)
        return out

    def _window(self, w: int, known: Dynamics) -> Moments | None:
        course, goal, plan = self._course, self._goal, self._plan
        z = np.concatenate((self._off, self._more + plan.offsets[w]), axis=1)
        more, held = self._answers(w), self._pushes()
        offsets = plan.offsets[w + 1] + more
        span = slice(*(border - course.borders[0] for border in course.borders[w : w + 2]))
        end, postures = self._windows.run(
            *(self._states, np.arange(len(z)), offsets * course.sigma, held + plan.help[w]),
            *(course.ctrl[span], course.applied[span]),
        )
        fine: Any = np.isfinite(postures).all(axis=1) & np.isfinite(end.qvel).all(axis=1)
        off = goal.deviations(np.where(fine[:, None], postures, goal.marks[w + 1]), w + 1)
        cost = goal.costs(off - plan.off[w + 1])
        fine &= cost < LOST
        self._go_on(w, end, off, more, ~fine | (cost > _LOST))
        if fine.sum() * _ENOUGH < len(fine):
            return None
        held = (held + plan.help[w]) / CHANCE
        return Moments.of(z[fine], offsets[fine], held[fine], off[fine], known)

    def _answers(self, w: int) -> Array:
        """Scaled offsets beyond the plan's: what the gains ask for, and chance."""
        gain, most = self._gains[w], self._plan.most / self._course.sigma
        more = (self._off - self._plan.off[w]) @ gain[:, :DEVIATION].T
        more += self._more @ gain[:, DEVIATION:].T
        return np.clip(more, -most, most) + self._rng.standard_normal(more.shape)

    def _pushes(self) -> Array:
        count = len(self._off)
        pushes = _PUSH * CHANCE * self._rng.standard_normal((count, HELP))
        return pushes * (self._rng.random((count, 1)) < _OFTEN)

    def _go_on(self, w: int, end: States, off: Array, more: Array, lost: Any) -> None:
        """From where the bodies are; who is lost, from the plan."""
        again, plan = lost[:, None], self._plan
        self.lost += float(lost.mean())
        rows = plan.states.chosen([w + 1])
        parts = zip(end, rows, strict=True)
        self._states = States(*(np.where(again, own, each) for each, own in parts))
        self._off = np.where(again, plan.off[w + 1], off)
        self._more = np.where(again, 0.0, more)


def _both(new: Moments | None, old: Moments | None) -> Moments | None:
    if new is None or old is None:
        return new or old
    return new.beside(old)


def _fitted(seen: Sequence[Moments | None], w: int, known: Dynamics) -> Dynamics | None:
    """What a window does, by what was seen in it, and less so beside it."""
    own = seen[w]
    if own is None:
        return None
    for other in (*seen[max(0, w - 1) : w], *seen[w + 1 : w + 2]):
        own = own if other is None else own.beside(other, _BESIDE)
    return Dynamics.fitted(own, known, _FIRM)


def _regulated(course: Course, goal: Goal, dynamics: Sequence[Dynamics | None]) -> Array:
    """The regulator's gains; none where nothing was seen."""
    effort = _CALM * course.penalty
    gains, _ = regulator(dynamics, goal.cost, effort, effort)
    return slopes(gains, len(course.sigma))
