"""The compiled loop: laws and the engine's two half steps, one after the other.

Importing this compiles the loop, or takes it from numba's cache on disk; `simulate` does so when a
performance first needs it. The engine's functions are found by name in its own library.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import llvmlite.binding as llvm
import mujoco
import numba
from numba import types
from numba.core.errors import NumbaExperimentalFeatureWarning
from numba.extending import register_jitable

from understudy.control.compiling import law_signature

MOST_LAWS = 8

_PATTERNS = ("libmujoco*.so*", "libmujoco*.dylib", "mujoco.dll")
_FOLDER = Path(mujoco.__path__[0])
llvm.load_library_permanently(
    str(next(path for pattern in _PATTERNS for path in sorted(_FOLDER.glob(pattern))))
)
_STEP = types.void(types.uintp, types.uintp)
step1 = types.ExternalFunction("mj_step1", _STEP)
step2 = types.ExternalFunction("mj_step2", _STEP)

_LAW = law_signature()
_ROW, _BLOCK, _COUNTS = types.float64[::1], types.float64[:, ::1], types.int64[::1]
_REST = types.Tuple(
    (
        *(types.uintp, types.uintp, types.int64, types.int64, types.float64),
        *(_COUNTS, _ROW, _COUNTS, _ROW, _LAW.args[1]),
        *(_ROW, _ROW, _ROW, _BLOCK, _BLOCK, _BLOCK, _BLOCK, _BLOCK),
    )
)


@register_jitable
def _run(  # type: ignore[no-untyped-def]
    laws,
    model,
    data,
    first,
    last,
    dt,
    parameters_at,
    parameters,
    memory_at,
    memory,
    state,
    act,
    control,
    force,
    push,
    ctrl,
    applied,
    pushes,
    out,
):
    """Steps `first` to `last`: every law in turn changes its row of controls; the engine steps.

    As many of the laws run as `parameters_at` has stretches. `control`, `force` and `push` are
    views of the engine's inputs, `ctrl`, `applied` and `pushes` (which may have no columns) their
    values by step; states go to `out`.
    """
    count = len(parameters_at) - 1
    nq, nv, na = state.qpos.size, state.qvel.size, act.size
    for step in range(first, last):
        step1(model, data)
        for k in range(count):
            laws[k](
                step * dt,
                state,
                ctrl[step],
                applied[step],
                parameters[parameters_at[k] : parameters_at[k + 1]],
                memory[memory_at[k] : memory_at[k + 1]],
            )
        control[:] = ctrl[step]
        force[:] = applied[step]
        for j in range(pushes.shape[1]):
            push[j // 6, j % 6] = pushes[step, j]
        step2(model, data)
        out[step + 1, 0] = (step + 1) * dt
        out[step + 1, 1 : 1 + nq] = state.qpos
        out[step + 1, 1 + nq : 1 + nq + nv] = state.qvel
        out[step + 1, 1 + nq + nv : 1 + nq + nv + na] = act


def _one(law, rest):  # type: ignore[no-untyped-def]
    _run((law, law), *rest)


def _several(law0, law1, law2, law3, law4, law5, law6, law7, rest):  # type: ignore[no-untyped-def]
    _run((law0, law1, law2, law3, law4, law5, law6, law7), *rest)


with warnings.catch_warnings():
    # Functions as values are still called experimental there.
    warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
    _FUNCTION = types.FunctionType(_LAW)
    one = numba.njit(types.void(_FUNCTION, _REST), nogil=True, cache=True)(_one)
    several = numba.njit(types.void(*[_FUNCTION] * MOST_LAWS, _REST), nogil=True, cache=True)(
        _several
    )


def idle(time, state, ctrl, applied, parameters, memory):  # type: ignore[no-untyped-def]
    """A law that does nothing, to fill the places of `several`."""
