"""The commands reproduce and tune --drive."""

from __future__ import annotations

import csv
import json

import pytest

import understudy as us
from understudy.app.main import main
from understudy.drive_tuning import read_parameters
from understudy.fidelity import drive_error


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    assert main(["reproduce", "wilke2017", "--quick", "--out", str(folder)]) == 0
    return folder


def test_every_table_and_figure_is_on_the_page(made):
    page = (made / "wilke2017.html").read_text(encoding="utf-8")
    for n in range(1, 5):
        assert f"<h3>Table {n}</h3>" in page
    for n in range(2, 12):
        assert f"Figure {n}:" in page
    assert "cannot be compared" in page
    assert "a stand-in" in page


def test_the_page_asks_nothing_of_the_network(made):
    page = (made / "wilke2017.html").read_text(encoding="utf-8")
    assert "http" not in page.replace("http-equiv", "")


def test_units_gravity_scale_and_step_are_stated(made):
    kept = json.loads((made / "wilke2017.json").read_text(encoding="utf-8"))
    for word in ("56.44 mm", "9.81 units/s^2", "scale 1.4286", "1/60 s"):
        assert word in kept["settings"]
    for searches in kept["searches"].values():
        for search in searches.values():
            assert search["settings"]["gravity_units_per_s2"] == pytest.approx(9.81)


def test_a_quick_run_says_that_it_is_one_and_draws_no_conclusion(made):
    kept = json.loads((made / "wilke2017.json").read_text(encoding="utf-8"))
    page = (made / "wilke2017.html").read_text(encoding="utf-8")
    assert kept["quick"] is True
    assert "Quick run" in page
    assert "Best K_f found" not in page


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--evaluations", "-1", "--quick"], "evaluations is -1"),
        (["--points", "0"], "points is 0"),
        (["--runs", "-2"], "runs is -2"),
        (["--seed", "-1"], "seed is -1"),
    ],
)
def test_searches_that_are_none_are_refused(words, said, capsys, tmp_path):
    assert main(["reproduce", "wilke2017", "--out", str(tmp_path / "out"), *words]) == 2
    shown = capsys.readouterr().err
    assert said in shown
    assert shown.count("\n") == 1


def test_tables_are_written_in_full_as_csv(made):
    with (made / "wilke2017_table_3.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows[0]["Joint"] == "RightFoot"
    assert float(rows[0]["published F^2"]) == 15.196
    assert float(rows[0]["F^2"]) > float(rows[-1]["F^2"])
    with (made / "wilke2017_table_2.csv").open(encoding="utf-8") as file:
        assert len(list(csv.reader(file))) == 1 + 12


def test_a_missing_folder_and_an_unknown_paper_are_refused(tmp_path, capsys):
    assert main(["reproduce", "wilke2017", "--clips", str(tmp_path / "no")]) == 2
    assert "no such folder" in capsys.readouterr().err
    assert main(["reproduce", "wilke2018"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


# -- zordan1999 -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def figures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    assert main(["reproduce", "zordan1999", "--quick", "--out", str(folder)]) == 0
    return folder


def test_every_figure_has_a_section_with_what_the_paper_says(figures):
    page = (figures / "zordan1999.html").read_text(encoding="utf-8")
    for title in ("s 1 and 7", " 4", " 5", " 6", " 8, drum", " 8, staff", " 8, bow", " 9"):
        assert f"<h2>Figure{title}: " in page
    assert "cannot be compared" in page and "Quick run" in page
    assert "made, not captured" in page


def test_the_figures_ask_nothing_of_the_network(figures):
    page = (figures / "zordan1999.html").read_text(encoding="utf-8")
    assert "http" not in page.replace("http-equiv", "")
    assert page.count("data:image/png;base64,") > 20


def test_statements_are_held_against_numbers(figures):
    kept = json.loads((figures / "zordan1999.json").read_text(encoding="utf-8"))
    claims = [claim for figure in kept["figures"] for claim in figure["claims"]]
    assert len(claims) == kept["statements"] > 15
    # Few bodies and short motions bear them out, too.
    failed = [claim for claim in claims if not claim["holds"]]
    assert not failed
    assert kept["quick"] is True


def test_tables_of_figures_are_written_as_csv(figures):
    with (figures / "zordan1999_figure_4.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    deep = {row["hand"]: float(row["deepest overlap [mm]"]) for row in rows}
    assert deep["simulated with contact"] < 2.0 < 15.0 < deep["kinematic playback"]
    assert len(list(figures.glob("zordan1999_*.csv"))) == 8


def test_options_of_the_other_paper_are_refused(capsys, tmp_path):
    out = str(tmp_path / "out")
    assert main(["reproduce", "zordan1999", "--points", "5", "--out", out]) == 2
    shown = capsys.readouterr().err
    assert "--points is for wilke2017" in shown and shown.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_a_file_is_refused_before_the_work(capsys, tmp_path):
    (tmp_path / "out").write_text("")
    for paper in ("wilke2017", "zordan1999"):
        assert main(["reproduce", paper, "--out", str(tmp_path / "out")]) != 0
        assert "is a file" in capsys.readouterr().err


@pytest.mark.parametrize("method", ["cma", "monte_carlo"])
def test_tune_drive_writes_parameters_that_other_clips_use(short, tmp_path, capfd, method):
    words = ["--drive", "skeleton", "--method", method, "--points", "1", "--evaluations", "12"]
    assert main(["tune", str(short), *words, "--out", str(tmp_path), "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["best"]["error"] == min(trial["error"] for trial in found["trials"])
    assert (tmp_path / "wave_skeleton_tuning.png").exists()
    kept = read_parameters(tmp_path / "wave_skeleton_parameters.json")
    assert kept == found["driven"]
    clip = us.sample("walk").trimmed(0.0, 0.5)
    performance = us.driven(clip, us.Linkage.from_clip(clip, "skeleton"), **kept)
    assert drive_error(us.simulate(performance)).mean < 100.0


def test_searches_are_refused_for_a_paper_without_any(capsys):
    assert main(["reproduce", "hodgins1995", "--seed", "3"]) == 2
    assert "hodgins1995 has no searches" in capsys.readouterr().err


def test_a_part_that_is_not_there_is_refused(capsys):
    assert main(["reproduce", "hodgins1995", "--part", "swimming"]) == 2
    assert "running" in capsys.readouterr().err
