"""What drives the joints: the controller protocols, clip tracking, the rigid-body drive.

In: a `Scene` and a reference `Clip`. Out: controls for `simulate`; nothing here steps the engine.
"""

from understudy.control.controller import (
    Compiled,
    Controller,
    Controls,
    EngineState,
    OpenLoop,
    PythonController,
)
from understudy.control.drive import Drive
from understudy.control.tracking import Tracking

__all__ = [
    "Compiled",
    "Controller",
    "Controls",
    "Drive",
    "EngineState",
    "OpenLoop",
    "PythonController",
    "Tracking",
]
