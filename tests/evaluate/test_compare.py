from __future__ import annotations

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.evaluate.compare import compared, lag, sampled
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import figure


def waving(
    *,
    delay: float = 0.0,
    rate: float = 120.0,
    seconds: float = 4.0,
    frequency: float = 0.7,
    twist: float = 0.0,
    shift: tuple[float, float, float] = (0, 0, 0),
) -> Clip:
    """A figure whose elbow and knee swing; `delay` seconds late."""
    skeleton = figure()
    times = np.arange(round(seconds * rate) + 1) / rate - delay
    turned = rot.identity(len(times), len(skeleton))
    angle = np.sin(2 * np.pi * frequency * times)
    flat = np.zeros_like(angle)
    turned[:, skeleton.index("left_elbow")] = rot.from_rotvec(np.stack((flat, flat, angle), -1))
    turned[:, skeleton.index("right_knee")] = rot.from_rotvec(
        np.stack((flat, 0.4 * angle, flat), -1)
    )
    extra = rot.from_rotvec(np.array([twist, 0, 0]))
    turned[:, 1:] = rot.multiply(turned[:, 1:], extra)
    path = np.tile(skeleton.offsets[0] + np.asarray(shift, float), (len(times), 1))
    return Clip(skeleton=skeleton, rotations=turned, root_positions=path, rate=rate)


@pytest.mark.parametrize("delay", [0.09, 0.0, 0.0123, -0.04])
def test_lag_of_a_shifted_sinusoid_is_the_shift(delay: float) -> None:
    found = lag(waving(delay=delay), waving())
    assert found == pytest.approx(delay, abs=1e-3)


def test_lag_is_found_when_rates_differ() -> None:
    found = lag(waving(delay=0.09, rate=125.0), waving(rate=60.0))
    assert found == pytest.approx(0.09, abs=1e-3)


def test_still_motion_has_no_lag() -> None:
    assert lag(waving(frequency=0.0), waving(frequency=0.0)) is None


def test_lag_beyond_the_search_is_not_reported() -> None:
    late = waving(delay=0.4, frequency=0.3, seconds=6.0)
    assert lag(late, waving(frequency=0.3, seconds=6.0), longest=0.2) is None


def test_errors_vanish_after_removing_the_lag() -> None:
    late = waving(delay=0.09)
    with_lag = compared(late, waving())
    without = compared(late, waving(), lag=0.09)
    assert np.degrees(with_lag.joint_angles.max()) > 10.0
    assert np.degrees(without.joint_angles.max()) < 0.1


def test_a_motion_equals_itself() -> None:
    found = compared(waving(), waving())
    for values in (found.joint_angles, found.distances, found.aligned_distances, found.root_angles):
        assert np.abs(values).max() < 1e-7


def test_a_constant_twist_is_the_joint_error() -> None:
    found = compared(waving(twist=np.radians(10.0)), waving())
    assert np.degrees(found.joint_angles) == pytest.approx(10.0)
    assert found.root_angles == pytest.approx(0.0, abs=1e-9)


def test_a_shifted_root_moves_every_joint_but_none_seen_from_the_root() -> None:
    found = compared(waving(shift=(0.03, 0.04, 0.0)), waving())
    assert found.distances == pytest.approx(0.05)
    assert found.end_distances == pytest.approx(0.05)
    assert found.aligned_distances == pytest.approx(0.0, abs=1e-12)


def test_sampling_at_frames_gives_the_frames() -> None:
    clip = waving()
    turned, path = sampled(clip, clip.times)
    assert np.allclose(rot.angle_between(turned, clip.rotations), 0.0, atol=1e-7)
    assert np.allclose(path, clip.root_positions)


def test_sampling_between_frames_is_slerp() -> None:
    clip = waving(rate=10.0)
    turned, _ = sampled(clip, np.array([0.05]))
    assert np.allclose(turned[0], rot.slerp(clip.rotations[0], clip.rotations[1], np.array(0.5)))


def test_only_shared_time_is_compared() -> None:
    found = compared(waving(seconds=3.0), waving(seconds=1.0))
    assert found.times[-1] == pytest.approx(1.0)


def test_motions_that_share_no_time_are_refused() -> None:
    with pytest.raises(InvalidValue, match="share no moment"):
        compared(waving(seconds=1.0), waving(seconds=1.0), lag=5.0)
