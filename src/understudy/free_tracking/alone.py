"""Who in a performance is to be free, and each of them by himself.

A body is given its guidance alone, on the same ground and with what it holds. What else the
performance has, tasks, other props, pushes and other bodies, happens to it then as a disturbance,
which the guidance's feedback answers.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

from understudy.control import Guidance, Task, Tracking
from understudy.performance import Performance
from understudy.scene import Prop, Scene


def unheld(performance: Performance) -> list[Tracking]:
    """What tracks a clip with a free pelvis, unless a task balances the body."""
    controllers = performance.controllers
    taken = {c.character for c in controllers if isinstance(c, Guidance)}
    taken |= {c.character for c in controllers if isinstance(c, Task) and c.pelvis == "free"}
    return [
        c
        for c in controllers
        if isinstance(c, Tracking) and c.pelvis == "free" and c.character not in taken
    ]


def by_itself(performance: Performance, tracking: Tracking) -> Performance:
    """One body of a performance tracking its clip, with what it holds and nothing else."""
    scene, k = performance.scene, tracking.character
    return replace(
        performance,
        scene=replace(scene, characters=(scene.characters[k],), props=_held(scene, k), contacts=()),
        controllers=(replace(tracking, character=0),),
    )


def _held(scene: Scene, character: int) -> tuple[Prop, ...]:
    """Props in the hands of one character, by its own links' names."""
    prefix, found = scene.prefix(character), []
    links = {link.name for link in scene.characters[character].links}
    for prop in scene.props:
        holder = getattr(prop, "held_by", None) or ""
        if holder.startswith(prefix) and holder.removeprefix(prefix) in links:
            found.append(replace(cast(Any, prop), held_by=holder.removeprefix(prefix)))
    return tuple(found)
