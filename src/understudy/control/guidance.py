"""Guidance: small turns of a few joints, window by window, with which a body needs no other hold.

Servos alone let a body that nothing holds fall within a second. A guidance turns the commands of
trunk, hips, knees and ankles a little, in windows of some hundredths of a second; where it has
gains, by what the body is off its plan when a window begins. `free_tracking` finds one for a clip.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from understudy.character import Character
from understudy.control import guidance_law
from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.scene import Scene

# Which axes of which joints are turned: a trunk and hips about all, a knee about its own, an ankle
# about the foot's lateral and long axes.
AXES = {"lower_back": "xyz", "hip": "xyz", "knee": "y", "ankle": "xy"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Guidance:
    """A plan for one character, to stand after its `Tracking` in a performance.

    Attributes:
        window: Length of a window [s]; offsets hold for its length.
        offsets: Rotation vectors added to the commands, in the outboard links' frames [rad], shape
            (windows, axes); `axes` has their order.
        help: Force [N], world, and torque [N m], pelvis frame, that hold the pelvis, shape
            (windows, 6). Zero for a free body.
        postures: What is planned for the start of every window, shape (windows, 22): center of mass
            [m], its velocity [m/s], angular momentum about it [kg m^2/s], orientation of the pelvis
            and its angular velocity [rad/s], positions of the left and right ankle [m]; all world.
        gains: Offsets for being off the plan, shape (windows, axes, 21 + axes): per deviation of
            the posture (the pelvis' turn as a rotation vector), then per offset of the window
            before beyond its plan. No gains, shape (0, axes, 21 + axes): always the planned ones.
        most: Largest offset that the gains add [rad].
        character: Which of the scene's characters.
        found: How it was found: plain values for the certificate.
    """

    window: float
    offsets: Array = field(repr=False)
    help: Array = field(repr=False)
    postures: Array = field(repr=False)
    gains: Array = field(repr=False)
    most: float = 0.3
    character: int = 0
    found: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        windows, size = np.shape(self.offsets)
        known = guidance_law.DEVIATION + size
        shapes = {
            "offsets": (windows, size),
            "help": (windows, guidance_law.HELP),
            "postures": (windows, guidance_law.POSTURE),
            "gains": (windows if len(self.gains) else 0, size, known),
        }
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), float)
            if array.shape != shape:
                raise InvalidValue(
                    f"{name} of a Guidance has shape {array.shape}; it must have shape {shape}."
                )
            if not np.isfinite(array).all():
                raise InvalidValue(f"{name} of a Guidance must be finite; not all values are.")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if not (np.isfinite(self.window) and self.window > 0.0):
            raise InvalidValue(f"window is {self.window} s; it must be positive.")
        if not 0.0 <= self.most <= np.pi:
            raise InvalidValue(f"most is {self.most} rad; it must lie in 0 to pi.")

    @property
    def facts(self) -> dict[str, Any]:
        """What a certificate says about it."""
        return {
            "guidance": {**self.found, "window_s": self.window, "feedback": len(self.gains) > 0}
        }

    def configure(self, scene: Scene, model: mujoco.MjModel) -> None:
        """Check that the body has what is guided, and take over its servos' limits.

        Raises:
            InvalidValue: It has not, or the windows are no whole number of steps.
        """
        size = len(axes(scene, self.character))
        if size != self.offsets.shape[1]:
            raise InvalidValue(
                f"This guidance turns {self.offsets.shape[1]} axes; the body has {size}."
            )
        limit_commands(scene, model, self.character)
        every = self.window / scene.timestep
        if abs(every - round(every)) > 1e-6 or round(every) < 1:
            raise InvalidValue(
                f"The guidance has windows of {self.window} s; that is no whole number of steps of "
                f"{scene.timestep} s."
            )

    def start(self, scene: Scene, data: mujoco.MjData) -> None:
        """Leave the first state as it is."""

    def feedback(self, scene: Scene, model: mujoco.MjModel) -> tuple[Any, Array, Array]:
        """The law, its parameters, and room for what it remembers."""
        head = layout(scene, model, self.character)
        head[guidance_law.EVERY] = round(self.window / scene.timestep)
        head[guidance_law.COUNT] = len(self.offsets)
        head[guidance_law.MOST], head[guidance_law.FEEDBACK] = self.most, len(self.gains) > 0
        rows = [self.postures, self.offsets, self.help]
        if len(self.gains):
            rows.append(self.gains.reshape(len(self.gains), -1))
        parameters = np.concatenate((head, np.concatenate(rows, axis=1).ravel()))
        room = 2 * self.offsets.shape[1] + guidance_law.POSTURE + guidance_law.DEVIATION
        return guidance_law.law, parameters, np.zeros(room)


def axes(scene: Scene, character: int) -> list[tuple[int, int]]:
    """Link and axis (0, 1, 2) of every offset, in their order.

    Raises:
        InvalidValue: The body has no legs to stand on.
    """
    body = scene.characters[character]
    roles = [link.role or "" for link in body.links] if isinstance(body, Character) else []
    out = []
    for link, role in enumerate(roles):
        turned = AXES.get(role, AXES.get(role.partition("_")[2], ""))
        out += [(link, "xyz".index(axis)) for axis in turned]
    if not all(f"{side}_ankle" in roles for side in ("left", "right")):
        raise InvalidValue(
            f"{getattr(body, 'name', body)!r} has no two legs; only a body with legs can be free."
        )
    return out


def layout(scene: Scene, model: mujoco.MjModel, character: int) -> Array:
    """The law's parameters before the windows' rows; see `guidance_law`."""
    part, body = scene.parts[character], scene.characters[character]
    rows: dict[int, list[float]] = {}
    turned = axes(scene, character)
    for k, (link, axis) in enumerate(turned):
        row = rows.setdefault(link, [part.joint_controls[link - 1], -1.0, -1.0, -1.0])
        row[1 + axis] = k
    head = np.zeros(guidance_law.HEAD)
    head[guidance_law.STEP], head[guidance_law.EVERY] = scene.timestep, 1
    head[guidance_law.DOF], head[guidance_law.ROOT] = part.dofs.start, part.bodies[0]
    roles = [link.role for link in body.links]
    head[guidance_law.LEFT] = part.bodies[roles.index("left_ankle")]
    head[guidance_law.RIGHT] = part.bodies[roles.index("right_ankle")]
    head[guidance_law.BODIES], head[guidance_law.JOINTS] = len(part.bodies), len(rows)
    head[guidance_law.SIZE] = len(turned)
    bodies = list(part.bodies)
    solid = np.column_stack(
        (bodies, model.body_mass[bodies], model.body_inertia[bodies], model.body_iquat[bodies])
    )
    limited = _limited(scene, model, character)
    head[guidance_law.LIMITED] = len(limited)
    return np.concatenate(
        (head, np.array(list(rows.values()), float).ravel(), solid.ravel(), limited.ravel())
    )


def limit_commands(scene: Scene, model: mujoco.MjModel, character: int) -> None:
    """Leave the limits of a character's servos to the law: no command asks for more."""
    for actuator in scene.parts[character].joint_actuators:
        model.actuator_forcelimited[actuator] = False


def _limited(scene: Scene, model: mujoco.MjModel, character: int) -> Array:
    """A row for every joint whose servo has a limit; see `guidance_law`."""
    part = scene.parts[character]
    # The discrete integrator takes the stiffness at the end of the step: damping more.
    late = model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
    rows = []
    for j, actuator in enumerate(part.joint_actuators):
        k, most = model.actuator_gainprm[actuator, 0], model.actuator_forcerange[actuator].max()
        if k > 0.0 and most > 0.0:
            kd = -model.actuator_biasprm[actuator, 2] + late * scene.timestep * k
            first = part.qpos.start + 7 + 4 * j, part.dofs.start + 6 + 3 * j
            rows.append((part.joint_controls[j], *first, k, kd, most))
    return np.array(rows, float).reshape(-1, guidance_law.LIMIT)
