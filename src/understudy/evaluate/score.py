"""One take, one set of numbers: how well it tracks and how physical it is."""

from __future__ import annotations

import platform
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.character import Linkage, retargeted
from understudy.errors import InvalidValue, shown
from understudy.evaluate import compare, feet, physics
from understudy.evaluate.force_plate import as_by_plate
from understudy.evaluate.measure import Measured, Performer, measured
from understudy.motion.clip import Clip

if TYPE_CHECKING:
    from understudy.take import Take

FALLEN_DROP, FALLEN_ANGLE = 0.2, np.radians(45.0)
"""A body whose root is this much lower [m] or turned by this much from the clip's has fallen."""
HELD = 0.5
"""A root force below this share of body weight, on average and at its peak, counts as none [%]."""
FAR_OFF = 45.0
"""A joint this far from the clip's [deg] is named: something was in its way."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """How well one character of a take tracks its clip, and how physical its motion is.

    Numbers that do not exist (no clip was tracked, no foot ever stood) are None. Definitions and
    formulas are in docs/evaluation.md.

    Attributes:
        character: Name of the character.
        clip: Name of the tracked clip.
        duration_s: Simulated time [s].
        frame_rate_hz: Measured frames per second [Hz].
        diverged_s: When the simulation blew up [s].
        joint_error_deg: Root mean square over joints (not the root) and time [deg].
        joint_error_median_deg: Median over joints and time [deg].
        joint_errors_deg: Root mean square over time, per joint [deg].
        joint_error_peak_deg: Largest angle of any joint at any time [deg].
        joint_error_peak_joint: Where it occurred.
        joint_error_peak_s: When it occurred [s].
        joint_position_mm: Mean distance of joints from the reference's, world [mm].
        joint_position_aligned_mm: The same seen from each motion's own root [mm].
        hands_mm: Mean distance of the hands' ends [mm].
        feet_mm: Mean distance of ankles and balls of the feet [mm].
        root_position_mm: Mean distance of the root [mm].
        root_rotation_deg: Root mean square angle of the root [deg].
        fell_s: When the body fell: its root more than 0.2 m below or 45 degrees off the clip's [s].
        lag_ms: How late the joints are [ms].
        joint_error_as_read_deg: Joint error against the clip as it was read, before glitches were
            repaired and feet planted [deg].
        feet_as_read_mm: Mean distance of ankles and balls of the feet from the clip as read, one
            constant difference of height left out [mm].
        joint_error_without_lag_deg: Joint error after shifting the reference by the lag [deg].
        joint_position_without_lag_mm: Joint position error after that shift [mm].
        pelvis: "led", "assisted", "free" or "unknown": what holds the root.
        root_force_mean_percent: Mean outside force on the root [% of body weight].
        root_force_peak_percent: Its peak [% of body weight].
        root_support_percent: Mean of its vertical part, up positive [% of body weight].
        root_torque_mean_percent: Mean outside torque on the root [% of body weight x height].
        root_torque_peak_percent: Its peak [% of body weight x height].
        foot_slide_mm_s: Mean speed of loaded feet along the ground [mm/s].
        foot_slide_by_height_mm_s: The same with the rule that fits clips: low and slow [mm/s].
        clip_foot_slide_mm_s: That rule on the tracked clip [mm/s].
        penetration_mm: Deepest overlap of any contact of the character [mm].
        penetration_mean_mm: Mean overlap of its contact points while they overlap [mm].
        clip_penetration_mm: How far below the ground the tracked clip puts its soles [mm].
        ground_force_mean_percent: Mean upward ground force [% of body weight].
        ground_force_peak_percent: Its peak, low-pass filtered as a force plate's is read
            (`understudy.evaluate.force_plate`) [% of body weight].
        ground_force_spike_percent: Its largest value at any one step, unfiltered
            [% of body weight].
        torque_peak_nm: Largest joint torque [N m].
        torque_peak_joint: Where it occurred.
        torque_mean_nm: Mean of all joints over time [N m].
        torque_peaks_nm: Peak per joint [N m].
        torque_means_nm: Mean per joint [N m].
        strength_percent: Peak torque about any axis over the human limit there, per joint [%].
        power_peak_w: Largest sum of joint powers [W].
        power_mean_w: Mean of the sum of absolute joint powers [W].
        energy_drift_percent: Energy not accounted for in flight [% of the energy in play].
        flight_s: Time without any contact [s]; None without ground.
        real_time_factor: Simulated time over computing time, when known.
        seed: Seed of the performance.
        versions: Of understudy, mujoco, numpy and python.
    """

    character: str
    clip: str | None = None
    duration_s: float
    frame_rate_hz: float
    diverged_s: float | None = None
    joint_error_deg: float | None = None
    joint_error_median_deg: float | None = None
    joint_errors_deg: dict[str, float] = field(default_factory=dict, repr=False)
    joint_error_peak_deg: float | None = None
    joint_error_peak_joint: str | None = None
    joint_error_peak_s: float | None = None
    joint_position_mm: float | None = None
    joint_position_aligned_mm: float | None = None
    hands_mm: float | None = None
    feet_mm: float | None = None
    root_position_mm: float | None = None
    root_rotation_deg: float | None = None
    fell_s: float | None = None
    lag_ms: float | None = None
    joint_error_as_read_deg: float | None = None
    feet_as_read_mm: float | None = None
    joint_error_without_lag_deg: float | None = None
    joint_position_without_lag_mm: float | None = None
    pelvis: str = "unknown"
    root_force_mean_percent: float = 0.0
    root_force_peak_percent: float = 0.0
    root_support_percent: float = 0.0
    root_torque_mean_percent: float = 0.0
    root_torque_peak_percent: float = 0.0
    foot_slide_mm_s: float | None = None
    foot_slide_by_height_mm_s: float | None = None
    clip_foot_slide_mm_s: float | None = None
    penetration_mm: float = 0.0
    penetration_mean_mm: float = 0.0
    clip_penetration_mm: float | None = None
    ground_force_mean_percent: float | None = None
    ground_force_peak_percent: float | None = None
    ground_force_spike_percent: float | None = None
    torque_peak_nm: float = 0.0
    torque_peak_joint: str | None = None
    torque_mean_nm: float = 0.0
    torque_peaks_nm: dict[str, float] = field(default_factory=dict, repr=False)
    torque_means_nm: dict[str, float] = field(default_factory=dict, repr=False)
    strength_percent: dict[str, float] = field(default_factory=dict, repr=False)
    power_peak_w: float = 0.0
    power_mean_w: float = 0.0
    energy_drift_percent: float | None = None
    flight_s: float | None = None
    real_time_factor: float | None = None
    seed: int = 0
    versions: dict[str, str] = field(default_factory=dict, repr=False)

    @property
    def fully_physical(self) -> bool:
        """True when nothing but contact holds the body: no root force above rounding."""
        return self.root_force_peak_percent < HELD and self.root_torque_peak_percent < HELD

    def as_dict(self) -> dict[str, Any]:
        """Every number under its name; plain values that JSON takes, in a fixed order."""
        return asdict(self)

    def __str__(self) -> str:
        return _table(self)


def score(take: Take, *, character: int = 0, measures: Measured | None = None) -> Score:
    """Score one character of a take.

    Args:
        take: The take.
        character: Which of the scene's characters.
        measures: What `measured(take)` gave, to save doing it again.

    Raises:
        InvalidValue: The scene has no such character, or the take has no frames.
    """
    if not hasattr(take, "qpos"):
        raise InvalidValue(f"take is {shown(take)}; it must be a Take, as `track` gives.")
    if any(isinstance(performer, Linkage) for performer in take.scene.characters):
        raise InvalidValue(
            "Scores are of characters; `understudy.fidelity.drive_error` measures a driven linkage."
        )
    m = measured(take) if measures is None else measures
    who = m.performer(character)
    reference = take.references[character]
    seconds = take.facts.get("cpu_seconds")
    return Score(
        character=who.character.name,
        clip=None if reference is None else reference.name,
        duration_s=take.duration,
        frame_rate_hz=m.rate,
        diverged_s=take.diverged,
        seed=take.seed,
        versions=versions(),
        real_time_factor=take.duration / seconds if seconds else None,
        **_tracking(take, m, who),
        **_root(take, m, who),
        **_contact(take, m, who),
        **_effort(m, who),
    )


def motion(take: Take, m: Measured, character: int = 0) -> Clip:
    """The simulated motion at the measured frames, on the character's skeleton."""
    who = m.performer(character)
    state = take.qpos[m.steps][:, who.coordinates]
    return Clip(
        skeleton=who.character.skeleton,
        rotations=who.character.local_rotations(state),
        root_positions=state[:, :3],
        rate=m.rate,
    )


