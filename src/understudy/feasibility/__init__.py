"""Whether a motion can be performed without help, said before it is simulated.

In: a `Performance` that tracks a clip. Out: a `Feasibility`: the force and torque at the pelvis
that contact with the ground cannot explain, over time, one score, and why.
"""

from understudy.feasibility.assess import NEEDS_HELP, Feasibility, assess
from understudy.feasibility.reasons import Moment

__all__ = ["NEEDS_HELP", "Feasibility", "Moment", "assess"]
