"""What drives the joints: controller protocols, clip tracking, tasks, the rigid-body drive.

In: a `Scene` and a reference `Clip`. Out: controls for `simulate`; nothing here steps the engine.
"""

from understudy.control.balance import Balance
from understudy.control.controller import (
    Compiled,
    Controller,
    Controls,
    EngineState,
    OpenLoop,
    PythonController,
)
from understudy.control.disturbance import Disturbance, Push, Throw
from understudy.control.drive import Drive
from understudy.control.give_way import GiveWay
from understudy.control.guidance import Guidance
from understudy.control.look_at import LookAt
from understudy.control.reach import HandOn, Reach
from understudy.control.task import Task
from understudy.control.tracking import Tracking
from understudy.control.upright import Upright

__all__ = [
    "Balance",
    "Compiled",
    "Controller",
    "Controls",
    "Disturbance",
    "Drive",
    "EngineState",
    "GiveWay",
    "Guidance",
    "HandOn",
    "LookAt",
    "OpenLoop",
    "Push",
    "PythonController",
    "Reach",
    "Task",
    "Throw",
    "Tracking",
    "Upright",
]
