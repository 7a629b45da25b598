"""Which joints a name means: a joint, a link, a limb, a side, or the whole body."""

from __future__ import annotations

from understudy.character import Character
from understudy.errors import InvalidValue, UnknownName

_ARM, _LEG = ("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle", "ball")
_SIDES = {
    f"{side}_{limb}": tuple(f"{side}_{part}" for part in parts)
    for side in ("left", "right")
    for limb, parts in (("arm", _ARM), ("leg", _LEG))
}
_BACK = ("lower_back", "upper_back")
# Limbs of a person and the roles they are made of.
LIMBS: dict[str, tuple[str, ...]] = {
    **_SIDES,
    "left": _SIDES["left_arm"] + _SIDES["left_leg"],
    "right": _SIDES["right_arm"] + _SIDES["right_leg"],
    "arms": _SIDES["left_arm"] + _SIDES["right_arm"],
    "legs": _SIDES["left_leg"] + _SIDES["right_leg"],
    "back": _BACK,
    "upper_body": (*_BACK, "neck", *_SIDES["left_arm"], *_SIDES["right_arm"]),
    "body": (*_BACK, "neck", *(role for parts in _SIDES.values() for role in parts)),
}


def links_of(character: Character, name: str) -> tuple[int, ...]:
    """Index of every link that a link's, joint's or limb's name means; "body" is all but the root.

    Raises:
        UnknownName: The character has none of that name; the text gives the nearest.
    """
    for i, link in enumerate(character.links):
        if name in (link.name, link.joint):
            return (i,)
    if name == "body":
        return tuple(range(1, len(character.links)))
    roles = LIMBS.get(name, ())
    found = tuple(i for i, link in enumerate(character.links) if link.role in roles)
    if roles and found:
        return found
    limbs = [limb for limb in LIMBS if any(k.role in LIMBS[limb] for k in character.links)]
    valid = [*limbs, *(k.joint for k in character.links), *(k.name for k in character.links)]
    raise UnknownName("joint, link or limb", name, dict.fromkeys(valid))


def joints_of(character: Character, name: str) -> tuple[str, ...]:
    """Names of the joints that a name means, the root's refused.

    Raises:
        UnknownName: See `links_of`.
        InvalidValue: It is the root, which has no servo of its own.
    """
    links = links_of(character, name)
    if 0 in links:
        raise InvalidValue(
            f"{name!r} is the root of {character.name!r}: it has no joint to vary; its mass can be."
        )
    return tuple(character.links[i].joint for i in links)
