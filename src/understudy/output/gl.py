"""Pictures by the engine's own OpenGL renderer, where the machine has an OpenGL library.

Whether it works is found out in a process of its own, because a broken driver can take its process
down and the engine decides at import which library it binds to.
"""

from __future__ import annotations

import copy
import ctypes.util
import functools
import importlib
import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from understudy.motion.rotations import Array
from understudy.output import meshes
from understudy.output.camera import Camera
from understudy.output.shading import lamp

_GHOST = (0.42, 0.66, 0.93)
_SHADOW = (0.060, 0.063, 0.066, 1.0)
_PROBE = """
import sys, mujoco
from importlib import import_module
context = import_module("mujoco." + sys.argv[1]).GLContext(16, 16)
context.make_current()
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, drawing)
assert drawing.currentBuffer == mujoco.mjtFramebuffer.mjFB_OFFSCREEN
drawing.free()
context.free()
print("drawn")
"""


@functools.cache
def backend() -> str | None:
    """The engine's OpenGL module that draws on this machine ("egl", "osmesa", ...), or None.

    Asked once; it takes about a second where a library is found, and nothing where none is.
    """
    for name in _candidates():
        environment = {k: v for k, v in os.environ.items() if k != "PYOPENGL_PLATFORM"}
        environment["MUJOCO_GL"] = name
        try:
            answer = subprocess.run(
                [sys.executable, "-c", _PROBE, name],
                env=environment,
                capture_output=True,
                stdin=subprocess.DEVNULL,
                timeout=30.0,
                check=False,
            )
        except (OSError, subprocess.SubprocessError):
            continue
        if answer.returncode == 0 and b"drawn" in answer.stdout:
            return name
    return None


def _candidates() -> list[str]:
    """Modules worth trying, the likeliest first; none of them is loaded here."""
    if sys.platform == "darwin":
        return ["cgl"]
    if sys.platform == "win32":
        return ["glfw"]
    found = [
        name
        for name, library in (("egl", "EGL"), ("osmesa", "OSMesa"))
        if ctypes.util.find_library(library)
    ]
    wanted = os.environ.get("MUJOCO_GL", "").lower().strip()
    return sorted(found, key=lambda name: name != wanted)


