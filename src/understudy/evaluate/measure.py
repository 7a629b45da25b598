"""What happened in a take, recomputed from its recorded states.

A take records states and controls; forces follow from them. One pass sets every measured frame in
the engine, runs its forward dynamics with the recorded controls and keeps contacts, joint torques,
energy and momentum. Nothing is simulated again, so the numbers belong to the take itself.

Joint torques are the ones that acted *over* a step. A stiff servo's torque at the instant a step
begins says little: the engine integrates the servo's damping implicitly, so the momentum it passes
on is that of tau - kv (v' - v), where v and v' are the velocities before and after the step. With
that term, M (v' - v)/h equals the sum of all forces to rounding (tests check it).
"""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from understudy.character import Athlete
from understudy.errors import InvalidValue
from understudy.evaluate.contacts import Contacts, Integers, Recorder
from understudy.evaluate.owners import Owners, owners
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.simulate import quiet_engine

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.take import Take

# Straight on a joint's axis, or (orientation servos) on all axes of a ball joint.
_ON_JOINTS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_SO3))


@dataclass(frozen=True, kw_only=True)
class Performer:
    """Where one character's numbers are in the model.

    Attributes:
        character: The character.
        index: Its place in the scene.
        coordinates: Its slice of the generalized positions.
        dofs: Its slice of the degrees of freedom; the first six are the root's.
        bodies: Body number of each link, shape (links,).
        weight: Body weight [N].
        height: Stature [m]; what weight times height scales torques with.
    """

    character: Character
    index: int
    coordinates: slice
    dofs: slice
    bodies: Integers = field(repr=False)
    weight: float
    height: float

    @property
    def joints(self) -> tuple[str, ...]:
        """Joint names in link order, the root's first."""
        return tuple(link.joint for link in self.character.links)

    @property
    def links(self) -> tuple[str, ...]:
        """Link names in order."""
        return tuple(link.name for link in self.character.links)

    def bodies_with_roles(self, *roles: str) -> Integers:
        """Bodies of the links whose joints have these roles, in the order asked, if they exist."""
        by_role = {
            link.role: body for link, body in zip(self.character.links, self.bodies, strict=True)
        }
        return np.array([by_role[role] for role in roles if role in by_role], dtype=np.int64)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Forces, torques, energy and momentum of a take at its measured frames.

    Attributes:
        steps: Index of each measured frame in the take, shape (frames,).
        times: Time [s], shape (frames,).
        rate: Measured frames per second [Hz].
        performers: The characters and where their numbers are.
        torque: Force of actuators and applied forces on every degree of freedom over the step that
            starts at the frame [N, N m], shape (frames, dofs). Ball joints have three, in the
            frame of the outboard link; the root has world forces, then torques in its own frame.
        power: Power of those forces [W], shape (frames, dofs).
        resistance: Friction, springs and limits of the joints and contacts, over the same step
            [N, N m], shape (frames, dofs).
        push: Forces that the take applied to its links from outside, as a hand or a gust does
            [N, N m], shape (frames, dofs); no part of `torque`.
        kinetic: Kinetic energy of the scene [J], shape (frames,).
        potential: Gravitational energy of the scene over that at z = 0 [J], shape (frames,).
        center_of_mass: Per character [m], world, shape (frames, characters, 3).
        momentum: Linear momentum per character [N s], world, shape (frames, characters, 3).
        angular_momentum: About the center of mass [N m s], world, (frames, characters, 3).
        contacts: Every contact point.
        owners: Whose the geometries in contact are.
        body_positions: World positions of all bodies [m], shape (frames, bodies, 3).
        body_rotations: World orientations of all bodies, wxyz, shape (frames, bodies, 4).
    """

    steps: Integers = field(repr=False)
    times: Array = field(repr=False)
    rate: float
    performers: tuple[Performer, ...]
    torque: Array = field(repr=False)
    power: Array = field(repr=False)
    resistance: Array = field(repr=False)
    push: Array = field(repr=False)
    kinetic: Array = field(repr=False)
    potential: Array = field(repr=False)
    center_of_mass: Array = field(repr=False)
    momentum: Array = field(repr=False)
    angular_momentum: Array = field(repr=False)
    contacts: Contacts = field(repr=False)
    owners: Owners = field(repr=False)
    body_positions: Array = field(repr=False)
    body_rotations: Array = field(repr=False)

    @property
    def frames(self) -> int:
        """Number of measured frames."""
        return len(self.steps)

    def performer(self, character: int = 0) -> Performer:
        """The character with that number.

        Raises:
            InvalidValue: The scene has no such character.
        """
        if not 0 <= character < len(self.performers):
            raise InvalidValue(
                f"No character {character}; the scene has {len(self.performers)}, counted from 0."
            )
        return self.performers[character]

    def joint_torques(self, character: int = 0) -> Array:
        """Torque vector of every joint but the root [N m], outboard frame, (frames, joints, 3)."""
        dofs = self.performer(character).dofs
        return self._by_joint(self.torque[:, dofs][:, 6:], character)

    def joint_powers(self, character: int = 0) -> Array:
        """Power of every joint but the root [W], shape (frames, joints)."""
        dofs = self.performer(character).dofs
        own = self.power[:, dofs][:, 6:]
        body = self.performer(character).character
        if isinstance(body, Athlete):
            return own @ np.abs(body.hinge_axes).sum(axis=2)
        return self._by_joint(own, character).sum(axis=2)

    def _by_joint(self, own: Array, character: int) -> Array:
        """Numbers of the joints' degrees of freedom as vectors, shape (frames, joints, 3)."""
        body = self.performer(character).character
        if isinstance(body, Athlete):
            return np.einsum("fh,hjk->fjk", own, body.hinge_axes)
        return own.reshape(self.frames, -1, 3)

    def root_force(self, character: int = 0) -> Array:
        """Outside force on the root [N], world, shape (frames, 3); zero when nothing holds it."""
        return self.torque[:, self.performer(character).dofs][:, :3]

    def root_torque(self, character: int = 0) -> Array:
        """Outside torque on the root [N m], world, shape (frames, 3)."""
        who = self.performer(character)
        turned = self.body_rotations[:, who.bodies[0]]
        return rot.rotate(turned, self.torque[:, who.dofs][:, 3:6])

    def ground_reaction(self, character: int = 0, *, links: Integers | None = None) -> Array:
        """Force of the fixed world on the character [N], world, shape (frames, 3).

        With `links` (body numbers) only the force on those.
        """
        bodies = self.performer(character).bodies if links is None else links
        return self.contacts.force_on(bodies, self.frames, other=np.zeros(1, dtype=np.int64))

    def link_forces(self, character: int = 0) -> Array:
        """Contact force on every link [N], world, shape (frames, links, 3)."""
        who = self.performer(character)
        each = [self.contacts.force_on(np.array([b]), self.frames) for b in who.bodies]
        return np.stack(each, axis=1)


