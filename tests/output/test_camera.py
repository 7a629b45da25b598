"""Framing: what moves fills the picture and stays in it."""

import numpy as np
import pytest

from understudy.errors import InvalidValue, UnknownName
from understudy.output.camera import VIEWS, framed


def crossing() -> tuple[np.ndarray, np.ndarray]:
    """A box of points that walks 4 m along +x; points (frames, n, 3) and its path."""
    corners = np.stack(np.meshgrid([-0.3, 0.3], [-0.4, 0.4], [0.0, 1.8]), -1).reshape(-1, 3)
    path = np.stack((np.linspace(0, 4, 121), np.zeros(121), np.ones(121)), -1)
    return corners + path[:, None] * [1, 1, 0], path


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(("width", "height"), [(640, 480), (200, 300)])
def test_every_point_stays_in_the_picture_and_one_side_is_full(
    view: str, width: int, height: int
) -> None:
    points, path = crossing()
    shot = framed(points, path, rate=30.0, view=view, aspect=width / height)
    seen = np.array(
        [shot.camera(f).project(points[f], width, height)[0] for f in range(len(points))]
    )
    inside = seen / (width, height)
    assert inside.min() > 0.0 and inside.max() < 1.0
    free = np.minimum(inside.min(axis=(0, 1)), 1 - inside.max(axis=(0, 1)))
    assert free.min() < 0.09  # the margin of 6 % is nearly used up


def test_following_camera_keeps_the_size_of_the_body() -> None:
    points, path = crossing()
    shot = framed(points, path, rate=30.0, view="follow-side")
    heights = []
    for f in (20, 60, 100):
        seen, _ = shot.camera(f).project(points[f], 640, 480)
        heights.append(np.ptp(seen[:, 1]))
    assert heights == pytest.approx([heights[0]] * 3, rel=0.01)
    assert heights[0] > 0.8 * 480


def test_camera_is_level_and_looks_at_its_target() -> None:
    points, path = crossing()
    shot = framed(points, path, rate=30.0, view="three-quarter", heading=0.7)
    camera = shot.camera(0)
    assert camera.axes @ camera.axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert camera.axes[0, 2] == 0.0
    at, depth = camera.project(shot.targets[0], 640, 480)
    assert at == pytest.approx([320, 240])
    assert depth == pytest.approx(shot.distance)


def test_walking_forward_crosses_a_side_view_from_left_to_right() -> None:
    points, path = crossing()
    shot = framed(points, path, rate=30.0, view="side")
    first, _ = shot.camera(0).project(path[0], 640, 480)
    last, _ = shot.camera(0).project(path[-1], 640, 480)
    assert last[0] > first[0]


def test_unknown_view_names_the_nearest() -> None:
    points, path = crossing()
    with pytest.raises(UnknownName, match="Did you mean 'side'"):
        framed(points, path, rate=30.0, view="sid")


def test_nothing_to_frame_is_refused() -> None:
    with pytest.raises(InvalidValue, match="nothing to frame"):
        framed(np.zeros((3, 0, 3)), np.zeros((3, 3)), rate=30.0)
