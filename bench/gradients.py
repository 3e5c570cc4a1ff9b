#!/usr/bin/env python3
"""What the gradient of a rollout costs beside its steps with A and B, and how exact it is.

    bench/gradients.py [--tasks allegro_cube planar_hand] [--steps 32] [--rollouts 200] [--json]

Commands wander from the start of a task. Times are of one thread, in the library. The error is that of the slope along random directions of the commands against
differences of fourth order; steps are smoothed, since an exact step has kinks. One line for each task.
"""

import argparse
import json
import pathlib
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "build/release/python"))
import stiction as st  # noqa: E402

SMOOTH = {"smoothing": st.Analytic(kappa=1000), "tol_complementarity": 1e-11, "threads": 1}


def commands(task, rollouts, steps):
    random = np.random.default_rng(0)
    q = np.tile(task.q_start, (rollouts, 1))
    return q, q[:, None, -task.model.n_a :] + 0.01 * random.standard_normal((rollouts, steps, task.model.n_a)).cumsum(axis=1)


def measure(name, rollouts, steps):
    task = st.load_task(name)
    q, u = commands(task, rollouts, steps)
    rolled = st.rollout_batch(task.model, q, u, **SMOOTH)
    slope = np.random.default_rng(1).standard_normal(rolled.q.shape)
    states, inputs = rolled.q[:, :-1].reshape(-1, task.model.n_q), u.reshape(-1, task.model.n_a)
    times = {"rollout": [], "gradient": [], "with_A_and_B": []}
    for _ in range(3):
        start = time.process_time()
        rolled = st.rollout_batch(task.model, q, u, **SMOOTH)
        middle = time.process_time()
        _, by_u = st.pull_back_rollout(task.model, rolled, u, slope, **SMOOTH)
        times["rollout"].append(middle - start)
        times["gradient"].append(time.process_time() - middle)
        start = time.process_time()
        st.step_batch(task.model, states, inputs, with_A=True, with_B=True, **SMOOTH)
        times["with_A_and_B"].append(time.process_time() - start)
    best = {key: min(values) for key, values in times.items()}
    along = np.random.default_rng(2).standard_normal(u.shape)
    some = slice(0, min(20, rollouts))

    def loss(s):
        return (st.rollout_batch(task.model, q[some], u[some] + s * along[some], **SMOOTH).q * slope[some]).sum(axis=(1, 2))

    expected = (8 * (loss(1e-6) - loss(-1e-6)) - loss(2e-6) + loss(-2e-6)) / 12e-6
    error = np.abs((by_u[some] * along[some]).sum(axis=(1, 2)) - expected) / np.abs(expected)
    return {
        "task": name,
        "steps": steps,
        "failed": rolled.failed,
        "us_a_step": {key: 1e6 * value / (rollouts * steps) for key, value in best.items()},
        "ratio": (best["rollout"] + best["gradient"]) / best["with_A_and_B"],
        "relative_error": {"median": float(np.median(error)), "worst": float(error.max())},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", default=["planar_hand", "allegro_ball", "allegro_cube", "iiwa_bimanual"])
    parser.add_argument("--steps", type=int, default=32)
    parser.add_argument("--rollouts", type=int, default=200)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    for name in arguments.tasks:
        row = measure(name, arguments.rollouts, arguments.steps)
        times, error = row["us_a_step"], row["relative_error"]
        line = f"{name}: {times['rollout']:.1f} µs a step, {times['gradient']:.1f} µs for its gradient, together {row['ratio']:.2f} of a step with A and B"
        print(json.dumps(row) if arguments.json else f"{line}; relative error {error['median']:.1e} (worst {error['worst']:.1e}), {row['failed']} failed")


if __name__ == "__main__":
    main()
