"""Courses: commands over time, paths, and the outer loop."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.athletics import course as c
from understudy.athletics.course import Course, track_400m
from understudy.errors import InvalidValue


def test_commands_are_straight_lines_between_their_rows():
    row = np.array([1.0, 2.0, 0.0, 3.0, 4.0, 1.0])
    assert c.commanded(0.0, row, 0, 2) == (2.0, 0.0, 0.0)
    assert c.commanded(2.0, row, 0, 2) == pytest.approx((3.0, 0.5, 0.5))
    assert c.commanded(9.0, row, 0, 2) == (4.0, 1.0, 0.0)


@pytest.mark.parametrize("lane", [1, 4, 8])
def test_a_lane_of_the_track_has_its_length(lane):
    path = track_400m(lane)
    length = np.linalg.norm(np.diff(np.vstack((path, path[:1])), axis=0), axis=1).sum()
    assert length == pytest.approx(400.0 + 2 * np.pi * 1.22 * (lane - 1), abs=0.1)


def test_a_path_begins_at_its_first_point_with_its_heading():
    place, heading, speed = Course.along([[1.0, 2.0], [1.0, 9.0]], 4.0).start
    assert place == pytest.approx([1.0, 2.0])
    assert heading == pytest.approx(np.pi / 2)
    assert speed == 4.0


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"times": [0.0, 0.0], "speeds": [1.0, 1.0], "headings": [0.0, 0.0]}, "increase"),
        ({"path": [[0.0, 0.0]]}, "two points"),
        ({"turning": 0.0}, "positive"),
    ],
)
def test_a_course_that_cannot_be_run_says_why(given, word):
    with pytest.raises(InvalidValue, match=word):
        Course(**given)
