#!/usr/bin/env python3
"""Do guarded moves reach their end, how hard do they press, and how well is a wrong height found? 40 seeds of each scenario in MuJoCo, with the noise of a real Franka.

    PYTHONPATH=build/release/python .venv/bin/python bench/move_until_touch.py [--seeds 40] [--scenario NAME…] [--joint-friction COULOMB VISCOUS | --friction-of KIND [--friction-error SHARE | --friction-motion RAD]] [--runs 10] [--first-seed 0] [--program build/release/stiction] [--json]

With --joint-friction the joints of the simulated arm have that dry friction [N m] and damping [N m s/rad], as a robot's file states them in <dynamics>: what motor currents show of an arm
without torque sensors behind its gears. With --friction-of each joint has the friction that was identified on a Franka, see FRANKA; joints of a hand then have none. With --friction-error the observer takes friction off that is too large by this share, with --friction-motion what it found by moving joints to and fro by so much, else none. Forces are those of the simulation, from 0.1 s after contact on, as a share of what the move asks for, and while it slides of the controller's bound. Noise is what `calibrate` finds on docs/tutorials/franka_touches.csv.

With --runs the task ur5_mesh_push is run as well, with so many seeds, after scenarios/feel_table.yaml and after the same without moves. The table, and the block on it, is then 15 to 20 mm higher or lower than the arm thinks: seeds that draw less are left out. A
block is delivered where it is within the tolerances of its goal at the end, the goal being meant relative to the table. Planning counts in steps, so that runs are the same on every machine.
"""

import argparse
import itertools
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
import yaml

import real_touches
import stiction as st

ROOT = pathlib.Path(__file__).resolve().parent.parent
FAR = 0.015  # [m]
RUN = 120  # of the clock of the simulation, at most [s]
SCENARIOS = ["lower_until_touch", "press_button", "follow_wall", "lower_mug", "close_hand"]

# C. Gaz, M. Cognetti, A. Oliva, P. Robuffo Giordano, A. De Luca, "Dynamic Identification of the Franka Emika Panda Robot With Retrieval of Feasible Parameters Using Penalty-Based
# Optimization", RA-L 2019, numbers as in the authors' franka_model.h (github.com/marcocognetti/FrankaEmikaPandaDynModel): τ_f = φ₁/(1 + exp(−φ₂(q̇ + φ₃))) − φ₁/(1 + exp(−φ₂φ₃)).
# φ₁ is the span from one direction to the other, so either direction has half of it. φ₃ shifts the curve by at most 0.05 rad/s and is left out.
PHI_1 = np.array([0.54615, 0.87224, 0.64068, 1.2794, 0.83904, 0.30301, 0.56489])  # [N m]
PHI_2 = np.array([5.1181, 9.0657, 10.136, 5.5903, 8.3469, 17.133, 10.336])  # [s/rad]
FRANKA = {
    "franka": (0 * PHI_1, PHI_1 * PHI_2 / 4),  # as identified, at the speeds of guarded moves: the curve is smooth, with this slope at rest
    "franka-dry": (PHI_1 / 2, 0 * PHI_1),  # the same size as dry friction: joints stick
}


def find_noise():
    model, _ = real_touches.load_arm("panda")
    found = real_touches.calibrate_without(model, real_touches.load_logs(), "")
    return {"noise": np.sqrt(np.diag(found.within))[:7].round(4).tolist(), "drift": np.ravel(found.drift)[:7].round(4).tolist()}


def friction_of(arguments, joint):
    """Dry friction and damping of a joint, counted from the base."""
    if arguments.joint_friction:
        return arguments.joint_friction
    coulomb, viscous = FRANKA[arguments.friction_of]
    return coulomb[joint], viscous[joint]


