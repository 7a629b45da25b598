"""Why a motion needs what the ground cannot give: read from the motion itself.

Each stretch with much unexplained force is tried on the parts of the body: would one force through
a hand, the seat, a foot explain force and torque there? A part that does, and rests, leans on
something the scene lacks. Glitches and cut ends of a capture are told first, because they explain
themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.ndimage import binary_closing, find_objects, label

from understudy.character.body import Character
from understudy.character.soles import Floor, sole_paths
from understudy.control.reference import sampled
from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.edits import derivative
from understudy.motion.figure import plain_name
from understudy.motion.rotations import Array

# A stretch counts where the force exceeds this [% of body weight], and half of its peak or the root
# mean square of all.
LEAST = 10.0
APART = 0.1  # Stretches less than this apart are one [s].
MOST = 3
# Captured motion that bodies performed turns no joint faster than 27 rad/s; glitches 71 and 72.
GLITCH = 45.0
END = 0.15  # A stretch that ends this soon after the start, or begins as late [s].
RESTS = 0.35  # A part that leans on something moves slower than this [m/s].
EXPLAINS = 0.6  # And a force through it explains this share of what is missing.
LASTS = 0.1  # It takes this long to lean [s].
OFF = 0.02  # Soles this high over the ground bear nothing [m].
HAND_LOW = 0.25  # A hand this low [m] while no foot is down is meant to be on the floor.
LEVER = 0.3  # A torque over this arm [m] counts as much as the force.
SMOOTHING = 0.125  # Window of velocities [s].


@dataclass(frozen=True, kw_only=True)
class Moment:
    """A stretch in which the ground explains too little.

    Attributes:
        start: [s].
        end: [s].
        peak: Largest unexplained force in it [% of body weight].
        cause: "glitch", "end", "support", "floor", "flight" or "timing".
        part: The part of the body concerned, such as "left hand"; empty where there is none.
        looks: What it looks like, as the end of a sentence: "looks like a hand on ...".
        advice: What to do about it, one sentence.
    """

    start: float
    end: float
    peak: float
    cause: str
    part: str = ""
    looks: str
    advice: str

    def __str__(self) -> str:
        return (
            f"{self.start:.2f} to {self.end:.2f} s, up to {self.peak:.0f} %: {self.looks}. "
            f"{self.advice}"
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "start_s": self.start,
            "end_s": self.end,
            "peak_percent": self.peak,
            "cause": self.cause,
            "part": self.part,
            "looks": self.looks,
            "advice": self.advice,
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Residual:
    """What is left unexplained, with the motion that it is left over from.

    Attributes:
        clip: The reference, on the character's skeleton.
        character: The body.
        floor: What lies under it; None is z = 0.
        force: [N], world, shape (frames, 3).
        torque: About the pelvis' origin [N m], world, shape (frames, 3).
        weight: Body weight [N].
    """

    clip: Clip
    character: Character
    floor: Floor | None
    force: Array = field(repr=False)
    torque: Array = field(repr=False)
    weight: float

    @property
    def sizes(self) -> Array:
        """Length of the force [% of body weight], shape (frames,)."""
        return 100.0 * np.linalg.norm(self.force, axis=1) / self.weight


def moments(residual: Residual) -> tuple[Moment, ...]:
    """Stretches with much unexplained force, each with what it looks like, largest first."""
    sizes, rate = residual.sizes, residual.clip.rate
    usual = min(float(np.sqrt(np.mean(sizes**2))), 0.5 * float(sizes.max()))
    high = sizes > max(LEAST, usual)
    gap = max(1, round(APART * rate))
    padded: Any = binary_closing(np.pad(high, gap), np.ones(gap, bool))
    labeled: Any = label(padded[gap:-gap] | high)
    spans = [found[0] for found in find_objects(labeled[0])]
    spans.sort(key=lambda span: -float(np.sum(sizes[span] ** 2)))
    seen = _Seen(residual)
    return tuple(seen.moment(span) for span in spans[:MOST])


class _Seen:
    """The motion as the tests of a cause look at it."""

    def __init__(self, residual: Residual):
        clip, character = residual.clip, residual.character
        self.residual, self.rate = residual, clip.rate
        pose = clip.forward_kinematics()
        self.places: dict[str, Array] = {}
        self.soles: dict[str, Array] = {}
        for k, link in enumerate(character.links):
            name, inside = called(link.role)
            if not name:
                continue
            place = pose.positions[:, k]
            if inside:
                place = place + rot.rotate(pose.rotations[:, k], link.com)
            self.places[name] = place
            if name.endswith("foot"):
                paths = sole_paths(clip, character, side=name.split()[0])
                under = 0.0 if residual.floor is None else residual.floor.height(paths)
                self.soles[name] = (paths[..., 2] - under).min(axis=1, initial=np.inf)
        self.speeds = {
            name: np.linalg.norm(derivative(place, clip.rate, smoothing=SMOOTHING), axis=1)
            for name, place in self.places.items()
        }
        self.hips = pose.positions[:, 0]
        turning = np.linalg.norm(sampled(clip, clip.times).rates, axis=-1)
        self.turning = {
            link.joint: turning[:, k]
            for k, link in enumerate(character.links)
            if k and (link.role is None or _kind(link.role) not in _LIGHT)
        }

    def moment(self, span: slice) -> Moment:
        """What a stretch of frames looks like."""
        peak = float(self.residual.sizes[span].max())
        for test in (self._glitch, self._end, self._raised, self._support, self._flight):
            found = test(span)
            if found is not None:
                break
        else:
            found = {
                "cause": "timing",
                "looks": "looks like a push before the feet are down or after they have left",
                "advice": "Nothing is missing in the scene; if the body needs help, it is there.",
            }
        first, last = span.start / self.rate, (span.stop - 1) / self.rate
        return Moment(start=first, end=last, peak=peak, **found)

    def _glitch(self, span: slice) -> dict[str, str] | None:
        margin = round(0.1 * self.rate)
        around = slice(max(0, span.start - margin), span.stop + margin)
        fastest = {name: float(rates[around].max()) for name, rates in self.turning.items()}
        joint = max(fastest, key=lambda name: fastest[name], default="")
        if not joint or fastest[joint] < GLITCH:
            return None
        when = (around.start + int(self.turning[joint][around].argmax())) / self.rate
        name = plain_name(joint)
        return {
            "cause": "glitch",
            "part": name,
            "looks": f"looks like a glitch of the capture: the {name} turns at "
            f"{fastest[joint]:.0f} rad/s",
            "advice": f"Cut the clip around {when:.2f} s, or repair the {name} there.",
        }

    def _end(self, span: slice) -> dict[str, str] | None:
        first = span.stop <= END * self.rate
        if not first and span.start < self.residual.clip.frames - END * self.rate:
            return None
        which = "start" if first else "end"
        return {
            "cause": "end",
            "looks": f"is at the very {which} of the clip, where accelerations are guessed",
            "advice": f"Cut 0.1 s off the {which}.",
        }

    def _raised(self, span: slice) -> dict[str, str] | None:
        """A foot that rests above the floor."""
        for name in sorted(self.soles, key=lambda name: self._speed(name, span)):
            height = float(np.median(self.soles[name][span]))
            if height < OFF or self._speed(name, span) > RESTS or self._airy(span) < 0.5:
                continue
            return {
                "cause": "floor",
                "part": name,
                "looks": f"looks like the {name} on something {100 * height:.0f} cm high that is "
                "not in the scene",
                "advice": f"Put it there: top at {height:.2f} m over the floor, "
                f"{self._where(name, span)}.",
            }
        return None

    def _support(self, span: slice) -> dict[str, str] | None:
        """The resting part through which one force explains most of what is missing."""
        hands = [name for name in self.places if name.endswith("hand")]
        low = [name for name in hands if self.places[name][span, 2].min() < HAND_LOW]
        if low and self._airy(span) > 0.5:
            name = min(low, key=lambda name: self._speed(name, span))
            lowest = float(self.places[name][span, 2].min())
            if self._speed(name, span) < 3.0 * RESTS:
                return {
                    "cause": "support",
                    "part": name,
                    "looks": f"looks like the hands on the floor, {100 * lowest:.0f} cm above it",
                    "advice": "Check the height of the floor at the time.",
                }
        if span.stop - span.start < LASTS * self.rate:
            return None
        shares = {
            name: self._share(name, span)
            for name in self.places
            if self._speed(name, span) < RESTS and not name.endswith("foot")
        }
        name = max(shares, key=lambda name: shares[name], default="")
        if not name or shares[name] < EXPLAINS:
            return None
        seat = "a seat" if name == "pelvis" else "something"
        return {
            "cause": "support",
            "part": name,
            "looks": f"looks like the {name} on {seat} that is not in the scene",
            "advice": f"Put it there: {self._where(name, span)}, "
            f"z {float(np.median(self.places[name][span, 2])):.2f} m.",
        }

    def _flight(self, span: slice) -> dict[str, str] | None:
        if self._airy(span) < 0.8:
            return None
        lack = self.residual.force[span, 2].mean() / self.residual.weight
        if abs(lack) < 0.3:
            return None
        fall = 9.8 * (1.0 - lack)
        return {
            "cause": "flight",
            "looks": f"is in the air, yet falls with {fall:.0f} m/s2 instead of 9.8",
            "advice": "Check where the floor is, and the rate of the file (--rate).",
        }

    def _airy(self, span: slice) -> float:
        """Share of a stretch in which no sole is on the floor."""
        soles = list(self.soles.values())
        return float((np.min(soles, axis=0)[span] > OFF).mean()) if soles else 0.0

    def _speed(self, name: str, span: slice) -> float:
        """Speed of a part where most force is missing [m/s]."""
        return float(np.average(self.speeds[name][span], weights=self.residual.sizes[span] ** 2))

    def _where(self, name: str, span: slice) -> str:
        x, y = np.median(self.places[name][span, :2], axis=0)
        return f"x {x:.2f}, y {y:.2f}"

    def _share(self, name: str, span: slice) -> float:
        """How much of force and torque one force through a part explains, 0 to 1."""
        force, torque = self.residual.force[span], self.residual.torque[span] / LEVER
        arm = (self.places[name] - self.hips)[span] / LEVER
        cross = np.cross(arm[:, None], np.eye(3)).swapaxes(1, 2)
        system = np.concatenate((np.broadcast_to(np.eye(3), cross.shape), cross), axis=1)
        wanted = np.concatenate((force, torque), axis=1)[..., None]
        square = system.swapaxes(1, 2) @ system
        given = np.linalg.solve(square, system.swapaxes(1, 2) @ wanted)
        left = float(np.sum((system @ given - wanted) ** 2))
        return 1.0 - left / max(float(np.sum(wanted**2)), 1e-12)


def called(role: str | None) -> tuple[str, bool]:
    """What the part of a role is called, and whether it leans on its center of mass."""
    side, _, kind = (role or "").rpartition("_")
    side = side if side in ("left", "right") else ""
    kind = kind if side else (role or "")
    name, inside = _PARTS.get(kind, ("", False))
    return f"{side} {name}".strip() if name else "", inside


def _kind(role: str) -> str:
    return role.removeprefix("left_").removeprefix("right_")


# Roles whose links may lean on things, and whether at their center of mass or at their joint.
_PARTS = {
    "pelvis": ("pelvis", True),
    "upper_back": ("back", True),
    "elbow": ("elbow", False),
    "wrist": ("hand", True),
    "knee": ("knee", False),
    "ankle": ("foot", True),
}
# Links too light for a glitch of theirs to show in the force on the body.
_LIGHT = ("ball", "wrist", "neck")
