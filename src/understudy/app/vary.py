"""`understudy vary`: one clip in, a family of varied, physically simulated motions out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from tyro.conf import Positional, UseAppendAction, arg

from understudy.app.body import Body, character_for, check_body
from understudy.app.outcome import Interrupted, Outcome, table
from understudy.app.reading import Reading, clip_from, stem
from understudy.errors import InvalidValue

if TYPE_CHECKING:
    from understudy.family import Family
    from understudy.motion.clip import Clip
    from understudy.performance import Performance
    from understudy.variations import Variation

EXAMPLE = """\
  understudy vary sample:walk --count 12 --seed 7
  understudy vary walk.bvh --preset zombie,tired --count 40 --grip 0.3 --out undead
  understudy vary kick.bvh --scale right_knee=1.0:1.4@2:6 --mass right_foot=1:3 --count 20"""

_SHOWN = 24
_Many = tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Options(Body, Reading):
    """Make a family of varied, physically simulated motions from one clip.

    Members take the presets in turn (all of them when nothing is asked for); every other option
    changes every member. LO:HI is a range, drawn evenly in ratio; one number is fixed. Names are
    joints, links, or limbs: left_arm, right_leg, left, arms, legs, back, upper_body, body.

    --grip, the strength slider, trades tracking against the generative effect. At 1 stiff servos
    hold the body to the clip and undo most of what a change does elsewhere; toward 0 the effects
    spread through the body and the motion strays from the clip.

    In DIR: family.html (browse side by side), family.png (contact sheet), family.csv and
    family.json (figures; change of force and torque by joint), members/NNN_KIND.bvh, .glb, .json.
    Members that fall or diverge are flagged and kept. The same command again keeps what is done.

    Attributes:
        clip: A motion file, or sample:NAME.
        count: How many members.
        seed: Seed of all draws; member i depends on the seed and i alone.
        preset: stronger_left, tired, limp_right_arm, heavy_boots, zombie or injured_leg; a comma
            between several.
        scale: Motion of a joint, over all or from T0 to T1 seconds.
        mass: Mass of a link, as a factor; a bare number is the whole body's mass [kg].
        length: Length of a link, as a factor.
        strength: Torque a joint gives, as a factor; 0 is limp.
        limp: Joints without any servo.
        lock: Joints held at one angle: straight (usual), mean or start.
        speed: Of the whole motion.
        grip: 0 to 1, or a range.
        linkage: Rigid bodies driven along the clip, as in Wilke & Semwal 2017, in place of a
            character: independent, skeleton, constrained or tree.
        pelvis: led along its path, assisted softly (usual), or free.
        torque_limits: Bound every joint by human strength, or not.
        out: Folder for the files.
        jobs: Threads.
        json: Print one JSON object.
    """

    clip: Positional[Annotated[str, arg(metavar="CLIP")]]
    count: Annotated[int, arg(metavar="N")] = 100
    seed: int = 0
    preset: UseAppendAction[Annotated[_Many, arg(metavar="NAME")]] = ()
    scale: UseAppendAction[Annotated[_Many, arg(metavar="JOINT=LO:HI[@T0:T1]")]] = ()
    mass: UseAppendAction[Annotated[_Many, arg(metavar="LINK=LO:HI|KG")]] = ()  # type: ignore[assignment]
    length: UseAppendAction[Annotated[_Many, arg(metavar="LINK=LO:HI")]] = ()
    strength: UseAppendAction[Annotated[_Many, arg(metavar="JOINT=LO:HI")]] = ()
    limp: UseAppendAction[Annotated[_Many, arg(metavar="LIMB")]] = ()
    lock: UseAppendAction[Annotated[_Many, arg(metavar="JOINT[=HOW]")]] = ()
    speed: Annotated[str | None, arg(metavar="LO:HI", help_behavior_hint="(default: 1)")] = None
    grip: Annotated[str, arg(metavar="G", aliases=("--strength-slider",))] = "0.5"
    linkage: Annotated[
        Literal["independent", "skeleton", "constrained", "tree"] | None,
        arg(
            metavar="{independent,skeleton,constrained,tree}",
            help_behavior_hint="(default: a character)",
        ),
    ] = None
    pelvis: Annotated[
        Literal["led", "assisted", "free"] | None,
        arg(metavar="{led,assisted,free}", help_behavior_hint="(default: by the body's legs)"),
    ] = None
    torque_limits: Literal["off", "human"] = "off"
    out: Annotated[Path | None, arg(metavar="DIR", help_behavior_hint="(default: NAME_family)")] = (
        None
    )
    jobs: Annotated[int | None, arg(metavar="N", help_behavior_hint="(default: one per core)")] = (
        None
    )
    json: bool = False


def run(options: Options) -> Outcome:
    """Make the family, or go on with it."""
    import understudy as us

    common = asked(options)
    presets = [name for word in options.preset for name in word.split(",")]
    grip = amount("--grip", options.grip)
    body = body_asked(options)
    check_linkage(options, body)
    check_body(body)
    clip = clip_from(options.clip, options)
    performance = performance_of(clip, body, options)
    out = options.out or Path(f"{stem(options.clip)}_family")
    try:
        made = us.family(
            performance,
            options.count,
            seed=options.seed,
            variations=presets or None,
            common=common,
            grip=grip,
            out=out,
            jobs=options.jobs,
            progress=True,
        )
    except KeyboardInterrupt as stop:
        raise stopped(stop, out, options.count) from stop
    diverged = sum("diverged" in member.flags for member in made.members)
    return Outcome(result=result(made), text=text(made), status=1 if diverged else 0)


def stopped(stop: KeyboardInterrupt, out: Path, count: int) -> Interrupted:
    """The interrupt with how many members are finished: a member's JSON is written last."""
    written = [path.name.partition("_")[0] for path in (out / "members").glob("*_*.json")]
    finished = sum(index.isdigit() and int(index) < count for index in written)
    return Interrupted(
        result={"count": count, "finished": finished},
        status=getattr(stop, "status", Interrupted().status),
        kept=f"{finished} of {count} members are finished and kept; the same command goes on",
    )


