"""Edits as performances: they are what Python would make, and refuse what cannot be."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import understudy as us
from understudy.character.bodies import adult_man, child
from understudy.control import Balance, GiveWay, LookAt, Push, Throw, Tracking
from understudy.edit import EditError, read_edit
from understudy.motion import rotations as rot
from understudy.motion.arm import palm
from understudy.motion.segments import concatenated
from understudy.scene import Ball, Drum, Ground

WAVE = '[[character]]\nclip = "sample:gesture"\ntrim = [0.8, 1.2]\n'
BALL = '[[prop]]\nkind = "ball"\nposition = [2, 0, 1]\n'
STAND = '[[character]]\nclip = "sample:clapping"\ntrim = [0, 0.6]\nat = [{x}, 0]\n'


@pytest.fixture(scope="module")
def wave() -> us.Clip:
    return us.sample("gesture").trimmed(0.8, 1.2)


def reference(performance: us.Performance, number: int = 0) -> us.Clip:
    found = [c for c in performance.controllers if isinstance(c, Tracking)]
    return found[number].reference


def same(a: us.Performance, b: us.Performance) -> bool:
    """Whether two performances are one, down to the engine's model."""
    models = {one.scene.spec().to_xml() for one in (a, b)}
    scenes = {(s.scene.contacts, s.scene.props, s.scene.timestep) for s in (a, b)}
    rest = [(s.controllers, s.duration, s.seed) for s in (a, b)]
    return len(models) == len(scenes) == 1 and rest[0] == rest[1]


def palm_at(clip: us.Clip, hand: str, time: float) -> np.ndarray:
    """Where the middle of a palm is in the frame at a time [m]."""
    joint, pose = f"{hand}_wrist", clip.forward_kinematics()
    i, frame = clip.skeleton.index(joint), round(time * clip.rate)
    return pose.positions[frame, i] + rot.rotate(
        pose.rotations[frame, i], palm(clip.skeleton, joint)
    )


def test_a_clip_alone_is_tracked_as_python_tracks_it(said, wave):
    assert same(said(WAVE).performance(), us.tracked(wave, us.Character.from_clip(wave)))


def test_props_tasks_and_pushes_are_those_python_gives(said, wave):
    text = (
        'contacts = [["chest", "ball"]]\nseed = 4\n[ground]\nfriction = 0.7\n'
        + WAVE
        + '[[character.task]]\nkind = "look_at"\ntarget = "ball/center"\n'
        + BALL
        + "[[push]]\ntime = 0.1\nimpulse = [9, 0, 0]\n[[throw]]\ntime = 0.3\nflight = 0.2\n"
    )
    body = us.Character.from_clip(wave)
    by_hand = us.tracked(
        wave,
        body,
        tasks=[
            LookAt(target="ball/center"),
            Push(time=0.1, impulse=(9.0, 0.0, 0.0)),
            Throw(time=0.3, flight=0.2),
        ],
        props=[Ball(position=(2.0, 0.0, 1.0))],
        contacts=(("chest", "ball"),),
        ground=Ground(friction=0.7),
        seed=4,
    )
    assert same(said(text).performance(), by_hand)


def test_a_task_that_gives_the_body_other_legs_is_as_in_python(said):
    clip = us.sample("bow").trimmed(0.0, 1.0)
    text = '[[character]]\nclip = "sample:bow"\ntrim = [0, 1]\n'
    made = said(text + '[[character.task]]\nkind = "balance"\nservos = 0.5\n').performance()
    by_hand = us.tracked(clip, us.Character.from_clip(clip), tasks=[Balance(servos=0.5)])
    assert same(made, by_hand)
    assert made.controllers[0].pelvis == "free"


def test_edits_of_the_clip_are_made_in_order(said):
    text = WAVE + "mirrored = true\nspeed = 0.5\nat = [2, 1]\nheading = 90\nbody = 'child'\n"
    clip = us.sample("gesture").trimmed(0.8, 1.2).mirrored().retimed(0.5)
    by_hand = clip.placed(at=(2.0, 1.0), heading=np.pi / 2)
    assert same(said(text).performance(), us.tracked(by_hand, child()))


