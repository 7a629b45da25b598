"""The compiled part of the search: every child of a window, one after the other.

Importing this compiles the loop of `simulate` or takes it from numba's cache.
"""

from __future__ import annotations

from numba import types

from understudy.control.guidance_law import DOF, HELP, posture, spare, steer
from understudy.simulate.loop import step1, step2

_STAGE = types.void(types.uintp, types.uintp)
kinematics = types.ExternalFunction("mj_kinematics", _STAGE)
com_pos = types.ExternalFunction("mj_comPos", _STAGE)
com_vel = types.ExternalFunction("mj_comVel", _STAGE)


def run_children(  # type: ignore[no-untyped-def]
    model,
    data,
    first,
    last,
    parents,
    start,
    end,
    state,
    inputs,
    offsets,
    held,
    ctrl,
    applied,
    parameters,
    postures,
):
    """Run children `first` to `last` through a window.

    `start` and `end` are positions, velocities and warm starts; `inputs` the engine's warm start,
    controls and forces; `ctrl` and `applied` what is laid down, a row per step; `held` the help.
    """
    dof = int(parameters[DOF])
    for child in range(first, last):
        parent = parents[child]
        state.qpos[:] = start[0][parent]
        state.qvel[:] = start[1][parent]
        inputs[0][:] = start[2][parent]
        for step in range(len(ctrl)):
            step1(model, data)
            inputs[1][:] = ctrl[step]
            steer(inputs[1], parameters, offsets[child])
            spare(state, inputs[1], parameters)
            inputs[2][:] = applied[step]
            for k in range(HELP):
                inputs[2][dof + k] += held[child, k]
            step2(model, data)
        end[0][child] = state.qpos
        end[1][child] = state.qvel
        end[2][child] = inputs[0]
        kinematics(model, data)
        com_pos(model, data)
        com_vel(model, data)
        posture(state, parameters, postures[child])
