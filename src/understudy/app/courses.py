"""The words of a command that say where an athlete is to go, read as a course."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from understudy.errors import InvalidValue, UnderstudyError

if TYPE_CHECKING:
    from understudy.athletics.course import Course
    from understudy.motion.rotations import Array

# How long an athlete stands before a run, a step in the speed [s]; how fast a stop brakes [m/s^2],
# and how long it stands after it [s].
_STANDS, _AT_ONCE, _BRAKES, _SETTLES = 1.0, 0.01, 1.5, 2.5
# The ends of a closed path are no farther apart [m].
_CLOSED = 1.0


def course_from(
    *,
    speed: str,
    heading: str = "0",
    path: str | None = None,
    seconds: float,
    standing: bool = False,
    stop: bool = False,
) -> Course:
    """The course that `--speed`, `--heading`, `--path`, `--start standing` and `--stop` ask for.

    Raises:
        InvalidValue: A word has another form, a speed is negative, times do not increase, or there
            is no time to stop.
        UnderstudyError: The file of points has a line that is none.
    """
    import numpy as np

    from understudy.athletics.course import Course, track_400m

    speeds, headings = _steps("--speed", speed), _steps("--heading", heading)
    if min(value for _, value in speeds) < 0.0:
        raise InvalidValue(f"--speed is {speed!r}; a speed must be 0 m/s or more.")
    if standing:
        speeds = _from_standing(speeds)
    if stop:
        speeds = _to_standing(speeds, seconds)
    times = sorted({time for time, _ in (*speeds, *headings)})
    rows = [
        np.interp(times, [time for time, _ in steps], [value for _, value in steps])
        for steps in (speeds, headings)
    ]
    points, closed = np.zeros((0, 2)), False
    if path == "track-400m":
        points, closed = track_400m(), True
    elif path is not None:
        points = points_of(Path(path))
        closed = len(points) > 3 and bool(np.linalg.norm(points[0] - points[-1]) < _CLOSED)
        points = points[:-1] if closed else points
    return Course(
        times=np.array(times),
        speeds=rows[0],
        headings=np.radians(rows[1]),
        path=points,
        closed=closed,
    )


def numbers(option: str, word: str, form: str, count: int) -> list[float]:
    """So many finite numbers between colons and commas.

    Raises:
        InvalidValue: The word has another form.
    """
    try:
        found = [float(part) for part in word.replace(":", ",").split(",")]
    except ValueError:
        found = []
    if len(found) != count or not all(map(math.isfinite, found)):
        raise InvalidValue(f"{option} is {word!r}; it must be {form}.")
    return found


def points_of(file: Path) -> Array:
    """The points of a file, a line of X Y in meters each [m], shape (points, 2).

    Empty lines and lines that begin with # do not count.

    Raises:
        UnderstudyError: A line holds something else or the point before it, or there are too few.
    """
    import numpy as np

    rows: list[tuple[float, float]] = []
    for number, line in enumerate(file.read_bytes().removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        text = line.decode("utf-8", errors="backslashreplace").strip()
        if not text or text.startswith("#"):
            continue
        point = _point(text)
        if point is None:
            shown = text if len(text) <= 40 else f"{text[:40]}..."
            raise UnderstudyError(
                f"{file}:{number}: found {shown!r}; expected two numbers, X and Y in meters."
            )
        if rows and point == rows[-1]:
            raise UnderstudyError(
                f"{file}:{number}: found {text!r}, the point before it again; "
                "expected another point."
            )
        rows.append(point)
    if len(rows) < 2:
        raise UnderstudyError(f"{file}: found {len(rows)} of two or more points, X Y in meters.")
    return np.array(rows)


def _point(text: str) -> tuple[float, float] | None:
    try:
        x, y = (float(part) for part in text.replace(",", " ").split())
    except ValueError:
        return None
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None


def _from_standing(speeds: list[tuple[float, float]]) -> list[tuple[float, float]]:
    late = [(time, speed) for time, speed in speeds if time > _STANDS + _AT_ONCE]
    return [(0.0, 0.0), (_STANDS, 0.0), (_STANDS + _AT_ONCE, speeds[0][1]), *late]


def _to_standing(speeds: list[tuple[float, float]], seconds: float) -> list[tuple[float, float]]:
    since, last = speeds[-1]
    stop = seconds - last / _BRAKES - _SETTLES
    if stop <= since:
        raise InvalidValue(
            f"--seconds is {seconds:g}; with --stop it must be over {since + seconds - stop:.1f}."
        )
    return [*speeds, (stop, last), (stop + _AT_ONCE, 0.0)]


def _steps(option: str, word: str) -> list[tuple[float, float]]:
    """One number, or TIME:NUMBER,TIME:NUMBER,..., with times that increase."""
    if ":" not in word:
        return [(0.0, numbers(option, word, "a number", 1)[0])]
    pairs = [numbers(option, part, "TIME:NUMBER,TIME:NUMBER,...", 2) for part in word.split(",")]
    steps = [(time, value) for time, value in pairs]
    for (before, _), (time, _) in pairwise(steps):
        if time <= before:
            raise InvalidValue(
                f"{option} is {word!r}; after {before:g} s comes {time:g} s; times must increase."
            )
    return steps
