"""The head turns to what is looked at."""

from __future__ import annotations

import numpy as np
import pytest

import understudy as us
from understudy.character import adult_man
from understudy.control import LookAt
from understudy.errors import InvalidValue, UnknownName
from understudy.motion import rotations as rot
from understudy.scene import Ball


@pytest.fixture(scope="module")
def clip() -> us.Clip:
    return us.sample("gesture").trimmed(0.0, 1.5)


def gaze(take: us.Take) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], positions of the eyes [m] and unit directions of the face."""
    times, placed, turned = take.poses(60.0)
    head = take.model.body("head").id
    height = take.scene.characters[0].height
    eyes = placed[:, head] + rot.rotate(turned[:, head], np.array([0.05, 0.0, 0.088]) * height)
    return times, eyes, rot.rotate(turned[:, head], np.array([1.0, 0.0, 0.0]))


@pytest.mark.parametrize("target", [(2.0, 1.5, 1.6), (1.5, -1.0, 0.9), (1.0, 0.0, 2.4)])
def test_the_face_points_at_the_target(clip, target):
    times, eyes, face = gaze(us.track(clip, adult_man(), tasks=[LookAt(target=target)]))
    way = np.array(target) - eyes
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    off = np.degrees(np.arccos(np.clip(np.sum(way * face, axis=1), -1.0, 1.0)))
    assert off[times > 0.5].max() < 1.5


def test_what_is_behind_is_looked_at_as_far_as_the_neck_goes(clip):
    limit = (np.radians(50.0), np.radians(40.0))
    take = us.track(clip, adult_man(), tasks=[LookAt(target=(-3.0, 1.0, 1.6), limit=limit)])
    times, _, face = gaze(take)
    chest = take.poses(60.0)[2][:, take.model.body("chest").id]
    ahead = rot.rotate(chest, np.array([1.0, 0.0, 0.0]))
    turned = np.degrees(np.arccos(np.clip(np.sum(ahead * face, axis=1), -1.0, 1.0)))
    assert turned[times > 0.5].max() < 51.5
    assert turned[times > 0.5].min() > 48.5
    assert face[-1, 1] > 0.5  # to the left, where the target is nearer


def test_a_target_at_the_feet_is_not_looked_at_through_the_chest(clip):
    times, _, face = gaze(us.track(clip, adult_man(), tasks=[LookAt(target=(0.3, 0.0, 0.0))]))
    down = np.degrees(np.arcsin(-face[times > 0.5][:, 2]))
    assert 40.0 < down.min() < down.max() < 50.0


def test_a_falling_ball_is_followed(clip):
    ball = Ball(position=(1.5, 0.6, 2.0))
    take = us.track(clip, adult_man(), props=[ball], tasks=[LookAt(target="ball/center")])
    times, eyes, face = gaze(take)
    way = take.poses(60.0)[1][:, take.model.body("ball").id] - eyes
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    off = np.degrees(np.arccos(np.clip(np.sum(way * face, axis=1), -1.0, 1.0)))
    assert off[times > 0.4].max() < 6.0


def test_wrong_targets_are_refused(clip):
    with pytest.raises(InvalidValue, match=r"limit is .* it must be two angles"):
        LookAt(target=(1, 0, 1), limit=(0.0, 1.0))
    with pytest.raises(InvalidValue, match="target has shape"):
        LookAt(target=(1, 0))  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="'bal'"):
        us.simulate(us.tracked(clip, adult_man(), tasks=[LookAt(target="bal")]))
