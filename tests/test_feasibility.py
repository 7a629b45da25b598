"""The force a clip needs and the ground cannot give, and what it looks like."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import understudy as us
from understudy.character import Character, adult_woman
from understudy.errors import InvalidValue
from understudy.feasibility import assess
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import sample
from understudy.performance import Performance, tracked

BODY = adult_woman()
GRAVITY = 9.81


def held(clip: Clip, body: Character = BODY) -> Performance:
    """The performance whose reference is exactly this clip on the body's skeleton."""
    performance = tracked(clip, body)
    tracking: Any = performance.controllers[0]
    return replace(performance, controllers=(replace(tracking, reference=clip),))


def statue(seconds: float = 1.0) -> Clip:
    """The body standing still."""
    performance = tracked(sample("gesture").trimmed(0.0, 0.2), BODY)
    pose: Any = getattr(performance.controllers[0], "reference", None)
    frames = round(seconds * pose.rate) + 1
    return replace(
        pose,
        rotations=np.repeat(pose.rotations[:1], frames, axis=0),
        root_positions=np.repeat(pose.root_positions[:1], frames, axis=0),
    )


def raised(clip: Clip, height: Any) -> Clip:
    path = np.array(clip.root_positions)
    path[:, 2] += height
    return replace(clip, root_positions=path)


def test_a_body_that_stands_still_is_borne_by_the_ground():
    found = assess(held(statue()))
    assert found.score < 0.1
    assert str(found) == "0 %: will stand free."
    np.testing.assert_allclose(found.ground, 100.0, atol=0.2)


def test_a_body_too_weak_for_it_is_told_where_and_when():
    strong = assess(held(statue()))
    assert strong.strain is not None and strong.strain.share < 0.3
    links = [
        link if link.torque_limit is None else replace(link, torque_limit=0.01 * link.torque_limit)
        for link in BODY.links
    ]
    weak = assess(held(statue(), replace(BODY, links=tuple(links))))
    assert weak.strain is not None and weak.strain.joint == strong.strain.joint
    assert weak.strain.share == pytest.approx(100.0 * strong.strain.share)
    assert weak.outlook == "will need help from above"
    assert "times a person's strength at" in str(weak)
    told = weak.as_dict()
    assert told["strain_percent"] == pytest.approx(100.0 * weak.strain.share)
    assert told["strain_joint"] == weak.strain.joint


def test_of_a_body_of_unknown_strength_no_strain_is_told():
    links = tuple(replace(link, torque_limit=None) for link in BODY.links)
    found = assess(held(statue(), replace(BODY, links=links)))
    assert found.strain is None and found.as_dict()["strain_percent"] is None
    assert found.outlook == "will stand free"


def test_a_clip_of_a_moment_is_too_short_to_tell():
    found = assess(held(raised(statue(0.1), 0.3)))
    assert found.outlook == "too short to tell"
    assert str(found) == "100 %: too short to tell; it takes 0.15 s."
    assert assess(held(raised(statue(0.15), 0.3))).outlook == "will need help from above"


def test_a_body_that_hangs_in_the_air_lacks_its_whole_weight():
    found = assess(held(raised(statue(), 0.3)))
    assert found.score == pytest.approx(100.0, abs=0.1)
    np.testing.assert_allclose(found.force[:, 2], 100.0, atol=0.1)
    assert found.moments[0].cause == "floor"
    assert "something 30 cm high" in found.moments[0].looks


def test_free_fall_lacks_nothing():
    still = statue(0.6)
    fall = 0.5 * GRAVITY * still.times * (0.6 - still.times)
    assert assess(held(raised(still, 0.05 + fall))).score < 0.5


def test_a_jump_played_at_the_wrong_rate_falls_at_the_wrong_rate():
    still = statue(0.6)
    fall = 0.5 * GRAVITY * still.times * (0.6 - still.times)
    slow = raised(still, 0.05 + 0.36 * fall)
    found = assess(held(slow))
    assert found.score == pytest.approx(64.0, abs=1.0)
    assert found.moments[0].cause == "flight"
    assert "falls with 4 m/s2" in found.moments[0].looks


def test_a_body_that_leans_on_a_hand_is_told_so():
    """Tilted forward past its toes: only a hand or the trunk could hold it."""
    still = statue()
    tilt = rot.from_euler("Y", np.full((still.frames, 1), 0.45))
    base = np.array([*still.root_positions[0, :2], 0.0])
    leaning = replace(
        still,
        rotations=np.concatenate(
            (rot.multiply(tilt, still.rotations[:, 0])[:, None], still.rotations[:, 1:]), axis=1
        ),
        root_positions=base + rot.rotate(tilt, still.root_positions - base),
    )
    found = assess(held(leaning))
    assert found.score > 10.0
    assert (found.moments[0].cause, found.moments[0].part) == ("support", "back")
    assert "looks like the back on something that is not in the scene" in str(found)


def test_a_glitch_is_named_with_its_joint_and_time():
    still = statue()
    turned = np.array(still.rotations)
    joint = BODY.index("lower_back")
    kick = 2.0 * np.exp(-(((still.times - 0.5) / 0.03) ** 2))
    turned[:, joint] = rot.multiply(turned[:, joint], rot.from_euler("Y", kick[:, None]))
    found = assess(held(replace(still, rotations=turned)))
    worst = found.moments[0]
    assert (worst.cause, worst.part) == ("glitch", "lower back")
    assert worst.start < 0.5 < worst.end
    assert "the lower back turns at" in str(found)


def test_the_score_is_that_of_the_mirror_image():
    """The body is not quite its own mirror image: left and right are within 1 %."""
    walk = sample("walk").trimmed(0.5, 2.0)
    scores = [
        assess(tracked(clip, Character.from_clip(clip))).score for clip in (walk, walk.mirrored())
    ]
    assert scores[0] == pytest.approx(scores[1], rel=0.05, abs=0.02)


def test_a_led_upper_body_has_no_ground_to_be_judged_by():
    clip = sample("gesture")
    with pytest.raises(InvalidValue, match="no ground"):
        assess(tracked(clip, Character.from_clip(clip, plan="upper")))


def test_a_performance_without_a_clip_is_refused():
    with pytest.raises(InvalidValue, match="tracks no clip"):
        assess(replace(held(statue()), controllers=()))


@pytest.mark.clips
@pytest.mark.parametrize(("name", "most"), [("cmu_bvh/02_01.bvh", 3.0), ("cmu_bvh/29_01.bvh", 2.0)])
def test_captured_walks_score_a_few_percent(name, most, clips):
    clip = us.read(clips / name)
    assert assess(us.tracked(clip, us.Character.from_clip(clip))).score < most
