"""Runs of this package's own tracker: one clip, one seed each; groups, summaries and tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.control import Tracking
from understudy.errors import InvalidValue
from understudy.evaluate.following import flight_time, following, mass_center
from understudy.evaluate.measure import Measured, measured
from understudy.evaluate.score import HELD, score
from understudy.feasibility import assess

if TYPE_CHECKING:
    from understudy.performance import Performance
    from understudy.take import Take

EASY_SCORE, DYNAMIC_SCORE = 7.0, 20.0
"""A clip whose poses leave so much force unexplained, or less, can be free [% of body weight]: at
rest on its feet, and with runs, jumps, hops and leaps in it."""
SHORT = 10.0
"""Longer clips are not counted among the easy ones [s]."""
FLIES = 0.07
"""A clip that falls freely for so long is dynamic [s]."""
SUCCESS_MM = 500.0
"""Published trackers count a clip as followed when its joints are on average never so far off."""
CLOSE_MM = 150.0
"""A free body whose joints are on average never so far off also looks as the clip does [mm]; one
beyond that may be about to topple when the clip ends."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """One clip tracked with one seed. Numbers that do not exist are None.

    Attributes:
        label: The clip's path in its folder.
        number: Its place in the sorted list of the folder's clips.
        seed: Seed of the search.
        seconds: How much of it was to be tracked [s].
        score_percent: Force that the clip's poses leave unexplained [% of body weight].
        free: Nothing held it, and it was never lost before the clip's end.
        help_percent: Root mean square outside force on the root [% of body weight].
        free_s: Time without help before it was lost [s].
        lost_s: When it was lost [s].
        joint_deg: Root mean square joint error [deg].
        com_mm: Root mean square distance of the center of mass [mm].
        global_mm: Mean distance of joints in the world [mm].
        peak_mm: Largest mean distance of the joints at one time [mm].
        relative_mm: Mean distance of joints, roots at one place [mm].
        slide_mm_s: Foot slide [mm/s].
        clip_slide_mm_s: The cleaned clip's own [mm/s].
        torque_nm: Largest joint torque [N m].
        torque_joint: Where.
        strength_percent: Largest torque of any joint over its servo's limit [%].
        over_percent: Share of the time in which any joint's torque exceeds its limit [%].
        shake: Joint accelerations over the clip's.
        flight_s: Time the clip falls freely [s].
        cpu_s: Processor time of cleaning, search and take [s].
        error: Why there is no take. A clip that was searched in vain has `seconds`, and counts as
            not free; one that was refused has none, and counts for nothing.
        survived: Of each disturbance, how many replays were not lost, and of how many.
    """

    label: str
    number: int = 0
    seed: int = 0
    seconds: float = 0.0
    score_percent: float | None = None
    free: bool = False
    help_percent: float | None = None
    free_s: float | None = None
    lost_s: float | None = None
    joint_deg: float | None = None
    com_mm: float | None = None
    global_mm: float | None = None
    peak_mm: float | None = None
    relative_mm: float | None = None
    slide_mm_s: float | None = None
    clip_slide_mm_s: float | None = None
    torque_nm: float | None = None
    torque_joint: str | None = None
    strength_percent: float | None = None
    over_percent: float | None = None
    shake: float | None = None
    flight_s: float | None = None
    cpu_s: float | None = None
    error: str | None = None
    survived: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kept = {name: (int(n), int(of)) for name, (n, of) in self.survived.items()}
        object.__setattr__(self, "survived", kept)

    @property
    def cost(self) -> float | None:
        """Processor seconds per second of motion."""
        return self.cpu_s / self.seconds if self.cpu_s is not None and self.seconds else None

    @property
    def refused(self) -> bool:
        """Whether nothing was tried: the file cannot be read, or holds no body with legs."""
        return self.error is not None and not self.seconds

    @property
    def success(self) -> bool:
        """Followed by the rule of published trackers, and with no help."""
        held = self.help_percent is None or self.help_percent >= HELD
        return not held and self.peak_mm is not None and self.peak_mm < SUCCESS_MM

    @property
    def close(self) -> bool:
        """Free, and close to the clip all the time."""
        return self.free and self.peak_mm is not None and self.peak_mm < CLOSE_MM

    @property
    def name(self) -> str:
        """File name without its ending, with the folder where that tells formats apart."""
        path = Path(self.label)
        return str(path.with_suffix("")) if path.parent.name else path.stem

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Run:
        """A run as `as_dict` gave it; unknown keys are left out.

        Raises:
            InvalidValue: There is no label.
        """
        known = {f.name for f in fields(cls)}
        if "label" not in values:
            raise InvalidValue("A run without a label; it must name its clip.")
        return cls(**{k: v for k, v in values.items() if k in known})


def run_of(
    take: Take,
    label: str,
    *,
    number: int = 0,
    cpu_s: float | None = None,
) -> Run:
    """Measure a take of a tracked clip.

    Args:
        take: The take.
        label: The clip's path in its folder.
        number: Its place there.
        cpu_s: Processor time it took [s].
    """
    m = measured(take)
    s, f = score(take, measures=m), following(take, measures=m)
    strength = _strength(take, m)
    return Run(
        label=label,
        number=number,
        seed=take.seed,
        seconds=f.clip_s,
        score_percent=missing(take.performance),
        free=f.free and f.whole,
        help_percent=f.help_percent,
        free_s=f.free_s,
        lost_s=f.lost_s,
        joint_deg=s.joint_error_deg,
        com_mm=f.com_mm,
        global_mm=f.joint_position_mm,
        peak_mm=f.joint_position_peak_mm,
        relative_mm=f.joint_relative_mm,
        slide_mm_s=s.foot_slide_by_height_mm_s,
        clip_slide_mm_s=s.clip_foot_slide_mm_s,
        torque_nm=s.torque_peak_nm,
        torque_joint=s.torque_peak_joint,
        strength_percent=strength[0],
        over_percent=strength[1],
        shake=f.shake,
        flight_s=f.clip_flight_s,
        cpu_s=cpu_s,
    )


def _strength(take: Take, m: Measured) -> tuple[float, float]:
    """Largest torque over the servos' limits [%], and time above them [%]; 0 without limits."""
    torque = np.linalg.norm(m.joint_torques(), axis=2)
    limit = take.model.actuator_forcerange[list(take.scene.parts[0].joint_actuators), 1]
    used = torque[:, limit > 0.0] / limit[limit > 0.0]
    if not used.size:
        return 0.0, 0.0
    return 100.0 * float(used.max()), 100.0 * float(np.mean(used.max(axis=1) > 1.001))


