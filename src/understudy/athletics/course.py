"""Where an athlete is to go: speed and facing direction over time, or along a path.

The same outer loop serves every athlete: it limits how fast speed and heading change, removes the
bias between the speed asked for and the speed reached by slow integrals, and turns a path into a
heading and a turning rate. The law part is scalar and runs compiled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from understudy.control.trajectory import bounded, toward
from understudy.errors import InvalidValue
from understudy.motion.rotations import Array
from understudy.motion.skeleton import frozen_array

# Parameters at the head of a course: limits, gains, counts; then rows of time, speed, heading,
# then rows of x, y, heading along the path.
# fmt: off
(
    C_ACCELERATION, C_TURNING, C_SPEED_GAIN, C_SIDE_GAIN, C_PATH_GAIN, C_PATH_SUM,
    C_ROWS, C_POINTS, C_CLOSED, C_BENDING
) = range(10)
# fmt: on
C_TABLE = 10
# Memory: the limited commands, the biases, running means, the place on the path; then what a
# start or a stop changes of the run: how much further back feet are put [m], damping of the knee,
# stiffness of the thrust (a share), forward lean.
# fmt: off
(
    SPEED, HEADING, SPEED_BIAS, SIDE_BIAS, MEAN_SPEED, MEAN_SIDE, SEGMENT, PATH_BIAS,
    ASIDE, TURNING, LEAD, MORE_DAMPING, MORE_THRUST, MORE_LEAN
) = range(14)
# fmt: on
COURSE_MEMORY = 14
# The means run over about two steps [s]; the heading closes on a path's in this time [s].
_MEAN, _CLOSING = 0.7, 0.35
_MOST_BIAS, _MOST_SIDE, _MOST_AIM = 4.0, 0.4, 0.35
# Desired speeds under this one are standing [m/s]: a runner starts when they rise over it.
LEAST = 1.0
# Points of a path lie this far apart [m].
_SPACING = 0.5


def wrapped(angle):  # type: ignore[no-untyped-def]
    """The same angle between minus and plus half a turn."""
    return math.atan2(math.sin(angle), math.cos(angle))


def followed_course(time, dt, p, at, m, mat, state, body, yaw, east, north):  # type: ignore[no-untyped-def]
    """One step of the outer loop.

    Args:
        time: [s].
        dt: Time step [s].
        p: Parameters; the course begins at `at`.
        at: See above.
        m: Memory; the course's begins at `mat`.
        mat: See above.
        state: The engine's; the center of mass is that of all outboard of `body`.
        body: Number of the pelvis.
        yaw: Facing direction [rad].
        east: Velocity of the center of mass along world x [m/s].
        north: Along world y [m/s].

    Returns:
        Speed to ask of the controller and sideways speed (both with what removes the bias) [m/s],
        heading error [rad], desired turning rate [rad/s], and the commanded speed [m/s].
    """
    row = at + C_TABLE
    goal_speed, goal_heading, slope = commanded(time, p, row, int(p[at + C_ROWS]))
    aside = 0.0
    if p[at + C_POINTS] > 0.0:
        goal_heading, curving, aside = _on_path(
            p, at, row + 3 * int(p[at + C_ROWS]), m, mat, state, body
        )
        slope = curving * m[mat + SPEED]
        m[mat + ASIDE] = aside
        m[mat + PATH_BIAS] = bounded(
            m[mat + PATH_BIAS] + p[at + C_PATH_SUM] * aside * dt, -0.15, 0.15
        )
        aim = p[at + C_PATH_GAIN] * aside + m[mat + PATH_BIAS]
        goal_heading -= bounded(aim, -_MOST_AIM, _MOST_AIM)
    most = p[at + C_ACCELERATION] * dt
    m[mat + SPEED] += bounded(goal_speed - m[mat + SPEED], -most, most)
    limit = p[at + C_TURNING]
    turning = slope + wrapped(goal_heading - m[mat + HEADING]) / _CLOSING
    # A step in the turning rate is a step in the lean, whichever foot is down.
    bend = p[at + C_BENDING] * dt
    turning = toward(m[mat + TURNING], bounded(turning, -limit, limit), bend)
    m[mat + TURNING] = turning
    m[mat + HEADING] = wrapped(m[mat + HEADING] + turning * dt)
    c, s = math.cos(m[mat + HEADING]), math.sin(m[mat + HEADING])
    share = dt / _MEAN
    m[mat + MEAN_SPEED] += share * (c * east + s * north - m[mat + MEAN_SPEED])
    m[mat + MEAN_SIDE] += share * (c * north - s * east - m[mat + MEAN_SIDE])
    short = m[mat + SPEED] - m[mat + MEAN_SPEED]
    m[mat + SPEED_BIAS] = bounded(
        m[mat + SPEED_BIAS] + p[at + C_SPEED_GAIN] * short * dt, -_MOST_BIAS, _MOST_BIAS
    )
    m[mat + SIDE_BIAS] = bounded(
        m[mat + SIDE_BIAS] - p[at + C_SIDE_GAIN] * m[mat + MEAN_SIDE] * dt, -_MOST_SIDE, _MOST_SIDE
    )
    side = m[mat + SIDE_BIAS] - bounded(0.3 * aside, -0.3, 0.3)
    error = wrapped(m[mat + HEADING] - yaw)
    return m[mat + SPEED] + m[mat + SPEED_BIAS], side, error, turning, m[mat + SPEED]


def commanded(time, p, row, rows):  # type: ignore[no-untyped-def]
    """Speed, heading and the heading's rate from the table, linear between its rows."""
    k = 0
    while k < rows - 1 and time >= p[row + 3 * (k + 1)]:
        k += 1
    a = row + 3 * k
    if k == rows - 1 or time < p[a]:
        return p[a + 1], p[a + 2], 0.0
    span = p[a + 3] - p[a]
    share = (time - p[a]) / span
    turn = p[a + 5] - p[a + 2]
    return p[a + 1] + share * (p[a + 4] - p[a + 1]), p[a + 2] + share * turn, turn / span


