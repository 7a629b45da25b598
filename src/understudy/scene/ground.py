"""The ground: a plane, level or sloping, and steps on it."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from understudy.errors import InvalidValue, expect
from understudy.motion.rotations import Array
from understudy.scene import props

_COLOR: props.Color = (0.82, 0.84, 0.86, 1.0)
_STEP_COLOR: props.Color = (0.70, 0.72, 0.74, 1.0)


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Steps that go up: boxes, each one rise higher than the one before.

    Attributes:
        position: Middle of the first riser's foot [m], world: x, y.
        rise: Height of each step [m].
        run: Depth of each tread [m].
        width: [m].
        count: Number of steps.
        heading: Direction that goes up, from +x toward +y [rad].
        landing: Depth of the last tread [m]; None makes it as deep as the others.
    """

    position: tuple[float, float]
    rise: float = 0.17
    run: float = 0.29
    width: float = 1.2
    count: int = 3
    heading: float = 0.0
    landing: float | None = None

    def __post_init__(self) -> None:
        what = "steps"
        position = props.vector(self.position, "position", 2, "m", what=what)
        object.__setattr__(self, "position", position)
        props.number(self.rise, "rise", 0.005, 2.0, "m", what=what)
        props.number(self.run, "run", 0.05, 50.0, "m", what=what)
        props.number(self.width, "width", 0.05, 100.0, "m", what=what)
        props.number(self.heading, "heading", -100.0, 100.0, "rad", what=what)
        if self.landing is not None:
            props.number(self.landing, "landing", 0.05, 1000.0, "m", what=what)
        whole = isinstance(self.count, int) and not isinstance(self.count, bool)
        if not (whole and 1 <= self.count <= 200):
            raise InvalidValue(f"count of steps is {self.count!r}; it must be a whole 1 to 200.")

    @property
    def length(self) -> float:
        """From the first riser to the end of the last tread [m]."""
        last = self.run if self.landing is None else self.landing
        return self.run * (self.count - 1) + last

    def rises(self, points: ArrayLike) -> Array:
        """Height over their foot of the treads under points (..., 2) [m]; 0 beside them."""
        away = np.asarray(points, float) - np.array(self.position)
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        along = away[..., 0] * cos + away[..., 1] * sin
        across = away[..., 1] * cos - away[..., 0] * sin
        on = (along >= 0.0) & (along <= self.length) & (np.abs(across) <= 0.5 * self.width)
        number = np.minimum(np.floor(along / self.run) + 1.0, self.count)
        return np.where(on, number * self.rise, 0.0)


@dataclass(frozen=True, kw_only=True)
class Block:
    """A fixed box on the floor, to step, stand, sit or lean on.

    Attributes:
        position: Its middle [m], world: x, y.
        height: Of its top over z = 0 [m].
        length: Along its heading [m].
        width: Across [m].
        heading: Direction of its length, from +x toward +y [rad].
    """

    position: tuple[float, float]
    height: float
    length: float = 0.4
    width: float = 0.8
    heading: float = 0.0

    def __post_init__(self) -> None:
        what = "block"
        position = props.vector(self.position, "position", 2, "m", what=what)
        object.__setattr__(self, "position", position)
        props.number(self.height, "height", 0.005, 10.0, "m", what=what)
        props.number(self.length, "length", 0.02, 100.0, "m", what=what)
        props.number(self.width, "width", 0.02, 100.0, "m", what=what)
        props.number(self.heading, "heading", -100.0, 100.0, "rad", what=what)

    def rises(self, points: ArrayLike) -> Array:
        """Height of the top under points (..., 2) [m]; 0 beside it."""
        away = np.asarray(points, float) - np.array(self.position)
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        along = away[..., 0] * cos + away[..., 1] * sin
        across = away[..., 1] * cos - away[..., 0] * sin
        on = (np.abs(along) <= 0.5 * self.length) & (np.abs(across) <= 0.5 * self.width)
        return np.where(on, self.height, 0.0)