def missing(performance: Performance | None) -> float | None:
    """Score of the clip that a performance tracks [% of body weight]; None without ground."""
    if performance is None or performance.scene.ground is None:
        return None
    return assess(performance).score


def flight(performance: Performance) -> float:
    """Time that the tracked clip falls freely [s]; 0 where no clip is tracked."""
    for controller in performance.controllers:
        if isinstance(controller, Tracking):
            body = performance.scene.characters[controller.character]
            center = mass_center(controller.reference, body)
            return flight_time(center, controller.reference.rate)
    return 0.0


def easy(run: Run) -> bool:
    """CMU clips of at most 10 s whose poses leave at most 7 % unexplained."""
    return (
        "cmu" in run.label.casefold()
        and run.seconds <= SHORT
        and run.score_percent is not None
        and run.score_percent <= EASY_SCORE
    )


def dynamic(run: Run) -> bool:
    """Runs, jumps, hops and leaps that leave at most 20 % unexplained."""
    return (
        (run.flight_s or 0.0) >= FLIES
        and run.score_percent is not None
        and run.score_percent <= DYNAMIC_SCORE
    )


GROUPS: Mapping[str, Callable[[Run], bool]] = {
    "CMU clips up to 10 s, score <= 7 %": easy,
    "dynamic clips, score <= 20 %": dynamic,
    "everything else": lambda run: not easy(run) and not dynamic(run),
    "all": lambda run: True,
}
"""Which runs belong to which group; an easy dynamic clip belongs to two."""
HALVES: Mapping[str, Callable[[Run], bool]] = {
    "all": lambda run: True,
    "chosen on": lambda run: run.number % 2 == 0,
    "held out": lambda run: run.number % 2 == 1,
}
"""Settings are chosen on every other clip of the sorted list; the others are only reported."""

SUMMARY_HEAD = (
    "group",
    "half",
    "runs",
    "free",
    "free %",
    "free, close %",
    "help of the others % BW",
    "global mm",
    "root-relative mm",
    "joints deg",
    "CoM mm",
    "slide <= clip's %",
    "CPU-s/s",
)
"""Columns of `summaries`: medians over the free runs; cost over all."""


