"""Hands that bear the body are put on the floor; other hands are left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character import Character, adult_man, retargeted
from understudy.character.leaning import bearing_hands, leaning
from understudy.character.soles import point_paths
from understudy.feasibility import assess
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.samples import sample
from understudy.performance import tracked

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def man() -> Character:
    return adult_man()


def lowest_hand(clip: Clip, man: Character) -> np.ndarray:
    """Height of the lowest point of both hands [m], shape (frames,)."""
    return np.min([path[:, 2] for path in point_paths(clip, man, "hands")[0]], axis=0)


@pytest.fixture(scope="module")
def handstand(man: Character) -> Clip:
    """The middle of a standing clip upside down, its arms overhead, hands 8 cm over the floor."""
    clip = retargeted(sample("gesture").trimmed(0.0, 1.0), man)
    local = np.tile(rot.identity(), (clip.frames, len(man.links), 1))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        raised = rot.from_rotvec(np.array([sign * np.radians(80.0), 0.0, 0.0]))
        local[:, man.index(f"{side}_shoulder")] = raised
        bent = rot.from_rotvec(np.array([0.0, 0.0, -sign * np.radians(30.0)]))
        local[:, man.index(f"{side}_elbow")] = bent
    local[:, 0] = rot.from_rotvec(np.array([np.pi, 0.0, 0.0]))
    path = np.tile(UP, (clip.frames, 1))
    clip = replace(clip, rotations=local, root_positions=path)
    return replace(clip, root_positions=path - (lowest_hand(clip, man).min() - 0.08) * UP)


def test_hands_that_bear_come_to_the_floor(man, handstand):
    stood = leaning(handstand, man)
    np.testing.assert_allclose(lowest_hand(stood, man), 0.0, atol=0.003)
    assert "Put the hands that bear the body on the floor" in stood.notes[-1]


def test_hands_keep_their_orientation(man, handstand):
    before, after = (c.forward_kinematics() for c in (handstand, leaning(handstand, man)))
    for side in ("left", "right"):
        k = man.index(f"{side}_wrist")
        turned = rot.angle_between(before.rotations[:, k], after.rotations[:, k])
        np.testing.assert_allclose(turned, 0.0, atol=1e-6)


@pytest.mark.parametrize("name", ["walk", "gesture"])
def test_who_stands_on_feet_leans_on_no_hand(name, man):
    clip = retargeted(sample(name).trimmed(0.0, 2.0), man)
    assert not bearing_hands(clip, man)
    assert leaning(clip, man) is clip


@pytest.mark.clips
def test_a_cartwheel_is_borne_by_hands(clips):
    clip = us.read(clips / "cmu_bvh" / "49_06.bvh")
    assert assess(tracked(clip, us.Character.from_clip(clip))).score < 4.0