def test_a_trim_may_go_to_the_end(said):
    text = WAVE.replace("[0.8, 1.2]", "[5.5, inf]")
    assert said(text).performance().duration == pytest.approx(0.5)


def test_a_file_is_found_beside_the_edit(tmp_path, wave):
    us.write(wave, tmp_path / "wave.bvh")
    (tmp_path / "edit.toml").write_text('[[character]]\nclip = "wave.bvh"\nup = "y"\n')
    made = read_edit(tmp_path / "edit.toml").performance()
    assert reference(made).frames == wave.frames


def test_an_offset_brings_the_palm_to_its_place_at_any_speed(said):
    place = (0.35, -0.2, 1.2)
    for speed in (1.0, 2.0):
        text = (
            '[[character]]\nclip = "sample:gesture"\ntrim = [0, 1]\n'
            f"speed = {speed}\nbody = 'adult_man'\n"
            f"[[character.offset]]\ntime = 0.5\nposition = {list(place)}\nwindow = 0.2\n"
        )
        clip = reference(said(text).performance())
        assert np.linalg.norm(palm_at(clip, "right", 0.5 / speed) - place) < 0.002


def test_hands_of_two_bodies_meet(said):
    text = STAND.format(x=0.0) + "body = 'child'\n"
    text += STAND.format(x=0.7) + "body = 'child'\nheading = 180\n"
    text += "[[meet]]\ntime = 0.3\nhands = ['right', 'left']\napart = 0.01\nwindow = 0.2\n"
    made = said(text).performance()
    assert len(made.scene.characters) == 2
    one = palm_at(reference(made, 0), "right", 0.3)
    two = palm_at(reference(made, 1), "left", 0.3)
    assert np.linalg.norm(one - two) == pytest.approx(0.01, abs=0.002)


def test_segments_are_spliced_where_the_file_says(said):
    text = """\
[[character]]
  [[character.segment]]
  clip = "sample:gesture"
  trim = [0, 1]
  [[character.segment]]
  clip = "sample:clapping"
  trim = [0, 1]
  time = 0.6
  blend = 0.3
  start = 0.1
"""
    a, b = us.sample("gesture").trimmed(0.0, 1.0), us.sample("clapping").trimmed(0.0, 1.0)
    clip = a.spliced(b, at=0.6, blend=0.3, start=0.1)
    made = said(text).performance()
    assert same(made, us.tracked(clip, us.Character.from_clip(clip)))
    ends = said(text.replace("  time = 0.6\n  blend = 0.3\n  start = 0.1\n", "  blend = 0\n"))
    with pytest.raises(EditError, match=r"edit\.toml:5: .* write segments with a blend above 0"):
        ends.performance()


def test_a_transition_without_a_time_lies_near_the_end(said):
    text = "[[character]]\n" + 2 * (
        '[[character.segment]]\nclip = "sample:gesture"\ntrim = [0, 2]\n'
    )
    # It begins in the third half second of the one and leads into the first of the other.
    assert 2.5 <= said(text).performance().duration <= 3.5


def test_segments_of_two_skeletons_come_onto_one_body(said, tmp_path, wave):
    us.write(us.retargeted(wave, adult_man()), tmp_path / "man.bvh")
    (tmp_path / "edit.toml").write_text(
        '[[character]]\n[[character.segment]]\nclip = "sample:gesture"\ntrim = [0, 0.6]\n'
        '[[character.segment]]\nclip = "man.bvh"\nblend = 0.3\n'
    )
    made = read_edit(tmp_path / "edit.toml").performance()
    assert reference(made).skeleton == us.Character.from_clip(us.sample("gesture")).skeleton


