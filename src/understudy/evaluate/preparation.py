"""What was changed of a clip before a body is to perform it, in degrees and millimeters."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.character.soles import sole_paths
from understudy.errors import InvalidValue
from understudy.motion import rotations as rot
from understudy.motion.edits import derivative

if TYPE_CHECKING:
    from understudy.take import Take

# A foot stands whose sole is this near the ground [m] and slow [m/s], for this long [s].
_LOW, _SLOW, _LASTS = 0.02, 0.35, 0.05


@dataclass(frozen=True, kw_only=True)
class Preparation:
    """How far a prepared clip is from the clip as it was read, one constant height left out.

    Attributes:
        joints_deg: Root mean square over joints and time [deg].
        joint_peak_deg: Largest turn of any joint [deg].
        joint_peak: Which joint.
        joint_peak_s: When [s].
        pelvis_mm: Mean way of the pelvis [mm].
        pelvis_peak_mm: Its largest [mm].
        feet_mm: Mean way of the ankles [mm]; None without feet.
        hands_mm: Mean way of the wrists [mm]; None without hands.
        stances: How often each foot stands on the ground.
    """

    joints_deg: float
    joint_peak_deg: float
    joint_peak: str
    joint_peak_s: float
    pelvis_mm: float
    pelvis_peak_mm: float
    feet_mm: float | None
    hands_mm: float | None
    stances: dict[str, int]

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)

    def __str__(self) -> str:
        stood = ", ".join(f"{side} foot {count}" for side, count in self.stances.items())
        ends = [("feet", self.feet_mm), ("hands", self.hands_mm)]
        moved = "".join(f", {name} {size:.0f} mm" for name, size in ends if size is not None)
        return (
            f"joints {self.joints_deg:.1f} deg rms (most {self.joint_peak_deg:.0f}: "
            f"{self.joint_peak} at {self.joint_peak_s:.2f} s), pelvis {self.pelvis_mm:.0f} mm "
            f"(most {self.pelvis_peak_mm:.0f}){moved}; stances: {stood or 'none'}."
        )


def preparation(take: Take, *, character: int = 0) -> Preparation:
    """What was changed, of a take that `understudy.take.posed` made.

    Raises:
        InvalidValue: Another take.
    """
    raw, body = take.references[character], take.scene.characters[character]
    if raw is None or not take.facts.get("posed"):
        raise InvalidValue("This take was simulated; give the one that posed() makes.")
    clip = take.clip(character, rate=take.rate)
    frames = min(raw.frames, clip.frames)
    turned = np.degrees(rot.angle_between(raw.rotations[:frames, 1:], clip.rotations[:frames, 1:]))
    before = raw.forward_kinematics().positions[:frames]
    after = clip.forward_kinematics().positions[:frames]
    moved = 1000.0 * np.linalg.norm(after - before, axis=-1)
    names = clip.skeleton.names

    def mean(ending: str) -> float | None:
        own = [k for k, name in enumerate(names) if name.endswith(ending)]
        return float(moved[:, own].mean()) if own else None

    peak, joint = np.unravel_index(int(turned.argmax()), turned.shape) if turned.size else (0, 0)
    return Preparation(
        joints_deg=float(np.sqrt(np.mean(turned**2))) if turned.size else 0.0,
        joint_peak_deg=float(turned.max(initial=0.0)),
        joint_peak=names[min(int(joint) + 1, len(names) - 1)].replace("_", " "),
        joint_peak_s=float(peak) / clip.rate,
        pelvis_mm=float(moved[:, 0].mean()),
        pelvis_peak_mm=float(moved[:, 0].max()),
        feet_mm=mean("_ankle"),
        hands_mm=mean("_wrist"),
        stances=_stances(take, clip, body),
    )


def _stances(take: Take, clip: Any, body: Any) -> dict[str, int]:
    """How often each foot comes to rest on the ground."""
    ground, found = take.scene.ground, {}
    for side in ("left", "right"):
        paths = sole_paths(clip, body, side=side)
        if ground is None or not paths.shape[1]:
            continue
        low = paths[..., 2] - ground.height(paths) < _LOW
        slow = np.linalg.norm(derivative(paths, clip.rate, smoothing=0.075), axis=-1) < _SLOW
        stands = np.concatenate(([False], (low & slow).any(axis=1), [False]))
        edges = np.flatnonzero(np.diff(stands.astype(int)))
        found[side] = int(np.sum(edges[1::2] - edges[::2] >= _LASTS * clip.rate))
    return found
