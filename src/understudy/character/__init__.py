"""Who performs: bodies with masses, shapes and joints.

In: a clip (or a ready-made body's name). Out: a `Character`, which gives a MuJoCo model (`spec`), a
skeleton, and through `retargeted` and `restored` takes clips on and gives them back; or a
`Linkage`, the clip's whole skeleton as rigid bodies; or an `Athlete`, whose joints are hinges with
motors and whose motion needs no clip.
"""

from understudy.character.athlete import Athlete, athlete, athlete_man, athlete_woman
from understudy.character.bodies import adult_man, adult_woman, alien, body, child
from understudy.character.body import Character, Link, Shape
from understudy.character.linkage import Linkage, Lock
from understudy.character.mapping import Mapping, read_mapping
from understudy.character.retarget import restored, retargeted
from understudy.character.roles import Roles, find_roles

__all__ = [
    "Athlete",
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
    "athlete",
    "athlete_man",
    "athlete_woman",
    "body",
    "child",
    "find_roles",
    "read_mapping",
    "restored",
    "retargeted",
]
