"""How closely driven bodies followed their clip: errors, joint gaps, forces (Wilke & Semwal 2017).

In: a `Take` of a linkage. Out: numbers per joint and frame, in SI and in the clip's unit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from understudy.character import Linkage
from understudy.control import Drive, drive_laws
from understudy.control.compiling import compiled
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.take import Take


def welford(values: Array) -> tuple[Array, Array]:
    """Mean and variance along axis 0, one value at a time (algorithm 2; Knuth and Welford).

    Returns:
        Means, and variances over n - 1 (0 for a single value), both of shape values.shape[1:].
    """
    values = np.asarray(values, float)
    mean, squares = np.zeros(values.shape[1:]), np.zeros(values.shape[1:])
    for n, value in enumerate(values, 1):
        delta = value - mean
        mean = mean + delta / n
        squares = squares + delta * (value - mean)
    return mean, squares / max(len(values) - 1, 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class DriveError:
    """Squared position error of a driven linkage, equation 4, and how far its joints came apart.

    A body's position is where its joint lies: its center of mass for spheres, the end of a capsule
    for others.

    Attributes:
        joints: Names, in the order of the columns.
        unit: Meters per unit.
        times: Time of each frame [s], shape (frames,).
        squared: e^2 per frame and joint [units^2], shape (frames, joints).
        mean: Its mean over frames, then joints [units^2]: equation 4.
        per_joint: Its mean over frames [units^2], shape (joints,).
        per_joint_variance: Its variance over frames [units^4], shape (joints,).
        variance: Variance over joints of their means [units^4].
        gaps: Distance between the parts of each joint [units], shape (frames, joints): the parent
            end of a body from the far end of its parent body; zeros for independent bodies.
        settings: What the numbers depend on: law, gains, gravity, scale, time step, unit.
    """

    joints: tuple[str, ...]
    unit: float
    times: Array = field(repr=False)
    squared: Array = field(repr=False)
    mean: float
    per_joint: Array = field(repr=False)
    per_joint_variance: Array = field(repr=False)
    variance: float
    gaps: Array = field(repr=False)
    settings: dict[str, Any] = field(default_factory=dict, repr=False)

    @property
    def rms_mm(self) -> float:
        """Root mean squared position error [mm]."""
        return float(1e3 * self.unit * np.sqrt(self.mean))

    @property
    def gap_mean(self) -> float:
        """Mean joint gap [units]."""
        return float(self.gaps.mean())

    @property
    def gap_max(self) -> float:
        """Largest joint gap [units]."""
        return float(self.gaps.max())

    @property
    def gap_max_mm(self) -> float:
        """Largest joint gap [mm]."""
        return 1e3 * self.unit * self.gap_max

    @property
    def growth(self) -> float:
        """Slope of log e^2 over log time of the root, from a quarter of the time on (figure 2).

        2 where the error is a steady drift; NaN where there are too few frames or no error.
        """
        late = (self.times > 0.25 * self.times[-1]) & (self.squared[:, 0] > 0.0)
        if np.count_nonzero(late) < 8:
            return float("nan")
        slope, _ = np.polyfit(np.log(self.times[late]), np.log(self.squared[late, 0]), 1)
        return float(slope)

    def __str__(self) -> str:
        s = self.settings
        gravity = s.get("gravity_units_per_s2", float("nan"))
        return (
            f"mean squared error {self.mean:.4g} units^2 ({self.rms_mm:.3g} mm rms), variance over "
            f"joints {self.variance:.3g}, joint gap at most {self.gap_max:.3g} units "
            f"({self.gap_max_mm:.3g} mm) [1 unit = {1e3 * self.unit:.4g} mm, gravity "
            f"{gravity:.4g} units/s^2, scale {s.get('scale', 1.0):g}, step "
            f"{1e3 * s.get('timestep_s', float('nan')):.4g} ms]"
        )


def drive_error(take: Take, character: int = 0) -> DriveError:
    """Equation 4 at the clip's frames, and joint gaps, of a take of a driven linkage.

    Raises:
        InvalidValue: The performer is no linkage, or the take has no clip to compare with.
    """
    linkage, reference = _linkage(take, character), take.references[character]
    if reference is None:
        raise InvalidValue("The take keeps no clip that its bodies were to follow.")
    every = take.stride(reference.rate)
    state = take.qpos[::every, take.scene.parts[character].qpos][: reference.frames]
    placed, turned = linkage.poses(state)
    ends = placed + rot.rotate(turned, linkage.ends)
    wanted = reference.forward_kinematics().positions[: len(ends)]
    squared = np.sum((ends - wanted) ** 2, axis=-1) / linkage.unit**2
    per_joint, variances = welford(squared)
    mean, variance = welford(per_joint)
    gaps = np.zeros_like(squared)
    if linkage.kind != "independent":
        parents = list(linkage.skeleton.parents[1:])
        starts = placed + rot.rotate(turned, linkage.anchors)
        apart = np.linalg.norm(starts[:, 1:] - ends[:, parents], axis=-1)
        gaps[:, 1:] = apart / linkage.unit
    return DriveError(
        joints=linkage.names,
        unit=linkage.unit,
        times=take.times[::every][: len(ends)],
        squared=squared,
        mean=float(mean),
        per_joint=per_joint,
        per_joint_variance=variances,
        variance=float(variance),
        gaps=gaps,
        settings=dict(take.facts),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class DriveForces:
    """What the drive did to every body.

    Attributes:
        joints: Names, in the order of the columns.
        times: Time of each frame [s], shape (frames,).
        force: Force at the center of mass, world axes [N], shape (frames, joints, 3).
        torque: Torque, world axes [N m], shape (frames, joints, 3).
    """

    joints: tuple[str, ...]
    times: Array = field(repr=False)
    force: Array = field(repr=False)
    torque: Array = field(repr=False)

    def change(self, other: DriveForces) -> tuple[Array, Array]:
        """Mean squared change of force [N^2] and torque [N^2 m^2] of each joint, shapes (joints,).

        Table 3 of the paper compares two simulations in this way. Raises `InvalidValue` where the
        two differ in joints; of two lengths the shorter counts.
        """
        if self.joints != other.joints:
            raise InvalidValue("The two takes have different joints.")
        n = min(len(self.times), len(other.times))
        force, torque = (
            np.sum((a[:n] - b[:n]) ** 2, axis=-1).mean(axis=0)
            for a, b in ((self.force, other.force), (self.torque, other.torque))
        )
        return force, torque


def drive_forces(take: Take, character: int = 0) -> DriveForces:
    """Forces and torques of the drive on every body over a take, one row per step.

    Raises:
        InvalidValue: The performer is no linkage, or it is a tree and the take was read from disk:
            its recorded joint torques do not say which body they acted on.
    """
    linkage, part = _linkage(take, character), take.scene.parts[character]
    steps = max(take.frames - 1, 1)
    _, turned = linkage.poses(take.qpos[:steps, part.qpos])
    if linkage.kind != "tree":
        both = take.qfrc_applied[:steps, part.dofs].reshape(steps, len(linkage), 6)
        force, torque = np.array(both[..., :3]), rot.rotate(turned, both[..., 3:])
    else:
        force, torque = _tree_forces(take, character, steps)
    return DriveForces(joints=linkage.names, times=take.times[:steps], force=force, torque=torque)


def _linkage(take: Take, character: int) -> Linkage:
    linkage = take.scene.characters[character]
    if not isinstance(linkage, Linkage):
        raise InvalidValue(f"{linkage.name!r} is no linkage; see `score` for characters.")
    return linkage


def _tree_forces(take: Take, character: int, steps: int) -> tuple[Array, Array]:
    """The law asked again at every recorded state."""
    import mujoco

    controllers = [] if take.performance is None else take.performance.controllers
    drive = next(
        (c for c in controllers if isinstance(c, Drive) and c.character == character), None
    )
    if drive is None:
        raise InvalidValue("Forces on a tree's bodies need the performance, which files leave out.")
    _, parameters, memory = drive.feedback(take.scene, take.model)
    wrenches = compiled(drive_laws.tree_wrenches)
    data = mujoco.MjData(take.model)
    out = np.empty((steps, len(drive.reference.skeleton), 10))
    for k in range(steps):
        data.qpos[:], data.qvel[:] = take.qpos[k], take.qvel[k]
        mujoco.mj_fwdPosition(take.model, data)
        mujoco.mj_fwdVelocity(take.model, data)
        wrenches(take.times[k], data.qpos, data.xpos, data.cvel, parameters, memory)
        out[k] = memory.reshape(-1, 10)
    return out[..., 4:7], out[..., 7:10]
