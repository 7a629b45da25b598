"""One member of a family: varied, simulated, scored and written."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from understudy.character import Character
from understudy.character.retarget import restored
from understudy.errors import Diverged, UnderstudyError
from understudy.evaluate.certificate import certificate
from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.score import Score, score
from understudy.family import bodies
from understudy.family import cost as costs
from understudy.family.bodies import APART_MM, linkage_of
from understudy.family.casting import POSE_RATE, Part
from understudy.motion.bvh_writer import write_bvh
from understudy.motion.clip import Clip
from understudy.motion.files import written
from understudy.motion.rotations import Array
from understudy.output.gltf import write_glb
from understudy.performance import Performance
from understudy.simulate import simulate
from understudy.take import Take
from understudy.variations import Mass

# A member left the floor when nothing touches it for this much longer than unvaried [s].
_FLIGHT = 0.3
# A member is held up when the outside force on its pelvis exceeds this mean [% of body weight].
_HELD = 50.0
# A joint is below the floor at this depth [m]; a trunk is folded at this angle [deg] and time [s].
_SUNK, _FOLDED, _FOLDED_S = 0.05, 45.0, 0.5
FLAGS = {
    "diverged": "the simulation blew up and is kept up to then",
    "fell": "the root is 0.2 m below or 45 degrees off its part",
    "fell apart": f"the parts of a joint came {APART_MM:g} mm from each other",
    "left the floor": f"nothing touched the body for {_FLIGHT:g} s longer than unvaried",
    "below the floor": f"a joint was more than {1e3 * _SUNK:.0f} mm below the floor",
    "trunk folded": f"chest or head was more than {_FOLDED:.0f} degrees off the unvaried one for "
    f"{_FOLDED_S:g} s",
    "held up": f"the outside force on the pelvis exceeds {_HELD:.0f} % of body weight on average",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Member:
    """What became of one member; everything but the poses goes through JSON.

    Attributes:
        index: From 0; -1 for the unvaried performance.
        name: Stem of its files.
        kind: The preset it took, or "varied".
        says: What was changed, one phrase each.
        variation: The same as plain values.
        flags: Keys of `FLAGS` that apply.
        away_mm: Mean distance of joints from the unvaried performance [mm], worst moment aside.
        cost: Per joint, see `understudy.family.cost`.
        total: Sums of it.
        certificate: See `understudy.evaluate.certificate`; without computing times.
        duration: Simulated time [s].
        notes: What a reader of the figures should know, a sentence each.
        poses: Points of the body at `POSE_RATE` [m], world, shape (frames, points, 3), float32.
    """

    index: int
    name: str
    kind: str
    says: tuple[str, ...]
    variation: dict[str, Any] = field(repr=False)
    flags: tuple[str, ...]
    away_mm: float
    cost: dict[str, dict[str, float]] = field(repr=False)
    total: dict[str, Any] = field(repr=False)
    certificate: dict[str, Any] = field(repr=False)
    duration: float
    notes: tuple[str, ...] = ()
    poses: Any = field(repr=False)

    def as_dict(self) -> dict[str, Any]:
        """Plain values, without the poses."""
        return {
            "kind": "understudy family member",
            "index": self.index,
            "name": self.name,
            "preset": self.kind,
            "says": list(self.says),
            "flags": list(self.flags),
            "notes": list(self.notes),
            "away_mm": self.away_mm,
            "duration_s": self.duration,
            "total": self.total,
            "cost": self.cost,
            "variation": self.variation,
            "certificate": self.certificate,
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Unvaried:
    """The performance all members are compared with.

    Attributes:
        performance: As given, at the family's grip.
        take: Its take.
    """

    performance: Performance
    take: Take = field(repr=False)

    @cached_property
    def measures(self) -> Measured:
        """Forces and contacts at the rate of the comparison."""
        return measured(self.take, rate=costs.RATE)

    @cached_property
    def effort(self) -> costs.Effort:
        """Forces and torques."""
        if linkage_of(self.take) is not None:
            return bodies.drive_effort(self.take, self.performance.duration)
        return costs.effort(self.take, self.performance.duration, self.measures)

    @cached_property
    def flight(self) -> float:
        """Longest time without contact [s]."""
        return longest_flight(self.measures)

    @cached_property
    def poses(self) -> Array:
        """Points of the body at `POSE_RATE` [m]."""
        return poses_of(self.take)

    @cached_property
    def repaired(self) -> Clip | None:
        """The captured clip as the performance took it."""
        captured = self.take.captured[0]
        return None if captured is None else captured.repaired()

    def ready(self) -> None:
        """Work out everything members share, so that threads find it done."""
        _ = self.effort, self.poses
        if linkage_of(self.take) is None:
            _ = self.flight, self.repaired


def performed(part: Part, unvaried: Unvaried, performance: Performance) -> tuple[Member, Take]:
    """Vary, simulate and score one member."""
    varied = part.variation(performance)
    if part.index < 0:
        take = unvaried.take
    else:
        try:
            take = simulate(varied)
        except Diverged as error:
            if error.take is None:
                raise
            take = error.take
    if linkage_of(take) is not None:
        error = bodies.error_of(take)
        after = bodies.drive_effort(take, varied.duration)
        flags, found = bodies.drive_flags(take, error), bodies.drive_certificate(take, error)
    else:
        m = unvaried.measures if part.index < 0 else measured(take, rate=costs.RATE)
        after = costs.effort(take, varied.duration, m)
        scores = score(take, measures=m)
        flags, found = flags_of(take, scores, m, unvaried), _timeless(take, scores, m)
    cost = costs.changed(unvaried.effort, after)
    poses, share = poses_of(take), take.duration / max(varied.duration, 1e-9)
    flags += pose_flags(take, poses, unvaried.poses, share)
    away = _away(poses, unvaried.poses, share)
    member = Member(
        index=part.index,
        name=part.name,
        kind=part.kind,
        says=tuple(str(p) for v in part.variation.parts for p in getattr(v, "parts", (v,))),
        variation=part.variation.as_dict(),
        flags=flags,
        away_mm=away,
        notes=notes_of(take, part, away),
        cost=cost,
        total=costs.total(cost),
        certificate=found,
        duration=take.duration,
        poses=poses,
    )
    return member, take


def flags_of(take: Take, found: Score, m: Measured, unvaried: Unvaried) -> tuple[str, ...]:
    """Which of `FLAGS` apply."""
    out = []
    if take.diverged is not None:
        out.append("diverged")
    if found.fell_s is not None:
        out.append("fell")
    if take.scene.ground is not None and longest_flight(m) > unvaried.flight + _FLIGHT:
        out.append("left the floor")
    if found.pelvis != "led" and found.root_force_mean_percent > _HELD:
        out.append("held up")
    return tuple(out)


def pose_flags(take: Take, poses: Array, unvaried: Array, share: float) -> tuple[str, ...]:
    """Flags that the poses of a character tell; a linkage knows neither floor nor trunk."""
    body = take.scene.characters[0]
    if not isinstance(body, Character):
        return ()
    out, joints = [], len(body.skeleton)
    if take.scene.ground is not None and poses[:, :joints, 2].min() < -_SUNK:
        out.append("below the floor")
    usual = unvaried[_matching(poses, unvaried, share)]
    for a, b in _trunk(body):
        now, before = poses[:, b] - poses[:, a], usual[:, b] - usual[:, a]
        lengths = np.linalg.norm(now, axis=1) * np.linalg.norm(before, axis=1)
        cosine = np.sum(now * before, axis=1) / np.maximum(lengths, 1e-9)
        off = (cosine < np.cos(np.radians(_FOLDED))) & (lengths > 1e-6)
        if off.sum() > _FOLDED_S * POSE_RATE:
            out.append("trunk folded")
            break
    return tuple(out)


def _trunk(body: Character) -> list[tuple[int, int]]:
    """Points of the poses between which chest and head lie, where the body has them."""
    roles = {link.role: i for i, link in enumerate(body.links) if link.role}
    ends = {j: len(body.skeleton) + k for k, j in enumerate(body.skeleton.end_joints)}
    if (neck := roles.get("neck")) is None:
        return []
    # From the pelvis: in some captures' skeletons the chest has no length of its own.
    out = [(roles["pelvis"], neck)]
    return out + [(neck, ends[neck])] * (neck in ends)


def notes_of(take: Take, part: Part, away: float) -> tuple[str, ...]:
    """Why a driven linkage of other masses moved as before."""
    changes = [p for v in part.variation.parts for p in getattr(v, "parts", (v,))]
    if linkage_of(take) is None or not any(isinstance(p, Mass) for p in changes):
        return ()
    still = round(away) == 0
    return ("The drive's force follows the body's mass: only the cost changes.",) * still


def longest_flight(m: Measured) -> float:
    """Longest time in which nothing touches the first character [s]."""
    touching = np.zeros(m.frames + 2, bool)
    touching[[0, -1]] = True
    touching[1 + m.contacts.frame[m.contacts.involving(m.performer(0).bodies)]] = True
    return float((np.diff(np.flatnonzero(touching)) - 1).max() / m.rate)


def poses_of(take: Take) -> Any:
    """Joints, then ends, of the first character at `POSE_RATE` [m], (frames, points, 3)."""
    if linkage_of(take) is not None:
        return bodies.joint_places(take, POSE_RATE)
    pose = take.clip(rate=POSE_RATE).forward_kinematics()
    return np.concatenate((pose.positions, pose.ends), axis=1).astype(np.float32)


def _away(poses: Array, unvaried: Array, share: float) -> float:
    apart = poses - unvaried[_matching(poses, unvaried, share)]
    return float(1e3 * np.linalg.norm(apart, axis=2).mean())


def _matching(poses: Array, unvaried: Array, share: float) -> Any:
    """The frame of the unvaried poses at the same share of the part, for every frame."""
    return np.linspace(0.0, min(share, 1.0) * (len(unvaried) - 1), len(poses)).round().astype(int)


def _timeless(take: Take, found: Score, m: Measured) -> dict[str, Any]:
    """The certificate without computing times, so that the same motion gives the same bytes."""
    out = certificate(take, scores=(replace(found, real_time_factor=None),), measures=m)
    out["facts"].pop("cpu_seconds", None)
    return out


# -- files ------------------------------------------------------------------------------------


def write_member(member: Member, take: Take, folder: Path, unvaried: Unvaried) -> None:
    """NAME.bvh, NAME.glb, NAME.poses.npz and, last, NAME.json."""
    body, motion = take.scene.characters[0], take.clip()
    stem = folder / member.name
    captured = take.captured[0]
    source = unvaried.repaired if isinstance(body, Character) else None
    if source is not None and captured is not None and captured is not unvaried.take.captured[0]:
        source = captured.repaired()
    if isinstance(body, Character) and source is not None and source.skeleton == body.source:
        write_bvh(restored(motion, source, body), f"{stem}.bvh")
    else:
        write_bvh(motion, f"{stem}.bvh")
    write_glb(motion, f"{stem}.glb", character=body)
    with written(f"{stem}.poses.npz") as temporary:
        np.savez(temporary, poses=member.poses)
    text = json.dumps(member.as_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    with written(f"{stem}.json") as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def kept_member(part: Part, folder: Path) -> Member | None:
    """A member finished before, or None; one whose files are damaged is made again."""
    stem = folder / part.name
    if not all(Path(f"{stem}{kind}").exists() for kind in (".bvh", ".glb")):
        return None
    try:
        saved = json.loads(Path(f"{stem}.json").read_text(encoding="utf-8"))
        with np.load(f"{stem}.poses.npz", allow_pickle=False) as arrays:
            poses = arrays["poses"]
        if saved["variation"] != json.loads(json.dumps(part.variation.as_dict())):
            return None
        return Member(
            index=saved["index"],
            name=saved["name"],
            kind=saved["preset"],
            says=tuple(saved["says"]),
            variation=saved["variation"],
            flags=tuple(saved["flags"]),
            notes=tuple(saved.get("notes", ())),
            away_mm=saved["away_mm"],
            cost=saved["cost"],
            total=saved["total"],
            certificate=saved["certificate"],
            duration=saved["duration_s"],
            poses=poses,
        )
    except (OSError, ValueError, KeyError, TypeError, EOFError, UnderstudyError):
        return None


def packed(poses: Array, origin: Array) -> str:
    """Poses as 16-bit millimeters from `origin`, base64."""
    whole = np.round(1e3 * (np.asarray(poses, float) - origin))
    return base64.b64encode(np.clip(whole, -32767, 32767).astype("<i2").tobytes()).decode("ascii")
