"""Where was my robot touched? A UR5 is pushed at its wrist; its joint torques say where.

    PYTHONPATH=build/release/python .venv/bin/python python/examples/where_was_my_robot_touched.py

Cells begin with # %%, as editors and Jupyter know them. Torques come from a known contact and a sensor's noise here; on a robot they are measured, less those of gravity and motion.
"""

# %% The robot, and the surfaces on which a contact is looked for
import numpy as np
import stiction as st

NOISE = 0.05  # standard deviation of a torque [N m]
URDF = "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"

model = st.load_model({"robots": [{"name": "arm", "urdf": URDF}]})
sensor = st.Sensor(model)  # surfaces and samples of every link that a joint moves
q = np.array([0.3, -1.2, 1.6, -1.97, -1.57, 0.4])  # [rad]

# %% A push of 25 N into the surface of the fifth link, at one of the sensor's samples, and what six torque sensors would show of it.
link = next(link for link in sensor.links if link.name == "arm/wrist_2_link")
p_L, f_L = link.p_L[100], -25.0 * link.n_L[100]
tau = st.calc_contact_torque(model, q, link.name, p_L, f_L) + np.random.default_rng(0).normal(0, NOISE, model.n_a)
print("torques [N m]:", np.round(tau, 2))

# %% Every contact that makes these torques
result = sensor.sense(q, tau, friction=0.5, noise=NOISE)
print(result.verdict.name)
for c in result.candidates:
    if c.explains:
        print(f"  {c.link:20} {np.round(c.p_W, 3)} m  {np.linalg.norm(c.f_W):5.1f} N  {np.sqrt(c.residual):.2g} N m left over")
print(f"  and {sum(not c.explains for c in result.candidates)} points that explain less")
print(f"the contact is {100 * result.calc_distance(link.name, p_L):.1f} cm from the nearest candidate")

# %% How much this link's own torque sensor can show: at how many of its points every push makes a torque, and how many pushes make none.
seen = sensor.calc_detectability(link.name, friction=0.5, epsilon=0.01)  # torque of a push of 1 N [N m]
print(f"{seen.full} of {len(seen.kinds)} points show every push, {100 * seen.eta.mean():.0f} % of all pushes make less than 0.01 N m per newton")
