"""What an edit file says, as frozen values: one class per table, one field per key."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from typing import Any, Literal

from understudy.character.bodies import BODIES
from understudy.character.body import SelfCollision
from understudy.control import GiveWay, Push, Task, Throw
from understudy.edit.source import Source, source
from understudy.edit.tables import made
from understudy.errors import InvalidValue, UnknownName
from understudy.motion.reaching import HandTarget, Meet
from understudy.motion.segments import MOST_LOOPS, check_blend
from understudy.performance import Performance
from understudy.scene import Contacts, Ground, Prop

OWN = "own"
FARTHEST = 1e4  # from the origin that a character can stand [m]
Side = Literal["left", "right"]


@dataclass(frozen=True, kw_only=True)
class Cut:
    """A clip, read and edited: trimmed, mirrored, retimed, looped, in this order.

    Attributes:
        clip: A motion file, relative to the edit file, or "sample:NAME".
        trim: From when to when it is used [s].
        mirrored: Whether left and right are exchanged.
        speed: How many times as fast it plays.
        loops: How often; the clip must end as it begins.
        up, unit, rate, t_pose, asf: How to read the file; see `understudy.read`.
    """

    clip: str | None = None
    trim: tuple[float, float] | None = None
    mirrored: bool = False
    speed: float = 1.0
    loops: int = 1
    up: Literal["x", "y", "z"] | None = None
    unit: float | str | None = None
    rate: float | None = None
    t_pose: Literal["auto", "keep", "drop"] = "auto"
    asf: str | None = None

    def __post_init__(self) -> None:
        if not 1 <= self.loops <= MOST_LOOPS:
            raise InvalidValue(f"loops is {self.loops}; it must lie in 1 to {MOST_LOOPS}.")
        if self.trim is not None and not self.trim[0] < self.trim[1]:
            raise InvalidValue(
                f"trim is {list(self.trim)}; it must be a start and a later end, as [1.0, 3.5], or "
                "[1.0, inf] up to the clip's end."
            )

    @property
    def reading(self) -> dict[str, object]:
        """What was said on how to read the file."""
        usual, said = Cut(), ("up", "unit", "rate", "t_pose", "asf")
        return {k: v for k in said if (v := getattr(self, k)) != getattr(usual, k)}


@dataclass(frozen=True, kw_only=True)
class Segment(Cut):
    """One of several clips in a row.

    Attributes:
        time: When the transition into it begins, in the motion so far [s]; found where left out.
        start: Its own time then [s]; found where `time` is left out too, otherwise 0.
        blend: How long the transition lasts [s]; 0 puts it end to end, for clips that share a pose.
    """

    time: float | None = None
    start: float | None = None
    blend: float = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.clip is None:
            raise InvalidValue('A segment needs a clip, as clip = "walk.bvh" or "sample:walk".')
        if self.blend == 0.0:
            if self.time is not None or self.start is not None:
                raise InvalidValue(
                    "blend is 0, which puts segments end to end; leave out time and start, and "
                    "use trim."
                )
        else:
            check_blend(self.blend)


@dataclass(frozen=True, kw_only=True)
class Offset:
    """A hand at a place at a time, by inverse kinematics before the simulation.

    Attributes:
        hand: "left" or "right".
        time: When, in the motion before the character's speed [s].
        position: Where the middle of the palm shall be [m], world, 3 numbers.
        window: Performed time on either side over which the offset comes and goes [s].
    """

    hand: Side = "right"
    time: float
    position: tuple[float, float, float]
    window: float = 0.3

    def __post_init__(self) -> None:
        self.target(1.0)

    def target(self, speed: float) -> HandTarget:
        """The target in a motion played so many times as fast."""
        joint = f"{self.hand}_wrist"
        return HandTarget(
            time=self.time / speed, joint=joint, position=self.position, window=self.window
        )


@dataclass(frozen=True, kw_only=True)
class Meeting:
    """Two hands of two characters that come together.

    Attributes:
        time: When, in the motions before the characters' speed [s].
        characters: Which two, counted from 1 in the order of the file.
        hands: The first one's hand and the second's.
        window: Performed time on either side over which the offsets come and go [s].
        position: Where [m], world, 3 numbers; halfway between the hands where left out.
        apart: Distance left between the two palms' middles [m].
    """

    time: float
    characters: tuple[int, int] = (1, 2)
    hands: tuple[Side, Side] = ("right", "left")
    window: float = 0.3
    position: tuple[float, float, float] | None = None
    apart: float = 0.005

    def __post_init__(self) -> None:
        if self.characters[0] == self.characters[1]:
            raise InvalidValue(
                f"characters is {list(self.characters)}; it must be two different ones."
            )
        self.meet(1.0)

    def meet(self, speed: float) -> Meet:
        """The meeting in motions played so many times as fast."""
        first, second = (f"{hand}_wrist" for hand in self.hands)
        return Meet(
            time=self.time / speed,
            hands=(first, second),
            window=self.window,
            position=self.position,
            apart=self.apart,
        )


@dataclass(frozen=True, kw_only=True)
class Performer(Cut):
    """A character and its motion: one clip, or segments in a row.

    Attributes:
        segment: Clips in a row, in place of `clip`; trim, mirrored, speed and loops then act on
            the whole.
        body: "own" (the bones of the clip) or a ready-made one.
        plan, sex, mass, height, mapping: As for `Character.from_clip`; [kg], [m], a file.
        at: Where the first frame's root stands over the ground [m], 2 numbers.
        heading: By how much the motion is turned there, counterclockwise from above [rad].
        pelvis: "led", "assisted" or "free"; see `tracked`.
        law, stiffness, torque_limits: See `Tracking`.
        offset: Hands at places.
        task: What to do besides the clip.
    """

    segment: tuple[Segment, ...] = ()
    body: str = OWN
    plan: Literal["full", "full16", "upper", "upper8"] = "full"
    sex: Literal["female", "male"] | None = None
    mass: float | None = None
    height: float | None = None
    mapping: str | None = None
    at: tuple[float, float] | None = None
    heading: float = 0.0
    pelvis: Literal["led", "assisted", "free"] | None = None
    law: Literal["modern", "paper"] = "modern"
    stiffness: float | None = None
    torque_limits: Literal["off", "human"] = "off"
    offset: tuple[Offset, ...] = ()
    task: tuple[Task, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.clip is None) == (not self.segment):
            raise InvalidValue(
                'A character needs one of a clip, as clip = "walk.bvh" or "sample:walk", and '
                "[[character.segment]] tables."
            )
        if self.segment and self.reading:
            raise InvalidValue(
                f"{next(iter(self.reading))} is about reading a file; give it to the segments."
            )
        if self.at is not None and max(map(abs, self.at)) > FARTHEST:
            raise InvalidValue(
                f"at is {list(self.at)}; it must be 2 numbers from {-FARTHEST:g} to {FARTHEST:g} m."
            )
        if self.body != OWN and self.body not in BODIES:
            raise UnknownName("body", self.body, (OWN, *BODIES))
        for name in ("sex", "mapping"):
            if self.body != OWN and getattr(self, name) is not None:
                raise InvalidValue(f'{name} is for body = "own"; {self.body!r} has its own.')

    @property
    def settings(self) -> dict[str, Any]:
        """Keywords of `tracked`."""
        found: dict[str, Any] = {"law": self.law, "torque_limits": self.torque_limits}
        if self.stiffness is not None:
            found["stiffness"] = self.stiffness
        return found


@dataclass(frozen=True, kw_only=True)
class Edit:
    """What an edit file says.

    Attributes:
        title: What it is, for people.
        seed: Seed of the performance.
        timestep: Physics step [s]; by default the one nearest 2 ms that divides the frame period.
        duration: Simulated time [s]; by default the longest motion's. Longer holds the last pose.
        self_collision: See `Scene`.
        contacts: What touches besides the ground; see `Scene`.
        ground: The floor; level where left out.
        character: Who performs.
        meet: Hands that come together.
        prop: Things in the scene.
        push, throw: What happens to them; times are performed ones.
        give_way: How every character gives way to what hits it; None where it does not.
        source: The file, for errors that name a line.
    """

    title: str = ""
    seed: int = 0
    timestep: float | None = None
    duration: float | None = None
    self_collision: SelfCollision = "off"
    contacts: Contacts = ()
    ground: Ground | None = None
    character: tuple[Performer, ...]
    meet: tuple[Meeting, ...] = ()
    prop: tuple[Prop, ...] = ()
    push: tuple[Push, ...] = ()
    throw: tuple[Throw, ...] = ()
    give_way: GiveWay | None = None
    source: Source = field(repr=False, compare=False)

    def __post_init__(self) -> None:
        if not 1 <= len(self.character) <= 24:
            count = f"{len(self.character)} times [[character]]; it must be 1 to 24."
            raise self.source.error(("character",), count)
        if self.seed < 0:
            raise InvalidValue(f"seed is {self.seed}; it must be zero or positive.")
        if self.duration is not None and not self.duration > 0.0:
            raise InvalidValue(f"duration is {self.duration:g} s; it must be positive.")
        for k, meeting in enumerate(self.meet):
            self._check_meeting(k, meeting)
        thrown = [throw.ball for throw in self.throw]
        for k, ball in enumerate(thrown):
            if ball in thrown[:k]:
                again = f"{ball!r} is thrown twice; a ball is thrown once: add another [[prop]]."
                raise self.source.error(("throw", k, "ball"), again)
        names = [getattr(prop, "name", "") for prop in self.prop]
        for k, name in enumerate(names):
            if name in names[:k]:
                raise self.source.error(
                    ("prop", k, "name"),
                    f'Two props are named {name!r}; give one another name, as name = "{name}_2".',
                )

    def _check_meeting(self, number: int, meeting: Meeting) -> None:
        """Refuse characters that are not there, or that do not keep time with each other."""
        place = ("meet", number, "characters")
        for who in meeting.characters:
            if not 1 <= who <= len(self.character):
                raise self.source.error(
                    place,
                    f"characters is {list(meeting.characters)}; this file has "
                    f"{len(self.character)}, counted from 1.",
                )
        one, two = (self.character[who - 1].speed for who in meeting.characters)
        if one != two:
            raise self.source.error(
                place,
                f"The two play at speed {one:g} and {two:g}; hands meet where speeds are alike.",
            )

    def performance(self) -> Performance:
        """The performance that the file describes; nothing is simulated yet.

        Raises:
            EditError: A clip that cannot be read, a target out of reach, a joint that a body lacks,
                two tasks on one joint, a name that is of nothing; names the line.
        """
        from understudy.edit.staging import staged

        return staged(self)


def read_edit(path: str | PathLike[str]) -> Edit:
    """Read an edit file (docs/edit_file.md): a performance described in TOML.

    Raises:
        EditError: One line with the file, the line, what was wrong and what would be right.
    """
    return edit_of(source(path))


def edit_of(said: Source) -> Edit:
    """The edit that a source holds; raises as `read_edit`."""
    return made(Edit, said, said.data, (), source=said)
