"""Gradients through contact: where a command has no effect, a smoothed step still says which way to go.

    PYTHONPATH=build/release/python .venv/bin/python python/examples/gradients_through_contact.py

Cells begin with # %%, as editors and Jupyter know them. A ball on two springs stands 2 cm before a box; the box is to move 5 cm.
"""

# %% A step and its derivatives, at a distance
import numpy as np
import stiction as st

task = st.load_task("planar_pushing")
model = task.model
box, hand = slice(0, 3), slice(3, 5)  # of q: y, z, angle of the box; y, z of the hand
gap, half_box, radius = 0.02, 0.5, 0.1  # [m]
q = task.q_start
q[hand] = [q[0], q[1] - half_box - radius - gap]
u = q[hand]

exact = st.step(model, q, u, with_B=True)
smooth = st.step(model, q, u, smoothing=st.Analytic(kappa=100), with_B=True)
assert exact.B is not None and smooth.B is not None  # asked for
print(f"how far the box goes per metre of the command: exact {exact.B[1, 1]:.3f}, smoothed {smooth.B[1, 1]:.3f}")
if not abs(exact.B[1, 1]) < 1e-3 * smooth.B[1, 1]:
    raise SystemExit("the hand touches the box, or does not feel it")

# %% Descent on a sequence of commands: dynamics forwards, gradients backwards, barrier sharper and sharper
STEPS, TARGET = 10, q[1] + 0.05
commands = np.tile(u, (STEPS, 1))


def rollout(kappa: float) -> tuple[float, np.ndarray]:
    """(1/2) |z_T - target|^2 of the box and its derivatives to all commands, by the chain rule over A and B."""
    state, steps = q, []
    for command in commands:
        local = st.calc_local_model(model, state, command, scheme=st.Analytic(kappa=kappa), with_A=True)
        steps.append(local)
        state = local.c
    gradient, adjoint = np.zeros_like(commands), np.zeros(model.n_v)
    adjoint[1] = state[1] - TARGET
    for t in reversed(range(STEPS)):
        gradient[t] = steps[t].B.T @ adjoint
        adjoint = np.asarray(steps[t].A).T @ adjoint
    return 0.5 * (state[1] - TARGET) ** 2, gradient


for kappa in (100.0, 1000.0, 10000.0):
    for _ in range(15):
        cost, gradient = rollout(kappa)
        sensitivity = float(np.sum(gradient**2)) / max(2 * cost, 1e-12)  # |dz_T/du|^2
        commands -= gradient / max(sensitivity, 1e-3)  # Gauss-Newton: the shortest change that closes the rest
    print(f"kappa {kappa:7.0f}: the box ends {1000 * np.sqrt(2 * cost):.2f} mm from its target")

# %% The exact model with these commands
state = q
for command in commands:
    state = st.step(model, state, command).q_next
off_mm = 1000 * abs(state[1] - TARGET)
print(f"exact: the box ends {off_mm:.2f} mm from its target, the hand pushed {1000 * (commands[-1, 1] - u[1]):.0f} mm")

# %% The same derivatives for many states with one call, on all cores
batch = st.step_batch(model, np.tile(q, (1000, 1)), u + np.linspace(0, [0, 0.1], 1000), smoothing=st.Analytic(kappa=100), with_B=True)
assert batch.B is not None and not batch.failed
print("slopes of 1000 commands:", batch.B[::250, 1, 1].round(3))
if off_mm > 2:
    raise SystemExit("the gradients lead elsewhere")
