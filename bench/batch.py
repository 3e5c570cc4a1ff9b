#!/usr/bin/env python3
"""How many steps with B a second `st.step_batch` makes from Python, beside what the library makes of the same batch and a loop of `st.step`.

    bench/batch.py [--task allegro_ball] [--steps 100000] [--json]

States are those of a plan of the task, disturbed. One line, or one JSON object; nothing is judged.
"""

import argparse
import json
import os
import pathlib
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "build/release/python"))
import stiction as st  # noqa: E402


def states(task, steps):
    """Configurations and commands of a plan, joints and commands disturbed by 0.02 rad (or as many metres)."""
    plan = st.plan(task, seed=0, timeout_s=60).plan
    random = np.random.default_rng(0)
    at = random.integers(0, len(plan.q) - 1, steps)
    n_a = task.model.n_a
    q, u = plan.q[at].copy(), plan.u[at + 1].copy()
    q[:, -n_a:] += 0.02 * random.standard_normal((steps, n_a))
    return q, u + 0.02 * random.standard_normal((steps, n_a))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--task", default="allegro_ball")
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    task = st.load_task(arguments.task)
    options = {"smoothing": st.Analytic(kappa=1000), "with_B": True}
    q, u = states(task, arguments.steps)
    st.step_batch(task.model, q[:1000], u[:1000], **options)  # warms caches
    out = {"task": arguments.task, "steps": arguments.steps, "cores": os.cpu_count()}
    for threads in (1, 0):
        start = time.perf_counter()
        batch = st.step_batch(task.model, q, u, threads=threads, **options)
        wall = time.perf_counter() - start
        key = "all" if threads == 0 else "one"
        out |= {f"{key}_steps_per_s": arguments.steps / wall, f"{key}_share_of_library": batch.wall_s / wall, "failed": batch.failed}
    some = min(2000, arguments.steps)
    start = time.perf_counter()
    work = st.StepWorkspace(task.model)
    for i in range(some):
        work.forget()
        st.step(task.model, q[i], u[i], workspace=work, **options)
    out["loop_steps_per_s"] = some / (time.perf_counter() - start)
    if arguments.json:
        print(json.dumps(out))
    else:
        print(
            f"{arguments.task}: {out['all_steps_per_s']:.0f} steps with B a second on {out['cores']} cores, {100 * out['all_share_of_library']:.1f} % of the library's rate; "
            f"{out['one_steps_per_s']:.0f} on one; {out['loop_steps_per_s']:.0f} in a loop of step(); {out['failed']} failed"
        )


if __name__ == "__main__":
    main()