def measured(take: Take, *, rate: float | None = None) -> Measured:
    """Measure a take at every step, or at about `rate` frames per second.

    Contact forces change from step to step, so means and peaks need every step; a rate is for a
    quick look. The true rate is the take's own divided by a whole number.

    Raises:
        InvalidValue: The rate is not positive, or the take has no frames.
    """
    if rate is not None and not rate > 0:
        raise InvalidValue(f"rate is {rate} Hz; it must be positive, or None for every step.")
    if len(take.times) == 0:
        raise InvalidValue("The take has no frames; there is nothing to measure.")
    stride = 1 if rate is None else max(1, round(take.rate / rate))
    return measured_at(take, np.arange(0, len(take.times), stride), take.rate / stride)


def measured_at(take: Take, steps: Integers, rate: float) -> Measured:
    """Measure a take at the frames `steps`; see `measured`."""
    model = copy.copy(take.model)
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data = mujoco.MjData(model)
    who = performers(take)
    with quiet_engine():
        raw = _pass(take, model, data, steps, np.array([p.bodies[0] for p in who]))
    torque, power = _over_the_step(take, model, steps, raw)
    center = raw.centers[:, model.body_rootid]
    kept = (raw.energy, raw.centers, raw.places, raw.turned, raw.resistance, raw.push)
    for array in (torque, power, *kept):
        array.setflags(write=False)
    return Measured(
        steps=steps,
        times=np.asarray(take.times)[steps],
        rate=rate,
        performers=who,
        torque=torque,
        power=power,
        resistance=raw.resistance,
        push=raw.push,
        kinetic=raw.energy[:, 1],
        potential=-float(model.body_mass.sum()) * (raw.centers[:, 0] @ model.opt.gravity),
        center_of_mass=raw.trees[:, :, 0],
        momentum=raw.trees[:, :, 1],
        angular_momentum=raw.trees[:, :, 2],
        contacts=raw.contacts.table(raw.velocity, center),
        owners=owners(take),
        body_positions=raw.places,
        body_rotations=raw.turned,
    )


