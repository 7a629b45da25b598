"""One face for two ways to draw: OpenGL where it works, NumPy everywhere else."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Protocol

import mujoco
import numpy as np

from understudy.errors import UnderstudyError, UnknownName
from understudy.motion.rotations import Array
from understudy.output.camera import Camera
from understudy.output.gl import GLRenderer, backend
from understudy.output.software import SoftwareRenderer

RENDERERS = ("auto", "opengl", "software")
_OTHERWISE = "use renderer='software' (--renderer software)."


class Renderer(Protocol):
    """Draws a model.

    Attributes:
        name: "opengl" or "software".
    """

    name: str

    def picture(
        self, qpos: Array, camera: Camera, *, ghost: Array | None = None, opacity: float = 0.4
    ) -> np.ndarray[Any, np.dtype[np.uint8]]:
        """One picture of a pose, uint8, (height, width, 3); see `SoftwareRenderer.picture`."""
        ...

    def close(self) -> None:
        """Give everything back; the renderer draws no more."""


def opened(
    model: mujoco.MjModel,
    width: int,
    height: int,
    *,
    renderer: str = "auto",
    spec: Callable[[], mujoco.MjSpec] | None = None,
    shadows: bool = True,
    samples: int = 4,
    ghost_bodies: tuple[int, ...] = (),
) -> Renderer:
    """A renderer for pictures of `width` times `height` pixels; `close` it when done.

    Args:
        model: What is drawn.
        width: Width [pixels].
        height: Height [pixels].
        renderer: "opengl" (the engine's own), "software" (needs no graphics library), or "auto":
            OpenGL where it works.
        spec: Makes a specification of the model, which OpenGL dresses with a sky and tiles.
        shadows: Draw the body's shadow on the ground (software: on the body too).
        samples: Samples on an edge that OpenGL takes; 0 is fastest.
        ghost_bodies: Bodies that a ghost shows.

    Raises:
        UnknownName: No such renderer.
        UnderstudyError: OpenGL is asked for and does not work here.
    """
    if renderer not in RENDERERS:
        raise UnknownName("renderer", renderer, RENDERERS)
    if renderer != "software" and backend() is not None:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                return GLRenderer(
                    model,
                    width,
                    height,
                    spec=spec,
                    shadows=shadows,
                    samples=samples,
                    ghost_bodies=ghost_bodies,
                )
        except RuntimeError as error:
            if renderer == "opengl":
                raise UnderstudyError(f"{error}; {_OTHERWISE}") from error
    if renderer == "opengl":
        raise UnderstudyError(f"No OpenGL library draws on this machine; {_OTHERWISE}")
    return SoftwareRenderer(model, width, height, shadows=shadows, ghost_bodies=ghost_bodies)
