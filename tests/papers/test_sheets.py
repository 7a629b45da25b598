"""Tables of papers, and moments as pictures in a page."""

from __future__ import annotations

import base64
import csv
import io

import numpy as np
import pytest

import understudy as us
from understudy.errors import InvalidValue
from understudy.papers.filmstrip import Film, films_html
from understudy.papers.sheets import Sheet, as_csv, as_html, plain

TABLE = Sheet(
    name="Table 1",
    caption="Speeds & sizes",
    head=("body", "speed [m/s]", "falls"),
    rows=(("<man>", 1.0 / 3.0, False), ("published", None, True), ("gone", float("inf"), None)),
    notes=("A note.",),
)


def test_csv_has_every_number_in_full():
    rows = list(csv.reader(io.StringIO(as_csv(TABLE))))
    assert rows[0] == list(TABLE.head)
    assert float(rows[1][1]) == 1.0 / 3.0
    assert rows[2][1] == ""


def test_html_escapes_what_was_given_and_says_yes_and_no():
    text = as_html(TABLE, endless="flew apart")
    assert "&lt;man&gt;" in text and "<man>" not in text
    assert "0.3333" in text and ">yes<" in text and ">no<" in text and "flew apart" in text
    assert '<tr class="published">' in text
    assert "Speeds &amp; sizes" in text and "A note." in text


def test_what_is_not_finite_is_null_in_json():
    assert plain({1: (float("nan"), [float("inf"), 2.0])}) == {"1": [None, [None, 2.0]]}


def pictures(text):
    parts = text.split("data:image/png;base64,")[1:]
    return [base64.b64decode(part.split('"')[0]) for part in parts]


def test_a_film_shows_the_moments_asked_for():
    clip = us.sample("gesture").trimmed(0.0, 2.0)
    film = Film(title="a <wave>", thing=clip, times=(0.0, 1.0, 2.0))
    text = films_html([film], alt='a "hand"', width=40, height=50)
    drawn = pictures(text)
    assert len(drawn) == 3 and all(d.startswith(b"\x89PNG") for d in drawn)
    assert len(set(drawn)) == 3
    assert "a &lt;wave&gt;" in text and "a &quot;hand&quot;" in text
    for time in film.times:
        assert f"{time:.2f} s" in text


def test_the_side_it_is_seen_from_can_be_said():
    clip = us.sample("gesture").trimmed(0.0, 1.0)

    def seen(heading: float | None) -> list[bytes]:
        film = Film(title="", thing=clip, times=(0.5,), view="front", heading=heading)
        return pictures(films_html([film], alt="", width=40, height=50))

    assert seen(0.0) == seen(2.0 * np.pi)
    assert seen(0.0) != seen(np.pi)
    assert seen(None)


def test_a_moment_outside_the_motion_is_refused():
    film = Film(title="", thing=us.sample("gesture").trimmed(0.0, 1.0), times=(3.0,))
    with pytest.raises(InvalidValue, match="3"):
        films_html([film], alt="", width=40, height=50)
