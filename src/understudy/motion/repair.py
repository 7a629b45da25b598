"""Glitches of a capture found and repaired: spikes, flips and steps.

A glitch is judged by the turn from one frame to the next (the geodesic angle, never a difference
of Euler angles), against the typical turn of the same joint just before and after. Fast human
motion speeds up over several frames; a glitch begins in one frame, at least four times as fast as
the tenth of a second on either side. Three kinds are told apart:

    flip    turns by 75 degrees or more in one frame: of the stretches between such turns every
            second one is wrong (those that last less time in all); it is turned back so that it
            joins its neighbors, or drawn again like a spike if it is shorter than 0.1 s
    spike   leaves the path and returns to it within 60 ms: the frames between are drawn again by a
            monotone cubic from the frames around them
    step    stays at another angle, at ten times the speed of its surroundings and more than 1500
            degrees a second: spread over a tenth of a second

The root's path is repaired in the same way, for spikes only. A kick, a run, a clap have fast frames
but not such edges and are left alone. A joint that shakes is steadied (`motion.jitter`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.interpolate import PchipInterpolator

from understudy.motion import rotations as rot
from understudy.motion.clip import Clip
from understudy.motion.jitter import steadied
from understudy.motion.rotations import Array

# Degrees (per frame) and degrees per second that a spike, a flip and a step exceed; the fastest
# joint rotation in daily life and sport short of throwing is about 1500 to 2000 degrees a second.
_SPIKE, _SPIKE_SPEED = 10.0, 1000.0
_FLIP, _FLIP_SPEED = 75.0, 2500.0
_STEP_SPEED = 1500.0
# How much faster than its surroundings, and how long those are [s].
_SPIKE_RATIO, _STEP_RATIO = 4.0, 10.0
_AROUND = 0.1
# Longest spike, and longest flip that is drawn again rather than turned back [s].
_BRIEF, _BRIEF_FLIP = 0.06, 0.1
# A step is spread over this time [s].
_SPREAD = 0.1
# Root spikes exceed this distance [m] (per frame) and speed [m/s].
_ROOT, _ROOT_SPEED = 0.015, 3.0


@dataclass(frozen=True, kw_only=True)
class Repair:
    """One repaired glitch.

    Attributes:
        joint: The joint's name, or "root position".
        kind: "spike", "flip", "step" or "jitter".
        start: Time of the first changed frame [s].
        end: Time of the last changed frame [s].
        before: Largest change from frame to frame in it, before [degrees; meters for the root].
        after: The same, after.
    """

    joint: str
    kind: Literal["spike", "flip", "step", "jitter"]
    start: float
    end: float
    before: float
    after: float


def repaired(clip: Clip) -> Clip:
    """The clip without spikes, flips and steps; a note per joint says what was done."""
    return repair(clip)[0]


def repair(clip: Clip) -> tuple[Clip, tuple[Repair, ...]]:
    """The repaired clip and each repair; the same clip and none when nothing was found."""
    turned = np.array(clip.rotations)
    repairs: list[Repair] = []
    if clip.frames < 5:
        return clip, ()
    path, root_repairs = _repaired_path(clip.root_positions, clip.rate)
    for joint, name in enumerate(clip.skeleton.names):
        track = _Track(turned[:, joint], clip.rate)
        for kind, first, last, before in track.repair():
            after = float(_steps(track.q[max(first - 1, 0) : last + 2]).max(initial=0.0))
            repairs.append(_report(name, kind, first, last, before, after, clip.rate))
        turned[:, joint] = track.q
        # Before what hangs on it: thighs that turn against a shaking pelvis are right.
        given = turned, path, clip.skeleton.parents, clip.rate
        turned, path, calmed = steadied(*given, joint)
        repairs += [_report(name, "jitter", *stretch, clip.rate) for stretch in calmed]
    repairs += root_repairs
    if not repairs:
        return clip, ()
    notes = (*clip.notes, *_notes(repairs))
    return replace(clip, rotations=turned, root_positions=path, notes=notes), tuple(repairs)


def _report(
    joint: str, kind: str, first: int, last: int, before: float, after: float, rate: float
) -> Repair:
    assert kind in ("spike", "flip", "step", "jitter")
    return Repair(
        joint=joint, kind=kind, start=first / rate, end=last / rate, before=before, after=after
    )


def _notes(repairs: list[Repair]) -> Iterator[str]:
    for joint, kind in dict.fromkeys((r.joint, r.kind) for r in repairs):
        found = [r for r in repairs if (r.joint, r.kind) == (joint, kind)]
        if joint == "root position":
            size = f"{1000.0 * max(r.before for r in found):.0f} mm"
        else:
            size = f"{max(r.before for r in found):.0f} degrees a frame"
        many = "stretches of jitter" if kind == "jitter" else f"{kind}s"
        count = f"{len(found)} {many if len(found) > 1 else kind}"
        times = ", ".join(f"{r.start:.2f}" for r in found[:6])
        more = ", ..." if len(found) > 6 else ""
        yield f"Repaired {joint}: {count} of up to {size}, at {times}{more} s."


def _steps(q: Array) -> Array:
    """Turn from each frame to the next [deg], shape (frames - 1,)."""
    return np.degrees(rot.angle_between(q[:-1], q[1:]))


def _typical(steps: Array, first: int, last: int, width: int) -> float:
    """The typical step just outside steps first .. last: the larger of the two sides' medians."""
    sides = (steps[max(0, first - width) : first], steps[last + 1 : last + 1 + width])
    return max((float(np.median(side)) for side in sides if len(side)), default=0.0)


