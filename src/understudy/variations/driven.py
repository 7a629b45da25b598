"""The same variations on rigid bodies that a drive pushes along a clip: the paper's own case.

A linkage's bodies have the names of the clip's joints, and such a name means that body, as in the
paper. The names of a person's joints and limbs mean the bodies that begin there: "left_knee" the
shank, "left_arm" all outboard of the shoulder.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np

from understudy.character import Linkage
from understudy.character.roles import find_roles
from understudy.control import Drive
from understudy.errors import UnknownName
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.figure import LINKS
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.variations.names import LIMBS

# K_f of the paper's constrained skeleton [1/s], Wilke & Semwal 2017, table 1: the loosest grip.
LOOSE_GAIN = 24.1933


def drive_of(performance: Performance, character: int) -> Drive | None:
    """The drive of a linkage, or None where the performer is none."""
    for controller in performance.controllers:
        if isinstance(controller, Drive) and controller.character == character:
            return controller
    return None


def bodies_of(drive: Drive, name: str) -> tuple[int, ...]:
    """Numbers of the bodies that a name means.

    Raises:
        UnknownName: There is no such joint, link or limb.
    """
    skeleton = drive.reference.skeleton
    if name in skeleton.names:
        return (skeleton.index(name),)
    if name == "body":
        return tuple(range(len(skeleton)))
    found = _roles(drive.reference)
    roles = LIMBS.get(name) or (_role(name),)
    begin = [skeleton.index(found[role]) for role in roles if role in found]
    # A joint where no body begins, such as a head's in some clips, is its own body.
    bodies = sorted({b for joint in begin for b in skeleton.children(joint) or [joint]})
    if name.startswith(("left", "right")) and name in LIMBS:
        bodies = sorted({j for body in bodies for j in _outboard(skeleton, body)})
    if not bodies:
        limbs = [limb for limb, parts in LIMBS.items() if any(r in found for r in parts)]
        raise UnknownName("joint, link or limb", name, [*limbs, *skeleton.names, *found])
    return tuple(bodies)


def joint_of(drive: Drive, name: str) -> str:
    """The clip joint that a joint's or link's name means.

    Raises:
        UnknownName: There is no such joint.
    """
    found = _roles(drive.reference)
    if name in drive.reference.skeleton.names:
        return name
    if _role(name) in found:
        return found[_role(name)]
    raise UnknownName("joint", name, [*drive.reference.skeleton.names, *found])


def scaled(performance: Performance, drive: Drive, name: str, weights: Array) -> Performance:
    """K_v(j, f) times `weights`, shape (frames,), for the bodies named."""
    return _with(performance, drive, scaling=_times(drive, drive.scaling, name, weights))


def weakened(performance: Performance, drive: Drive, name: str, factor: float) -> Performance:
    """The strength of the bodies named times a factor; a drive never exceeds what its law says."""
    weights = np.full(drive.reference.frames, factor)
    strength = np.minimum(_times(drive, drive.strength, name, weights), 1.0)
    return _with(performance, drive, strength=strength)


def held(performance: Performance, drive: Drive, name: str, at: Any) -> Performance:
    """A joint locked in all axes at "straight", "mean", "start", or a rotation vector [rad]."""
    joint = joint_of(drive, name)
    if not drive.reference.skeleton.children(drive.reference.skeleton.index(joint)):
        return performance  # no body hangs on it
    own = drive.reference.joint(joint)
    turn = {
        "straight": lambda: rot.identity(),
        "mean": lambda: rot.mean(own, axis=0),
        "start": lambda: own[0],
    }.get(at, lambda: rot.from_rotvec(np.array(at)))()
    linkage = _linkage(performance, drive).locked(joint, rotation=turn)
    return _with(_with_linkage(performance, drive, linkage), drive)


def weighed(performance: Performance, drive: Drive, name: str, kind: str, amount: float) -> Any:
    """The bodies named with other masses: "by" a factor, "to" kg, or "share" of the whole."""
    linkage = _linkage(performance, drive)
    masses = np.array(linkage.masses)
    # The paper's unit of mass: one body of those there are, whatever was changed before.
    total = float(np.median(masses)) * len(masses)
    for body in bodies_of(drive, name):
        masses[body] = {"by": amount * masses[body], "to": amount, "share": amount * total}[kind]
    if np.array_equal(masses, linkage.masses):
        return performance
    return _with(_with_linkage(performance, drive, replace(linkage, masses=masses)), drive)


def retimed(performance: Performance, drive: Drive, factor: float) -> Performance:
    """The clip at another speed; K_v and strengths over time go with it."""
    reference = drive.reference.retimed(factor)
    at = np.minimum(
        np.round(np.arange(reference.frames) * factor).astype(int), drive.reference.frames - 1
    )
    timed = {
        name: value[at]
        for name in ("scaling", "strength")
        if (value := getattr(drive, name)) is not None and value.ndim == 2
    }
    captured = None if drive.captured is None else drive.captured.retimed(factor)
    longer = replace(performance, duration=reference.duration)
    return _with(longer, drive, reference=reference, captured=captured, **timed)


def gripped(performance: Performance, drive: Drive, grip: float) -> Performance:
    """K_f from the paper's (0) to the drive's own (1), and K_p from none to critical damping."""
    if drive.law == "paper" or grip == 1.0:
        return performance
    own = drive.gain_in(performance.scene)
    gain = LOOSE_GAIN * (own / LOOSE_GAIN) ** grip
    position = grip * drive.position_gain_in(performance.scene) * (gain / own) ** 2
    return _with(performance, drive, gain=gain, position_gain=position)


# -- details ----------------------------------------------------------------------------------


def _role(name: str) -> str:
    """A person's joint from its name or its link's: "left_foot" is "left_ankle"."""
    return next((role for role, link in LINKS.items() if link == name), name)


class _Clip:
    """A key equal for clips of one skeleton value: roles are looked for once."""

    def __init__(self, clip: Clip):
        self.clip = clip

    def __hash__(self) -> int:
        return hash(self.clip.skeleton.names)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Clip) and other.clip.skeleton == self.clip.skeleton


@functools.lru_cache(maxsize=4)
def _found(key: _Clip) -> dict[str, str]:
    return find_roles(key.clip).joints


def _roles(clip: Clip) -> dict[str, str]:
    return _found(_Clip(clip))


def _outboard(skeleton: Any, joint: int) -> list[int]:
    return [joint, *(k for child in skeleton.children(joint) for k in _outboard(skeleton, child))]


def _times(drive: Drive, before: Array | None, name: str, weights: Array) -> Array:
    frames, joints = drive.reference.frames, len(drive.reference.skeleton)
    out = np.ones((frames, joints))
    if before is not None:
        out *= before
    out[:, list(bodies_of(drive, name))] *= weights[:, None]
    return out


def _linkage(performance: Performance, drive: Drive) -> Linkage:
    return drive.linkage(performance.scene)


def _with_linkage(performance: Performance, drive: Drive, linkage: Linkage) -> Performance:
    characters = list(performance.scene.characters)
    characters[drive.character] = linkage
    return replace(performance, scene=replace(performance.scene, characters=tuple(characters)))


def _with(performance: Performance, drive: Drive, **changes: Any) -> Performance:
    new = replace(drive, **changes) if changes else drive
    controllers = tuple(new if c is drive else c for c in performance.controllers)
    return replace(performance, controllers=controllers)