@dataclass(frozen=True, kw_only=True)
class Ground:
    """A plane through the origin, level unless it slopes, with or without steps and blocks.

    Attributes:
        friction: Coulomb coefficient between sole and ground.
        stiffness_time: Time constant of the contact [s]; the engine takes no less than two steps.
            Soles sink about 1 mm under an adult at 0.006 and 8 mm at 0.02.
        slope: Angle of the plane over the horizontal [rad].
        heading: Direction in which the slope goes up, from +x toward +y [rad].
        steps: Steps on it, or None; their foot is as high as the plane at their position.
        blocks: Things to step on, each of its own height.
    """

    friction: float = 1.0
    stiffness_time: float = 0.006
    slope: float = 0.0
    heading: float = 0.0
    steps: Steps | None = None
    blocks: tuple[Block, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "blocks", tuple(self.blocks))
        for block in self.blocks:
            expect(block, Block, "block", "a Block")
        if not (np.isfinite(self.friction) and self.friction >= 0):
            raise InvalidValue(f"friction is {self.friction}; it must be zero or positive.")
        if not 0.001 <= self.stiffness_time <= 0.5:
            raise InvalidValue(
                f"stiffness_time is {self.stiffness_time} s; it must lie between 0.001 and 0.5."
            )
        props.number(self.slope, "slope", -1.0, 1.0, "rad", what="the ground")
        props.number(self.heading, "heading", -100.0, 100.0, "rad", what="the ground")
        if self.steps is not None:
            expect(self.steps, Steps, "steps", "a Steps")

    @property
    def level(self) -> bool:
        """Whether it is the plane z = 0 and nothing else."""
        return self.slope == 0.0 and self.steps is None and not self.blocks

    @property
    def normal(self) -> Array:
        """Unit normal of the plane, upward, shape (3,)."""
        uphill = np.array([np.cos(self.heading), np.sin(self.heading), 0.0])
        return np.cos(self.slope) * np.array([0.0, 0.0, 1.0]) - np.sin(self.slope) * uphill

    def height(self, points: ArrayLike) -> Array:
        """Height of the ground under world points x, y (..., 2 or more) [m], shape (...)."""
        places = np.asarray(points, float)[..., :2]
        height = self._plane(places)
        if self.steps is not None:
            rises = self.steps.rises(places)
            top = self._plane(np.array(self.steps.position)) + rises
            height = np.where(rises > 0.0, np.maximum(height, top), height)
        for block in self.blocks:
            rises = block.rises(places)
            height = np.where(rises > 0.0, np.maximum(height, rises), height)
        return height

    def normals(self, points: ArrayLike) -> Array:
        """Unit normals of the ground under world points x, y (..., 2 or more), shape (..., 3)."""
        places = np.asarray(points, float)[..., :2]
        over = self.height(places) > self._plane(places)
        return np.where(over[..., None], np.array([0.0, 0.0, 1.0]), self.normal)

    def attach(self, spec: mujoco.MjSpec) -> None:
        """Add the plane and the steps to a scene that is being built."""
        plane = spec.worldbody.add_geom(
            name="ground",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 1.0],
            friction=[self.friction, 0.005, 0.0001],
            solref=[self.stiffness_time, 1.0],
            priority=1,
            contype=1,
            conaffinity=1,
            rgba=_COLOR,
        )
        if self.slope:
            plane.quat = props.upright(tuple(self.normal))
        if self.steps is not None:
            self._add_steps(spec, self.steps)
        for k, block in enumerate(self.blocks):
            base = float(self._plane(np.array(block.position)))
            bottom = min(0.0, base) - 0.5 * abs(np.tan(self.slope)) * (block.length + block.width)
            size = (block.length, block.width, block.height - bottom)
            self._add_box(
                spec, f"ground/block{k + 1}", block.position, block.height, size, block.heading
            )

    def _plane(self, places: Array) -> Array:
        along = places[..., 0] * np.cos(self.heading) + places[..., 1] * np.sin(self.heading)
        return np.tan(self.slope) * along

    def _add_steps(self, spec: mujoco.MjSpec, steps: Steps) -> None:
        """One box per step from under the plane up to its tread."""
        uphill = np.array([np.cos(steps.heading), np.sin(steps.heading)])
        base = float(self._plane(np.array(steps.position)))
        # A box reaches down to where the plane is lowest under the steps.
        reach = steps.length + steps.width
        depth = abs(np.tan(self.slope)) * reach
        for k in range(steps.count):
            start, end = k * steps.run, (k + 1) * steps.run
            if k == steps.count - 1:
                end = steps.length
            middle = np.array(steps.position) + 0.5 * (start + end) * uphill
            top = base + (k + 1) * steps.rise
            bottom = base - depth
            size = (end - start, steps.width, top - bottom)
            place = (float(middle[0]), float(middle[1]))
            self._add_box(spec, f"ground/step{k + 1}", place, top, size, steps.heading)

    def _add_box(
        self,
        spec: mujoco.MjSpec,
        name: str,
        place: tuple[float, float],
        top: float,
        size: tuple[float, float, float],
        heading: float,
    ) -> None:
        """A fixed box of that size [m] whose top is so high [m]."""
        spec.worldbody.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * side for side in size],
            pos=[*place, top - 0.5 * size[2]],
            quat=props.turned(heading),
            friction=[self.friction, 0.005, 0.0001],
            solref=[self.stiffness_time, 1.0],
            priority=1,
            contype=1,
            conaffinity=1,
            rgba=_STEP_COLOR,
        )
