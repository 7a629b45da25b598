"""Published running: the tables come back, identities hold, sources are named."""

from __future__ import annotations

import json

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.evaluate.people import _FOOT, _KNEE, _THIGH, _TILT, MEASURED, people


@pytest.mark.parametrize("row", range(3))
def test_tables_come_back_at_the_measured_speeds(row: int) -> None:
    found = people(MEASURED[row])
    for name, table in (("thigh", _THIGH), ("knee", _KNEE), ("foot", _FOOT), ("pelvis", _TILT)):
        assert np.allclose(np.degrees(found.curves[name])[:100:5], table[row]), name
    assert not found.extrapolated


@pytest.mark.parametrize("speed", [2.0, 2.7, 3.5, 4.1, 5.0])
def test_figures_belong_together(speed: float) -> None:
    found = people(speed)
    value = {name: human.mean for name, human in found.figures.items()}
    stride = 2.0 / value["step_rate_hz"]
    assert value["stance_s"] + value["flight_s"] == pytest.approx(0.5 * stride)
    assert value["duty"] == pytest.approx(value["stance_s"] / stride)
    assert value["step_length_m"] * value["step_rate_hz"] == pytest.approx(speed)
    # All the weight is borne while a foot stands.
    assert value["force_mean_bw"] * 2.0 * value["stance_s"] == pytest.approx(stride)
    hip, thigh, tilt = (found.curves[name] for name in ("hip", "thigh", "pelvis"))
    assert np.allclose(hip, thigh + tilt)


def test_curves_are_periodic_and_agree_with_their_events() -> None:
    for speed in MEASURED:
        found = people(speed)
        for curve in found.curves.values():
            assert curve[0] == pytest.approx(curve[-1])
        knee, thigh = np.degrees(found.curves["knee"]), np.degrees(found.curves["thigh"])
        value = {name: human.mean for name, human in found.figures.items()}
        assert knee.max() == pytest.approx(value["knee_swing_peak_deg"], abs=1.5)
        assert knee[:30].max() == pytest.approx(value["knee_stance_peak_deg"], abs=1.5)
        assert thigh.max() == pytest.approx(value["thigh_forward_peak_deg"], abs=1.5)
        assert thigh.min() == pytest.approx(value["thigh_back_peak_deg"], abs=1.5)
        off = np.interp(100.0 * value["duty"], np.arange(101), knee)
        assert off == pytest.approx(value["knee_toe_off_deg"], abs=2.0)


def test_people_stand_shorter_and_step_faster_the_faster_they_run() -> None:
    found = [people(speed).figures for speed in np.linspace(2.0, 5.0, 13)]
    for name, sign in (("stance_s", -1), ("step_rate_hz", 1), ("knee_swing_peak_deg", 1)):
        values = [figures[name].mean for figures in found]
        assert np.all(sign * np.diff(values) > 0.0), name


def test_speeds_beyond_the_tables_are_marked_and_soon_refused() -> None:
    beyond = people(5.5)
    assert beyond.extrapolated and beyond.speed == 5.0 and beyond.asked == 5.5
    for speed in (0.5, 9.0, float("nan")):
        with pytest.raises(InvalidValue, match="known from"):
            people(speed)


def test_every_figure_says_where_it_comes_from() -> None:
    found = people(3.5)
    for name, human in found.figures.items():
        assert any(year in human.source for year in ("2017", "2018", "2023", "1996")), name
        assert human.known in ("computed", "read in the paper") or "open data" in human.known
        if human.low is not None and human.high is not None:
            assert human.low < human.mean < human.high
            assert human.holds(human.mean) and not human.holds(human.high + 1.0)
        else:
            assert human.holds(human.mean) is None
    json.dumps(found.as_dict(), allow_nan=False)
