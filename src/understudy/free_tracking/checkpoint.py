"""A search on disk: one .npz file of plain arrays and a JSON text, written after every pass."""

from __future__ import annotations

import json
import zipfile
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from understudy.control import Guidance
from understudy.errors import UnderstudyError
from understudy.free_tracking.dynamics import Dynamics
from understudy.free_tracking.ladder import Ladder
from understudy.free_tracking.relay import ROWS, Done, Relay
from understudy.free_tracking.search import Search
from understudy.free_tracking.windows import States
from understudy.motion.files import written

Arrays = dict[str, np.ndarray]


class UnusableSearch(UnderstudyError):
    """The file is damaged, or of another search."""


def save(relay: Relay, path: str | PathLike[str], *, spent: float = 0.0) -> None:
    """Write what is done, what the next pass of the piece at work needs, and its best run.

    `spent` is the processor time of the search so far [s].

    A piece that is tried again is not written before it is done: the same is tried again.
    """
    if relay.again:
        return
    arrays: Arrays = {}
    search = relay.search
    for w, one in enumerate(search.dynamics):
        if one is not None:
            arrays |= {f"{w}.{name}": getattr(one, name) for name in Dynamics._fields}
    text: dict[str, Any] = {
        "search": relay.identity,
        "ladder": asdict(search.ladder),
        "farthest": search.farthest,
        "done": _packed(arrays, "done", relay.done),
    }
    best = None
    if search.best is not None and search.states is not None:
        best = Done(search.best, search.states)
    text["best"] = _packed(arrays, "best", best)
    text["fallen"] = _packed(arrays, "fallen", relay.fallen)
    text["spent"] = spent
    with written(path) as temporary, temporary.open("wb") as file:
        lists = json.dumps(text, default=lambda array: array.tolist())
        np.savez(file, allow_pickle=False, text=np.array(lists), **arrays)


def restore(relay: Relay, path: str | PathLike[str]) -> None:
    """Go on from a file that `save` wrote, if there is one.

    Raises:
        UnusableSearch: It is no such file, or of another search.
    """
    if not Path(path).exists():
        return
    try:
        with np.load(path, allow_pickle=False) as file:
            text = json.loads(str(file["text"]))
            same = text["search"] == relay.identity
            if same:
                _take_over(relay, text, file)
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise UnusableSearch(f"{path}: is not a checkpoint of a search ({error}).") from None
    if not same:
        raise UnusableSearch(f"{path}: belongs to another search; give another file or remove it.")


def _take_over(relay: Relay, text: dict[str, Any], file: Any) -> None:
    done, best = _unpacked(file, "done", text["done"]), _unpacked(file, "best", text["best"])
    relay.spent = float(text.get("spent", 0.0))
    relay.farthest = _unpacked(file, "fallen", text.get("fallen"))
    if done is not None and len(done.guidance.offsets) == relay.windows:
        relay.done = done
        return
    relay.begin(done)
    search: Search = relay.search
    ladder: dict[str, Any] = {
        k: np.array(v) if isinstance(v, list) else v for k, v in text["ladder"].items()
    }
    search.ladder, search.farthest = Ladder(**ladder), float(text["farthest"])
    search.dynamics = [
        Dynamics(*(file[f"{w}.{name}"] for name in Dynamics._fields))
        if f"{w}.state" in file
        else None
        for w in range(search.windows)
    ]
    if best is not None:
        search.best, search.states = best


def _packed(arrays: Arrays, name: str, done: Done | None) -> dict[str, Any] | None:
    """Put its arrays among the others, and give the rest."""
    if done is None:
        return None
    own = done.guidance
    arrays |= {f"{name}.{row}": getattr(own, row) for row in ROWS}
    arrays |= {f"{name}.{row}": getattr(done.states, row) for row in States._fields}
    return {"window": own.window, "character": own.character, "found": own.found}


def _unpacked(file: Any, name: str, text: dict[str, Any] | None) -> Done | None:
    if text is None:
        return None
    guidance = Guidance(**{row: file[f"{name}.{row}"] for row in ROWS}, **text)
    return Done(guidance, States(*(file[f"{name}.{row}"] for row in States._fields)))
