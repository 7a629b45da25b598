"""Practice gives feedback that answers pushes, and leaves the plan as it was."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import understudy as us
from understudy.control import Guidance, Push
from understudy.evaluate import following
from understudy.free_tracking import Effort, freed
from understudy.free_tracking.checkpoint import save
from understudy.free_tracking.free import FREE, STEP
from understudy.free_tracking.goal import Goal
from understudy.free_tracking.practice import Plan, practiced
from understudy.free_tracking.relay import Relay
from understudy.free_tracking.search import Search
from understudy.free_tracking.windows import Windows
from understudy.performance import Performance, tracked
from understudy.simulate import simulate


@pytest.fixture(scope="module")
def servos() -> Performance:
    clip = us.sample("walk").trimmed(1.0, 2.4)
    return tracked(clip, us.Character.from_clip(clip), pelvis="free", timestep=STEP, **FREE)


@pytest.fixture(scope="module")
def found(servos: Performance) -> dict[int, Performance]:
    """Without practice and with."""
    return {rounds: freed(servos, effort=Effort(rounds=rounds)) for rounds in (0, 4)}


def guidance_of(performance: Performance) -> Guidance:
    (one,) = (c for c in performance.controllers if isinstance(c, Guidance))
    return one


def test_the_plan_stays(found: dict[int, Performance]) -> None:
    before, after = guidance_of(found[0]), guidance_of(found[4])
    assert np.array_equal(before.offsets, after.offsets)
    assert np.array_equal(before.postures, after.postures)
    assert not np.array_equal(before.gains, after.gains)
    assert before.found["rounds"] == 0 and 2 <= after.found["rounds"] <= 4


def test_a_body_that_practiced_keeps_nearer_its_plan_when_pushed(
    found: dict[int, Performance],
) -> None:
    off = {}
    for rounds, performance in found.items():
        errors = []
        for x, y in ((9.0, 0.0), (-9.0, 0.0), (0.0, 9.0), (0.0, -9.0)):
            push = Push(time=0.3, on="pelvis", impulse=(x, y, 0.0))
            take = simulate(replace(performance, controllers=(*performance.controllers, push)))
            errors.append(following(take).com_mm)
        off[rounds] = float(np.mean(errors))
    assert off[4] < off[0]


def test_a_search_stopped_while_it_practices_keeps_its_run(
    servos: Performance, found: dict[int, Performance], tmp_path: Path
) -> None:
    relay, file = Relay(servos), tmp_path / "search.npz"

    def stop(_: int) -> None:
        if relay.search.practice_is_next:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        for _ in relay.passes(stop):
            save(relay, file)
    again = freed(servos, checkpoint=file)
    assert relay.search.ladder.tried == guidance_of(again).found["passes"]
    assert np.array_equal(guidance_of(again).gains, guidance_of(freed(servos)).gains)


def test_what_held_a_plan_is_not_taken_for_what_the_body_does(servos: Performance) -> None:
    search = Search(servos, effort=Effort(passes=1, rounds=0))
    for _ in search.passes():
        pass
    scene, course, best = servos.scene, search.course, search.best
    assert best is not None and search.states is not None and best.help.any()
    times = np.array(course.borders) * scene.timestep
    errors = []
    with Windows(search.model, search.layout, threads=1) as windows:
        body, part = scene.characters[0], scene.parts[0]
        goal = Goal.of(windows, search.reference, body, part, times)
        plan = Plan.of(course, goal, windows, best, search.states)
        course = replace(course, effort=Effort(rounds=4))
        _, dynamics, _ = practiced(course, goal, windows, plan, seed=0, told=lambda _: None)
        for w, one in enumerate(dynamics):
            assert one is not None
            z = np.concatenate((plan.off[w], plan.offsets[w]))
            told = one.state @ z + one.offsets @ plan.offsets[w + 1] + one.rest
            span = slice(*course.borders[w : w + 2])
            each = []
            for held in (np.zeros(6), plan.help[w]):
                start, offsets = plan.states.chosen([w]), plan.offsets[w + 1] * course.sigma
                commands = course.ctrl[span], course.applied[span]
                own = start, np.zeros(1, int), offsets[None], held[None]
                _, postures = windows.run(*own, *commands)
                off = goal.deviations(postures, w + 1)[0] - told
                each.append(goal.costs(off[None])[0])
            errors.append(each)
    without, held = np.mean(errors, axis=0)
    assert without < 0.7 * held
