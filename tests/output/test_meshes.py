"""Triangles of every shape: closed, right way out, as large as the shape."""

import mujoco
import numpy as np
import pytest

from understudy.output import meshes


def volume(points: np.ndarray, triangles: np.ndarray) -> float:
    """By the divergence theorem; negative when triangles face inward, wrong when open."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def one(xml: str) -> meshes.Surface:
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><asset><mesh name='cube' vertex='-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 "
        f"-1 1 1 1 1 1'/></asset><worldbody><body pos='1 2 3'><freejoint/>{xml}</body></worldbody>"
        "</mujoco>"
    )
    (surface,) = meshes.surfaces(model)
    return surface


@pytest.mark.parametrize(
    ("xml", "exact"),
    [
        ("<geom type='sphere' size='.5'/>", 4 / 3 * np.pi * 0.5**3),
        ("<geom type='capsule' size='.2 .6' pos='1 0 0'/>", np.pi * 0.04 * (1.2 + 4 / 3 * 0.2)),
        ("<geom type='cylinder' size='.3 .4' euler='30 40 50'/>", np.pi * 0.09 * 0.8),
        ("<geom type='ellipsoid' size='.1 .2 .3' euler='90 0 0'/>", 4 / 3 * np.pi * 0.006),
        ("<geom type='box' size='.1 .2 .3' pos='0 1 0' euler='10 20 30'/>", 8 * 0.006),
        ("<geom type='mesh' mesh='cube'/>", 8.0),
    ],
)
def test_surface_encloses_the_volume_of_its_shape(xml: str, exact: float) -> None:
    surface = one(xml)
    centered = surface.points - surface.points.mean(axis=0)
    assert volume(centered, surface.triangles) == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder", "ellipsoid", "box"])
def test_normals_are_unit_and_point_the_way_triangles_face(kind: str) -> None:
    surface = one(f"<geom type='{kind}' size='.1 .2 .3' euler='20 50 70'/>")
    assert np.linalg.norm(surface.normals, axis=1) == pytest.approx(1.0)
    corners = surface.points[surface.triangles]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    solid = np.linalg.norm(facing, axis=1) > 1e-9
    means = surface.normals[surface.triangles].mean(axis=1)
    assert (np.einsum("ij,ij->i", facing, means)[solid] > 0).all()


def test_meshes_keep_sharp_edges_and_smooth_round_ones() -> None:
    cube = one("<geom type='mesh' mesh='cube'/>")
    assert len(cube.points) == 24  # three normals at each of the eight corners
    assert np.abs(cube.normals).max(axis=1) == pytest.approx(1.0, abs=1e-6)
    points, _, triangles = meshes.sphere(np.ones(3))
    _, normals, _ = meshes.creased(points, triangles)
    ball, _, _ = meshes.creased(points, triangles)
    assert np.einsum("ij,ij->i", ball, normals).min() > 0.97


def test_hidden_groups_and_transparent_shapes_are_left_out() -> None:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom size='1' group='3'/><geom size='1' rgba='1 1 1 0'/>"
        "<geom type='plane' size='1 1 1'/><geom size='2'/></worldbody></mujoco>"
    )
    (seen,) = meshes.surfaces(model)
    assert np.abs(seen.points).max() == pytest.approx(2.0, rel=0.01)
    assert meshes.planes(model).tolist() == [2]


def test_outline_reaches_as_far_as_the_surface(model: mujoco.MjModel) -> None:
    bodies, points = meshes.outline(model)
    for surface in meshes.surfaces(model):
        mine = points[bodies == surface.body]
        assert (mine.max(axis=0) >= surface.points.max(axis=0) - 1e-9).all()
        assert (mine.min(axis=0) <= surface.points.min(axis=0) + 1e-9).all()
