"""Where the camera stands, computed from the motion.

In: the world path of the points that must stay in the picture. Out: one `Camera` per frame, such
that they all stay in it and fill it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from understudy.errors import InvalidValue, UnknownName
from understudy.motion.rotations import Array

# Compass bearing of the camera, seen from the body, from its front toward its left [deg]. From the
# right side a body that walks forward crosses the picture from left to right.
BEARINGS = {"front": 0.0, "three-quarter": -42.0, "side": -90.0, "back": 180.0}
VIEWS = (*BEARINGS, "follow", *(f"follow-{name}" for name in BEARINGS))
_ELEVATION = np.radians(12.0)
_FIELD_OF_VIEW = np.radians(30.0)
_SMOOTH = 0.35  # the following camera evens out the root's path over this time [s]
_MARGIN = 0.06  # of the picture's size, on every side


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole camera in the world, upright.

    Attributes:
        position: Where it stands [m], shape (3,).
        axes: Its right, up and forward directions in the world as rows, shape (3, 3).
        field_of_view: Vertical opening angle [rad].
    """

    position: Array
    axes: Array
    field_of_view: float = _FIELD_OF_VIEW

    def project(self, points: Array, width: int, height: int) -> tuple[Array, Array]:
        """Pixel coordinates (..., 2), from the top left, and depth (...,) [m] of world points."""
        seen = (np.asarray(points) - self.position) @ self.axes.T
        depth = seen[..., 2]
        scale = 0.5 * height / np.tan(0.5 * self.field_of_view) / np.where(depth > 1e-9, depth, 1.0)
        return np.stack(
            (0.5 * width + seen[..., 0] * scale, 0.5 * height - seen[..., 1] * scale), axis=-1
        ), depth


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A camera that keeps its direction and distance while its target moves.

    Attributes:
        targets: Point in the middle of the picture at every frame [m], shape (frames, 3).
        direction: Unit vector from the target to the camera, shape (3,).
        distance: From the target to the camera [m].
        field_of_view: Vertical opening angle [rad].
    """

    targets: Array
    direction: Array
    distance: float
    field_of_view: float = _FIELD_OF_VIEW

    def camera(self, frame: int) -> Camera:
        """The camera at one frame."""
        return Camera(
            position=self.targets[frame] + self.distance * self.direction,
            axes=_axes(self.direction),
            field_of_view=self.field_of_view,
        )


def framed(
    points: Array,
    path: Array,
    *,
    rate: float,
    heading: float = 0.0,
    view: str = "follow",
    aspect: float = 4 / 3,
) -> Shot:
    """The shot that holds every point of the motion and is filled by it.

    Args:
        points: World points to hold [m], shape (frames, n, 3).
        path: What a following camera follows, such as the root's path [m], shape (frames, 3).
        rate: Frames per second of both [Hz].
        heading: Direction in which the body faces, from +x toward +y [rad].
        view: One of `VIEWS`; "follow" is the three-quarter view that travels along.
        aspect: Width of the picture over its height.

    Raises:
        UnknownName: No such view.
        InvalidValue: There is no point to show.
    """
    bearing = bearing_of(view, heading)
    if points.size == 0:
        raise InvalidValue("There is nothing to frame: no visible body moves.")
    follows = view.startswith("follow")
    flat = np.cos(_ELEVATION)
    direction = np.array(
        [flat * np.cos(bearing), flat * np.sin(bearing), np.sin(_ELEVATION)],
    )
    path = smoothed(path, rate) if follows else np.zeros_like(path)
    center, distance = _fit((points - path[:, None]).reshape(-1, 3), direction, aspect)
    return Shot(targets=path + center, direction=direction, distance=distance)


def bearing_of(view: str, heading: float) -> float:
    """Direction from the body to the camera, from +x toward +y [rad]; raises `UnknownName`."""
    if view not in VIEWS:
        raise UnknownName("view", view, VIEWS)
    side = view.removeprefix("follow").removeprefix("-") or "three-quarter"
    return heading + float(np.radians(BEARINGS[side]))


def _axes(direction: Array) -> Array:
    """Right, up and forward of an upright camera that looks against `direction`."""
    right = np.array([-direction[1], direction[0], 0.0])
    right /= np.linalg.norm(right)
    return np.stack((right, np.cross(direction, right), -direction))


def _fit(points: Array, direction: Array, aspect: float) -> tuple[Array, float]:
    """Target and distance at which points (n, 3) just fill the picture.

    With x, y, z along the camera's right, up and forward from a target (cx, cy) at distance D, a
    point is inside when |x - cx| <= t (D + z); the tightest D and the centered cx follow from the
    largest x - t z and -x - t z. The same holds upward.
    """
    axes = _axes(direction)
    seen = points @ axes.T
    slope = np.tan(0.5 * _FIELD_OF_VIEW) * (1.0 - 2.0 * _MARGIN)
    center, distances = [], []
    for values, t in ((seen[:, 0], slope * aspect), (seen[:, 1], slope)):
        high, low = np.max(values - t * seen[:, 2]), np.max(-values - t * seen[:, 2])
        center.append(0.5 * (high - low))
        distances.append(0.5 * (high + low) / t)
    distance = max(*distances, 0.1 - np.min(seen[:, 2]))
    # Put the target at the middle depth of the points, so that targets lie in the body.
    middle = 0.5 * float(np.min(seen[:, 2]) + np.max(seen[:, 2]))
    return np.array([*center, middle]) @ axes, float(distance + middle)


def smoothed(path: Array, rate: float) -> Array:
    """A path (frames, 3) at `rate` [Hz] without the sway of single steps."""
    from scipy.ndimage import gaussian_filter1d

    if len(path) < 3 or _SMOOTH * rate < 0.1:
        return np.array(path)
    return gaussian_filter1d(path, _SMOOTH * rate, axis=0, mode="nearest")
