"""A robot behind its own driver: what `stiction.run` needs of it is read() and command(u, period).

    PYTHONPATH=build/release/python .venv/bin/python python/examples/own_robot.py

The robot here is a process of its own that answers datagrams, as the controller of an arm does; inside it is MuJoCo. A real one needs another `Driver`:
read() from its state and from whatever sees the object, command() to its joint impedance controller, and a wait for the end of the period.
"""

from __future__ import annotations

import multiprocessing
import socket
import struct
from collections.abc import Sequence
from multiprocessing.connection import Connection

import stiction as st

TASK, GOAL = "planar_hand", [0.0, 0.35, 0.3]  # two arms turn a ball by 0.3 rad
TIMEOUT_S = 5.0  # a robot that does not answer for so long is taken as gone: the run ends and says so. Between machines of one room, 0.05 s


def packed(numbers: Sequence[float]) -> bytes:
    return struct.pack(f"{len(numbers)}d", *numbers)


def unpacked(message: bytes) -> tuple[float, ...]:
    return struct.unpack(f"{len(message) // 8}d", message)


class Driver:
    """The plant of a run, on this side of the network."""

    def __init__(self, task: st.Task, address: tuple[str, int]) -> None:
        self.n_q, self.n_a = task.model.n_q, task.model.n_a
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(TIMEOUT_S)
        self.socket.connect(address)

    def ask(self, numbers: Sequence[float]) -> tuple[float, ...] | None:
        try:
            self.socket.send(packed(numbers))
            return unpacked(self.socket.recv(65536))
        except (TimeoutError, ConnectionRefusedError):
            return None

    def read(self) -> st.Measurement | None:
        state = self.ask([])
        if state is None:
            return None
        time, object_time, rest = state[0], state[1], state[2:]
        return st.Measurement(time, rest[: self.n_q], rest[self.n_q :], object_time=object_time)

    def command(self, u: Sequence[float], period: float) -> bool:
        return self.ask([*u, period]) is not None  # the robot answers when the period is over


def serve(name: str, port: Connection) -> None:
    """The robot: holds its last command where nobody gives another one."""
    plant = st.SimulatedPlant(st.load_task(name))
    server = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    server.bind(("127.0.0.1", 0))
    port.send(server.getsockname()[1])
    while True:
        message, client = server.recvfrom(65536)
        if message:
            *u, period = unpacked(message)
            plant.command(u, period)
            server.sendto(packed([period]), client)
        else:
            state = plant.read()
            assert state is not None  # a simulation always answers
            server.sendto(packed([state.time, state.object_time, *state.q, *state.u]), client)


def main() -> None:
    here, there = multiprocessing.Pipe()
    robot = multiprocessing.get_context("spawn").Process(target=serve, args=(TASK, there), daemon=True)
    robot.start()
    task = st.load_task(TASK)
    task.set_goal(GOAL)
    run = st.run(task, plant=Driver(task, ("127.0.0.1", here.recv())), seed=0)
    print(f"{run.end.name} after {run.duration_s:.1f} s: {run.message or run.error}")

    robot.terminate()  # somebody pulls the plug
    robot.join()
    task.set_goal([0.0, 0.35, 0.0])
    print(st.run(task, plant=Driver(task, ("127.0.0.1", 9)), seed=0).message)


if __name__ == "__main__":
    main()