def performers(take: Take) -> tuple[Performer, ...]:
    """Where each character of the take's scene is in its model."""
    model, out = take.model, []
    for k, (character, part) in enumerate(
        zip(take.scene.characters, take.scene.parts, strict=True)
    ):
        bodies = np.array(part.bodies, dtype=np.int64)
        mass = float(model.body_mass[bodies].sum())
        gravity = float(np.linalg.norm(model.opt.gravity)) or 9.81
        out.append(
            Performer(
                character=character,
                index=k,
                coordinates=part.qpos,
                dofs=part.dofs,
                bodies=bodies,
                weight=mass * gravity,
                height=float(character.height),
            )
        )
    return tuple(out)


@dataclass
class _Raw:
    """What one pass keeps; arrays are filled frame by frame."""

    servo: Array
    outputs: Array
    resistance: Array
    push: Array
    energy: Array
    centers: Array
    trees: Array
    velocity: Array
    places: Array
    turned: Array
    contacts: Recorder


def _pass(
    take: Take, model: Any, data: Any, steps: Integers, roots: Integers
) -> _Raw:  # MjModel, MjData
    frames, bodies = len(steps), model.nbody
    raw = _Raw(
        servo=np.empty((frames, model.nv)),
        outputs=np.empty((frames, len(data.actuator_force))),
        resistance=np.empty((frames, model.nv)),
        push=np.zeros((frames, model.nv)),
        energy=np.empty((frames, 2)),
        centers=np.empty((frames, bodies, 3)),
        trees=np.empty((frames, len(roots), 3, 3)),
        velocity=np.empty((frames, bodies, 6)),
        places=np.empty((frames, bodies, 3)),
        turned=np.empty((frames, bodies, 4)),
        contacts=Recorder(model),
    )
    # Views of the engine's memory: looking them up every frame would cost as much as the physics.
    qpos, qvel, ctrl, applied = data.qpos, data.qvel, data.ctrl, data.qfrc_applied
    moved = (
        (raw.servo, data.qfrc_actuator),
        (raw.outputs, data.actuator_force),
        (raw.energy, data.energy),
        (raw.centers, data.subtree_com),
        (raw.velocity, data.cvel),
        (raw.places, data.xpos),
        (raw.turned, data.xquat),
    )
    com, linear, angular = data.subtree_com, data.subtree_linvel, data.subtree_angmom
    mass = model.body_subtreemass[roots][:, None]
    times, forward, subtree = data, mujoco.mj_forward, mujoco.mj_subtreeVel
    has_ctrl, has_applied = model.nu > 0, len(take.qfrc_applied) > 0
    outside, pushes = pushing(take), data.xfrc_applied
    for f, t in enumerate(steps):
        qpos[:], qvel[:] = take.qpos[t], take.qvel[t]
        if has_ctrl:
            ctrl[:] = take.ctrl[t]
        if has_applied:
            applied[:] = take.qfrc_applied[t]
        if outside is not None:
            pushes[:] = outside[t]
        times.time = take.times[t]
        forward(model, data)
        subtree(model, data)
        for kept, live in moved:
            kept[f] = live
        raw.resistance[f] = data.qfrc_passive + data.qfrc_constraint
        if outside is not None and pushes.any():
            # What is left of all forces but the constraints' when the known ones are taken off.
            known = data.qfrc_passive - data.qfrc_bias + data.qfrc_actuator + applied
            raw.push[f] = data.qfrc_smooth - known
        trees = raw.trees[f]
        trees[:, 0], trees[:, 1], trees[:, 2] = com[roots], linear[roots] * mass, angular[roots]
        raw.contacts.record(f, data)
    return raw


