"""PNG files written without a library are read by one."""

import io

import numpy as np
import pytest

from understudy.output.png import encoded, write_png

Image = pytest.importorskip("PIL.Image")


def test_pixels_and_text_survive(tmp_path) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (17, 31, 3), np.uint8)
    write_png(tmp_path / "a.png", pixels, {"Renderer": "software", "Title": "Läufer"})
    with Image.open(tmp_path / "a.png") as read:
        assert np.array_equal(np.asarray(read), pixels)
        assert read.text == {"Renderer": "software", "Title": "Läufer"}


def test_gradients_compress() -> None:
    pixels = np.broadcast_to(np.arange(200, dtype=np.uint8)[:, None, None], (200, 300, 3))
    data = encoded(pixels)
    assert len(data) < 2000
    with Image.open(io.BytesIO(data)) as read:
        assert np.array_equal(np.asarray(read), pixels)
