"""Evaluation of takes made the way users make them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bodies import chain, still
from understudy.control import Tracking
from understudy.evaluate import certificate, measured, physics, score
from understudy.evaluate.plots import hand_speed
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.performance import Performance
from understudy.report import report_html
from understudy.scene import Scene
from understudy.simulate import simulate


def swinging(frequency: float = 0.3, seconds: float = 8.0) -> Clip:
    """The chain's rod swings slowly about the lateral axis."""
    clip = still(chain(2), seconds=seconds)
    angle = 0.5 * np.sin(2 * np.pi * frequency * clip.times)
    turned = clip.rotations.copy()
    turned[:, 1] = rot.from_rotvec(np.stack((0 * angle, angle, 0 * angle), axis=-1))
    return replace(clip, rotations=turned, name="swinging")


def test_the_papers_law_lags_by_damping_over_stiffness() -> None:
    clip = swinging()
    take = simulate(
        Performance(
            scene=Scene(characters=(chain(2),), ground=None, gravity=0.0),
            controllers=(Tracking(reference=clip, law="paper", pelvis="led"),),
            duration=clip.duration,
        )
    )
    s = score(take)
    assert s.lag_ms == pytest.approx(1e3 * physics.servo_lag(1.0, 0.1), abs=2.0)
    assert s.joint_error_deg is not None and s.joint_error_without_lag_deg is not None
    # The start from rest at the wrong speed is all that is left.
    assert s.joint_error_without_lag_deg < 0.2 * s.joint_error_deg


def test_every_character_of_a_scene_has_its_own_score() -> None:
    one, two = chain(2), replace(chain(2), name="other")
    clip = still(one, seconds=0.3)
    aside = replace(clip, root_positions=clip.root_positions + np.array([0.0, 2.0, 0.0]))
    take = simulate(
        Performance(
            scene=Scene(characters=(one, two), ground=None),
            controllers=(
                Tracking(reference=clip, pelvis="led"),
                Tracking(reference=aside, character=1, pelvis="free"),
            ),
            duration=0.3,
        )
    )
    first, second = score(take), score(take, character=1)
    assert (first.pelvis, second.pelvis) == ("led", "free")
    assert first.root_support_percent == pytest.approx(100.0, rel=0.05)
    assert second.root_force_peak_percent == 0.0
    found = certificate(take)
    assert [c["character"] for c in found["characters"]] == ["chain", "other"]
    assert not found["fully_physical"]
    page = report_html(take)
    assert page.count("Help from outside") == 2
    m = measured(take)
    fall = m.center_of_mass[0, 1, 2] - m.center_of_mass[-1, 1, 2]
    assert fall == pytest.approx(0.5 * 9.81 * m.times[-1] ** 2, rel=0.03)


def test_the_same_take_has_the_same_score() -> None:
    clip = swinging(seconds=1.0)
    performance = Performance(
        scene=Scene(characters=(chain(2),), ground=None),
        controllers=(Tracking(reference=clip, pelvis="led"),),
        duration=1.0,
    )
    first, second = (score(simulate(performance)) for _ in range(2))
    assert replace(first, real_time_factor=None) == replace(second, real_time_factor=None)


@pytest.mark.clips
def test_hand_speeds_of_a_captured_gesture_agree(clips: Path) -> None:
    import understudy as us

    clip = us.read(clips / "cmu_bvh" / "02_05.bvh").trimmed(0.0, 3.0)
    take = us.track(clip, us.Character.from_clip(clip, plan="upper"), pelvis="led")
    charts = hand_speed(take, measured(take))
    assert [c.title for c in charts] == ["Left hand speed", "Right hand speed"]
    for chart in charts:
        peaks = {s.name: float(s.y[3:-3].max()) for s in chart.series}
        assert set(peaks) == {"simulated", "reference", "captured"}
        # Zordan & Hodgins 1999, section 6: peak values similar to the raw hand's.
        assert peaks["simulated"] == pytest.approx(peaks["captured"], rel=0.2)
