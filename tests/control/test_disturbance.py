"""Pushes and throws against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from bodies import chain, still
from understudy.character import adult_man
from understudy.control import Push, Throw
from understudy.errors import InvalidValue, UnknownName
from understudy.evaluate import measured
from understudy.performance import Performance
from understudy.scene import Ball, Box, Scene
from understudy.simulate import simulate

BLOCK = replace(chain(1), links=chain(1).links[:1])


def floating(*tasks, props=(), timestep=0.002, gravity=0.0, duration=1.0, contacts=()):
    scene = Scene(
        characters=(BLOCK,),
        ground=None,
        props=props,
        timestep=timestep,
        gravity=gravity,
        contacts=contacts,
    )
    return simulate(Performance(scene=scene, controllers=tasks, duration=duration))


@pytest.mark.parametrize("timestep", [0.0007, 0.002, 0.03])
def test_a_push_changes_momentum_by_its_impulse_at_any_time_step(timestep):
    push = Push(time=0.2003, on="block", impulse=(1.0, -2.0, 3.0), duration=0.1)
    take = floating(push, timestep=timestep)
    np.testing.assert_allclose(measured(take).momentum[-1, 0], [1, -2, 3], rtol=1e-9)


def test_a_push_is_recorded_in_the_take():
    take = floating(Push(time=0.2, on="block", impulse=(1.0, 0.0, 0.0)))
    body = take.model.body("block").id
    impulse = take.xfrc_applied[:-1, body, 0].sum() / take.rate
    assert impulse == pytest.approx(1.0)
    assert take.xfrc_applied[take.times < 0.19].max() == 0.0


def test_a_ball_is_held_still_until_it_is_thrown_and_arrives_on_time():
    ball = Ball(position=(4.0, 1.0, 1.5))
    throw = Throw(time=1.2, at=(0.5, 0.2, 1.1), flight=0.4)
    take = floating(throw, props=(ball,), gravity=9.81, duration=1.5)
    first = take.model.joint("ball").qposadr[0]
    path = take.qpos[:, first : first + 3]
    held = take.times <= 0.8
    np.testing.assert_allclose(path[held], np.tile(ball.position, (held.sum(), 1)), atol=1e-12)
    arrived = path[np.argmin(np.abs(take.times - 1.2))]
    # One step of gravity early or late: a few millimeters at 2 ms.
    np.testing.assert_allclose(arrived, throw.at, atol=5e-3)


def test_a_throw_at_a_link_is_aimed_at_where_the_clip_has_it():
    clip, body = us.sample("gesture").trimmed(0.0, 1.0), adult_man()
    ball = Ball(position=(3.0, 0.0, 1.4))
    throw = Throw(time=0.8, at="chest", flight=0.5)
    performance = us.tracked(clip, body, props=[ball], contacts=[("ball", "chest")], tasks=[throw])
    take = us.simulate(performance)
    touch = take.model.joint("ball").qposadr[0]
    speed = np.linalg.norm(np.diff(take.qpos[:, touch : touch + 3], axis=0), axis=1) * take.rate
    hit = take.times[
        np.argmin(np.abs(take.times - 0.7)) + int(np.argmin(speed[take.times[1:] > 0.7]))
    ]
    assert 0.7 < hit < 0.95


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Push(time=-1.0, impulse=(1, 0, 0)), "time is -1.0 s"),
        (lambda: Push(time=np.nan, impulse=(1, 0, 0)), "time is nan s"),
        (lambda: Push(time=1.0, impulse=(1, 0)), "impulse is .1, 0.; it must be three numbers"),
        (lambda: Push(time=1.0, impulse=(1, 0, np.inf)), "must be finite numbers"),
        (lambda: Push(time=1.0, impulse=(1, 0, 0), duration=0.0), "duration is 0.0 s"),
        (lambda: Throw(time=0.2, flight=0.5), "a flight of 0.5 s cannot arrive at 0.2 s"),
        (lambda: Throw(time=1.0, flight=-0.5), "flight is -0.5 s"),
    ],
)
def test_disturbances_that_cannot_be_meant_are_refused(make, message):
    with pytest.raises(InvalidValue, match=message):
        make()


def test_names_that_do_not_exist_are_refused_with_the_nearest():
    with pytest.raises(UnknownName, match="Did you mean 'block'"):
        floating(Push(time=0.1, on="blok", impulse=(1, 0, 0)))
    with pytest.raises(UnknownName, match=r"'bal'.* Did you mean 'ball'"):
        floating(Throw(time=1.0, ball="bal", at=(0, 0, 0)), props=(Ball(position=(1, 0, 1)),))
    with pytest.raises(InvalidValue, match="'crate' is fixed; it needs a loose prop"):
        floating(
            Throw(time=1.0, ball="crate", at=(0, 0, 0)),
            props=(Box(name="crate", position=(1, 0, 1), size=(0.1, 0.1, 0.1)),),
        )
    with pytest.raises(InvalidValue, match="'crate' is fixed; a push would not move it"):
        floating(
            Push(time=0.1, on="crate", impulse=(1, 0, 0)),
            props=(Box(name="crate", position=(1, 0, 1), size=(0.1, 0.1, 0.1)),),
        )
    with pytest.raises(InvalidValue, match="give it to `tracked` as a task"):
        floating(Throw(time=1.0), props=(Ball(position=(1, 0, 1)),))
    with pytest.raises(UnknownName, match="'chst'"):
        us.tracked(still(chain(2)), chain(2), tasks=[Throw(time=1.0, at="chst")])


def test_a_ball_is_thrown_once():
    twice = [Throw(time=1.0, at=(0, 0, 1)), Throw(time=2.0, at=(0, 0, 1))]
    with pytest.raises(InvalidValue, match="'ball' is thrown to arrive at 1 s and at 2 s"):
        floating(*twice, props=(Ball(position=(2, 0, 1)),))
