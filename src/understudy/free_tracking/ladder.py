"""Down the ladder of help, every window by itself, to none; up again where it failed.

A window that was passed goes a step down; once all were, and no pass fell, fewer children do. Where
a pass fell, the windows shortly before go half way back to what worked, to whole help where nothing
did. A pass that stayed near its goal spares the last rung; one that came through far from it is
tried again once as it was, to learn before help is taken.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from understudy.motion.rotations import Array

_RUNGS = (0.3, 0.1, 0.0)
_EASY = 2.5  # Mean cost of a pass that stayed near its goal.
_ROUGH = 8.0  # Mean cost of one that came through far off.
_NEAR = 0.05  # Closer than this to what worked, what worked is tried again.
_MORE, _MOST = 1.3, 2.0  # More children after a fall, at most so many times.
_FEWER = 0.6  # So many times the children after a pass that came through, if none fell.
# A fall has its cause in so many windows before it began: what was learned there is no good.
MARGIN = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class Ladder:
    """What to try next.

    Attributes:
        children: Samples of a window.
        usual: As many in the first pass.
        scales: Help of every window in the next pass: 1 is whole, 0 none.
        worked: The last help with which a window was passed; infinite if it never was.
        tried: Passes so far.
        rough: Whether the last pass came through far off, and is tried again.
        free: Whether a pass without any help came to the end.
        steady: Whether no pass fell.
    """

    children: int
    usual: int
    scales: Array
    worked: Array
    tried: int = 0
    rough: bool = False
    free: bool = False
    steady: bool = True

    @property
    def fell(self) -> bool:
        """Whether the last pass fell."""
        return self.children > self.usual

    @property
    def _enough(self) -> int:
        """Children after a pass that came through."""
        return round(_FEWER * self.usual) if self.steady else self.usual

    @classmethod
    def first(cls, windows: int, children: int) -> Ladder:
        """The first try: the same help everywhere."""
        first, never = np.full(windows, _RUNGS[0]), np.full(windows, np.inf)
        return cls(children=children, usual=children, scales=first, worked=never)

    def after(self, reached: int, *, strayed: int | None = None, cost: float = np.inf) -> Ladder:
        """The ladder after a pass.

        Args:
            reached: Windows to whose end it came.
            strayed: Where it began to fall; by default there.
            cost: Mean cost of its best run's deviations.
        """
        windows = len(self.scales)
        through = reached == windows
        free = through and not self.scales.any()
        if through and not free and not self.rough and _ROUGH < cost < np.inf:
            again = {"tried": self.tried + 1, "worked": self.scales, "rough": True}
            return replace(self, children=self._enough, **again)
        fell = reached if strayed is None else strayed
        good = windows if through else max(0, fell - MARGIN)
        scales, worked = self.scales.copy(), self.worked.copy()
        worked[:good] = scales[:good]
        rungs = (_RUNGS[0], _RUNGS[-1]) if cost < _EASY else _RUNGS
        scales[:good] = [max(s for s in rungs if s < own or s == 0.0) for own in scales[:good]]
        children = self._enough
        if not through:
            bad = slice(good, min(reached + 1, windows))
            known = np.where(np.isfinite(worked[bad]), worked[bad], 1.0)
            near = known - scales[bad] < _NEAR
            scales[bad] = np.where(near, known, 0.5 * (scales[bad] + known))
            more = round(_MORE * max(self.children, self.usual))
            children = min(more, round(_MOST * self.usual))
        return replace(
            self,
            children=children,
            scales=scales,
            worked=worked,
            tried=self.tried + 1,
            rough=False,
            free=free,
            steady=self.steady and through,
        )
