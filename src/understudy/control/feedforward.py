"""What the motion needs: inverse dynamics of the reference, with ground contact explained first.

For each frame the engine's inverse dynamics gives the generalized force that the reference
accelerations require. Its six root rows can only come from the ground: non-negative least squares
finds friction-pyramid forces at the soles near the ground that explain them best; what the legs
must bear follows by the transposed Jacobian. What is left over in the root rows is the help the
motion would need from above.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from scipy.optimize import nnls
from scipy.signal import savgol_filter

from understudy.control.reference import sampled
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.rotations import Array
from understudy.scene import Ground, Part, Scene

# A sole point this high [m] or higher bears nothing. Farther, and legs push before they land.
NEAR_GROUND = 0.008
# Judging a motion, a point bears up to this height [m]: captured feet are that far off.
REACH = 0.02
SMOOTHING = 0.08  # Window of the derivative filter [s].


@dataclass(frozen=True, eq=False)
class Required:
    """What a reference needs, at the clip's frames.

    Attributes:
        joints: Torque at each joint but the root, in the outboard link's frame [N m], shape
            (frames, links - 1, 3).
        root: Force [N] (world) and torque [N m] (pelvis frame) at the root that no ground contact
            explains, shape (frames, 6).
        ground: Vertical force borne by the ground [N], shape (frames,).
    """

    joints: Array
    root: Array
    ground: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Rehearsal:
    """The body and the clip a performer has learned, when it performs with another body or clip.

    Feedforward and servo gains are then those of the rehearsed body: what was changed since is for
    the servos to feel. Many performances may share one, and its inverse dynamics runs once.

    Attributes:
        scene: Where it was rehearsed.
        reference: The clip rehearsed.
    """

    scene: Scene
    reference: Clip

    def need(self, character: int, *, contact: bool) -> Required:
        """Inverse dynamics of the rehearsed clip with the rehearsed body; see `required`."""
        key = character, contact
        if key not in self._needs:
            model = self.scene.model
            self._needs[key] = required(
                self.scene, model, character, self.reference, contact=contact
            )
        return self._needs[key]

    @cached_property
    def _needs(self) -> dict[tuple[int, bool], Required]:
        return {}


def contact_points(model: mujoco.MjModel, part: Part) -> list[tuple[int, Array, float]]:
    """Body, local position [m] and radius [m] of what can touch the ground first in every geom.

    A sphere's center, a capsule's two ends, a box's eight corners (radius 0), and for anything else
    the corners of its bounding box. The lowest point of each lies its radius below.
    """
    points: list[tuple[int, Array, float]] = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        touches = model.geom_contype[geom] & 1 or model.geom_conaffinity[geom] & 1
        if body not in part.bodies or not touches:
            continue
        size, kind = model.geom_size[geom], model.geom_type[geom]
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        turn = turn.reshape(3, 3)
        center = np.array(model.geom_pos[geom])
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            points.append((body, center, float(size[0])))
        elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
            ends = (center - size[1] * turn[:, 2], center + size[1] * turn[:, 2])
            points += [(body, end, float(size[0])) for end in ends]
        else:
            half = size if kind == mujoco.mjtGeom.mjGEOM_BOX else model.geom_aabb[geom][3:]
            corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T * half
            points += [(body, center + turn @ corner, 0.0) for corner in corners]
    return points


def required(
    scene: Scene,
    model: mujoco.MjModel,
    character: int,
    clip: Clip,
    *,
    contact: bool,
    reach: float = NEAR_GROUND,
    smoothing: float = SMOOTHING,
) -> Required:
    """What `clip`, on the character's skeleton, requires frame by frame.

    Args:
        scene: Where it happens.
        model: Its model.
        character: Which of its characters.
        clip: The reference.
        contact: Whether ground contact may explain the root's part.
        reach: Height over the ground from which a point bears nothing [m].
        smoothing: Window of the derivatives that give accelerations [s].
    """
    part = scene.parts[character]
    reference = sampled(clip, clip.times)
    velocities = reference.qvel()
    changes = derivative(velocities, clip.rate, smoothing=smoothing)
    positions = reference.qpos()
    quiet = _quiet_copy(model)
    data = mujoco.MjData(quiet)
    points = contact_points(model, part) if contact and scene.ground is not None else []
    bodies = [body for body, _, _ in points]
    local = np.array([place for _, place, _ in points]).reshape(-1, 3)
    below = np.array([(0.0, 0.0, radius) for _, _, radius in points]).reshape(-1, 3)
    friction = scene.ground.friction if scene.ground is not None else 0.0
    edges = np.array(
        [[friction, 0, 1], [-friction, 0, 1], [0, friction, 1], [0, -friction, 1]], float
    )
    # On the plane z = 0 every point pushes alike.
    uneven = None if scene.ground is None or scene.ground.level else scene.ground
    frames, dofs = len(positions), velocities.shape[1]
    force, borne = np.empty((frames, dofs)), np.zeros(frames)
    jacobian = np.empty((3, model.nv))
    for f in range(frames):
        data.qpos[part.qpos], data.qvel[part.dofs] = positions[f], velocities[f]
        data.qacc[part.dofs] = changes[f]
        mujoco.mj_inverse(quiet, data)
        force[f] = data.qfrc_inverse[part.dofs]
        if not points:
            continue
        frame = data.xmat[bodies].reshape(-1, 3, 3)
        soles = data.xpos[bodies] + (frame @ local[..., None])[..., 0] - below
        heights, pushes = soles[:, 2], edges
        if uneven is not None:
            heights, pushes = soles[:, 2] - uneven.height(soles), _leaning(edges, uneven, soles)
        near = np.flatnonzero(heights < reach)
        if not len(near):
            continue
        columns = np.empty((4 * len(near), dofs))
        for row, point in enumerate(near):
            mujoco.mj_jac(quiet, data, jacobian, None, soles[point], bodies[point])
            # A point half way up may bear all of it, one at the limit almost nothing.
            weight = min(1.0, max(0.05, 2.0 - 2.0 * heights[point] / reach))
            edge = pushes if pushes.ndim == 2 else pushes[point]
            np.dot(weight * edge, jacobian[:, part.dofs], out=columns[4 * row : 4 * row + 4])
        # A little ridge: of the many ways to share a load the most even one.
        system = np.zeros((6 + len(columns), len(columns)))
        system[:6] = columns[:, :6].T
        np.fill_diagonal(system[6:], 0.05)
        wanted = np.zeros(len(system))
        wanted[:6] = force[f, :6]
        push, _ = nnls(system, wanted)
        force[f] -= push @ columns
        borne[f] = push @ columns[:, 2]
    if frames > 7 and points:
        width = min(7, frames - (frames + 1) % 2)
        force = np.asarray(savgol_filter(force, width, 1, axis=0), float)
    return Required(force[:, 6:].reshape(frames, -1, 3), force[:, :6], borne)


def _leaning(edges: Array, ground: Ground, points: Array) -> Array:
    """The friction pyramid's edges about the ground's normal under points, (points, 4, 3)."""
    normals: Array = ground.normals(points)
    first: Array = np.cross(np.array([0.0, 1.0, 0.0]), normals)
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    axes = np.stack((first, np.cross(normals, first), normals), axis=1)
    return np.asarray(edges @ axes, float)


def _quiet_copy(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model without contact, limits and servos: its inverse dynamics is the motion's alone."""
    quiet = copy.copy(model)
    flags = mujoco.mjtDisableBit
    quiet.opt.disableflags |= int(
        flags.mjDSBL_CONTACT | flags.mjDSBL_ACTUATION | flags.mjDSBL_LIMIT
    )
    return quiet
