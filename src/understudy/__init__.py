"""Turns a recorded motion into a physically simulated performance.

    read -> Clip -> Character -> Scene -> Controller -> Performance -> simulate -> Take
              ^                                                                     |
              +-------------------------- take.clip() ------------------------------+

    import understudy as us

    clip = us.read("walk.bvh")
    character = us.Character.from_clip(clip)
    take = us.track(clip, character)
    print(us.score(take))
    us.write(take, "walk_sim.bvh", "walk_sim.glb")
    us.write_report(take, "walk.html")

SI units and radians, z up, quaternions wxyz. What was simulated can be tracked again. Nothing is
imported until its name is used.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "Character": "character",
    "Clip": "motion.clip",
    "Linkage": "character",
    "Performance": "performance",
    "Scene": "scene",
    "Take": "take",
    "UnderstudyError": "errors",
    "family": "family",
    "driven": "performance",
    "fetch": "motion.fetch",
    "load_take": "output",
    "perform": "free_tracking",
    "read": "motion.read",
    "retargeted": "character.retarget",
    "sample": "motion.samples",
    "samples": "motion.samples",
    "score": "evaluate",
    "simulate": "simulate",
    "track": "free_tracking",
    "tracked": "performance",
    "tune": "tuning",
    "write": "output",
    "write_report": "report",
}

__all__ = [*_HOMES, "__version__"]  # pyright: ignore[reportUnsupportedDunderAll]


class _Package(ModuleType):
    """Keeps `understudy.simulate` the function although a submodule has the same name.

    Importing a submodule binds it on its package; for public names that binding is ignored, and
    the submodule stays reachable by `from understudy.simulate import ...`.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if name in _HOMES and isinstance(value, ModuleType):
            return
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
