"""What drives the joints: the controller protocols, the servos and clip tracking.

In: a `Scene` and a reference `Clip`. Out: controls for `simulate`; nothing here steps the engine.
"""

from understudy.control.controller import (
    Compiled,
    Controller,
    Controls,
    OpenLoop,
    PythonController,
)
from understudy.control.tracking import Tracking

__all__ = ["Compiled", "Controller", "Controls", "OpenLoop", "PythonController", "Tracking"]
