"""Numbers of a stored model: those that differ come back, and none that no body has is set."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

from understudy.errors import UnderstudyError
from understudy.output.take_model import changes, set_number
from understudy.take import Take


def test_what_differs_is_all_that_is_kept_and_it_comes_back(take: Take) -> None:
    before, after = take.scene.model, copy.copy(take.scene.model)
    after.dof_armature[7] += 0.25
    after.opt.timestep, after.opt.iterations = 0.003, 17
    found = changes(before, after)
    assert set(found) == {"dof_armature", "opt.timestep", "opt.iterations"}
    again = copy.copy(before)
    for name, value in found.items():
        set_number(again, name, value)
    assert changes(after, again) == {}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda a: a - 1.0, "dof_armature of the model is -1 .* negative"),
        (lambda a: a + 1e30, "dof_armature of the model has .* beyond"),
        (lambda a: a * np.nan, "not finite"),
        (lambda a: a[1:], "does not fit"),
        (lambda a: a.astype(str), "not finite"),
    ],
)
def test_an_armature_that_no_body_has_is_refused(change: Any, said: str, take: Take) -> None:
    model = copy.copy(take.scene.model)
    wrong = change(np.zeros(model.nv))
    with pytest.raises(UnderstudyError, match=said):
        set_number(model, "dof_armature", wrong)
    assert np.array_equal(model.dof_armature, take.scene.model.dof_armature)