def _on_path(p, at, points, m, mat, state, body):  # type: ignore[no-untyped-def]
    """Heading and curvature of the path beside the body, and how far to the left of it it is."""
    count = int(p[at + C_POINTS])
    x, y = state.subtree_com[body, 0], state.subtree_com[body, 1]
    last = count - 1 if p[at + C_CLOSED] > 0.0 else count - 2
    k = int(m[mat + SEGMENT])
    share = _along(p, points, count, k, x, y)
    for _ in range(count):
        if share <= 1.0 or (k >= last and p[at + C_CLOSED] == 0.0):
            break
        k = 0 if k >= last else k + 1
        share = _along(p, points, count, k, x, y)
    a, b = points + 3 * k, points + 3 * ((k + 1) % count)
    dx, dy = p[b] - p[a], p[b + 1] - p[a + 1]
    length = math.sqrt(dx * dx + dy * dy)
    share = bounded(share, 0.0, 1.0)
    m[mat + SEGMENT] = k
    turn = wrapped(p[b + 2] - p[a + 2])
    aside = (dx * (y - p[a + 1]) - dy * (x - p[a])) / length
    # The chord cuts the corner: to the left of it by this much where the path bends left.
    bulge = 0.5 * turn * length * share * (1.0 - share)
    return p[a + 2] + share * turn, turn / length, aside + bulge


def _along(p, points, count, k, x, y):  # type: ignore[no-untyped-def]
    """How much of segment k of the path lies behind (x, y)."""
    a, b = points + 3 * k, points + 3 * ((k + 1) % count)
    dx, dy = p[b] - p[a], p[b + 1] - p[a + 1]
    return ((x - p[a]) * dx + (y - p[a + 1]) * dy) / (dx * dx + dy * dy)


