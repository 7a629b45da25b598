"""Pushes against closed forms: they move the body and are no help of its root."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_takes import body_spec, simulated

from understudy.evaluate import certificate, measured, physics, push_events, score
from understudy.evaluate.pushes import pushed

FORCE = np.array([120.0, 0.0, 50.0])


@pytest.fixture(scope="module")
def hit() -> Any:
    """A body in the air: its root is pushed for 0.1 s, then its arm is turned for 0.05 s."""

    def push(time: float, data: Any) -> None:
        if 0.1 - 1e-9 <= time < 0.2 - 1e-9:
            data.xfrc_applied[1, :3] = FORCE
        if 0.3 - 1e-9 <= time < 0.35 - 1e-9:
            data.xfrc_applied[2, 3:] = [0.0, 4.0, 0.0]

    return simulated(body_spec(servo=200.0, step=0.001), 0.5, qpos=[0, 0, 2.0], control=push)


def test_a_push_changes_momentum_by_its_impulse(hit: Any) -> None:
    m = measured(hit)
    first, second = push_events(hit)
    gained = m.momentum[-1, 0] - m.momentum[0, 0]
    fallen = np.array([0.0, 0.0, m.performer().weight * hit.duration])
    assert np.allclose(gained + fallen, first.impulse, atol=1e-2 * first.impulse_ns)
    assert second.impulse_ns == 0.0


def test_a_push_is_told_with_its_link_time_and_size(hit: Any) -> None:
    first, second = push_events(hit)
    assert (first.link, second.link) == ("pelvis", "arm")
    assert first.start_s == pytest.approx(0.1) and first.duration_s == pytest.approx(0.1)
    assert first.impulse_ns == pytest.approx(13.0)
    assert first.peak_force_n == pytest.approx(130.0)
    assert second.start_s == pytest.approx(0.3) and second.duration_s == pytest.approx(0.05)
    assert second.peak_torque_nm == pytest.approx(4.0)


def test_a_push_is_no_help_of_the_root(hit: Any) -> None:
    s = score(hit)
    assert s.root_force_peak_percent == 0.0 and s.fully_physical


def test_forces_with_a_push_account_for_the_motion(hit: Any) -> None:
    m = measured(hit)
    assert np.allclose(m.push[150, :3], FORCE)
    assert not m.push[250].any()
    assert physics.flights(m) == ((0, m.frames - 1),)
    drift = physics.energy_drift(hit, m)
    assert drift is not None and drift < 1.0


def test_a_push_is_in_the_certificate(hit: Any, thrown: Any) -> None:
    found = certificate(hit)
    assert [push["link"] for push in found["pushes"]] == ["pelvis", "arm"]
    assert "pelvis, 13.0 N s at 0.10 s" in found["statement"]
    assert certificate(thrown)["pushes"] == []
    assert pushed(()) == ""


def test_a_take_without_a_record_of_pushes_has_none(thrown: Any) -> None:
    kept = thrown.xfrc_applied
    del thrown.xfrc_applied
    try:
        assert push_events(thrown) == () and not measured(thrown).push.any()
    finally:
        thrown.xfrc_applied = kept
