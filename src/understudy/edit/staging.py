"""An edit as a performance: motions on their bodies, hands placed, tasks fitted, one scene."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, cast

import numpy as np

from understudy.character import Character
from understudy.control import Disturbance, GiveWay, Push, Task, Throw, Tracking
from understudy.control.task import check_overlaps
from understudy.edit.edit import Edit, Performer
from understudy.edit.lines import Place
from understudy.edit.motions import motion_of
from understudy.errors import UnderstudyError, UnknownName
from understudy.motion.clip import Clip
from understudy.motion.reaching import meeting, reaching
from understudy.performance import FREE, FREE_STEP, Performance, together, tracked
from understudy.scene import Scene, timestep_for

NARROW = 0.2
"""Two characters whose roots begin nearer to each other than this stand in each other [m]."""


def staged(edit: Edit) -> Performance:
    """The performance of an edit; raises as `Edit.performance`."""
    alone = _alone(edit)
    _check_apart(edit, alone)
    references = [_tracking(one).reference for one in alone]
    _place_hands(edit, references)
    tasks = _fitted_tasks(edit, alone, references)
    for k, (one, reference) in enumerate(zip(alone, references, strict=True)):
        tracking = replace(_tracking(one), reference=reference)
        alone[k] = replace(one, controllers=(tracking, *tasks[k]), duration=reference.duration)
    whole = alone[0] if len(alone) == 1 else together(*alone)
    scene = _furnished(edit, whole.scene)
    lasts = whole.duration if edit.duration is None else edit.duration
    if round(lasts / scene.timestep) < 1:
        raise edit.source.error(
            ("duration",), f"The performance lasts {lasts:g} s, not one step; give it a duration."
        )
    _check_times(edit, lasts)
    happening = _happening(edit, scene, references)
    for k, own in enumerate(tasks):
        for j, task in enumerate(own):
            _check(edit, replace(task, character=k), scene, ("character", k, "task", j))
    with edit.source.blaming(()):
        return replace(
            whole,
            scene=scene,
            controllers=(*whole.controllers, *happening),
            duration=lasts,
        )


def _check_times(edit: Edit, lasts: float) -> None:
    """Refuse what would happen after the end."""
    wanted = [(push.time, ("push", k, "time")) for k, push in enumerate(edit.push)]
    wanted += [(throw.time, ("throw", k, "time")) for k, throw in enumerate(edit.throw)]
    wanted += [
        (task.span[0], ("character", k, "task", j, "span"))
        for k, said in enumerate(edit.character)
        for j, task in enumerate(said.task)
    ]
    for place, one in _giving_way(edit):
        wanted += [(time, (*place, "hits")) for time in one.hits]
        wanted += [(time, (*place, "touches")) for _, time in one.touches]
    for time, place in wanted:
        if time >= lasts and place[-1] in ("hits", "touches"):
            raise edit.source.error(
                place, f"{place[-1]} has {time:g} s; the performance lasts {lasts:g} s."
            )
        if time >= lasts:
            raise edit.source.error(
                place, f"{place[-1]} begins at {time:g} s; the performance lasts {lasts:g} s."
            )


def _giving_way(edit: Edit) -> list[tuple[Place, GiveWay]]:
    """Whatever gives way to hits, and where the file says so."""
    found: list[tuple[Place, GiveWay]] = [
        (("character", k, "task", j), task)
        for k, said in enumerate(edit.character)
        for j, task in enumerate(said.task)
        if isinstance(task, GiveWay)
    ]
    return [*found, *([] if edit.give_way is None else [(("give_way",), edit.give_way)])]


def _check_hit(edit: Edit, hit: bool) -> None:
    """Refuse to give way to nothing; `hit` is whether a push or a throw concerns anybody."""
    for place, one in _giving_way(edit):
        if one.hits or one.touches:
            continue
        if place != ("give_way",):
            raise edit.source.error(
                place, "A give_way task needs the times of the hits, hits = [1.2]."
            )
        if not hit:
            raise edit.source.error(
                place,
                "Nothing hits anybody, so there is nothing to give way to: add a [[push]] or a "
                "[[throw]] at a body, or the times of the hits, hits = [1.2].",
            )


def _alone(edit: Edit) -> list[Performance]:
    """Every character tracking its motion by itself, with nothing else to do."""
    found: list[Performance] = []
    free = [_nothing_holds(said) for said in edit.character]
    for k, said in enumerate(edit.character):
        if free[k] and said.plan.startswith("upper"):
            raise edit.source.error(
                ("character", k, "plan"),
                f"plan {said.plan!r} leaves the legs out; only a body with legs can be free.",
            )
        motion, body = motion_of(edit, k)
        pelvis = said.pelvis or next((t.pelvis for t in said.task if t.pelvis), None)
        step = found[0].scene.timestep if found else edit.timestep
        if step is None and any(free):
            step = timestep_for(motion.rate, near=FREE_STEP)
        physics = FREE if free[k] else {"integrator": FREE["integrator"]} if any(free) else {}
        with edit.source.blaming(("character", k)):
            found.append(
                tracked(
                    motion,
                    body,
                    pelvis=pelvis,
                    ground=edit.ground,
                    timestep=step,
                    self_collision=edit.self_collision,
                    seed=edit.seed,
                    **{**said.settings, **physics},
                )
            )
    return found


def _nothing_holds(said: Performer) -> bool:
    """Whether a character is free, and no task balances it."""
    return said.pelvis == "free" and not any(task.pelvis == "free" for task in said.task)


def _tracking(performance: Performance) -> Tracking:
    return cast(Tracking, performance.controllers[0])


def _check_apart(edit: Edit, alone: Sequence[Performance]) -> None:
    """Refuse two characters that stand in each other."""
    starts = [_tracking(one).reference.root_positions[0, :2] for one in alone]
    for (i, a), (j, b) in combinations(enumerate(starts), 2):
        if np.linalg.norm(a - b) < NARROW:
            raise edit.source.error(
                ("character", j, "at"),
                f"Characters {i + 1} and {j + 1} both begin at ({b[0]:.2f}, {b[1]:.2f}) m; put one "
                "somewhere else, as at = [0.9, 0.0] and heading = 180.",
            )


# -- hands -------------------------------------------------------------------------------------


def _place_hands(edit: Edit, references: list[Clip]) -> None:
    """Change the references so that hands are where offsets and meetings want them."""
    _check_hand_times(edit, references)
    for k, said in enumerate(edit.character):
        targets = [offset.target(said.speed) for offset in said.offset]
        try:
            references[k] = reaching(references[k], targets)
        except UnderstudyError:
            for j, target in enumerate(targets):  # whose fault it is, each by itself first
                with edit.source.blaming(("character", k, "offset", j)):
                    reaching(references[k], [target])
            for j in range(1, len(targets)):
                with edit.source.blaming(("character", k, "offset", j)):
                    reaching(references[k], targets[: j + 1])
            raise
    pairs = dict.fromkeys(meet.characters for meet in edit.meet)
    for pair in pairs:
        numbers = [k for k, meet in enumerate(edit.meet) if meet.characters == pair]
        _meet(edit, references, numbers, pair[0] - 1, pair[1] - 1)


def _check_hand_times(edit: Edit, references: Sequence[Clip]) -> None:
    """Refuse hands to be placed after the motion, by the motion's own clock."""
    wanted = [
        (offset.time, ("character", k, "offset", j), k)
        for k, said in enumerate(edit.character)
        for j, offset in enumerate(said.offset)
    ]
    wanted += [
        (meet.time, ("meet", j), who - 1)
        for j, meet in enumerate(edit.meet)
        for who in meet.characters
    ]
    for time, place, who in wanted:
        last = references[who].duration * edit.character[who].speed
        if time > last + 0.5 / references[who].rate:
            raise edit.source.error(
                (*place, "time"),
                f"time is {time:g} s; the motion of character {who + 1} lasts {last:g} s (before "
                "its speed).",
            )


