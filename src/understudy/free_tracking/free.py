"""From a performance whose pelvis nothing holds to one that stays on its feet, and to its take."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from os import PathLike
from typing import Any, cast

from tqdm import tqdm

from understudy.character import Character
from understudy.control import (
    Compiled,
    Controller,
    GiveWay,
    Guidance,
    PythonController,
    Task,
    Tracking,
)
from understudy.edit import read_edit
from understudy.errors import InvalidValue, NotFound
from understudy.free_tracking.alone import by_itself, unheld
from understudy.free_tracking.checkpoint import restore, save
from understudy.free_tracking.passes import Effort
from understudy.free_tracking.relay import Relay
from understudy.motion.clip import Clip
from understudy.performance import FREE, Performance, tracked, until
from understudy.performance import FREE_STEP as STEP
from understudy.scene import timestep_for
from understudy.simulate import simulate
from understudy.simulate import track as tracked_take
from understudy.take import Take


def track(
    clip: Clip,
    character: Character,
    *,
    pelvis: str | None = None,
    seed: int = 0,
    budget: float | None = None,
    effort: Effort | None = None,
    threads: int | None = None,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
    **settings: Any,
) -> Take:
    """Make a character perform a clip.

    With pelvis "free" nothing holds the body up: a guidance is searched with which it performs the
    clip on its own feet, with the strength of a person and the least help if it cannot without
    (see `freed`). Otherwise this is `simulate(tracked(clip, character, ...))`; so it is with a task
    that keeps the balance itself.

    Args:
        clip: Any clip; it is repaired, retargeted and set on the ground first.
        character: Any character.
        pelvis: "led", "assisted" or "free"; see `understudy.performance.tracked`.
        seed: Of every random choice.
        budget: Seconds the search may take.
        effort: How hard it tries.
        threads: Of the search; all cores by default.
        checkpoint: File that keeps the search; see `freed`.
        progress: Show progress bars on standard error.
        settings: See `understudy.performance.tracked`. For a free body the defaults are soft
            servos, human torque limits, steps of 1/120 s and the discrete integrator.

    Raises:
        Diverged: The simulation blew up; carries the take up to then.
        NotFound: No pass of the search came half a second far.
    """
    balances = any(getattr(task, "pelvis", None) == "free" for task in settings.get("tasks", ()))
    if pelvis != "free" or balances:
        return tracked_take(
            clip, character, pelvis=pelvis, seed=seed, progress=progress, **settings
        )
    made = {"timestep": timestep_for(clip.rate, near=STEP), **FREE, **settings}
    performance = tracked(clip, character, pelvis="free", seed=seed, **made)
    found, spent = _guided(
        performance,
        budget=budget,
        effort=effort,
        threads=threads,
        checkpoint=checkpoint,
        progress=progress,
    )
    take = simulate(found, progress=progress)
    take.facts["search_cpu_seconds"] = spent
    return take


def perform(path: str | PathLike[str], *, progress: bool = False, **search: Any) -> Take:
    """Run what an edit file describes; a free pelvis is given a guidance first.

    Args:
        path: A TOML file; docs/edit_file.md has the format.
        progress: Show progress bars on standard error.
        search: See `freed`.

    Raises:
        EditError: The file cannot be read or performed; names the line.
        Diverged: The simulation blew up; carries the take up to then.
        NotFound: No pass of a search came half a second far.
    """
    performance = guided(read_edit(path).performance(), progress=progress, **search)
    return simulate(performance, progress=progress)


def guided(performance: Performance, **search: Any) -> Performance:
    """The performance with a guidance for every body that nothing holds up.

    Bodies whose pelvis is held, that balance by a task, or that have a guidance stay as they are;
    so does a performance without free bodies.

    Args:
        performance: Any.
        search: Keywords of `freed`; a checkpoint only where one body is free.

    Raises:
        NotFound: No pass of a search came half a second far.
    """
    return _guided(performance, **search)[0]


def _guided(performance: Performance, **search: Any) -> tuple[Performance, float]:
    """As `guided`, and the processor time of all searches, those gone on from included [s]."""
    controllers, duration = list(performance.controllers), performance.duration
    spent = 0.0
    for tracking in unheld(performance):
        alone, own = _freed(by_itself(performance, tracking), **search)
        spent += own
        guidance = cast(Guidance, alone.controllers[-1])
        guidance = replace(guidance, character=tracking.character)
        controllers.insert(_place(controllers, tracking), guidance)
        duration = min(duration, alone.duration)
    return until(replace(performance, controllers=tuple(controllers)), duration), spent


def _place(controllers: Sequence[Controller], tracking: Tracking) -> int:
    """After a character's tasks, so that its strength bounds them too, but before it gives way."""
    own = [
        k
        for k, one in enumerate(controllers)
        if one is tracking
        or (
            isinstance(one, Task)
            and not isinstance(one, GiveWay)
            and one.character == tracking.character
        )
    ]
    return max(own) + 1


