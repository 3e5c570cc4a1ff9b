"""A scene made in Python: plan, check, refine and simulate, all in memory.

    PYTHONPATH=build/release/python .venv/bin/python python/examples/push_box.py

A ball on two springs pushes a box on a table, seen from above, 15 cm ahead and a quarter turn around.
"""

from __future__ import annotations

import math
from pathlib import Path

import stiction as st

MODELS = Path(__file__).resolve().parents[2] / "models"
BOX_M = 0.4

scene = {
    "gravity": [0, 0, 0],  # the table is level
    "contact_distance": 1.0,  # pairs farther apart than this are no contacts [m]
    "robots": [{"name": "hand", "urdf": MODELS / "planar_pusher.urdf", "stiffness": 200}],  # K of the joint springs [N/m]
    "objects": [{"name": "box", "joint": "planar_yz", "mass": 2.0, "shapes": [{"box": {"size": 3 * [BOX_M]}, "friction": 0.6}]}],
}
task = st.Task(
    {
        "name": "push_box",
        "scene": scene,
        "start": {"objects": {"box": {"coordinates": [0.5, 0.0, 0.0]}}, "joints": [0.0, 0.0]},
        "goal": {"objects": {"box": {"coordinates": [0.65, 0.0, math.pi / 2]}}},
        "tolerance": {"position": 0.02, "angle": 0.1},
        "planner": {"margins": True},  # it is executed open loop below
    }
)

# One step of the contact dynamics, smoothed so that it has a gradient away from contact.
step = st.step(task.model, task.q_start, [0.1, 0.0], smoothing=st.Analytic(kappa=100), with_B=True)
print(f"D_qnext_u:\n{step.B}")

found = st.solve(task, seed=0)  # plans, refines, checks and simulates, seed after seed, until a plan holds open loop
if found.status != st.Status.Solved:
    raise SystemExit(f"no plan holds: {found.status.name}")
plan = found.best.plan
print(plan, st.check_plan(plan))

run = st.transfer(plan, alone=False)  # open loop, in a second-order simulation
print(f"simulated for {run.duration_s:.0f} s: {run.error}, goal {'reached' if run.reached else 'missed'}")

trajectory = st.make_trajectory(plan)  # what a robot would be sent
print(f"{len(trajectory.times)} commands of {trajectory.u.shape[1]} joints in {trajectory.duration:.0f} s")