def _meet(edit: Edit, references: list[Clip], numbers: list[int], one: int, two: int) -> None:
    """Let hands of one pair of characters come together."""
    meets = [edit.meet[k].meet(edit.character[one].speed) for k in numbers]
    try:
        references[one], references[two] = meeting(references[one], references[two], meets)
    except UnderstudyError:
        for end in (1, None):  # each by itself, then with all before it
            for j, k in enumerate(numbers):
                with edit.source.blaming(("meet", k)):
                    some = meets[j : j + 1] if end else meets[: j + 1]
                    meeting(references[one], references[two], some)
        raise


# -- tasks -------------------------------------------------------------------------------------


def _fitted_tasks(
    edit: Edit, alone: Sequence[Performance], references: list[Clip]
) -> list[list[Task]]:
    """Every character's tasks, made ready; they may change the references."""
    every: list[list[Task]] = []
    for k, said in enumerate(edit.character):
        body, own = cast(Character, alone[k].scene.characters[0]), []
        for j, task in enumerate(said.task):
            with edit.source.blaming(("character", k, "task", j)):
                fitted, references[k] = task.fitted(references[k], body)
                own.append(fitted)
                check_overlaps(own)
        every.append(own)
    return every


def _check(edit: Edit, one: Task | Disturbance, scene: Scene, place: Place) -> None:
    """Let a task or a disturbance look at the scene, as it will before it is simulated."""
    with edit.source.blaming(place):
        one.configure(scene, copy.copy(scene.model))


