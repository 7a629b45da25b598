"""The force that contact-consistent inverse dynamics leaves over, as a score of a clip.

The reference's accelerations take a force and a torque on the whole body. Points of the body near
the ground may push, within the friction pyramid; what they cannot give would have to come from
above. Its root mean square in % of body weight is the score: a clip that scores 0 can be performed
with nothing holding the body up, as far as the ground is concerned.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter1d

from understudy.character import Character
from understudy.character.athlete import IN_MOTION
from understudy.control import Tracking
from understudy.control.feedforward import REACH, required
from understudy.errors import InvalidValue
from understudy.feasibility.reasons import Moment, Residual, moments
from understudy.motion import rotations as rot
from understudy.motion.figure import plain_name
from understudy.motion.rotations import Array
from understudy.performance import Performance

# Window of the derivatives [s]: what is faster a servo does not follow either.
SMOOTHING = 0.125
# Of 36 captured clips that a sampling search tried to perform without help, it did all 26 that
# scored up to SURE, three of four up to LIKELY, and one of six above.
SURE, LIKELY = 7.0, 20.0
NEEDS_HELP, TOO_SHORT = "will need help from above", "too short to tell"
# Accelerations of less than this [s] are those of the filter they are taken with.
SHORTEST = 0.15
# Strength is asked for through this time [s]. Of 40 clips none that came out free asks for more
# than 1.2 of a person's; wrists that bear a cartwheel, for 4.5.
LASTS, TOO_MUCH = 0.1, 1.5
# A peak this far above the score [% of body weight] is worth a word.
WORTH = 20.0


class Strain(NamedTuple):
    """The joint that is asked for most.

    Attributes:
        joint: Its name.
        share: Of a person's strength in motion, as the limits of a free body have it.
        time: When [s].
    """

    joint: str
    share: float
    time: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Feasibility:
    """What a motion needs that the ground cannot give.

    Attributes:
        times: Time of each frame [s], shape (frames,).
        force: Force at the pelvis that no contact explains [% of body weight], world axes, shape
            (frames, 3).
        torque: The same for torque [% of body weight x height], pelvis axes, shape (frames, 3).
        ground: Upward force the ground bears [% of body weight], shape (frames,).
        moments: Stretches with much of it, the most telling first.
        strain: Where most of a person's strength is needed, a mean over 0.1 s, if the ground gives
            what it can; None for a body of unknown strength.
    """

    times: Array = field(repr=False)
    force: Array = field(repr=False)
    torque: Array = field(repr=False)
    ground: Array = field(repr=False)
    moments: tuple[Moment, ...] = ()
    strain: Strain | None = None

    @property
    def sizes(self) -> Array:
        """Length of the force over time [% of body weight], shape (frames,)."""
        return np.linalg.norm(self.force, axis=1)

    @property
    def score(self) -> float:
        """Root mean square of the force [% of body weight]."""
        return float(np.sqrt(np.mean(self.sizes**2)))

    @property
    def peak(self) -> float:
        """Its largest length [% of body weight]."""
        return float(self.sizes.max())

    @property
    def peak_time(self) -> float:
        """When [s]."""
        return float(self.times[int(self.sizes.argmax())])

    @property
    def outlook(self) -> str:
        """What the score promises, in a few words."""
        if self.times[-1] - self.times[0] < SHORTEST - 1e-9:
            return TOO_SHORT
        if self.strain is not None and self.strain.share > TOO_MUCH:
            return NEEDS_HELP
        if round(self.score) <= SURE:
            return "will stand free"
        if round(self.score) <= LIKELY:
            return "may stand free"
        return NEEDS_HELP

    def __str__(self) -> str:
        said = f"{self.score:.0f} %: {self.outlook}"
        if self.outlook == TOO_SHORT:
            return f"{said}; it takes {SHORTEST:g} s."
        if self.strain is not None and self.strain.share > TOO_MUCH:
            said += (
                f"; the {plain_name(self.strain.joint)} takes {self.strain.share:.1f} times a "
                f"person's strength at {self.strain.time:.1f} s"
            )
        at = self.peak_time
        worst = next((m for m in self.moments if m.start <= at <= m.end), None)
        if worst is None:
            return said + "."
        leans = worst.cause in ("floor", "support")
        if not leans and self.peak < max(WORTH, 1.5 * self.score):
            return said + "."
        return f"{said}; the peak of {self.peak:.0f} % at {at:.1f} s {worst.looks}."

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "score_percent": self.score,
            "peak_percent": self.peak,
            "peak_s": self.peak_time,
            "torque_percent": float(np.sqrt(np.mean(np.sum(self.torque**2, axis=1)))),
            "strain_percent": None if self.strain is None else 100.0 * self.strain.share,
            "strain_joint": None if self.strain is None else self.strain.joint,
            "strain_s": None if self.strain is None else self.strain.time,
            "outlook": self.outlook,
            "statement": str(self),
            "moments": [moment.as_dict() for moment in self.moments],
        }


def assess(performance: Performance, *, character: int = 0) -> Feasibility:
    """How far contact with the ground explains the motion that a character is to track.

    About 0.1 ms a frame; nothing is simulated.

    Args:
        performance: As `tracked` gives.
        character: Which of the scene's characters.

    Raises:
        InvalidValue: No clip is tracked by that character, or there is no ground.
    """
    scene = performance.scene
    tracking = next(
        (
            controller
            for controller in performance.controllers
            if isinstance(controller, Tracking) and controller.character == character
        ),
        None,
    )
    if tracking is None:
        raise InvalidValue(
            f"Character {character} tracks no clip; feasibility is judged of a performance that "
            "tracked() gives."
        )
    if scene.ground is None:
        raise InvalidValue("There is no ground in this scene, so none can bear the motion.")
    clip, body = tracking.reference, scene.characters[character]
    need = required(
        scene, scene.model, character, clip, contact=True, reach=REACH, smoothing=SMOOTHING
    )
    weight, height = body.simulated_mass * scene.gravity, body.height
    turned = rot.rotate(clip.rotations[:, 0], need.root[:, 3:])
    residual = Residual(
        clip=clip,
        character=body,
        floor=None if scene.ground.level else scene.ground,
        force=need.root[:, :3],
        torque=turned,
        weight=weight,
    )
    return Feasibility(
        times=clip.times,
        force=100.0 * residual.force / weight,
        torque=100.0 * need.root[:, 3:] / (weight * height),
        ground=100.0 * need.ground / weight,
        moments=moments(residual),
        strain=_strain(need.joints, body, clip.rate),
    )


def _strain(torques: Array, body: Character, rate: float) -> Strain | None:
    """The largest share of a joint's strength, by torques (frames, links - 1, 3) [N m]."""
    shares: dict[str, Array] = {}
    for k, link in enumerate(body.links[1:]):
        if link.torque_limit is not None:
            limit = float(np.max(link.torque_limit))
            limit *= IN_MOTION.get((link.role or "").partition("_")[2], 1.0)
            size = np.linalg.norm(torques[:, k], axis=1) / limit
            shares[link.joint] = uniform_filter1d(size, max(1, round(LASTS * rate)))
    if not shares:
        return None
    joint = max(shares, key=lambda name: float(shares[name].max()))
    return Strain(joint, float(shares[joint].max()), float(shares[joint].argmax()) / rate)
