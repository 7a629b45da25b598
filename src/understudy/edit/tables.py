"""Tables of an edit file as frozen dataclasses, by their fields: a new prop or task needs no code.

A key is a field, its type the field's. What is a tuple of dataclasses is a [[list of tables]];
where the field's type is `Task` or `Prop`, the table's `kind` says which. Angles are degrees in the
file and radians after it.
"""

from __future__ import annotations

import math
import re
import types
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from understudy import control, scene
from understudy.control import Disturbance, Task
from understudy.edit.lines import Place, named
from understudy.edit.source import EditError, Source
from understudy.errors import UnknownName, shown
from understudy.scene import Prop

Made = TypeVar("Made")

ANGLES = {"heading": (-360.0, 360.0), "slope": (-57.0, 57.0), "limit": (0.0, 180.0)}
"""Fields that are angles: least and most in degrees."""
ENDLESS = ("span", "trim")
"""Fields in which a time may be infinite."""
HIDDEN = ("character", "reference")
"""Fields of tasks and disturbances that the file's order or `tracked` fills in."""
FOLLOWING: dict[Any, tuple[str, ...]] = {control.HandOn: ("facing",)}
"""Fields that follow from others: a palm laid on a surface faces it."""
LARGEST = 1e9
"""No quantity of an edit is larger, in SI units."""
MOST_TABLES = 1000
"""A list of more tables than this is a mistake."""


class Refused(Exception):
    """A value that is not what its field takes; the text says what that is."""


def made(
    kind: type[Made], source: Source, table: object, place: Place, /, **besides: object
) -> Made:
    """A dataclass from a table, and fields that are in no file.

    Raises:
        EditError: An unknown key, a missing one, a value of another type or out of range.
    """
    if not isinstance(table, Mapping):
        raise source.error(place, f"{named(place)} is {shown(table)}; it must be a table.")
    known = keys(kind)
    for name in table:
        if name not in known:
            raise _unknown(source, place, name, known)
    hints, values = _hints(kind), {}
    for name, field in known.items():
        if name in table:
            values[name] = _value(source, table[name], hints[name], (*place, name))
        elif field.default is MISSING and field.default_factory is MISSING:
            raise _missing(source, place, name, hints[name])
    with source.blaming(place):
        return kind(**values, **besides)


def _missing(source: Source, place: Place, name: str, hint: Any) -> EditError:
    """The error for a key that must be there."""
    if _tables_of(hint) is not None:
        return source.error(place, f"There is no [[{name}]]; an edit needs one at least.")
    return source.error(place, f"{named(place)} needs {name!r}, {_wanted(hint)}.")


def keys(kind: Any) -> dict[str, Field[Any]]:
    """The keys that a table of a kind takes, in order, with their fields."""
    hidden = HIDDEN if issubclass(kind, (Task, Disturbance)) else ("source",)
    hidden = (*hidden, *FOLLOWING.get(kind, ()))
    return {f.name: f for f in fields(kind) if f.init and f.name not in hidden}


def spelled(name: str) -> str:
    """A class's name as a kind: "HandOn" is "hand_on"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


@cache
def kinds(base: Any) -> dict[str, Any]:
    """The kinds of task, or of prop, by their names in the file."""
    if base is Task:
        every = [getattr(control, name) for name in control.__all__]
        found = [c for c in every if isinstance(c, type) and issubclass(c, Task) and c is not Task]
    else:
        every = [getattr(scene, name) for name in scene.__all__]
        found = [
            c
            for c in every
            if isinstance(c, type)
            and is_dataclass(c)
            and hasattr(c, "attach")
            and any(f.name == "name" for f in fields(c))
        ]
    return {spelled(kind.__name__): kind for kind in found}


@cache
def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind)


def _value(source: Source, value: object, hint: Any, place: Place) -> Any:
    """A value of the file as its field takes it."""
    name = str(place[-1])
    inner = _table_of(hint)
    if inner is not None:
        return _one(source, value, inner, place)
    inner = _tables_of(hint)
    if inner is not None:
        return _several(source, value, inner, place)
    try:
        if name in ANGLES:
            return _angle(value, hint, *ANGLES[name])
        return converted(value, hint, endless=name in ENDLESS)
    except Refused as refused:
        where = f" in {named(place[:-1])}" if place[:-1] else ""
        wanted = str(refused)
        if re.search(r"\b(nan|inf)\b", repr(value)):
            wanted = wanted.replace("number", "finite number")
        elif re.search(r"\de\+|\d{9}", repr(value)):
            wanted = f"{wanted}, of at most {LARGEST:g}"
        raise source.error(
            place, f"{name}{where} is {shown(value)}; it must be {wanted}."
        ) from None


def _one(source: Source, value: object, kind: Any, place: Place) -> Any:
    """One table, such as [ground]."""
    if isinstance(value, list):
        name = named(place)
        raise source.error(
            place, f"{name} can be there only once: write {name} in single brackets."
        )
    return made(kind, source, value, place)


def _several(source: Source, value: object, kind: Any, place: Place) -> tuple[Any, ...]:
    """A list of tables, such as [[prop]]."""
    name = named((*place, 0))
    if not isinstance(value, list):
        one = "one table" if isinstance(value, Mapping) else shown(value)
        raise source.error(
            place, f"{place[-1]} is {one}; write {name}, in double brackets, before each one."
        )
    if len(value) > MOST_TABLES:
        raise source.error(place, f"{len(value)} times {name}; {MOST_TABLES} are the most.")
    out = []
    for number, table in enumerate(value):
        where = (*place, number)
        if kind in (Task, Prop):
            chosen = _chosen(source, table, kind, where)
            rest = {key: said for key, said in table.items() if key != "kind"}
            out.append(made(chosen, source, rest, where))
        else:
            out.append(made(kind, source, table, where))
    return tuple(out)


def _chosen(source: Source, table: object, base: Any, place: Place) -> Any:
    """The class that a table's `kind` names."""
    every = kinds(base)
    if not isinstance(table, Mapping) or "kind" not in table:
        raise source.error(place, f"{named(place)} needs 'kind': one of {', '.join(every)}.")
    kind = table["kind"]
    if not isinstance(kind, str) or kind not in every:
        text = kind if isinstance(kind, str) else shown(kind)
        error = UnknownName(f"kind of {place[-2]}", text, every)
        raise source.error((*place, "kind"), str(error))
    return every[kind]


