"""Options for who performs, and the one way they become a character."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import arg

from understudy.errors import InvalidValue, UnknownName

if TYPE_CHECKING:
    from understudy.character import Character
    from understudy.motion.clip import Clip

OWN = "own"
READY_MADE = ("adult_man", "adult_woman", "child", "alien")


@dataclass(frozen=True, kw_only=True)
class Body:
    """Who performs.

    Attributes:
        character: own (the bones of the clip), adult_man, adult_woman, child or alien.
        plan: Which links: the whole body, the 16 of Zordan & Hodgins 1999, or the upper body.
        sex: Anthropometric table of an own body.
        mass: Mass [kg].
        height: Stature [m]; the bones of an own body stay the clip's.
        mapping: TOML file that says which joint of the clip plays which role, where names do not.
    """

    character: Annotated[str, arg(metavar="NAME")] = OWN
    plan: Literal["full", "full16", "upper", "upper8"] = "full"
    sex: Literal["female", "male"] = "male"
    mass: Annotated[
        float | None, arg(metavar="KG", help_behavior_hint="(default: from height)")
    ] = None
    height: Annotated[
        float | None, arg(metavar="M", help_behavior_hint="(default: from bones)")
    ] = None
    mapping: Annotated[Path | None, arg(metavar="FILE", help_behavior_hint="(default: none)")] = (
        None
    )


def check_body(body: Body) -> None:
    """Refuse options that no clip could satisfy, before any clip is read.

    Raises:
        UnknownName: No ready-made body of that name.
        InvalidValue: A ready-made body takes no sex and no mapping.
    """
    if body.character == OWN:
        return
    if body.character not in READY_MADE:
        raise UnknownName("character", body.character, (OWN, *READY_MADE))
    usual = Body()
    for name in ("sex", "mapping"):
        if getattr(body, name) != getattr(usual, name):
            raise InvalidValue(f"--{name} is for --character own; {body.character} has its own.")


def character_for(clip: Clip, body: Body) -> Character:
    """The character the options ask for; raises as `check_body` and `Character.from_clip`."""
    from understudy.character import Character, bodies, read_mapping

    check_body(body)
    if body.character == OWN:
        return Character.from_clip(
            clip,
            plan=body.plan,
            sex=body.sex,
            mass=body.mass,
            height=body.height,
            mapping=None if body.mapping is None else read_mapping(body.mapping),
        )
    given = {"mass": body.mass, "height": body.height}
    sizes = {name: value for name, value in given.items() if value is not None}
    return getattr(bodies, body.character)(plan=body.plan, **sizes)