def performance_of(clip: Clip, body: Body, options: Options) -> Performance:
    """The performance to vary: a character that tracks the clip, or a linkage driven along it."""
    import understudy as us

    if options.linkage is not None:
        from understudy.performance import driven

        return driven(clip, us.Linkage.from_clip(clip, options.linkage))
    return us.tracked(
        clip,
        character_for(clip, body),
        pelvis=options.pelvis,
        torque_limits=options.torque_limits,
    )


def check_linkage(options: Options, body: Body) -> None:
    """Refuse options that would do nothing on a linkage, before any clip is read.

    Raises:
        InvalidValue: Names them.
    """
    if options.linkage is None:
        return
    usual = Body()
    idle = [
        name for name in Body.__dataclass_fields__ if getattr(body, name) != getattr(usual, name)
    ]
    idle += ["pelvis"] * (options.pelvis is not None)
    idle += ["torque_limits"] * (options.torque_limits != "off")
    if idle:
        words = ", ".join(f"--{name.replace('_', '-')}" for name in idle)
        raise InvalidValue(
            f"{words}: for characters only; --linkage takes the bones of the clip, bodies of 1 kg "
            "and a drive."
        )


def body_asked(options: Options) -> Body:
    """Who performs; `--mass` without a name is the body's."""
    given = {name: getattr(options, name) for name in Body.__dataclass_fields__}
    bare = [word for word in options.mass if "=" not in word]
    if len(bare) > 1:
        raise InvalidValue("--mass: give the body's mass once; a link's as LINK=LO:HI.")
    whole = amount("--mass", bare[0]) if bare else None
    if isinstance(whole, tuple):
        raise InvalidValue("--mass: the body's mass is one number; a link's is LINK=LO:HI.")
    return Body(**{**given, "mass": whole})


