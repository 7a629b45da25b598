"""What is doubtful in a course: whatever lies outside what the runner was measured to do.

The bounds are those of the table in docs/athletics.md. Nothing here forbids anything; a course
outside of them is run as it is, and whoever asked is told.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from understudy.athletics.course import LEAST, Course
from understudy.control import Push
from understudy.motion.rotations import Array

# Steady speeds that were measured [m/s], and the least friction.
SLOWEST, FASTEST = 2.5, 5.0
LEAST_FRICTION = 0.8
# What may have made a runner fall lies this far back at most [s].
_BACK = 2.0
# The bend of a path is measured over this length [m]: shorter kinks are run straight over.
_WINDOW = 2.0


def course_doubts(course: Course, duration: float) -> tuple[str, ...]:
    """Sentences on speeds and turns that the course asks for and the runner was not measured at.

    Args:
        course: What is asked of the runner.
        duration: How long [s]; what comes later does not count.
    """
    out = []
    asked = course.speeds[course.times <= max(duration, course.times[0])]
    odd = [speed for speed in asked.tolist() if not (speed < LEAST or SLOWEST <= speed <= FASTEST)]
    if odd:
        speeds = ", ".join(f"{speed:g}" for speed in dict.fromkeys(odd))
        out.append(
            f"{speeds} m/s lies outside {SLOWEST:g} to {FASTEST:g} m/s, "
            "where the runner was measured."
        )
    turning = asked_turning(course, 0.0, duration)
    if turning > course.turning * 1.01:
        out.append(
            f"The heading asked for turns by up to {_rate(turning)}; the runner turns by "
            f"{_rate(course.turning)} at most, and lags behind."
        )
    return tuple(out)


def fall_reasons(
    course: Course, time: float, *, pushes: Sequence[Push] = (), friction: float = 1.0
) -> tuple[str, ...]:
    """What may have made a runner fall, as parts of a sentence; empty if nothing is unusual.

    Args:
        course: What was asked of the runner.
        time: When it fell [s].
        pushes: On this runner.
        friction: Of the ground.
    """
    out = []
    speed = float(np.interp(time, course.times, course.speeds))
    if speed > FASTEST or LEAST <= speed < SLOWEST:
        out.append(f"a speed of {speed:.3g} m/s (measured: {SLOWEST:g} to {FASTEST:g})")
    turning = min(asked_turning(course, time - _BACK, time), course.turning)
    if turning > Course().turning:
        out.append(f"a turn of {turning:.2f} rad/s (measured: up to {Course().turning:g})")
    elif turning == course.turning:
        out.append(f"a turn at the limit of {turning:.2f} rad/s")
    for push in pushes:
        if time - _BACK <= push.time <= time:
            size = math.hypot(*push.impulse)
            out.append(f"the push of {size:.3g} N s at {push.time:.3g} s")
    if friction < LEAST_FRICTION:
        out.append(f"friction of {friction:g} (measured: {LEAST_FRICTION:g} and more)")
    return tuple(out)


def asked_turning(course: Course, since: float, until: float) -> float:
    """Fastest change of the heading that the table asks for in a span of time [rad/s].

    Zero on a path, whose bends are `sharpest_bend`'s.
    """
    if len(course.path) or len(course.times) < 2:
        return 0.0
    rates = np.abs(np.diff(course.headings) / np.diff(course.times))
    meets = (course.times[:-1] < until) & (course.times[1:] > since)
    return float(rates[meets].max()) if meets.any() else 0.0


def sharpest_bend(course: Course) -> tuple[Array, float] | None:
    """Where the path bends most [m], shape (2,), and its radius there [m]; None if it is straight.

    The radius is a mean over 2 m of path, so that the kinks of a polygon with small angles do not
    count as corners.
    """
    rows = course.sampled()
    if not len(rows):
        return None
    if course.closed:
        rows = np.vstack((rows, rows[: len(rows) // 2]))
    spacing = float(np.linalg.norm(rows[1, :2] - rows[0, :2]))
    turns = np.diff(np.unwrap(rows[:, 2]))
    window = min(max(round(_WINDOW / spacing), 1), len(turns))
    bends = np.abs(np.convolve(turns, np.ones(window), mode="valid"))
    most = float(bends.max())
    if most < 1e-6:
        return None
    sharp = np.flatnonzero(bends > 0.999 * most)
    middle = int(sharp[len(sharp) // 2]) + window // 2
    return rows[middle, :2], window * spacing / most


def path_doubt(course: Course, most: float) -> str:
    """A sentence on a runner who left the path.

    Args:
        course: With a path.
        most: How far from it the runner was [m].
    """
    said = f"Ran up to {most:.1f} m off the path"
    speed = float(course.speeds.max())
    least = speed / course.turning
    bend = sharpest_bend(course)
    if bend is None or bend[1] >= least:
        return f"{said}."
    (x, y), radius = bend
    return (
        f"{said}: it bends on a radius of {radius:.1f} m near ({x:.3g}, {y:.3g}), "
        f"and at {speed:.3g} m/s the runner needs {least:.1f} m "
        f"({speed:.3g} m/s / {course.turning:g} rad/s); "
        "round the path there, or run slower."
    )


def _rate(turning: float) -> str:
    return f"{turning:.2f} rad/s ({math.degrees(turning):.0f} deg/s)"
