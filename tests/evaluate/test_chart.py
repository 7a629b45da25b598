from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_takes import body_spec, simulated

from understudy.errors import InvalidValue
from understudy.evaluate import measured
from understudy.evaluate.chart import Bars, Chart, Series, thinned, ticks, write_chart
from understudy.evaluate.plots import against_stiffness, all_charts


def chart(**changes: Any) -> Chart:
    x = np.linspace(0, 2, 50)
    values = {
        "title": "Speed",
        "caption": "How fast.",
        "x_label": "Time [s]",
        "y_label": "Speed [m/s]",
        "series": (Series(name="hand", x=x, y=np.sin(x)),),
        **changes,
    }
    return Chart(**values)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(0, 1, [0, 0.2, 0.4, 0.6, 0.8, 1.0]), (-3, 7, [-2, 0, 2, 4, 6]), (0, 0.004, None)],
)
def test_ticks_are_round_and_inside(low: float, high: float, expected: list[float] | None) -> None:
    found = ticks(low, high)
    assert all(low - 1e-9 <= v <= high + 1e-9 for v in found)
    assert 3 <= len(found) <= 7
    if expected is not None:
        assert found == pytest.approx(expected)


def test_thinning_keeps_peaks() -> None:
    y = np.zeros(100_000)
    y[31_234], y[77_001] = 5.0, -3.0
    x, kept = thinned(np.arange(100_000.0), y)
    assert len(kept) < 2_000
    assert (kept.max(), kept.min()) == (5.0, -3.0)
    assert np.all(np.diff(x) > 0)


def test_names_in_a_chart_are_escaped() -> None:
    series = (Series(name="<b>&", x=np.arange(3.0), y=np.arange(3.0)),)
    text = chart(title="a <script>", series=series).html()
    assert "<script>" not in text and "<b>" not in text


def test_a_chart_says_in_words_what_it_shows() -> None:
    label = re.search(r'aria-label="([^"]*)"', chart().html())
    assert label and "hand from 0.0 to 1.0" in label[1]


def test_the_highest_value_is_drawn_highest() -> None:
    line = re.search(r'class="line c0" data-name[^>]* d="([^"]*)"', chart().html())
    assert line
    points = np.array([p.split() for p in re.findall(r"[ML]([\d. ]+)", line[1])], float)
    assert points[0] == pytest.approx([0, 300])
    assert points[np.argmin(points[:, 1]), 0] == pytest.approx(1000 * np.pi / 4, abs=15)


def test_gaps_break_the_line() -> None:
    y = np.array([1.0, np.nan, 2.0, 3.0])
    text = chart(series=(Series(name="a", x=np.arange(4.0), y=y),)).html()
    assert "nan" not in text
    assert re.search(r'd="M[^LM]*M[^LM]*L[^LM]*"', text)


@pytest.mark.parametrize("points", [0, 1])
def test_a_chart_of_almost_nothing_still_draws(points: int) -> None:
    text = chart(series=(Series(name="a", x=np.zeros(points), y=np.ones(points)),)).html()
    assert "nan" not in text and "inf" not in text
    HTMLParser().feed(text)


def test_a_logarithmic_axis_spaces_decades_evenly() -> None:
    for made in against_stiffness(np.array([1e4, 1e2, 1e3]), np.arange(3.0), np.arange(3.0)):
        line = re.search(r'class="line c0" data-name[^>]* d="M([^"]*)"', made.html())
        assert line
        assert [float(p.split()[0]) for p in line[1].split("L")] == [0.0, 500.0, 1000.0]


def test_series_of_unequal_length_are_refused() -> None:
    with pytest.raises(InvalidValue, match="has 3 x and 2 y values"):
        Series(name="a", x=np.zeros(3), y=np.zeros(2))


def test_bars_mark_what_exceeds_its_limit() -> None:
    text = Bars(
        title="Torque",
        caption="Peaks.",
        label="Torque [N m]",
        names=("left_hip", "neck"),
        values=np.array([100.0, 60.0]),
        marks=np.array([200.0, 50.0]),
    ).html()
    assert text.count("fill over") == 1 and "left hip" in text


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_charts_are_written_as_pictures(tmp_path: Path, kind: str) -> None:
    pytest.importorskip("matplotlib")
    write_chart(chart(), tmp_path / f"chart.{kind}")
    head = (tmp_path / f"chart.{kind}").read_bytes()[:8]
    assert head.startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[kind])


def test_charts_of_another_kind_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match=r"\.png, \.pdf or \.svg"):
        write_chart(chart(), tmp_path / "chart.bmp")


def test_a_take_without_a_clip_has_plots_of_forces_only(standing: Any) -> None:
    titles = [c.title for c in all_charts(standing, measured(standing))]
    assert titles == ["What holds the root", "Ground reaction", "Peak joint torque"]


def test_ground_reaction_of_a_body_at_rest_is_drawn_at_one(standing: Any) -> None:
    (found,) = [c for c in all_charts(standing, measured(standing)) if c.title == "Ground reaction"]
    assert isinstance(found, Chart)
    assert found.series[0].y[-1] == pytest.approx(1.0, abs=0.01)


def test_without_ground_there_is_no_ground_reaction() -> None:
    take = simulated(body_spec(ground=False, hold=5000.0), 0.2)
    assert "Ground reaction" not in [c.title for c in all_charts(take, measured(take))]
