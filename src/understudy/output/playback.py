"""What there is to see: the poses of a take or a clip at a picture's rate.

In: a `Take` or a `Clip`. Out: a `Playback`: a model, its pose at every picture, and beside it the
pose of the reference, the prepared clip that the body tracked: the ghost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from understudy.character import Linkage
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.output import bones, meshes
from understudy.output.camera import Shot, bearing_of, framed, smoothed

if TYPE_CHECKING:
    from understudy.take import Take

# What body and ghost are called in a take, and in one that shows how a clip was prepared.
LABELS = {False: ("simulated", "reference"), True: ("prepared", "as read")}
_GAP = 0.35  # m between a body and the ghost beside it
_FRAMING_POSES = 90  # poses looked at to place the camera
_NEAR = 1.5  # a prop's points this near the performers are kept in the picture [m]


@dataclass(frozen=True, kw_only=True, eq=False)
class Playback:
    """Poses to draw.

    Attributes:
        model: What is posed.
        spec: Makes a fresh specification of the same model, for a renderer that dresses it.
        times: Time of each picture [s], shape (frames,).
        rate: Pictures per second [Hz].
        qpos: Pose of the whole scene, shape (frames, nq).
        ghost: The same with the reference in the performers' places, or None.
        ghost_bodies: Bodies that the ghost shows.
        roots: Where the root positions of the performers start in qpos.
        ghost_roots: The same for the performers that have a ghost; of loose bodies, every one's.
        name: For titles.
        simulated: False when the poses come from a clip.
        labels: What the body and its ghost are.
        names: Name of every body, from which left and right are told; by default the model's.
        props: Bodies that belong to no performer and are held by none.
    """

    model: mujoco.MjModel
    spec: Callable[[], mujoco.MjSpec] = field(repr=False)
    times: Array = field(repr=False)
    rate: float
    qpos: Array = field(repr=False)
    ghost: Array | None = field(default=None, repr=False)
    ghost_bodies: tuple[int, ...] = ()
    roots: tuple[int, ...] = (0,)
    ghost_roots: tuple[int, ...] = ()
    name: str = "take"
    simulated: bool = True
    labels: tuple[str, str] = ("simulated", "reference")
    names: tuple[str, ...] = ()
    props: tuple[int, ...] = ()

    @property
    def frames(self) -> int:
        """Number of pictures."""
        return len(self.times)

    def nearest(self, time: float) -> int:
        """The frame nearest to a time [s]; raises `InvalidValue` outside the motion."""
        first, last = float(self.times[0]), float(self.times[-1])
        slack = 1.0 / self.rate
        if not first - slack <= time <= last + slack:
            raise InvalidValue(f"time is {time} s; the motion lasts from {first:g} to {last:g} s.")
        return int(np.argmin(np.abs(self.times - time)))

    def poses(self, qpos: Array) -> tuple[Array, Array]:
        """World positions (n, bodies, 3) [m] and orientations wxyz (n, bodies, 4) of the bodies."""
        data = mujoco.MjData(self.model)
        placed = np.empty((len(qpos), self.model.nbody, 3))
        turned = np.empty((len(qpos), self.model.nbody, 4))
        for k, state in enumerate(qpos):
            data.qpos[:] = state
            mujoco.mj_kinematics(self.model, data)
            placed[k], turned[k] = data.xpos, data.xquat
        return placed, turned

    @cached_property
    def heading(self) -> float:
        """Direction in which the performers face on average, from +x toward +y [rad].

        From the line between left and right parts; from the path where names tell no sides. Where
        two face each other, from the first to the last.
        """
        pairs = _sides(self.names or _body_names(self.model))
        facing = np.zeros(2)
        if pairs:
            placed, _ = self.poses(self.qpos[:: max(1, self.frames // 30)])
            left, right = (list(side) for side in zip(*pairs, strict=True))
            across = (placed[:, left] - placed[:, right]).sum(axis=1)
            forward = np.stack((across[:, 1], -across[:, 0]), axis=-1)  # across x up
            forward /= np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
            mean = forward.mean(axis=0)
            facing = mean if np.linalg.norm(mean) > 0.3 else forward[0]
            if len(self.roots) > 1 and np.linalg.norm(mean) <= 0.3:
                first, last = (
                    self.qpos[:, r : r + 2].mean(axis=0) for r in self.roots[:: len(self.roots) - 1]
                )
                facing = last - first
        if not facing.any():
            facing = self.path[-1, :2] - self.path[0, :2]
        return float(np.arctan2(facing[1], facing[0])) if facing.any() else 0.0

    @property
    def path(self) -> Array:
        """Mean position of the performers' roots [m], shape (frames, 3)."""
        return np.mean([self.qpos[:, r : r + 3] for r in self.roots], axis=0)

    def smooth_path(self) -> Array:
        """The path that a following camera takes [m], shape (frames, 3)."""
        return smoothed(self.path, self.rate)

    def beside(self, view: str = "follow") -> Playback:
        """The same with the ghost moved to the left, as the camera of `view` sees it."""
        if self.ghost is None:
            return self
        bearing = bearing_of(view, self.heading)
        aside = np.array([np.sin(bearing), -np.cos(bearing)])
        held, points = meshes.outline(self.model)
        chosen = np.isin(held, self.ghost_bodies)
        every = max(1, self.frames // 30)
        reach = 0.0
        for states in (self.qpos[::every], self.ghost[::every]):
            seen = self._points(states, held[chosen], points[chosen])
            center = np.mean([states[:, r : r + 2] for r in self.ghost_roots], axis=0)
            across = (seen[..., :2] - center[:, None]) @ aside
            reach += float(np.abs(across).max()) if across.size else 0.0
        ghost = np.array(self.ghost)
        for r in self.ghost_roots:
            ghost[:, r : r + 2] += (min(reach, 3.0) + _GAP) * aside
        return replace(self, ghost=ghost)

    def reference(self) -> Playback:
        """Only the reference, as a body of its own."""
        if self.ghost is None:
            return self
        return replace(self, qpos=self.ghost, ghost=None, simulated=False)

    def between(self, first: int, last: int) -> Playback:
        """Only the frames from `first` up to `last`, which is left out."""
        return self.chosen(np.arange(first, last), rate=self.rate)

    def chosen(self, frames: np.ndarray, *, rate: float) -> Playback:
        """Only the frames numbered, seen as from the same side, at a new rate [Hz]."""
        ghost = None if self.ghost is None else self.ghost[frames]
        shown = replace(
            self, times=self.times[frames], qpos=self.qpos[frames], ghost=ghost, rate=rate
        )
        shown.__dict__["heading"] = self.heading
        return shown

    def alone(self) -> Playback:
        """Without the ghost."""
        return replace(self, ghost=None)

    def shot(self, view: str, aspect: float) -> Shot:
        """The camera that keeps everything that moves in the picture; see `camera.framed`."""
        every = np.unique(np.linspace(0, self.frames - 1, _FRAMING_POSES).astype(int))
        held, points = meshes.outline(self.model, self.props)
        seen = self._points(self.qpos[every], held, points)
        loose = np.isin(held, self.props)
        if loose.any():
            # A ball that rolls away, or the far end of a long table, does not shrink the picture.
            path = np.broadcast_to(self.path[every][:, None], seen.shape)
            apart = np.linalg.norm(seen[..., :2] - path[..., :2], axis=-1)
            seen = np.where((loose & (apart > _NEAR))[..., None], path, seen)
        if self.ghost is not None:
            chosen = np.isin(held, self.ghost_bodies)
            ghost = self._points(self.ghost[every], held[chosen], points[chosen])
            seen = np.concatenate((seen, ghost), axis=1)
        follow = view.startswith("follow")
        shot = framed(
            seen,
            self.path[every],
            rate=max(len(every) - 1, 1) / max(float(np.ptp(self.times)), 1e-9),
            heading=self.heading,
            view=view,
            aspect=aspect,
        )
        if not follow:
            return replace(shot, targets=np.repeat(shot.targets[:1], self.frames, axis=0))
        targets = np.stack(
            [np.interp(np.arange(self.frames), every, shot.targets[:, k]) for k in range(3)], -1
        )
        return replace(shot, targets=targets)

    def _points(self, qpos: Array, bodies: np.ndarray, points: Array) -> Array:
        placed, turned = self.poses(qpos)
        return placed[:, bodies] + rot.rotate(turned[:, bodies], points)


def playback(thing: Take | Clip, *, rate: float = 30.0) -> Playback:
    """What a take or a clip shows, at the rate nearest to `rate` [Hz] that divides its own.

    Raises:
        InvalidValue: `thing` is neither, or the rate is not positive.
    """
    if not (np.isfinite(rate) and rate > 0):
        raise InvalidValue(f"rate is {rate} Hz; it must be positive.")
    if isinstance(thing, Clip):
        return _of_clip(thing, rate)
    from understudy.take import Take

    if isinstance(thing, Take):
        return _of_take(thing, rate)
    raise InvalidValue(f"{type(thing).__name__} cannot be shown; give a Take or a Clip.")


def props_of(take: Take) -> tuple[int, ...]:
    """Bodies of a take that are no performer's and that no performer holds."""
    model = take.model
    performing = {0: False} | {body: True for part in take.scene.parts for body in part.bodies}
    for body in range(1, model.nbody):  # the engine numbers parents before children
        performing.setdefault(body, performing[int(model.body_parentid[body])])
    return tuple(body for body in range(1, model.nbody) if not performing[body])


def sampled(clip: Clip, times: Array) -> tuple[Array, Array]:
    """Root positions (n, 3) [m] and local rotations (n, joints, 4) at times [s], ends held."""
    at = np.clip(np.asarray(times) * clip.rate, 0.0, clip.frames - 1)
    low = np.minimum(at.astype(int), max(clip.frames - 2, 0))
    high = np.minimum(low + 1, clip.frames - 1)
    weight = at - low
    rooted = clip.root_positions
    placed = rooted[low] + weight[:, None] * (rooted[high] - rooted[low])
    return placed, rot.slerp(clip.rotations[low], clip.rotations[high], weight[:, None])


def _of_take(take: Take, rate: float) -> Playback:
    chosen = np.arange(0, take.frames, take.stride(rate))
    times = np.asarray(take.times[chosen], float)
    qpos = np.array(take.qpos[chosen])
    ghost, bodies, ghost_roots = np.array(qpos), [], []
    performers = zip(take.scene.characters, take.scene.parts, take.references, strict=True)
    for character, part, reference in performers:
        if reference is None:
            continue
        placed, turned = sampled(reference, times)
        if isinstance(character, Linkage):
            pose = replace(reference, rotations=turned, root_positions=placed).forward_kinematics()
            ghost[:, part.qpos] = character.coordinates(
                *character.placed(pose.positions, pose.rotations)
            )
        else:
            ghost[:, part.qpos] = np.concatenate((placed, turned.reshape(len(times), -1)), axis=1)
        bodies += part.bodies
        loose = isinstance(character, Linkage) and character.kind != "tree"
        starts = range(part.qpos.start, part.qpos.stop, 7) if loose else [part.qpos.start]
        ghost_roots += starts
    named = [clip.name for clip in take.references if clip is not None]
    return Playback(
        model=take.model,
        spec=take.scene.spec,
        times=times,
        rate=take.rate / take.stride(rate),
        qpos=qpos,
        ghost=ghost if bodies else None,
        ghost_bodies=tuple(bodies),
        roots=tuple(part.qpos.start for part in take.scene.parts),
        ghost_roots=tuple(ghost_roots),
        props=props_of(take),
        labels=LABELS[bool(take.facts.get("posed"))],
        name=" + ".join(named) or " + ".join(c.name for c in take.scene.characters),
    )


def _of_clip(clip: Clip, rate: float) -> Playback:
    skeleton = clip.skeleton

    def spec() -> mujoco.MjSpec:
        return bones.spec_of(skeleton)

    model = spec().compile()
    every = max(1, round(clip.rate / rate))
    qpos = np.zeros((len(range(0, clip.frames, every)), model.nq))
    qpos[:, :3] = clip.root_positions[::every]
    for i in range(len(skeleton)):
        address = int(model.joint(f"j{i}").qposadr[0])
        qpos[:, address : address + 4] = clip.rotations[::every, i]
    # The engine numbers bodies depth first; put the joints' names in its order.
    names = ["world"] * model.nbody
    for i, name in enumerate(skeleton.names):
        names[int(model.body(f"b{i}").id)] = name
    return Playback(
        model=model,
        spec=spec,
        times=clip.times[::every],
        rate=clip.rate / every,
        qpos=qpos,
        name=clip.name,
        simulated=False,
        names=tuple(names),
    )


def _body_names(model: mujoco.MjModel) -> tuple[str, ...]:
    kind = mujoco.mjtObj.mjOBJ_BODY
    return tuple(mujoco.mj_id2name(model, kind, i) or "" for i in range(model.nbody))


def _sides(names: tuple[str, ...]) -> list[tuple[int, int]]:
    """Numbers of the parts whose names differ only in their side: (left, right) pairs."""
    number = {name: i for i, name in enumerate(names)}
    swaps = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"))
    pairs = []
    for name, i in number.items():
        for left, right in swaps:
            if left in name and name.replace(left, right) in number:
                pairs.append((i, number[name.replace(left, right)]))
        for left, right in (("L", "R"), ("l", "r")):
            for other in (
                right + name[1:] if name.startswith(left) else "",
                name[:-1] + right if name.endswith(("_" + left, "." + left)) else "",
            ):
                if other and len(name) > 1 and other in number:
                    pairs.append((i, number[other]))
    return pairs
