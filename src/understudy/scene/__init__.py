"""What a character stands in: characters, ground and props, compiled to one MuJoCo model.

In: `Character` values and things with `attach(spec)`. Out: a `Scene` with its `MjModel`.
"""

from understudy.scene.ball import Ball
from understudy.scene.box import Box
from understudy.scene.drum import Drum
from understudy.scene.ground import Block, Ground, Steps
from understudy.scene.props import Prop
from understudy.scene.scene import Part, Scene, timestep_for
from understudy.scene.staff import Staff
from understudy.scene.table import Table
from understudy.scene.touching import Contacts

__all__ = [
    "Ball",
    "Block",
    "Box",
    "Contacts",
    "Drum",
    "Ground",
    "Part",
    "Prop",
    "Scene",
    "Staff",
    "Steps",
    "Table",
    "timestep_for",
]