def pushing(take: Take) -> Array | None:
    """Force, then torque, on every body's center of mass [N, N m], world, (frames, bodies, 6).

    None where nothing pushed.
    """
    outside = getattr(take, "xfrc_applied", None)
    return None if outside is None or not np.any(outside) else np.asarray(outside)


def _over_the_step(take: Take, model: Any, steps: Integers, raw: _Raw) -> tuple[Array, Array]:
    """Torque and power over the step that follows each frame; corrects `raw.resistance` too."""
    torque = raw.servo.copy()
    if len(take.qfrc_applied):
        torque += take.qfrc_applied[steps]
    last = len(take.times) - 1
    after = np.minimum(steps + 1, last)
    arrived = take.qvel[after]
    change = arrived - take.qvel[steps]
    kinds = mujoco.mjtIntegrator
    kind = int(model.opt.integrator)
    whole = kind == int(kinds.mjINT_DISCRETE)
    if whole or kind in (int(kinds.mjINT_IMPLICITFAST), int(kinds.mjINT_IMPLICIT)):
        torque -= servo_gain(model, raw.outputs, 2) * change
        raw.resistance -= model.dof_damping * change
    if whole:
        # This integrator also takes stiffness at the end of the step.
        torque -= servo_gain(model, raw.outputs, 1) * arrived / take.rate
        raw.resistance -= _joint_stiffness(model) * arrived / take.rate
    # The last frame has no step after it; it repeats the torque of the step before.
    if len(steps) > 1 and steps[-1] == last:
        torque[-1] = torque[-2]
    return torque, torque * (take.qvel[steps] + 0.5 * change)


def _joint_stiffness(model: Any) -> Array:
    """Linear spring constant on every degree of freedom, shape (dofs,)."""
    return np.asarray(model.jnt_stiffness).reshape(model.njnt)[model.dof_jntid]


def servo_gain(model: Any, outputs: Array, order: int) -> Array:
    """Gain of the servos on every degree of freedom as the engine integrates it, (frames, dofs).

    Servos are affine actuators on joints; one on a ball joint acts equally on its three axes. A
    servo at its force limit has no gain left.

    Args:
        model: The model.
        outputs: What the actuators gave, `actuator_force` of every frame.
        order: 1 for stiffness [N/m, N m/rad], 2 for damping [N s/m, N m s/rad].
    """
    out = np.zeros((len(outputs), model.nv))
    on_joints = np.flatnonzero(
        np.isin(model.actuator_trntype, _ON_JOINTS)
        & (model.actuator_biastype != int(mujoco.mjtBias.mjBIAS_NONE))
    )
    widths = {int(mujoco.mjtJoint.mjJNT_BALL): 3, int(mujoco.mjtJoint.mjJNT_FREE): 6}
    for i in on_joints:
        joint = model.actuator_trnid[i, 0]
        start = model.jnt_dofadr[joint]
        width = widths.get(int(model.jnt_type[joint]), 1)
        gear = model.actuator_gear[i, 0] if width == 1 else 1.0
        gain = np.full(len(outputs), -model.actuator_biasprm[i, order] * gear**2)
        if model.actuator_forcelimited[i]:
            first = model.actuator_outadr[i]
            given = np.linalg.norm(outputs[:, first : first + model.actuator_outnum[i]], axis=1)
            gain[given >= np.abs(model.actuator_forcerange[i]).max() * (1 - 1e-9)] = 0.0
        out[:, start : start + width] += gain[:, None]
    return out
