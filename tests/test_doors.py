"""Wrong arguments at the public functions: one sentence that says what it must be."""

from __future__ import annotations

import json

import pytest

import understudy as us
from understudy.errors import InvalidValue, UnknownName
from understudy.evaluate import certificate
from understudy.tuning import tune


@pytest.fixture(scope="module")
def clip() -> us.Clip:
    return us.sample("gesture").trimmed(1.0, 1.3).resampled(60.0)


@pytest.fixture(scope="module")
def character(clip) -> us.Character:
    return us.Character.from_clip(clip)


@pytest.fixture(scope="module")
def take(clip, character) -> us.Take:
    return us.track(clip, character)


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda c, b, t: us.track(None, b), "clip is None; it must be a Clip"),
        (lambda c, b, t: us.track(c, "man"), "character is 'man'; it must be a Character"),
        (lambda c, b, t: us.tracked(c, None), "character is None; it must be a Character"),
        (lambda c, b, t: us.score(c), "take is Clip.*; it must be a Take"),
        (lambda c, b, t: us.read(None), "path is None; it must be the name of a motion file"),
        (lambda c, b, t: us.sample(1), "name is 1; it must be one of gesture"),
        (lambda c, b, t: us.fetch(object()), "name is <object.*; it must be the name of a clip"),
        (lambda c, b, t: us.load_take(None), "path is None; it must be the name of a take"),
        (lambda c, b, t: us.write(None, "a.bvh"), "thing is None; it must be a Take or a Clip"),
        (lambda c, b, t: us.write(t), "needs at least one path"),
        (lambda c, b, t: us.write(t, 5), "path is 5; it must be the name of a file"),
        (lambda c, b, t: us.write(t, "a.bvh", character=5), "character is 5; this take has 1"),
        (lambda c, b, t: us.write(c, "a.bvh", character="x"), "character is 'x'; this clip has 1"),
        (lambda c, b, t: us.Performance(scene=t.scene, duration="x"), "duration is x s"),
        (lambda c, b, t: us.Performance(scene=None, duration=1.0), "scene is None; it must be"),
        (lambda c, b, t: us.tune(c), "performance is Clip.*; it must be a Performance"),
    ],
)
def test_a_wrong_argument_is_named_with_what_it_must_be(call, expected, clip, character, take):
    with pytest.raises(InvalidValue, match=expected) as caught:
        call(clip, character, take)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200


def test_an_unknown_setting_names_the_nearest_one(clip, character):
    with pytest.raises(
        UnknownName, match=r"No setting named 'stifness'\. Did you mean 'stiffness'"
    ):
        us.track(clip, character, stifness=5.0)
    with pytest.raises(UnknownName, match="Did you mean 'ground'"):
        us.track(clip, character, grond=None)


@pytest.mark.parametrize(
    "asked",
    [
        {"torque_weight": float("nan")},
        {"torque_weight": -1.0},
        {"torque_weight": 1e300},
        {"survey": 1},
        {"survey": 100_000},
        {"iterations": -1},
        {"bounds": (float("nan"), 10.0)},
    ],
)
def test_a_search_that_cannot_be_meant_is_refused_before_it_starts(asked, take):
    (name,) = asked
    with pytest.raises(InvalidValue, match=f"{name} (is|are) .*; (it|they) must"):
        tune(take.performance, **asked)


def test_certificates_of_two_runs_differ_only_in_their_timing(clip, character):
    first, second = (certificate(us.track(clip, character)) for _ in range(2))
    assert first["timing"]["cpu_seconds"] > 0.0
    assert first["timing"]["real_time_factor"] > 0.0
    assert "cpu_seconds" not in first["facts"]
    for made in (first, second):
        del made["timing"], made["real_time_factor"]
    assert json.dumps(first) == json.dumps(second)
