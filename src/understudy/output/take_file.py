"""Takes on disk: one .npz file of plain arrays and a JSON text, never pickled.

The JSON text holds the take's values as a tree. A number, a text or None stands for itself; an
array is a reference to another entry of the file; a value type of this package is its name and its
fields. Reading makes only value types of this package, which check themselves.
"""

from __future__ import annotations

import copy
import dataclasses
import importlib
import io
import json
import sys
import zipfile
import zlib
from os import PathLike
from pathlib import Path
from typing import Any, cast

import mujoco
import numpy as np

from understudy.control import Guidance
from understudy.errors import ClipError, InvalidValue, UnderstudyError
from understudy.motion.files import written
from understudy.motion.source import check_regular
from understudy.output.take_model import LARGEST, changes, set_number
from understudy.performance import Performance
from understudy.take import Take

_FORMAT, _VERSION = "understudy take", 1
_ENTRY, _PLAN = "take.json", "performance"
# Only these packages have values that a take is made of.
_HOMES = (
    "understudy.motion.",
    "understudy.character.",
    "understudy.scene.",
    "understudy.control.",
    "understudy.performance",
    "understudy.free_tracking.replanning",
    "understudy.take",
)
_NOT_STORED = {"performance", "model"}
# Facts that differ from run to run.
_TIMING = ("cpu_seconds", "search_cpu_seconds")
# Frames per second of a take: one for each step of the engine [Hz].
_RATES = (0.01, 1e7)
_MOST_BYTES = 8 * 2**30
_DEPTH = 40


def save_take(take: Take, path: str | PathLike[str]) -> None:
    """Write a take, with its scene and clips, to an .npz file.

    What was asked for (`take.performance`) is kept only where it has a guidance, be it one that
    plans anew: a search found that, and the take can be performed again, with more besides.

    Raises:
        UnderstudyError: The file cannot be written, or the scene holds a value that is not plain
            data, such as a prop with a function.

    The same take gives the same bytes, but for the computing times, which stand under "timing" of
    the JSON text and are facts of the take again once it is read.
    """
    arrays: dict[str, np.ndarray] = {}
    timing = {name: take.facts[name] for name in _TIMING if name in take.facts}
    facts = {name: value for name, value in take.facts.items() if name not in timing}
    plan = take.performance
    guided = plan is not None and any(
        isinstance(getattr(c, "guidance", c), Guidance) for c in plan.controllers
    )
    document = {
        "format": _FORMAT,
        "version": _VERSION,
        "engine": mujoco.__version__,
        "timing": _plain(timing, arrays, "timing"),
        "take": _plain(dataclasses.replace(take, facts=facts), arrays, "take"),
        "model": _plain(changes(take.scene.model, take.model), arrays, "model"),
        **({_PLAN: _plain(plan, arrays, _PLAN)} if guided else {}),
    }
    text = json.dumps(document, allow_nan=True)
    with written(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_STORED) as file:
        file.writestr(_dateless(_ENTRY), text, zipfile.ZIP_DEFLATED, 6)
        for name, array in arrays.items():
            block = io.BytesIO()
            np.lib.format.write_array(block, np.ascontiguousarray(array), allow_pickle=False)
            file.writestr(_dateless(f"{name}.npy"), block.getvalue())


def _dateless(name: str) -> zipfile.ZipInfo:
    """An entry without the time of day, so that the same take gives the same bytes."""
    entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
    entry.external_attr = 0o644 << 16
    return entry


def load_take(path: str | PathLike[str]) -> Take:
    """Read a take that `save_take` wrote; its `performance` is None, but for a guided one.

    Raises:
        UnderstudyError: No such file, or it is no take file, damaged, or of another version; one
            line that says which.
    """
    if not isinstance(path, str | PathLike):
        raise InvalidValue(f"path is {path!r:.40}; it must be the name of a take file.")
    try:
        check_regular(path, what="take file")
        with zipfile.ZipFile(Path(path)) as file:
            return _read(file)
    except ClipError:
        raise
    except UnderstudyError as error:
        raise UnderstudyError(f"{path}: {' '.join(str(error).split())}") from error
    except FileNotFoundError as error:
        raise UnderstudyError(f"{path}: there is no such file.") from error
    except OSError as error:
        raise UnderstudyError(f"{path}: cannot be read: {error.strerror or error}.") from error
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise UnderstudyError(f"{path}: is no take file, or was cut short: {error}.") from error
    except (
        ArithmeticError,
        AttributeError,
        AssertionError,
        LookupError,
        MemoryError,
        RecursionError,
        RuntimeError,
        TypeError,
        ValueError,
        mujoco.FatalError,
    ) as error:
        raise UnderstudyError(
            f"{path}: is damaged: {str(error) or type(error).__name__}"
        ) from error


