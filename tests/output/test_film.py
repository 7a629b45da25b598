"""Video files: as many frames as the motion lasts, whole or not at all."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from understudy.errors import InvalidValue, MissingExtra, UnderstudyError
from understudy.motion.clip import Clip
from understudy.output import film
from understudy.output.film import at_even_times, ffmpeg, video
from understudy.take import Take

Image = pytest.importorskip("PIL.Image")
SMALL = {"width": 96, "height": 64, "renderer": "software"}


def frames_of(path: Path) -> np.ndarray:
    """A video decoded, shape (frames, height, width, 3)."""
    command = [ffmpeg(), "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    return np.frombuffer(done.stdout, np.uint8).reshape(-1, 64, 96, 3)


def test_film_lasts_as_long_as_the_motion(take: Take, tmp_path: Path) -> None:
    pytest.importorskip("imageio_ffmpeg")
    done = video(take, tmp_path / "a.mp4", fps=12.0, **SMALL)
    frames = frames_of(tmp_path / "a.mp4")
    assert done.frames == len(frames) == 13
    assert done.renderer == "software"
    assert frames.std() > 10 and not np.array_equal(frames[0], frames[-1])


def test_gif_keeps_real_time(clip: Clip, tmp_path: Path) -> None:
    done = video(clip, tmp_path / "a.gif", fps=15.0, **SMALL)
    with Image.open(tmp_path / "a.gif") as read:
        total = 0
        for k in range(read.n_frames):
            read.seek(k)
            total += read.info["duration"]
        assert read.n_frames == done.frames == 16
    assert total == pytest.approx(1000 * 16 / 15, abs=10)


@pytest.mark.parametrize("fps", [24.0, 30.0, 50.0, 60.0])
def test_frames_are_the_states_nearest_in_time(take: Take, fps: float) -> None:
    shown = at_even_times(take, fps)
    wanted = np.arange(shown.frames) / fps
    assert np.abs(shown.times - wanted).max() <= 0.5 / take.rate + 1e-9
    assert wanted[-1] <= take.duration < wanted[-1] + 1 / fps


def test_wrong_extension_and_rate_are_refused(clip: Clip, tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match=r"\.mp4 or a \.gif"):
        video(clip, tmp_path / "a.avi")
    with pytest.raises(InvalidValue, match="fps is 0"):
        video(clip, tmp_path / "a.mp4", fps=0.0)


def test_encoder_that_fails_says_why_and_leaves_no_file(
    clip: Clip, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = tmp_path / "ffmpeg"
    fake.write_text(f"#!{sys.executable}\nimport sys\nsys.exit('Unknown encoder libx264')\n")
    fake.chmod(0o755)
    monkeypatch.setattr(film, "ffmpeg", lambda: str(fake))
    out = tmp_path / "out"
    with pytest.raises(UnderstudyError, match="Unknown encoder libx264"):
        video(clip, out / "a.mp4", fps=12.0, **SMALL)
    assert not list(out.iterdir())


def test_without_ffmpeg_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(film.shutil, "which", lambda _: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtra, match=r"understudy\[video\]"):
        ffmpeg()
