"""What an edit file says, and how its mistakes are told."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re

import pytest

import understudy as us
from understudy import control, scene
from understudy.control import Disturbance, Push, Task, Throw
from understudy.edit import EditError, read_edit, tables
from understudy.edit.edit import Edit, Meeting, Offset, Performer, Segment
from understudy.edit.source import MOST_BYTES
from understudy.scene import Drum, Ground, Prop, Steps

WAVE = '[[character]]\nclip = "sample:gesture"\ntrim = [0.8, 1.2]\n'

EVERYTHING = """\
title = "all"
seed = 7
timestep = 0.004
duration = 2
self_collision = "pairs"
contacts = [["right_hand", "drum"]]
[ground]
slope = 10
[ground.steps]
position = [1, 0]
heading = 90
[[character]]
clip = "sample:gesture"
trim = [1, 2.5]
mirrored = true
speed = 2
body = "child"
mass = 20
at = [0.5, -1]
heading = -45
pelvis = "led"
  [[character.offset]]
  hand = "left"
  time = 0.5
  position = [0.1, 0.2, 0.3]
  [[character.task]]
  kind = "look_at"
  target = "drum/skin"
  limit = [60, 30]
  span = [0.2, inf]
[[character]]
  [[character.segment]]
  clip = "a.bvh"
  unit = "cm"
  [[character.segment]]
  clip = "b.bvh"
  unit = 0.01
  blend = 0
