"""An arm whose reference goes through a wall presses on it with 15 N: configure once, then one update a tick.

    PYTHONPATH=build/release/python .venv/bin/python python/examples/bounded_force.py

The robot is a quasi-static step of the library: joint springs and contacts in balance. A real one takes its place by its joint positions, what it
measures of contact forces, and its joint position commands.
"""

from pathlib import Path

import numpy as np
import stiction as st

DT, LAMBDA_MAX = 0.005, 15.0  # [s], [N]
START = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0])  # [rad]
STIFFNESS = {f"joint_{j}": k for j, k in enumerate([800, 600, 600, 600, 400, 200, 200], start=1)}  # [N m/rad]

model = st.load_model(
    {
        "gravity": [0, 0, 0],
        "robots": [{"name": "arm", "urdf": "../../models/iiwa7_balls.urdf", "stiffness": STIFFNESS, "friction": 0.3}],
        "fixed": [{"name": "wall", "pose": {"position": [0.6, 0.26, 0.35]}, "friction": 0.3, "shapes": [{"box": {"size": [0.3, 0.2, 0.4]}}]}],
    },
    base=Path(__file__).parent,
)


def touched(step: st.StepResult) -> list[st.ContactForce]:
    """What a skin would measure: forces on links of the arm, from outside."""
    found = []
    for contact in step.contacts:
        on_a = contact.a.startswith("arm/")
        if contact.active and on_a != contact.b.startswith("arm/"):
            body = (contact.a if on_a else contact.b).rsplit("/", 1)[0]
            force_W = contact.force_W if on_a else -contact.force_W
            found.append(st.ContactForce(body=body, p_WC=contact.p_WA if on_a else contact.p_WB, force_W=force_W, id=contact.id))
    return found


def press(law: st.Law) -> list[float]:
    """Turns the base by 0.4 rad in 3 s, through the wall, and waits 2 s: the largest force of every tick [N]."""
    controller = st.ContactController(model, law=law, lambda_max=LAMBDA_MAX)
    controller.configure(START)
    work, q, forces = st.StepWorkspace(model), START, []
    contacts: list[st.ContactForce] = []
    for tick in range(round(5.0 / DT)):
        q_ref = START + [0.4 * min(1.0, tick * DT / 3.0), 0, 0, 0, 0, 0, 0]
        command = controller.update(st.ControllerState(time=tick * DT, q=q, q_ref=q_ref, contacts=contacts), DT)
        step = st.step(model, q, command.q_cmd, h=DT, workspace=work)
        if command.status != st.Status.Solved or step.status != st.Status.Solved:
            raise SystemExit(f"tick {tick}: {command.status.name}, {step.status.name}")
        q, contacts = step.q_next, touched(step)
        forces.append(max((float(np.linalg.norm(c.force_W)) for c in contacts), default=0.0))
    return forces


if __name__ == "__main__":
    ours, tracking = press(st.Law.ContactAware), press(st.Law.Unconstrained)
    print(f"bounded: {ours[-1]:.1f} N at the end, {max(ours):.1f} N at most, bound {LAMBDA_MAX:.1f} N")
    print(f"tracking alone: {tracking[-1]:.1f} N at the end")
