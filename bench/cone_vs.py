#!/usr/bin/env python3
"""Our cone solver beside Clarabel and ProxQP on the same problems in one run; rows as `stiction bench --json`, for bench/refresh.py.

    bench/cone_vs.py [INSTANCES] > cone_vs.json

All solve from cold. Theirs are asked for 1e-8, ours for 1e-9 of all rows together, so that residuals compare; theirs are timed by their own clocks,
without building the problem, ours around solve(). Cones: ours and Clarabel. Pyramids of four rays: ours, Clarabel and ProxQP.
"""

import json
import pathlib
import statistics
import subprocess
import sys

import clarabel
import numpy as np
import proxsuite
from scipy import sparse

ROOT = pathlib.Path(__file__).resolve().parents[1]


def project(w, n_cones):
    """Distance of the rows from their cones, largest over the rows."""
    c = w[: 3 * n_cones].reshape(-1, 3)
    outside = np.concatenate([np.linalg.norm(c[:, 1:], axis=1) - c[:, 0], -w[3 * n_cones :], [0.0]])
    return outside.max()


def residual(p, x, z):
    """Largest of scaled stationarity, primal and dual violation and wᵀz over all rows."""
    Q, b, G, g = p["Q"], p["b"], p["G"], p["g"]
    w = G @ x + g
    scale = np.maximum.reduce([np.ones_like(b), abs(b), abs(Q @ x), abs(G).T @ abs(z)])
    return max((abs(Q @ x + b - G.T @ z) / scale).max(), project(w, p["n_cones"]), project(z, p["n_cones"]), abs(w @ z) / max(1, abs(b).max()))


def solve_clarabel(p):
    cones = [clarabel.SecondOrderConeT(3)] * p["n_cones"] + ([clarabel.NonnegativeConeT(p["n_lines"])] if p["n_lines"] else [])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-8
    P = sparse.triu(sparse.csc_matrix(p["Q"]), format="csc")
    s = clarabel.DefaultSolver(P, p["b"], sparse.csc_matrix(-p["G"]), p["g"], cones, settings).solve()
    return s.solve_time, np.array(s.x), np.array(s.z)


def solve_proxqp(p):
    n, m = len(p["b"]), len(p["g"])
    qp = proxsuite.proxqp.dense.QP(n, 0, m)
    qp.settings.eps_abs = 1e-8
    qp.settings.eps_rel = 0
    qp.settings.compute_timings = True
    qp.init(p["Q"], p["b"], None, None, p["G"], -p["g"], np.full(m, 1e20))
    qp.solve()
    return qp.results.info.solve_time * 1e-6, qp.results.x, -qp.results.z


def main():
    instances = sys.argv[1] if len(sys.argv) > 1 else "30"
    program = ROOT / "build" / "release" / "bench" / "cone_vs"
    problems = json.loads(subprocess.run([program, instances], check=True, capture_output=True, text=True).stdout)
    rows = {}
    for p in problems:
        for key in ("Q", "b", "G", "g", "x", "z"):
            p[key] = np.array(p[key])
        solvers = {"clarabel": solve_clarabel} if p["friction"] == "cone" else {"clarabel": solve_clarabel, "proxqp": solve_proxqp}
        for name, solve in solvers.items():
            seconds, x, z = solve(p)
            row = rows.setdefault((name, p["family"], p["friction"]), {"ours": [], "theirs": [], "r_ours": [], "r_theirs": [], "failed": 0})
            row["ours"].append(p["seconds"])
            row["theirs"].append(seconds)
            row["r_ours"].append(residual(p, p["x"], p["z"]))
            row["r_theirs"].append(residual(p, x, z))
            row["failed"] += p["status"] != "Solved"
    out = []
    print(f"{'':46} {'ours [ms]':>10} {'theirs':>10} {'times':>7} {'residual':>10} {'theirs':>10}", file=sys.stderr)
    for (name, family, friction), row in rows.items():
        ours, theirs = statistics.median(row["ours"]), statistics.median(row["theirs"])
        label = f"cone_vs/{name}/{family}/{friction}"
        print(
            f"{label:46} {1e3 * ours:10.4f} {1e3 * theirs:10.4f} {theirs / ours:7.1f} {max(row['r_ours']):10.1e} {max(row['r_theirs']):10.1e}",
            file=sys.stderr,
        )
        out.append(
            {"name": label, "ours_s": ours, "theirs_s": theirs, "ratio": ours / theirs, "residual_ours": max(row["r_ours"]),
             "residual_theirs": max(row["r_theirs"]), "failed": row["failed"]}
        )  # fmt: skip
    print(json.dumps({"instances": int(instances), "results": out}))


if __name__ == "__main__":
    main()
