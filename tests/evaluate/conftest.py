"""Takes shared by the tests of this folder."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_takes import body_spec, simulated


@pytest.fixture(scope="session")
def thrown() -> Any:
    """The body thrown up in the air, spinning, its arm driven by a stiff servo."""

    def swing(time: float, data: Any) -> None:
        angle = 0.5 * np.sin(12.0 * time)
        data.ctrl[0:4] = [np.cos(angle), 0, np.sin(angle), 0]

    return simulated(
        body_spec(servo=400.0, step=0.0005),
        0.6,
        qpos=[0, 0, 2.0],
        qvel=[1.0, 0.5, 3.0, 0.5, 1.0, 2.0],
        control=swing,
    )


@pytest.fixture(scope="session")
def standing() -> Any:
    """The body resting on the ground for a second."""
    return simulated(body_spec(servo=200.0), 1.0, qpos=[0, 0, 0.05])
