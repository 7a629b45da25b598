"""Who performs: bodies with masses, shapes and joints.

In: a clip (or a ready-made body's name). Out: a `Character`, which gives a MuJoCo model (`spec`), a
skeleton, and through `retargeted` and `restored` takes clips on and gives them back; or a
`Linkage`, the clip's whole skeleton as rigid bodies.
"""

from understudy.character.bodies import adult_man, adult_woman, alien, body, child
from understudy.character.body import Character, Link, Shape
from understudy.character.linkage import Linkage, Lock
from understudy.character.mapping import Mapping, read_mapping
from understudy.character.retarget import restored, retargeted
from understudy.character.roles import Roles, find_roles

__all__ = [
    "Character",
    "Link",
    "Linkage",
    "Lock",
    "Mapping",
    "Roles",
    "Shape",
    "adult_man",
    "adult_woman",
    "alien",
    "body",
    "child",
    "find_roles",
    "read_mapping",
    "restored",
    "retargeted",
]
