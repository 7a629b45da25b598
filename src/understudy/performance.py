"""One reproducible run: a scene, its controllers, how long, and the seed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from numbers import Real
from typing import Any, cast

import numpy as np

from understudy.athletics.course import Course
from understudy.athletics.gains import Schedule, shipped
from understudy.athletics.running import TIMESTEP, Running
from understudy.athletics.upper import UpperBody
from understudy.character import Athlete, Character, Linkage, athlete_man, retargeted
from understudy.character.body import SelfCollision
from understudy.character.build import size_doubts
from understudy.character.leaning import leaning
from understudy.character.planting import planted
from understudy.character.soles import standing
from understudy.control import Controller, Disturbance, Drive, GiveWay, Task, Tracking
from understudy.control.disturbance import check_throws, check_times
from understudy.control.supported import supported
from understudy.control.task import check_overlaps
from understudy.errors import InvalidValue, UnknownName, expect, shown
from understudy.motion.clip import Clip
from understudy.scene import Contacts, Ground, Prop, Scene, timestep_for
from understudy.scene.survey import surveyed

# Wilke & Semwal 2017 drop 9.81 units per second squared on figures about 24 units tall.
PAPER_GRAVITY = 9.81
# Steps per second at which the modern drive runs, or the next multiple of the clip's rate.
DRIVE_RATE = 240.0

# Physics of a free body: soft servos and an integrator that takes their stiffness implicitly stand
# long steps, and a search costs as much as it has steps.
FREE_STEP = 1.0 / 120.0
FREE: dict[str, Any] = {"integrator": "discrete", "servos": "soft", "torque_limits": "human"}


@dataclass(frozen=True, kw_only=True)
class Performance:
    """Everything needed to reproduce a take, and no results.

    Attributes:
        scene: Where it happens.
        controllers: What drives it; feedback controllers act in this order.
        duration: Simulated time [s].
        seed: Seed of every random choice; the same seed gives the same take, bit for bit.
    """

    scene: Scene
    controllers: tuple[Controller, ...] = ()
    duration: float
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "controllers", tuple(self.controllers))
        expect(self.scene, Scene, "scene", "a Scene")
        if not (isinstance(self.duration, Real) and 0 <= self.duration < np.inf):
            raise InvalidValue(f"duration is {self.duration!s:.40} s; it must be zero or positive.")
        numbers = self.steps * (self.scene.model.nq + self.scene.model.nv + self.scene.model.nu)
        check_overlaps(self.controllers)
        check_throws(self.controllers)
        check_times(self.controllers, self.duration)
        _check_pelvis(self.controllers)
        if numbers > 1_000_000_000:
            raise InvalidValue(
                f"duration is {self.duration} s: {numbers * 8 / 1e9:.0f} GB of states; "
                "trim the clip or use a longer timestep."
            )

    @property
    def steps(self) -> int:
        """Number of physics steps."""
        return round(self.duration / self.scene.timestep)


def until(performance: Performance, duration: float) -> Performance:
    """The performance up to a time [s], without the pushes and throws that come later."""
    return replace(
        performance,
        controllers=tuple(
            one
            for one in performance.controllers
            if not (isinstance(one, Disturbance) and one.begins >= duration)
        ),
        duration=duration,
    )


def _check_pelvis(controllers: Iterable[Controller]) -> None:
    """Refuse to lead the pelvis of a body that is to balance by itself.

    Raises:
        InvalidValue: Says so.
    """
    led = {c.character for c in controllers if isinstance(c, Tracking) and c.pelvis == "led"}
    for task in controllers:
        if isinstance(task, Task) and task.pelvis == "free" and task.character in led:
            raise InvalidValue(
                f"{task.kind}: pelvis is 'led', which holds the body up; leave pelvis out, or make "
                "it 'free' or 'assisted'."
            )


def tracked(
    clip: Clip,
    character: Character,
    *,
    pelvis: str | None = None,
    tasks: Sequence[Task | Disturbance] = (),
    props: Sequence[Prop] = (),
    contacts: Contacts = (),
    ground: Ground | None = None,
    timestep: float | None = None,
    integrator: str | None = None,
    self_collision: SelfCollision = "off",
    seed: int = 0,
    **settings: object,
) -> Performance:
    """The performance of a character tracking a clip, and doing more than the clip shows.

    Glitches of the clip are repaired, its joint angles carried over to the character and its feet
    set on the ground; a servo then follows it (see `Tracking`). Tasks replace what some joints do.

    Args:
        clip: Any clip.
        character: Any character.
        pelvis: "led", "assisted" or "free"; by default free for a body that balances, led for one
            without legs, else assisted.
        tasks: What to do besides following the clip (`Upright`, `Balance`, `Reach`, ...), and what
            happens to the body (`Push`, `Throw`).
        props: Things in the scene: a drum, a staff in a hand.
        contacts: What touches besides the ground; see `Scene`.
        ground: The floor; by default read off the clip for a body with feet (see `surveyed`; level
            unless the feet say otherwise), none without.
        timestep: Physics step [s]; by default the one nearest 2 ms that divides the frame period.
        integrator: See `Scene`.
        self_collision: See `Scene`.
        seed: Seed of the performance.
        settings: Passed on to `Tracking`: law, stiffness, torque_limits, ...
    """
    expect(clip, Clip, "clip", "a Clip, as `read` gives")
    expect(character, Character, "character", "a Character, as `Character.from_clip` gives")
    if isinstance(character, Athlete):
        raise InvalidValue(
            f"{character.name!r} has hinges with motors; a clip is tracked by a body with ball "
            "joints, such as adult_man()."
        )
    _check_names(tracked, Tracking, settings)
    clean = clip.repaired()
    reference = retargeted(clean, character)
    feet = any((link.role or "").endswith("_ankle") for link in character.links)
    floor = own = None
    if ground is None and feet:
        ground, note = surveyed(reference, character)
        reference = reference.noted(note) if note else reference
        own = None if ground.level else ground
    elif ground is not None and not ground.level:
        floor = ground
    reference = standing(reference, character, ground=floor, own=own)
    reference = leaning(reference, character, ground=own or floor)
    reference = planted(reference, character, ground=own or floor)
    doubts = [note for note in size_doubts(character.height) if note in character.notes]
    if doubts:
        reference = reference.noted(*doubts)
    if ground is not None:
        reference = supported(reference, character, ground)
    fitted: list[Task | Disturbance] = []
    for task in tasks:
        expect(task, (Task, Disturbance), "task", "a task such as Upright, or a Push or Throw")
        made, reference = task.fitted(reference, character)
        fitted.append(made)
    scene = Scene(
        characters=(character,),
        ground=ground,
        props=tuple(props),
        contacts=contacts,
        timestep=timestep_for(reference.rate) if timestep is None else timestep,
        self_collision=self_collision,
        integrator=integrator,  # type: ignore[arg-type]
    )
    if pelvis is None:
        pelvis = next((t.pelvis for t in tasks if t.pelvis), "assisted" if feet else "led")
    tracking = Tracking(
        reference=reference,
        captured=clip.noted(*clean.notes[len(clip.notes) :]),
        pelvis=pelvis,
        **settings,  # type: ignore[arg-type]
    )
    return Performance(
        scene=scene,
        controllers=(tracking, *fitted),
        duration=reference.duration,
        seed=seed,
    )


def running(
    athlete: Athlete | None = None,
    course: Course | None = None,
    *,
    duration: float,
    schedule: Schedule | None = None,
    ground: Ground | None = None,
    timestep: float = TIMESTEP,
    upper: Clip | UpperBody | None = None,
    disturbances: Sequence[Disturbance] = (),
) -> Performance:
    """The performance of one athlete running.

    Args:
        athlete: Who; a man by default.
        course: Where to and how fast; 3.5 m/s straight on by default.
        duration: [s].
        schedule: Gains; by default those that come with the package.
        ground: By default level.
        timestep: [s].
        upper: A clip whose waist, neck and arms the runner shows; one of running is locked to the
            stride, another begins after half a second (`UpperBody` says otherwise).
        disturbances: Pushes.
    """
    body = athlete_man() if athlete is None else athlete
    expect(body, Athlete, "athlete", "an Athlete, as `athlete_man` gives")
    scene = Scene(
        characters=(body,), ground=Ground() if ground is None else ground, timestep=timestep
    )
    controller = Running(
        course=Course() if course is None else course,
        schedule=shipped() if schedule is None else schedule,
    )
    layers = () if upper is None else (UpperBody(clip=upper) if isinstance(upper, Clip) else upper,)
    expect(upper, (Clip, UpperBody, type(None)), "upper", "a Clip or an UpperBody")
    return Performance(
        scene=scene, controllers=(controller, *layers, *disturbances), duration=duration
    )


def together(
    *performances: Performance,
    props: Sequence[Prop] = (),
    contacts: Contacts = (),
    tasks: Sequence[Task | Disturbance] = (),
    seed: int | None = None,
) -> Performance:
    """Several performances as one: all characters in one scene, each with its own controllers.

    The characters stand where their clips are (`Clip.placed` moves one), runners where their
    courses begin (`Course.beside` is the next lane). The scene lasts as long as the longest
    performance; who has finished holds the last pose. Names in the scene: the first character's as
    they are, the second's with "b/" before them, the third's with "c/".

    Args:
        performances: Two or more, made alone, with the same time step, gravity and ground.
        props: Things in the scene besides those the performances bring.
        contacts: What touches besides the ground and the performances' own; see `Scene`. Such as
            (("right_hand", "b/left_hand"),).
        tasks: Tasks and disturbances besides the performances' own; `character` counts all of them.
        seed: Seed of the whole; by default the first one's.

    Raises:
        InvalidValue: Performances that do not fit together; says which value differs.
    """
    if len(performances) < 2:
        raise InvalidValue(f"together was given {len(performances)} performances; it needs two.")
    for one in performances:
        expect(one, Performance, "performance", "a Performance, as `tracked` gives")
    scenes = [one.scene for one in performances]
    for name in ("timestep", "gravity", "ground", "self_collision", "integrator"):
        values = [getattr(scene, name) for scene in scenes]
        if any(value != values[0] for value in values):
            other = next(value for value in values if value != values[0])
            raise InvalidValue(
                f"The performances differ in {name}: {values[0]} and {other}. Make them alike, "
                "for instance with clip.resampled, or timestep= when they are made."
            )
    controllers: list[Controller] = []
    every: list[Prop] = []
    touching: list[tuple[str, str]] = []
    first = 0
    for one in performances:
        for controller in one.controllers:
            who: Any = getattr(controller, "character", None)
            if who is not None and first > 0:
                controller = replace(cast(Any, controller), character=who + first)
            controllers.append(controller)
        shifted = _renamed(one.scene, first)
        every += shifted[0]
        touching += shifted[1]
        first += len(one.scene.characters)
    all_touch = contacts == "all" or any(scene.contacts == "all" for scene in scenes)
    return Performance(
        scene=replace(
            scenes[0],
            characters=tuple(body for scene in scenes for body in scene.characters),
            props=(*every, *props),
            contacts="all" if all_touch else (*touching, *(() if contacts == "all" else contacts)),
        ),
        controllers=(*controllers, *tasks),  # type: ignore[arg-type]
        duration=max(one.duration for one in performances),
        seed=performances[0].seed if seed is None else seed,
    )


def _renamed(scene: Scene, first: int) -> tuple[list[Prop], list[tuple[str, str]]]:
    """Props and contacts of a scene whose characters become number `first` and following."""
    if first == 0:
        return list(scene.props), [] if scene.contacts == "all" else list(scene.contacts)
    names = {getattr(prop, "name", "") for prop in scene.props}
    links = {link.name for link in scene.characters[0].links}

    def moved(name: str) -> str:
        if name in names:
            return name
        old, _, own = name.rpartition("/")
        number = first + (ord(old) - ord("a") if old else 0)
        return f"{chr(ord('a') + number)}/{own}" if old or own in links else name

    props: list[Prop] = []
    for prop in scene.props:
        holder = getattr(prop, "held_by", None)
        props.append(replace(cast(Any, prop), held_by=moved(holder)) if holder else prop)
    pairs = [] if scene.contacts == "all" else [(moved(a), moved(b)) for a, b in scene.contacts]
    return props, pairs


def driven(
    clip: Clip,
    linkage: Linkage,
    *,
    law: str = "modern",
    rate: float | None = None,
    gravity: float | None = None,
    scale: float = 1.0,
    substeps: int | None = None,
    tasks: Sequence[Disturbance | GiveWay] = (),
    props: Sequence[Prop] = (),
    contacts: Contacts = (),
    ground: Ground | None = None,
    duration: float | None = None,
    seed: int = 0,
    **settings: object,
) -> Performance:
    """The performance of rigid bodies driven along a clip (see `Drive`).

    Under the modern law glitches of the clip are repaired first, because a bone that turns over in
    one frame tears any joint open; the paper's law takes the clip as it is.

    Args:
        clip: The clip, on the linkage's skeleton.
        linkage: See `Linkage.from_clip`.
        law: "modern", or "paper" for exactly the published law.
        rate: Frames per second to resample the clip to [Hz]; by default it keeps its own.
        gravity: Downward acceleration [m/s^2]; by default 9.81 for the modern law, and 9.81 of the
            linkage's units per second squared for the paper's.
        scale: Size of the paper's simulated model over the clip's. A model twice as large under the
            same gravity moves as this one under half of it, and so it is done.
        substeps: Physics steps per frame; by default one for the paper's law, otherwise so many
            that a step lasts at most 1/240 s.
        tasks: What happens to the bodies (`Push`, `Throw`), and `GiveWay`, under which the drive's
            own strength falls and recovers.
        props: Things in the scene.
        contacts: What touches besides the ground; see `Scene`.
        ground: A floor, for linkages with contact; none by default.
        duration: Simulated time [s]; by default the clip's.
        seed: Seed of the performance.
        settings: Passed on to `Drive`: gain, order, velocity_scale, scaling, strength, ...

    Raises:
        InvalidValue: A value out of range, or gains too large for the time step (K_f dt >= 2).
    """
    expect(clip, Clip, "clip", "a Clip, as `read` gives")
    _check_names(driven, Drive, settings)
    if not (np.isfinite(scale) and scale > 0):
        raise InvalidValue(f"scale is {scale}; it must be a positive number.")
    if gravity is None:
        gravity = PAPER_GRAVITY * linkage.unit if law == "paper" else 9.81
    reference = clip.repaired() if law == "modern" else clip
    captured = clip.noted(*reference.notes[len(clip.notes) :])
    if rate is not None:
        reference = reference.resampled(rate)
    if substeps is None:
        substeps = 1 if law == "paper" else max(1, int(np.ceil(DRIVE_RATE / reference.rate - 1e-6)))
    if not 1 <= substeps <= 1000:
        raise InvalidValue(f"substeps is {substeps}; it must lie in 1 to 1000.")
    scene = Scene(
        characters=(linkage,),
        ground=ground,
        props=tuple(props),
        contacts=contacts,
        timestep=1.0 / (reference.rate * substeps),
        gravity=gravity / scale,
    )
    given, settings = _given_way(tasks, reference, settings)
    drive = Drive(
        reference=reference,
        captured=captured,
        law=law,
        scale=scale,
        **settings,  # type: ignore[arg-type]
    )
    drive.check(scene)
    return Performance(
        scene=scene,
        controllers=(drive, *given),
        duration=reference.duration if duration is None else duration,
        seed=seed,
    )


def _given_way(
    tasks: Sequence[Disturbance | GiveWay], reference: Clip, settings: dict[str, object]
) -> tuple[list[Disturbance], dict[str, object]]:
    """Disturbances of a drive, and its settings with the strength that hits leave it."""
    hits: list[Disturbance] = []
    for task in tasks:
        if isinstance(task, GiveWay):
            share = task.share(reference.times)[:, None]
            own = settings.get("strength")
            whole = np.ones((1, len(reference.skeleton))) if own is None else np.asarray(own, float)
            settings = {**settings, "strength": share * np.atleast_2d(whole)}
        elif isinstance(task, Disturbance):
            hits.append(task)
        else:
            raise InvalidValue(
                f"task is {shown(task)}; a drive takes Push, Throw and GiveWay: it has no servos."
            )
    return hits, settings


def _check_names(function: Callable[..., object], kind: type, settings: Iterable[str]) -> None:
    """Refuse keywords that neither a function nor the controller it makes knows.

    Raises:
        UnknownName: With the nearest one that is known.
    """
    own = inspect.signature(function).parameters.values()
    known = [p.name for p in own if p.kind is p.KEYWORD_ONLY]
    given = ("reference", "captured", "character")
    known += [f.name for f in fields(kind) if f.init and f.name not in (*known, *given)]
    for name in settings:
        if name not in known:
            raise UnknownName("setting", name, known)
