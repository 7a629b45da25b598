"""Free bodies get their guidance by themselves, and live with what else a performance has."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import understudy as us
from understudy.control import Guidance, LookAt, Push, Throw, Tracking
from understudy.free_tracking import Effort, guided, perform, track
from understudy.free_tracking.alone import by_itself, unheld
from understudy.performance import FREE, FREE_STEP, Performance, together, tracked
from understudy.scene import Ball, Staff
from understudy.simulate import simulate

SMALL = Effort(children=60, elites=40)
EDIT = """
[[character]]
clip = "sample:gesture"
trim = [0.8, 1.6]
pelvis = "free"

  [[character.task]]
  kind = "look_at"
  target = "ball/center"

[[prop]]
kind = "ball"
position = [3.0, 0.4, 1.5]
mass = 0.4

[[push]]
time = 0.2
on = "chest"
impulse = [-6.0, 0.0, 0.0]

[[throw]]
time = 0.6
ball = "ball"
at = "chest"
flight = 0.4

[give_way]
"""


def free(at: tuple[float, float], **settings: object) -> Performance:
    clip = us.sample("gesture").trimmed(0.8, 1.4).placed(at=at)
    body = us.Character.from_clip(clip)
    made = {**FREE, "timestep": FREE_STEP, **settings}
    return tracked(clip, body, pelvis="free", **made)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("edit") / "hit.toml"
    path.write_text(EDIT, encoding="utf-8")
    return path


def test_an_edit_of_a_free_body_is_pushed_and_hit_and_stands(file: Path) -> None:
    take = perform(file, effort=SMALL)
    assert take.performance is not None
    kinds = [type(one).__name__ for one in take.performance.controllers]
    assert kinds == ["Tracking", "LookAt", "Guidance", "Push", "Throw", "GiveWay"]
    score = us.score(take)
    assert score.fully_physical and score.fell_s is None
    assert take.facts["torque_limits"] == "human"
    assert score.joint_position_mm is not None and score.joint_position_mm < 40.0


def test_a_body_is_freed_without_tasks_and_props_but_with_what_it_holds() -> None:
    one = free((0.0, 0.0))
    scene = replace(
        one.scene,
        props=(Ball(position=(2.0, 0.0, 1.0)), Staff(held_by="right_hand")),
        contacts=(("chest", "ball"),),
    )
    whole = replace(one, scene=scene, controllers=(*one.controllers, LookAt(target="ball/center")))
    (tracking,) = unheld(whole)
    alone = by_itself(whole, tracking)
    assert [type(prop) for prop in alone.scene.props] == [Staff]
    assert alone.scene.contacts == ()
    assert alone.controllers == (tracking,)


def test_two_free_bodies_get_a_guidance_each() -> None:
    both = together(free((0.0, 0.0)), free((2.0, 0.0)))
    found = guided(both, effort=SMALL)
    assert [type(one) for one in found.controllers] == [Tracking, Guidance] * 2
    first, second = (one for one in found.controllers if isinstance(one, Guidance))
    assert (first.character, second.character) == (0, 1)
    # The second stands 2 m from the first: the same search in another place.
    away = second.postures[0, :3] - first.postures[0, :3]
    assert away == pytest.approx([2.0, 0.0, 0.0], abs=1e-6)
    take = simulate(found)
    for part in take.scene.parts:
        assert np.abs(take.qpos[-1, part.qpos][2] - take.qpos[0, part.qpos][2]) < 0.05


def test_who_is_held_or_guided_already_stays_as_he_is() -> None:
    held = free((0.0, 0.0), servos="stiff")
    (tracking,) = held.controllers
    held = replace(held, controllers=(replace(tracking, pelvis="assisted"),))  # type: ignore[call-arg]
    assert guided(held) is held or guided(held).controllers == held.controllers


def test_tasks_and_disturbances_of_track_act_on_a_free_body() -> None:
    clip = us.sample("gesture").trimmed(0.8, 1.4)
    take = track(
        clip,
        us.Character.from_clip(clip),
        pelvis="free",
        effort=SMALL,
        tasks=[
            LookAt(target="ball/center"),
            Push(time=0.1, impulse=(5.0, 0.0, 0.0)),
            Throw(time=0.5, flight=0.3),
        ],
        props=[Ball(position=(2.0, 0.0, 1.0), mass=0.3)],
        contacts=(("chest", "ball"),),
    )
    assert us.score(take).fell_s is None
