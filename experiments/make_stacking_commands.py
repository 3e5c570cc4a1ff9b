#!/usr/bin/env python3
"""Joint commands of the stacking experiment (Fig. 2-9): tool waypoints → inverse kinematics → models/stacking_commands.csv.

Seven segments of 2·(1, 2, 2, 1, 1, 1, 2) s: close the fingers, lift, carry and turn by 90°, lower, open, retreat, go back. The tool point lies
0.15 m beyond link 7. Waypoints are the published ones, all 47 mm lower: with the published ones the pads of this gripper would close above
the box. Ten knots per segment; between knots commands are linear.
"""

import pathlib

import numpy as np
import pinocchio as pin

ROOT = pathlib.Path(__file__).resolve().parents[1]
DURATIONS = 2.0 * np.array([1, 2, 2, 1, 1, 1, 2])
EDGE = 0.075
POSITIONS = np.array(
    [
        [0.555, 0, 0.10],
        [0.555, 0, 0.10],
        [0.555, 0, 0.17 + 3 * EDGE],
        [0.69, 0, 0.17 + 3 * EDGE],
        [0.69, 0, 0.17 + 2 * EDGE + 0.005],
        [0.69, 0, 0.17 + 2 * EDGE + 0.005],
        [0.69, 0, 0.25 + 3 * EDGE],
        [0.555, 0, 0.25 + 3 * EDGE],
    ]
) - [0, 0, 0.047]
YAWS = np.array([0, 0, 0, 1, 1, 1, 1, 0]) * np.pi / 2
OPENINGS = np.array([0.05, 0.02, 0.02, 0.02, 0.02, 0.05, 0.05, 0.05])
KNOTS = 10
TOOL = np.array([0, 0, 0.15])
GUESS = np.array([0, 0, 0, -1.75, 0, 1.0, 0])


def solve(model, data, frame, position, yaw, q):
    """Gauss–Newton on the pose of the tool point from q; damped, to 1e-10."""
    target = pin.SE3(pin.rpy.rpyToMatrix(0, np.pi, yaw), position)
    tool = pin.SE3(np.eye(3), TOOL)
    for _ in range(200):
        pin.framesForwardKinematics(model, data, q)
        error = pin.log6((data.oMf[frame] * tool).actInv(target)).vector
        if np.linalg.norm(error) < 1e-10:
            return q
        J = pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL)
        J = (tool.inverse().toActionMatrix() @ J)[:, :7]
        step = J.T @ np.linalg.solve(J @ J.T + 1e-10 * np.eye(6), error)
        q = q.copy()
        q[:7] += step * min(1.0, 0.3 / np.linalg.norm(step))
    raise RuntimeError(f"no configuration found for the tool at {position}, yaw {yaw}")


def main():
    model = pin.buildModelFromUrdf(str(ROOT / "models" / "iiwa7_wsg50.urdf"))
    data = model.createData()
    frame = model.getFrameId("iiwa_link_7")
    starts = np.concatenate([[0.0], np.cumsum(DURATIONS)])
    times = np.concatenate([np.linspace(starts[i], starts[i + 1], KNOTS + 1)[:-1] for i in range(len(DURATIONS))] + [starts[-1:]])
    q = np.concatenate([GUESS, np.zeros(2)])
    rows = []
    for t in times:
        # solve() continues from the knot before, so that the redundant joint does not jump
        q = solve(model, data, frame, np.array([np.interp(t, starts, POSITIONS[:, k]) for k in range(3)]), np.interp(t, starts, YAWS), q)
        opening = np.interp(t, starts, OPENINGS)
        rows.append([t, *q[:7], -opening, opening])
    header = "time [s]," + ",".join(f"iiwa_joint_{i + 1} [rad]" for i in range(7)) + ",left_finger_joint [m],right_finger_joint [m]"
    np.savetxt(ROOT / "models" / "stacking_commands.csv", rows, fmt="%.12g", delimiter=",", header=header, comments="")


if __name__ == "__main__":
    main()
