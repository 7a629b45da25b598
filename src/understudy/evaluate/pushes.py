"""Pushes: forces from outside that a take was given on purpose, and what they amount to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.evaluate.measure import pushing
from understudy.evaluate.owners import owners
from understudy.motion.figure import plain_name
from understudy.motion.rotations import Array

if TYPE_CHECKING:
    from understudy.take import Take

TOLD = 3  # pushes that a statement names one by one


@dataclass(frozen=True, kw_only=True)
class PushEvent:
    """A force or torque on one link from outside, for a while.

    Attributes:
        link: The link or prop that was pushed.
        start_s: When it begins [s].
        duration_s: How long it lasts [s].
        impulse_ns: Size of `impulse` [N s].
        impulse: Time integral of the force at the link's center of mass [N s], world, shape (3,).
        peak_force_n: Largest force [N].
        peak_torque_nm: Largest torque [N m].
    """

    link: str
    start_s: float
    duration_s: float
    impulse_ns: float
    impulse: Array = field(repr=False, compare=False)
    peak_force_n: float
    peak_torque_nm: float

    def __post_init__(self) -> None:
        impulse = np.array(self.impulse, float)
        impulse.setflags(write=False)
        object.__setattr__(self, "impulse", impulse)

    def as_dict(self) -> dict[str, Any]:
        """Plain values that JSON takes, with the unit in every key."""
        return {
            "link": self.link,
            "start_s": self.start_s,
            "duration_s": self.duration_s,
            "impulse_ns": self.impulse_ns,
            "impulse_world_ns": self.impulse.tolist(),
            "peak_force_n": self.peak_force_n,
            "peak_torque_nm": self.peak_torque_nm,
        }


def push_events(take: Take) -> tuple[PushEvent, ...]:
    """Every push of a take, in order of time: a stretch of steps in which a link was pushed."""
    outside = pushing(take)
    if outside is None:
        return ()
    # The last frame's forces act on no step.
    acting, names, out = outside[: len(take.times) - 1], owners(take), []
    for body in np.flatnonzero(np.any(acting, axis=(0, 2))):
        wrench = acting[:, body]
        active = np.concatenate(([0], np.any(wrench, axis=1).astype(int), [0]))
        edges = np.flatnonzero(np.diff(active))
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            force, torque = wrench[a:b, :3], wrench[a:b, 3:]
            impulse = force.sum(axis=0) / take.rate
            out.append(
                PushEvent(
                    link=names.names[names.of_body[body]],
                    start_s=float(take.times[a]),
                    duration_s=float(b - a) / take.rate,
                    impulse_ns=float(np.linalg.norm(impulse)),
                    impulse=impulse,
                    peak_force_n=float(np.linalg.norm(force, axis=1).max()),
                    peak_torque_nm=float(np.linalg.norm(torque, axis=1).max()),
                )
            )
    return tuple(sorted(out, key=lambda push: (push.start_s, push.link)))


def pushed(pushes: Sequence[PushEvent]) -> str:
    """In words: what pushed the body besides contact; empty when nothing did."""
    if not pushes:
        return ""
    told = [
        f"{plain_name(push.link)}, {push.impulse_ns:.1f} N s at {push.start_s:.2f} s"
        for push in pushes[:TOLD]
    ]
    more = f"; and {len(pushes) - TOLD} more" if len(pushes) > TOLD else ""
    return f"Pushed from outside, on purpose: {'; '.join(told)}{more}."
