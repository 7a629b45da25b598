"""Performance -> Performance: the same part, performed by a changed body or with changed intent.

Wilke & Semwal 2017 vary a driven clip by scaling the velocities of single joints and by leaving
bodies uncontrolled. Here each change is a value; calling it with a performance gives the changed
performance, and `Together` calls several. A change whose amount is a pair stands for a range:
`drawn(rng)` picks one of it.

In: a `Performance`. Out: a `Performance`; nothing runs.
"""

from understudy.variations.body import Length, Mass
from understudy.variations.change import Together, Variation
from understudy.variations.intent import Grip, Limp, Lock, Scaling, Speed, Strength
from understudy.variations.names import LIMBS
from understudy.variations.presets import PRESETS, preset

__all__ = [
    "LIMBS",
    "PRESETS",
    "Grip",
    "Length",
    "Limp",
    "Lock",
    "Mass",
    "Scaling",
    "Speed",
    "Strength",
    "Together",
    "Variation",
    "preset",
]
