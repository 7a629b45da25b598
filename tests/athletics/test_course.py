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
        ({"speeds": [-1.0]}, "0 m/s or more"),
    ],
)
def test_a_course_that_cannot_be_run_says_why(given, word):
    with pytest.raises(InvalidValue, match=word):
        Course(**given)


def test_the_lane_beside_is_so_far_to_the_right():
    straight = Course.steady(3.5, heading=np.pi / 2)
    assert straight.beside(1.22).start[0] == pytest.approx([1.22, 0.0])
    angle = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    circle = np.column_stack((np.cos(angle), np.sin(angle)))
    lane = Course.along(10.0 * circle, 3.5, closed=True).beside(1.0)
    assert np.linalg.norm(lane.path, axis=1) == pytest.approx(11.0, abs=0.02)


def test_how_far_away_a_place_is():
    square = Course.along([[0, 0], [4, 0], [4, 4], [0, 4]], 3.5, closed=True)
    places = [[2.0, 0.5], [5.0, 5.0], [-0.25, 2.0]]
    assert square.away(places) == pytest.approx([0.5, np.sqrt(2.0), 0.25])
    with pytest.raises(InvalidValue, match="no path"):
        Course.steady(3.5).away(places)


def test_places_past_the_end_of_an_open_path_are_none_of_it():
    places = [[1.0, 0.0], [4.0, 3.0], [4.2, 3.9], [4.0, 4.5], [4.0, 9.0]]
    corner = [[0, 0], [4, 0], [4, 4]]
    assert Course.along(corner, 3.5).ended(places) == 3
    assert Course.along(corner, 3.5, closed=True).ended(places) == 5


def test_a_lane_that_would_fold_on_itself_is_refused():
    angle = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    circle = 2.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    with pytest.raises(InvalidValue, match="sharply"):
        Course.along(circle, 3.5, closed=True).beside(-3.0)
