"""The text of an edit file: what it holds, on which line, and errors that say so."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from understudy.edit.lines import Place, lines_of, named, twice_in
from understudy.errors import ControllerFailed, Diverged, UnderstudyError, UnknownName, expect

# An edit file is written by a person; more bytes than this are something else.
MOST_BYTES = 1_000_000


class EditError(UnderstudyError):
    """A mistake in an edit file: names the file, the line, the value and what would be right."""

    def __init__(self, path: str | PathLike[str], problem: str, line: int | None = None):
        self.path, self.line = fspath(path), line
        self.problem = " ".join(problem.splitlines())  # a name in it may hold any character
        where = self.path if line is None else f"{self.path}:{line}"
        super().__init__(f"{where}: {self.problem}")


@dataclass(frozen=True, kw_only=True)
class Source:
    """An edit file as text.

    Attributes:
        path: The file; what it names lies relative to its folder.
        data: What TOML makes of it.
        lines: Line of every place in the data.
    """

    path: Path
    data: dict[str, Any] = field(default_factory=dict, repr=False)
    lines: dict[Place, int] = field(default_factory=dict, repr=False)

    def line(self, place: Place) -> int | None:
        """The line of a place, or of the nearest thing around it that has one."""
        while place and place not in self.lines:
            place = place[:-1]
        return self.lines.get(place)

    def error(self, place: Place, problem: str) -> EditError:
        """The error to raise for what is wrong at a place."""
        return EditError(self.path, problem, self.line(place))

    @contextmanager
    def blaming(self, place: Place) -> Iterator[None]:
        """Within: an error becomes one of this file, on the line of the key it speaks of.

        Raises:
            EditError: In place of any other `UnderstudyError` but a simulation's.
        """
        try:
            yield
        except (EditError, Diverged, ControllerFailed):
            raise
        except UnderstudyError as error:
            text = str(error)
            for said, meant in _IN_THE_FILE:
                text = re.sub(said, meant, text)
            if isinstance(error, UnknownName):
                text = self._of_nobody(error.name) or text
            raise self.error(self._key_of(error, place), text) from error

    def _of_nobody(self, name: str) -> str:
        """What to say of a name such as "c/chest" that is of a character who is not there."""
        count = len(self.data.get("character", ()))
        prefix = re.match(r"([b-x])/", name)
        if prefix is None or ord(prefix[1]) - ord("a") < count:
            return ""
        there = "is only one character" if count == 1 else f"are only {count} characters"
        own = "" if count > 1 else f" Its own names have no prefix: {name[2:]!r}."
        return f"{name!r} is of another character, and there {there} in this file.{own}"

    def at(self, place: Place) -> Any:
        """What the file has at a place; None where it has nothing."""
        value: Any = self.data
        try:
            for part in place:
                value = value[part]
        except (KeyError, IndexError, TypeError):
            return None
        return value

    def _key_of(self, error: UnderstudyError, place: Place) -> Place:
        """The key, of a table or of those around it, that an error is about.

        Messages read "radius of drum is", "Push: impulse is"; an unknown name is a key's value.
        """
        for length in range(len(place), -1, -1):
            around = place[:length]
            table = self.at(around)
            for key in sorted(table, key=len, reverse=True) if isinstance(table, dict) else ():
                where = (*around, key)
                if where == place[: length + 1] or _holds_tables(table[key]):
                    continue
                if isinstance(error, UnknownName):
                    held = table[key] if isinstance(table[key], list) else [table[key]]
                    if error.name in held:
                        return where
                elif re.search(rf"(?<![\w.]){re.escape(key)} (?:is|has|of)\b", str(error)):
                    return where
        return place


def _holds_tables(value: object) -> bool:
    """Whether a key opens a table or a list of them."""
    return isinstance(value, dict) or (
        isinstance(value, list) and any(isinstance(item, dict) for item in value)
    )


# What messages of Python functions call by another name than the file does.
_IN_THE_FILE = (
    (r" \(--[\w-]+\)", ""),
    (r"or use spliced, which", "or write segments with a blend above 0, which"),
    (r"Place one clip nearer: clip\.placed\(at=\.\.\.\)", "Put one nearer, as at = [0.9, 0.0]"),
    (r"give it to `tracked` as a task, which aims it, or ", ""),
)


def source(path: str | PathLike[str]) -> Source:
    """Read an edit file.

    Raises:
        EditError: It cannot be read, or is not TOML; names the line.
        InvalidValue: `path` is no name of a file.
    """
    expect(path, (str, PathLike), "path", "the name of an edit file")
    try:
        with Path(path).open("rb") as file:
            raw = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise EditError(path, f"{(error.strerror or str(error)).lower()}.") from None
    except ValueError as error:
        raise EditError(repr(path), f"is no name of a file: {error}.") from None
    if len(raw) > MOST_BYTES:
        raise EditError(path, f"holds more than {MOST_BYTES} bytes; it is no edit file.")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise EditError(path, "is not UTF-8 text; save it as UTF-8.", line) from None
    return parsed(text, path)


def parsed(text: str, path: str | PathLike[str]) -> Source:
    """The source of a text; `path` is where it is said to be from."""
    try:
        data = tomllib.loads(text)
        lines = lines_of(text)
    except RecursionError:
        raise EditError(path, "is nested too deeply; no key of an edit file is.") from None
    except ValueError as error:  # TOMLDecodeError, and numbers of too many digits
        raise _refused(path, text, error) from None
    made = Source(path=Path(path), data=data, lines=lines)
    for place in lines:
        value = made.at(place)
        if isinstance(value, int) and value.bit_length() > 63:
            raise made.error(place, f"{place[-1]} is a number of {value.bit_length()} bits.")
    return made


# How the reader begins what it says of a key, or of a table, that is there already.
_AGAIN = ("Cannot overwrite", "Cannot declare", "Duplicate")


def _told_twice(text: str, line: int | None, column: int) -> tuple[str, int] | None:
    """What a text says twice, up to where the reader stopped, in words; and the second's line."""
    read = text.replace("\r\n", "\n")
    if line is not None:
        lines = read.split("\n")[:line]
        read = "\n".join((*lines[:-1], lines[-1][: column - 1]))
    twice = twice_in(read)
    if twice is None:
        return None
    where = f"here and on line {twice.first}"
    if isinstance(twice.place[-1], int):
        said = f"{named(twice.place)} must come before what is in it, on line {twice.first}."
        return said, twice.again
    if twice.table:
        several = "of what there can be several, each stands in double brackets, as [[prop]]"
        return f"{named(twice.place)} is there twice, {where}; keep one: {several}.", twice.again
    *around, key = twice.place
    inside = f" in {named(tuple(around))}" if around else ""
    return f"{str(key)!r} is there twice{inside}, {where}; keep one.", twice.again


def _refused(path: str | PathLike[str], text: str, error: ValueError) -> EditError:
    """What is wrong with a text that is not TOML."""
    found = re.fullmatch(r"(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error))
    if found is None:
        return EditError(path, f"is not TOML: {error}.")
    problem, line, column = found.groups()
    if problem.startswith(_AGAIN):
        told = _told_twice(text, int(line) if line else None, int(column or 0))
        if told is not None:
            return EditError(path, f"is not TOML: {told[0]}", told[1])
    where = f" at column {column}" if column else " at the end"
    number = int(line) if line else text.count("\n", 0, max(len(text) - 1, 0)) + 1
    return EditError(path, f"is not TOML: {problem}{where}.", number)
