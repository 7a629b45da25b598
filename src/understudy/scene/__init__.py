"""What a character stands in: characters, ground and props, compiled to one MuJoCo model.

In: `Character` values and things with `attach(spec)`. Out: a `Scene` with its `MjModel`.
"""

from understudy.scene.ground import Ground
from understudy.scene.scene import Part, Scene, timestep_for

__all__ = ["Ground", "Part", "Scene", "timestep_for"]
