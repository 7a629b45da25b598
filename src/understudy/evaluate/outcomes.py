"""How well tasks were done: how far a palm, a face, a staff or a body was from its goal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.character.footing import SIDES, sole_of
from understudy.control import Balance, HandOn, LookAt, Reach, Task, Upright
from understudy.control.look_at import EYES
from understudy.evaluate.measure import Measured
from understudy.motion import rotations as rot
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What one task came to, while it had taken over fully.

    Attributes:
        task: Its kind: "Reach", "Upright", ...
        character: Number of the character.
        start_s: When it had taken over [s].
        end_s: When it began to let go [s].
        what: What is measured.
        unit: "mm" or "deg".
        mean: Mean distance from the goal.
        most: The largest.
    """

    task: str
    character: int
    start_s: float
    end_s: float
    what: str
    unit: str
    mean: float
    most: float


def outcomes(take: Take, measures: Measured) -> tuple[Outcome, ...]:
    """The outcome of every task of a take, in the order of its controllers.

    A take read from a file has none: it does not hold its controllers.
    """
    controllers = () if take.performance is None else take.performance.controllers
    made = []
    for task in (one for one in controllers if isinstance(one, Task)):
        found = _measured(task, take, measures)
        if found is None:
            continue
        what, unit, values = found
        start = task.span[0] + task.ease
        end = min(task.span[1], take.duration + task.ease) - task.ease
        during = (measures.times >= start) & (measures.times <= end)
        if during.any():
            values = values[during]
            made.append(
                Outcome(
                    task=task.kind,
                    character=task.character,
                    start_s=start,
                    end_s=end,
                    what=what,
                    unit=unit,
                    mean=float(values.mean()),
                    most=float(values.max()),
                )
            )
    return tuple(made)


def _measured(task: Task, take: Take, m: Measured) -> tuple[str, str, Array] | None:
    """What is measured of a task, its unit, and its value at every measured frame."""
    who = m.performer(task.character)
    prefix = take.scene.prefix(task.character)
    if isinstance(task, Reach):
        hand = f"{prefix}{task.hand}_hand"
        gap = _site(take, m, f"{prefix}{task.hand}_palm") - _target(task.target, take, m)
        gap = gap - task.beside(who.character)
        if isinstance(task, HandOn):  # how deep it lies is the surface's business
            normal = np.array(task.normal)
            gap = gap - (gap @ normal)[:, None] * normal
        return f"{hand} from its target", "mm", 1e3 * np.linalg.norm(gap, axis=1)
    if isinstance(task, LookAt):
        head = take.model.body(f"{prefix}head").id
        turn, place = m.body_rotations[:, head], m.body_positions[:, head]
        eyes = place + rot.rotate(turn, np.array(EYES) * who.height)
        face = rot.rotate(turn, np.array([1.0, 0.0, 0.0]))
        return "face from its target", "deg", _angle(face, _target(task.target, take, m) - eyes)
    if isinstance(task, Upright):
        turn = m.body_rotations[:, take.model.body(f"{prefix}{task.hand}_hand").id]
        axis = rot.rotate(turn, np.array(task.axis))
        return "from vertical", "deg", _angle(axis, np.array([[0.0, 0.0, 1.0]]))
    if isinstance(task, Balance):
        soles = []
        for side in SIDES:
            foot = take.model.body(f"{prefix}{side}_foot").id
            middle = sole_of(who.character, side).middle
            turned = rot.rotate(m.body_rotations[:, foot], middle)
            soles.append(m.body_positions[:, foot] + turned)
        aside = m.center_of_mass[:, task.character, :2] - 0.5 * (soles[0] + soles[1])[:, :2]
        return "center of mass from the middle of the feet", "mm", 1e3 * np.hypot(*aside.T)
    return None


def _target(target: str | tuple[float, float, float], take: Take, m: Measured) -> Array:
    """World place of a target [m], shape (frames, 3) or (1, 3)."""
    return _site(take, m, target) if isinstance(target, str) else np.array([target])


def _site(take: Take, m: Measured, name: str) -> Array:
    """World path of a named site [m], shape (frames, 3)."""
    site = take.model.site(name)
    body = int(take.model.site_bodyid[site.id])
    return m.body_positions[:, body] + rot.rotate(m.body_rotations[:, body], site.pos)


def _angle(a: Array, b: Array) -> Array:
    """Angle between directions [deg], shape (frames,)."""
    lengths = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    cosine: Any = np.sum(a * b, axis=1) / np.maximum(lengths, 1e-12)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
