"""Which line of a TOML text says what: the standard library's reader keeps no lines.

Only for texts that `tomllib` has accepted: what is valid TOML need not be checked again, so a key,
a header and the end of a string are all there is to find.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass

Place = tuple[str | int, ...]
"""Where a value is in what was read: keys, and numbers of entries of a list from 0."""

_BLANK = " \t"
_SPACE = " \t\n"


def lines_of(text: str) -> dict[Place, int]:
    """The line, from 1, on which each key, table and entry of a list of a valid TOML text begins.

    `("prop", 0, "radius")` is the key `radius` of the first `[[prop]]`, `("prop", 0)` the header of
    that table.
    """
    return _Scanner(text.replace("\r\n", "\n")).lines


def named(place: Place) -> str:
    """A table as the file writes it: "[[character.task]]", or a key as "'radius' in [[prop]]"."""
    words = ".".join(str(part) for part in place if isinstance(part, str))
    return f"[[{words}]]" if place and isinstance(place[-1], int) else f"[{words}]"


@dataclass(frozen=True, kw_only=True)
class Twice:
    """A key, or a table in single brackets, that a text has twice.

    Attributes:
        place: Where it is; of a list of tables that begins after a table in it, its first entry.
        table: Whether it is a table's header.
        first, again: The two lines.
    """

    place: Place
    table: bool
    first: int
    again: int


def twice_in(text: str) -> Twice | None:
    """The first thing that is there twice in a text that is valid TOML but for that."""
    return _Scanner(text).twice


class _Scanner:
    """Goes through a text once; `at` is where it is."""

    def __init__(self, text: str):
        self.text, self.at, self.line = text, 0, 1
        self.lines: dict[Place, int] = {}
        self.tables: dict[Place, int] = {}  # how many tables a [[list]] of them has so far
        self.opened: set[Place] = set()  # by a [header]
        self.twice: Twice | None = None
        base: Place = ()
        while self._to_next(_SPACE):
            if self._char() == "[":
                base = self._header()
            else:
                self._entry(base)

    def _char(self) -> str:
        return self.text[self.at : self.at + 1]

    def _take(self, count: int = 1) -> None:
        self.line += self.text.count("\n", self.at, self.at + count)
        self.at += count

    def _to_next(self, skipped: str) -> bool:
        """Go past characters and comments; whether anything is left."""
        while self.at < len(self.text):
            char = self._char()
            if char == "#":
                end = self.text.find("\n", self.at)
                self.at = len(self.text) if end < 0 else end
            elif char in skipped:
                self._take()
            else:
                return True
        return False

    def _header(self) -> Place:
        """[a.b] or [[a.b]]; the place of the table it opens."""
        line, many = self.line, self.text.startswith("[[", self.at)
        self._take(2 if many else 1)
        *above, last = self._key()
        self._take(2 if many else 1)
        place: Place = ()
        for part in above:
            place = (*place, part)
            self.lines.setdefault(place, line)
            if place in self.tables:
                place = (*place, self.tables[place] - 1)
        place = (*place, last)
        if place in self.opened or (place in self.tables and not many):
            self._note(place, line, table=True)
        elif many and place in self.lines and place not in self.tables:
            self.lines[(*place, 0)] = self.lines[place]
            self._note((*place, 0), line, table=True)
        self.lines.setdefault(place, line)
        if many:
            number = self.tables.get(place, 0)
            self.tables[place] = number + 1
            place = (*place, number)
            self.lines[place] = line
        else:
            self.opened.add(place)
        return place

    def _key(self) -> list[str]:
        """The parts of a dotted key; ends at what follows it."""
        parts = []
        while True:
            self._to_next(_BLANK)
            start = self.at
            if self._char() in "\"'":
                self._string()
                quoted = self.text[start : self.at]
                parts.append(str(tomllib.loads(f"key = {quoted}")["key"]))
            else:
                while self._char() not in ("", ".", "=", "]", *_SPACE):
                    self._take()
                parts.append(self.text[start : self.at])
            self._to_next(_BLANK)
            if self._char() != ".":
                return parts
            self._take()

    def _entry(self, base: Place) -> None:
        """A key, "=" and its value."""
        line = self.line
        *above, last = self._key()
        for part in above:
            base = (*base, part)
            self.lines.setdefault(base, line)
        base = (*base, last)
        if base in self.lines:
            self._note(base, line, table=False)
        self.lines.setdefault(base, line)
        self._take()  # "="
        self._to_next(_BLANK)
        self._value(base)

    def _note(self, place: Place, line: int, *, table: bool) -> None:
        """Remember the first thing that is there twice."""
        found = Twice(place=place, table=table, first=self.lines[place], again=line)
        self.twice = self.twice or found

    def _value(self, place: Place) -> None:
        char = self._char()
        if char in ('"', "'"):
            self._string()
        elif char in ("[", "{"):
            self._take()
            number = 0
            while self._to_next(_SPACE + ",") and self._char() not in ("]", "}"):
                if char == "{":
                    self._entry(place)
                else:
                    inner = (*place, number)
                    self.lines[inner] = self.line
                    self._value(inner)
                    number += 1
            self._take()
        else:
            while self._char() not in ("", ",", "]", "}", "#", "\n"):
                self._take()

    def _string(self) -> None:
        """Go past a string of one line or several, with or without escapes."""
        quote = self._char()
        escapes, many = quote == '"', self.text.startswith(3 * quote, self.at)
        end = 3 * quote if many else quote
        self._take(len(end))
        while not self.text.startswith(end, self.at) and self.at < len(self.text):
            self._take(2 if escapes and self._char() == "\\" else 1)
        self._take(len(end))
        # Up to two quotes right before the closing three belong to the string.
        for _ in range(2 if many else 0):
            if self._char() == quote:
                self._take()
