"""Feet on the ground, summed up; and which events a certificate keeps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_takes import body_spec, simulated

from understudy.evaluate import certificate, contact_events, measured
from understudy.evaluate.certificate import foremost
from understudy.evaluate.events import GAP
from understudy.evaluate.feet import STEP_GAP, footfalls, without_footfalls

PUSH = 0.02  # s


def hopping(speed: float) -> Any:
    """A foot that stands, is thrown up at `speed` [m/s] and stands again."""

    def lift(time: float, data: Any) -> None:
        if 0.3 <= time < 0.3 + PUSH - 1e-9:
            data.qfrc_applied[2] = 13.0 * (speed / PUSH + 9.81)

    spec = body_spec(foot=True, servo=2e4)
    return simulated(spec, 1.2, qpos=[0, 0, 0.199], control=lift, foot=True)


def aloft(speed: float) -> float:
    """Time off the ground [s]: the lift, then free fall from where it ends."""
    height = 0.5 * speed * PUSH
    return PUSH + (speed + np.sqrt(speed**2 + 2 * 9.81 * height)) / 9.81


def test_a_foot_that_jumps_comes_down_twice() -> None:
    m = measured(hopping(2.0))
    (foot,) = footfalls(m)
    assert (foot.foot, foot.touchdowns) == ("left_foot", 2)
    standing = sum(e.duration_s for e in foot.events)
    assert foot.stance_mean_s == pytest.approx(standing / 2)
    away = foot.events[1].start_s - foot.events[0].end_s
    assert away == pytest.approx(aloft(2.0), abs=0.01)


def test_a_foot_that_hops_for_a_moment_has_not_stepped() -> None:
    m = measured(hopping(0.2))
    assert GAP < aloft(0.2) < STEP_GAP
    assert len(contact_events(m, "left_foot", "ground")) == 2
    assert footfalls(m)[0].touchdowns == 1


def test_impulse_of_the_ground_on_the_foot_is_all_the_ground_gave() -> None:
    take = hopping(2.0)
    m = measured(take)
    (foot,) = footfalls(m)
    total = sum((e.impulse for e in foot.events), np.zeros(3))
    assert np.allclose(total, m.ground_reaction()[:-1].sum(axis=0) / m.rate, rtol=1e-9)


def test_certificates_sum_feet_up_and_list_the_rest(standing: Any) -> None:
    found = certificate(hopping(2.0))
    assert found["contacts"] == [] and found["contacts_in_all"] == 0
    assert found["feet_on_ground"][0]["touchdowns"] == 2
    resting = certificate(standing)  # a body without feet
    assert resting["contacts"][0]["between"] == ["pelvis", "ground"]
    assert resting["feet_on_ground"] == []


def test_certificates_keep_the_largest_events_in_order() -> None:
    m = measured(hopping(2.0))
    events = contact_events(m, gap=0.0)
    assert without_footfalls(m, events) == ()
    small, large = sorted(events, key=lambda e: e.impulse_ns)[:3], events[0]
    assert foremost((small[0], large, *small[1:]), 2)[0] == large
    assert foremost(events, len(events)) == events
