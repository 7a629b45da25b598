"""What a search wants: to be where the reference is, above all to be able to go on from there.

Deviations from the reference are counted in the scales below, for 70 kg and 1.75 m; a deviation of
one scale costs one. Besides, the divergent part of the center of mass costs: where it is going to
be, as an inverted pendulum falls.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from understudy.character import Character
from understudy.control.guidance_law import DEVIATION
from understudy.control.reference import sampled
from understudy.free_tracking.windows import Windows
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.scene import Part

# The six parts of a deviation: center of mass [m], its velocity [m/s], angular momentum
# [kg m^2/s], pelvis' turn [rad] and angular velocity [rad/s], ankles [m].
PARTS = (3, 3, 3, 3, 3, 6)
_SCALES = (*[0.03] * 3, *[0.15] * 3, 1.5, 1.5, 1.0, *[0.08] * 3, *[0.5] * 3, *[0.05] * 6)
_WEIGHTS = (1.0, 1.0, 1.0, 1.0, 0.3, 0.3)
_PACE, _DIVERGENT = 3.3, 0.05  # Of an inverted pendulum [1/s]; one scale of its divergent part [m].
_JOINTS = 100.0  # Cost of a mean squared joint error of 1 rad^2.
# Help: natural frequency of 8 rad/s, damping ratio 0.9; moments of inertia of a body [kg m^2].
_STIFF, _DAMP = 64.0, 14.4
_INERTIA = np.array([8.0, 8.0, 1.5])
_SIZE = 70.0 * 1.75**2


@dataclass(frozen=True, eq=False)
class Goal:
    """The reference at the windows' borders.

    Attributes:
        marks: Its postures, shape (borders, POSTURE).
        rotations: Its joints' rotations but the root's, shape (borders, links - 1, 4).
        coordinates: The character's part of qpos.
        scales: One scale of every part of a deviation, shape (DEVIATION,).
        cost: Quadratic cost of a scaled deviation, shape (DEVIATION, DEVIATION).
        mass: Of the body [kg].
        size: Mass times height squared over those of 70 kg and 1.75 m.
    """

    marks: Array
    rotations: Array
    coordinates: slice
    scales: Array
    cost: Array
    mass: float
    size: float

    @classmethod
    def of(cls, windows: Windows, clip: Clip, body: Character, part: Part, times: Array) -> Goal:
        """The goal of following `clip` at the borders `times` [s]."""
        reference = sampled(clip, times)
        qpos = np.tile(windows.model.qpos0, (len(times), 1))
        qvel = np.zeros((len(times), windows.model.nv))
        qpos[:, part.qpos], qvel[:, part.dofs] = reference.qpos(), reference.qvel()
        size = body.mass * body.height**2 / _SIZE
        scales = np.array(_SCALES)
        scales[6:9] *= size
        return cls(
            marks=windows.postures(qpos, qvel),
            rotations=reference.rotations[:, 1:],
            coordinates=part.qpos,
            scales=scales,
            cost=_cost(scales),
            mass=body.mass,
            size=size,
        )

    def deviations(self, postures: Array, border: int) -> Array:
        """How far postures (n, POSTURE) are off at a border, in scales, shape (n, DEVIATION)."""
        mark, out = self.marks[border], np.empty((len(postures), DEVIATION))
        out[:, :9] = postures[:, :9] - mark[:9]
        turn = rot.multiply(postures[:, 9:13], rot.conjugate(mark[9:13]))
        out[:, 9:12] = rot.to_rotvec(turn)
        out[:, 12:] = postures[:, 13:] - mark[13:]
        return out / self.scales

    def costs(self, off: Array) -> Array:
        """Cost of scaled deviations (n, DEVIATION), shape (n,)."""
        return np.einsum("ni,ij,nj->n", off, self.cost, off)

    def displacements(self, off: Array) -> Array:
        """Square of how far scaled deviations (n, DEVIATION) are off in place and turn, (n,)."""
        return (off[:, :3] ** 2).sum(axis=1) + (off[:, 9:12] ** 2).sum(axis=1)

    def joint_costs(self, qpos: Array, border: int) -> Array:
        """Cost of the joints' errors of states (n, nq) at a border, shape (n,)."""
        joints = qpos[:, self.coordinates][:, 7:].reshape(len(qpos), -1, 4)
        cosine = np.abs(np.sum(joints * self.rotations[border], axis=-1))
        return _JOINTS * np.mean((2.0 * np.arccos(np.minimum(cosine, 1.0))) ** 2, axis=1)

    def pull(self, off: Array, root: Array) -> Array:
        """Help that takes scaled deviations back to the reference, shape (n, 6).

        Args:
            off: Scaled deviations.
            root: Orientations of the pelvis, in whose frame the torque is, shape (n, 4).
        """
        x = off * self.scales
        force = -self.mass * (_STIFF * x[:, :3] + _DAMP * x[:, 3:6])
        torque = -self.size * _INERTIA * (_STIFF * x[:, 9:12] + _DAMP * x[:, 12:15])
        return np.concatenate((force, rot.rotate(rot.conjugate(root), torque)), axis=1)


def _cost(scales: Array) -> Array:
    cost = np.diag(np.repeat(_WEIGHTS, PARTS))
    for axis in range(2):
        divergent = np.zeros(DEVIATION)
        divergent[axis] = scales[axis] / _DIVERGENT
        divergent[3 + axis] = scales[3 + axis] / (_PACE * _DIVERGENT)
        cost += np.outer(divergent, divergent)
    return cost