def _tracking(take: Take, m: Measured, who: Performer) -> dict[str, Any]:
    reference = take.references[who.index]
    if reference is None:
        return {}
    simulated = motion(take, m, who.index)
    found = compare.compared(simulated, reference)
    angles = np.degrees(found.joint_angles)
    skeleton = simulated.skeleton
    out: dict[str, Any] = {
        "joint_position_mm": 1e3 * _mean(found.distances),
        "joint_position_aligned_mm": 1e3 * _mean(found.aligned_distances),
        "root_position_mm": 1e3 * _mean(found.root_distances),
        "root_rotation_deg": _rms(np.degrees(found.root_angles)),
    }
    if angles.shape[1]:
        frame, worst = np.unravel_index(int(np.argmax(angles)), angles.shape)
        out |= {
            "joint_error_peak_deg": float(angles[frame, worst]),
            "joint_error_peak_joint": skeleton.names[1 + int(worst)],
            "joint_error_peak_s": float(found.times[frame]),
            "joint_error_deg": _rms(angles),
            "joint_error_median_deg": float(np.median(angles)),
            "joint_errors_deg": {
                name: _rms(angles[:, j]) for j, name in enumerate(skeleton.names[1:])
            },
        }
    fallen = (found.root_drops > FALLEN_DROP) | (found.root_angles > FALLEN_ANGLE)
    if fallen.any():
        out["fell_s"] = float(found.times[np.argmax(fallen)])
    roles = [link.role for link in who.character.links]
    hands = [i for i, j in enumerate(skeleton.end_joints) if (roles[j] or "").endswith("wrist")]
    soles = [i for i, role in enumerate(roles) if (role or "").endswith(("ankle", "ball"))]
    if hands:
        out["hands_mm"] = 1e3 * _mean(found.end_distances[:, hands])
    if soles:
        out["feet_mm"] = 1e3 * _mean(found.distances[:, soles])
    out |= _as_read(take, who, simulated, soles)
    late = compare.lag(simulated, reference)
    if late is not None:
        shifted = compare.compared(simulated, reference, lag=late)
        out |= {
            "lag_ms": 1e3 * late,
            "joint_error_without_lag_deg": _rms(np.degrees(shifted.joint_angles)),
            "joint_position_without_lag_mm": 1e3 * _mean(shifted.distances),
        }
    return out


