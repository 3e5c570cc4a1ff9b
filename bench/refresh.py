#!/usr/bin/env python3
"""Turns the output of the benchmarks into docs/benchmarks.md; what is not given stays as it is, down to tasks that were not run end to end.

    build/release/stiction bench --json > bench.json
    bench/end_to_end.py --seeds 100 > end_to_end.json
    bench/cone_vs.py > cone_vs.json
    bench/mesh_steps.py > mesh_steps.json
    build/release/bench/growth_bench planar_hand allegro_ball_table_3_2 > growth.txt
    bench/refresh.py [--steps bench.json] [--end-to-end end_to_end.json] [--meshes mesh_steps.json] [--cones cone_vs.json] [--growth growth.txt]
"""

import argparse
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]


def milliseconds(seconds):
    if seconds is None:
        return "–"
    value = 1e3 * seconds
    if value < 1e-3:
        return f"{value:.6f}"
    return f"{value:.4f}" if value < 1 else f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def times(other, ours):
    if other is None:
        return "–"
    ratio = other / ours
    return f"{ratio:.1f}" if ratio < 10 else f"{ratio:.0f}"


def bench_table(data):
    lines = [
        "| row | contacts | median [ms] | p95 [ms] | p99 [ms] | published [ms] | times faster | peer [ms] | times faster | allocations |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in data["results"]:
        cells = [
            f"`{row['name']}`",
            "–" if row["contacts"] is None else f"{row['contacts']:.0f}",
            milliseconds(row["median_s"]),
            milliseconds(row["p95_s"]),
            milliseconds(row["p99_s"]),
            milliseconds(row["published_s"]),
            times(row["published_s"], row["median_s"]),
            milliseconds(row["peer_s"]),
            times(row["peer_s"], row["median_s"]),
            "–" if row["allocations"] is None else str(row["allocations"]),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def end_to_end_table(data, before):
    """Tasks that were not run keep their rows of `before`, the lines of the section as it is."""
    lines = [
        "| task | solved and accepted | median [s] | worst [s] | peak memory [MB] | commit |",
        "|---|---|---|---|---|---|",
    ]
    rows = {line.split("|")[1].strip(): line for line in before if line.startswith("| `")}
    for row in data["results"]:
        task = f"`{row['task']}`"
        rows[task] = f"| {task} | {row['accepted']} of {row['runs']} | {row['median_s']:.2f} | {row['worst_s']:.2f} | {row['peak_mb']:.0f} | {row.get('commit', '–')} |"
    return lines + list(rows.values())


def cone_table(data):
    lines = [
        "| row | ours [ms] | theirs [ms] | times faster | largest residual, ours | theirs |",
        "|---|---|---|---|---|---|",
    ]
    for row in data["results"]:
        lines.append(
            f"| `{row['name']}` | {milliseconds(row['ours_s'])} | {milliseconds(row['theirs_s'])} | {times(row['theirs_s'], row['ours_s'])} "
            f"| {row['residual_ours']:.0e} | {row['residual_theirs']:.0e} |"
        )
    return lines


def steps_section(data):
    return [
        "# Benchmarks",
        "",
        "Made by `bench/refresh.py` from `stiction bench --json`; do not edit.",
        "",
        f"Machine: {data['machine']}. Commit: {data['commit']}.",
        "",
        "* `step_exact/TASK`, `step_exact_B/TASK`, `step_smoothed_B/TASK`: one step with kinematics and contacts, and B where the name says so, at states",
        "  with active contacts along plans of the task. Cold, that is without anything kept from another step; `/warm` rows follow the step before.",
        "* `step_coulomb/TASK`: the exact step that the plans of a task with Coulomb's law are made of, always cold.",
        "* `step_smoothed_AB/…`: the same with A and B. `randomized_100/…`: a first-order randomised local model, 100 samples on all threads.",
        "* `stacking_69dof/step`: ten boxes, arm and gripper along the published motion at h = 0.1 s. `scaling_contacts/N`: one body on N feet;",
        "  `scaling_bodies/N`: a tower of N boxes, four contacts each. contacts: median number of candidates of a step.",
        "* `cone/…`: random but physical cone programs, seeded; the solve alone.",
        "* `rrt_1000/…`: a tree of exactly 1000 extensions with the single-step settings of the published runs, no early stop, one core.",
        "* `impc_10/…`: ten iterations of trajectory optimisation with the settings of Table 3.1, analytic scheme, all cores.",
        "* `residual/…`: one residual (4.5) of a contact point, batched where the name says so. `descent/…`: one descent of Algorithm 4.",
        "  `sense_cycle/…`: 1000 samples and their descents, δ = 0.1, on capsules or on `meshes`. `discriminate/10`: (4.13) for ten candidates. One core.",
        "* `contact_qp/…`: one solve of the contact controller with seven joints; `…/proxqp`, `…/highs`: the same problems by ProxQP, its peer, and by HiGHS.",
        "* `contact_estimate/7_joints`: contacts of a control loop from the torques of one tick, of ticks in contact; touches begin among them; one, or two at once.",
        "* published: the thesis, Tables 3.1 and 3.2 on 16 cores, and section 2.3 (an upper bound, commercial solver). peer: the thesis's research code on two",
        "  cores; its steps include contacts and B.",
        "",
        *bench_table(data),
    ]


def end_to_end_section(data, before):
    return [
        "## End to end",
        "",
        "`bench/end_to_end.py`: `stiction plan TASK --seed s` for s = 0, 1, …, then `stiction refine`; `stiction check` judges both. Wall time of both programs.",
        "",
        *end_to_end_table(data, before),
    ]


def cones_section(data):
    return [
        "## The cone solver beside others",
        "",
        f"`bench/cone_vs.py`: {data['instances']} seeded problems of each kind, cold, one run. Cones as they are, and with pyramids of four rays. Largest residual: of",
        "stationarity, cones and complementarity over all rows, recomputed from the raw matrices.",
        "",
        *cone_table(data),
    ]


def meshes_section(data):
    lines = ["| row | contacts | median [ms] | p95 [ms] | of its twin's | allocations |", "|---|---|---|---|---|---|"]
    for row in data["results"]:
        ratio = f"{row['ratio_to_twin']:.2f}" if "ratio_to_twin" in row else "–"
        lines.append(
            f"| `{row['name']}` | {row['contacts']:.0f} | {milliseconds(row['median_s'])} | {milliseconds(row['p95_s'])} | {ratio} | {row['allocations']} |"
        )
    return [
        "## Meshes beside primitives",
        "",
        f"`bench/mesh_steps.py`: exact steps of robots with their meshes, and of the same robots made of capsules (arms) or boxes (hand), one run. Commit: {data['commit']}.",
        "",
        *lines,
    ]


def growth_section(text):
    return [
        "## Size of the tree",
        "",
        "`bench/growth_bench TASK…`: time of an iteration on one thread between two sizes of the tree, and the memory of the process so far.",
        "",
        "```",
        *text.splitlines(),
        "```",
    ]


def sections_of(text):
    """Heading → lines, without the blank ones at the end."""
    sections = {}
    for line in text.splitlines():
        if line.startswith(("# ", "## ")):
            sections[line] = lines = []
        lines.append(line)
    for lines in sections.values():
        while lines and not lines[-1]:
            lines.pop()
    return sections


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=pathlib.Path, help="of stiction bench --json")
    parser.add_argument("--end-to-end", type=pathlib.Path, help="of bench/end_to_end.py")
    parser.add_argument("--meshes", type=pathlib.Path, help="of bench/mesh_steps.py")
    parser.add_argument("--cones", type=pathlib.Path, help="of bench/cone_vs.py")
    parser.add_argument("--growth", type=pathlib.Path, help="of growth_bench")
    arguments = parser.parse_args()

    target = ROOT / "docs" / "benchmarks.md"
    sections = sections_of(target.read_text(encoding="utf-8"))
    new = []
    if arguments.steps:
        new.append(steps_section(json.loads(arguments.steps.read_text())))
    if arguments.end_to_end:
        new.append(end_to_end_section(json.loads(arguments.end_to_end.read_text()), sections.get("## End to end", [])))
    if arguments.meshes:
        new.append(meshes_section(json.loads(arguments.meshes.read_text())))
    if arguments.cones:
        new.append(cones_section(json.loads(arguments.cones.read_text())))
    if arguments.growth:
        new.append(growth_section(arguments.growth.read_text()))
    if not new:
        parser.error("nothing given: at least one of --steps, --end-to-end, --meshes, --cones, --growth")
    for lines in new:
        sections[lines[0]] = lines
    target.write_text("\n\n".join("\n".join(lines) for lines in sections.values()) + "\n", encoding="utf-8")
    print(f"wrote {target.relative_to(ROOT)}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
