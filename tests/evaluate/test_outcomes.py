"""How far tasks stayed from their goals."""

from __future__ import annotations

import numpy as np
import pytest

import understudy as us
from understudy.character import adult_man
from understudy.control import Balance, GiveWay, HandOn, LookAt, Reach, Upright
from understudy.evaluate import certificate, measured, outcomes
from understudy.report import report_html
from understudy.scene import Box, Staff


@pytest.fixture(scope="module")
def take() -> us.Take:
    tasks = [
        Reach(hand="left", target=(0.35, 0.3, 1.2), span=(0.2, 1.4)),
        LookAt(target="staff/head", ease=0.4),
        Upright(span=(0.0, 2.0), ease=0.5),
        GiveWay(),
    ]
    clip = us.sample("staff").trimmed(1.0, 2.5)
    return us.track(clip, adult_man(), props=[Staff()], tasks=tasks)


def test_every_task_with_a_goal_has_an_outcome(take):
    reach, look, upright = outcomes(take, measured(take))
    assert (reach.task, look.task, upright.task) == ("Reach", "LookAt", "Upright")
    assert (reach.start_s, reach.end_s) == pytest.approx((0.5, 1.1))
    assert (look.start_s, look.end_s) == pytest.approx((0.4, 1.5))
    # It lets go only after the end.
    assert (upright.start_s, upright.end_s) == pytest.approx((0.5, 1.5))
    assert reach.unit == "mm" and 0.0 < reach.mean < 8.0 and reach.most > reach.mean
    assert look.unit == "deg" and look.mean < 4.0
    assert upright.unit == "deg" and upright.mean < 2.0


def test_a_palm_that_is_held_up_is_said_to_be_far(take):
    clip = us.sample("gesture").trimmed(0.0, 1.6)
    wall = Box(position=(0.3, 0.25, 1.1), size=(0.1, 0.8, 0.8))
    press = HandOn(hand="left", target=(0.4, 0.25, 1.1), span=(0.2, 3.0), ease=0.3)
    held = us.track(clip, adult_man(), props=[wall], contacts=[("left_hand", "box")], tasks=[press])
    (free,) = outcomes(*(lambda t: (t, measured(t)))(us.track(clip, adult_man(), tasks=[press])))
    (far,) = outcomes(held, measured(held))
    assert free.mean < 8.0
    assert far.mean > 5.0 * free.mean


def test_balance_is_measured_from_the_middle_of_the_feet():
    take = us.track(us.sample("gesture").trimmed(0.0, 1.0), adult_man(), tasks=[Balance()])
    (balance,) = outcomes(take, measured(take))
    assert balance.unit == "mm" and 0.0 < balance.most < 8.0


def test_certificate_and_report_tell_of_tasks(take):
    told = certificate(take)["tasks"]
    assert [one["task"] for one in told] == ["Reach", "LookAt", "Upright"]
    assert np.isfinite([one["mean"] for one in told]).all()
    page = report_html(take)
    assert 'id="tasks"' in page and "left_hand from its target" in page


def test_a_take_without_tasks_has_no_outcomes():
    take = us.track(us.sample("gesture").trimmed(0.0, 0.2), adult_man())
    assert outcomes(take, measured(take)) == ()
    assert 'id="tasks"' not in report_html(take)
