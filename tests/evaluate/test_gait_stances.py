"""Stances from margins, and the force over one."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.evaluate.gait_forces import GRAVITY, impact_peak, stance_force
from understudy.evaluate.gait_stances import SHORTEST, Stance, _spans, flights

AHEAD = np.array([1.0, 0.0, 0.0])


def stance(side: str, start: float, end: float) -> Stance:
    return Stance(side=side, start_s=start, end_s=end, whole=True, begins=True)


def test_edges_lie_where_the_margin_crosses_zero() -> None:
    times = np.arange(0.0, 2.0, 0.01)
    margin = 0.3 - np.abs(times - 0.7345)
    (found,) = _spans("left", times, margin)
    assert (found.start_s, found.end_s) == pytest.approx((0.4345, 1.0345))
    assert found.whole and found.middle_s == pytest.approx(0.7345)


def test_blinks_are_neither_stances_nor_gaps() -> None:
    times = np.arange(0.0, 2.0, 0.005)
    inside = (times > 0.5) & (times < 0.9)
    blink = (times > 0.7) & (times < 0.7 + 0.5 * SHORTEST)
    brief = (times > 1.3) & (times < 1.3 + 0.5 * SHORTEST)
    margin = np.where((inside & ~blink) | brief, 1.0, -1.0)
    (found,) = _spans("left", times, margin)
    assert found.start_s == pytest.approx(0.5, abs=0.005)
    assert found.end_s == pytest.approx(0.9, abs=0.005)


def test_stances_cut_off_by_the_record_are_not_whole() -> None:
    times = np.arange(0.0, 1.0, 0.01)
    first, last = _spans("left", times, np.abs(times - 0.5) - 0.2)
    assert not first.whole and not first.begins
    assert not last.whole and last.begins


def test_flight_is_the_gap_between_the_feet() -> None:
    run = [stance("left", 0.0, 0.25), stance("right", 0.35, 0.60), stance("left", 0.72, 0.95)]
    assert flights(run) == pytest.approx([0.10, 0.12])
    walk = [stance("left", 0.0, 0.65), stance("right", 0.5, 1.15)]
    assert flights(walk) == pytest.approx([-0.15])
    hop = [stance("left", 0.0, 0.25), stance("left", 0.35, 0.60)]
    assert flights(hop) == []


def plate(up: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    times = np.arange(len(up)) * 0.001
    return times, np.stack((along, 0.0 * up, up), axis=1)


def test_a_half_sine_has_its_known_mean_peak_and_impulses() -> None:
    share = (np.arange(250) + 0.5) / 250
    times, force = plate(2.4 * np.sin(np.pi * share), -0.3 * np.sin(2.0 * np.pi * share))
    found = stance_force(times, force, stance("left", 0.0, 0.2505), AHEAD)
    assert found.mean == pytest.approx(2.4 * 2.0 / np.pi, rel=1e-3)
    assert found.peak == found.active == pytest.approx(2.4, rel=1e-3)
    assert found.impact is None
    # Half a wave of 0.3 BW over 0.125 s.
    once = 0.3 * 2.0 / np.pi * 0.125 * GRAVITY
    assert (found.braking, found.pushing) == pytest.approx((-once, once), rel=1e-3)
    assert found.loading_rate == pytest.approx(2.4 * np.pi / 0.25, rel=0.01)
    assert found.up[50] == pytest.approx(2.4, rel=1e-3)


def test_a_bump_before_the_active_peak_is_the_impact() -> None:
    share = (np.arange(250) + 0.5) / 250
    bump = 1.2 * np.exp(-(((share - 0.10) / 0.03) ** 2))
    times, force = plate(2.4 * np.sin(np.pi * share) + bump, 0.0 * share)
    found = stance_force(times, force, stance("left", 0.0, 0.2505), AHEAD)
    assert found.impact is not None
    assert found.impact == pytest.approx(2.4 * np.sin(0.1 * np.pi) + 1.2, rel=0.05)
    assert found.active == pytest.approx(2.4, rel=1e-3)


def test_a_spike_above_everything_is_the_impact_too() -> None:
    up = np.concatenate((np.linspace(0, 4, 10), np.linspace(4, 1, 10), np.full(180, 1.5)))
    assert impact_peak(np.append(up, 0.0), 50) == pytest.approx(4.0)


def test_ripple_below_the_dip_is_no_peak() -> None:
    share = np.linspace(0.0, 1.0, 251)
    up = 2.4 * np.sin(np.pi * share) + 0.005 * np.sin(400.0 * share)
    assert impact_peak(up, 60) is None
