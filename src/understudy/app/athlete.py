"""`understudy athlete`: a motion that needs no clip."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, arg

from understudy.app.athlete_told import error_of, figures, notes, summary
from understudy.app.courses import course_from, numbers
from understudy.app.outcome import Outcome, plain
from understudy.app.performing import check_name, ready, staged
from understudy.app.reading import Reading, clip_from
from understudy.errors import InvalidValue

if TYPE_CHECKING:
    from understudy.athletics.course import Course
    from understudy.character import Athlete
    from understudy.control import Push
    from understudy.evaluate.gait import Gait
    from understudy.evaluate.measure import Measured
    from understudy.motion.clip import Clip
    from understudy.performance import Performance
    from understudy.take import Take

EXAMPLE = """\
  understudy athlete running --speed 3.5 --seconds 20 --out out
  understudy athlete running --speed 0:2.5,8:5,16:2.5 --seconds 20 --stills
  understudy athlete running --start standing --stop --speed 3.5 --seconds 12
  understudy athlete running --path track-400m --speed 4 --seconds 110
  understudy athlete running --heading 0:0,5:0,9.5:90 --push 12:0,70 --seconds 16
  understudy athlete running --runners 4 --character mixed --stills
  understudy athlete running --upper sample:gesture --seconds 8"""

# Runners side by side are this far apart, as lanes of a track are [m]; there are as many of those.
_LANE, _LANES = 1.22, 8
# Heights of several runners over the usual one.
_HEIGHTS = (1.0, 0.98, 1.02, 0.96, 1.03, 0.99, 0.97, 1.01)
# A gait is measured from then on [s], or from a third of a shorter run.
_SETTLED = 2.0


@dataclass(frozen=True, kw_only=True)
class Options:
    """Simulate an athlete that runs, with no clip: only a controller, a body and the ground.

    Writes NAME.bvh, NAME.glb (of several NAME_a.bvh, NAME_b.bvh and so on), NAME.take.npz,
    NAME.html (report), NAME_gait.html and NAME_gait.json (the run beside people and beside other
    motions) and NAME.json (what was measured).

    Attributes:
        behavior: running (Hodgins et al. 1995).
        speed: Meters per second, or TIME:SPEED,TIME:SPEED,... with straight lines in between; under
            1 m/s the athlete stands.
        seconds: How long.
        start: running, or standing for a second before the run.
        stop: End standing.
        heading: Facing direction in degrees, left positive; or TIME:DEGREES,...
        path: File of points to run along, a line of X Y in meters each; or track-400m.
        character: man, woman, or of several runners mixed: a man, a woman and so on.
        height: Stature in meters, by default the man's 1.75 or the woman's 1.65.
        mass: In kg, by default 70 or 58, and of another height in proportion.
        runners: How many, in lanes 1.22 m apart, each to the right of the one before. They differ
            in height by a few percent, so that they do not run in step.
        push: TIME:FORWARD,LEFT in N s at the chest of the first, in the world; may be given again.
        upper: Clip whose waist, neck and arms the runners show; a run's go with the stride.
        beside: Motion to show beside the run, such as a captured one; may be given up to 3 times.
        friction: Of the ground.
        timestep: Physics step [s].
        name: Stem of the files.
        out: Folder for the files.
        stills: Also NAME.png, a sheet of poses.
        video: Also NAME.mp4.
        json: Print one JSON object.
    """

    behavior: Positional[Annotated[Literal["running"], arg(metavar="BEHAVIOR")]]
    speed: Annotated[str, arg(metavar="V")] = "3.5"
    seconds: Annotated[float, arg(metavar="S")] = 20.0
    start: Literal["running", "standing"] = "running"
    stop: bool = False
    heading: Annotated[str, arg(metavar="DEG")] = "0"
    path: Annotated[str | None, arg(metavar="FILE", help_behavior_hint="(default: none)")] = None
    character: Literal["man", "woman", "mixed"] = "man"
    height: Annotated[float | None, arg(metavar="M", help_behavior_hint="(default: usual)")] = None
    mass: Annotated[float | None, arg(metavar="KG", help_behavior_hint="(default: usual)")] = None
    runners: Annotated[int, arg(metavar="N")] = 1
    push: Annotated[
        tuple[str, ...], arg(metavar="T:X,Y", help_behavior_hint="(default: none)")
    ] = ()
    upper: Annotated[str | None, arg(metavar="CLIP", help_behavior_hint="(default: none)")] = None
    beside: Annotated[
        tuple[str, ...], arg(metavar="CLIP", help_behavior_hint="(default: none)")
    ] = ()
    friction: Annotated[float, arg(metavar="MU")] = 1.0
    timestep: Annotated[float, arg(metavar="S")] = 0.001
    name: Annotated[str, arg(metavar="NAME")] = "running"
    out: Annotated[Path, arg(metavar="DIR")] = Path()
    stills: bool = False
    video: bool = False
    json: bool = False


def run(options: Options) -> Outcome:
    """Simulate, measure and write."""
    import understudy as us
    from understudy.evaluate.measure import measured
    from understudy.evaluate.running import MOST_BESIDE
    from understudy.performance import together, until

    if len(options.beside) > MOST_BESIDE:
        raise InvalidValue(f"--beside was given {len(options.beside)} files; at most 3 are shown.")
    check_name(options.name)
    ready(options.out)
    captured = [clip_from(word, Reading()) for word in options.beside]
    alone = _performances(options)
    found = [_judged(options, one) for one in alone]
    falls = [one["fell_at_s"] for one in found if one["fell_at_s"] is not None]
    performance = together(*alone) if len(alone) > 1 else alone[0]
    if falls:
        performance = until(performance, max(min(falls), performance.scene.timestep))
    take = us.simulate(performance, progress=True)
    measures = measured(take)
    for k, (one, runner) in enumerate(zip(found, alone, strict=True)):
        one |= _on_path(take, k, runner) | _beside_people(measures, k) | _layered(take, k)
        one["notes"] = _notes(options, one, runner, k)
    with staged(options.out, options.name) as (folder, files):
        _write(options, take, found, measures, captured, folder)
    result = (found[0] if len(found) == 1 else {"runners": found}) | {"files": files}
    return Outcome(
        result=result | error_of(found), text=summary(found, files), status=1 if falls else 0
    )


def _write(
    options: Options,
    take: Take,
    found: list[dict[str, Any]],
    measures: Measured,
    captured: list[Clip],
    folder: Path,
) -> None:
    """Every file of the run."""
    import understudy as us
    from understudy.running_report import write_running

    stem = folder / options.name
    several = len(found) > 1
    for k, one in enumerate(found):
        own = f"{stem}_{chr(ord('a') + k)}" if several else f"{stem}"
        us.write(take, f"{own}.bvh", f"{own}.glb", character=k)
        if one["hip_curve_correlation"] is not None:
            gait = _gait(measures, k)
            write_running(gait, f"{own}_gait.html", beside=captured)
            write_running(gait, f"{own}_gait.json", beside=captured)
    endings = [".take.npz", *[".png"] * options.stills, *[".mp4"] * options.video]
    us.write(take, *(f"{stem}{ending}" for ending in endings))
    us.write_report(take, f"{stem}.html")
    text = json.dumps(plain({"runners": found} if several else found[0]), indent=2)
    Path(f"{stem}.json").write_text(text + "\n", encoding="utf-8")


def _layered(take: Take, character: int) -> dict[str, Any]:
    """How well the clip on the upper body is followed; nothing without one."""
    from understudy.evaluate.layered import layered

    try:
        return {"upper": layered(take, character=character).as_dict()}
    except InvalidValue:
        return {}


def _performances(options: Options) -> list[Performance]:
    """Each runner alone."""
    from understudy.performance import running
    from understudy.scene import Ground

    if not 1 <= options.runners <= _LANES:
        raise InvalidValue(f"--runners is {options.runners}; it must be 1 to {_LANES}.")
    upper = None if options.upper is None else clip_from(options.upper, Reading())
    pushes = _pushes(options)
    course = asked_course(options)
    return [
        running(
            body,
            course.beside(_LANE * k) if k else course,
            duration=options.seconds,
            ground=Ground(friction=options.friction),
            timestep=options.timestep,
            upper=upper,
            disturbances=pushes if k == 0 else (),
        )
        for k, body in enumerate(_bodies(options))
    ]


def _pushes(options: Options) -> list[Push]:
    from understudy.control import Push

    out = []
    for word in options.push:
        time, forward, left = numbers("--push", word, "TIME:FORWARD,LEFT", 3)
        if not 0.0 <= time < options.seconds:
            raise InvalidValue(
                f"--push is {word!r}; its time must lie in the run of {options.seconds:g} s."
            )
        out.append(Push(time=time, impulse=(forward, left, 0.0)))
    return out


def asked_course(options: Options) -> Course:
    """Where the first runner is to go."""
    return course_from(
        speed=options.speed,
        heading=options.heading,
        path=options.path,
        seconds=options.seconds,
        standing=options.start == "standing",
        stop=options.stop,
    )


def _bodies(options: Options) -> list[Athlete]:
    """Who runs."""
    from understudy.character import athlete

    kinds = ("man", "woman") if options.character == "mixed" else (options.character,)
    out = []
    for k in range(options.runners):
        kind = kinds[k % len(kinds)]
        tall = athlete(kind).height if options.height is None else options.height
        out.append(athlete(kind, height=tall * _HEIGHTS[k], mass=options.mass))
    return out


def _judged(options: Options, performance: Performance) -> dict[str, Any]:
    """What a judge saw of one runner; runners in lanes do not touch, so each is seen alone."""
    from understudy.athletics.running import Running
    from understudy.athletics.running_judge import Judge, report
    from understudy.athletics.standing_judge import Recorder, Samples, start_and_stop
    from understudy.simulate.trials import judged

    (running, *_) = performance.controllers
    assert isinstance(running, Running)
    seen, _ = judged(performance, Judge(running=running))
    found = figures(options.behavior, performance.scene.characters[0], report(seen))
    if not running.course.stands:
        return found
    memory, _ = judged(performance, Recorder(running=running, seconds=performance.duration))
    samples = Samples.of(memory)
    if samples.fell and found["fell_at_s"] is None:
        found["fell_at_s"] = samples.seconds
    return found | start_and_stop(samples, running.course)


def _on_path(take: Take, character: int, alone: Performance) -> dict[str, Any]:
    """Of a runner on a path: speed along it and distance from it; the judge knows headings only."""
    (running, *_) = alone.controllers
    course: Course = running.course  # type: ignore[union-attr]
    if not len(course.path):
        return {}
    first = take.scene.parts[character].qpos.start
    places = take.qpos[:: take.stride(4.0), first : first + 2]
    length = sum(math.hypot(*step) for step in (places[1:] - places[:-1]).tolist())
    seconds = (len(places) - 1) * take.stride(4.0) / take.rate
    return {
        "mean_speed_m_s": length / seconds if seconds > 0.0 else None,
        "heading_rms_deg": None,
        "trunk_lean_deg": None,
        "off_path_most_m": float(course.away(places[: course.ended(places)]).max()),
    }


def _gait(measures: Measured, character: int) -> Gait:
    from understudy.evaluate.gait import gait_of

    start = min(_SETTLED, float(measures.times[-1]) / 3.0)
    return gait_of(measures, character=character, start=start)


def _beside_people(measures: Measured, character: int) -> dict[str, Any]:
    """How like people's its hip and knee curves are; None where no whole cycle was run."""
    from understudy.evaluate.running import likeness

    try:
        curves = likeness(_gait(measures, character)).curves
    except InvalidValue:
        return {"hip_curve_correlation": None, "knee_curve_correlation": None}
    return {f"{name}_curve_correlation": curves[name].correlation for name in ("hip", "knee")}


def _notes(options: Options, found: dict[str, Any], alone: Performance, number: int) -> list[str]:
    """What is to be said of one runner beside the figures."""
    (running, *_) = alone.controllers
    return notes(
        found,
        running.course,  # type: ignore[union-attr]
        options.seconds,
        pushes=_pushes(options) if number == 0 else (),
        friction=options.friction,
        upper=options.upper is not None,
    )
