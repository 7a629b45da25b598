"""Stills and contact sheets of takes and clips."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from understudy.errors import InvalidValue, MissingExtra, UnknownName
from understudy.motion.clip import Clip
from understudy.output.pictures import contact_sheet, still
from understudy.take import Take

Image = pytest.importorskip("PIL.Image")


def test_still_says_what_it_shows_and_how_it_was_drawn(take: Take, tmp_path: Path) -> None:
    drawn = still(take, 0.5, tmp_path / "a.png", width=160, height=120)
    assert drawn.renderer == "software"
    with Image.open(tmp_path / "a.png") as read:
        assert read.size == (160, 120)
        assert np.array_equal(np.asarray(read), drawn.pixels)
        assert read.text["Renderer"] == "software"
        assert read.text["Time"] == "0.500 s"


def test_ghost_changes_the_picture(take: Take) -> None:
    pictures = [
        still(take, 0.5, ghost=ghost, view="front", width=120, height=90).pixels
        for ghost in ("none", "over", "beside")
    ]
    assert not np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[1], pictures[2])


def test_body_fills_the_height_of_a_still(clip: Clip) -> None:
    drawn = still(clip, 0.5, width=160, height=160).pixels.astype(int)
    body = np.nonzero((drawn[..., 0] - drawn[..., 2] > 30).any(axis=1))[0]
    assert np.ptp(body) > 0.75 * 160


def test_sheet_has_a_row_for_the_reference_and_one_for_the_simulated(
    take: Take, clip: Clip, tmp_path: Path
) -> None:
    both = contact_sheet(take, tmp_path / "sheet.png", count=3, width=40, height=60)
    alone = contact_sheet(clip, count=3, width=40, height=60)
    assert both.pixels.shape[0] - alone.pixels.shape[0] == 60 + 4
    with Image.open(tmp_path / "sheet.png") as read:
        assert read.text["Renderer"] == "software"


def test_sheets_follow_a_body_that_travels_unless_told_not_to(clip: Clip) -> None:
    path = clip.root_positions + np.linspace(0.0, 8.0, clip.frames)[:, None] * [1.0, 0.0, 0.0]
    away = replace(clip, root_positions=path)

    def body(follow: bool) -> float:
        """Share of the picture that shows the body."""
        drawn = contact_sheet(away, count=3, view="side", width=80, height=80, follow=follow)
        pixels = drawn.pixels.astype(int)
        return float((pixels[..., 0] - pixels[..., 2] > 30).mean())

    assert body(True) > 4 * body(False) > 0


def test_a_sheet_follows_body_and_reference_apart(take: Take) -> None:
    """A body that stays behind while its reference walks off is still large in both rows."""
    apart = np.array(take.qpos)
    apart[:, 0] -= 9.0 * take.times
    near = contact_sheet(take, count=3, width=80, height=80).pixels.astype(int)
    far = contact_sheet(replace(take, qpos=apart), count=3, width=80, height=80)
    dark, darker = ((p.sum(axis=-1) < 200).mean() for p in (near, far.pixels.astype(int)))
    assert darker > 0.6 * dark > 0


def test_sheet_wraps_into_bands(clip: Clip) -> None:
    six = contact_sheet(clip, count=6, width=40, height=40).pixels.shape
    twelve = contact_sheet(clip, count=12, width=40, height=40).pixels.shape
    assert twelve[1] == six[1] and twelve[0] > six[0] + 40


@pytest.mark.parametrize(
    ("kwargs", "error", "said"),
    [
        ({"time": 9.0}, InvalidValue, "lasts from 0 to 1 s"),
        ({"time": 0.0, "view": "fornt"}, UnknownName, "Did you mean 'front'"),
        ({"time": 0.0, "ghost": "behind"}, UnknownName, "beside"),
        ({"time": 0.0, "width": 3}, InvalidValue, "3 x 720"),
    ],
)
def test_wrong_wishes_are_refused(take: Take, kwargs: dict, error: type, said: str) -> None:
    with pytest.raises(error, match=said):
        still(take, **kwargs)


def test_sheet_without_pillow_names_the_extra(take: Take, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(MissingExtra, match=r"understudy\[video\]"):
        contact_sheet(take)
