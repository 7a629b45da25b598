"""Strength that falls at a hit and comes back."""

from __future__ import annotations

import numpy as np
import pytest

import understudy as us
from understudy.control import GiveWay, LookAt, Push, Throw
from understudy.control.give_way import _FIRST, _HITS, _STRENGTH, strength_at
from understudy.errors import InvalidValue, UnknownName
from understudy.evaluate import compare, contact_events
from understudy.scene import Ball


@pytest.fixture(scope="module")
def clip() -> us.Clip:
    return us.sample("gesture").trimmed(0.0, 3.2)


NEVER = np.zeros(0)


def parameters(hits: tuple[float, ...], strength=0.2, fall=0.1, limp=0.2, recovery=0.4):
    out = np.zeros(_FIRST + len(hits))
    out[_STRENGTH : _STRENGTH + 4] = strength, fall, limp, recovery
    out[_HITS] = len(hits)
    out[_FIRST:] = hits
    return out


def test_strength_falls_stays_low_and_recovers():
    times = (0.99, 1.0, 1.05, 1.1, 1.2, 1.3, 1.5, 1.7, 2.0)
    found = [strength_at(time, parameters((1.0,)), NEVER) for time in times]
    np.testing.assert_allclose(found, [1, 1, 0.6, 0.2, 0.2, 0.2, 0.6, 1, 1], atol=1e-12)


def test_of_two_hits_the_weaker_moment_counts():
    both = parameters((1.0, 1.4))
    for time in np.linspace(0.9, 2.2, 40):
        alone = [strength_at(time, parameters((hit,)), NEVER) for hit in (1.0, 1.4)]
        assert strength_at(time, both, NEVER) == min(alone)


def away(take: us.Take) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and the largest joint or root angle from the clip [deg]."""
    found = compare.compared(take.clip(rate=120.0), take.references[0])
    worst = np.maximum(found.joint_angles.max(axis=1), found.root_angles)
    return found.times, np.degrees(worst)


@pytest.mark.parametrize("impulse", [(60.0, 0.0, 0.0), (0.0, -100.0, 0.0), (-70.0, 70.0, 0.0)])
def test_the_body_gives_way_to_a_push_and_is_back_within_a_second_and_a_half(clip, impulse):
    body = us.Character.from_clip(clip)
    push = Push(time=1.2, on="chest", impulse=impulse)
    stiff = us.track(clip, body, tasks=[push])
    soft = us.track(clip, body, tasks=[push, GiveWay.after(push)])
    times, angle = away(soft)
    hit = (times > 1.2) & (times < 1.7)
    assert angle[hit].max() > 1.5 * away(stiff)[1][hit].max()
    assert angle[hit].max() > 10.0
    assert angle[times > 2.7].max() < 5.0


def test_times_come_from_what_hits():
    pushes = [Push(time=2.0, impulse=(1, 0, 0)), Push(time=1.0, impulse=(1, 0, 0))]
    assert GiveWay.after(*pushes, strength=0.5) == GiveWay(hits=(1.0, 2.0), strength=0.5)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"hits": (-1.0,)}, "hits is"),
        ({"hits": "soon"}, "hits is 'soon'"),
        ({"hits": (np.inf,)}, "hits is"),
        ({"strength": 1.5}, "strength is 1.5"),
        ({"strength": np.nan}, "strength is nan"),
        ({"recovery": -1.0}, "recovery is -1.0 s"),
    ],
)
def test_values_that_cannot_be_meant_are_refused(settings, message):
    with pytest.raises(InvalidValue, match=message):
        GiveWay(**settings)


def test_it_gives_way_when_the_ball_touches_not_when_it_was_to_arrive(clip):
    body = us.Character.from_clip(clip)
    throw = Throw(time=1.2, ball="ball", at="chest", flight=0.4)
    ball = Ball(position=(3.0, 0.2, 1.5), mass=3.0)
    give = GiveWay.after(throw)
    assert give.touches == (("ball", 1.2),) and give.hits == ()
    contacts = [("ball", part) for part in ("chest", "abdomen")]
    take = us.track(clip, body, props=[ball], contacts=contacts, tasks=[throw, give])
    hit = contact_events(take, "chest", "ball")[0].start_s
    assert hit < 1.19  # the ball's surface is there before its middle
    stiff = us.track(clip, body, props=[ball], contacts=contacts, tasks=[throw])
    before = take.times < hit
    np.testing.assert_allclose(take.qpos[before], stiff.qpos[before], atol=1e-9)
    times, angle = away(take)
    assert angle[(times > hit) & (times < hit + 0.5)].max() > 1.3 * away(stiff)[1].max()
    assert angle[times > hit + 1.5].max() < 5.0


def test_a_ball_that_misses_weakens_nobody(clip):
    body = us.Character.from_clip(clip)
    throw = Throw(time=1.0, ball="ball", at=(0.5, 3.0, 1.0), flight=0.4)
    ball = Ball(position=(3.0, 3.0, 1.5))
    take = us.track(clip, body, props=[ball], tasks=[throw, GiveWay.after(throw)])
    assert away(take)[1].max() < 2.0


def test_a_prop_that_is_not_there_is_refused_with_the_nearest(clip):
    body = us.Character.from_clip(clip)
    ball = Ball(position=(3.0, 0.0, 1.5))
    with pytest.raises(UnknownName, match=r"'bal'\. Did you mean 'ball'"):
        us.track(clip, body, props=[ball], tasks=[GiveWay(touches=(("bal", 1.0),))])


def test_driven_bodies_give_way_and_come_back_too():
    clip = us.sample("gesture").trimmed(0.0, 2.0)
    linkage = us.Linkage.from_clip(clip, "constrained")
    push = Push(time=0.8, on="upper_back", impulse=(-10.0, 5.0, 0.0))

    def away(*tasks) -> tuple[np.ndarray, np.ndarray]:
        take = us.simulate(us.driven(clip, linkage, rate=60.0, tasks=tasks))
        moved = take.clip().forward_kinematics().positions
        reference = take.references[0].forward_kinematics().positions
        return take.clip().times, np.linalg.norm(moved - reference, axis=-1).max(axis=1)

    times, stiff = away(push)
    _, soft = away(push, GiveWay.after(push))
    hit = (times > 0.8) & (times < 1.1)
    assert soft[hit].max() > 3.0 * stiff[hit].max()
    assert soft[hit].max() > 0.02
    assert soft[times > 1.8].max() < 0.002


def test_a_drive_takes_no_task_that_needs_servos():
    clip = us.sample("gesture").trimmed(0.0, 0.5)
    with pytest.raises(InvalidValue, match="a drive takes Push, Throw and GiveWay"):
        us.driven(clip, us.Linkage.from_clip(clip), tasks=[LookAt(target=(1, 0, 1))])  # type: ignore[list-item]
