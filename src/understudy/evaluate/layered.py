"""How well a runner's upper body shows the clip that was laid on it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.athletics import running_law as law
from understudy.athletics.upper import UpperBody
from understudy.character import Athlete
from understudy.character.hinged import UPPER
from understudy.errors import InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take

# Part of the time that is looked at [Hz].
_RATE = 100.0


@dataclass(frozen=True, kw_only=True)
class Layered:
    """A clip's upper body against what the runner did, while all of it was shown.

    The waist is left out: it is the runner's own for the most part.

    Attributes:
        clip: Name of the clip.
        stride: Whether it was locked to the runner's stride.
        seconds: How long it was shown [s].
        joint_error_deg: Root mean square over the hinges of neck and arms.
        joints_deg: The same by joint.
        hands_mm: Mean distance of the wrists from where they should be, as seen from the chest.
        arms_reach_deg: How far the body's hinges at best point arms and hands from the clip's, root
            mean square; an athlete's forearm does not turn about its length.
    """

    clip: str
    stride: bool
    seconds: float
    joint_error_deg: float
    joints_deg: dict[str, float]
    hands_mm: float
    arms_reach_deg: float

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes."""
        return asdict(self)


def layered(take: Take, *, character: int = 0) -> Layered:
    """How well a runner follows the clip laid on its upper body.

    Raises:
        InvalidValue: The take has no such layer, or ends before all of it is shown.
    """
    controllers = () if take.performance is None else take.performance.controllers
    layer = next(
        (c for c in controllers if isinstance(c, UpperBody) and c.character == character), None
    )
    if layer is None:
        raise InvalidValue(f"Character {character} of this take has no clip on its upper body.")
    body = layer.athlete(take.scene)
    angles, weight = layer.asked(take.scene, take.qpos)
    whole = np.flatnonzero(weight >= 1.0)[:: take.stride(_RATE)]
    if not len(whole):
        raise InvalidValue(f"{layer.clip.name}: the take ends before the upper body is shown.")
    state = np.array(take.qpos[whole][:, take.scene.parts[character].qpos])
    state[:, :7] = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    wanted = np.array(state)
    wanted[:, 7 + law.NECK : 7 + UPPER] = angles[whole, law.NECK :]
    off = np.degrees(state - wanted)[:, 7 + law.NECK : 7 + UPPER]
    hands = np.linalg.norm(_hands(body, state) - _hands(body, wanted), axis=2)
    return Layered(
        clip=layer.clip.name,
        stride=layer.locked,
        seconds=len(whole) * take.stride(_RATE) / take.rate,
        joint_error_deg=_rms(off),
        joints_deg=_by_joint(body, off),
        hands_mm=1e3 * float(hands.mean()),
        arms_reach_deg=_rms(np.degrees(layer.away(body))),
    )


def _by_joint(body: Athlete, off: Array) -> dict[str, float]:
    out, first = {}, 0
    for link, hinges in zip(body.links, body.hinges, strict=True):
        if hinges and first < UPPER:
            if first >= law.NECK:
                at = first - law.NECK
                out[link.joint] = _rms(off[:, at : at + len(hinges)])
            first += len(hinges)
    return out


def _hands(body: Athlete, state: Array) -> Array:
    """Places of the wrists [m], shape (frames, 2, 3)."""
    clip = Clip(
        skeleton=body.skeleton,
        rotations=body.local_rotations(state),
        root_positions=state[:, :3],
        rate=_RATE,
    )
    pose, skeleton = clip.forward_kinematics(), body.skeleton
    joints = [skeleton.index(f"{side}_wrist") for side in ("left", "right")]
    return pose.positions[:, joints]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
