"""Pictures without a graphics library: the right pixels, the same every time."""

import mujoco
import numpy as np
import pytest

from understudy.output import meshes
from understudy.output.camera import Camera
from understudy.output.playback import Playback
from understudy.output.raster import Shapes
from understudy.output.renderer import opened
from understudy.output.software import SoftwareRenderer

BALL = """<mujoco><worldbody>{ground}<body name='ball' pos='0 0 1'>
<joint type='slide' axis='0 1 0'/><geom size='.5' rgba='1 0 0 1'/></body></worldbody></mujoco>"""


def ahead() -> Camera:
    """From 4 m ahead at the height of the ball."""
    axes = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
    return Camera(position=np.array([4.0, 0.0, 1.0]), axes=axes, field_of_view=np.radians(30))


def red(picture: np.ndarray) -> np.ndarray:
    return picture[..., 0].astype(int) > picture[..., 2].astype(int) + 40


def test_sphere_covers_the_pixels_of_its_projection() -> None:
    model = mujoco.MjModel.from_xml_string(BALL.format(ground=""))
    picture = SoftwareRenderer(model, 320, 240).picture(np.zeros(1), ahead())
    # The outline is a circle at the angle asin(r / d) off the axis.
    radius = 120 * np.tan(np.arcsin(0.5 / 4.0)) / np.tan(np.radians(15))
    assert red(picture).sum() == pytest.approx(np.pi * radius**2, rel=0.02)
    rows, columns = np.nonzero(red(picture))
    assert rows.mean() == pytest.approx(119.5, abs=0.5)
    assert columns.mean() == pytest.approx(159.5, abs=0.5)


def test_moving_left_in_the_world_moves_to_the_left_of_someone_facing_it() -> None:
    model = mujoco.MjModel.from_xml_string(BALL.format(ground=""))
    picture = SoftwareRenderer(model, 160, 120).picture(np.array([0.5]), ahead())
    assert np.nonzero(red(picture))[1].mean() > 100  # +y is to the right seen from +x


def test_pictures_are_the_same_every_time(playing: Playback) -> None:
    shot = playing.shot("follow", 4 / 3)

    def drawn() -> np.ndarray:
        drawing = opened(playing.model, 160, 120, renderer="software", ghost_bodies=(1, 2, 3))
        return drawing.picture(playing.qpos[10], shot.camera(10), ghost=playing.ghost[10])

    assert np.array_equal(drawn(), drawn())


def test_body_throws_a_shadow_on_the_ground_only() -> None:
    ground = "<geom type='plane' size='0 0 1'/>"
    model = mujoco.MjModel.from_xml_string(BALL.format(ground=ground))
    camera = Camera(
        position=np.array([4.0, 0.0, 2.5]),
        axes=np.array([[0.0, 1.0, 0.0], [-0.4, 0.0, 0.9165151], [-0.9165151, 0.0, -0.4]]),
        field_of_view=np.radians(45),
    )
    lit = SoftwareRenderer(model, 160, 120, shadows=False).picture(np.zeros(1), camera).astype(int)
    dark = SoftwareRenderer(model, 160, 120).picture(np.zeros(1), camera).astype(int)
    ground_only = ~red(lit) & ~red(dark)
    change = (lit - dark).max(axis=2)
    assert (change[ground_only] > 15).sum() > 200
    assert (change[ground_only] >= -1).all()


def test_ghost_tints_only_where_it_is_not_behind_the_body(playing: Playback) -> None:
    shot = playing.shot("follow-side", 4 / 3)
    drawing = SoftwareRenderer(
        playing.model, 160, 120, ghost_bodies=tuple(range(1, playing.model.nbody))
    )
    without = drawing.picture(playing.qpos[8], shot.camera(8))
    same = drawing.picture(playing.qpos[8], shot.camera(8), ghost=playing.qpos[8])
    ahead_of_it = drawing.picture(playing.qpos[8], shot.camera(8), ghost=playing.ghost[8])
    # Where both coincide only the simulated body is seen, but for the soft rim of edge pixels.
    assert (np.abs(same.astype(int) - without).max(axis=2) > 12).mean() < 0.02
    assert (np.abs(ahead_of_it.astype(int) - without).max(axis=2) > 12).mean() > 0.01


def test_edges_are_smoothed() -> None:
    model = mujoco.MjModel.from_xml_string(BALL.format(ground=""))
    picture = SoftwareRenderer(model, 320, 240).picture(np.zeros(1), ahead()).astype(int)
    row = picture[120, :, 1]
    left = int(np.nonzero(red(picture)[120])[0][0])
    steps = np.abs(np.diff(row[left - 3 : left + 3]))
    assert np.count_nonzero(steps > 3) >= 2  # at least one pixel in between


def test_scene_without_ground_or_body_is_drawn() -> None:
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    picture = SoftwareRenderer(model, 64, 48).picture(np.zeros(0), ahead())
    assert picture.shape == (48, 64, 3) and picture.dtype == np.uint8


def test_pixels_see_the_bodies_that_the_engine_s_rays_hit(playing: Playback) -> None:
    """The engine's exact shapes, met by one ray through the middle of every pixel."""
    width, height = 80, 60
    camera = playing.shot("follow", width / height).camera(12)
    model, qpos = playing.model, playing.qpos[12]
    shapes = Shapes(model, meshes.surfaces(model))
    shapes.pose(qpos)
    seen = shapes.seen(camera, width, height)
    ours = np.zeros(width * height, int)
    ours[seen.pixel] = seen.body
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    x, y = np.meshgrid(np.arange(0.5, width), np.arange(0.5, height))
    slope = np.tan(0.5 * camera.field_of_view) / (0.5 * height)
    rays = np.stack(((x - width / 2) * slope, (height / 2 - y) * slope, np.ones_like(x)), -1)
    rays = rays.reshape(-1, 3) @ camera.axes
    geom, hits = np.zeros(1, np.int32), np.zeros(width * height, int)
    distance = np.full(width * height, np.nan)
    for k, ray in enumerate(rays):
        far = mujoco.mj_ray(model, data, camera.position, ray, None, 1, -1, geom)
        if geom[0] >= 0 and model.geom_type[geom[0]] != mujoco.mjtGeom.mjGEOM_PLANE:
            hits[k], distance[k] = model.geom_bodyid[geom[0]], far * np.linalg.norm(ray)
    body = (hits > 0) | (ours > 0)
    assert (hits == ours)[body].mean() > 0.93
    both = np.flatnonzero((hits == ours)[seen.pixel])
    ahead_of_eye = np.linalg.norm(seen.point[both] - camera.position, axis=1)
    assert ahead_of_eye == pytest.approx(distance[seen.pixel[both]], abs=0.02)