def is_take_file(path: str | PathLike[str]) -> bool:
    """Whether a file looks like one that `save_take` wrote; never raises."""
    try:
        check_regular(path, what="take file")
        with zipfile.ZipFile(Path(path)) as file:
            return _ENTRY in file.namelist()
    except (ClipError, OSError, TypeError, ValueError, zipfile.BadZipFile):
        return False


def _read(file: zipfile.ZipFile) -> Take:
    names = {info.filename: info.file_size for info in file.infolist()}
    if _ENTRY not in names:
        raise UnderstudyError("is no take file: it has no entry " + repr(_ENTRY) + ".")
    if sum(names.values()) > _MOST_BYTES:
        raise UnderstudyError(f"would take more than {_MOST_BYTES >> 30} GiB in memory.")
    document = json.loads(file.read(_ENTRY))
    if not isinstance(document, dict) or document.get("format") != _FORMAT:
        raise UnderstudyError("is no take file.")
    if document.get("version") != _VERSION:
        raise UnderstudyError(
            f"was written in version {document.get('version')!r} of the take format; this program "
            f"reads version {_VERSION}."
        )
    reader = _Reader(file)
    if document["take"]["type"] != f"{Take.__module__}.{Take.__qualname__}":
        raise UnderstudyError("holds no take.")
    fields = reader.fields(document["take"], Take)
    _check_scalars(fields)
    timing = reader.value(document.get("timing", {"pairs": []}))
    if not isinstance(timing, dict):
        raise UnderstudyError("states computing times that are none.")
    fields["facts"] = {**fields.get("facts", {}), **timing}
    scene = fields["scene"]
    _check_colors(scene)
    model = copy.copy(scene.model)
    for name, value in reader.value(document["model"]).items():
        set_number(model, name, value)
    plan = reader.value(document.get(_PLAN))
    if not (plan is None or isinstance(plan, Performance)):
        raise UnderstudyError("holds a performance that is none.")
    take = Take(**fields, model=model, performance=plan)
    _check_states(take)
    if take.frames < 1 or len(take.references) != len(scene.characters):
        raise UnderstudyError("has no frames, or not one reference for each character.")
    if not np.isfinite(take.times).all() or np.any(np.diff(take.times) <= 0.0):
        raise UnderstudyError("has times that do not rise from frame to frame.")
    return take


def _check_states(take: Take) -> None:
    """Refuse states and forces that no take of its scene has."""
    model, frames = take.model, take.frames
    shapes = {
        "qpos": (frames, model.nq),
        "qvel": (frames, model.nv),
        "ctrl": (frames, model.nu),
        "qfrc_applied": (frames, model.nv),
        "xfrc_applied": (frames, model.nbody, 6),
    }
    for name, shape in shapes.items():
        values = getattr(take, name)
        if values.shape != shape:
            raise UnderstudyError(f"{name} has shape {values.shape}; the scene needs {shape}.")
        # A NaN fails the comparison too.
        if not (np.abs(values) <= LARGEST).all():
            raise UnderstudyError(f"{name} has values that are not finite, or beyond {LARGEST:g}.")


def _check_scalars(fields: dict[str, Any]) -> None:
    """Refuse single values that no take has."""
    rate, low, high = fields.get("rate"), *_RATES
    if not (isinstance(rate, int | float) and low <= rate <= high):
        raise UnderstudyError(f"has rate {rate!r:.40}; a take has {low:g} to {high:g} Hz.")
    moment = fields.get("diverged")
    if moment is not None and not (isinstance(moment, int | float) and np.isfinite(moment)):
        raise UnderstudyError(f"diverged at {moment!r:.40}, which is no time.")
    if not isinstance(fields.get("facts", {}), dict):
        raise UnderstudyError("states facts that are none.")


def _check_colors(scene: Any) -> None:
    """Refuse colors that could not be drawn."""
    for character in scene.characters:
        for part in getattr(character, "links", ()):
            for shape in getattr(part, "shapes", ()):
                color = np.asarray(shape.rgba, float)
                # A NaN fails the comparison too.
                if color.shape != (4,) or not ((color >= 0.0) & (color <= 1.0)).all():
                    raise UnderstudyError(
                        f"colors {part.name!r} with {color.tolist()!s:.60}; a color is four "
                        "numbers from 0 to 1."
                    )


