"""A long performance, piece by piece: each begins in the state in which the one before hands over.

A piece is searched some way beyond its end, so that it hands over a body that can go on. However
long the performance, one piece is in memory at a time. A piece that fails is tried again by itself,
from a little earlier; only where it fails again is there help. A piece through which no pass comes
at all is made shorter.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from typing import Any, NamedTuple

import numpy as np

from understudy.control import Guidance
from understudy.errors import InvalidValue
from understudy.free_tracking.passes import Effort
from understudy.free_tracking.search import Search, Stretch
from understudy.free_tracking.windows import States
from understudy.performance import Performance

PIECE, AHEAD, BACK, LEAST = 5.0, 1.0, 1.5, 0.6
"""Length of a piece; how far beyond its end it is searched; how much before it is done again where
it fails; the shortest piece [s]."""
WORTH = 0.5
"""A run that was lost is worth keeping when it came so far [s]."""
ROWS = ("offsets", "help", "postures", "gains")
"""Fields of a guidance with a row per window."""


class Done(NamedTuple):
    """The part of a performance that is done.

    Attributes:
        guidance: Of its windows.
        states: At the last borders of its windows, a row each.
    """

    guidance: Guidance
    states: States

    def until(self, window: int) -> Done:
        """What lies before a window, not far from the end."""
        less = len(self.guidance.offsets) - window
        rows = {name: getattr(self.guidance, name)[:window] for name in ROWS}
        states = self.states.chosen(slice(len(self.states.qpos) - less))
        return Done(replace(self.guidance, **rows), states)

    def followed(self, by: Done) -> Done:
        """With a piece after it."""
        own, new = self.guidance, by.guidance
        rows = {n: np.concatenate((getattr(own, n), getattr(new, n))) for n in ROWS}
        found = {**own.found, **_sums(own, new)}
        return Done(replace(own, **rows, found=found), by.states)

    @property
    def held(self) -> float:
        """Sum of the help's forces [N]."""
        return float(np.linalg.norm(self.guidance.help[:, :3], axis=1).sum())


