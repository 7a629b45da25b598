"""The filter of ground forces: what it keeps, what it halves, and that it only averages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_takes import body_spec, simulated

from understudy.evaluate import measured, score
from understudy.evaluate.feet import footfalls
from understudy.evaluate.force_plate import CUTOFF, as_by_plate
from understudy.evaluate.gait_forces import stance_by_plate, stance_force
from understudy.evaluate.gait_stances import Stance

RATES = (120.0, 600.0, 1000.0)


def impulse(rate: float) -> np.ndarray:
    """A force of 1 N s within one step, amid a second."""
    force = np.zeros(int(rate) + 1)
    force[len(force) // 2] = rate
    return force


@pytest.mark.parametrize("rate", RATES)
def test_a_constant_stays(rate: float) -> None:
    assert np.allclose(as_by_plate(np.full(50, 3.7), rate), 3.7, rtol=1e-12)


@pytest.mark.parametrize("rate", RATES)
def test_an_impulse_keeps_its_area_and_its_moment(rate: float) -> None:
    force, times = as_by_plate(impulse(rate), rate), np.arange(int(rate) + 1) / rate
    assert force.sum() / rate == pytest.approx(1.0, rel=1e-12)
    assert (force * times).sum() / rate == pytest.approx(0.5, rel=1e-12)
    assert np.allclose(force, force[::-1], atol=1e-12 * rate)


@pytest.mark.parametrize("rate", RATES)
def test_a_push_is_never_a_pull_and_no_peak_grows(rate: float) -> None:
    raw = np.maximum(0.0, np.random.default_rng(3).normal(size=400))
    force = as_by_plate(raw, rate)
    assert force.min() >= 0.0
    assert force.max() <= raw.max()


@pytest.mark.parametrize("rate", RATES)
def test_half_of_the_power_is_left_at_the_cutoff(rate: float) -> None:
    times = np.arange(0.0, 4.0, 1.0 / rate)
    turned = 2.0 * np.pi * CUTOFF * times
    wave = np.stack((np.cos(turned), np.sin(turned)), axis=1)
    middle = slice(len(times) // 4, -len(times) // 4)
    assert np.allclose(as_by_plate(wave, rate)[middle], np.sqrt(0.5) * wave[middle], atol=1e-6)


def test_the_peak_of_an_impulse_does_not_depend_on_the_step() -> None:
    fine, finer = (as_by_plate(impulse(rate), rate).max() for rate in (1000.0, 2000.0))
    assert fine == pytest.approx(finer, rel=0.02)
    assert finer < 100.0  # N, of 2000


def test_each_axis_is_filtered_by_itself_and_the_argument_left_alone() -> None:
    force = np.random.default_rng(0).normal(size=(60, 3))
    before = force.copy()
    found = as_by_plate(force, 500.0)
    assert np.array_equal(found[:, 1], as_by_plate(force[:, 1], 500.0))
    assert np.array_equal(force, before)


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_few_frames_are_filtered_too(frames: int) -> None:
    assert as_by_plate(np.ones(frames), 120.0) == pytest.approx(np.ones(frames))


def test_too_few_frames_a_second_are_left_as_they_are() -> None:
    raw = np.arange(5.0)
    assert np.array_equal(as_by_plate(raw, 2.0 * CUTOFF), raw)


def landed() -> Any:
    """A foot dropped from 20 mm."""
    return simulated(body_spec(foot=True, servo=2e4), 0.8, qpos=[0, 0, 0.22], foot=True)


def test_the_peak_of_a_landing_is_the_plates_and_the_spike_stands_beside_it() -> None:
    take = landed()
    m = measured(take)
    raw = 100.0 * m.ground_reaction()[:, 2] / m.performer().weight
    found = score(take, measures=m)
    assert found.ground_force_spike_percent == pytest.approx(raw.max())
    assert found.ground_force_peak_percent == pytest.approx(as_by_plate(raw, m.rate).max())
    assert as_by_plate(raw, m.rate).max() < 0.7 * raw.max()
    (foot,) = footfalls(m)
    assert foot.peak_force_n < 0.7 * foot.spike_force_n
    # It stands on this one foot, so all of the ground's force is on it.
    assert foot.peak_force_percent == pytest.approx(found.ground_force_peak_percent, rel=0.01)


def test_a_stance_keeps_its_impulses_and_loses_its_spike() -> None:
    times = np.linspace(0.0, 0.299, 300)
    up = np.where((times > 0.05) & (times < 0.25), 1.2, 0.0)
    up[150] += 3.0
    force = np.stack((-0.2 * up, 0.0 * up, up), axis=1)
    stance = Stance(side="left", start_s=0.05, end_s=0.2505, whole=True, begins=True)
    ahead = np.array([1.0, 0.0, 0.0])
    raw, plate = (one(times, force, stance, ahead) for one in (stance_force, stance_by_plate))
    assert (plate.mean, plate.braking) == (raw.mean, raw.braking)
    assert raw.peak == pytest.approx(4.2)
    assert plate.peak == pytest.approx(1.2 + 3.0 * 0.073, rel=0.05)
