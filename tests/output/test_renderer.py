"""Choosing a renderer: OpenGL where it works, software everywhere else, silently."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest

from understudy.errors import UnderstudyError, UnknownName
from understudy.output import gl
from understudy.output.playback import Playback
from understudy.output.renderer import opened


@pytest.fixture
def no_library(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(gl, "_candidates", list)
    gl.backend.cache_clear()
    yield
    gl.backend.cache_clear()


@pytest.mark.usefixtures("no_library")
def test_without_a_graphics_library_software_draws(model: mujoco.MjModel) -> None:
    assert gl.backend() is None
    assert opened(model, 64, 48).name == "software"
    with pytest.raises(UnderstudyError, match="renderer='software'"):
        opened(model, 64, 48, renderer="opengl")


def test_broken_library_is_found_out_without_a_word(
    model: mujoco.MjModel, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(gl, "_candidates", lambda: ["no_such_backend"])
    gl.backend.cache_clear()
    try:
        assert opened(model, 64, 48, renderer="auto").name == "software"
    finally:
        gl.backend.cache_clear()
    assert capfd.readouterr() == ("", "")


def test_library_that_kills_its_process_is_survived(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gl, "_candidates", lambda: ["egl"])
    monkeypatch.setattr(gl, "_PROBE", "import os; os.abort()")
    gl.backend.cache_clear()
    try:
        assert gl.backend() is None
    finally:
        gl.backend.cache_clear()


def test_unknown_renderer_is_refused(model: mujoco.MjModel) -> None:
    with pytest.raises(UnknownName, match="software"):
        opened(model, 64, 48, renderer="softwear")


def test_software_drawing_loads_no_graphics_library() -> None:
    code = (
        "import sys, mujoco, numpy as np\n"
        "from understudy.output.renderer import opened\n"
        "opened(mujoco.MjModel.from_xml_string('<mujoco/>'), 32, 32, renderer='software')\n"
        "assert not [m for m in sys.modules if m.startswith('OpenGL') or m == 'PIL']\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_opengl_sees_the_body_where_software_does(playing: Playback) -> None:
    if gl.backend() is None:
        pytest.skip("no OpenGL library on this machine")
    shot, masks = playing.shot("follow-side", 4 / 3), []
    for name in ("opengl", "software"):
        drawing = opened(playing.model, 160, 120, renderer=name, spec=playing.spec, shadows=False)
        assert drawing.name == name
        away = playing.qpos[8].copy()
        away[2] = -50.0  # under the ground
        pictures = [drawing.picture(q, shot.camera(8)) for q in (playing.qpos[8], away)]
        drawing.close()
        masks.append((np.abs(np.subtract(*pictures, dtype=int)) > 25).any(axis=2))
    agreed = (masks[0] & masks[1]).sum() / (masks[0] | masks[1]).sum()
    assert agreed > 0.85