class Relay:
    """The search for a guidance, piece by piece.

    Args:
        performance: With a `Tracking` of the character whose pelvis nothing else holds.
        seed: The same gives the same guidance, bit for bit, on any number of threads.
        effort: How hard to try in every piece.
        threads: For the simulations.
        piece: Length of a piece [s]; what is little longer is one piece.
        ahead: How far beyond its end a piece is searched [s].

    Attributes:
        windows: Windows of the whole performance.
        done: What is done, or None.
        farthest: The run that came farthest in a first piece that was given up, or None.
        spent: Processor time of searches that this one goes on from [s].
        search: Of the piece at work.
        again: Whether the piece at work failed before.
        identity: What a search must share with the one whose checkpoint it goes on from.

    Raises:
        InvalidValue: Nothing tracks a clip there, the body has no legs, or the clip one frame.
    """

    def __init__(
        self,
        performance: Performance,
        *,
        seed: int = 0,
        effort: Effort | None = None,
        threads: int = 2,
        piece: float = PIECE,
        ahead: float = AHEAD,
    ):
        self.performance, self.seed, self.threads = performance, seed, threads
        self.effort = Effort() if effort is None else effort
        if performance.duration <= 0.0:
            raise InvalidValue(
                "The clip has 1 frame: there is nothing to perform; it must have at least 2."
            )
        dt = performance.scene.timestep
        self._every = max(1, round(self.effort.window / dt))
        self.windows = -(-performance.steps // self._every)
        self._piece, self._ahead, self._back, self._least = (
            max(1, round(span / (self._every * dt))) for span in (piece, ahead, BACK, LEAST)
        )
        self.done: Done | None = None
        self.spent = 0.0
        self.farthest: Done | None = None
        self._failed: tuple[Done | None, Done | None] | None = None
        self._worth = min(self.windows, max(1, round(WORTH / (self._every * dt))))
        self._short = False  # Whether the piece at work was made shorter.
        self.begin()
        self.identity = self._identity()

    @property
    def reached(self) -> int:
        """Windows that are done."""
        return 0 if self.done is None else len(self.done.guidance.offsets)

    @property
    def begun(self) -> float:
        """When the piece at work begins [s]."""
        return self.search.borders[0] * self.performance.scene.timestep

    @property
    def again(self) -> bool:
        """Whether the piece at work failed before."""
        return self._failed is not None or self._short

    @property
    def best(self) -> Guidance | None:
        """The guidance from the start as far as it goes, the piece at work included.

        Where no pass came to the end of the first piece, that of the run that came farthest, if it
        came half a second.
        """
        own = self._found(whole=True) if self.reached < self.windows else None
        before = self.done
        if self._failed is not None and own is None:
            before, own = self._failed
        whole = own if before is None else before if own is None else before.followed(own)
        if whole is None and self.fallen is not None:
            whole = self.fallen if len(self.fallen.guidance.offsets) >= self._worth else None
        return None if whole is None else self._told(whole.guidance)

    @property
    def fallen(self) -> Done | None:
        """The run that came farthest of those that did not come to the end of the first piece."""
        own, states = self.search.fallen, self.search.fallen_states
        if self.done is not None or own is None or states is None:
            return self.farthest
        if self.farthest and len(self.farthest.guidance.offsets) >= len(own.offsets):
            return self.farthest
        return Done(replace(own, found={**own.found, "pieces": 1}), states)

    def begin(self, done: Done | None = None, end: int | None = None) -> None:
        """Go to the piece after what is done; `end` is the window before which it hands over."""
        self.done, first, dt = done, 0, self.performance.scene.timestep
        start: dict[str, Any] = {}
        if done is not None:
            first = len(done.guidance.offsets)
            start = {"start": done.states.chosen([-1]), "offsets": done.guidance.offsets[-1]}
        if end is None:
            end = first + self._piece
            end = self.windows if end + self._piece // 2 >= self.windows else end
        self._end = end
        ahead = min(self._ahead, end - first)
        last = min((end + ahead) * self._every, self.performance.steps)
        assert first * self._every * dt < self.performance.duration
        self.search = Search(
            self.performance,
            seed=self.seed,
            effort=self.effort,
            threads=self.threads,
            stretch=Stretch(first=first * self._every, last=last, **start),
        )

    def passes(self, told: Callable[[int], None] | None = None) -> Iterator[None]:
        """Search piece after piece; yields after every pass.

        Args:
            told: Called with the number of windows passed so far in the pass at work.
        """
        while True:
            for _ in self.search.passes(lambda n: told(self.reached + n) if told else None):
                yield
            if not self._hand_over():
                return

    def _hand_over(self) -> bool:
        """Finish the piece at work, or try it again; whether there is anything left to do."""
        own, end = self._found(), self._end
        self.farthest = self.fallen
        if not (self.search.ladder.free or self.again or self.done is None):
            back = min(self._back, len(self.done.states.qpos) - 1, self.reached - 1)
            self._failed = self.done, own
            self.begin(self.done.until(self.reached - back), end)
            return True
        done = self._followed(self.done, own)
        if self._failed is not None:
            before, first = self._failed
            self._failed, other = None, self._followed(before, first)
            if done is None or (other is not None and other.held < done.held):
                done = other
            self.done = before
        self._short = done is None
        if done is None:
            length = (end - self.reached) // 2
            if length < self._least:
                return False
            self.begin(self.done, self.reached + length)
            return True
        if len(done.guidance.offsets) >= self.windows:
            self.done = done
            return False
        self.begin(done)
        return True

    def _identity(self) -> dict[str, Any]:
        """Plain values; a digest stands for the body and what it follows."""
        model, reference = self.search.model, self.search.reference
        digest = hashlib.sha256()
        for array in (
            *self.search.commands,
            *(reference.rotations, reference.root_positions),
            *(model.body_mass, model.actuator_gainprm, model.geom_size),
        ):
            digest.update(np.ascontiguousarray(array).tobytes())
        return {
            "seed": self.seed,
            "effort": asdict(self.effort),
            "windows": [self._every, self.windows, self._piece, self._ahead, self._back],
            "step": float(model.opt.timestep),
            "body and clip": digest.hexdigest(),
        }

    def _followed(self, before: Done | None, own: Done | None) -> Done | None:
        return own if before is None or own is None else before.followed(own)

    def _found(self, *, whole: bool = False) -> Done | None:
        """What the search at work has found, up to where it hands over."""
        guidance, states = self.search.best, self.search.states
        if guidance is None or states is None:
            return None
        last = len(guidance.offsets) if whole else self._end - self.reached
        rows = {name: getattr(guidance, name)[:last] for name in ROWS}
        found = {**guidance.found, "pieces": 1}
        tail = states.chosen(slice(max(0, last - self._back), last + 1))
        return Done(replace(guidance, **rows, found=found), tail)

    def _told(self, guidance: Guidance) -> Guidance:
        """With how much it helps, and when, in what is known of it."""
        scene = self.performance.scene
        weight = scene.characters[guidance.character].mass * abs(scene.gravity)
        percent = 100.0 * np.linalg.norm(guidance.help[:, :3], axis=1) / weight
        helped = [
            [
                round(float(t), 3)
                for t in (a * guidance.window, b * guidance.window, percent[a:b].mean())
            ]
            for a, b in _runs(percent > 0.0)
        ]
        found = {**guidance.found, "help_percent": float(percent.mean()), "helped": helped}
        return replace(guidance, found=found)


def _runs(flags: Any) -> list[tuple[int, int]]:
    """First and one after the last of every run of true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], np.asarray(flags, int), [0]))))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _sums(one: Guidance, other: Guidance) -> dict[str, Any]:
    """What is known of how two guidances were found, as of one: sums, and means by length."""
    a, b = len(one.offsets), len(other.offsets)
    sums = {n: one.found[n] + other.found[n] for n in ("pieces", "passes", "rounds")}
    means = {n: (a * one.found[n] + b * other.found[n]) / (a + b) for n in ("help_scale", "cost")}
    return {**sums, **means}
