"""A body that plans anew does as its guidance while it is on its plan, else better."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import understudy as us
from understudy.control import Push
from understudy.errors import InvalidValue
from understudy.free_tracking import Effort, Foresight, freed, replanned
from understudy.free_tracking.replanning import Replanning
from understudy.performance import FREE, FREE_STEP, Performance, together, tracked
from understudy.simulate import simulate
from understudy.take import Take

QUICK = Foresight(windows=6, children=40, elites=20)


@pytest.fixture(scope="module")
def guided() -> Performance:
    clip = us.sample("walk").trimmed(1.0, 1.5)
    body = us.Character.from_clip(clip)
    servos = tracked(clip, body, pelvis="free", timestep=FREE_STEP, **FREE)
    return freed(servos, effort=Effort(children=60, elites=40))


@pytest.fixture(scope="module")
def planning(guided: Performance) -> Performance:
    return replanned(guided, QUICK)


def pushed(performance: Performance, x: float = 0.0, y: float = 20.0) -> Take:
    push = Push(time=0.1, on="pelvis", impulse=(x, y, 0.0))
    return simulate(replace(performance, controllers=(*performance.controllers, push)))


def off(take: Take, planned: Take) -> float:
    """Where the pelvis is going to be, off the plan [m]."""
    place, speed = take.qpos[-1] - planned.qpos[-1], take.qvel[-1] - planned.qvel[-1]
    return float(np.linalg.norm(place[:2] + speed[:2] / 3.3))


def test_on_its_plan_a_body_does_not_plan(guided: Performance, planning: Performance) -> None:
    (one,) = (c for c in planning.controllers if isinstance(c, Replanning))
    assert np.array_equal(simulate(planning).qpos, simulate(guided).qpos)
    assert one.function.planned == 0  # type: ignore[attr-defined]


def test_a_body_pushed_far_plans_anew_and_is_nearer_in_the_end(
    guided: Performance, planning: Performance
) -> None:
    planned, sides = simulate(guided), ((20.0, 0.0), (-20.0, 0.0), (0.0, 20.0), (0.0, -20.0))
    takes = [pushed(planning, *side) for side in sides]
    (one,) = (c for c in planning.controllers if isinstance(c, Replanning))
    assert one.function.planned > 0  # type: ignore[attr-defined]
    assert takes[0].facts["replanning"]["windows"] == 6
    anew = np.mean([off(take, planned) for take in takes])
    assert anew < np.mean([off(pushed(guided, *side), planned) for side in sides])


def test_planning_anew_is_the_same_every_time(planning: Performance) -> None:
    assert np.array_equal(pushed(planning).qpos, pushed(planning).qpos)


def test_a_take_file_keeps_how_it_plans(planning: Performance, tmp_path: Path) -> None:
    take = pushed(planning)
    us.write(take, tmp_path / "pushed.take.npz")
    again = us.load_take(tmp_path / "pushed.take.npz").performance
    assert again is not None
    assert np.array_equal(simulate(again).qpos, take.qpos)
    (one,) = (c for c in again.controllers if isinstance(c, Replanning))
    assert one.foresight == QUICK and one.function.planned > 0


def test_a_second_body_plans_in_its_own_place(guided: Performance) -> None:
    clip = us.sample("walk").trimmed(1.0, 1.5).placed(at=(0.0, 3.0))
    body = us.Character.from_clip(clip)
    other = tracked(clip, body, timestep=FREE_STEP, integrator="discrete")
    alone, both = simulate(replanned(guided, QUICK)), together(other, guided)
    take = simulate(replanned(both, QUICK))
    part = take.scene.parts[1]
    assert take.qpos[:, part.qpos] == pytest.approx(alone.qpos, abs=1e-3)


def test_what_is_not_guided_cannot_plan(guided: Performance) -> None:
    servos = replace(guided, controllers=guided.controllers[:1])
    with pytest.raises(InvalidValue, match="Nothing in the performance is guided"):
        replanned(servos)


@pytest.mark.parametrize("wrong", [{"elites": 0}, {"windows": 0}, {"alarm": -1.0}])
def test_foresight_checks_itself(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidValue, match=f"{next(iter(wrong))} is"):
        Foresight(**wrong)  # type: ignore[arg-type]
