"""The standard figure has human proportions."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.errors import InvalidValue
from understudy.motion.figure import LINKS, PARENTS, ROLES, figure
from understudy.motion.mirror import partners, reflected, sagittal_axis


@pytest.mark.parametrize("sex", ["male", "female"])
@pytest.mark.parametrize("height", [1.1, 1.75])
def test_figure_stands_on_the_floor_with_its_stature(sex, height):
    body = figure(height, sex)
    rest = body.rest_positions()
    tops = rest[list(body.end_joints)] + body.end_offsets
    assert abs(tops[:, 2].max() - height) < 1e-9
    assert 0.0 < min(rest[:, 2].min(), tops[:, 2].min()) < 0.02 * height


def test_figure_is_symmetric_faces_x_and_has_left_on_y():
    body = figure()
    rest = body.rest_positions()
    assert rest[body.index("left_knee"), 1] > 0
    assert rest[body.index("left_ball"), 0] > rest[body.index("left_ankle"), 0]
    axis = sagittal_axis(body)
    np.testing.assert_allclose(axis, [0, 1, 0])
    np.testing.assert_allclose(reflected(rest[list(partners(body))], axis), rest, atol=1e-12)


def test_every_role_has_a_link_and_a_parent():
    assert set(LINKS) == set(ROLES)
    assert set(PARENTS) == set(ROLES) - {"pelvis"}


@pytest.mark.parametrize(("height", "sex"), [(0.1, "male"), (9.0, "male"), (1.7, "other")])
def test_figures_outside_the_tables_are_refused(height, sex):
    with pytest.raises(InvalidValue):
        figure(height, sex)