class GLRenderer:
    """Draws a model with OpenGL.

    Attributes:
        name: "opengl".
    """

    name = "opengl"

    def __init__(
        self,
        model: mujoco.MjModel,
        width: int,
        height: int,
        *,
        spec: Callable[[], mujoco.MjSpec] | None = None,
        shadows: bool = True,
        samples: int = 0,
        ghost_bodies: tuple[int, ...] = (),
    ):
        """Open a context.

        Raises:
            RuntimeError: OpenGL does not work here.
        """
        name = backend()
        if name is None:
            raise RuntimeError("no OpenGL library draws on this machine")
        self.width, self.height = width, height
        self._model = copy.copy(model) if spec is None else dressed(spec()).compile()
        if self._model.nq != model.nq:
            self._model = copy.copy(model)
        painted = self._model.geom_matid < 0
        self._model.geom_rgba[painted] = meshes.colors(self._model)[painted]
        view = self._model.vis
        view.global_.offwidth, view.global_.offheight = width, height
        view.quality.offsamples = samples
        view.quality.shadowsize, self._shadows = 0, shadows
        self._data, self._ghost = mujoco.MjData(self._model), mujoco.MjData(self._model)
        self._ghost_bodies = np.asarray(ghost_bodies, int)
        self._options = mujoco.MjvOption()
        plane = meshes.planes(self._model)
        self._plane = int(plane[0]) if len(plane) else None
        try:
            self._context: Any = importlib.import_module(f"mujoco.{name}").GLContext(width, height)
            self._context.make_current()
            self._scene = mujoco.MjvScene(self._model, maxgeom=6 * self._model.ngeom + 100)
            self._drawing = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
        except Exception as error:
            raise RuntimeError(f"OpenGL fails in this process: {error}") from error
        flags = self._scene.flags
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0

    def __enter__(self) -> GLRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the context back; the renderer draws no more."""
        if self._context is not None:
            self._drawing.free()
            self._context.free()
            self._context = None

    def picture(
        self, qpos: Array, camera: Camera, *, ghost: Array | None = None, opacity: float = 0.4
    ) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """One picture, uint8, shape (height, width, 3); see `SoftwareRenderer.picture`."""
        self._context.make_current()
        scene, every = self._scene, mujoco.mjtCatBit.mjCAT_ALL
        self._pose(self._data, qpos)
        mujoco.mjv_updateScene(
            self._model, self._data, self._options, None, mujoco.MjvCamera(), every, scene
        )
        self._flatten(camera)
        if ghost is not None:
            self._add_ghost(ghost, opacity)
        self._center = self._data.subtree_com[self._model.body_rootid[-1]]
        self._aim(camera)
        out = np.empty((self.height, self.width, 3), np.uint8)
        area = mujoco.MjrRect(0, 0, self.width, self.height)
        mujoco.mjr_render(area, scene, self._drawing)
        mujoco.mjr_readPixels(out, None, area, self._drawing)
        return out[::-1]

    def _pose(self, data: mujoco.MjData, qpos: Array) -> None:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_comPos(self._model, data)
        mujoco.mj_camlight(self._model, data)

    def _add_ghost(self, qpos: Array, opacity: float) -> None:
        """Add the ghost's shapes to the scene, in its color, and hide the other bodies of it."""
        scene, first = self._scene, self._scene.ngeom
        self._pose(self._ghost, qpos)
        mujoco.mjv_addGeoms(
            self._model,
            self._ghost,
            self._options,
            mujoco.MjvPerturb(),
            mujoco.mjtCatBit.mjCAT_DYNAMIC,
            scene,
        )
        for i in range(first, scene.ngeom):
            shape = scene.geoms[i]
            mine = shape.objtype == mujoco.mjtObj.mjOBJ_GEOM and np.isin(
                self._model.geom_bodyid[shape.objid], self._ghost_bodies
            )
            # A nearly solid ghost is drawn solid: OpenGL would show its inside.
            solid = 1.0 if opacity > 0.7 else opacity
            shape.rgba[:] = (*_GHOST, solid if mine else 0.0)
            shape.category = mujoco.mjtCatBit.mjCAT_DECOR  # casts no shadow

    def _flatten(self, camera: Camera) -> None:
        """Add a shadow on the ground: every shape once more, pressed flat along the light.

        The engine's own shadows cost several times as much in software and come out speckled.
        """
        if self._plane is None or not self._shadows:
            return
        scene, first = self._scene, self._scene.ngeom
        mujoco.mjv_addGeoms(
            self._model,
            self._data,
            self._options,
            mujoco.MjvPerturb(),
            mujoco.mjtCatBit.mjCAT_DYNAMIC,
            scene,
        )
        normal = self._data.geom_xmat[self._plane].reshape(3, 3)[:, 2]
        light = lamp(camera)
        press = np.eye(3) - np.outer(light, normal) / (light @ normal)
        base = self._data.geom_xpos[self._plane] + 0.006 * normal
        for i in range(first, scene.ngeom):
            shape = scene.geoms[i]
            shape.pos[:] = press @ (shape.pos - base) + base
            shape.mat[:] = press @ shape.mat
            shape.rgba[:] = _SHADOW
            shape.matid, shape.emission, shape.specular = -1, 6.5, 0.0
            shape.category = mujoco.mjtCatBit.mjCAT_DECOR

    def _aim(self, camera: Camera) -> None:
        """Point both eyes of the scene's camera, and its lamp, where the camera looks."""
        near, far = 0.05, 200.0
        half = near * np.tan(0.5 * camera.field_of_view)
        for eye in self._scene.camera:
            eye.pos[:], eye.forward[:], eye.up[:] = camera.position, camera.axes[2], camera.axes[1]
            eye.frustum_near, eye.frustum_far = near, far
            eye.frustum_bottom, eye.frustum_top = -half, half
            eye.frustum_center, eye.frustum_width = 0.0, half * self.width / self.height
        light = lamp(camera)
        for i in range(self._scene.nlight):
            lit = self._scene.lights[i]
            if not lit.headlight:
                lit.dir[:] = -light
                lit.pos[:] = self._center + 4.0 * light


def dressed(spec: mujoco.MjSpec) -> mujoco.MjSpec:
    """A specification with a sky, a checkered ground and a lamp added, for pictures only."""
    spec.add_texture(
        name="understudy_sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.62, 0.73, 0.87],
        rgb2=[0.92, 0.95, 0.98],
        width=256,
        height=1536,
    )
    spec.add_texture(
        name="understudy_tiles",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.70, 0.73, 0.76],
        rgb2=[0.63, 0.66, 0.69],
        width=256,
        height=256,
    )
    tiles = spec.add_material(name="understudy_ground", texrepeat=[1.0, 1.0], texuniform=True)
    tiles.textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = "understudy_tiles"
    tiles.reflectance, tiles.specular = 0.0, 0.0
    for geom in spec.geoms:
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            geom.material, geom.rgba = "understudy_ground", [1.0, 1.0, 1.0, 1.0]
    lamp_ = spec.worldbody.add_light(name="understudy_lamp")
    lamp_.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    lamp_.pos, lamp_.dir = [0.0, 0.0, 6.0], [0.0, 0.0, -1.0]
    lamp_.ambient, lamp_.diffuse, lamp_.specular = [0.0] * 3, [0.55] * 3, [0.15] * 3
    head = spec.visual.headlight
    head.ambient, head.diffuse, head.specular = [0.42] * 3, [0.18] * 3, [0.0] * 3
    spec.visual.rgba.haze = [0.92, 0.95, 0.98, 1.0]
    return spec
