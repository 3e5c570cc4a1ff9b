"""Every call of the module as a user writes it, with the types that come back. mypy reads this file; nothing runs it."""

from __future__ import annotations

from pathlib import Path
from typing import assert_type

import numpy as np
import stiction as st

scene = st.load_scene({"robots": [{"name": "arm", "urdf": Path("arm.urdf"), "stiffness": 200}]}, base=Path("."))
model = st.Model.make(scene)
assert_type(st.load_model("scene.yaml"), st.Model)
assert_type(st.import_scene(Path("scene.sdf"), out="task.yaml", object="lid"), st.Task)
X_WB = st.Pose(np.eye(3), [0.0, 0.0, 0.1])
task = st.Task({"name": "mine", "scene": {"fixed": [{"name": "table", "pose": X_WB}]}}).with_(start=[0.0], goal=[0.1], options={"goal_bias": 0.3})
names: list[str] = st.list_tasks()
findings: list[st.Finding] = st.lint(st.load_task(names[0]))


def report(progress: st.Progress) -> bool | None:
    return progress.fraction < 0.5 or None


step = st.step(model, [0.0], np.zeros(1), h=0.1, smoothing=st.Analytic(kappa=100), friction_cone=st.PolyhedralCone(rays=8), with_A=True, with_B=True)
assert_type(step.status, st.Status)
for contact in step.contacts:
    force: float = float(contact.force[0])
local = st.calc_local_model(model, [0.0], [0.0], scheme=st.RandomizedFirstOrder(std_q=[0.0], std_u=[0.1], samples=100))
assert local.A is None
knots: list[st.Knot] = st.rollout(model, [0.0], [0.0], [0.1]).knots
batch = st.step_batch(model, np.zeros((10, 1)), np.zeros((10, 1)), with_B=True)
shape: tuple[int, ...] = batch.q_next.shape

found = st.plan(task, options=task.options.replace(goal_bias=0.2), seed=0, threads=2, timeout_s=10, on_progress=report)
plan = found.plan
assert_type(plan[0], st.Segment)
assert_type(plan[:2], st.Plan)
count: int = len(plan)
plan.write("plan.json")
files: list[Path] = plan.export("motion.npz", trajectory=st.make_trajectory(plan, speed=0.5))
assert_type(st.read_plan(Path("plan.json")), st.Plan)
assert_type(st.refine(plan).plan, st.Plan)
accepted: bool = st.check_plan(plan).pass_
reached: bool = st.transfer(plan, friction_scale=0.8).reached
inside: bool = st.calc_tube(plan, st.ErrorSets(friction=0.2), factors=(1.2, 1.1)).inside
reached = st.transfer(plan, mass_scale=st.draw_world(plan, index=3).mass, start_error=np.zeros(3)).reached
best = st.solve(task, friction=[0.7, 1.0]).best.plan
end: st.RunEnd = st.run(plan, pose_noise=(0.001, 0.01)).end
with st.stream(plan, foxglove=0, rerun=Path("plan.rrd")) as stream:
    length: float = stream.play(speed=0.5)
    end = st.run(task, on_sample=stream).end
cost: float = st.optimize(task, iterations=3).cost.total
page: Path | None = st.view(plan, html="plan.html")
rows: list[dict[str, object]] = list(st.sweep("planar_pushing", seeds=3, friction=[1.0], options={"goal_bias": [0.3]}))

samples = st.simulate(st.Plant(model), [0.0], [0.0, 1.0], [[0.0], [0.1]]).q
plant = st.DrivenPlant(st.Plant(model, damping_ratio=0.0))
assert_type(plant.advance([0.0], 0.01), st.Status)

sensor = st.Sensor(model, links=["arm/*"])
torque = st.calc_contact_torque(model, [0.0], "arm/hand", [0.0, 0.0, 0.0], [0.0, 0.0, -10.0])
for candidate in sensor.sense([0.0], torque, friction=0.5, noise=0.05).candidates:
    where: float = float(candidate.p_W[2])
series: list[st.SenseResult] = st.sense(st.load_sensing_scenario("ur5_forearm"))

controller = st.ContactController(model, law=st.Law.ContactAware, lambda_max=15)
controller.configure([0.0])
push = st.ContactForce(body="arm/hand", p_WC=[0, 0, 0], force_W=[0, 0, 10])
command = controller.update(st.ControllerState(time=0.0, q=[0.0], q_ref=[0.1], contacts=[push]), 0.005).q_cmd
peak: float = st.control("box_in_the_way", lambda_max=15.0).settled_peak
touches: list[st.Touch] = st.touch(st.load_touch_scenario("reach_past_pillar"), seed=1).touches
