"""Words of the command line as a course."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.app.courses import course_from, points_of
from understudy.errors import InvalidValue, UnderstudyError


def test_a_path_is_read_from_a_file(tmp_path):
    file = tmp_path / "path.txt"
    file.write_text("# a corner\n0 0\n10 0\n10, 10\n")
    course = course_from(speed="3.5", path=str(file), seconds=5.0)
    assert course.path == pytest.approx(np.array([[0, 0], [10, 0], [10, 10]]))
    assert not course.closed


def test_speeds_and_headings_over_time_share_one_table():
    course = course_from(speed="0:2.5,4:5", heading="0:0,2:90", seconds=5.0)
    assert course.times.tolist() == [0.0, 2.0, 4.0]
    assert course.speeds == pytest.approx([2.5, 3.75, 5.0])
    assert np.degrees(course.headings) == pytest.approx([0.0, 90.0, 90.0])


@pytest.mark.parametrize("word", ["fast", "nan", "-1", "0:3,2:-1", "1:2:3"])
def test_a_speed_that_is_none_says_what_it_may_be(word):
    with pytest.raises(InvalidValue, match=f"--speed is '{word}'; .*must be"):
        course_from(speed=word, seconds=5.0)


def test_a_part_without_a_time_is_named():
    with pytest.raises(InvalidValue, match="--speed is '4'; it must be TIME:NUMBER"):
        course_from(speed="0:2.5,4", seconds=5.0)


@pytest.mark.parametrize("word", ["2:3,1:4", "0:3,0:4"])
def test_times_that_do_not_increase_are_refused(word):
    for option in ("speed", "heading"):
        with pytest.raises(InvalidValue, match=f"--{option} is '{word}'; after .* must increase"):
            course_from(**{"speed": "3.5", "seconds": 5.0} | {option: word})


@pytest.mark.parametrize(
    ("text", "line", "found"),
    [
        (b"0 0\n# b\na b\n", 3, "'a b'; expected two numbers"),
        (b"0 0\n1 2 3\n", 2, "'1 2 3'; expected two numbers"),
        (b"0 0\nnan 1\n", 2, "'nan 1'; expected two numbers"),
        (b"0 0\n\xff 1\n", 2, r"xff 1'; expected two numbers"),
        (b"0 0\n0, 0\n", 2, "'0, 0', the point before it again"),
    ],
)
def test_a_line_that_is_no_point_is_named(tmp_path, text, line, found):
    file = tmp_path / "path.txt"
    file.write_bytes(text)
    with pytest.raises(UnderstudyError, match=f"path.txt:{line}: found .*{found}"):
        points_of(file)


def test_one_point_is_no_path(tmp_path):
    file = tmp_path / "path.txt"
    file.write_bytes(b"\xef\xbb\xbf0 0\n")
    with pytest.raises(UnderstudyError, match="found 1 of two or more"):
        points_of(file)


def test_a_run_from_standing_to_standing_ends_with_time_to_settle():
    course = course_from(speed="3", seconds=12.0, standing=True, stop=True)
    assert course.speeds.tolist() == [0.0, 0.0, 3.0, 3.0, 0.0]
    assert course.times == pytest.approx([0.0, 1.0, 1.01, 7.5, 7.51])
    with pytest.raises(InvalidValue, match=r"--seconds is 5; with --stop it must be over 5\.5"):
        course_from(speed="3", seconds=5.0, standing=True, stop=True)
