"""From what a character's table says to its body and the motion it is to track."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np

from understudy.character import Character, bodies, read_mapping, retargeted
from understudy.edit.edit import OWN, Cut, Edit, Performer, Segment
from understudy.edit.lines import Place
from understudy.edit.source import Source
from understudy.errors import ClipError, InvalidValue
from understudy.motion.clip import Clip
from understudy.motion.edits import SPEEDS, placed, retimed, trimmed
from understudy.motion.mirror import mirrored
from understudy.motion.read import read
from understudy.motion.samples import sample, samples
from understudy.motion.segments import concatenated, looped, same_skeleton, spliced
from understudy.motion.transitions import transitions

SAMPLE = "sample:"
NEAR = 1.0
"""A transition whose time is not said begins at most this long before the last moment it can, and
leads at most this far into the other clip [s]; in short clips a third of what there is, so that a
clip does not go over into itself where it is anyway."""
ALONE = 0.1
"""A segment plays by itself for at least this long between two transitions that are found, where
there is room [s]."""
LONGEST = 3600.0
"""Motions longer than this are a mistake [s]."""


def motion_of(edit: Edit, number: int) -> tuple[Clip, Character]:
    """The motion and the body of a character, the motion not yet on the body.

    Raises:
        EditError: A file that cannot be read, an edit outside the clip, a body that cannot be.
    """
    said, place = edit.character[number], ("character", number)
    if said.clip is not None:
        clip, body = _read(said, edit.source, place), None
    else:
        clip, body = _joined(said, edit.source, place)
    clip = _cut(clip, said, edit.source, place)
    with edit.source.blaming(place):
        if said.at is not None or said.heading:
            clip = placed(clip, at=said.at, heading=said.heading)
        return clip, body or body_of(said, clip, edit.source, place)


def body_of(said: Performer, clip: Clip, source: Source, place: Place) -> Character:
    """The body that a table asks for."""
    mapping = None
    if said.mapping:
        with source.blaming((*place, "mapping")):
            mapping = read_mapping(source.path.parent / said.mapping)
    with source.blaming((*place, "body")):
        if said.body == OWN:
            return Character.from_clip(
                clip,
                plan=said.plan,
                sex=said.sex or "male",
                mass=said.mass,
                height=said.height,
                mapping=mapping,
            )
        sizes = {k: v for k in ("height", "mass") if (v := getattr(said, k)) is not None}
        return getattr(bodies, said.body)(plan=said.plan, **sizes)


def files_of(edit: Edit) -> list[str]:
    """Every file that an edit reads besides itself."""
    found: list[str] = []
    for performer in edit.character:
        for cut in (performer, *performer.segment):
            words = (None if (cut.clip or SAMPLE).startswith(SAMPLE) else cut.clip, cut.asf)
            found += [str(edit.source.path.parent / word) for word in words if word]
        if performer.mapping:
            found.append(str(edit.source.path.parent / performer.mapping))
    return found


def _read(cut: Cut, source: Source, place: Place) -> Clip:
    """The clip that a word names: a file or a sample."""
    word = cut.clip or ""
    with source.blaming((*place, "clip")):
        if word.startswith(SAMPLE):
            if cut.reading:
                name = next(iter(cut.reading))
                raise InvalidValue(f"{name} is about reading a file, and {word} is a sample.")
            return sample(word.removeprefix(SAMPLE))
        path = source.path.parent / word
        if word in samples() and not path.exists():
            raise ClipError(path, f'no such file. Did you mean "{SAMPLE}{word}"?')
        asf = None if cut.asf is None else source.path.parent / cut.asf
        options = {**cut.reading, **({"asf": asf} if asf else {})}
        return read(path, **options)  # type: ignore[arg-type]


def _cut(clip: Clip, cut: Cut, source: Source, place: Place) -> Clip:
    """Trimmed, mirrored, retimed and looped as a table says."""
    if cut.trim is not None:
        with source.blaming((*place, "trim")):
            start, end = cut.trim
            clip = trimmed(clip, start, None if math.isinf(end) else end)
            if clip.frames < 2:
                raise InvalidValue(
                    f"trim is {list(cut.trim)}; that is one frame, and a motion needs two or more."
                )
    if cut.mirrored:
        with source.blaming((*place, "mirrored")):
            clip = mirrored(clip)
    with source.blaming((*place, "speed")):
        if cut.speed >= SPEEDS[0]:
            _check_length(clip.duration / cut.speed)
        clip = retimed(clip, cut.speed)
    if cut.loops > 1:
        with source.blaming((*place, "loops")):
            _check_length(clip.duration * cut.loops)
        with source.blaming((*place, "loops")):
            clip = looped(clip, cut.loops)
    return clip


def _check_length(duration: float) -> None:
    if duration > LONGEST:
        raise InvalidValue(
            f"The motion would last {duration:g} s; {LONGEST:g} s are the most. Trim it."
        )


def _joined(said: Performer, source: Source, place: Place) -> tuple[Clip, Character | None]:
    """All segments as one motion; with the body it is on, where they are of several skeletons."""
    clips = []
    for k, segment in enumerate(said.segment):
        where = (*place, "segment", k)
        clips.append(_cut(_read(segment, source, where), segment, source, where))
    body = None
    if not all(same_skeleton(clips[0].skeleton, clip.skeleton) for clip in clips[1:]):
        body = body_of(said, clips[0], source, place)
        for k, clip in enumerate(clips):
            with source.blaming((*place, "segment", k, "clip")):
                clips[k] = retargeted(clip.repaired(), body)
    whole, free = clips[0], 0.0
    for k, (clip, segment) in enumerate(zip(clips[1:], said.segment[1:], strict=True), 1):
        with source.blaming((*place, "segment", k)):
            following = said.segment[k + 1] if k + 1 < len(clips) else None
            whole, free = _appended(
                whole, clip, segment, free=free, before=clips[k - 1].name, following=following
            )
    return whole, body


def _appended(
    whole: Clip,
    clip: Clip,
    segment: Segment,
    *,
    free: float,
    before: str,
    following: Segment | None,
) -> tuple[Clip, float]:
    """A motion that goes over into another, and when that transition has ended [s].

    `free` is when the one before has [s]: no transition may begin earlier, or the segment `before`
    would never be seen.
    """
    if segment.blend == 0.0:
        return concatenated([whole, clip]), whole.duration
    last = whole.duration - segment.blend
    _check_room(whole, segment, free=free, before=before)
    time, start = segment.time, segment.start
    if time is None and start is None:
        left = _left_for(following)
        time, start = _found(whole, clip, segment.blend, free=free, left=left)
    elif time is None:
        time = max(last, 0.0)
    time, start = time or 0.0, start or 0.0
    try:
        joined = spliced(whole, clip, at=time, blend=segment.blend, start=start)
    except InvalidValue as error:  # what is "at" there is "time" in the file
        raise InvalidValue(re.sub(r"^at is", "time is", str(error))) from None
    return joined, time + segment.blend


def _check_room(whole: Clip, segment: Segment, *, free: float, before: str) -> None:
    """Refuse a transition out of a segment before the one into it has ended."""
    slack, last = 0.5 / whole.rate, whole.duration - segment.blend
    if free > 0.0 and last < free - slack:
        raise InvalidValue(
            f"Of {before!r}, the segment before, {max(whole.duration - free, 0.0):.2f} s are left "
            f"after the transition into it; blend is {segment.blend:g} s. Use more of that clip, "
            "or shorter blends."
        )
    if segment.time is not None and segment.time < free - slack:
        raise InvalidValue(
            f"time is {segment.time:g} s; the transition into the segment before lasts until "
            f"{free:.3f} s, so it must lie in {free:.3f} to {last:.3f} s."
        )


def _left_for(following: Segment | None) -> float:
    """How much of a segment a transition that is to be found after it needs [s]."""
    if following is None or following.time is not None or following.blend == 0.0:
        return 0.0
    return following.blend + ALONE


def _found(
    whole: Clip, clip: Clip, blend: float, *, free: float, left: float
) -> tuple[float, float]:
    """The best times to go over near the end of a motion, into the beginning of another [s].

    The first lies at `free` [s] or after it; after the blend, `left` [s] of the other clip remain,
    where it is that long.
    """
    last = max(whole.duration - blend, 0.0)
    earliest = free + ALONE if free > 0.0 else 0.0
    begin = min(max(last - min(NEAR, last / 3.0), earliest), last)
    begin = np.floor(begin * whole.rate + 1e-6) / whole.rate
    spare = max(clip.duration - blend, 0.0)
    early = min(NEAR, spare / 3.0, max(spare - left, 0.0))
    ending = trimmed(whole, float(begin))
    stop = np.ceil((blend + early) * clip.rate - 1e-6) / clip.rate
    beginning = trimmed(clip, 0.0, min(float(stop), clip.duration))
    # Two motions that are the same one would be searched for jumps back.
    beginning = replace(beginning, name=f"{beginning.name}, its beginning")
    best = transitions(ending, beginning, count=1, blend=blend)[0]
    time = whole.duration - ending.duration + best.time_a
    return min(max(time, free), last), best.time_b
