"""The reproduction of Wilke & Semwal 2017."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.errors import InvalidValue
from understudy.papers.wilke2017 import published
from understudy.papers.wilke2017.cast import PARTS, casting, with_paper_names
from understudy.papers.wilke2017.experiments import sag_law
from understudy.papers.wilke2017.figures import kick_table, kick_window
from understudy.papers.wilke2017.runs import UNIT


def test_the_standard_figure_plays_the_papers_joints():
    clip = with_paper_names(us.sample("walk"))
    assert {"Hips", "LeftLeg", "RightFoot", "LeftHand", "Head"} <= set(clip.skeleton.names)
    assert clip.skeleton.parents == us.sample("walk").skeleton.parents


def test_who_is_no_person_cannot_play():
    clip = us.sample("walk")
    names = tuple(f"bone{k}" for k in range(len(clip.skeleton)))
    stick = replace(clip.skeleton, names=names, offsets=np.tile([0.0, 0.0, 0.1], (len(names), 1)))
    with pytest.raises(InvalidValue, match="play those of the paper"):
        with_paper_names(replace(clip, skeleton=stick))


def test_without_a_folder_samples_play_and_the_papers_own_clip_comes_first(tmp_path):
    assert not casting(None).own
    us.write(us.sample("gesture").trimmed(0.0, 0.5), tmp_path / "127_02.bvh")
    assert casting(tmp_path).sources["141_15"] == "127_02"
    us.write(us.sample("gesture").trimmed(0.0, 0.5), tmp_path / "141_15.bvh")
    cast = casting(tmp_path)
    assert cast.own == {"141_15"}
    assert cast.sources["141_14"] == "sample:gesture"


def test_published_numbers_are_the_papers():
    assert set(published.TABLE_2) == {part.file for part in PARTS} - {"141_15"}
    assert published.TABLE_1["independent"].error == 0.511
    assert next(iter(published.TABLE_3)) == "RightFoot" and len(published.TABLE_3) == 11


def test_the_sag_law_explains_the_published_error_of_independent_bodies():
    row = published.TABLE_1["independent"]
    assert sag_law(row.gain, 1165 / 60.0) == pytest.approx(row.error, rel=0.25)
    assert sag_law(published.TABLE_1["skeleton"].gain, 1165 / 60.0) > 5 * 0.874


@pytest.mark.clips
def test_real_clips_stand_in_for_the_papers(clips):
    cast = casting(clips, seconds=1.0)
    assert not any(source.startswith("sample:") for source in cast.sources.values())
    assert all(len(clip.skeleton) == 31 for clip in cast.clips.values())


@pytest.mark.clips
def test_scaling_a_kick_changes_forces_in_the_papers_order(clips):
    clip = casting(clips).clips["141_14"]
    first, last = kick_window(clip.resampled(60.0))
    assert last - first == 200
    takes = {}
    _, facts = kick_table(clip, takes)
    assert facts["table_3_spearman_force"] >= 0.9
    assert pytest.approx(0.0564444, rel=1e-5) == UNIT