class _Track:
    """One joint's rotations (frames, 4) under repair; `q` is the present state."""

    def __init__(self, q: Array, rate: float):
        self.q = np.array(q)
        self.rate = rate
        self.width = max(3, round(_AROUND * rate))

    def repair(self) -> list[tuple[str, int, int, float]]:
        """Repair in place; kind, first and last frame and size before [deg] of each repair."""
        if not np.any(_steps(self.q) > max(_SPIKE, _SPIKE_SPEED / self.rate)):
            return []
        done = self._spikes(both_edges_below=_FLIP)  # or a spike's one sharp edge counts as a flip
        return [*done, *self._flips(), *self._spikes(), *self._level_steps()]

    def _sudden(self, speed: float, least: float, ratio: float) -> list[int]:
        """Steps that are large, and larger than `ratio` times the typical ones around."""
        steps = _steps(self.q)
        large = np.flatnonzero(steps > max(least, speed / self.rate))
        return [
            int(t) for t in large if steps[t] > ratio * _typical(steps, int(t), int(t), self.width)
        ]

    def _spikes(self, both_edges_below: float = 360.0) -> list[tuple[str, int, int, float]]:
        """Draw spikes again, the shortest first, until none is left.

        Those whose two edges both reach `both_edges_below` [deg] are left for later.
        """
        done: list[tuple[str, int, int, float]] = []
        longest = max(1, round(_BRIEF * self.rate))
        while True:
            sudden = self._sudden(_SPIKE_SPEED, _SPIKE, _SPIKE_RATIO)
            sizes = _steps(self.q)
            pairs = [
                (back - leave, leave, back)
                for k, leave in enumerate(sudden)
                for back in sudden[k + 1 :]
                if back - leave <= longest
                and min(sizes[leave], sizes[back]) < both_edges_below
                and self._is_spike(leave, back)
            ]
            free = np.ones(len(self.q), bool)
            for _, leave, back in sorted(pairs):
                if free[leave : back + 2].all():
                    free[leave : back + 2] = False
                    before = float(_steps(self.q[leave : back + 2]).max())
                    self._redraw(leave + 1, back)
                    done.append(("spike", leave + 1, back, before))
            if not pairs:
                return sorted(done, key=lambda repair: repair[1])

    def _is_spike(self, leave: int, back: int) -> bool:
        """Whether the frames after step `leave` up to step `back` are off the path around them."""
        steps = _steps(self.q[max(0, leave - self.width) : back + 2 + self.width])
        offset = max(0, leave - self.width)
        edges = min(steps[leave - offset], steps[back - offset])
        gap = float(np.degrees(rot.angle_between(self.q[leave], self.q[back + 1])))
        typical = _typical(steps, leave - offset, back - offset, self.width)
        weight = np.arange(1, back - leave + 1) / (back - leave + 1)
        bridge = rot.slerp(self.q[leave], self.q[back + 1], weight)
        off = np.degrees(rot.angle_between(self.q[leave + 1 : back + 1], bridge))
        expected = 2.0 * typical * (back - leave + 1)
        return bool(
            edges > _SPIKE_RATIO * typical
            and off.max() > max(0.5 * _SPIKE, 2.0 * typical)
            and gap < max(0.5 * off.max(), expected)
        )

    def _redraw(self, first: int, last: int) -> None:
        """Draw frames first .. last again from up to two frames on either side.

        More frames are drawn where the gap would otherwise be crossed faster than a body moves.
        """
        fastest = _STEP_SPEED / self.rate
        while first > 1 and last < len(self.q) - 2 and last - first < _BRIEF_FLIP * self.rate:
            gap = np.degrees(rot.angle_between(self.q[first - 1], self.q[last + 1]))
            if gap <= fastest * (last - first + 2):
                break
            first, last = first - 1, last + 1
        low, high = max(0, first - 2), min(len(self.q), last + 3)
        known = np.r_[low:first, last + 1 : high]
        signs = rot.continuous(self.q[known])
        drawn = PchipInterpolator(known, signs)(np.arange(first, last + 1))
        self.q[first : last + 1] = rot.normalized(drawn)
        self.q = rot.continuous(self.q)

    def _flips(self) -> list[tuple[str, int, int, float]]:
        jumps = self._sudden(_FLIP_SPEED, _FLIP, _SPIKE_RATIO)
        if not jumps:
            return []
        edges = [0, *[t + 1 for t in jumps], len(self.q)]
        stretches = list(pairwise(edges))
        odd_time = sum(b - a for a, b in stretches[1::2])
        wrong = stretches[1::2] if 2 * odd_time <= len(self.q) else stretches[0::2]
        sizes = _steps(self.q)
        done: list[tuple[str, int, int, float]] = []
        original = self.q.copy()
        for first, stop in wrong:
            ends = [t for t in (first - 1, stop - 1) if 0 <= t < len(sizes)]
            before = float(max(sizes[t] for t in ends))
            if len(ends) == 2 and stop - first <= _BRIEF_FLIP * self.rate:
                self._redraw(first, stop - 1)
            else:
                self.q[first:stop] = self._turned_back(original, first, stop)
            done.append(("flip", first, stop - 1, before))
        self.q = rot.continuous(self.q)
        return done

    @staticmethod
    def _turned_back(q: Array, first: int, stop: int) -> Array:
        """Frames first .. stop - 1 turned so that they join the frames around them.

        The turn is applied in the child's or in the parent's frame, whichever needs to change less
        between the two ends; the change is spread over the stretch.
        """
        part = q[first:stop]
        joined = [
            (place, other)
            for place, other, exists in ((0, first - 1, first > 0), (-1, stop, stop < len(q)))
            if exists
        ]
        inside = [rot.multiply(rot.conjugate(part[i]), q[o]) for i, o in joined]
        outside = [rot.multiply(q[o], rot.conjugate(part[i])) for i, o in joined]
        weight = np.linspace(0.0, 1.0, len(part))
        if rot.angle_between(inside[0], inside[-1]) <= rot.angle_between(outside[0], outside[-1]):
            return rot.multiply(part, rot.slerp(inside[0], inside[-1], weight))
        return rot.multiply(rot.slerp(outside[0], outside[-1], weight), part)

    def _level_steps(self) -> list[tuple[str, int, int, float]]:
        """Spread sudden steps that stay over a tenth of a second."""
        done: list[tuple[str, int, int, float]] = []
        sudden = self._sudden(_STEP_SPEED, _SPIKE, _STEP_RATIO)
        # Several large ones in a row are a fast movement, not a step.
        sizes = _steps(self.q)
        alone = [
            t
            for t in sudden
            if not any(0 < abs(t - other) <= self.width for other in sudden)
            and max(sizes[max(0, t - 3) : t].max(initial=0), sizes[t + 1 : t + 4].max(initial=0))
            < 0.5 * sizes[t]
        ]
        for t in alone:
            before = float(_steps(self.q[t : t + 2])[0])
            jump = rot.multiply(rot.conjugate(self.q[t]), self.q[t + 1])
            half = max(1, round(0.5 * _SPREAD * self.rate))
            first, stop = max(0, t + 1 - half), min(len(self.q), t + 1 + half)
            s = np.clip((np.arange(first, stop) - (t + 0.5)) / (2.0 * half) + 0.5, 0.0, 1.0)
            ease = s * s * (3.0 - 2.0 * s)
            # Frames before the step are turned toward it, frames after it back by what is left.
            share = np.where(np.arange(first, stop) <= t, ease, ease - 1.0)
            turn = rot.from_rotvec(share[:, None] * rot.to_rotvec(jump))
            self.q[first:stop] = rot.multiply(self.q[first:stop], turn)
            done.append(("step", first, stop - 1, before))
        self.q = rot.continuous(self.q)
        return done


