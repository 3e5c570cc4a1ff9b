#!/usr/bin/env python3
"""Plans every task with many seeds, refines and checks every plan and says how often, how fast and with how much memory.

    .venv/bin/python bench/end_to_end.py [--seeds 20] [--first-seed 0] [--timeout 20 | --processor-seconds 40] [--program build/release/stiction] [--beside OTHER] [--rows FILE] [TASK …] > end_to_end.json

One JSON object on stdout; a line for each run on stderr. Times are those of `stiction plan` and `stiction refine` together, as the programs
run; a plan is accepted when `stiction check` accepts it as planned and as refined. With --processor-seconds the planner's budget is that of the processors, which is
the same on a machine that does other work beside. Exit code 1 when one was not solved or not accepted.
"""

import dataclasses
import json
import pathlib
import statistics
import subprocess
import tempfile
import typing

from by_task import make_parser, measure
from runs import ROOT, exit_with, measure_run

TASKS = [
    "planar_pushing",
    "planar_hand",
    "planar_hand_fixed_y",
    "box_grazing",
    "allegro_ball",
    "allegro_cube",
    "allegro_cube_180",
    "allegro_cube_roll",
    "allegro_pen",
    "allegro_plate",
    "allegro_door",
    "iiwa_bimanual_planar",
    "iiwa_bimanual",
    "iiwa_bimanual_box",
    "ur5_mesh_push",
]


def refused(program, plan):
    """Names of what `stiction check` does not accept."""
    done = measure_run([program, "check", plan, "--json"])
    checks = json.loads(done.text).get("checks", []) if done.text else []
    return [item["name"] for item in checks if not item["pass"]] or (["no report"] if done.code else [])


@dataclasses.dataclass(frozen=True)
class EndToEnd:
    """What one seed comes to with each of the programs, in turn."""

    programs: tuple
    timeout: float
    processor_seconds: int | None = None

    OF_EACH: typing.ClassVar = ("status", "wall_s", "processor_s", "peak_mb", "refused")
    columns: typing.ClassVar = (*OF_EACH[1:], *(f"beside_{name}" for name in OF_EACH))

    def __call__(self, case):
        first, *beside = [self.plan_and_refine(program, case) for program in self.programs]
        return [first | {f"beside_{name}": value for row in beside for name, value in row.items()}]

    def plan_and_refine(self, program, case):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder)
            timeout = 20 * self.processor_seconds if self.processor_seconds else self.timeout
            planned = measure_run([program, "plan", case.task, "--seed", case.seed, "--timeout", timeout, "-o", out, "--json"], self.processor_seconds)
            if planned.out_of_processor_time:
                return dict(zip(self.OF_EACH, ("OutOfTime", planned.wall_s, planned.processor_s, planned.peak_mb, [])))
            if planned.code not in (0, 3):
                raise RuntimeError(f"{program} ends with exit code {planned.code}")
            runs, failed = [planned], [f"plan {name}" for name in refused(program, out)]
            if planned.code == 0:
                runs.append(measure_run([program, "refine", out, "--json"]))
                failed += [f"refined {name}" for name in refused(program, out / "refined")]
        times = (sum(run.wall_s for run in runs), sum(run.processor_s for run in runs), max(run.peak_mb for run in runs))
        return dict(zip(self.OF_EACH, (json.loads(planned.text)["status"], *times, failed)))


def accepted(row):
    return row["status"] == "Solved" and not row["refused"]


def describe(row):
    check = f"failed: {', '.join(row['refused'])}" if row["refused"] else "passed"
    return f"{row['status']}, refined in {row['wall_s']:.2f} s ({row['processor_s']:.2f} s of processors), {row['peak_mb']:.0f} MB, check {check}"


def summarise(task, rows):
    commit = subprocess.run(["git", "-C", ROOT, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True).stdout.strip() or None
    times, processor_times, beside = ([row[name] for row in rows] for name in ("wall_s", "processor_s", "beside_wall_s"))
    out = {"task": task, "runs": len(rows), "commit": commit, "accepted": sum(map(accepted, rows)), "peak_mb": max(row["peak_mb"] for row in rows)}
    out |= {"median_s": statistics.median(times), "worst_s": max(times)}
    out |= {"median_processor_s": statistics.median(processor_times), "worst_processor_s": max(processor_times)}
    if None not in beside:
        out |= {"mean_s": statistics.mean(times), "beside_median_s": statistics.median(beside), "beside_mean_s": statistics.mean(beside)}
    return out


def table(results):
    return "\n".join(
        f"{r['task']}: {r['accepted']} of {r['runs']} accepted, {r['median_s']:.2f} s (median), {r['worst_s']:.2f} s at most; "
        f"processors {r['median_processor_s']:.2f} s (median), {r['worst_processor_s']:.2f} s at most" for r in results
    )


def main():
    parser = make_parser(__doc__.splitlines()[0], TASKS)
    parser.add_argument("--timeout", type=float, default=20, help="of the planner, by the clock [s]")
    parser.add_argument("--processor-seconds", type=int, help="budget of the planner in place of --timeout: seconds of processors, 40 are 20 s of two cores")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    parser.add_argument("--beside", type=pathlib.Path, help="another version of the program, run in turn with it: machines are not equally fast for long; its own built-in tasks")
    arguments = parser.parse_args()
    programs = tuple(str(program) for program in (arguments.program, arguments.beside) if program)
    results = measure(arguments, describe, summarise, table, run=EndToEnd(programs, arguments.timeout, arguments.processor_seconds), processes=1)
    return 0 if all(row["accepted"] == row["runs"] for row in results) else 1


if __name__ == "__main__":
    exit_with("end_to_end", main)
