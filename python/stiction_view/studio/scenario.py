"""Scenarios of sensing and control as motions with forces."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import stiction as st

from ..plan import Contact, Plan
from .picture import Pictures
from .texts import plain

MAX_FRAMES = 600
VERDICTS = {
    st.Verdict.Explained: "a single contact explains the torques",
    st.Verdict.Unexplained: "no single contact explains the torques",
    st.Verdict.BelowThreshold: "the torques are below the threshold",
}


@dataclass
class Played:
    """A motion with forces, and what is said of each frame and of all."""

    name: str
    drawn: Plan
    pictures: Pictures
    times: np.ndarray  # [s] (frames)
    lines: list[str]  # markdown, one a frame
    words: str
    charts: dict[str, tuple[str, np.ndarray]]  # title → unit, (frames)
    scenario: st.SensingScenario | st.ControlScenario | None = None  # that was played


def chosen_frames(count: int) -> np.ndarray:
    return np.unique(np.linspace(0, count - 1, min(count, MAX_FRAMES)).round().astype(int))


def _whole(model: st.Model, joints: np.ndarray) -> np.ndarray:
    """Joint positions (n, n_a) → configurations (n, n_q), objects where they are placed."""
    q = np.tile(model.neutral(), (len(joints), 1))
    q[:, model.n_qu :] = joints
    return q


def _moves(pictures: Pictures, q: np.ndarray, name: str, contacts: list[list[Contact]]) -> Plan:
    return pictures.plan(q, st.Pose(np.eye(3), np.zeros(3)), 0, name, contacts)


def play_sense(source: str | Path) -> Played:
    """Where a robot is touched. Raises stiction.InvalidInput."""
    scenario = st.load_sensing_scenario(source)
    moments = st.sense(scenario)
    model = scenario.sensor.model
    pictures, chosen = Pictures(model), chosen_frames(len(moments))
    contacts, lines = [], []
    for k in chosen:
        explaining = [c for c in moments[k].candidates if c.explains]
        contacts.append([Contact(np.array(c.p_W), np.array(c.f_W), False) for c in explaining])
        rows = [f"**{VERDICTS[moments[k].verdict]}** ({len(explaining)} of {len(moments[k].candidates)} places do)"]
        for number, c in enumerate(explaining, 1):
            extent = f", within {100 * c.extent:.1f} cm" if c.extent > 0 else ""
            rows.append(f"{number}. {plain(c.link)}: {np.linalg.norm(c.f_W):.1f} N, leaves {np.sqrt(max(c.residual, 0.0)):.2f} N·m{extent}")
        lines.append("  \n".join(rows))
    tau = np.linalg.norm(scenario.tau[chosen] - scenario.rest, axis=1)
    drawn = _moves(pictures, _whole(model, scenario.q[chosen]), scenario.name, contacts)
    words = f"{plain(scenario.description)}  \narrows are forces on the robot, each of which alone explains the torques"
    return Played(scenario.name, drawn, pictures, np.array(scenario.times)[chosen], lines, words, {"external torque": ("N·m", tau)}, scenario)


def error_unit(scenario: st.ControlScenario) -> str:
    """Of a thousandth of the tracking error."""
    if scenario.tool is not None:
        return "mm"
    kinds = {dof.kind for dof in scenario.model.dofs[-scenario.model.n_a :]}
    return ", ".join(unit for kind, unit in ((st.DofKind.Revolute, "mrad"), (st.DofKind.Prismatic, "mm")) if kind in kinds)


def play_control(source: str | Path) -> Played:
    """An arm with bounded contact forces. Raises stiction.InvalidInput."""
    scenario = st.load_control_scenario(source)
    out = st.control(scenario)
    if len(out.times) == 0:
        raise ValueError(f"the simulation gave nothing ({out.message or out.status.name})")
    model = scenario.model
    pictures, chosen = Pictures(model), chosen_frames(len(out.times))
    contacts = [[Contact(np.array(f.p_WC), np.array(f.force_W), False) for f in out.forces[k] if np.linalg.norm(f.force_W) > 0] for k in chosen]
    error, unit = 1e3 * out.error, error_unit(scenario)
    lines = [
        f"t = {out.times[k]:.2f} s: **{out.largest_force[k]:.1f} N** of {scenario.lambda_max:g}{', at its bound' if out.bounded[k] else ''}, {error[k]:.1f} {unit} behind"
        for k in chosen
    ]
    drawn = _moves(pictures, _whole(model, out.q[chosen]), scenario.name, contacts)
    words = f"{plain(scenario.description)}  \nimpact {out.peak_force:.1f} N, settled {out.settled_peak:.1f} N at most, bound {scenario.lambda_max:g} N"
    charts = {"largest force": ("N", np.array(out.largest_force)[chosen]), "tracking error": (unit, np.array(error)[chosen])}
    return Played(scenario.name, drawn, pictures, np.array(out.times)[chosen], lines, words, charts, scenario)
