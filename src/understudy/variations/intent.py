"""Variations of what the performer means and can do: scaling, strength, limpness, locks, speed.

Wilke & Semwal 2017: asymmetric scaling multiplies a joint's velocity, K_v(j, f) v(j, f), over some
frames; under-controlling leaves bodies without a controller. On an articulated body a joint's
velocity is its rotation's, so its whole rotation is scaled, about a pose that it keeps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from understudy.control.feedforward import Rehearsal
from understudy.control.tracking import ROOT_FREQUENCY
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array
from understudy.performance import Performance
from understudy.variations import driven
from understudy.variations.change import (
    Amount,
    Variation,
    body_of,
    exchanged,
    rehearsed,
    tracking_of,
)
from understudy.variations.names import joints_of

# Joints that bend one way only: scaled about their straightest moment they never bend backward.
_HINGES = ("elbow", "knee")
_MOST_ANGLE = 3.0  # rad; a scaled joint stays short of half a turn from what it is scaled about
# Overall stiffness [1/s^2] at grip 0, where a trunk still carries itself, and at grip 1, where it
# is the default of `Tracking`.
GRIP_STIFFNESS = (60.0, 3000.0)


@dataclass(frozen=True, kw_only=True)
class Scaling(Variation):
    """Asymmetric scaling: a joint moves by a factor more or less than in the clip.

    The joint's rotation is scaled about its mean over the time range (elbows and knees: about their
    straightest pose, so that they do not bend backward), and eased in and out.

    Attributes:
        joint: A joint, or a limb for all of its joints.
        by: The paper's K_v: 1.2 for a fifth more, 0 to stand still.
        start: Begin of the range [s]; None for the clip's begin.
        end: End of the range [s]; None for the clip's end.
        ease: Time from no scaling to full scaling at a begin or end inside the clip [s].
    """

    joint: str
    by: Amount
    start: float | None = None
    end: float | None = None
    ease: float = 0.25

    def __post_init__(self) -> None:
        self._check_amounts(0.0, 5.0)
        if not 0 <= self.ease <= 60:
            raise InvalidValue(f"Scaling: ease is {self.ease} s; it must lie in 0 to 60.")

    def _varied(self, performance: Performance) -> Performance:
        factor = self._number("by")
        if drive := driven.drive_of(performance, self.character):
            driven.bodies_of(drive, self.joint)
            weights = 1.0 + (factor - 1.0) * self._weights(drive.reference)
            same = factor == 1.0
            return performance if same else driven.scaled(performance, drive, self.joint, weights)
        tracking = tracking_of(performance, self.character)
        body = body_of(performance, self.character)
        joints = joints_of(body, self.joint)
        weights = self._weights(tracking.reference)
        if factor == 1.0:
            return performance
        reference = tracking.reference
        turned = np.array(reference.rotations)
        inside = weights > 0
        for joint in joints:
            j = reference.skeleton.index(joint)
            role = body.links[j].role or ""
            own = turned[:, j]
            if role.endswith(_HINGES):
                center = own[inside][np.argmin(rot.angle(own[inside]))]
            else:
                center = rot.mean(own[inside], axis=0)
            away = rot.to_rotvec(rot.multiply(rot.conjugate(center), own))
            length = np.linalg.norm(away, axis=1, keepdims=True)
            grown = away * (1.0 + (factor - 1.0) * weights[:, None])
            most = np.maximum(length, _MOST_ANGLE)
            grown *= np.minimum(
                1.0, most / np.maximum(np.linalg.norm(grown, axis=1, keepdims=True), 1e-12)
            )
            changed = rot.multiply(center, rot.from_rotvec(grown))
            turned[inside, j] = changed[inside]
        varied = replace(reference, rotations=turned).noted(f"{self}.")
        return exchanged(
            performance, tracking, replace(rehearsed(performance, tracking), reference=varied)
        )

    def _weights(self, clip: Clip) -> Array:
        """How much of the scaling each frame gets, 0 to 1, shape (frames,)."""
        start = 0.0 if self.start is None else self.start
        end = clip.duration if self.end is None else self.end
        slack = 0.5 / clip.rate
        if not (-slack <= start < end <= clip.duration + slack):
            raise InvalidValue(
                f"Scaling: the time range {start:g} to {end:g} s is empty or outside the clip, "
                f"which lasts 0 to {clip.duration:g} s."
            )
        times, ease = clip.times, max(min(self.ease, 0.5 * (end - start)), 1e-9)
        up = np.ones(clip.frames) if start <= slack else (times - start) / ease
        down = np.ones(clip.frames) if end >= clip.duration - slack else (end - times) / ease
        ramp = np.clip(np.minimum(up, down), 0.0, 1.0)
        if not ramp.any():
            raise InvalidValue(f"Scaling: no frame lies between {start:g} and {end:g} s.")
        return 0.5 - 0.5 * np.cos(np.pi * ramp)

    def __str__(self) -> str:
        when = ""
        if self.start is not None or self.end is not None:
            end = "the end" if self.end is None else f"{self.end:g} s"
            when = f" from {self.start or 0:g} s to {end}"
        return f"{spoken(self.joint)}: motion x {said(self.by)}{when}"


@dataclass(frozen=True, kw_only=True)
class Strength(Variation):
    """A joint gives a factor more or less torque than its servo would.

    Gains, feedforward and torque limit alike: weaker joints sag and lag, stronger ones overshoot.
    A drive's bodies are never stronger than its law: factors above 1 do nothing there.

    Attributes:
        joint: A joint, or a limb for all of its joints.
        by: Factor; 0 is limp. Factors of several variations multiply.
    """

    joint: str
    by: Amount

    def __post_init__(self) -> None:
        self._check_amounts(0.0, 10.0)

    def _varied(self, performance: Performance) -> Performance:
        factor = self._number("by")
        if drive := driven.drive_of(performance, self.character):
            driven.bodies_of(drive, self.joint)
            same = factor == 1.0
            return performance if same else driven.weakened(performance, drive, self.joint, factor)
        tracking = tracking_of(performance, self.character)
        joints = joints_of(body_of(performance, self.character), self.joint)
        if factor == 1.0:
            return performance
        known = dict(tracking.strengths)
        for joint in joints:
            known[joint] = known.get(joint, 1.0) * factor
        new = replace(rehearsed(performance, tracking), strengths=tuple(sorted(known.items())))
        return exchanged(performance, tracking, new)

    def __str__(self) -> str:
        return f"{spoken(self.joint)}: strength x {said(self.by)}"


@dataclass(frozen=True, kw_only=True)
class Limp(Variation):
    """Under-controlling: joints without any servo, only a little passive damping.

    Attributes:
        joint: A joint, or a limb for all of its joints.
    """

    joint: str

    def _varied(self, performance: Performance) -> Performance:
        limp = Strength(joint=self.joint, by=0.0, character=self.character)
        return limp(performance)

    def __str__(self) -> str:
        return f"{spoken(self.joint)}: limp"


@dataclass(frozen=True, kw_only=True)
class Lock(Variation):
    """Joints held at one angle, as by a splint.

    Attributes:
        joint: A joint, or a limb for all of its joints.
        at: "straight" (the neutral pose), "mean" (of the clip), "start" (the clip's first frame),
            or a rotation vector from neutral in the outboard link's frame [rad], three numbers.
    """

    joint: str
    at: Literal["straight", "mean", "start"] | tuple[float, float, float] = "straight"

    def __post_init__(self) -> None:
        named = isinstance(self.at, str) and self.at in ("straight", "mean", "start")
        turn = not isinstance(self.at, str) and len(self.at) == 3 and np.isfinite(self.at).all()
        if not (named or (turn and np.linalg.norm(np.asarray(self.at, float)) <= np.pi)):
            raise InvalidValue(
                f"Lock: at is {self.at!r}; it must be 'straight', 'mean', 'start' or three numbers "
                "of at most pi together."
            )

    def _varied(self, performance: Performance) -> Performance:
        if drive := driven.drive_of(performance, self.character):
            return driven.held(performance, drive, self.joint, self.at)
        tracking = tracking_of(performance, self.character)
        joints = joints_of(body_of(performance, self.character), self.joint)
        turned = np.array(tracking.reference.rotations)
        for joint in joints:
            own = turned[:, tracking.reference.skeleton.index(joint)]
            own[:] = self._pose(own)
        new = replace(
            rehearsed(performance, tracking),
            reference=replace(tracking.reference, rotations=turned).noted(f"{self}."),
            locked=tuple(sorted({*tracking.locked, *joints})),
        )
        return exchanged(performance, tracking, new)

    def _pose(self, own: Array) -> Array:
        if self.at == "mean":
            return rot.mean(own, axis=0)
        if self.at == "start":
            return np.array(own[0])
        return rot.identity() if self.at == "straight" else rot.from_rotvec(np.array(self.at))

    def __str__(self) -> str:
        where = self.at if isinstance(self.at, str) else f"{np.degrees(self.at).round().tolist()}°"
        return f"{spoken(self.joint)}: locked ({where})"


@dataclass(frozen=True, kw_only=True)
class Speed(Variation):
    """The whole motion faster or slower.

    Attributes:
        by: Factor; 2 for twice as fast.
    """

    by: Amount

    def __post_init__(self) -> None:
        self._check_amounts(0.1, 10.0)

    def _varied(self, performance: Performance) -> Performance:
        factor = self._number("by")
        if factor == 1.0:
            return performance
        if drive := driven.drive_of(performance, self.character):
            return driven.retimed(performance, drive, factor)
        tracking = tracking_of(performance, self.character)
        known = tracking.rehearsal
        captured = tracking.captured
        new = replace(
            tracking,
            reference=tracking.reference.retimed(factor),
            captured=None if captured is None else captured.retimed(factor),
            rehearsal=known
            and Rehearsal(scene=known.scene, reference=known.reference.retimed(factor)),
        )
        return exchanged(performance, tracking, new)

    def __str__(self) -> str:
        return f"speed x {said(self.by)}"


@dataclass(frozen=True, kw_only=True)
class Grip(Variation):
    """The strength slider: how tightly servos hold the body to the clip.

    Tracking and the generative effect are traded against each other: at 1 (the usual stiffness)
    servos undo most of what a variation does to the rest of the body, toward 0 its consequences
    spread, and the motion strays from the clip. Legs over ground keep what standing needs.

    Attributes:
        to: 0 to 1.
    """

    to: Amount

    def __post_init__(self) -> None:
        self._check_amounts(0.0, 1.0)

    def _varied(self, performance: Performance) -> Performance:
        grip = self._number("to")
        if drive := driven.drive_of(performance, self.character):
            return driven.gripped(performance, drive, grip)
        tracking = tracking_of(performance, self.character)
        low, high = GRIP_STIFFNESS
        stiffness = high if grip == 1.0 else low * (high / low) ** grip
        along, up, turn = tracking.root_frequency or ROOT_FREQUENCY[tracking.pelvis]
        if tracking.root_frequency is None and grip < 1.0:
            turn *= (stiffness / high) ** 0.25
        frequency = None if grip == 1.0 else (along, up, turn)
        new = replace(tracking, stiffness=stiffness, root_frequency=frequency)
        return performance if new == tracking else exchanged(performance, tracking, new)

    def __str__(self) -> str:
        return f"grip {said(self.to)}"


def spoken(name: str) -> str:
    """A joint's name for a sentence."""
    return name.replace("_", " ")


def said(amount: Amount) -> str:
    """An amount or a range for a sentence."""
    if isinstance(amount, tuple):
        return f"{amount[0]:.3g} to {amount[1]:.3g}"
    return f"{amount:.3g}"
