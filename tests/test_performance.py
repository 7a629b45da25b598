"""Performances with props and tasks, and several of them together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character import adult_man, child
from understudy.control import Balance, LookAt, Push, Throw, Tracking, Upright
from understudy.errors import InvalidValue
from understudy.performance import together, tracked, until
from understudy.scene import Ball, Drum, Ground, Staff


@pytest.fixture(scope="module")
def clip() -> us.Clip:
    return us.sample("clapping").trimmed(0.0, 0.6)


@pytest.fixture(scope="module")
def facing(clip) -> us.Clip:
    return clip.placed(at=(1.2, 0.0), heading=np.pi)


def test_two_performances_together_move_as_each_alone(clip, facing):
    one, two = tracked(clip, adult_man()), tracked(facing, child())
    take = us.simulate(together(one, two))
    for k, alone in enumerate((us.simulate(one), us.simulate(two))):
        part, own = take.scene.parts[k], alone.scene.parts[0]
        np.testing.assert_allclose(take.qpos[:, part.qpos], alone.qpos[:, own.qpos], atol=1e-6)
        assert us.score(take, character=k).joint_error_deg == pytest.approx(
            us.score(alone).joint_error_deg, abs=1e-3
        )


def test_controllers_props_and_contacts_go_with_their_characters(clip, facing):
    one = tracked(
        clip, adult_man(), props=[Drum(position=(0.4, 0.0, 0.9))], contacts=[("right_hand", "drum")]
    )
    two = tracked(
        facing,
        child(),
        props=[Staff(held_by="left_hand")],
        tasks=[Upright(hand="left")],
        contacts=[("right_hand", "staff")],
    )
    both = together(one, two, contacts=[("head", "b/right_hand")])
    assert [type(c) for c in both.controllers] == [Tracking, Tracking, Upright]
    assert [c.character for c in both.controllers] == [0, 1, 1]
    assert [p.name for p in both.scene.props] == ["drum", "staff"]
    assert both.scene.props[1].held_by == "b/left_hand"
    assert both.scene.contacts == (
        ("right_hand", "drum"),
        ("b/right_hand", "staff"),
        ("head", "b/right_hand"),
    )
    assert np.isfinite(us.simulate(both).qpos).all()


def test_three_go_together_whoever_is_joined_first(clip, facing):
    makers = [tracked(clip.placed(at=(x, 0.0)), child()) for x in (0.0, 1.0, 2.0)]
    staffs = [
        tracked(clip.placed(at=(x, 0.0)), child(), props=[Staff(name=f"staff{x}")])
        for x in (0.0, 1.0, 2.0)
    ]
    flat = together(*makers)
    nested = together(together(makers[0], makers[1]), makers[2])
    assert [c.character for c in nested.controllers] == [c.character for c in flat.controllers]
    holders = [p.held_by for p in together(staffs[0], together(staffs[1], staffs[2])).scene.props]
    assert holders == ["right_hand", "b/right_hand", "c/right_hand"]


def test_the_shorter_one_holds_its_last_pose(clip, facing):
    take = us.simulate(
        together(tracked(clip, adult_man()), tracked(facing.trimmed(0.0, 0.2), child()))
    )
    assert take.duration == pytest.approx(0.6)
    part = take.scene.parts[1]
    moved = take.qpos[take.times > 0.45][:, part.qpos]
    assert np.ptp(moved, axis=0).max() < 0.02


def test_performances_that_do_not_fit_are_refused(clip, facing):
    one = tracked(clip, adult_man())
    with pytest.raises(InvalidValue, match="was given 1 performances; it needs two"):
        together(one)
    with pytest.raises(InvalidValue, match="differ in timestep"):
        together(one, tracked(facing, child(), timestep=0.001))
    with pytest.raises(InvalidValue, match="differ in ground"):
        together(one, tracked(facing, child(), ground=Ground(friction=0.5)))
    with pytest.raises(InvalidValue, match=r"performance is Clip.*; it must be a Performance"):
        together(one, facing)  # type: ignore[arg-type]


def test_tasks_for_all_can_be_given_to_the_whole(clip, facing):
    both = together(
        tracked(clip, adult_man()),
        tracked(facing, child()),
        tasks=[
            LookAt(character=1, target="right_palm"),
            Push(time=0.1, on="b/chest", impulse=(5, 0, 0)),
        ],
    )
    take = us.simulate(both)
    assert take.xfrc_applied[:, take.model.body("b/chest").id, 0].max() > 0.0
    assert not take.xfrc_applied[:, take.model.body("chest").id].any()


def test_a_loose_prop_leaves_the_characters_coordinates_where_they_are(clip):
    take = us.track(clip, adult_man(), props=[Ball(position=(2.0, 0.0, 0.5))])
    plain = us.track(clip, adult_man())
    part = take.scene.parts[0]
    assert part.qpos == plain.scene.parts[0].qpos
    np.testing.assert_allclose(take.qpos[:, part.qpos], plain.qpos, atol=1e-9)


def test_without_contacts_a_prop_is_passed_through(clip):
    drum = Drum(position=(0.3, 0.0, 1.15))
    performance = tracked(clip, adult_man(), props=[drum], contacts="all")
    through = replace(performance, scene=replace(performance.scene, contacts=()))
    hit, passed = us.simulate(performance), us.simulate(through)
    assert np.abs(hit.qpos - passed.qpos).max() > 1e-3
    np.testing.assert_allclose(passed.qpos, us.track(clip, adult_man()).qpos, atol=1e-9)


def test_a_led_pelvis_and_balance_do_not_go_together(clip):
    with pytest.raises(InvalidValue, match="Balance: pelvis is 'led', which holds the body up"):
        tracked(clip, adult_man(), pelvis="led", tasks=[Balance()])


def test_balance_of_an_upper_body_says_that_it_has_no_legs(clip):
    with pytest.raises(InvalidValue, match="plan 'upper', which has no legs: use 'full'"):
        tracked(clip, adult_man(plan="upper"), tasks=[Balance()])


@pytest.mark.parametrize("time", [0.6, 5.0])
def test_what_comes_after_the_end_is_refused(clip, time):
    push = Push(time=time, impulse=(5, 0, 0))
    with pytest.raises(
        InvalidValue, match=rf"Push: begins at {time:g} s; the performance lasts 0\.6"
    ):
        tracked(clip, adult_man(), tasks=[push])
    made = tracked(clip, adult_man())
    with pytest.raises(InvalidValue, match=r"the performance lasts 0\.6 s"):
        replace(made, controllers=(*made.controllers, push))
    with pytest.raises(InvalidValue, match=r"Throw: begins at 0\.7 s"):
        replace(made, controllers=(*made.controllers, Throw(time=1.2, at=(0, 0, 1))))


def test_a_performance_cut_short_leaves_out_what_comes_later(clip):
    pushes = [Push(time=time, impulse=(5, 0, 0)) for time in (0.1, 0.3)]
    short = until(tracked(clip, adult_man(), tasks=pushes), 0.3)
    assert short.duration == 0.3
    assert [c.time for c in short.controllers if isinstance(c, Push)] == [0.1]