def _as_read(take: Take, who: Performer, simulated: Clip, soles: list[int]) -> dict[str, Any]:
    """Errors against the clip as read, where the tracked clip is that one frame for frame."""
    captured, reference = take.captured[who.index], take.references[who.index]
    if captured is None or reference is None:
        return {}
    if (captured.frames, captured.rate) != (reference.frames, reference.rate):
        return {}
    read = retargeted(captured, who.character)
    height = float(np.median(reference.root_positions[:, 2] - read.root_positions[:, 2]))
    read = replace(read, root_positions=read.root_positions + np.array([0.0, 0.0, height]))
    found = compare.compared(simulated, read)
    out: dict[str, Any] = {}
    if found.joint_angles.shape[1]:
        out["joint_error_as_read_deg"] = _rms(np.degrees(found.joint_angles))
    if soles:
        out["feet_as_read_mm"] = 1e3 * _mean(found.distances[:, soles])
    return out


def _root(take: Take, m: Measured, who: Performer) -> dict[str, Any]:
    force = m.root_force(who.index) / who.weight * 100.0
    torque = m.root_torque(who.index) / (who.weight * who.height) * 100.0
    sizes, turns = np.linalg.norm(force, axis=1), np.linalg.norm(torque, axis=1)
    return {
        "pelvis": _pelvis(take, who, float(sizes.max())),
        "root_force_mean_percent": _mean(sizes),
        "root_force_peak_percent": float(sizes.max()),
        "root_support_percent": _mean(force[:, 2]),
        "root_torque_mean_percent": _mean(turns),
        "root_torque_peak_percent": float(turns.max()),
    }


