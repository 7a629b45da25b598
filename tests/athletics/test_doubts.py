"""What is said of courses outside the measured."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.athletics.course import Course, track_400m
from understudy.athletics.doubts import (
    course_doubts,
    fall_reasons,
    path_doubt,
    sharpest_bend,
)
from understudy.control import Push


def table(times, speeds, headings):
    return Course(times=np.array(times), speeds=np.array(speeds), headings=np.array(headings))


@pytest.mark.parametrize("speed", [2.5, 3.5, 5.0])
def test_a_measured_course_leaves_no_doubt(speed):
    assert course_doubts(Course.steady(speed), 20.0) == ()
    assert course_doubts(Course.along(track_400m(), speed, closed=True), 20.0) == ()


def test_standing_and_starting_are_no_doubtful_speeds():
    course = table([0.0, 1.0, 1.01], [0.0, 0.0, 3.5], [0.0] * 3)
    assert course_doubts(course, 9.0) == ()


@pytest.mark.parametrize("speed", [1.5, 6.0])
def test_a_speed_outside_the_measured_is_said(speed):
    (said,) = course_doubts(Course.steady(speed), 9.0)
    assert said.startswith(f"{speed:g} m/s lies outside 2.5 to 5 m/s")


def test_what_comes_after_the_end_is_not_doubted():
    assert course_doubts(table([0.0, 30.0], [3.0, 8.0], [0.0, 0.0]), 20.0) == ()


def test_a_heading_that_turns_too_fast_is_said():
    course = table([0.0, 1.0, 3.0], [3.5] * 3, [0.0, 0.0, 1.2])
    (said,) = course_doubts(course, 9.0)
    assert "up to 0.60 rad/s (34 deg/s)" in said and "0.35 rad/s (20 deg/s) at most" in said
    assert course_doubts(course, 1.0) == ()


def test_reasons_for_a_fall_lie_just_before_it():
    course = table([0.0, 1.0, 3.0], [3.5] * 3, [0.0, 0.0, 1.2])
    push = Push(time=2.0, impulse=(30.0, 40.0, 0.0))
    assert fall_reasons(course, 2.5, pushes=[push]) == (
        "a turn at the limit of 0.35 rad/s",
        "the push of 50 N s at 2 s",
    )
    assert fall_reasons(course, 9.0, pushes=[push]) == ()
    assert fall_reasons(Course.steady(6.0), 1.0, friction=0.5) == (
        "a speed of 6 m/s (measured: 2.5 to 5)",
        "friction of 0.5 (measured: 0.8 and more)",
    )


def test_a_circle_bends_on_its_radius():
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    circle = 20.0 * np.column_stack((np.cos(angle), np.sin(angle)))
    found = sharpest_bend(Course.along(circle, 3.5, closed=True))
    assert found is not None and found[1] == pytest.approx(20.0, rel=0.02)
    assert sharpest_bend(Course.along([[0, 0], [9, 0]], 3.5)) is None
    assert sharpest_bend(Course.steady(3.5)) is None


def test_a_corner_is_found_also_where_a_path_closes():
    square = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0]]
    found = sharpest_bend(Course.along(square, 3.5))
    assert found is not None and found[0] == pytest.approx([20.0, 0.0], abs=0.3)
    drop = [
        [0.0, 0.0],
        *([10 + 10 * np.sin(a), 10 * np.cos(a)] for a in np.linspace(2.9, 0.24, 60)),
    ]
    found = sharpest_bend(Course.along(drop, 3.5, closed=True))
    assert found is not None and np.linalg.norm(found[0]) < 1.0


def test_a_runner_off_a_gentle_path_is_not_told_of_corners():
    assert path_doubt(Course.along([[0, 0], [90, 0]], 3.5), 1.0) == "Ran up to 1.0 m off the path."
    corner = Course.along([[0, 0], [10, 0], [10, 10]], 3.5)
    assert "needs 10.0 m (3.5 m/s / 0.35 rad/s)" in path_doubt(corner, 7.0)