def test_segments_that_share_a_pose_are_put_end_to_end(said):
    times = us.sample("patty_cake")
    text = "[[character]]\n" + "".join(
        f'[[character.segment]]\nclip = "sample:patty_cake"\ntrim = [{a}, {a + 1}]\nblend = 0\n'
        for a in (1.5, 0.5)
    )
    clip = concatenated([times.trimmed(1.5, 2.5), times.trimmed(0.5, 1.5)])
    assert same(said(text).performance(), us.tracked(clip, us.Character.from_clip(clip)))


def test_who_is_hit_gives_way(said):
    text = STAND.format(x=0) + STAND.format(x=2) + BALL
    text += '[[prop]]\nkind = "staff"\nheld_by = "b/right_hand"\n'
    text += '[[push]]\ntime = 0.1\non = "chest"\nimpulse = [1, 0, 0]\n'
    text += '[[push]]\ntime = 0.2\non = "staff"\nimpulse = [1, 0, 0]\n'
    text += '[[push]]\ntime = 0.3\non = "ball"\nimpulse = [1, 0, 0]\n'
    text += '[[throw]]\ntime = 0.4\nflight = 0.1\nat = "b/head"\n'
    text += BALL.replace("[2, 0, 1]", "[2, 1, 1]\nname = 'second'")
    text += "[[throw]]\ntime = 0.5\nflight = 0.1\nat = [0, 0, 1]\nball = 'second'\n"
    text += "[give_way]\nstrength = 0.3\nhits = [0.05]\n"
    made = said(text).performance()
    one, two = (c for c in made.controllers if isinstance(c, GiveWay))
    assert (one.character, one.hits, one.strength) == (0, (0.05, 0.1), 0.3)
    assert (two.character, two.hits, two.strength) == (1, (0.05, 0.2), 0.3)
    # A ball hits when it touches, at about the time of the throw.
    assert one.touches == (("second", 0.5),)
    assert two.touches == (("ball", 0.4), ("second", 0.5))
    assert made.controllers[-2:] == (one, two)


def test_a_throw_at_a_link_of_the_second_is_aimed_at_it(said):
    text = STAND.format(x=0) + STAND.format(x=2) + BALL.replace("[2, 0, 1]", "[4, 0, 1]")
    made = said(text + '[[throw]]\ntime = 0.4\nflight = 0.1\nat = "b/chest"\n').performance()
    (throw,) = (c for c in made.controllers if isinstance(c, Throw))
    assert throw.at[0] == pytest.approx(2.0, abs=0.1)


def test_a_longer_duration_is_allowed_and_a_shorter_one(said):
    for seconds in (0.2, 1.0):
        assert said(f"duration = {seconds}\n{WAVE}").performance().duration == seconds


