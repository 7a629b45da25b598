"""One performance in, a family of varied ones out, each with what changed and what it cost.

In: a `Performance`, how many, a seed, what to vary. Out: a `Family`: every member's motion as BVH
and GLB with its certificate, a contact sheet, a table, and one page to browse them side by side.
"""

from understudy.family.family import Family, family
from understudy.family.member import Member

__all__ = ["Family", "Member", "family"]
