"""A path drawn by a user, and how a runner leans on it."""

from __future__ import annotations

import numpy as np

from understudy.athletics.course import Course
from understudy.character import athlete_man
from understudy.evaluate.chart import Chart, Series
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.papers.finding import Claim, Finding
from understudy.papers.sheets import Sheet
from understudy.performance import running
from understudy.simulate import simulate
from understudy.take import Take

SPEED = 3.5
# A runner this near to the path is on it [m]; ours.
NEAR = 0.5
_RADIUS, _STRAIGHT = 12.0, 10.0


def drawn_path() -> Array:
    """Half a circle to the left and one to the right between straights [m], shape (n, 2)."""
    turn = np.linspace(0.0, np.pi, 60)[1:]
    left = np.column_stack((np.sin(turn), 1.0 - np.cos(turn))) * _RADIUS
    right = np.column_stack((-np.sin(turn), 1.0 - np.cos(turn))) * _RADIUS
    start = np.array([[0.0, 0.0], [_STRAIGHT, 0.0]])
    first = start[-1] + left
    back = first[-1] - [_STRAIGHT, 0.0]
    second = back + right
    return np.vstack((start, first, back, second, second[-1] + [2.0 * _STRAIGHT, 0.0]))


def following(*, quick: bool = False) -> Finding:
    """A man along the path."""
    path = drawn_path()
    whole = 6.0 if quick else 30.0
    course = Course.along(path, SPEED)
    take = simulate(running(athlete_man(), course, duration=whole))
    center = take.clip(rate=100.0)
    places = center.root_positions[:, :2]
    away = course.away(places)
    stays = bool(take.qpos[:, 2].min() > 0.6)
    lean = _leans(take, path)
    turning = np.degrees(np.arctan(SPEED**2 / (9.81 * _RADIUS)))
    return Finding(
        figure="path",
        title="Along a drawn path",
        setting=f"A man at {SPEED:g} m/s on a path with straights of {_STRAIGHT:g} m and half "
        f"circles of {_RADIUS:g} m radius to the left and to the right. Lean is the pelvis's, mean "
        "over the half circle, less the straight's.",
        claims=(
            Claim(
                said="The runner runs along a user-defined path.",
                measured=f"at most {away.max():.2f} m off it (bound of ours: {NEAR:g} m)"
                + ("" if stays else "; he falls"),
                holds=stays and bool(away.max() <= NEAR),
            ),
            Claim(
                said="The body leans into the curve.",
                measured=", ".join(f"{abs(v):.1f} degrees {k}" for k, v in lean.items())
                + f"; a point mass would lean {turning:.1f}",
                holds=all(v > 1.0 for v in lean.values()),
            ),
        ),
        charts=(
            Chart(
                title="The path and the run",
                caption="Seen from above; the axes have their own scales.",
                x_label="x [m]",
                y_label="y [m]",
                series=(
                    Series(name="run", x=places[:, 0], y=places[:, 1]),
                    Series(name="path", x=path[:, 0], y=path[:, 1]),
                ),
                decimals=2,
            ),
        ),
        sheets=(
            Sheet(
                name="Path",
                caption="The run on the path.",
                head=("off the path, most [m]", "mean [m]", *(f"lean, {k} [deg]" for k in lean)),
                rows=((float(away.max()), float(away.mean()), *lean.values()),),
            ),
        ),
    )


def _leans(take: Take, path: Array) -> dict[str, float]:
    """Mean lean of the pelvis into the left and the right half circle [deg]."""
    places, turned = take.qpos[:, :2], take.qpos[:, 3:7]
    left_axis = rot.rotate(turned, np.array([0.0, 1.0, 0.0]))
    roll = np.degrees(np.arcsin(left_axis[:, 2]))  # positive: the left side is up
    middle = path[1, 1] + 2.0 * _RADIUS
    straight = roll[(take.times > 1.0) & (places[:, 0] < path[1, 0]) & (places[:, 1] < 1.0)]
    parts = {
        "to the left": (places[:, 0] > path[1, 0] + 1.0) & (places[:, 1] < middle - 2.0),
        "to the right": (places[:, 0] < path[0, 0] - 1.0) & (places[:, 1] > middle + 2.0),
    }
    base = float(straight.mean()) if len(straight) else 0.0
    out = {}
    for (name, part), sign in zip(parts.items(), (-1.0, 1.0), strict=True):
        if part.any():
            out[name] = sign * (float(roll[part].mean()) - base)
    return out
