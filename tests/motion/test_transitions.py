"""The finder of transition times: known answers, order, loops, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.motion import edits, samples
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.read import read
from understudy.motion.transitions import transitions


@pytest.fixture(scope="module")
def walk() -> Clip:
    return samples.sample("walk")


def test_a_part_of_a_clip_is_found_where_it_was(walk):
    part = walk.trimmed(1.0, 2.5).placed(at=(5.0, 5.0), heading=2.0)
    best = transitions(walk, part)[0]
    assert best.time_a - best.time_b == pytest.approx(1.0, abs=0.02)
    assert best.cost < 0.005


def test_they_come_best_first_and_apart(walk):
    gesture = samples.sample("gesture")
    found = transitions(gesture, walk, count=8, blend=0.4)
    assert len(found) == 8
    assert [t.cost for t in found] == sorted(t.cost for t in found)
    for k, one in enumerate(found):
        for other in found[:k]:
            apart = max(abs(one.time_a - other.time_a), abs(one.time_b - other.time_b))
            assert apart > 0.39
    for t in found:
        gesture.spliced(walk, at=t.time_a, start=t.time_b, blend=t.blend)


def test_a_walk_loops_after_whole_strides(walk):
    # One stride of the sample lasts 1.1 s (a fifth of its 5 s, less the first and last bit).
    found = transitions(walk, walk, count=3)
    strides = [(t.time_a - t.time_b) / 1.1 for t in found]
    assert np.allclose(strides, np.round(strides), atol=0.05)
    assert min(strides) > 0.9
    best = found[0]
    loop = walk.trimmed(best.time_b, best.time_a).looped(3)
    speed, own = (np.linalg.norm(edits.joint_velocities(c), axis=-1).max() for c in (loop, walk))
    assert speed < 1.02 * own


def test_time_is_kept_on_both_sides(walk):
    for t in transitions(walk, samples.sample("gesture"), keep=1.0):
        assert t.time_a >= 1.0 - 1e-9
        assert t.time_b + t.blend <= 5.0 + 1e-9


def test_feet_of_opposite_sides_cost_more(walk):
    half = walk.trimmed(0.55, 4.0)  # half a stride on: left for right
    shifted = transitions(walk, half, count=1)[0]
    assert (shifted.time_a - shifted.time_b) % 1.1 == pytest.approx(0.55, abs=0.05)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"count": 0}, "count is 0"),
        ({"blend": 0.0}, "blend is 0"),
        ({"blend": 9.0}, "does not fit"),
        ({"keep": -1.0}, "keep is -1"),
        ({"keep": 4.9}, "does not fit"),
    ],
)
def test_senseless_searches_are_refused(walk, options, text):
    with pytest.raises(InvalidValue, match=text):
        transitions(walk, walk, **options)


@pytest.mark.clips
@pytest.mark.parametrize(("first", "second"), [("02_01", "02_03"), ("35_01", "35_17")])
def test_real_clips_go_over_into_each_other_without_haste(clips, first, second):
    a, b = (read(clips / "cmu_bvh" / f"{name}.bvh").repaired() for name in (first, second))
    hands = [a.skeleton.index(name) for name in ("LeftHand", "RightHand")]

    def peak(clip: Clip) -> float:
        places = clip.forward_kinematics().positions[:, hands]
        return float(np.linalg.norm(np.diff(places, axis=0), axis=-1).max() * clip.rate)

    for t in transitions(a, b, count=3):
        out = a.spliced(b, at=t.time_a, start=t.time_b)
        assert peak(out) <= 1.3 * max(peak(a), peak(b))
        turns = [rot.angle_between(c.rotations[1:], c.rotations[:-1]).max() for c in (out, a, b)]
        assert turns[0] < max(turns[1:]) + np.radians(3.0)


def test_a_clip_that_lasts_just_one_blend_has_its_transition():
    short, other = samples.sample("gesture").trimmed(0.0, 0.59), samples.sample("clapping")
    (found,) = transitions(short, other, count=1, blend=short.duration)
    assert found.time_a == 0.0
