"""The edit files that come with the package do what their titles say."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import understudy as us
from understudy.edit import read_edit
from understudy.evaluate import compare
from understudy.evaluate.events import contact_events
from understudy.motion import rotations as rot
from understudy.motion.edits import joint_velocities
from understudy.motion.samples.partner import CLAPS, clap_times
from understudy.motion.samples.striking import HITS

EDITS = Path(__file__).resolve().parents[2] / "examples" / "edits"


@cache
def performed(name: str) -> us.Take:
    return us.simulate(read_edit(EDITS / f"{name}.toml").performance())


def test_each_example_has_a_test():
    tested = {"drum", "staff", "hit_and_recover", "patty_cake", "segments"}
    assert {path.stem for path in EDITS.glob("*.toml")} == tested


@pytest.mark.parametrize("path", sorted(EDITS.glob("*.toml")), ids=lambda path: path.stem)
def test_each_example_says_what_it_is(path):
    text = path.read_text(encoding="utf-8")
    assert read_edit(path).title
    assert text.startswith("# ")
    assert len(text.splitlines()) <= 70


def test_the_drum_stops_four_strokes_at_its_skin():
    events = contact_events(performed("drum"), "right_hand", "drum")
    assert [event.start_s for event in events] == pytest.approx(HITS, abs=0.03)
    assert max(event.penetration_mm for event in events) <= 2.0


def test_the_staff_stays_upright_and_recovers_from_its_push():
    take = performed("staff")
    times, _, turned = take.poses(120.0)
    axis = rot.rotate(turned[:, take.model.body("staff").id], np.array([0.0, 0.0, 1.0]))
    tilt = np.degrees(np.arccos(np.clip(axis[:, 2], -1.0, 1.0)))
    assert tilt[(times > 0.7) & (times < 3.0)].max() < 3.0
    assert tilt[(times > 3.0) & (times < 3.6)].max() > 5.0
    assert tilt[(times > 4.0)].max() < 3.0


def test_the_body_that_is_hit_comes_back_to_its_clip():
    take = performed("hit_and_recover")
    found = compare.compared(take.clip(rate=120.0), take.references[0])
    away = np.degrees(np.maximum(found.joint_angles.max(axis=1), found.root_angles))
    for hit in (0.8, 2.6, 4.3):
        during = (found.times > hit) & (found.times < hit + 0.5)
        assert away[during].max() > 5.0
    for start, end in ((2.3, 2.6), (4.1, 4.25), (5.8, 6.0)):
        assert away[(found.times > start) & (found.times < end)].max() < 5.0
    assert contact_events(take, "chest", "ball")


def test_every_clap_of_the_children_is_a_contact():
    events = contact_events(performed("patty_cake"), gap=0.1)
    mine = {"right": "right_hand", "left": "left_hand"}
    speed = 1.33
    for clap, time in zip(CLAPS, clap_times(), strict=True):
        # A clap of one hand meets the partner's same hand; of both, each the one opposite.
        pairs = [(clap, clap)] if clap != "both" else [("right", "left"), ("left", "right")]
        for a, b in pairs:
            names = (mine[a], f"b/{mine[b]}")
            assert any(
                e.between == names and abs(e.start_s - time / speed) < 0.15 for e in events
            ), f"{names} at {time / speed:.2f} s"


def test_the_segments_go_over_into_each_other_without_a_jerk():
    take = performed("segments")
    body = take.scene.characters[0]
    clips = [us.retargeted(us.sample(name), body) for name in ("walk", "gesture", "drumming")]
    fastest = max(joint_velocities(clip)[1:-1].max() for clip in clips)
    made = take.clip(rate=120.0)
    assert joint_velocities(made)[1:-1].max() < 1.3 * fastest
    assert us.score(take).fell_s is None
