"""A plant that is looked at and pulled at while a closed loop runs: MuJoCo at the pace of the clock on the wall, and a hand at its objects."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import stiction as st

HOLD = 0.02  # [s] of a command while nothing is to be done


@dataclass(frozen=True)
class Pull:
    """A spring from a point of a body to where the hand is."""

    body: str
    p_B: np.ndarray  # [m]
    hand_W: np.ndarray  # [m]


class Hand:
    """What the mouse pulls at, and with which force: it grows with the way from the point to the hand, and is `newton` from `stretch` [m] on. For any thread."""

    def __init__(self, model: st.Model, newton: float, stretch: float):
        self.model, self.newton, self.stretch = model, newton, stretch
        self.pull: Pull | None = None
        self.last = ""  # body that was pulled

    def drag(self, q: np.ndarray, body: str, point_W: np.ndarray, hand_W: np.ndarray, phase: str) -> None:
        """The mouse has taken a body at a point, which it had at q, and is somewhere; at the end of a drag it lets go."""
        held = self.pull
        if phase == "end":
            self.pull = None
        elif phase == "start" or held is None or held.body != body:
            X = self.model.body_poses(q)[body]
            self.pull = Pull(body, X.R.T @ (point_W - X.p), hand_W)
        else:
            self.pull = Pull(body, held.p_B, hand_W)

    def force(self, q: np.ndarray) -> tuple[Pull | None, np.ndarray]:
        """The pull and its force [N] at a configuration."""
        pull = self.pull
        if pull is None:
            return None, np.zeros(3)
        self.last = pull.body
        way = pull.hand_W - self.point(pull, q)
        return pull, self.newton * way / max(self.stretch, float(np.linalg.norm(way)))

    def point(self, pull: Pull, q: np.ndarray) -> np.ndarray:
        """Of the body [m]."""
        X = self.model.body_poses(q)[pull.body]
        return X.R @ pull.p_B + X.p

    def let_go(self) -> bool:
        """Something was pulled once, and nothing is now."""
        return self.pull is None and self.last != ""


@dataclass
class Log:
    """What happened, command by command."""

    times: list[float] = field(default_factory=list)
    q: list[np.ndarray] = field(default_factory=list)
    force_W: list[np.ndarray] = field(default_factory=list)  # of the hand [N]
    point_W: list[np.ndarray] = field(default_factory=list)  # where it acts [m]


class LivePlant:
    """For `stiction.run`. One thread commands it; any thread may pull and read now(). A pace of 0 does not wait for the clock on the wall."""

    real_time = True  # the world goes on while the planner works

    def __init__(self, task: st.Task, newton: float, stretch: float, pace: float = 1.0):
        self.model, self.pace = task.model, pace
        self.hold = Hand(task.model, newton, stretch)
        self.log = Log()
        self._plant = st.SimulatedPlant(task)
        self._lock = threading.Lock()
        self._begun: float | None = None
        first = self._plant.read()
        assert first is not None  # nothing was commanded yet
        self._measured = first
        self._note(np.zeros(3), np.zeros(3))

    def read(self) -> st.Measurement | None:
        return self._plant.read()

    def command(self, u: np.ndarray, period: float) -> bool:
        force, point = self._push()
        taken = self._plant.command(u, period)
        measured = self._plant.read()
        if measured is None:
            return False
        self._measured = measured
        self._note(force, point)
        self._wait(measured.time)
        return taken

    def now(self) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
        """Time [s], configuration, force of the hand [N] and its point [m]."""
        with self._lock:
            log = self.log
            return log.times[-1], log.q[-1], log.force_W[-1], log.point_W[-1]

    def rest(self, until: Callable[[np.ndarray], bool]) -> bool:
        """Commands rest until something holds of a configuration. False: the simulation broke down."""
        while not until(self._measured.q):
            if not self.command(np.asarray(self._measured.u), HOLD):
                return False
        return True

    def _push(self) -> tuple[np.ndarray, np.ndarray]:
        """The force of the hand and its point, from now on."""
        pull, force = self.hold.force(self._measured.q)
        if pull is None:
            if self.hold.let_go():
                self._plant.push(self.hold.last, force, np.zeros(3))
            return force, np.zeros(3)
        self._plant.push(pull.body, force, pull.p_B)
        return force, self.hold.point(pull, self._measured.q)

    def _note(self, force: np.ndarray, point: np.ndarray) -> None:
        with self._lock:
            log = self.log
            log.times.append(float(self._measured.time))
            log.q.append(np.array(self._measured.q))
            log.force_W.append(force)
            log.point_W.append(point)

    def _wait(self, plant_time: float) -> None:
        """The plant is not ahead of the clock on the wall; what it is behind by is not made up for."""
        if self.pace <= 0:
            return
        now = time.monotonic()
        if self._begun is None or now > self._begun + plant_time / self.pace:
            self._begun = now - plant_time / self.pace
        time.sleep(self._begun + plant_time / self.pace - now)