def _pelvis(take: Take, who: Performer, peak: float) -> str:
    """What the controller says it does with the root, or what its servo's gains say."""
    for controller in () if take.performance is None else take.performance.controllers:
        said = getattr(controller, "pelvis", None)
        if isinstance(said, str) and getattr(controller, "character", None) == who.index:
            return said
    if len(take.scene.characters) == 1 and isinstance(take.facts.get("pelvis"), str):
        return take.facts["pelvis"]
    servos = list(take.scene.parts[who.index].root_actuators)
    held = bool(np.any(take.model.actuator_gainprm[servos, 0])) or peak >= HELD
    return "assisted" if held else "free"


def _contact(take: Take, m: Measured, who: Performer) -> dict[str, Any]:
    mine = m.contacts.involving(who.bodies)
    depth = m.contacts.depth[mine]
    overlaps = depth[depth > 0.0]
    out: dict[str, Any] = {}
    if len(overlaps):
        out |= {
            "penetration_mm": 1e3 * float(overlaps.max()),
            "penetration_mean_mm": 1e3 * _mean(overlaps),
        }
    if take.scene.ground is None:
        return out
    vertical = 100.0 * m.ground_reaction(who.index)[:, 2] / who.weight
    touching = np.zeros(m.frames, bool)
    touching[m.contacts.frame[mine]] = True
    out |= {
        "ground_force_mean_percent": _mean(vertical),
        "ground_force_peak_percent": float(as_by_plate(vertical, m.rate).max()),
        "ground_force_spike_percent": float(vertical.max()),
        "flight_s": float((~touching).sum() / m.rate),
    }
    # A character that never comes near the ground does not fly: it was hung up.
    if touching.any() or _pelvis(take, who, 0.0) == "free":
        out["energy_drift_percent"] = physics.energy_drift(take, m, who.index)
    if not feet.feet(who):
        return out
    loaded = feet.loaded_slide(m, who.index).speed
    ground = take.scene.ground
    lowly = feet.kinematic_slide(motion(take, m, who.index), who, take.model, ground=ground).speed
    out |= {
        "foot_slide_mm_s": _thousand(loaded),
        "foot_slide_by_height_mm_s": _thousand(lowly),
    }
    reference = take.references[who.index]
    if reference is not None:
        own = feet.kinematic_slide(reference, who, take.model, ground=ground)
        out["clip_foot_slide_mm_s"] = _thousand(own.speed)
        if np.isfinite(own.lowest).all():
            out["clip_penetration_mm"] = 1e3 * max(0.0, -float(own.lowest.min()))
    return out


def _effort(m: Measured, who: Performer) -> dict[str, Any]:
    vectors = m.joint_torques(who.index)
    if vectors.shape[1] == 0:
        return {}
    torque, power = np.linalg.norm(vectors, axis=2), m.joint_powers(who.index)
    peaks, total = torque.max(axis=0), power.sum(axis=1)
    names, links = who.joints[1:], who.character.links[1:]
    strength = {
        link.joint: float(
            100.0 * np.max(np.abs(vectors[:, j]) / np.maximum(np.asarray(link.torque_limit), 1e-9))
        )
        for j, link in enumerate(links)
        if link.torque_limit is not None
    }
    return {
        "torque_peak_nm": float(peaks.max()),
        "torque_peak_joint": names[int(np.argmax(peaks))],
        "torque_mean_nm": _mean(torque),
        "torque_peaks_nm": dict(zip(names, peaks.tolist(), strict=True)),
        "torque_means_nm": dict(zip(names, torque.mean(axis=0).tolist(), strict=True)),
        "strength_percent": strength,
        "power_peak_w": float(np.abs(total).max()),
        "power_mean_w": _mean(np.abs(power).sum(axis=1)),
    }