@dataclass(frozen=True, kw_only=True)
class Course:
    """What a user, a path or another program asks of an athlete.

    Attributes:
        times: When the values below hold, increasing [s], shape (rows,); linear in between.
        speeds: Desired speed [m/s], shape (rows,); under 1 m/s the athlete stands.
        headings: Desired facing direction from +x toward +y [rad], shape (rows,); a path replaces
            them.
        begin: Where it begins [m], shape (2,); a path replaces it.
        path: Points to run along [m], shape (points, 2), or empty for none.
        closed: Whether the path's end leads to its beginning.
        acceleration: Most that the speed asked for changes [m/s^2].
        turning: Most that the heading asked for changes [rad/s].
        bending: Most that this rate changes [rad/s^2].
    """

    times: Array = field(default_factory=lambda: np.zeros(1))
    speeds: Array = field(default_factory=lambda: np.array([3.5]))
    headings: Array = field(default_factory=lambda: np.zeros(1))
    begin: Array = field(default_factory=lambda: np.zeros(2))
    path: Array = field(default_factory=lambda: np.zeros((0, 2)), repr=False)
    closed: bool = False
    acceleration: float = 0.5
    turning: float = 0.35
    bending: float = 0.8

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "times", frozen_array(self.times, (None,), "times"))
        rows = (len(self.times),)
        for name in ("speeds", "headings"):
            set_(self, name, frozen_array(getattr(self, name), rows, name))
        set_(self, "begin", frozen_array(self.begin, (2,), "begin"))
        set_(self, "path", frozen_array(self.path, (None, 2), "path"))
        if not rows[0] or (np.diff(self.times) <= 0).any():
            raise InvalidValue(f"times is {self.times.tolist()}; it must increase.")
        if (self.speeds < 0.0).any():
            raise InvalidValue(f"speeds is {self.speeds.tolist()}; each must be 0 m/s or more.")
        if len(self.path) == 1 or (np.linalg.norm(np.diff(self.path, axis=0), axis=1) == 0).any():
            raise InvalidValue("The path needs two points or more, each apart from the next.")
        for name in ("acceleration", "turning", "bending"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InvalidValue(f"{name} is {getattr(self, name)}; it must be positive.")

    @classmethod
    def steady(cls, speed: float, heading: float = 0.0) -> Course:
        """One speed [m/s] and heading [rad]."""
        return cls(speeds=np.array([speed]), headings=np.array([heading]))

    @classmethod
    def along(cls, path: ArrayLike, speed: float, *, closed: bool = False) -> Course:
        """One speed [m/s] along points [m], shape (points, 2)."""
        return cls(speeds=np.array([speed]), path=np.asarray(path, float), closed=closed)

    def beside(self, distance: float) -> Course:
        """The same course so far to the right [m], as the next lane of a track is.

        Raises:
            InvalidValue: The path bends so sharply that it would fold on itself there.
        """
        _, heading, _ = self.start
        right = np.array([np.sin(heading), -np.cos(heading)])
        if not len(self.path):
            return replace(self, begin=self.begin + distance * right)
        rows = self.sampled()
        shift = np.column_stack((np.sin(rows[:, 2]), -np.cos(rows[:, 2])))
        path = rows[:, :2] + distance * shift
        if (np.einsum("ki,ki->k", np.diff(path, axis=0), np.diff(rows[:, :2], axis=0)) <= 0).any():
            raise InvalidValue(
                f"The path bends too sharply for another {abs(distance):g} m beside it."
            )
        return replace(self, path=path)

    def away(self, places: ArrayLike) -> Array:
        """How far places are from the path [m], shape (n,).

        Args:
            places: World x and y [m], shape (n, 2).

        Raises:
            InvalidValue: There is no path.
        """
        if not len(self.path):
            raise InvalidValue("This course has no path to be away from.")
        path = np.vstack((self.path, self.path[:1])) if self.closed else self.path
        first, along = path[:-1], np.diff(path, axis=0)
        out = []
        for place in np.asarray(places, float):
            share = np.einsum("ki,ki->k", place - first, along) / np.sum(along**2, axis=1)
            near = first + np.clip(share, 0.0, 1.0)[:, None] * along
            out.append(float(np.linalg.norm(place - near, axis=1).min()))
        return np.array(out)

    def ended(self, places: ArrayLike) -> int:
        """How many of the places, in the order of time, come before the end of an open path.

        Args:
            places: World x and y [m], shape (n, 2).
        """
        given = np.asarray(places, float)
        if not len(self.path) or self.closed:
            return len(given)
        ahead = (given - self.path[-1]) @ (self.path[-1] - self.path[-2]) > 0.0
        past = ahead & np.isclose(self.away(given), np.linalg.norm(given - self.path[-1], axis=1))
        return max(int(np.argmax(past)), 1) if past.any() else len(given)

    @property
    def start(self) -> tuple[Array, float, float]:
        """Where it begins [m], shape (2,), with what heading [rad] and speed [m/s]."""
        if not len(self.path):
            return self.begin, float(self.headings[0]), float(self.speeds[0])
        rows = self.sampled()
        return rows[0, :2], float(rows[0, 2]), float(self.speeds[0])

    @property
    def stands(self) -> bool:
        """Whether it asks for standing at some time."""
        return bool((self.speeds < LEAST).any())

    def parameters(self) -> Array:
        """What the law reads; see the module."""
        head = np.zeros(C_TABLE)
        head[C_ACCELERATION], head[C_TURNING] = self.acceleration, self.turning
        head[C_BENDING] = self.bending
        head[C_SPEED_GAIN], head[C_SIDE_GAIN] = 0.25, 0.25
        head[C_PATH_GAIN], head[C_PATH_SUM] = 0.20, 0.05
        table = np.stack((self.times, self.speeds, self.headings), axis=1)
        points = self.sampled()
        head[C_ROWS], head[C_POINTS], head[C_CLOSED] = len(table), len(points), self.closed
        return np.concatenate((head, table.ravel(), points.ravel()))

    def memory(self) -> Array:
        """What the law remembers at time zero, shape (COURSE_MEMORY,)."""
        _, heading, speed = self.start
        out = np.zeros(COURSE_MEMORY)
        out[SPEED] = out[MEAN_SPEED] = speed
        out[HEADING] = heading
        return out

    def sampled(self) -> Array:
        """The path at even distances: x, y [m] and heading [rad], shape (points, 3)."""
        if not len(self.path):
            return np.zeros((0, 3))
        path = np.vstack((self.path, self.path[:1])) if self.closed else self.path
        along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))))
        count = max(3, round(along[-1] / _SPACING) + 1)
        at = np.linspace(0.0, along[-1], count)
        places = np.stack([np.interp(at, along, path[:, i]) for i in range(2)], axis=1)
        if self.closed:
            places = places[:-1]
            way = np.roll(places, -1, axis=0) - np.roll(places, 1, axis=0)
        else:
            way = np.gradient(places, axis=0)
        return np.column_stack((places, np.arctan2(way[:, 1], way[:, 0])))


def track_400m(lane: int = 1) -> Array:
    """Center line of a lane of a standard track [m], shape (points, 2), closed, run to the left.

    Two straights of 84.39 m and two half circles; lane 1 is measured 0.30 m from the kerb of 36.50
    m radius (World Athletics, Track and Field Facilities Manual), which makes it 400 m round.
    """
    if not 1 <= lane <= 8:
        raise InvalidValue(f"lane is {lane}; it must be 1 to 8.")
    straight, radius = 84.39, 36.50 + 0.30 + 1.22 * (lane - 1)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 120)
    right = np.column_stack((straight / 2 + radius * np.cos(turn), radius * np.sin(turn)))
    return np.vstack((right, -right))
