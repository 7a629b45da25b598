"""Takes on disk: the same bits back, and one clear line for every file that is none."""

import dataclasses
import io
import json
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from understudy.errors import UnderstudyError
from understudy.output.take_file import is_take_file, load_take, save_take
from understudy.take import Take


@pytest.fixture(scope="module")
def stored(take: Take, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("takes") / "walk.npz"
    save_take(take, path)
    return path


def test_take_comes_back_bit_for_bit(take: Take, stored: Path) -> None:
    read = load_take(stored)
    for name in ("times", "qpos", "qvel", "ctrl", "qfrc_applied"):
        assert np.array_equal(getattr(read, name), getattr(take, name)), name
    assert (read.rate, read.seed, read.facts) == (take.rate, take.seed, take.facts)
    assert read.performance is None


def test_scene_and_clips_come_back(take: Take, stored: Path) -> None:
    read = load_take(stored)
    assert read.scene.model.nq == take.scene.model.nq
    assert np.array_equal(read.scene.model.body_inertia, take.scene.model.body_inertia)
    assert np.array_equal(read.model.actuator_gainprm, take.model.actuator_gainprm)
    before, after = take.captured[0], read.captured[0]
    assert before is not None and after is not None
    assert after.skeleton == before.skeleton
    assert np.array_equal(after.rotations, before.rotations)
    assert read.clip().rotations == pytest.approx(take.clip().rotations)


def test_numpy_opens_the_arrays_without_pickle(stored: Path, take: Take) -> None:
    with np.load(stored, allow_pickle=False) as file:
        (name,) = [n for n in file.files if n.endswith("take.qpos")]
        assert np.array_equal(file[name], take.qpos)


def test_saving_twice_gives_the_same_arrays(take: Take, stored: Path, tmp_path: Path) -> None:
    save_take(load_take(stored), tmp_path / "again.npz")
    with zipfile.ZipFile(stored) as a, zipfile.ZipFile(tmp_path / "again.npz") as b:
        assert a.namelist() == b.namelist()
        assert all(a.read(n) == b.read(n) for n in a.namelist())


def test_every_truncation_is_one_clear_error(stored: Path, tmp_path: Path) -> None:
    data = stored.read_bytes()
    for cut in (0, 1, 30, 1000, len(data) // 2, len(data) - 30, len(data) - 1):
        short = tmp_path / "short.npz"
        short.write_bytes(data[:cut])
        assert not is_take_file(short)
        with pytest.raises(UnderstudyError, match=r"short\.npz: ") as caught:
            load_take(short)
        assert "\n" not in str(caught.value)


def test_flipped_bytes_never_escape_as_another_error(stored: Path, tmp_path: Path) -> None:
    data, rng = stored.read_bytes(), np.random.default_rng(3)
    head = data.find(b"PK\x03\x04", 4)  # the JSON text comes first
    for _ in range(25):
        broken = bytearray(data)
        for at in rng.integers(0, min(head, len(data)), 3):
            broken[at] ^= 1 << int(rng.integers(8))
        bad = tmp_path / "bad.npz"
        bad.write_bytes(broken)
        try:
            load_take(bad)
        except UnderstudyError as error:
            assert str(bad) in str(error)


def edited(stored: Path, path: Path, change) -> Path:
    """The same file with its JSON text changed in place."""
    with zipfile.ZipFile(stored) as old, zipfile.ZipFile(path, "w") as new:
        document = json.loads(old.read("take.json"))
        change(document)
        new.writestr("take.json", json.dumps(document))
        for name in old.namelist()[1:]:
            new.writestr(name, old.read(name))
    return path


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(version=99), "version 99"),
        (lambda d: d.update(format="other"), "no take file"),
        (lambda d: d["take"].update(type="os.system"), "holds no take"),
        (lambda d: d["take"]["fields"]["scene"].update(type="subprocess.Popen"), "no value of"),
        (lambda d: d["take"]["fields"]["scene"].update(type="understudy.scene.os"), "not have"),
        (lambda d: d["take"]["fields"].update(surprise=1), "does not know"),
        (lambda d: d["take"]["fields"].update(qpos={"zeros": [481, 2]}), "qpos has shape"),
        (lambda d: d["take"]["fields"].update(qpos={"zeros": [10**6, 10**6]}), "shape"),
        (lambda d: d["take"]["fields"].update(qpos={"array": "nowhere"}), "nowhere"),
        (lambda d: d["model"]["pairs"].append(["__class__", 3]), "changes '__class__'"),
        (lambda d: d["model"]["pairs"].append(["body_parentid", 3]), "changes 'body_parentid'"),
        (lambda d: d["model"]["pairs"].append(["geom_size", 1.0]), "does not fit"),
        (lambda d: d["model"]["pairs"].append(["opt.timestep", "abc"]), "opt.timestep is 'abc'"),
        (lambda d: d["model"]["pairs"].append(["opt.timestep", -1.0]), "opt.timestep is -1"),
        (lambda d: d["model"]["pairs"].append(["opt.integrator", 99]), "opt.integrator is 99"),
        (lambda d: d["model"]["pairs"].append(["opt.iterations", "x"]), "opt.iterations is 'x'"),
        (
            lambda d: d["take"]["fields"]["scene"]["fields"].update(timestep="abc"),
            "timestep is 'abc'",
        ),
        (
            lambda d: d["take"]["fields"]["references"]["tuple"][0]["fields"].update(skeleton=7),
            "holds a Clip|skeleton",
        ),
    ],
)
def test_hostile_file_is_refused_in_one_line(
    stored: Path, tmp_path: Path, change, said: str
) -> None:
    path = edited(stored, tmp_path / "hostile.npz", change)
    with pytest.raises(UnderstudyError, match=said) as caught:
        load_take(path)
    assert "\n" not in str(caught.value)


