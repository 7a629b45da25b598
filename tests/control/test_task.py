"""What tasks share: spans, joints, overlaps, commands; and the compiled law is the plain one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character import adult_man
from understudy.control import GiveWay, LookAt, PythonController, Reach, Upright
from understudy.control.task import TIMES, weight_at
from understudy.errors import InvalidValue, UnknownName
from understudy.scene import Staff


@pytest.fixture(scope="module")
def clip() -> us.Clip:
    return us.sample("gesture").trimmed(0.0, 1.0).resampled(60.0)


def test_a_task_eases_in_and_out_of_its_span():
    parameters = np.array([1.0, 3.0, 0.5])
    assert len(parameters) == TIMES
    times = (0.9, 1.0, 1.25, 1.5, 2.0, 2.75, 3.0, 3.5)
    weights = [weight_at(time, parameters) for time in times]
    np.testing.assert_allclose(weights, [0, 0, 0.5, 1, 1, 0.5, 0, 0], atol=1e-12)


def test_a_span_without_end_holds_to_the_end():
    assert weight_at(1e6, np.array([0.0, np.inf, 0.3])) == 1.0


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"span": (2.0, 1.0)}, "span is 2 to 1 s"),
        ({"span": (-1.0, 1.0)}, "span is -1 to 1 s"),
        ({"span": (np.nan, 1.0)}, "span is nan"),
        ({"span": 3.0}, "span is 3.0; it must be two times"),
        ({"ease": -0.1}, "ease is -0.1 s"),
        ({"ease": np.nan}, "ease is nan s"),
        ({"hand": "both"}, "hand is 'both'; it must be 'left' or 'right'"),
        ({"stiffness": 0.0}, "stiffness is 0.0"),
        ({"damping_ratio": np.nan}, "damping_ratio is nan"),
        ({"axis": (0.0, 0.0, 0.0)}, "axis is zero"),
    ],
)
def test_values_that_cannot_be_meant_are_refused(settings, message):
    with pytest.raises(InvalidValue, match=message):
        Upright(**settings)


def test_two_tasks_on_one_joint_at_one_time_are_refused(clip):
    reach = Reach(target=(0.4, -0.2, 1.2), span=(0.0, 0.6))
    with pytest.raises(
        InvalidValue, match=r"Reach and Upright both command 'right_wrist' from 0\.3 s to 0\.6 s"
    ):
        us.tracked(clip, adult_man(), tasks=[reach, Upright(span=(0.3, 0.9))])
    us.tracked(clip, adult_man(), tasks=[reach, Upright(span=(0.6, 0.9))])
    us.tracked(clip, adult_man(), tasks=[reach, Upright(hand="left")])


def test_a_task_on_a_joint_the_body_lacks_names_the_joint(clip):
    skeleton = us.Character.from_clip(clip)
    legless = replace(skeleton, links=skeleton.links[:4])
    with pytest.raises(UnknownName, match=r"No joint for Upright in .* named 'right_wrist'"):
        us.tracked(us.retargeted(clip, legless), legless, tasks=[Upright()])
    with pytest.raises(UnknownName, match="'sholder'"):
        us.simulate(us.tracked(clip, adult_man(), tasks=[GiveWay(give=("sholder",))]))


def test_a_task_of_a_character_that_is_not_there_is_refused(clip):
    with pytest.raises(InvalidValue, match="character is 1; the scene has 1"):
        us.simulate(us.tracked(clip, adult_man(), tasks=[Upright(character=1)]))


def test_what_is_no_task_is_refused(clip):
    with pytest.raises(InvalidValue, match="task is 'upright'; it must be a task"):
        us.tracked(clip, adult_man(), tasks=["upright"])  # type: ignore[list-item]


def test_compiled_laws_give_the_motion_of_the_plain_ones(clip):
    tasks = [
        Upright(hand="left", ease=0.1),
        Reach(target=(0.4, -0.2, 1.2), ease=0.2),
        LookAt(target=(2.0, 1.0, 1.0)),
        GiveWay(hits=(0.5,)),
    ]
    short = clip.trimmed(0.0, 0.7)
    performance = us.tracked(short, adult_man(), props=[Staff(held_by="left_hand")], tasks=tasks)
    idle = PythonController(function=lambda time, data: None, period=1.0)
    plain = replace(performance, controllers=(*performance.controllers, idle))
    compiled = us.simulate(performance)
    np.testing.assert_allclose(us.simulate(plain).qpos, compiled.qpos, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(us.simulate(plain).ctrl, compiled.ctrl, rtol=0.0, atol=1e-9)


def test_tasks_without_a_weight_change_nothing(clip):
    tasks = [Upright(span=(5.0, 6.0)), LookAt(target=(1, 1, 1), span=(5.0, 6.0)), GiveWay()]
    body = adult_man()
    plain, idle = us.track(clip, body), us.track(clip, body, tasks=tasks)
    np.testing.assert_array_equal(plain.ctrl, idle.ctrl)
    np.testing.assert_allclose(plain.qpos, idle.qpos, rtol=0.0, atol=1e-12)


def test_a_performance_with_tasks_is_the_same_on_any_number_of_threads(clip):
    from understudy.simulate import simulate_many

    made = [
        us.tracked(clip, adult_man(), tasks=[Upright(stiffness=s)]) for s in (100.0, 200.0, 300.0)
    ]
    alone = [us.simulate(one) for one in made]
    for threads in (1, 2):
        for one, many in zip(alone, simulate_many(made, threads=threads), strict=True):
            assert isinstance(many, us.Take)
            np.testing.assert_array_equal(one.qpos, many.qpos)


def test_a_take_says_which_tasks_it_was_asked_for(clip):
    take = us.track(clip, adult_man(), tasks=[Upright(span=(0.2, 0.8))])
    assert take.facts["tasks"] == [
        "Upright(character=0, span=(0.2, 0.8), ease=0.3, hand='right', axis=(1.0, 0.0, 0.0), "
        "stiffness=200.0, damping_ratio=0.8)"
    ]
