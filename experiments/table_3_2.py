"""Table 3.2: time of 1000 iterations with three smoothing schemes."""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np
import stiction as st

from . import growth
from .report import Result

CORES = os.cpu_count() or 1
TITLE = "Table 3.2: growth times of six tasks with three smoothing schemes"


def run(quick: bool) -> Result:
    names = ("planar_pushing", "planar_hand") if quick else tuple(growth.SYSTEMS)
    iterations = 100 if quick else growth.ITERATIONS
    seeds = range(1)
    result = Result(
        f"{iterations} iterations with the settings of the published runs. The wall clock suffers from whatever else runs; the processor time of "
        "all threads does not. Published: 16 cores, 100 samples, as here.",
        settings={"iterations": iterations, "seeds": list(seeds)},
    )
    table: dict[str, list[float]] = {"wall_s": [], "processor_s": [], "published_s": []}
    slower = True
    for name in names:
        system = growth.SYSTEMS[name]
        of_scheme = {}
        for scheme, published in zip(growth.SCHEMES, system.published):
            task = st.load_task(f"{name}_table_3_2")
            settings = task.options.thesis | growth.variants(system)[scheme] | {"stop_at_goal": False}
            options = {"max_iterations": iterations, "thesis": settings}
            wall, processor = np.median([timed(task, options, seed) for seed in seeds], axis=0)
            of_scheme[scheme] = processor
            for column, value in zip(table.values(), (wall, processor, published)):
                column.append(value)
            ours = f"{wall:.3f} s, {processor:.3f} s of processor"
            scaled = published * iterations / growth.ITERATIONS
            note = f"published/ours {scaled / wall:.0f}; on {CORES} idle cores {scaled * CORES / processor:.0f}"
            result.add(f"{name}, {scheme}", f"{published} s", ours, scaled > wall, note)
        slower &= of_scheme["analytic"] < min(of_scheme["randomized-first"], of_scheme["randomized-zeroth"])
    result.data["times"] = table
    result.add("hypothesis 2: analytic smoothing is the fastest", "on every task", "on every task" if slower else "not everywhere", slower or None)
    return result


def timed(task: st.Task, options: dict[str, Any], seed: int) -> tuple[float, float]:
    wall, processor = time.perf_counter(), time.process_time()
    st.plan(task, options=options, seed=seed, timeout_s=600)
    return time.perf_counter() - wall, time.process_time() - processor
