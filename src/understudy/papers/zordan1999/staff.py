"""Figure 8, the staff: a servo in the wrist keeps it upright."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np

from understudy.character.bodies import adult_man
from understudy.control import Push, Upright
from understudy.evaluate.chart import Chart, Series
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array
from understudy.motion.samples import sample
from understudy.papers.filmstrip import Film
from understudy.papers.finding import Claim, Finding, Strip
from understudy.papers.sheets import Sheet
from understudy.papers.zordan1999.drum import played_back
from understudy.papers.zordan1999.finding import spread
from understudy.performance import tracked
from understudy.scene import Staff
from understudy.simulate import simulate
from understudy.take import Take

# While the staff is pumped [s].
PUMPED = (1.1, 5.0)
# A push on its middle [N s], ahead and to the side, and when it begins [s].
PUSH, PUSHED = 5.0, 3.0
# Held below its middle it would topple, and a push on its middle tilts it.
GRIP = 0.4
# Upright is this near to the vertical [deg].
UPRIGHT = 3.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Pumped:
    """A staff through a take.

    Attributes:
        take: What happened.
        angle: Of the staff from the vertical at every step [deg], shape (frames,).
    """

    take: Take = field(repr=False)
    angle: Array = field(repr=False)

    @property
    def steady(self) -> Array:
        """The angle while the staff is pumped [deg]."""
        times = self.take.times
        return self.angle[(times >= PUMPED[0]) & (times <= PUMPED[1])]

    @property
    def tilt(self) -> tuple[float, float]:
        """Root mean square and largest through the pump [deg]."""
        return float(np.sqrt(np.mean(self.steady**2))), float(self.steady.max())

    @property
    def back(self) -> float | None:
        """Time from the push until the staff is upright and stays so [s]; None for never."""
        times = self.take.times
        last = min(PUMPED[1], float(times[-1]))
        away = times[(times > PUSHED) & (times < last) & (self.angle > UPRIGHT)]
        end = float(away.max()) - PUSHED if len(away) else 0.0
        return end if end < last - PUSHED - 0.1 else None


def pumped(take: Take) -> Pumped:
    """The staff of a take."""
    body = mujoco.mj_name2id(take.model, mujoco.mjtObj.mjOBJ_BODY, "staff")
    _, _, turned = take.poses()
    up = rot.rotate(turned[:, body], np.array([0.0, 0.0, 1.0]))[:, 2]
    return Pumped(take=take, angle=np.degrees(np.arccos(np.clip(up, -1.0, 1.0))))


def pumping(*, quick: bool = False) -> Finding:
    """The staff with its task and without, under both laws, and pushed."""
    clip, body = sample("staff"), adult_man(plan="upper" if quick else "full")
    if quick:
        clip = clip.trimmed(0.0, 4.4)
    staff = Staff(grip=GRIP)

    def played(law: str, *tasks: Upright | Push) -> Pumped:
        return pumped(simulate(tracked(clip, body, law=law, tasks=tasks, props=(staff,))))

    ways = {"ahead": (PUSH, 0.0, 0.0), "to the left": (0.0, PUSH, 0.0)}
    laws = ("modern",) if quick else ("modern", "paper")
    if quick:
        del ways["to the left"]
    plain = {law: played(law) for law in laws}
    task = {law: played(law, Upright()) for law in laws}
    hit = {
        way: played("modern", Upright(), Push(time=PUSHED, on="staff", impulse=impulse))
        for way, impulse in ways.items()
    }
    raw = pumped(played_back(plain["modern"].take))
    rows: list[tuple[object, ...]] = [("kinematic playback", None, None, *raw.tilt, None)]
    rows += [("tracked", law, None, *one.tilt, None) for law, one in plain.items()]
    rows += [("task in the wrist", law, None, *one.tilt, None) for law, one in task.items()]
    rows += [("task in the wrist", "modern", way, *one.tilt, one.back) for way, one in hit.items()]
    return _finding(rows, raw, plain["modern"], task["modern"], hit)


def _finding(
    rows: list[tuple[object, ...]], raw: Pumped, plain: Pumped, task: Pumped, hit: dict[str, Pumped]
) -> Finding:
    late = max(float("inf") if one.back is None else one.back for one in hit.values())
    worst = max(one.tilt[1] for one in hit.values())
    pushed = hit["ahead"]
    times = spread(2.0, 2.8, 6)
    after = tuple(min(PUSHED - 0.05 + 0.15 * k, pushed.take.duration) for k in range(6))
    return Finding(
        figure="8, staff",
        title="The staff",
        setting="sample:staff by a man of 1.78 m, whose captured wrist lets the staff tilt. The "
        f"staff is 1.5 m long, 0.8 kg, held at {GRIP:g} of its length. Wrist servo: "
        f"{Upright().stiffness:g} /s^2 of the inertia of hand and staff, damping ratio "
        f"{Upright().damping_ratio:g}.",
        claims=(
            Claim(
                said="Played back, the staff does not stay vertical.",
                measured=f"{raw.tilt[0]:.1f} degrees rms, {raw.tilt[1]:.0f} at most",
                holds=raw.tilt[0] > UPRIGHT,
            ),
            Claim(
                said="A servo in the wrist keeps it upright.",
                measured=f"{task.tilt[0]:.2f} degrees rms through the pump "
                f"(goal: {UPRIGHT:g} or less)",
                holds=task.tilt[0] <= UPRIGHT,
            ),
            Claim(
                said="It sways in a realistic way under its own mass.",
                measured=f"sways between {task.steady.min():.2f} and {task.tilt[1]:.2f} degrees; "
                f"a push of {PUSH:g} N s tilts it by {worst:.0f} degrees, and it is back within "
                f"{UPRIGHT:g} degrees after {late:.2f} s (goal: 1 s)",
                holds=late <= 1.0 and worst > UPRIGHT,
            ),
        ),
        charts=(
            Chart(
                title="Figure 8, staff: tilt",
                caption="Angle of the staff from the vertical. "
                f"The push of {PUSH:g} N s ahead on its middle comes at {PUSHED:g} s.",
                x_label="Time [s]",
                y_label="Tilt [deg]",
                series=tuple(
                    Series(name=name, x=one.take.times, y=one.angle)
                    for name, one in (
                        ("task in the wrist", task),
                        ("kinematic playback", raw),
                        ("task, pushed ahead", pushed),
                    )
                ),
            ),
        ),
        strips=(
            Strip(
                alt="A man pumps a staff: tilting as captured, upright with the task.",
                films=(
                    Film(title="as captured", thing=plain.take, times=times),
                    Film(title="task in the wrist", thing=task.take, times=times),
                    Film(title="pushed ahead at 3 s", thing=pushed.take, times=after),
                ),
            ),
        ),
        sheets=(
            Sheet(
                name="Figure 8 staff",
                caption=f"Tilt of the staff from {PUMPED[0]:g} to {PUMPED[1]:g} s.",
                head=(
                    "wrist",
                    "law",
                    f"push of {PUSH:g} N s",
                    "tilt, rms [deg]",
                    "tilt, largest [deg]",
                    f"back within {UPRIGHT:g} degrees after [s]",
                ),
                rows=tuple(rows),
            ),
        ),
        facts={
            "staff_tilt_rms_deg": task.tilt[0],
            "staff_tilt_played_back_rms_deg": raw.tilt[0],
            "staff_recovery_s": None if np.isinf(late) else late,
        },
    )
