"""The page: everything inside it, nothing from outside, the poses it was given."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

from understudy.motion.clip import Clip
from understudy.output.playback import playback
from understudy.output.player import player_html, write_player
from understudy.take import Take


def content(page: str) -> dict:
    found = re.search(r"const take = (\{.*?\});\n", page)
    assert found is not None
    return json.loads(found.group(1))


def array(held: dict, name: str, kind: str) -> np.ndarray:
    at, count = held["parts"][name]
    assert at % 4 == 0
    return np.frombuffer(base64.b64decode(held["data"]), kind, count, at)


@pytest.fixture(scope="module")
def page(take: Take) -> str:
    return player_html(take)


def test_page_needs_nothing_from_outside(page: str) -> None:
    assert not re.search(r"(src|href)\s*=\s*[\"'](?!data:)", page)
    assert "http:" not in page and "https:" not in page
    assert "default-src 'none'" in page
    assert "@DATA@" not in page and "@TITLE@" not in page


def test_page_holds_the_simulated_and_the_reference_poses(page: str, take: Take) -> None:
    held, shown = content(page), playback(take, rate=60.0)
    assert held["frames"] == shown.frames and held["rate"] == shown.rate
    shape = (shown.frames, shown.model.nbody)
    for states, names in (
        (shown.qpos, ("positions", "rotations")),
        (shown.ghost, ("ghost_positions", "ghost_rotations")),
    ):
        placed, turned = shown.poses(states)
        assert array(held, names[0], "<f4").reshape(*shape, 3) == pytest.approx(placed, abs=1e-5)
        stored = array(held, names[1], "<i2").reshape(*shape, 4) / 32767
        assert stored == pytest.approx(turned, abs=2e-5)


def test_triangles_of_every_body_lie_in_its_range(page: str, take: Take) -> None:
    held = content(page)
    indices = array(held, "indices", "<u4")
    points = array(held, "points", "<f4").reshape(-1, 3)
    assert sum(body["count"] for body in held["bodies"]) == len(indices)
    assert indices.max() == len(points) - 1
    drawn = [k for k, body in enumerate(held["bodies"]) if body["count"]]
    assert set(drawn) == set(take.scene.parts[0].bodies)


def test_clip_alone_has_no_ghost(clip: Clip) -> None:
    held = content(player_html(clip))
    assert held["ghost"] is False and held["labels"] == []


def test_title_cannot_break_out_of_the_page(clip: Clip) -> None:
    nasty = "</script><script>alert(1)</script><b>&"
    page = player_html(clip, title=nasty)
    assert "<script>alert" not in page
    assert content(page)["name"] == nasty


def test_long_takes_get_fewer_frames_a_second(clip: Clip, monkeypatch: pytest.MonkeyPatch) -> None:
    from understudy.output import player

    monkeypatch.setattr(player, "_MOST_POSES", 300)
    assert content(player_html(clip))["rate"] < 25.0


def test_page_is_written_whole(clip: Clip, tmp_path: Path) -> None:
    write_player(clip, tmp_path / "deep" / "walk.html")
    text = (tmp_path / "deep" / "walk.html").read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>") and text.rstrip().endswith("</html>")


def test_page_names_the_two_motions_with_the_words_of_the_sheets(page: str) -> None:
    assert [label["text"] for label in content(page)["labels"]] == ["simulated", "reference"]
    assert "aptured" not in page.replace(content(page)["data"], "")


def test_page_needs_no_font_for_its_buttons(page: str) -> None:
    assert "\\u23F8" not in page and "\u23f8" not in page and "&#9654;" not in page