[[meet]]
time = 1
hands = ["left", "left"]
characters = [2, 1]
[[prop]]
kind = "drum"
position = [0.4, 0, 1]
[[push]]
time = 1
impulse = [0, 5, 0]
[[throw]]
time = 1
at = [0, 0, 1]
[give_way]
strength = 0
"""


def test_every_key_becomes_a_field(said):
    edit = said(EVERYTHING.replace("speed = 2\n", ""))
    assert (edit.title, edit.seed, edit.timestep, edit.duration) == ("all", 7, 0.004, 2.0)
    assert edit.contacts == (("right_hand", "drum"),)
    assert edit.ground == Ground(
        slope=math.radians(10), steps=Steps(position=(1.0, 0.0), heading=math.radians(90))
    )
    one, two = edit.character
    assert (one.trim, one.mirrored, one.body, one.mass) == ((1.0, 2.5), True, "child", 20.0)
    assert (one.at, one.heading, one.pelvis) == ((0.5, -1.0), math.radians(-45), "led")
    assert one.offset == (Offset(hand="left", time=0.5, position=(0.1, 0.2, 0.3)),)
    assert one.task == (
        control.LookAt(
            target="drum/skin", limit=(math.radians(60), math.radians(30)), span=(0.2, math.inf)
        ),
    )
    assert two.segment == (
        Segment(clip="a.bvh", unit="cm"),
        Segment(clip="b.bvh", unit=0.01, blend=0.0),
    )
    assert edit.meet == (Meeting(time=1.0, hands=("left", "left"), characters=(2, 1)),)
    assert edit.prop == (Drum(position=(0.4, 0.0, 1.0)),)
    assert edit.push == (Push(time=1.0, impulse=(0.0, 5.0, 0.0)),)
    assert edit.throw == (Throw(time=1.0, at=(0.0, 0.0, 1.0)),)
    assert edit.give_way is not None and edit.give_way.strength == 0.0


def test_what_is_not_said_is_as_in_python(said):
    edit = said(WAVE)
    for field in dataclasses.fields(Edit):
        if field.name not in ("character", "source"):
            assert getattr(edit, field.name) == field.default, field.name


def test_a_file_reads_as_its_text_does(said, tmp_path):
    path = tmp_path / "wave.toml"
    path.write_bytes(b"\xef\xbb\xbf" + WAVE.replace("\n", "\r\n").encode())
    assert read_edit(path) == said(WAVE)
    assert read_edit(str(path)).source.path == path


def test_every_task_and_every_prop_has_a_kind():
    assert set(tables.kinds(Task)) >= {"upright", "reach", "look_at", "hand_on", "give_way"}
    assert set(tables.kinds(Prop)) == {"ball", "box", "drum", "staff", "table"}
    for kind in (*tables.kinds(Task).values(), *tables.kinds(Prop).values()):
        hints = tables._hints(kind)
        assert all(name in hints for name in tables.keys(kind))


def test_the_fields_in_degrees_are_those_documented_in_radians():
    kinds = {getattr(module, name) for module in (control, scene) for name in module.__all__}
    angles = set()
    for kind in (*kinds, Performer):
        if not (dataclasses.is_dataclass(kind) and isinstance(kind, type)):
            continue
        if issubclass(kind, (Task, Disturbance)) or kind is Performer or hasattr(kind, "attach"):
            text = inspect.getdoc(kind) or ""
            for entry in re.split(r"\n {4}(?=\w+(?:, \w+)*:)", text):
                if "[rad]" in entry:
                    angles |= set(entry.partition(":")[0].split(", "))
    angles |= {"heading"}
    assert angles == set(tables.ANGLES)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("[[character]]\nclip = sample\n", 2, "not TOML"),
        (
            '[[character]]\nclip = "a"\nclip = "b"\n',
            3,
            r"'clip' .* in \[\[character\]\], .* line 2;",
        ),
        ("seed = 1\n# \nseed = 2", 3, "'seed' is there twice, here and on line 1; keep one"),
        ('title = \'a\'\r\ntitle = """b\nc"""', 2, "'title' is there twice, .* line 1"),
        (WAVE + "at = {x = 1, x = 2}\n", 4, "'x' is there twice in"),
        (
            "[ground.steps]\n[ground]\nsteps = 1\n" + WAVE,
            3,
            r"'steps' is there twice in \[ground\]",
        ),
        ("[ground]\n" + WAVE + "[ground]\n", 5, r"\[ground\] is there twice, .* keep one"),
        (WAVE + "[character]\n", 4, r"\[character\] is there twice, .* double brackets"),
        ("[[character.task]]\n" + WAVE, 2, r"\[\[character\]\] must come before .* line 1"),
        ("seed = 1\n[seed]\n", 2, "not TOML: Cannot overwrite a value"),
        (WAVE.replace("[0.8, 1.2]", "[1.0, 1.0]"), 3, r"trim is \[1\.0, 1\.0\]; .* later end"),
        (WAVE.replace("[0.8, 1.2]", "[8, 2]"), 3, r"trim is \[8\.0, 2\.0\]; .* a later end"),
        ("a = " + "[" * 5000, None, "too deeply"),
        ("seed = " + "9" * 5000, None, "not TOML"),
        ("title = 'a'\nseed = 0x" + "f" * 5000, 2, "20000 bits"),
        (WAVE + "'two\\nlines' = 1\n", 4, "No key"),
        ("", None, r"no \[\[character\]\]"),
        ("character = []\n", 1, "0 times"),
        ('[character]\nclip = "a"\n', 1, "double brackets"),
        ("[[character]]\nbody = 'child'\n", 1, "needs one of a clip"),
        (WAVE + '[[character.segment]]\nclip = "a"\n', 1, "needs one of a clip"),
        (WAVE + "speeed = 2\n", 4, "'speeed'. Did you mean 'speed'"),
        ("speed = 2\n" + WAVE, 1, "No key of the file named 'speed'"),
        (WAVE + "speed = nan\n", 4, "finite number"),
        (WAVE + "speed = true\n", 4, "speed in .* is True; it must be a number"),
        (WAVE + "loops = 0\n", 4, "1 to 1000"),
        (WAVE + "at = [1, 2, 3]\n", 4, "2 numbers"),
        (WAVE + "at = [1, inf]\n", 4, "2 finite numbers"),
        (WAVE + "at = [1, 1e300]\n", 4, "2 numbers in brackets, of at most 1e"),
        (WAVE + "heading = 1e4\n", 4, "-360 to 360 degrees"),
        (WAVE + 'law = "modem"\n', 4, '"modern" or "paper"'),
        (WAVE + 'body = "kid"\n', 4, "Did you mean 'child'"),
        (WAVE + 'body = "man"\n', 4, "Did you mean 'adult_man'"),
        (WAVE + 'body = "woman"\n', 4, "Did you mean 'adult_woman'"),
        (WAVE + '\nbody = "child"\nsex = "male"\n', 6, "has its own"),
        (WAVE + "[[character.task]]\nkind='look_at'\ntarget=[1,0,1]\nlimit=30\n", 7, "2 numbers"),
        (
            WAVE + "[[character.task]]\nkind='look_at'\ntarget='a'\nlimit=[1,200]\n",
            7,
            "each from 0",
        ),
        ("seed = -1\n" + WAVE, 1, "zero or positive"),
        ("seed = 1_000_000_000_000_000_000\n" + WAVE, 1, "whole number"),
        ("duration = 0\n" + WAVE, 1, "positive"),
        ("duration = 2020-01-01\n" + WAVE, 1, "a number"),
        ('contacts = ["right_hand", "drum"]\n' + WAVE, 1, "pairs"),
        ("[ground]\nslope = 80\n" + WAVE, 2, "-57 to 57"),
        ("[ground.steps]\nrise = 0.1\n" + WAVE, 1, "needs 'position'"),
        ("[[ground]]\n" + WAVE, 1, "single brackets"),
        (WAVE + "[[prop]]\n", 4, "needs 'kind'"),
        (WAVE + '[[prop]]\nkind = "drums"\n', 5, "Did you mean 'drum'"),
        (WAVE + '[[prop]]\nkind = "drum"\n', 4, "needs 'position', 3 numbers"),
        (WAVE + "[[prop]]\nkind = 'staff'\ncolour = 1\n", 6, "named 'colour'.*Valid: name"),
        (WAVE + "[[prop]]\nkind = 'staff'\n# \n\nmass = -2\n", 8, "mass of staff is -2"),
        (WAVE + "[[character.task]]\nkind = 'up'\n", 5, "No kind of task"),
        (WAVE + "[[character.task]]\nkind = 'upright'\nspan = [2, 1]\n", 6, "span is 2 to 1"),
        (WAVE + "[[character.task]]\nkind = 'upright'\nreference = 1\n", 6, "No key"),
        (WAVE + "[[character.offset]]\ntime = 1\n", 4, "needs 'position'"),
        (WAVE + "[[push]]\ntime = -1\nimpulse = [1, 0, 0]\n", 5, "time is -1"),
        (WAVE + "[[push]]\nkind = 'hard'\ntime = 1\nimpulse = [1, 0, 0]\n", 5, "named 'kind'"),
        (WAVE + "[[throw]]\ntime = 0.1\nflight = 0.4\n", 6, "cannot arrive"),
        (WAVE + 2 * "[[throw]]\ntime = 1\n", 6, "'ball' is thrown twice; .* add another"),
        (WAVE + "[[meet]]\ntime = 0.1\n", 4, "counted from 1"),
        (WAVE + "[[meet]]\ntime = 0.1\nhands = ['left', 'up']\n", 6, "2 of"),
        (WAVE + "[give_way]\nkind = 'soft'\n", 5, "named 'kind'"),
        ("kind = 'edit'\n" + WAVE, 1, "named 'kind'"),
        (WAVE + "kind = 'drum'\n", 4, "named 'kind'"),
        (WAVE + "[give_way]\nstrength = 2\n", 5, "0 to 1"),
        ('character = [\n  { clip = "a" },\n  { clip = "b", sped = 1 },\n]\n', 3, "'sped'"),
    ],
)
def test_a_mistake_is_one_line_that_names_its_line(said, text, line, words):
    with pytest.raises(EditError, match=words) as caught:
        said(text)
    message = str(caught.value)
    assert "\n" not in message
    assert caught.value.line == line
    assert message.startswith("edit.toml: " if line is None else f"edit.toml:{line}: ")


def test_hands_meet_only_where_speeds_are_alike(said):
    with pytest.raises(EditError, match="speed 1 and 2"):
        said(f"{WAVE}{WAVE}speed = 2\n[[meet]]\ntime = 0.1\n")


def test_files_that_are_none_are_refused(tmp_path):
    with pytest.raises(EditError, match="no such file"):
        read_edit(tmp_path / "none.toml")
    with pytest.raises(EditError, match="is a directory"):
        read_edit(tmp_path)
    with pytest.raises(us.UnderstudyError, match="name of an edit file"):
        read_edit(3)  # type: ignore[arg-type]
    with pytest.raises(EditError, match="no name of a file"):
        read_edit("a\0b")
    (tmp_path / "big.toml").write_bytes(b"#" * (MOST_BYTES + 1))
    with pytest.raises(EditError, match="more than"):
        read_edit(tmp_path / "big.toml")
    (tmp_path / "latin.toml").write_bytes(b"\n\ntitle = 'caf\xe9'\n")
    with pytest.raises(EditError, match=r"latin\.toml:3: is not UTF-8"):
        read_edit(tmp_path / "latin.toml")
