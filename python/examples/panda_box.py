"""Plan with your own robot: a Panda pushes a box over a table.

    PYTHONPATH=build/release/python .venv/bin/python python/examples/panda_box.py

Cells begin with # %%, as editors and Jupyter know them. The robot is a URDF as its makers give it, everything else stands here.
"""

# %% The scene: a robot, an object, what does not move, and pairs that are not looked at
import numpy as np
import stiction as st

PANDA = "package://example-robot-data/robots/panda_description/urdf/panda.urdf"
BOX_M = 0.1
HOME = [0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4, 0.0]  # the last one is the gripper

scene = {
    "robots": [{"name": "panda", "urdf": PANDA, "stiffness": 400, "friction": 0.6}],
    "objects": [{"name": "box", "joint": "free", "mass": 0.5, "shapes": [{"box": {"size": 3 * [BOX_M]}, "friction": 0.6}]}],
    "fixed": [{"name": "table", "friction": 0.4, "shapes": [{"half_space": {}}]}],
    "filters": [{"exclude": ["panda/panda_link0", "table"]}],
}
task = st.Task(
    {
        "name": "panda_box",
        "scene": scene,
        "start": {"objects": {"box": {"position": [0.5, -0.15, BOX_M / 2]}}, "joints": HOME},
        "goal": {"objects": {"box": {"position": [0.5, 0.0, BOX_M / 2], "rpy": [0, 0, 0]}}},
        "tolerance": {"position": 0.02, "angle": 0.1},
    }
)
print(task.model, *task.model.notes, sep="\n  ")

# %% What is hardly meant: an overlap, a wrong unit, a goal out of reach. Nothing, here
print("lint:", st.lint(task))

# %% A plan, the best one so far after a minute, and an independent check of it
result = st.plan(task, seed=0, timeout_s=60)
print(result, result.reason)
report = st.check_plan(result.plan)
print(report)

# %% Another goal of the same scene, and what a plan holds: NumPy arrays, the time first
nearer = task.with_(goal=[0.5, -0.1, BOX_M / 2, 0, 0, 0])
print("nearer goal:", nearer.q_goal[:3].round(3), "m")
plan = result.plan
print("configurations", plan.q.shape, "commands", plan.u.shape, "pieces", [segment.kind.name for segment in plan])

# %% For others: a page to look at, and commands over time for the robot
st.view(plan, html="panda_box.html")
trajectory = st.make_trajectory(plan)
print("trajectory", plan.export("panda_box.csv", trajectory=trajectory)[0], f"{trajectory.duration:.0f} s")