def freed(
    performance: Performance,
    *,
    seed: int | None = None,
    budget: float | None = None,
    effort: Effort | None = None,
    threads: int | None = None,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
) -> Performance:
    """The performance with a guidance under which nothing need hold the body.

    Where no free run is found, the guidance is the one with the least help; its `help` says how
    much. Where no run came to the end, the performance is as short as the one that came farthest,
    if it came half a second. The same performance and seed give the same guidance, bit for bit.

    Args:
        performance: Of one character that tracks a clip with a free pelvis, without tasks.
        seed: By default the performance's.
        budget: Seconds the search may take once it is compiled; then the best so far counts.
        effort: How hard it tries.
        threads: All cores by default.
        checkpoint: File that keeps the search after every pass; the same call goes on from it.
        progress: Show a progress bar on standard error.

    Raises:
        InvalidValue: The performance has tasks, or nothing that tracks a clip freely; the seed is
            no whole number from 0 on.
        NotFound: No run came half a second far.
        UnderstudyError: The checkpoint is of another search.
    """
    return _freed(
        performance,
        seed=seed,
        budget=budget,
        effort=effort,
        threads=threads,
        checkpoint=checkpoint,
        progress=progress,
    )[0]


def _freed(
    performance: Performance,
    *,
    seed: int | None = None,
    budget: float | None = None,
    effort: Effort | None = None,
    threads: int | None = None,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
) -> tuple[Performance, float]:
    """As `freed`, and the processor time of the search, all its calls together [s]."""
    _check(performance)
    started = clock.process_time()
    relay = Relay(
        performance,
        seed=performance.seed if seed is None else seed,
        effort=effort,
        threads=threads or os.cpu_count() or 1,
    )
    if checkpoint is not None:
        restore(relay, checkpoint)
    timer, searched = _Timer(budget), False
    with _bar(relay, progress) as bar:

        def told(windows: int) -> None:
            bar.update(windows - bar.n)
            timer.check()

        try:
            for _ in relay.passes(told):
                searched = True
                if checkpoint is not None:
                    save(relay, checkpoint, spent=relay.spent + clock.process_time() - started)
                bar.set_description(_doing(relay))
        except _TimeIsUp:
            pass
    best = relay.best
    if best is None:
        raise NotFound(_nothing(relay, timer))
    if timer.over:
        best = replace(best, found={**best.found, "out_of_time_s": timer.budget})
    found = replace(performance, controllers=(*performance.controllers, best))
    found = until(found, min(performance.duration, len(best.offsets) * best.window))
    # To read a finished search again is no part of what it cost.
    again = relay.spent > 0.0 and not searched and not timer.over
    return found, relay.spent + (0.0 if again else clock.process_time() - started)


def _nothing(relay: Relay, timer: _Timer) -> str:
    """Why there is no guidance."""
    dt = relay.performance.scene.timestep
    first = (
        f"No pass of the search came to the end of the first {relay.search.borders[-1] * dt:.1f} s"
    )
    if timer.over:
        return f"{first} before the budget of {timer.budget:g} s was spent. Try a longer one."
    return f"{first}: the farthest fell at {relay.search.farthest:.1f} s. Try another seed."


class _TimeIsUp(Exception):
    """The budget is spent."""


class _Timer:
    """Raises `_TimeIsUp` when so many seconds have passed since the first check."""

    def __init__(self, budget: float | None):
        self.budget, self.over = budget, False
        self._end: float | None = None

    def check(self) -> None:
        if self.budget is None:
            return
        now = clock.monotonic()
        self._end = now + self.budget if self._end is None else self._end
        if now >= self._end:
            self.over = True
            raise _TimeIsUp


@contextmanager
def _bar(relay: Relay, progress: bool) -> Iterator[Any]:
    with tqdm(
        total=relay.windows,
        desc=_doing(relay),
        unit="window",
        delay=2.0,
        disable=None if progress else True,
        leave=False,
    ) as bar:
        yield bar


def _doing(relay: Relay) -> str:
    ladder = relay.search.ladder
    what = f"pass {ladder.tried + 1}, help {100.0 * ladder.scales.mean():.0f} %"
    what = "practice" if relay.search.practice_is_next else what
    return what if relay.done is None else f"from {relay.begun:.1f} s, {what}"


def _check(performance: Performance) -> None:
    for controller in performance.controllers:
        if isinstance(controller, Compiled | PythonController):
            raise InvalidValue(
                f"The performance has a {type(controller).__name__}; free it without, and add that "
                "to the result."
            )
        if getattr(controller, "pelvis", None) in ("led", "assisted"):
            raise InvalidValue("The pelvis is held; make the performance with pelvis='free'.")
