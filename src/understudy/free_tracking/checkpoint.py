"""A search on disk: one .npz file of plain arrays and a JSON text, written after every pass."""

from __future__ import annotations

import hashlib
import json
import zipfile
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.control import Guidance
from understudy.errors import UnderstudyError
from understudy.free_tracking.dynamics import Dynamics
from understudy.free_tracking.ladder import Ladder
from understudy.motion.files import written

if TYPE_CHECKING:
    from understudy.free_tracking.search import Search

_ARRAYS = ("offsets", "help", "postures", "gains")


def save(search: Search, path: str | PathLike[str]) -> None:
    """Write what the next pass needs, and the best guidance so far."""
    ladder = search.ladder
    arrays = {"scales": ladder.scales, "worked": ladder.worked}
    for w, one in enumerate(search.dynamics):
        if one is not None:
            arrays |= {f"{w}.{name}": getattr(one, name) for name in Dynamics._fields}
    best = search.best
    text: dict[str, Any] = {
        "search": identity(search),
        "ladder": {n: getattr(ladder, n) for n in ("children", "usual", "tried", "done")},
        "farthest": search.farthest,
        "best": None,
    }
    if best is not None:
        arrays |= {f"best.{name}": getattr(best, name) for name in _ARRAYS}
        text["best"] = {"window": best.window, "character": best.character, "found": best.found}
    with written(path) as temporary, temporary.open("wb") as file:
        np.savez(file, allow_pickle=False, text=np.array(json.dumps(text)), **arrays)


def restore(search: Search, path: str | PathLike[str]) -> None:
    """Go on from a file that `save` wrote, if there is one.

    Raises:
        UnderstudyError: It is no such file, or of another search.
    """
    if not Path(path).exists():
        return
    try:
        with np.load(path, allow_pickle=False) as file:
            text = json.loads(str(file["text"]))
            same = text["search"] == identity(search)
            ladder = Ladder(**text["ladder"], scales=file["scales"], worked=file["worked"])
            farthest = float(text["farthest"])
            dynamics = [
                Dynamics(*(file[f"{w}.{name}"] for name in Dynamics._fields))
                if f"{w}.state" in file
                else None
                for w in range(search.windows)
            ]
            best = None
            if text["best"] is not None:
                best = Guidance(**{n: file[f"best.{n}"] for n in _ARRAYS}, **text["best"])
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise UnderstudyError(f"{path}: is not a checkpoint of a search ({error}).") from None
    if not same:
        raise UnderstudyError(f"{path}: belongs to another search; give another file or remove it.")
    search.ladder, search.farthest = ladder, farthest
    search.dynamics, search.best = dynamics, best


def identity(search: Search) -> dict[str, Any]:
    """What a search must share with the one whose checkpoint it goes on from."""
    block, model = search.commands, search.model
    digest = hashlib.sha256()
    for array in (block[0], block[1], model.body_mass, model.actuator_gainprm, model.geom_size):
        digest.update(np.ascontiguousarray(array).tobytes())
    return {
        "seed": search.seed,
        "effort": asdict(search.effort),
        "step": float(model.opt.timestep),
        "commands": digest.hexdigest(),
    }
