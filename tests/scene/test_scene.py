"""Scenes compile to one model whose arrays say where each character lives."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

from bodies import chain
from understudy.character import adult_man, child
from understudy.errors import InvalidValue
from understudy.scene import Ground, Scene, timestep_for


def test_the_parts_of_two_characters_do_not_overlap_and_cover_the_state():
    scene = Scene(characters=(adult_man(), child()))
    model, (man, small) = scene.model, scene.parts
    assert (man.qpos.start, man.qpos.stop) == (0, small.qpos.start)
    assert small.qpos.stop == model.nq
    assert (man.dofs.start, man.dofs.stop, small.dofs.stop) == (0, small.dofs.start, model.nv)
    assert model.body(small.bodies[0]).name == "b/pelvis"
    controls = [*man.root_controls, *small.root_controls]
    controls += [a + i for part in (man, small) for a in part.joint_controls for i in range(4)]
    assert sorted(controls) == list(range(model.nu))


def test_engine_options_are_the_ones_servos_need():
    option = Scene(characters=(chain(2),)).model.opt
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    np.testing.assert_array_equal(option.gravity, [0.0, 0.0, -9.81])


@pytest.mark.parametrize("rate", [15.0, 23.976, 30.0, 60.0, 100.0, 120.0, 240.0, 1000.0])
def test_the_time_step_divides_the_frame_period_and_lies_near_2_ms(rate):
    step = timestep_for(rate)
    frames = 1.0 / (rate * step)
    assert frames == pytest.approx(round(frames), abs=1e-9)
    assert 0.0009 < step < 0.003


@dataclass(frozen=True)
class Ball:
    def attach(self, spec: mujoco.MjSpec) -> None:
        body = spec.worldbody.add_body(name="ball", pos=[1.0, 0.0, 2.0])
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0.0, 0.0], mass=0.5)


def test_props_attach_themselves():
    scene = Scene(characters=(chain(2),), props=(Ball(),))
    assert scene.model.body("ball").mass[0] == pytest.approx(0.5)
    assert scene.model.nv == 3 + 3 * 2 + 6


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_a_body_alone_falls_the_same_whether_or_not_islands_are_looked_for(integrator):
    scene = Scene(characters=(adult_man(),), ground=Ground(), integrator=integrator)
    off = int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
    ends = []
    for flags in (off, 0):
        model = scene.spec().compile()
        assert model.opt.disableflags & off
        model.opt.disableflags &= ~off
        model.opt.disableflags |= flags
        data = mujoco.MjData(model)
        data.qpos[2], data.qvel[0] = 1.1, 1.0
        touching = 0
        for _ in range(400):
            mujoco.mj_step(model, data)
            touching += data.ncon > 0
        assert touching > 100 and np.isfinite(data.qpos).all()
        ends.append(data.qpos.copy())
    np.testing.assert_array_equal(*ends)


def test_islands_are_looked_for_where_there_is_more_than_a_body():
    off = int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
    for scene in (
        Scene(characters=(adult_man(), child())),
        Scene(characters=(adult_man(),), props=(Ball(),)),
    ):
        assert not scene.model.opt.disableflags & off


def test_scenes_that_make_no_sense_are_refused():
    with pytest.raises(InvalidValue, match="at least one character"):
        Scene(characters=())
    with pytest.raises(InvalidValue, match="timestep"):
        Scene(characters=(chain(1),), timestep=1.0)
    with pytest.raises(InvalidValue, match="friction"):
        Ground(friction=-1.0)
    with pytest.raises(InvalidValue, match="gravity"):
        Scene(characters=(chain(1),), gravity=float("nan"))


@pytest.mark.parametrize(
    ("position", "inside"), [((1.5, 0.0, -0.1), "ground"), ((1.0, 0.0, 0.75), "table")]
)
def test_a_loose_prop_that_begins_inside_something_is_refused(position, inside):
    import understudy as us
    from understudy.character import adult_man
    from understudy.scene import Ball, Table

    clip = us.sample("gesture").trimmed(0.0, 0.2)
    props = [Ball(position=position), Table(position=(1.0, 0.0), size=(0.5, 0.5))]
    with pytest.raises(InvalidValue, match=f"'ball' begins .* mm inside '{inside}'"):
        us.track(clip, adult_man(), props=props, contacts=[("ball", "table")])
    high = [Ball(position=(*position[:2], 1.2)), props[1]]
    us.track(clip, adult_man(), props=high, contacts=[("ball", "table")])


def test_integrators_go_by_name():
    discrete = Scene(characters=(chain(2),), integrator="discrete")
    assert discrete.model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
    with pytest.raises(InvalidValue, match="integrator is 'rk4'; it must be one of"):
        Scene(characters=(chain(2),), integrator="rk4")  # type: ignore[arg-type]