@cache
def _versions() -> tuple[tuple[str, str], ...]:
    found = []
    for name in ("understudy", "mujoco", "numpy"):
        try:
            found.append((name, version(name)))
        except PackageNotFoundError:
            found.append((name, "unknown"))
    return (*found, ("python", platform.python_version()))


def versions() -> dict[str, str]:
    """Versions of what a number depends on."""
    return dict(_versions())


def _mean(values: Any) -> float:
    return float(np.mean(values))


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _thousand(value: float | None) -> float | None:
    return None if value is None else 1e3 * value


def _table(s: Score) -> str:
    """A score for a terminal: one figure per line, what does not exist left out."""
    rows: list[tuple[str, str]] = []

    def row(label: str, text: str, *values: float | str | None) -> None:
        if all(value is not None for value in values):
            rows.append((label, text.format(*values)))

    row("fell", "at {:.2f} s", s.fell_s)
    row("joint error", "{:.2f} deg rms, {:.2f} median", s.joint_error_deg, s.joint_error_median_deg)
    if s.joint_error_peak_deg is not None and s.joint_error_peak_deg > FAR_OFF:
        row(
            "furthest joint",
            "{:.0f} deg, {} at {:.2f} s",
            s.joint_error_peak_deg,
            s.joint_error_peak_joint,
            s.joint_error_peak_s,
        )
    row(
        "joint position",
        "{:.1f} mm, {:.1f} seen from the root",
        s.joint_position_mm,
        s.joint_position_aligned_mm,
    )
    row("hands", "{:.1f} mm", s.hands_mm)
    row("feet", "{:.1f} mm", s.feet_mm)
    row("clip as read", "joints {:.2f} deg rms off it", s.joint_error_as_read_deg)
    row("", "feet {:.1f} mm off it", s.feet_as_read_mm)
    row("root", "{:.1f} mm, {:.2f} deg", s.root_position_mm, s.root_rotation_deg)
    row(
        "lag",
        "{:.1f} ms ({:.2f} deg without it)",
        s.lag_ms,
        s.joint_error_without_lag_deg,
    )
    row(
        f"pelvis {s.pelvis}",
        "force {:.1f} % of body weight (peak {:.0f}), support {:.1f} %",
        s.root_force_mean_percent,
        s.root_force_peak_percent,
        s.root_support_percent,
    )
    row(
        "root torque",
        "{:.1f} % of weight x height (peak {:.0f})",
        s.root_torque_mean_percent,
        s.root_torque_peak_percent,
    )
    row(
        "ground force",
        "{:.0f} % of body weight (peak {:.0f}; {:.0f} in one step, unfiltered)",
        s.ground_force_mean_percent,
        s.ground_force_peak_percent,
        s.ground_force_spike_percent,
    )
    row("foot slide", "{:.0f} mm/s while loaded", s.foot_slide_mm_s)
    row(
        "foot slide by height",
        "{:.0f} mm/s (clip {:.0f})",
        s.foot_slide_by_height_mm_s,
        s.clip_foot_slide_mm_s,
    )
    row(
        "penetration",
        "{:.1f} mm deepest, {:.1f} mean",
        s.penetration_mm,
        s.penetration_mean_mm,
    )
    if s.torque_peak_joint is not None:
        row(
            "joint torque",
            "{:.1f} N m mean, {:.0f} peak (" + s.torque_peak_joint + ")",
            s.torque_mean_nm,
            s.torque_peak_nm,
        )
        row("joint power", "{:.0f} W mean, {:.0f} peak", s.power_mean_w, s.power_peak_w)
    if s.flight_s is not None and s.flight_s >= 0.005:
        row("flight", "{:.2f} s without any contact", s.flight_s)
    row("energy drift", "{:.2f} % in flight", s.energy_drift_percent)
    row("speed", "{:.0f} x real time", s.real_time_factor)
    row("diverged", "at {:.3f} s", s.diverged_s)
    title = f"{s.character}: {s.clip or 'no clip'}, {s.duration_s:.2f} s"
    width = max(len(label) for label, _ in rows)
    return "\n".join([title, *(f"  {label:<{width}}  {text}" for label, text in rows)])