def test_the_contacts_of_all_are_allowed(said):
    text = 'contacts = "all"\n' + WAVE + '[[prop]]\nkind = "drum"\nposition = [0.5, 0, 1]\n'
    made = said(text).performance()
    assert made.scene.contacts == "all"
    assert made.scene.props == (Drum(position=(0.5, 0.0, 1.0)),)
    assert replace(made, seed=1).seed == 1


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (WAVE.replace("gesture", "gestur"), 2, "Did you mean 'gesture'"),
        (WAVE.replace("sample:", ""), 2, 'Did you mean "sample:gesture"'),
        (WAVE.replace("sample:gesture", "no/such.bvh"), 2, "no such file"),
        (WAVE.replace("sample:gesture", r"a\nb.bvh"), 2, "no such file"),
        (WAVE.replace("sample:gesture", r"a\u0000b.bvh"), 2, "null byte"),
        (WAVE.replace("sample:gesture", ""), 2, "folder"),
        (WAVE.replace("[0.8, 1.2]", "[8, 9]"), 3, "Cannot trim"),
        (WAVE.replace("1.2", "0.801"), 3, r"trim is \[0\.8, 0\.801\]; that is one frame"),
        (WAVE + "unit = 'cm'\n", 4, "sample"),
        (WAVE + "speed = 0\n", 4, r"0\.001 to 1000\.$"),
        (WAVE + "loops = 3\n", 4, "write segments with a blend"),
        (WAVE + "at = [1e9, 0]\n", 4, "-10000 to 10000 m"),
        (WAVE + "speed = 0.0001\n", 4, r"lie in 0\.001"),
        (WAVE.replace("[0.8, 1.2]", "[0, 6]") + "\nloops = 700\n", 5, "would last 4200 s"),
        (WAVE + "mass = 1e9\n", 4, r"1 to 1000 kg\.$"),
        (WAVE + "body = 'child'\nheight = 30\n", 5, "height"),
        (WAVE + "mapping = 'none.toml'\n", 4, "no such file"),
        (WAVE + "stiffness = 1e9\n", 4, "stiffness is"),
        ("timestep = 1\n" + WAVE, 1, "timestep is"),
        ("duration = 1e-9\n" + WAVE, 1, "not one step"),
        ("duration = 1e9\n" + WAVE, 1, "GB of states"),
        ('contacts = [\n["head", "drum"]]\n' + WAVE, 2, "named 'drum'"),
        ('contacts = [\n["head", "head"]]\n' + WAVE, 2, "touch itself"),
        ('contacts = [\n["head", "pelvis"],\n["chest", "head"]]\n' + WAVE, 3, "joined"),
        (WAVE + "[[character.task]]\nkind='reach'\ntarget=[2, 0, 1]\n", 4, "m nearer"),
        (WAVE + "[[character.task]]\nkind='reach'\ntarget='drum/skin'\n", 6, "No site"),
        (
            WAVE + "[[character.task]]\nkind='upright'\n[[character.task]]\nkind='reach'\n"
            "target=[0.3, -0.3, 1.2]\n",
            6,
            "both command 'right_wrist'",
        ),
        (
            WAVE + "plan='upper8'\n[[character.task]]\nkind='give_way'\ngive='knee'\n",
            7,
            "a list of",
        ),
        (
            WAVE
            + "plan='upper8'\n[[character.task]]\nkind='give_way'\ngive=['neck','left_knee']\n",
            7,
            "left_knee",
        ),
        (WAVE + "[[character.task]]\nkind='upright'\nspan=[5, 6]\n", 6, "lasts 0.4 s"),
        (WAVE + "[[character.offset]]\ntime=0.1\nposition=[9, 0, 1]\n", 4, "the arm reaches"),
        (WAVE + "[[character.offset]]\ntime=9\nposition=[0, 0, 1]\n", 5, "lasts 0.4 s"),
        (
            WAVE + 2 * "[[character.offset]]\ntime=0.1\nposition=[0.3, -0.2, 1.2]\n",
            7,
            "less than a frame apart",
        ),
        (WAVE + "[[prop]]\nkind='staff'\nheld_by='right_hnd'\n", 6, "Did you mean 'right_hand'"),
        (WAVE + BALL + BALL, 7, "Two props are named 'ball'; give one another name"),
        (WAVE + BALL + BALL + "name = 'ball'\n", 10, "Two props are named 'ball'"),
        (WAVE + "[[push]]\ntime=0.1\non='chst'\nimpulse=[1, 0, 0]\n", 6, "Did you mean 'chest'"),
        (WAVE + "[[push]]\ntime=7\nimpulse=[1, 0, 0]\n", 5, "lasts 0.4 s"),
        (WAVE + BALL + "[[throw]]\ntime=0.2\nflight=0.1\nat='b/head'\n", 10, "only one character"),
        (WAVE + BALL + "[[throw]]\ntime=0.2\nflight=0.1\nat='had'\n", 10, "link to throw at"),
        (WAVE + "[[throw]]\ntime=0.2\nflight=0.1\n", 4, "named 'ball'"),
        (WAVE + "[give_way]\ngive=['elbow']\n", 5, "'elbow'"),
        (WAVE + "[give_way]\n", 4, "Nothing hits anybody"),
        (
            WAVE + BALL + "[[push]]\ntime=0.1\non='ball'\nimpulse=[1, 0, 0]\n[give_way]\n",
            11,
            "Nothing hits anybody",
        ),
        (WAVE + "[give_way]\nhits=[0.1, 0.4]\n", 5, r"hits has 0\.4 s; .* lasts 0\.4 s"),
        (WAVE + "[[character.task]]\nkind='give_way'\nhits=[2]\n", 6, r"hits has 2 s"),
        (WAVE + "[[character.task]]\nkind='give_way'\n", 4, r"needs the times .* \[1\.2\]"),
        ("contacts=[['right_hand', 'b/right_hand']]\n" + WAVE, 1, "only one .* 'right_hand'"),
        (WAVE + "[[prop]]\nkind='staff'\nheld_by='b/left_hand'\n", 6, "only one character"),
        (
            STAND.format(x=0) + STAND.format(x=2) + "[[push]]\ntime=0.1\non='d/head'\n"
            "impulse=[1, 0, 0]\n",
            11,
            "'d/head' is of another character, and there are only 2",
        ),
        (WAVE + WAVE, 4, "both begin at"),
        (
            STAND.format(x=0) + STAND.format(x=5) + "[[meet]]\ntime=0.1\n[[meet]]\ntime=0.2\n",
            9,
            "Put one nearer, as at =",
        ),
    ],
)
def test_what_cannot_be_is_told_with_its_line(said, text, line, words):
    with pytest.raises(EditError, match=words) as caught:
        said(text).performance()
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"edit.toml:{line}: "), message


