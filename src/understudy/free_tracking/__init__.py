"""A whole body that performs a clip on its own feet: nothing holds its pelvis.

In: a clip and a character, or a performance with a free pelvis. Out: the performance with a
`Guidance`, found by sampling and fitted linear-quadratic regulators, and its take.
"""

from understudy.free_tracking.alone import unheld
from understudy.free_tracking.checkpoint import UnusableSearch
from understudy.free_tracking.free import freed, guided, perform, track
from understudy.free_tracking.passes import Effort
from understudy.free_tracking.relay import Relay
from understudy.free_tracking.replanning import Foresight, replanned
from understudy.free_tracking.search import Search

__all__ = [
    "Effort",
    "Foresight",
    "Relay",
    "Search",
    "UnusableSearch",
    "freed",
    "guided",
    "perform",
    "replanned",
    "track",
    "unheld",
]