def asked(options: Options) -> list[Variation]:
    """The variations of every member, from the options.

    Raises:
        InvalidValue: A word that is none; the text gives its form.
    """
    from understudy.variations import Length, Limp, Lock, Mass, Scaling, Speed, Strength

    out: list[Variation] = []
    for word in options.length:
        name, by = _named("--length", word)
        out.append(Length(link=name, by=amount("--length", by)))
    for word in options.scale:
        name, rest = _named("--scale", word)
        by, _, when = rest.partition("@")
        start, end = _times(when)
        out.append(Scaling(joint=name, by=amount("--scale", by), start=start, end=end))
    for word in (word for word in options.mass if "=" in word):
        name, by = _named("--mass", word)
        out.append(Mass(link=name, by=amount("--mass", by)))
    for word in options.strength:
        name, by = _named("--strength", word)
        out.append(Strength(joint=name, by=amount("--strength", by)))
    out += [Limp(joint=name) for word in options.limp for name in word.split(",")]
    for word in options.lock:
        for part in word.split(","):
            name, _, how = part.partition("=")
            out.append(Lock(joint=name, at=how or "straight"))  # type: ignore[arg-type]
    if options.speed is not None:
        out.append(Speed(by=amount("--speed", options.speed)))
    return out


def amount(option: str, word: str) -> float | tuple[float, float]:
    """A number, or a range LO:HI."""
    try:
        numbers = [float(part) for part in word.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2) or not all(math.isfinite(n) for n in numbers):
        raise InvalidValue(f"{option}: {word!r} is neither a number nor a range LO:HI.")
    return numbers[0] if len(numbers) == 1 else (numbers[0], numbers[1])


def _named(option: str, word: str) -> tuple[str, str]:
    name, equals, rest = word.partition("=")
    if not (name and equals and rest):
        raise InvalidValue(f"{option}: {word!r} has no value; write {option} NAME=LO:HI.")
    return name, rest


def _times(word: str) -> tuple[float | None, float | None]:
    if not word:
        return None, None
    span = amount("--scale", word)
    if not isinstance(span, tuple):
        raise InvalidValue(f"--scale: {word!r} is no time range; write @T0:T1 in seconds.")
    return span


def result(made: Family) -> dict[str, Any]:
    """What `--json` prints."""
    from understudy.family.table import UNITS, row

    return {
        "clip": made.name,
        "count": len(made.members),
        "reused": made.reused,
        "flags": made.flagged(),
        "unvaried": row(made.unvaried),
        "members": [row(member) for member in made.members],
        "units": UNITS,
        "files": [str(path) for path in overview(made)],
    }


def overview(made: Family) -> list[Path]:
    """The files about the whole family that exist."""
    assert made.folder is not None
    names = ("family.html", "family.png", "family.csv", "family.json")
    return [made.folder / name for name in names if (made.folder / name).exists()]


def text(made: Family) -> str:
    """The table of the members, what was flagged, and where the files are."""
    from understudy.family.table import row

    head = ("member", "away mm", "torque x", "help %", "most changed", "flags")
    shown = made.members[:_SHOWN]
    rows = [
        (
            member.name,
            f"{member.away_mm:.0f}",
            "-" if (ratio := member.total["torque_ratio"]) is None else f"{ratio:.2f}",
            "-" if (held := row(member)["help_percent"]) is None else f"{held:.0f}",
            member.total["most_changed"],
            ", ".join(member.flags),
        )
        for member in (made.unvaried, *shown)
    ]
    lines = [table([head, *rows], right=(1, 2, 3))]
    if len(shown) < len(made.members):
        lines.append(f"... and {len(made.members) - len(shown)} more in family.csv.")
    counts = [f"{n} {flag}" for flag, n in made.flagged().items() if n]
    flags = f"{', '.join(counts)} (kept)" if counts else "none"
    kept = f"; {made.reused} were there before" if made.reused else ""
    helped = any(row(member)["help_percent"] is not None for member in made.members)
    lines += [
        "",
        "away: mean distance of joints from the unvaried motion; torque x: root mean square over",
        "unvaried; help: outside force on the pelvis, % of body weight." if helped else "unvaried.",
        *sorted({note for member in made.members for note in member.notes}),
        "",
        f"{len(made.members)} members{kept}; flagged: {flags}.",
        "files:",
        *(f"  {path}" for path in overview(made)),
        f"  {made.folder}/members/NNN_KIND{{.bvh,.glb,.json}}",
    ]
    return "\n".join(lines)