def write_with_friction(name, arguments, folder):
    """The scenario with a robot whose joints have friction."""
    scenario = yaml.safe_load((ROOT / "scenarios" / f"{name}.yaml").read_text(encoding="utf-8"))
    for robot in scenario["scene"]["robots"]:
        source = (ROOT / "scenarios" / robot["urdf"]).resolve()
        number = itertools.count()
        give = lambda joint: joint[0] + '<dynamics friction="{:g}" damping="{:g}"/>'.format(*friction_of(arguments, next(number)))
        text, given = re.subn(r'<joint name="[^"]*" type="(?:revolute|continuous)">', give, source.read_text(encoding="utf-8"))
        if not given:
            sys.exit(f"{source}: no joint was given friction")
        copy = folder / source.name
        copy.write_text(text, encoding="utf-8")
        robot["urdf"] = str(copy)
        if "mount" in robot:
            robot["mount"] = {"on" if key is True else key: value for key, value in robot["mount"].items()}  # PyYAML takes `on` for true
            robot["mount"]["file"] = str((ROOT / "scenarios" / robot["mount"]["file"]).resolve())
    scenario["plant"] = scenario.get("plant", {}) | {"joint_friction": True}
    if arguments.friction_error is not None:
        scenario["estimator"]["friction_error"] = arguments.friction_error
    if arguments.friction_motion is not None:
        scenario["friction_motion"] = arguments.friction_motion
    file = folder / f"{name}.yaml"
    file.write_text(yaml.safe_dump(scenario, sort_keys=False), encoding="utf-8")
    return str(file)


def run(program, scenario, seed):
    done = subprocess.run([program, "touch", scenario, "--seed", str(seed), "--json"], capture_output=True, text=True, timeout=300)
    out = json.loads(done.stdout) if done.stdout else {}
    if "moves" not in out:
        sys.exit(f"{scenario}, seed {seed}: {out.get('message') or done.stderr}")
    return out


def asked_forces(scenario):
    """Bounds of the moves that press: the force with which a move ends, and while it slides the bound of the controller."""
    text = yaml.safe_load((ROOT / "scenarios" / f"{scenario}.yaml").read_text(encoding="utf-8"))
    bound = text["controller"]["lambda_max"]
    return {move["name"]: move["until"]["force"] if "until" in move else bound if "press" in move else None for move in text["moves"]}


def table_of(model):
    return model.body_poses(model.neutral())["table"].p


def far_seeds(name, count):
    """The first seeds with which the table is far from where the arm thinks that it is."""
    scenario = st.load_touch_scenario(name)
    off = lambda seed: np.linalg.norm(table_of(scenario.make_world(seed)) - table_of(scenario.model))
    return list(itertools.islice((seed for seed in itertools.count() if off(seed) > FAR), count))


def deliver(file, seeds):
    """Runs of ur5_mesh_push after the moves of a file."""
    rows = []
    for seed in seeds:
        task = st.load_task("ur5_mesh_push")
        out = st.run(task, touch_first=file, seed=seed, threads=1, duration=RUN, timeout_s=10 * RUN, plan_step_time_s=2e-5)
        really = table_of(out.touch.world)
        block, goal = task.model.object_pose(out.q[-1], "block"), task.goal.X_WG
        off = float(np.linalg.norm(block.p - goal.p - really))
        angle = float(np.arccos(np.clip(0.5 * (np.trace(block.R.T @ goal.R) - 1), -1, 1)))
        known = table_of(out.touch.model)
        row = {"seed": seed, "table_mm": round(1e3 * float(really[2]), 2), "found_mm": round(1e3 * float(known[2]), 2), "end": out.end.name, "duration_s": round(out.duration_s, 1)}
        rows.append(row | {"delivered": off <= task.goal.tol_position and angle <= task.goal.tol_angle, "plans": len(out.plans), "moves_s": round(out.touch.moves[-1].end, 1) if out.touch.moves else 0})
    return rows