def test_nothing_is_ever_unpickled(stored: Path, tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self):
            return (print, ("unpickled",))

    path = tmp_path / "pickle.npz"
    with zipfile.ZipFile(stored) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            if name.endswith("take.qpos.npy"):
                header = b"{'descr': '|O', 'fortran_order': False, 'shape': (1,), }"
                header += b" " * (117 - len(header)) + b"\n"
                data = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header
                data += pickle.dumps(np.array([Bomb()], object))
            new.writestr(name, data)
    with pytest.raises(UnderstudyError, match="damaged"):
        load_take(path)


def test_missing_file_and_other_files_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(UnderstudyError, match="there is no such file"):
        load_take(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("hello")
    with pytest.raises(UnderstudyError, match="no take file"):
        load_take(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(UnderstudyError, match="no entry"):
        load_take(tmp_path / "other.npz")


def test_value_that_is_no_plain_data_is_refused(take: Take, tmp_path: Path) -> None:
    odd = dataclasses.replace(take, facts={"law": print})
    with pytest.raises(UnderstudyError, match=r"take\.facts\.law is a builtin"):
        save_take(odd, tmp_path / "odd.npz")
    assert not list(tmp_path.iterdir())


def test_runs_differ_only_in_their_computing_times(take: Take, tmp_path: Path) -> None:
    for name, seconds in (("a.npz", 1.0), ("b.npz", 2.0)):
        facts = {**take.facts, "cpu_seconds": seconds}
        save_take(dataclasses.replace(take, facts=facts), tmp_path / name)
        assert load_take(tmp_path / name).facts == facts
    documents = []
    with zipfile.ZipFile(tmp_path / "a.npz") as a, zipfile.ZipFile(tmp_path / "b.npz") as b:
        assert all(entry.date_time == (1980, 1, 1, 0, 0, 0) for entry in a.infolist())
        arrays = [name for name in a.namelist() if name != "take.json"]
        assert all(a.read(name) == b.read(name) for name in arrays)
        documents = [json.loads(file.read("take.json")) for file in (a, b)]
    assert documents[0] != documents[1]
    for document in documents:
        del document["timing"]
    assert documents[0] == documents[1]


def test_the_same_take_is_the_same_bytes(take: Take, tmp_path: Path) -> None:
    save_take(take, tmp_path / "a.npz")
    save_take(take, tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize("rate", [None, 1e30, 0.0, "fast"])
def test_a_rate_that_no_take_has_is_refused(rate: object, stored: Path, tmp_path: Path) -> None:
    def change(document: dict) -> None:
        document["take"]["fields"]["rate"] = rate

    with pytest.raises(UnderstudyError, match="has rate"):
        load_take(_changed(stored, tmp_path, change))


@pytest.mark.parametrize("value", [float("nan"), -0.5, 2.0])
def test_a_color_that_cannot_be_drawn_is_refused(
    value: float, stored: Path, tmp_path: Path
) -> None:
    def change(document: dict) -> None:
        text = json.dumps(document)
        start = text.index('"rgba": {"tuple": [') + len('"rgba": {"tuple": [')
        text = text[:start] + json.dumps(value) + text[text.index(",", start) :]
        document.clear()
        document.update(json.loads(text))

    with pytest.raises(UnderstudyError, match="a color is four"):
        load_take(_changed(stored, tmp_path, change))


@pytest.mark.parametrize(
    ("entry", "wrong", "said"),
    [
        ("qvel", lambda a: 1e200 * (1.0 + np.abs(a)), "qvel has values that are not finite"),
        ("ctrl", lambda a: np.nan * a, "ctrl has values that are not finite"),
        ("faces", lambda a: a + 10**6, "faces has .* each from 0 to the last"),
        ("faces", lambda a: a - 5, "faces has"),
        ("faces", lambda a: a + 0.5, "faces has .* whole numbers"),
        ("faces", lambda a: a[:, :2], r"faces has shape \(.*, 2\)"),
        ("actuator_gainprm", lambda a: np.nan * a, "actuator_gainprm .* not finite"),
        ("actuator_gainprm", lambda a: a[1:], "does not fit"),
    ],
)
def test_numbers_that_no_body_has_are_refused_in_one_line(
    entry: str, wrong: Callable[[Any], Any], said: str, stored: Path, tmp_path: Path
) -> None:
    path = tmp_path / "wrong.npz"
    met = 0
    with zipfile.ZipFile(stored) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            if name.endswith(f".{entry}.npy"):
                block = io.BytesIO()
                np.save(block, wrong(np.load(io.BytesIO(data))))
                data, met = block.getvalue(), met + 1
            new.writestr(name, data)
    assert met > 0
    with pytest.raises(UnderstudyError, match=said) as caught:
        load_take(path)
    assert "\n" not in str(caught.value)


def _changed(stored: Path, folder: Path, change) -> Path:
    """A copy of a take file with another JSON text."""
    path = folder / "changed.npz"
    with zipfile.ZipFile(stored) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            if name == "take.json":
                document = json.loads(data)
                change(document)
                data = json.dumps(document).encode()
            new.writestr(name, data)
    return path
