"""Families: the same bytes from the same seed, kept members, refusals, honest flags."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.errors import Diverged, InvalidValue, UnderstudyError, UnknownName
from understudy.family import casting, family, member
from understudy.performance import driven, tracked
from understudy.simulate import simulate
from understudy.variations import Length, Limp, Mass, Scaling, Strength
from understudy.variations.presets import preset

COUNT = 3
PRESETS = ("limp_right_arm", "heavy_boots", "tired")


@pytest.fixture(scope="module")
def clip():
    return us.sample("walk").trimmed(0.5, 1.1).resampled(60.0)


@pytest.fixture(scope="module")
def walk(clip):
    return tracked(clip, us.Character.from_clip(clip))


@pytest.fixture(scope="module")
def made(walk, tmp_path_factory):
    folder = tmp_path_factory.mktemp("family")
    return family(walk, COUNT, seed=7, variations=PRESETS, out=folder, jobs=1)


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_every_member_has_its_files(made):
    names = {path.name for path in (made.folder / "members").iterdir()}
    for one in (made.unvaried, *made.members):
        assert {f"{one.name}{kind}" for kind in (".bvh", ".glb", ".json", ".poses.npz")} <= names
    overview = {path.name for path in made.folder.iterdir() if path.is_file()}
    assert overview == {
        "family.html",
        "family.png",
        "family.csv",
        "family.json",
        "settings.json",
    }


def test_the_same_seed_gives_the_same_bytes_on_two_threads(walk, made, tmp_path):
    family(walk, COUNT, seed=7, variations=PRESETS, out=tmp_path, jobs=2)
    one, two = contents(made.folder), contents(tmp_path)
    assert one.keys() == two.keys()
    assert not [name for name in one if one[name] != two[name]]


def test_members_do_not_depend_on_how_many_there_are(walk, made):
    cast = casting.casting(7, PRESETS, (), 0.5)
    assert [cast.part(i).variation for i in range(COUNT)] == [
        made.cast.part(i).variation for i in range(COUNT)
    ]
    assert cast.part(0).variation != cast.part(3).variation
    other = casting.casting(8, PRESETS, (), 0.5)
    assert other.part(0).variation != cast.part(0).variation


def test_a_members_variation_performs_it_again(walk, made):
    again = simulate(made.cast.part(1).variation(walk))
    np.testing.assert_array_equal(member.poses_of(again), made.members[1].poses)


def test_the_bvh_of_a_member_is_on_the_clips_skeleton(clip, made):
    moved = us.read(made.folder / "members" / f"{made.members[0].name}.bvh")
    assert moved.skeleton.names == clip.skeleton.names
    assert moved.duration == pytest.approx(made.members[0].duration, abs=0.02)


def test_finished_members_are_kept_and_the_rest_is_made(walk, tmp_path, monkeypatch):
    arguments = {"seed": 1, "variations": ("heavy_boots",), "out": tmp_path, "jobs": 1}
    first = family(walk, 2, **arguments)
    before = contents(tmp_path)
    (tmp_path / "members" / f"{first.members[1].name}.glb").unlink()
    runs = []
    monkeypatch.setattr(member, "simulate", lambda p: runs.append(1) or simulate(p))
    again = family(walk, 2, **arguments)
    assert (again.reused, len(runs)) == (1, 1)
    assert contents(tmp_path) == before
    assert family(walk, 3, **arguments).reused == 2


def test_a_damaged_member_is_made_again(walk, tmp_path):
    arguments = {"seed": 1, "variations": ("heavy_boots",), "out": tmp_path, "jobs": 1}
    first = family(walk, 1, **arguments)
    before = contents(tmp_path)
    (tmp_path / "members" / f"{first.members[0].name}.json").write_text("{")
    assert family(walk, 1, **arguments).reused == 0
    assert contents(tmp_path) == before


def test_another_family_is_not_mixed_in(walk, made):
    with pytest.raises(UnderstudyError, match=r"another family \(different seed"):
        family(walk, COUNT, seed=8, variations=PRESETS, out=made.folder)
    lighter = Mass(link="left_hand", by=0.5)(walk)
    with pytest.raises(UnderstudyError, match="different performance"):
        family(lighter, COUNT, seed=7, variations=PRESETS, out=made.folder)


def test_the_unvaried_performance_costs_nothing(made):
    assert made.unvaried.total["torque_change_nm2"] == 0.0
    assert made.unvaried.away_mm == 0.0
    assert all(one.total["torque_change_nm2"] > 0.0 for one in made.members)


def test_cost_is_the_mean_squared_change_of_table_3(walk):
    heavy = family(walk, 1, variations=[Mass(link="left_foot", by=6.0)], jobs=1)
    cost = heavy.members[0].cost
    near, far = cost["left_hip"], cost["right_wrist"]
    assert near["torque_change_nm2"] > 10.0 * far["torque_change_nm2"]
    assert near["force_change_n2"] > 10.0 * far["force_change_n2"]


def test_the_table_has_a_row_per_member_and_says_units(made):
    with (made.folder / "family.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["unvaried", *(m.name for m in made.members)]
    assert "left_hip torque (N m)^2" in rows[0]
    content = json.loads((made.folder / "family.json").read_text(encoding="utf-8"))
    assert content["count"] == COUNT
    assert content["units"]["torque_change_nm2"].endswith("[(N m)^2]")


def test_the_page_needs_no_network(made):
    page = (made.folder / "family.html").read_text(encoding="utf-8")
    assert not re.findall(r"(?:src|href)\s*=\s*[\"']?(?:https?:)?//", page)
    assert "@DATA@" not in page
    assert not re.search(r"\b(?:fetch|XMLHttpRequest|import)\s*\(", page)


def test_a_clip_name_with_markup_stays_text(walk, tmp_path):
    own = walk.controllers[0]
    evil = replace(own, reference=own.reference.renamed("</script><b>x"))
    family(replace(walk, controllers=(evil,)), 1, out=tmp_path, jobs=1)
    page = (tmp_path / "family.html").read_text(encoding="utf-8")
    assert "</script><b>" not in page


def test_a_body_that_nothing_holds_falls_and_is_flagged(clip):
    long = us.sample("walk").trimmed(0.5, 2.0).resampled(60.0)
    free = tracked(long, us.Character.from_clip(long), pelvis="free")
    fallen = family(free, 1, variations=[Limp(joint="legs")], jobs=1)
    assert "fell" in fallen.members[0].flags
    assert fallen.flagged()["fell"] == 1


def test_a_diverged_member_is_kept_and_flagged(walk, tmp_path, monkeypatch):
    def blown(performance):
        take = simulate(performance)
        cut = {n: getattr(take, n)[:100] for n in ("times", "qpos", "qvel", "ctrl", "qfrc_applied")}
        raise Diverged(0.2, "left_hand", replace(take, diverged=0.2, **cut))

    monkeypatch.setattr(member, "simulate", blown)
    kept = family(walk, 1, variations=["heavy_boots"], out=tmp_path, jobs=1)
    assert kept.members[0].flags[0] == "diverged"
    assert (tmp_path / "members" / f"{kept.members[0].name}.bvh").exists()


def test_too_large_a_family_is_refused_with_its_size(walk, tmp_path, monkeypatch):
    with pytest.raises(InvalidValue, match="count is 0"):
        family(walk, 0)
    monkeypatch.setattr(casting, "_free_disk", lambda _: 10_000_000)
    with pytest.raises(InvalidValue, match=r"GB on disk; 0\.01 GB are free"):
        family(walk, 100, out=tmp_path / "none")
    monkeypatch.setattr(casting, "_free_memory", lambda: 1_000_000)
    with pytest.raises(InvalidValue, match="of memory"):
        family(walk, 100, out=tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_the_estimate_of_the_disk_is_right_within_a_factor_of_two(walk, made):
    each = sum(path.stat().st_size for path in (made.folder / "members").iterdir()) / (COUNT + 1)
    assert 0.5 < casting.disk_needed(walk, 1) / each < 2.0


@pytest.mark.parametrize(
    ("variations", "error", "said"),
    [
        (["zombi"], UnknownName, "zombie"),
        ([Strength(joint="left_nee", by=0.5)], UnknownName, "left_knee"),
        ([Scaling(joint="neck", by=(1.0, 2.0), end=9.0)], InvalidValue, "outside the clip"),
        ([], InvalidValue, "Nothing is to be varied"),
    ],
)
def test_what_cannot_be_varied_is_said_before_anything_is_made(
    walk, tmp_path, variations, error, said
):
    with pytest.raises(error, match=said):
        family(walk, 2, variations=variations, out=tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_changed_lengths_are_written_on_the_bodys_own_skeleton(walk, tmp_path):
    tall = family(walk, 1, variations=[Length(link="legs", by=1.2)], out=tmp_path, jobs=1)
    moved = us.read(tmp_path / "members" / f"{tall.members[0].name}.bvh")
    assert "left_knee" in moved.skeleton.names
    shank = np.linalg.norm(moved.skeleton.offsets[moved.skeleton.index("left_ankle")])
    old = np.linalg.norm(walk.scene.characters[0].link("left_foot").offset)
    assert shank == pytest.approx(1.2 * old, rel=1e-3)


def test_a_family_of_a_linkage_compares_the_drives_forces(clip, tmp_path):
    performance = driven(clip, us.Linkage.from_clip(clip, "tree"))
    made = family(
        performance, 1, variations=[Scaling(joint="left_ankle", by=1.2)], out=tmp_path, jobs=1
    )
    cost = made.members[0].cost
    assert list(cost) == list(clip.skeleton.names)
    assert cost["left_ankle"]["force_change_n2"] > 10 * cost["right_wrist"]["force_change_n2"]
    certificate = made.members[0].certificate
    assert certificate["kind"] == "understudy drive certificate"
    assert certificate["gap_max_mm"] < 1.0


def test_a_clip_in_place_of_a_performance_is_refused(clip):
    with pytest.raises(InvalidValue, match=r"give a performance: us\.tracked\(clip, character\)"):
        family(clip, 2)


def test_one_preset_needs_no_list():
    one, listed = (casting.casting(0, v, (), None) for v in ("zombie", ["zombie"]))
    assert one.as_dict() == listed.as_dict()
    with pytest.raises(InvalidValue, match="preset's name"):
        casting.casting(0, [3], (), None)


def test_a_long_list_of_names_says_how_many_it_leaves_out():
    text = str(UnknownName("joint", "x", [f"j{k}" for k in range(45)]))
    assert text.endswith("j39, ... and 5 more.")


def test_limbs_come_first_among_valid_names(walk):
    with pytest.raises(UnknownName, match="Valid: left_arm"):
        Limp(joint="qqq")(walk)


def test_a_folded_trunk_and_sunken_joints_are_flagged_on_characters_only(clip, walk):
    take = simulate(walk)
    poses = member.poses_of(take)
    assert member.pose_flags(take, poses, poses, 1.0) == ()
    sunk, folded = poses.copy(), poses.copy()
    sunk[..., 2] -= 0.4
    root = folded[:, :1].copy()
    turned = folded - root
    folded = root + np.stack((turned[..., 2], turned[..., 1], -turned[..., 0]), axis=-1)
    folded[..., 2] += 2.0
    assert member.pose_flags(take, sunk, poses, 1.0) == ("below the floor",)
    assert member.pose_flags(take, folded, poses, 1.0) == ("trunk folded",)
    driven_take = simulate(driven(clip, us.Linkage.from_clip(clip, "tree")))
    low = member.poses_of(driven_take) - 1.0
    assert member.pose_flags(driven_take, low, low, 1.0) == ()


def test_masses_leave_the_motion_of_independent_bodies_and_say_so(clip, tmp_path):
    performance = driven(clip, us.Linkage.from_clip(clip, "independent"), law="paper")
    made = family(performance, 1, common=[Mass(link="left_foot", by=5.0)], out=tmp_path, jobs=1)
    assert made.members[0].away_mm < 0.5
    assert "only the cost changes" in made.members[0].notes[0]
    kept = json.loads((tmp_path / "members" / "000_varied.json").read_text(encoding="utf-8"))
    assert kept["notes"] == list(made.members[0].notes)
    page = (tmp_path / "family.html").read_text(encoding="utf-8")
    assert '"floor":false' in page
    assert made.unvaried.notes == ()


def test_a_zombie_on_foot_is_lighter_than_the_papers(clip, walk):
    bodies = driven(clip, us.Linkage.from_clip(clip, "tree"))
    on_foot = preset("zombie").drawn(np.random.default_rng(0))(walk)
    driven_one = preset("zombie", linkage=True)
    own = walk.scene.characters[0].simulated_mass
    assert on_foot.scene.characters[0].simulated_mass < 1.3 * own
    says = [str(part) for part in driven_one.parts]
    assert "left thigh: mass 0.645 x the body's unvaried mass" in says
    made = family(bodies, 1, variations="zombie", jobs=1)
    assert any("unvaried mass" in text for text in made.members[0].says)