def _repaired_path(path: Array, rate: float) -> tuple[Array, list[Repair]]:
    """The root path (frames, 3) without spikes of up to 60 ms."""
    path = np.array(path)
    width = max(3, round(_AROUND * rate))
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    large = np.flatnonzero(steps > max(_ROOT, _ROOT_SPEED / rate))
    sudden = [
        int(t) for t in large if steps[t] > _SPIKE_RATIO * _typical(steps, int(t), int(t), width)
    ]
    repairs: list[Repair] = []
    done = -1
    for k, leave in enumerate(sudden):
        for back in sudden[k + 1 :]:
            if leave <= done or (back - leave) / rate > max(_BRIEF, 1.0 / rate) + 1e-9:
                break
            gap = float(np.linalg.norm(path[back + 1] - path[leave]))
            off = float(np.linalg.norm(path[leave + 1 : back + 1] - path[leave], axis=1).max())
            expected = 2.0 * _typical(steps, leave, back, width) * (back - leave + 1)
            if gap < max(0.5 * off, expected):
                before = float(steps[leave : back + 1].max())
                frames = np.arange(leave + 1, back + 1)
                known = np.r_[max(0, leave - 1) : leave + 1, back + 1 : min(len(path), back + 3)]
                path[frames] = PchipInterpolator(known, path[known])(frames)
                after = float(np.linalg.norm(np.diff(path[leave : back + 2], axis=0), axis=1).max())
                repairs.append(
                    _report("root position", "spike", leave + 1, back, before, after, rate)
                )
                done = back
                break
    return path, repairs
