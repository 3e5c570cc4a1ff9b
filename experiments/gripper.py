"""The parallel gripper of sections 2.3.5 and 2.3.6: the library's model, and a reference with Coulomb's law in its own mathematics."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import stiction as st

from .systems import load, solved

RADIUS, WEIGHT, STIFFNESS, FRICTION = 0.1, 10.0, 1000.0, 0.5
EPSILON = 1e-6  # of the ball, whose mass is 1 kg; the thesis has 0

# Coordinates of this file: x and y of the ball, y of the gripper, x of its left and of its right finger; u has the last three.
START = np.array([0.0, RADIUS, 0.0, -1.06 * RADIUS, 1.06 * RADIUS])


@dataclass
class State:
    """After one step: coordinates, and force (n, t) [N] and distance [m] at the left finger, the right finger and the ground."""

    q: np.ndarray
    force: np.ndarray  # (3, 2)
    phi: np.ndarray  # (3)
    slip: np.ndarray  # (3) in this step


class Ours:
    """Steps of the library. Its ball can also turn, but nothing turns it here."""

    def __init__(self) -> None:
        self.model = load("gripper")
        self.work = st.StepWorkspace(self.model)

    def step(self, q: np.ndarray, u: np.ndarray, h: float) -> State:
        full = np.array([q[0], q[1], 0.0, *q[2:]])
        # Impulses are small here, 0.1 N s.
        result = solved(st.step(self.model, full, u, h=h, regularisation=st.FixedEpsilon(epsilon=EPSILON), tol_complementarity=1e-11, workspace=self.work))
        force, phi, slip = np.zeros((3, 2)), np.full(3, np.nan), np.zeros(3)
        for contact in result.contacts:
            i = ["gripper/left/pad", "gripper/right/pad", "ground/plane"].index(contact.b)
            along = (np.array([0, 0, 1.0]), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]))[i]
            force[i] = contact.force[0], along @ contact.force_W
            phi[i] = contact.anitescu_gap
            tangents = np.column_stack([contact.t1_W, contact.t2_W])
            slip[i] = along @ tangents @ contact.displacement[1:]
        return State(np.delete(result.q_next, 2), force, phi, slip)


class Coulomb:
    """The same balance of forces with Coulomb's law, as a linear complementarity problem; solved by trying the modes of the contacts.

    0 ≤ f_n ⊥ φ + J_n δq ≥ 0;  |f_t| ≤ μ f_n, and f_t = -μ f_n sign(J_t δq) where it slides.
    """

    J_n = np.array([[1, 0, 0, -1, 0], [-1, 0, 0, 0, 1], [0, 1, 0, 0, 0]], dtype=float)
    J_t = np.array([[0, 1, -1, 0, 0], [0, 1, -1, 0, 0], [1, 0, 0, 0, 0]], dtype=float)
    TOLERANCE = 1e-9

    def __init__(self) -> None:
        self.modes = list(itertools.product("so-+", repeat=3))  # sticks, open, slides down, slides up

    def step(self, q: np.ndarray, u: np.ndarray, h: float) -> State:
        Q = np.diag([EPSILON / h**2] * 2 + [STIFFNESS] * 3)
        b = np.concatenate([[0, WEIGHT], -STIFFNESS * (u - q[2:])])
        phi = np.array([q[0] - q[3] - RADIUS, q[4] - q[0] - RADIUS, q[1] - RADIUS])
        for mode in self.modes:
            found = self.try_mode(mode, Q, b, phi)
            if found is not None:
                self.modes.sort(key=lambda m: m != mode)  # the mode of the last step first
                delta, force = found
                return State(q + delta, force, phi + self.J_n @ delta, self.J_t @ delta)
        raise RuntimeError("no contact mode fits")

    def try_mode(self, mode: tuple[str, ...], Q: np.ndarray, b: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Unknowns δq and two forces per contact: five balances and two equations per contact."""
        A = np.zeros((11, 11))
        right = np.concatenate([-b, np.zeros(6)])
        A[:5, :5], A[:5, 5:8], A[:5, 8:] = Q, -self.J_n.T, -self.J_t.T
        for i, kind in enumerate(mode):
            normal, tangent = 5 + i, 8 + i
            if kind == "o":
                A[normal, 5 + i] = A[tangent, 8 + i] = 1
                continue
            A[normal, :5], right[normal] = self.J_n[i], -phi[i]
            if kind == "s":
                A[tangent, :5] = self.J_t[i]
            else:
                A[tangent, 8 + i], A[tangent, 5 + i] = 1, FRICTION if kind == "+" else -FRICTION
        # Two fingers that stick share the load in many ways; the smallest forces are the symmetric ones.
        x = np.linalg.lstsq(A, right, rcond=1e-13)[0]
        if np.max(np.abs(A @ x - right)) > self.TOLERANCE:
            return None
        delta, normal, tangent = x[:5], x[5:8], x[8:]
        slip, gap = self.J_t @ delta, phi + self.J_n @ delta
        for i, kind in enumerate(mode):
            fits = gap[i] > -self.TOLERANCE if kind == "o" else normal[i] > -self.TOLERANCE
            fits &= kind != "s" or abs(tangent[i]) <= FRICTION * normal[i] + self.TOLERANCE
            fits &= kind not in "+-" or slip[i] * (1 if kind == "+" else -1) > -self.TOLERANCE
            if not fits:
                return None
        return delta, np.column_stack([normal, tangent])


def simulate(model: Ours | Coulomb, commands: np.ndarray, h: float) -> list[State]:
    """One state per row of commands, from START."""
    q = START
    out = []
    for u in commands:
        out.append(model.step(q, u, h))
        q = out[-1].q
    return out
