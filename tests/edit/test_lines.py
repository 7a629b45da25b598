"""Lines of keys, against the standard library's reader and against texts of known layout."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from understudy.edit.lines import Place, lines_of

TEXT = '''\
title = "a # b"   # 1
[ground]
slope.x = 3
"quoted.key" = \'\'\'
lines
=[[no]]
\'\'\'
after = """a\\\\""" # 8
quotes = """""two quotes"""""
[[prop]]
kind = "x"
points = [ # 12
  [1, 2], # 13

  [3,
   4], { a = 1, "b" = [5] },
]
[[prop]]
kind = "y"
[[prop.part]]
n = 1
[[prop.part]]
n = 2979-05-27 07:32:00
[prop.part.deep.er]
z = nan'''


def test_every_kind_of_line_is_found():
    lines = lines_of(TEXT)
    assert lines == {
        ("title",): 1,
        ("ground",): 2,
        ("ground", "slope"): 3,
        ("ground", "slope", "x"): 3,
        ("ground", "quoted.key"): 4,
        ("ground", "after"): 8,
        ("ground", "quotes"): 9,
        ("prop",): 10,
        ("prop", 0): 10,
        ("prop", 0, "kind"): 11,
        ("prop", 0, "points"): 12,
        ("prop", 0, "points", 0): 13,
        ("prop", 0, "points", 0, 0): 13,
        ("prop", 0, "points", 0, 1): 13,
        ("prop", 0, "points", 1): 15,
        ("prop", 0, "points", 1, 0): 15,
        ("prop", 0, "points", 1, 1): 16,
        ("prop", 0, "points", 2): 16,
        ("prop", 0, "points", 2, "a"): 16,
        ("prop", 0, "points", 2, "b"): 16,
        ("prop", 0, "points", 2, "b", 0): 16,
        ("prop", 1): 18,
        ("prop", 1, "kind"): 19,
        ("prop", 1, "part"): 20,
        ("prop", 1, "part", 0): 20,
        ("prop", 1, "part", 0, "n"): 21,
        ("prop", 1, "part", 1): 22,
        ("prop", 1, "part", 1, "n"): 23,
        ("prop", 1, "part", 1, "deep"): 24,
        ("prop", 1, "part", 1, "deep", "er"): 24,
        ("prop", 1, "part", 1, "deep", "er", "z"): 25,
    }
    assert set(lines) == places(tomllib.loads(TEXT))


def test_windows_line_ends_count_once():
    assert lines_of(TEXT.replace("\n", "\r\n")) == lines_of(TEXT)


@pytest.mark.parametrize("text", ["", "#", "\n\n# only\n", " \t\n"])
def test_nothing_said_has_no_lines(text):
    assert lines_of(text) == {}


def places(value: Any, place: Place = ()) -> set[Place]:
    """Every place in what was read."""
    found = {place} if place else set()
    items: Any = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    for key, inner in items:
        found |= places(inner, (*place, key))
    return found


# -- random documents, written while noting the line of everything ------------------------------

WORDS = st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), max_size=8)
KEYS = st.one_of(st.sampled_from(["a", "b", "at", "c-1", "_d", "7"]), WORDS)
SCALARS = st.one_of(
    st.sampled_from(["1", "-2.5e3", "nan", "true", "2020-01-02", "2020-01-02 03:04:05Z", "0x1F"]),
    WORDS.map(lambda word: json.dumps(word, ensure_ascii=False)),
    WORDS.filter(lambda word: "'" not in word).map(lambda word: f"'{word}'"),
    st.sampled_from(['"""\n\n a = 1 # "" \\""" [x]\n"""', "'''\n[b]\\'''", '""', "''", '"""""""']),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(KEYS, inner, max_size=3),
    ),
    max_leaves=8,
)
TABLES = st.recursive(
    st.dictionaries(KEYS, VALUES, max_size=3).map(lambda d: ("table", d, {})),
    lambda inner: st.tuples(
        st.just("table"),
        st.dictionaries(KEYS, VALUES, max_size=2),
        st.dictionaries(
            KEYS, st.one_of(inner, st.lists(inner, min_size=1, max_size=3)), max_size=3
        ),
    ),
    max_leaves=6,
)


class Writer:
    """Writes a document and notes where everything is."""

    def __init__(self, draw: Any):
        self.draw, self.text, self.lines = draw, "", {}

    @property
    def line(self) -> int:
        return self.text.count("\n") + 1

    def note(self, place: Place) -> None:
        self.lines.setdefault(place, self.line)

    def gap(self, *choices: str) -> str:
        return self.draw(st.sampled_from(choices))

    def key(self, key: str) -> str:
        bare = key and all(c.isascii() and (c.isalnum() or c in "-_") for c in key)
        return key if bare and self.draw(st.booleans()) else json.dumps(key, ensure_ascii=False)

    def table(self, table: Any, place: Place, header: str) -> None:
        _, values, inner = table
        values = {k: v for k, v in values.items() if k not in inner}
        for key, value in values.items():
            self.note((*place, key))
            self.text += self.gap("", "  ") + self.key(key) + self.gap("=", " = ", "\t=")
            self.value(value, (*place, key))
            self.text += self.gap("\n", " # [[c]] '''\n", "\n\n")
        for key, below in inner.items():
            several = isinstance(below, list)
            path = f"{header}{self.gap('.', ' . ')}{self.key(key)}" if header else self.key(key)
            for number, one in enumerate(below if several else [below]):
                here = (*place, key)
                self.note(here)
                if several:
                    here = (*here, number)
                    self.note(here)
                opening, closing = ("[[", "]]") if several else ("[", "]")
                self.text += f"{opening}{path}{self.gap('', ' ')}{closing}{self.gap('', ' #x')}\n"
                self.table(one, here, path)

    def value(self, value: Any, place: Place) -> None:
        if isinstance(value, str):
            self.text += value
        elif isinstance(value, list):
            self.text += "["
            for number, inner in enumerate(value):
                self.text += self.gap("", "\n", " # ],\n")
                self.note((*place, number))
                self.value(inner, (*place, number))
                self.text += "," if number + 1 < len(value) else self.gap("", ",", "\n,\n")
            self.text += self.gap("]", "\n]")
        else:
            self.text += "{"
            for number, (key, inner) in enumerate(value.items()):
                self.text += ", " if number else " "
                self.note((*place, key))
                self.text += f"{self.key(key)} = "
                self.value(inner, (*place, key))
            self.text += " }"


@settings(max_examples=80, deadline=None)
@given(TABLES, st.data())
def test_lines_of_random_documents_are_where_they_were_written(table, data):
    writer = Writer(data.draw)
    writer.table(table, (), "")
    read = tomllib.loads(writer.text)
    assert set(writer.lines) == places(read)
    assert lines_of(writer.text) == writer.lines
