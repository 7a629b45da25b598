"""Plain functions compiled by numba, with the plain functions they call.

Laws are written as ordinary scalar Python, so that they can be read, stepped through and tested as
they are. numba is imported when a law is first compiled, not before.
"""

from __future__ import annotations

import functools
import types
from collections.abc import Iterator
from typing import Any

from understudy.control.controller import EngineState

_FLAT = ("qpos", "qvel", "sensordata")
# numba's cache looks at the file of the function alone. Files of an installed package change
# together; in a checkout a function that calls into another file is compiled anew every time.
_INSTALLED = "-packages" in __file__


@functools.cache
def compiled(function: Any, signature: Any = None) -> Any:
    """A function compiled by numba: it holds no lock, and where safe the result is kept on disk.

    Plain functions that it calls are compiled into it. A function that numba has compiled already
    is compiled again from its source.

    Args:
        function: A plain function of scalars, tuples and arrays.
        signature: Its numba signature; by default it is compiled for what it is called with.
    """
    import numba
    from numba.extending import register_jitable

    function = getattr(function, "py_func", function)
    files = {function.__code__.co_filename}
    for helper in _helpers(function):
        register_jitable(helper)
        files.add(helper.__code__.co_filename)
    ours = str(getattr(function, "__module__", "")).startswith("understudy.")
    given = () if signature is None else (signature,)
    return numba.njit(*given, nogil=True, cache=ours and (_INSTALLED or len(files) == 1))(function)


@functools.cache
def compiled_law(law: Any) -> Any:
    """A law compiled for what every law is called with."""
    return compiled(law, law_signature())


@functools.cache
def law_signature() -> Any:
    """The numba signature of every law: time, state, ctrl, applied, parameters, memory."""
    from numba import types as t

    row = t.float64[::1]
    arrays = [row if name in _FLAT else t.float64[:, ::1] for name in EngineState._fields]
    return t.void(t.float64, t.NamedTuple(arrays, EngineState), row, row, row, row)


def _helpers(function: Any) -> Iterator[Any]:
    """Plain Python functions that a function calls by name, and that those call."""
    seen, queue = {function}, [function]
    while queue:
        one = queue.pop()
        for name in one.__code__.co_names:
            called = one.__globals__.get(name)
            if isinstance(called, types.FunctionType) and called not in seen:
                seen.add(called)
                queue.append(called)
                yield called
