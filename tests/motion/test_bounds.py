"""Numbers far outside what can be meant: one line with the value and the range, and notes."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from texts import TWO_JOINTS, person

import understudy as us
from understudy.errors import InvalidValue


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "two.bvh"
    path.write_text(TWO_JOINTS)
    return path


@pytest.mark.parametrize("rate", [1e-308, 0.0, -1.0, 1e9, float("nan"), "30"])
def test_a_rate_lies_within_a_hundredth_and_a_hundred_thousand(file, rate):
    with pytest.raises(InvalidValue, match=r"rate \(--rate\) is .* 0.01 to 100000 Hz"):
        us.read(file, rate=rate)
    with pytest.raises(InvalidValue, match="rate is"):
        person().resampled(rate)


@pytest.mark.parametrize("unit", [1e308, 1e-308, 0.0, float("inf"), "furlong", ""])
def test_a_unit_lies_between_a_micrometer_and_a_kilometer(file, unit):
    with pytest.raises(InvalidValue, match=r"unit \(--unit\) is .*m, cm, mm, inch"):
        us.read(file, unit=unit)


@pytest.mark.parametrize("speed", [1e-308, 1e-6, 1e6, "2"])
def test_a_speed_lies_within_a_thousandth_and_a_thousand(speed):
    with pytest.raises(InvalidValue, match=r"speed is .* 0.001 to 1000"):
        person().retimed(speed)


def test_more_frames_than_memory_holds_are_refused_with_their_number():
    long = person(2000, 1.0)
    with pytest.raises(InvalidValue, match="199900001 frames of 18 joints, more than memory"):
        long.resampled(1e5)
    with pytest.raises(InvalidValue, match="more than memory"):
        person(4000).retimed(0.001).resampled(1e4)


@pytest.mark.parametrize("mass", [1e-308, 1e-3, 0.5, 1e9, float("nan"), "70"])
def test_a_persons_mass_lies_within_a_kilogram_and_a_ton(mass):
    with pytest.raises(InvalidValue, match=r"mass is .* to 1000 kg \(--mass\)"):
        us.Character.from_clip(person(), mass=mass)


def test_a_body_beyond_the_engine_is_refused_by_its_size(tmp_path):
    count = 4090
    opening = "".join(
        f"{'JOINT' if k else 'ROOT'} j{k}\n{{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation "
        "Yrotation\n"
        for k in range(count)
    )
    row = " ".join(["0"] * 3 * count)
    path = tmp_path / "chain.bvh"
    path.write_text(
        f"HIERARCHY\n{opening}End Site\n{{\nOFFSET 0 1 0\n}}\n{'}' * count}\nMOTION\nFrames: 1\n"
        f"Frame Time: 0.01\n{row}\n"
    )
    clip = us.read(path, unit=0.01, up="y")
    with pytest.raises(InvalidValue, match="body of 4090 links"):
        us.Character.from_clip(clip)


def test_the_skeleton_of_another_format_is_refused_not_ignored(file):
    with pytest.raises(InvalidValue, match=r"asf \(--asf\) is the skeleton of an AMC"):
        us.read(file, asf="none.asf")


@pytest.mark.skipif(os.name != "posix", reason="only there are names bytes")
def test_a_name_that_is_no_text_can_still_be_performed(tmp_path):
    path = tmp_path / os.fsdecode(b"w\xff.bvh")
    try:
        path.write_text(TWO_JOINTS)
    except OSError:
        pytest.skip("this file system takes only text")
    clip = us.read(path)
    assert clip.name.encode() == "w\N{REPLACEMENT CHARACTER}".encode()
    assert us.Character.from_clip(clip).spec().compile()


@pytest.mark.parametrize(("frames", "expected"), [(1, "only one frame"), (2, "only 2 frames")])
def test_a_clip_too_short_to_judge_says_so(frames, expected, tmp_path):
    us.write(person(frames), tmp_path / "short.bvh")
    notes = us.read(tmp_path / "short.bvh").notes
    assert any(expected in note and "too short to judge" in note for note in notes)


@pytest.mark.parametrize(("time", "doubted"), [("0.0001", True), ("0.5", True), ("0.01", False)])
def test_an_unlikely_rate_of_the_file_is_noted(time, doubted, file):
    file.write_text(TWO_JOINTS.replace("0.0333333", time))
    notes = us.read(file).notes
    assert any("hardly a rate of capture" in note for note in notes) == doubted


def test_bones_without_length_are_noted(file):
    flat = TWO_JOINTS
    for offset in ("0 90 0", "0 20 0", "0 30 0"):
        flat = flat.replace(f"OFFSET {offset}", "OFFSET 0 0 0")
    file.write_text(flat)
    assert any("No bone has a length" in note for note in us.read(file).notes)
