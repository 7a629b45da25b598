"""Contact forces of many frames, decoded from the engine's constraint forces all at once.

The engine keeps a contact as a frame, a depth and a block of constraint forces; asking it contact
by contact costs a call each. Here the blocks of every frame are kept and turned into world forces
in one pass.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from understudy.motion.rotations import Array

Integers = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


@dataclass(frozen=True, kw_only=True)
class Contacts:
    """Every contact point of every measured frame, as one table.

    Attributes:
        frame: Index of the measured frame, shape (contacts,).
        geoms: The two geometries, shape (contacts, 2).
        bodies: The two bodies those belong to, 0 for the world, shape (contacts, 2).
        position: Contact point [m], world, shape (contacts, 3).
        normal: Unit normal from the first geometry to the second, world, shape (contacts, 3).
        force: Force on the second body [N], world, shape (contacts, 3); the first body receives the
            opposite.
        depth: Penetration [m], positive when the geometries overlap, shape (contacts,).
        slip: Speed of the second body's material point over the first's, along the contact plane
            [m/s], shape (contacts,).
        closing: Speed at which the two approach along the normal [m/s], shape (contacts,).
    """

    frame: Integers = field(repr=False)
    geoms: Integers = field(repr=False)
    bodies: Integers = field(repr=False)
    position: Array = field(repr=False)
    normal: Array = field(repr=False)
    force: Array = field(repr=False)
    depth: Array = field(repr=False)
    slip: Array = field(repr=False)
    closing: Array = field(repr=False)

    def __len__(self) -> int:
        return len(self.frame)

    def force_on(self, bodies: Integers, frames: int, *, other: Integers | None = None) -> Array:
        """Summed contact force on a group of bodies [N], world, shape (frames, 3).

        Contacts between two bodies of the group cancel and are left out. With `other`, only
        contacts with those bodies count.
        """
        first, second = np.isin(self.bodies[:, 0], bodies), np.isin(self.bodies[:, 1], bodies)
        sign = second.astype(float) - first
        if other is not None:
            outside = np.where(second, self.bodies[:, 0], self.bodies[:, 1])
            sign = sign * np.isin(outside, other)
        out = np.zeros((frames, 3))
        np.add.at(out, self.frame, sign[:, None] * self.force)
        return out

    def involving(self, bodies: Integers) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Mask of contacts between the group and something outside it, shape (contacts,)."""
        first, second = np.isin(self.bodies[:, 0], bodies), np.isin(self.bodies[:, 1], bodies)
        return first != second


class Recorder:
    """Keeps the raw contact blocks of each frame while the engine runs over the take."""

    def __init__(self, model: mujoco.MjModel):
        self.model = model
        self._raw: list[tuple[Any, ...]] = []
        self._frames: list[int] = []
        self._counts: list[int] = []

    def record(self, frame: int, data: mujoco.MjData) -> None:
        """Keep the contacts of `data`, which must be freshly computed."""
        if not data.ncon:
            return
        found = data.contact
        self._raw.append(
            (
                found.geom.copy(),
                found.frame.copy(),
                found.pos.copy(),
                found.dist.copy(),
                found.efc_address.copy(),
                found.dim.copy(),
                found.friction.copy(),
                data.efc_force.copy(),
            )
        )
        self._frames.append(frame)
        self._counts.append(data.ncon)

    def table(self, velocity: Array, center: Array) -> Contacts:
        """All contacts recorded.

        Args:
            velocity: Angular then linear velocity of every body about the center of mass of its
                tree, shape (frames, bodies, 6).
            center: Those centers of mass [m], shape (frames, bodies, 3).
        """
        if not self._raw:
            none, flat = np.zeros((0, 3)), np.zeros(0)
            empty = np.zeros((0, 2), dtype=np.int64)
            return Contacts(
                frame=np.zeros(0, dtype=np.int64),
                geoms=empty,
                bodies=empty,
                position=none,
                normal=none,
                force=none,
                depth=flat,
                slip=flat,
                closing=flat,
            )
        geom, axes, place, dist, address, dim, friction, _ = (
            np.concatenate(column) for column in zip(*self._raw, strict=True)
        )
        frame = np.repeat(np.array(self._frames), self._counts)
        # Addresses count from the start of each frame's forces; make them count from the first's.
        lengths = np.array([len(row[-1]) for row in self._raw])
        start = np.repeat(np.concatenate(([0], np.cumsum(lengths)[:-1])), self._counts)
        efc = np.concatenate([row[-1] for row in self._raw])
        local = self._local_forces(
            efc, np.where(address < 0, -1, address + start), dim.astype(int), friction
        )
        axes = axes.reshape(-1, 3, 3)
        bodies = self.model.geom_bodyid[np.maximum(geom, 0)].astype(np.int64)
        points = []
        for side in (0, 1):
            moving = velocity[frame, bodies[:, side]]
            arm = place - center[frame, bodies[:, side]]
            points.append(moving[:, 3:] + np.cross(moving[:, :3], arm))
        relative = points[1] - points[0]
        tangent = np.einsum("cij,cj->ci", axes[:, 1:], relative)
        return Contacts(
            frame=frame,
            geoms=geom.astype(np.int64),
            bodies=bodies,
            position=place,
            normal=axes[:, 0],
            force=np.einsum("cij,ci->cj", axes, local),
            depth=-dist,
            slip=np.linalg.norm(tangent, axis=1),
            closing=-np.sum(axes[:, 0] * relative, axis=1),
        )

    def _local_forces(self, efc: Array, address: Integers, dim: Integers, friction: Array) -> Array:
        """Normal and two friction forces in the contact frame, shape (contacts, 3)."""
        out = np.zeros((len(address), 3))
        elliptic = int(self.model.opt.cone) == int(mujoco.mjtCone.mjCONE_ELLIPTIC)
        for size in np.unique(dim):
            rows = np.flatnonzero((dim == size) & (address >= 0))
            if not len(rows):
                continue
            if size == 1 or elliptic:
                width = min(int(size), 3)
                out[rows, :width] = efc[address[rows][:, None] + np.arange(width)]
                continue
            # A pyramid's edges: pairs of (normal + mu tangent), (normal - mu tangent).
            edges = efc[address[rows][:, None] + np.arange(2 * (size - 1))].reshape(
                len(rows), -1, 2
            )
            out[rows, 0] = edges.sum(axis=(1, 2))
            tangents = (edges[:, :2, 0] - edges[:, :2, 1]) * friction[rows, :2]
            out[rows, 1 : 1 + tangents.shape[1]] = tangents
        return out