def _plain(value: Any, arrays: dict[str, np.ndarray], where: str) -> Any:
    """A value as JSON; arrays go to `arrays` under a name from where they are."""
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.ndarray):
        if value.dtype.kind not in "fiub":
            raise UnderstudyError(f"{where} holds an array of {value.dtype}, which is no number.")
        if value.size and not value.any() and value.size > 16:  # forces nobody applied
            return {"zeros": list(value.shape)}
        name = f"{len(arrays):04d}.{where[-80:]}"
        if where.startswith(_PLAN):  # its scene and clips are the take's: kept once
            same = (n for n, held in arrays.items() if _alike(held, value))
            name = next(same, name)
        arrays.setdefault(name, value)
        return {"array": name}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        kind = type(value)
        name = f"{kind.__module__}.{kind.__qualname__}"
        if name.startswith(_HOMES) and "<" not in name:
            return {
                "type": name,
                "fields": {
                    field.name: _plain(getattr(value, field.name), arrays, f"{where}.{field.name}")
                    for field in dataclasses.fields(value)
                    if field.init and not (kind is Take and field.name in _NOT_STORED)
                },
            }
    if isinstance(value, dict):
        return {
            "pairs": [
                [_plain(k, arrays, where), _plain(v, arrays, f"{where}.{k}")]
                for k, v in value.items()
            ]
        }
    if isinstance(value, tuple | list | set | frozenset):
        kind = "tuple" if isinstance(value, tuple) else type(value).__name__
        parts = sorted(value) if isinstance(value, set | frozenset) else value
        return {kind: [_plain(v, arrays, f"{where}.{i}") for i, v in enumerate(parts)]}
    raise UnderstudyError(
        f"{where} is a {type(value).__name__}, which a take file cannot hold; it holds numbers, "
        "texts, arrays and this package's own values."
    )


def _alike(one: np.ndarray, other: np.ndarray) -> bool:
    return one is other or (
        one.shape == other.shape and one.dtype == other.dtype and np.array_equal(one, other)
    )


@dataclasses.dataclass
class _Reader:
    """Makes values of the JSON tree again."""

    file: zipfile.ZipFile
    depth: int = 0

    def value(self, node: Any) -> Any:
        if node is None or isinstance(node, bool | int | float | str):
            return node
        if not isinstance(node, dict):
            raise UnderstudyError(f"holds a {type(node).__name__} where a value should be.")
        self.depth += 1
        if self.depth > _DEPTH:
            raise UnderstudyError(f"holds values nested deeper than {_DEPTH}.")
        try:
            return self._made(node)
        finally:
            self.depth -= 1

    def _made(self, node: dict[str, Any]) -> Any:
        if "array" in node:
            return self._array(node["array"])
        if "zeros" in node:
            shape = tuple(int(n) for n in node["zeros"])
            if len(shape) > 8 or min(shape, default=0) < 0 or np.prod(shape, dtype=float) > 1e9:
                raise UnderstudyError(f"holds an array of shape {shape}.")
            return np.broadcast_to(0.0, shape)
        if "type" in node:
            kind = _value_type(node["type"])
            fields = self.fields(node, kind)
            try:
                return kind(**fields)
            except TypeError as error:
                raise UnderstudyError(f"holds a {kind.__name__} that is none: {error}") from error
        if "pairs" in node:
            return {self.value(k): self.value(v) for k, v in node["pairs"]}
        for name, kind in (
            ("tuple", tuple),
            ("list", list),
            ("set", set),
            ("frozenset", frozenset),
        ):
            if name in node:
                return kind(self.value(part) for part in node[name])
        raise UnderstudyError("holds a value of no known kind.")

    def fields(self, node: dict[str, Any], kind: type) -> dict[str, Any]:
        """Constructor arguments of a value; unknown ones are refused."""
        known = {field.name for field in dataclasses.fields(cast(Any, kind)) if field.init}
        given = node["fields"]
        if not isinstance(given, dict) or not known.issuperset(given):
            raise UnderstudyError(
                f"holds a {kind.__name__} with fields that this version does not know."
            )
        return {name: self.value(part) for name, part in given.items()}

    def _array(self, name: Any) -> np.ndarray:
        with self.file.open(f"{name}.npy") as stream:
            array = np.lib.format.read_array(stream, allow_pickle=False)
        if array.dtype.kind not in "fiub":
            raise UnderstudyError(f"holds an array of {array.dtype}, which is no number.")
        return array


def _value_type(name: Any) -> type:
    """The frozen dataclass of this package called `name`."""
    if not (isinstance(name, str) and name.startswith(_HOMES)):
        raise UnderstudyError(f"names {name!r}, which is no value of this package.")
    module, _, own = name.rpartition(".")
    if module not in sys.modules:
        try:
            importlib.import_module(module)
        except ImportError:
            raise UnderstudyError(f"names {name!r}, which this version does not have.") from None
    kind = getattr(sys.modules[module], own, None)
    if not (
        isinstance(kind, type)
        and dataclasses.is_dataclass(kind)
        and kind.__module__ == module
        and kind.__dataclass_params__.frozen  # type: ignore[attr-defined]
    ):
        raise UnderstudyError(f"names {name!r}, which this version does not have.")
    return kind
