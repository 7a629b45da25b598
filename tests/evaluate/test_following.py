"""How a body follows its clip: closed forms, and the engine as an oracle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from bodies import chain, still
from understudy.control import Tracking
from understudy.errors import InvalidValue
from understudy.evaluate import certificate, following, measured, score
from understudy.evaluate.certificate import statement
from understudy.evaluate.following import flight_time, mass_center
from understudy.performance import Performance
from understudy.scene import Scene
from understudy.simulate import simulate

SHIFT = np.array([0.03, 0.0, 0.04])


def held(pelvis: str = "free", seconds: float = 0.5, gravity: float = 9.81, clip=None):
    body = chain(2)
    return simulate(
        Performance(
            scene=Scene(characters=(body,), ground=None, gravity=gravity),
            controllers=(Tracking(reference=clip or still(body, seconds=seconds), pelvis=pelvis),),
            duration=seconds,
        )
    )


def test_a_body_that_falls_is_lost_after_its_fall_by_the_bound() -> None:
    found = following(held())
    assert found.lost_s == pytest.approx(np.sqrt(2 * 0.2 / 9.81), abs=0.005)
    assert found.free_s == pytest.approx(found.lost_s, abs=0.005)
    assert found.help_percent == 0.0
    assert not found.free


def test_a_body_at_rest_without_gravity_is_free_and_exact() -> None:
    found = following(held(gravity=0.0))
    assert found.free and found.lost_s is None
    assert found.free_s == found.duration_s == pytest.approx(0.5)
    assert found.joint_position_mm == pytest.approx(0.0, abs=1e-6)
    assert found.com_peak_mm == pytest.approx(0.0, abs=1e-6)
    assert found.shake is None


def test_a_led_body_is_never_free_and_its_help_is_its_weight() -> None:
    found = following(held("led"))
    assert found.lost_s is None and not found.free
    assert found.free_s == 0.0
    assert found.help_percent == pytest.approx(100.0, rel=0.02)


def test_a_shifted_motion_errs_by_its_shift_in_the_world_and_not_from_the_root() -> None:
    take = held(gravity=0.0)
    (reference,) = take.references
    aside = replace(reference, root_positions=reference.root_positions + SHIFT)
    found = following(replace(take, references=(aside,)))
    assert found.joint_position_mm == pytest.approx(50.0)
    assert found.com_mm == pytest.approx(50.0)
    assert found.joint_relative_mm == pytest.approx(0.0, abs=1e-6)


def test_a_body_that_goes_elsewhere_is_lost_although_it_stands() -> None:
    take = held(gravity=0.0)
    (reference,) = take.references
    path = reference.root_positions + np.outer(reference.times, [4.0, 0.0, 0.0])
    found = following(replace(take, references=(replace(reference, root_positions=path),)))
    assert found.lost_s == pytest.approx(0.6 / 4.0, abs=0.006)


def test_the_center_of_mass_of_a_clip_is_the_engines() -> None:
    clip = us.sample("gesture").trimmed(1.0, 1.4)
    take = us.track(clip, us.Character.from_clip(clip))
    m = measured(take)
    simulated = take.clip(rate=take.rate)
    mine = mass_center(simulated, take.scene.characters[0])
    assert np.allclose(mine, m.center_of_mass[:, 0], atol=1e-9)


def test_flight_is_the_time_of_free_fall_but_for_the_fitting_window() -> None:
    times = np.arange(0.0, 1.6, 1.0 / 120.0)
    up = 2.0
    aloft = 2 * up / 9.81
    t = np.clip(times - 0.5, 0.0, aloft)
    path = np.zeros((len(times), 3))
    path[:, 2] = 1.0 + up * t - 0.5 * 9.81 * t**2
    assert aloft - 0.1 <= flight_time(path, 120.0) <= aloft
    assert flight_time(np.ones_like(path), 120.0) == 0.0


def test_a_take_that_ends_before_its_clip_is_not_whole() -> None:
    assert following(held(gravity=0.0)).whole
    short = following(held(gravity=0.0, seconds=0.3, clip=still(chain(2), seconds=0.5)))
    assert short.free and not short.whole
    assert short.free_s == pytest.approx(0.3) and short.clip_s == pytest.approx(0.5)


def test_without_a_clip_there_is_nothing_to_follow() -> None:
    take = replace(held(), references=(None,))
    with pytest.raises(InvalidValue, match="no reference clip"):
        following(take)


def test_the_certificate_says_how_the_body_followed() -> None:
    found = certificate(held())
    (one,) = found["characters"]
    assert one["following"]["lost_s"] == following(held()).lost_s
    assert one["following"]["free"] is False
    (unled,) = certificate(replace(held(), references=(None,)))["characters"]
    assert unled["following"] is None


def test_a_free_body_that_needs_help_is_told_the_least_that_was_found() -> None:
    s = replace(score(held()), root_force_mean_percent=4.0, root_force_peak_percent=9.0)
    said = statement(replace(s, fell_s=None))
    assert said.startswith("The least help that was found is an outside force")
    assert "4.0 % of body weight on average (peak 9.0 %)" in said