def summaries(runs: Sequence[Run]) -> list[tuple[str | int | float | None, ...]]:
    """One row per group and half that has runs; columns as `SUMMARY_HEAD`."""
    rows = []
    for group, belongs in GROUPS.items():
        for half, within in HALVES.items():
            found = [r for r in runs if not r.refused and belongs(r) and within(r)]
            if found:
                rows.append((group, half, *_summary(found)))
    return rows


def _summary(runs: Sequence[Run]) -> tuple[int | float | None, ...]:
    free = [r for r in runs if r.free]
    slid = [
        (r.slide_mm_s, r.clip_slide_mm_s)
        for r in free
        if r.slide_mm_s is not None and r.clip_slide_mm_s is not None
    ]
    return (
        len(runs),
        len(free),
        100.0 * len(free) / len(runs),
        100.0 * sum(r.close for r in runs) / len(runs),
        middle(r.help_percent for r in runs if not r.free),
        middle(r.global_mm for r in free),
        middle(r.relative_mm for r in free),
        middle(r.joint_deg for r in free),
        middle(r.com_mm for r in free),
        100.0 * sum(own <= clip for own, clip in slid) / len(slid) if slid else None,
        middle(r.cost for r in runs),
    )


def survival(runs: Sequence[Run]) -> list[tuple[str, int, int]]:
    """Of each disturbance: its name, replays that were not lost, and replays."""
    names = dict.fromkeys(name for run in runs for name in run.survived)
    pairs = {n: [run.survived[n] for run in runs if n in run.survived] for n in names}
    return [(n, sum(a for a, _ in each), sum(b for _, b in each)) for n, each in pairs.items()]


def worst(runs: Sequence[Run], count: int = 10) -> list[Run]:
    """The worst run of the worst clips: by help, then by how soon it was lost, then by error."""

    def badness(run: Run) -> tuple[bool, float, float, float]:
        lasted = (run.free_s or 0.0) / run.seconds if run.seconds else 0.0
        return (not run.free, run.help_percent or 0.0, 1.0 - lasted, run.global_mm or 0.0)

    found: dict[str, Run] = {}
    for run in sorted((r for r in runs if r.error is None), key=badness, reverse=True):
        found.setdefault(run.label, run)
    return list(found.values())[:count]


def middle(values: Iterable[float | None]) -> float | None:
    """Median of the values that exist; None where there are none."""
    found = [v for v in values if v is not None]
    return float(median(found)) if found else None


HEAD = (
    "clip",
    "seed",
    "s",
    "score %",
    "help % BW",
    "s free",
    "joints deg",
    "CoM mm",
    "global mm",
    "root-rel mm",
    "slide/clip mm/s",
    "torque N m",
    "of limit %",
    "time over %",
    "shake",
    "CPU-s/s",
)
"""Columns of `table`."""


def table(runs: Sequence[Run]) -> list[tuple[str, ...]]:
    """One row of words per run; columns as `HEAD`."""
    return [_row(run) for run in sorted(runs, key=lambda r: (r.number, r.label, r.seed))]


def reasons(runs: Sequence[Run]) -> list[str]:
    """Why runs have no take."""
    return [f"{run.name}, seed {run.seed}: {run.error}" for run in runs if run.error is not None]


def _row(run: Run) -> tuple[str, ...]:
    def cell(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    if run.error is not None:
        known = (f"{run.seconds:.2f}", cell(run.score_percent, ".1f"))
        return (run.name, str(run.seed), *known, "none", *[""] * (len(HEAD) - 5))
    slide = f"{cell(run.slide_mm_s, '.0f')}/{cell(run.clip_slide_mm_s, '.0f')}"
    return (
        run.name,
        str(run.seed),
        f"{run.seconds:.2f}",
        cell(run.score_percent, ".1f"),
        "free" if run.free else f"{cell(run.help_percent, '.1f')}{' lost' if run.lost_s else ''}",
        cell(run.free_s, ".2f"),
        cell(run.joint_deg, ".2f"),
        cell(run.com_mm, ".1f"),
        cell(run.global_mm, ".1f"),
        cell(run.relative_mm, ".1f"),
        slide,
        cell(run.torque_nm, ".0f"),
        cell(run.strength_percent, ".0f"),
        cell(run.over_percent, ".1f"),
        cell(run.shake, ".2f"),
        cell(run.cost, ".2f"),
    )