# -- the scene ---------------------------------------------------------------------------------


def _furnished(edit: Edit, scene: Scene) -> Scene:
    """The scene with props and contacts."""
    try:
        whole = replace(scene, props=edit.prop, contacts=edit.contacts)
        _ = whole.model
    except UnderstudyError:
        for k in range(len(edit.prop)):
            with edit.source.blaming(("prop", k)):
                _ = replace(scene, props=edit.prop[: k + 1]).model
        pairs = edit.contacts if isinstance(edit.contacts, tuple) else ()
        for k, pair in enumerate(pairs):
            with edit.source.blaming(("contacts", k)):
                _ = replace(scene, props=edit.prop, contacts=(pair,)).model
        with edit.source.blaming(("contacts",)):
            raise
    return whole


def _happening(edit: Edit, scene: Scene, references: Sequence[Clip]) -> list[Any]:
    """Pushes, throws, and how each character gives way to those that concern it."""
    found: list[Any] = []
    hits: list[list[Push | Throw]] = [[] for _ in references]
    for k, push in enumerate(edit.push):
        _check(edit, push, scene, ("push", k))
        found.append(push)
        for who in _concerned(scene, push):
            hits[who].append(push)
    for k, throw in enumerate(edit.throw):
        place = ("throw", k)
        concerned = _concerned(scene, throw)
        if isinstance(throw.at, str):
            with edit.source.blaming(place):
                throw = _aimed(throw, scene, concerned, references)
        _check(edit, throw, scene, place)
        found.append(throw)
        for who in concerned:
            hits[who].append(throw)
    if edit.give_way is not None:
        for who, own in enumerate(hits):
            said, felt = edit.give_way, GiveWay.after(*own)
            one = replace(
                said,
                character=who,
                hits=(*said.hits, *felt.hits),
                touches=(*said.touches, *felt.touches),
            )
            _check(edit, one, scene, ("give_way",))
            found.append(one)
    _check_hit(edit, any(hits))
    return found


def _aimed(
    throw: Throw, scene: Scene, concerned: Sequence[int], references: Sequence[Clip]
) -> Throw:
    """A throw at a link, led to where that is when the ball arrives."""
    if not concerned:
        links = [
            scene.prefix(k) + link.name
            for k, body in enumerate(scene.characters)
            for link in body.links
        ]
        raise UnknownName("link to throw at", str(throw.at), links)
    who = concerned[0]
    own = replace(throw, at=str(throw.at).rpartition("/")[2], character=who)
    return own.fitted(references[who], cast(Character, scene.characters[who]))[0]


def _concerned(scene: Scene, one: Push | Throw) -> list[int]:
    """Numbers of the characters that a push or a throw hits: by the names of links in the scene.

    A throw at a point may hit anybody.
    """
    everybody = list(range(len(scene.characters)))
    name = one.on if isinstance(one, Push) else one.at
    if not isinstance(name, str):
        return everybody
    held = {getattr(p, "name", ""): getattr(p, "held_by", None) for p in scene.props}
    name = held.get(name) or name
    return [
        who
        for who in everybody
        if name in {scene.prefix(who) + link.name for link in scene.characters[who].links}
    ]
