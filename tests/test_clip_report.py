"""A clip before it is performed: what was changed, and the page that shows it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character import Character
from understudy.clip_report import clip_page
from understudy.errors import InvalidValue
from understudy.evaluate.preparation import preparation
from understudy.motion.samples import sample
from understudy.take import posed

CLIP = sample("walk").trimmed(0.0, 1.5)
BODY = Character.from_clip(CLIP)


def test_a_posed_take_goes_through_the_prepared_clip_and_shows_the_raw_one():
    performance = us.tracked(CLIP, BODY)
    take = posed(performance)
    reference = performance.controllers[0].reference  # type: ignore[attr-defined]
    clip = take.clip(rate=take.rate)
    np.testing.assert_allclose(clip.root_positions, reference.root_positions, atol=1e-12)
    raw, read = take.references[0], us.retargeted(CLIP, BODY)
    assert raw is not None
    np.testing.assert_array_equal(raw.rotations, read.rotations)
    assert np.ptp(raw.root_positions[:, 2] - read.root_positions[:, 2]) < 1e-12


def test_a_spike_taken_out_is_told_with_joint_and_time():
    turned = np.array(CLIP.rotations)
    joint = CLIP.skeleton.index("left_elbow")
    turned[60, joint] = [np.cos(0.6), 0.0, 0.0, np.sin(0.6)]
    found = preparation(posed(us.tracked(replace(CLIP, rotations=turned), BODY)))
    assert found.joint_peak == "left elbow"
    assert found.joint_peak_s == pytest.approx(0.5)
    assert found.joint_peak_deg > 30.0
    assert "left elbow at 0.50 s" in str(found)


def test_a_walk_has_its_stances_counted():
    found = preparation(posed(us.tracked(CLIP, BODY)))
    assert set(found.stances) == {"left", "right"}
    assert all(1 <= count <= 4 for count in found.stances.values())
    assert found.pelvis_mm < 15.0


def test_a_simulated_take_is_no_preparation():
    take = us.track(CLIP.trimmed(0.0, 0.1), BODY)
    with pytest.raises(InvalidValue, match="posed"):
        preparation(take)


def test_the_page_says_what_is_missing_and_what_was_changed():
    text = clip_page(us.tracked(CLIP, BODY))
    for part in ("Missing ", "What the ground cannot give", "pelvis", "as read", "stances"):
        assert part in text
