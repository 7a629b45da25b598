"""The ground: its height is what a ray finds, and wrong ground is refused."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from bodies import chain
from understudy.errors import InvalidValue
from understudy.scene import Ground, Scene, Steps

STEPS = Steps(position=(0.5, -0.3), rise=0.18, run=0.3, width=1.1, count=4, heading=0.7)
GROUNDS = (
    Ground(),
    Ground(slope=np.radians(5.0), heading=0.4),
    Ground(slope=np.radians(-12.0), heading=2.0),
    Ground(steps=STEPS),
    Ground(steps=Steps(position=(0.0, 0.0), landing=1.5)),
    Ground(slope=np.radians(6.0), heading=-1.0, steps=STEPS),
)


@pytest.mark.parametrize("ground", GROUNDS)
def test_height_and_normals_are_what_a_ray_finds(ground):
    model = Scene(characters=(chain(1),), ground=ground).model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points = np.random.default_rng(1).uniform(-2.5, 2.5, (400, 2))
    heights, normals = ground.height(points), ground.normals(points)
    found, off = np.zeros(1, np.int32), 0
    for (x, y), height, normal in zip(points, heights, normals, strict=True):
        turned = np.zeros(3)
        start = np.array([x, y, 20.0])
        away = mujoco.mj_ray(
            model, data, start, np.array([0.0, 0.0, -1.0]), None, 1, 1, found, turned
        )
        assert height == pytest.approx(20.0 - away, abs=1e-9)
        off += not np.allclose(turned, normal, atol=1e-9)
    assert off == 0


def test_height_keeps_the_shape_of_its_points():
    ground = Ground(slope=0.1, steps=STEPS)
    assert ground.height(np.zeros((3, 5, 2))).shape == (3, 5)
    assert ground.height((1.0, 2.0)).shape == ()
    assert ground.normals(np.zeros((3, 5, 3))).shape == (3, 5, 3)


def test_level_ground_is_the_plane_at_zero():
    ground = Ground()
    assert ground.level
    assert not Ground(slope=0.1).level and not Ground(steps=STEPS).level
    np.testing.assert_array_equal(ground.height(np.ones((4, 2))), 0.0)
    model = Scene(characters=(chain(1),), ground=ground).model
    np.testing.assert_array_equal(model.geom("ground").quat, [1.0, 0.0, 0.0, 0.0])


def test_a_slope_rises_toward_its_heading():
    slope, heading = np.radians(7.0), 0.9
    ground = Ground(slope=slope, heading=heading)
    ahead = 2.0 * np.array([np.cos(heading), np.sin(heading)])
    assert ground.height(ahead) == pytest.approx(2.0 * np.tan(slope))
    assert ground.height([-ahead[1], ahead[0]]) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("field", "bad"),
    [
        (field, bad)
        for field in ("position", "rise", "run", "width", "count", "heading", "landing")
        for bad in (float("nan"), -200.0, "x", (1.0,), True)
    ],
)
def test_steps_of_wrong_sizes_are_refused(field, bad):
    values: dict[str, Any] = {"position": (0.0, 0.0), field: bad}
    with pytest.raises(InvalidValue, match=field):
        Steps(**values)


@pytest.mark.parametrize("bad", [float("nan"), 2.0, "x", None])
def test_slopes_that_are_walls_are_refused(bad):
    with pytest.raises(InvalidValue, match="slope"):
        Ground(slope=bad)


def test_steps_must_be_steps():
    with pytest.raises(InvalidValue, match="Steps"):
        Ground(steps=3)  # type: ignore[arg-type]
