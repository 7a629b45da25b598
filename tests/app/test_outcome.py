"""Plain values for JSON and aligned tables."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from understudy.app.outcome import plain, table


def test_plain_values_survive_json():
    value = {
        "array": np.arange(3),
        "scalar": np.float64(0.5),
        "nan": np.nan,
        "inf": np.array([np.inf, 1.0]),
        "path": Path("a") / "b",
        "flag": np.bool_(True),
        "nested": [{"x": (1, None)}],
        3: "three",
    }
    assert json.loads(json.dumps(plain(value), allow_nan=False)) == {
        "array": [0, 1, 2],
        "scalar": 0.5,
        "nan": None,
        "inf": [None, 1.0],
        "path": "a/b",
        "flag": True,
        "nested": [{"x": [1, None]}],
        "3": "three",
    }


def test_a_table_aligns_its_columns():
    text = table([("clip", "deg"), ("a", "1.0"), ("longer", "10.0")], right=(1,))
    assert text.splitlines() == ["clip     deg", "------------", "a        1.0", "longer  10.0"]