ROW = '[[character.segment]]\nclip = "sample:{clip}"\ntrim = [{start}, {end}]\n{more}'


def row(*segments: tuple[str, float, float, str]) -> str:
    """A character whose motion is these clips in a row."""
    return "[[character]]\n" + "".join(
        ROW.format(clip=clip, start=start, end=end, more=more)
        for clip, start, end, more in segments
    )


def blends(clip: us.Clip) -> list[tuple[float, float]]:
    """When each transition of a motion begins and ends [s], by its notes."""
    found = [re.search(r"at (\S+) s, blended over (\S+) s", note) for note in clip.notes]
    return [(float(m[1]), float(m[1]) + float(m[2])) for m in found if m]


@pytest.mark.parametrize("middle", [1.15, 1.38, 2.85, 4.0])
def test_a_short_segment_between_two_is_seen(said, middle):
    text = row(("gesture", 0, 3, ""), ("walk", 0, middle, ""), ("clapping", 0, 3, ""))
    (_, end), (begin, _) = blends(reference(said(text).performance()))
    assert begin >= end + 0.05


def test_a_segment_without_room_for_itself_has_its_blends_end_to_end(said):
    text = row(("gesture", 0, 3, ""), ("walk", 0, 1.05, ""), ("clapping", 0, 3, ""))
    (_, end), (begin, _) = blends(reference(said(text).performance()))
    assert begin == pytest.approx(end, abs=0.06)
    assert begin >= end - 1e-6


@pytest.mark.parametrize(
    ("second", "third", "line", "words"),
    [
        ("", "", 8, r"Of 'walk', the segment before, 0\.\d+ s are left .* blend is 0\.5 s"),
        (
            "time = 1\n",
            "time = 1.4\nblend = 0.2\n",
            12,
            "time is 1.4 s; .* lie in 1.500 to 1.700 s",
        ),
        ("time = 1\n", "blend = 2\n", 12, "blend is 2 s. Use more of that clip"),
        ("time = 1\n", "start = 0.2\nblend = 0.45\n", 13, "Use more of that clip"),
    ],
)
def test_a_segment_is_not_skipped(said, second, third, line, words):
    text = row(("gesture", 0, 3, ""), ("walk", 0, 0.9, second), ("clapping", 0, 3, third))
    with pytest.raises(EditError, match=words) as caught:
        said(text).performance()
    assert caught.value.line == line


def test_a_transition_may_begin_where_the_last_one_ends(said):
    text = row(
        ("gesture", 0, 3, ""), ("walk", 0, 2, "time = 1\n"), ("clapping", 0, 3, "time = 1.5\n")
    )
    assert blends(reference(said(text).performance())) == [(1.0, 1.5), (1.5, 2.0)]