def _unknown(source: Source, place: Place, name: str, known: Iterable[str]) -> EditError:
    where = named(place) if place else "the file"
    return source.error((*place, name), str(UnknownName(f"key of {where}", name, known)))


# -- types -------------------------------------------------------------------------------------


def converted(value: Any, hint: Any, *, endless: bool = False) -> Any:
    """A value as a type wants it.

    Raises:
        Refused: It is of another type, not finite, or not among the words allowed.
    """
    for option in options(hint):
        try:
            return _as(value, option, endless)
        except Refused:
            continue
    raise Refused(_wanted(hint))


def options(hint: Any) -> tuple[Any, ...]:
    """The types a field takes, None left out: TOML has no word for it."""
    if get_origin(hint) in (Union, types.UnionType):
        return tuple(h for part in get_args(hint) if part is not type(None) for h in options(part))
    return (hint,)


def _as(value: Any, hint: Any, endless: bool) -> Any:
    if get_origin(hint) is Literal:
        if isinstance(value, str) and value in get_args(hint):
            return value
    elif get_origin(hint) is tuple:
        return _row(value, get_args(hint), endless)
    elif hint is bool or hint is str:
        if isinstance(value, hint):
            return value
    elif hint is int:
        if isinstance(value, int) and not isinstance(value, bool) and abs(value) < 2**53:
            return value
    elif hint is float:
        return _number(value, endless)
    raise Refused


def _number(value: Any, endless: bool) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST:
        return float(value)
    if endless and value == math.inf:
        return math.inf
    raise Refused


def _row(value: Any, parts: tuple[Any, ...], endless: bool) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise Refused
    if parts[-1] is Ellipsis:
        parts = (parts[0],) * len(value)
    if len(value) != len(parts):
        raise Refused
    return tuple(converted(v, h, endless=endless) for v, h in zip(value, parts, strict=True))


def _angle(value: Any, hint: Any, low: float, high: float) -> Any:
    """An angle, or a row of them, in radians."""
    said = converted(value, hint)
    row = said if isinstance(said, tuple) else (said,)
    if not all(low <= angle <= high for angle in row):
        each = ", each" if isinstance(said, tuple) else ""
        raise Refused(f"{_wanted(hint)}{each} from {low:g} to {high:g} degrees")
    found = tuple(math.radians(angle) for angle in row)
    return found if isinstance(said, tuple) else found[0]


def _wanted(hint: Any) -> str:
    """A type in words: "a number", "3 numbers in brackets or text in quotes"."""
    said = [_word(option) for option in options(hint)]
    return " or ".join(dict.fromkeys(said))


def _word(hint: Any) -> str:
    plain = {float: "a number", int: "a whole number", str: "text in quotes", bool: "true or false"}
    if hint in plain:
        return plain[hint]
    if get_origin(hint) is Literal:
        return " or ".join(f'"{word}"' for word in get_args(hint))
    if get_origin(hint) is tuple:
        parts = get_args(hint)
        if get_origin(parts[0]) is tuple:
            timed = get_args(parts[0])[-1] is float
            pair = '["ball", 1.2]' if timed else '["right_hand", "drum"]'
            return f"pairs in brackets, as [{pair}],"
        word = {int: "whole numbers", str: "names in quotes"}.get(parts[0], "numbers")
        if get_origin(parts[0]) is Literal:
            word = f"of {_word(parts[0])}"
        count = "a list of " if parts[-1] is Ellipsis else f"{len(parts)} "
        return f"{count}{word} in brackets"
    return "a table"


def _table_of(hint: Any) -> Any:
    """The dataclass of a field that is one table, or None."""
    found = [h for h in options(hint) if isinstance(h, type) and is_dataclass(h)]
    return found[0] if found else None


def _tables_of(hint: Any) -> Any:
    """The dataclass of a field that is a list of tables, or None."""
    for option in options(hint):
        if get_origin(option) is tuple:
            part = get_args(option)[0]
            if isinstance(part, type) and (is_dataclass(part) or part is Prop):
                return part
    return None
