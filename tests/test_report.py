from __future__ import annotations

import itertools
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from bodies import chain, still
from understudy.character import Character
from understudy.character.bodies import adult_woman
from understudy.control import Tracking
from understudy.performance import Performance
from understudy.report import report_html, write_report
from understudy.scene import Ball, Scene
from understudy.simulate import simulate
from understudy.take import Take


def led(body: Character) -> Take:
    """Half a second of a body that holds its neutral pose."""
    clip = still(body, seconds=0.5).noted("Frame 1 <looked> like a T-pose.")
    tracking = Tracking(reference=clip, captured=clip, pelvis="led")
    return simulate(
        Performance(scene=Scene(characters=(body,)), controllers=(tracking,), duration=0.5)
    )


@pytest.fixture(scope="module")
def take() -> Take:
    return led(adult_woman())


@pytest.fixture(scope="module")
def page(take: Take) -> str:
    return report_html(take)


class Outline(HTMLParser):
    """Collects tags and what they refer to."""

    void = frozenset({"meta", "link", "br", "path", "input", "img", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.headings: list[str] = []
        self.attributes: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes.append((tag, dict(attrs)))
        if tag not in self.void:
            self.open.append(tag)
        if re.fullmatch(r"h[1-6]", tag):
            self.headings.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in self.void:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def outline(page: str) -> Outline:
    found = Outline()
    found.feed(page)
    return found


def test_report_is_well_formed(outline: Outline) -> None:
    assert outline.open == []


def test_headings_never_skip_a_level(outline: Outline) -> None:
    levels = [int(h[1]) for h in outline.headings]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(b <= a + 1 for a, b in itertools.pairwise(levels))


def test_report_says_in_words_what_holds_the_body(page: str) -> None:
    assert "Not fully physical" in page
    assert "The pelvis is led along the clip by an outside force of" in page


def test_report_reaches_for_nothing_outside_itself(page: str, outline: Outline) -> None:
    assert not re.search(r"(https?:)?//[a-z0-9-]+\.[a-z]", page)
    for _, attributes in outline.attributes:
        for name in ("src", "href"):
            assert (attributes.get(name) or "data:,").startswith("data:")


def test_everything_drawn_has_a_text_in_its_place(outline: Outline) -> None:
    plots = [a for _, a in outline.attributes if a.get("class") == "plot"]
    assert plots and all(a.get("role") == "img" and a.get("aria-label") for a in plots)
    frames = [a for tag, a in outline.attributes if tag == "iframe"]
    assert frames and all(a.get("title") for a in frames)


def test_notes_are_shown_and_escaped(page: str) -> None:
    assert "Frame 1 &lt;looked&gt; like a T-pose." in page
    assert "<looked>" not in page


def test_report_names_the_versions_and_the_seed(page: str) -> None:
    assert "mujoco" in page and "seed" in page


def test_no_figure_is_nan(page: str) -> None:
    shown = page.split("</iframe>")[1].split("<script>")[0]
    assert not re.search(r"\b(nan|inf|None)\b", shown)


def test_report_is_written_whole(take: Take, tmp_path: Path) -> None:
    write_report(take, tmp_path / "new" / "report.html", title="A title")
    text = (tmp_path / "new" / "report.html").read_text(encoding="utf-8")
    assert "<title>A title</title>" in text and text.endswith("</html>\n")


def test_a_body_that_cannot_be_seen_still_has_a_report() -> None:
    text = report_html(led(chain(3)))
    assert "No picture" in text and "rod1 joint" in text


def test_a_body_that_fell_is_headed_by_its_fall() -> None:
    body = adult_woman()
    high = still(body, seconds=0.4)
    tracking = Tracking(reference=high, captured=high, pelvis="free")
    scene = Scene(characters=(body,), ground=None)
    take = simulate(Performance(scene=scene, controllers=(tracking,), duration=0.4))
    page = report_html(take)
    assert re.search(r'<div class="verdict held"><b>It fell at 0\.2\d s</b>', page)
    assert "ully physical" not in page.split("</header>")[0]


def test_report_speaks_plainly(page: str) -> None:
    assert "ball of left foot" in page and "left ball" not in page
    assert "inverse_dynamics" not in page
    assert " /s²" in page


def test_report_lists_contacts_and_sums_up_feet(page: str) -> None:
    woman = adult_woman()
    clip = still(woman, seconds=0.4)
    ball = Ball(position=(0.0, 0.0, woman.height + 0.2))
    scene = Scene(characters=(woman,), props=(ball,), contacts=(("head", "ball"),))
    servo = Tracking(reference=clip, pelvis="assisted")
    hit = report_html(simulate(Performance(scene=scene, controllers=(servo,), duration=0.4)))
    section = hit.split('<section id="contact-events">')[1].split("</section>")[0]
    for words in ("Contact forces", "head - ball", "Feet on the ground", "left foot"):
        assert words in section
    reading = Outline()
    reading.feed(hit)
    assert reading.open == []
    # Nothing touched the body that is led above the floor, and nothing pushed it.
    assert 'id="contact-events"' not in page and 'id="pushes"' not in page


def test_report_tells_of_pushes(take: Take) -> None:
    chest = take.model.body("chest").id
    outside = np.zeros((take.frames, take.model.nbody, 6))
    outside[(take.times > 0.1) & (take.times < 0.2), chest, 0] = 200.0
    page = report_html(replace(take, xfrc_applied=outside))
    reading = Outline()
    reading.feed(page)
    assert reading.open == []
    row = re.search(r'<section id="pushes">.*?<tbody><tr>(.*?)</tr>', page)
    assert row and "chest" in row[1] and "200" in row[1]
    assert "Pushed from outside, on purpose: chest, " in page.split("</header>")[0]


def test_a_free_body_gets_figures_of_its_own(page: str) -> None:
    body = adult_woman()
    clip = still(body, seconds=0.3)
    tracking = Tracking(reference=clip, pelvis="free")
    free = simulate(
        Performance(scene=Scene(characters=(body,)), controllers=(tracking,), duration=0.3)
    )
    found = report_html(free)
    assert "On its own feet" in found and "no outside force; to the end" in found
    assert "On its own feet" not in page