def compare_runs(seeds):
    """After guarded moves, and without them."""
    file = ROOT / "scenarios" / "feel_table.yaml"
    text = yaml.safe_load(file.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as folder:
        blind = pathlib.Path(folder) / "blind.yaml"
        blind.write_text(yaml.safe_dump({key: value for key, value in text.items() if key != "moves"} | {"task": str(file.parent / text["task"])}), encoding="utf-8")
        tried = far_seeds(file.stem, seeds)
        runs = {"felt first": deliver(file, tried), "without moves": deliver(blind, tried)}
    return [{"runs": how, "seeds": seeds, "delivered": sum(row["delivered"] for row in rows), "reached": sum(row["end"] == "Reached" for row in rows),
             "plans": percent([row["plans"] for row in rows], 0.5), "duration_s": percent([row["duration_s"] for row in rows], 0.5), "each": rows} for how, rows in runs.items()]


def percent(values, share):
    return round(float(np.quantile(values, share)), 3) if values else None


def judge(scenario, arguments):
    asked, first, seeds = asked_forces(scenario), arguments.first_seed, arguments.seeds
    with tempfile.TemporaryDirectory() as folder:
        rubs = arguments.joint_friction or arguments.friction_of
        file = write_with_friction(scenario, arguments, pathlib.Path(folder)) if rubs else scenario
        outs = [run(arguments.program, file, seed) for seed in range(first, first + seeds)]
    reached, alarms, told, late, impact, last, found, corrections, links, failed = 0, [], [], [], [], [], [], [], [], []
    for seed, out in enumerate(outs, first):
        reached += out["status"] in ("Passed", "Failed")
        if out["status"] != "Passed":
            failed.append({"seed": seed, "status": out["status"], "message": out["message"]})
        for move in out["moves"]:
            force = asked[move["name"]]
            if not force:
                continue
            late.append(move["late_peak"] / force)
            impact.append(move["peak"])
            if "correction" in move:
                corrections.append(1e3 * move["correction"])
                found.append(1e3 * move["correction_error"])
            if not move["felt"]:
                continue
            last.append(move["last_force"])
            links += [felt["probability"] for felt in move["felt"]]
            alarms.append(1e3 * (min(felt["alarm_s"] for felt in move["felt"]) - move["contact_s"]))
            told.append(max(felt["time_s"] for felt in move["felt"]) - move["contact_s"])
    return {
        "scenario": scenario,
        "joint_friction": rubs,
        "friction_error": arguments.friction_error,
        "friction_motion": arguments.friction_motion,
        "seeds": seeds,
        "reached": reached,
        "noticed_ms": [percent(alarms, 0.5), percent(alarms, 1)],
        "told_s": [percent(told, 0.5), percent(told, 1)],
        "late_peak_of_asked": [percent(late, 0.5), percent(late, 1)],
        "impact_N": [percent(impact, 0.5), percent(impact, 1)],
        "last_force_N": [percent(last, 0), percent(last, 0.5), percent(last, 1)],
        "correction_mm": [percent(corrections, 0), percent(corrections, 1)],
        "correction_error_mm": [percent(found, 0), percent(found, 1)],
        "probability_of_link": [percent(links, 0), percent(links, 0.5)],
        "failed": failed,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--scenario", nargs="*", default=SCENARIOS)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--joint-friction", nargs=2, type=float, metavar=("COULOMB", "VISCOUS"))
    which.add_argument("--friction-of", choices=FRANKA)
    parser.add_argument("--friction-error", type=float)
    parser.add_argument("--friction-motion", type=float)
    parser.add_argument("--runs", type=int, default=0)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--program", default=ROOT / "build" / "release" / "stiction")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    out = {"noise": find_noise(), "runs": [judge(name, arguments) for name in arguments.scenario]}
    out["runs"] += compare_runs(arguments.runs) if arguments.runs else []
    if arguments.json:
        print(json.dumps(out))
        return
    print("noise of the real arm [N m], drift [N m/√s]:", *out["noise"].values(), sep="\n  ")
    for row in out["runs"]:
        print(*(f"{key:22} {value}" for key, value in row.items()), sep="\n")


if __name__ == "__main__":
    main()
