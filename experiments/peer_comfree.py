#!/usr/bin/env python3
"""Complementarity-free MPC on its own scenes, beside `stiction run` on the same files, starts and goals.

    experiments/peer_comfree.py CHECKOUT --peer-python VENV/bin/python

CHECKOUT is a copy of its repository, VENV an environment with mujoco 3.2, casadi 3.6 and numpy below 2. Its controller, simulator and success test are its
own, without its window; the figures go to the file from which `stiction benchmark` writes its page. Each case is one start and goal, by the seeds of its
program. Takes about ten processor minutes.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import io
import json
import math
import os
import re
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "python/module/stiction/benchmark_peers.json"
POSITION, ANGLE = 0.01, math.radians(5)  # our test [m], [rad]
PROGRAM = "Complementarity-free MPC"


@dataclass(frozen=True)
class Scene:
    title: str
    folder: str  # of examples/mpc
    target: str  # as its parameters name it
    script: str  # whose constants are its success test
    stiffness: float | None = None  # of the position controller in its simulator, where the file has motors


SCENES = {
    "allegro": Scene("Allegro hand, cube", "allegro/cube", "rotation", "test.py"),
    "fingertips": Scene("Three fingertips, cube on the ground", "fingertips/cube", "ground-rotation", "test-ground-rotation.py", 100),
    "trifinger": Scene("TriFinger, cube", "trifinger/cube", "rotation", "test.py", 10),
}


def constants(checkout: Path, scene: Scene) -> dict[str, float]:
    """Thresholds of its success test: of position [m] (infinite where its script does not look at it), of 1 − ⟨q, q_goal⟩², and numbers of steps."""
    text = (checkout / "examples/mpc" / scene.folder / scene.script).read_text(encoding="utf-8")

    def number(name: str) -> float:
        found = re.search(rf"^{name} = ([\d.]+)", text, flags=re.MULTILINE)
        if found is None:
            raise SystemExit(f"{checkout}: {scene.folder}/{scene.script}: got no line '{name} = …', expected one")
        return float(found.group(1))

    position = number("success_pos_threshold") if "comp_pos_error(" in text else math.inf
    return {
        "position": position,
        "quaternion": number("success_quat_threshold"),
        "in_a_row": number("consecutive_success_time_threshold"),
        "most": number("max_rollout_length"),
    }


def angle_between(a: Any, b: Any) -> float:
    """Of two unit quaternions [rad]."""
    return 2 * math.acos(min(1.0, abs(sum(x * y for x, y in zip(a, b)))))


def is_within(errors: tuple[float, float], test: dict[str, float]) -> bool:
    return errors[0] < test["position"] and math.sin(errors[1] / 2) ** 2 < test["quaternion"]  # 1 − ⟨a, b⟩² = sin²(θ / 2)


class Judge:
    """When a motion first passes both tests: theirs in a row for so many steps of the controller, ours at one moment."""

    def __init__(self, test: dict[str, float], period: float) -> None:
        self._test, self._lasts, self._since = test, test["in_a_row"] * period, None
        self.theirs_s: float | None = None
        self.ours_s: float | None = None
        self.best = (math.inf, math.inf)

    def look(self, when: float, errors: tuple[float, float]) -> None:
        self.best = min(self.best, errors, key=lambda e: max(e[0] / POSITION, e[1] / ANGLE))
        self._since = (when if self._since is None else self._since) if is_within(errors, self._test) else None
        if self.theirs_s is None and self._since is not None and when - self._since >= self._lasts - 1e-9:
            self.theirs_s = when
        if self.ours_s is None and errors[0] <= POSITION and errors[1] <= ANGLE:
            self.ours_s = when

    def rest(self, when: float, errors: tuple[float, float]) -> None:
        """The object stays there."""
        if self.theirs_s is None and is_within(errors, self._test):
            self.theirs_s = when

    def said(self) -> dict[str, Any]:
        return {"theirs_s": self.theirs_s, "ours_s": self.ours_s, "best": self.best}


# ---- its program, in its own environment


def load_peer(checkout: Path, scene: Scene, seed: int) -> SimpleNamespace:
    """Its parameters, simulator, contacts and controller; its window stays closed."""
    os.chdir(checkout)
    sys.path.insert(0, str(checkout))
    import mujoco.viewer

    mujoco.viewer.launch_passive = lambda *_, **__: SimpleNamespace(sync=lambda: None, close=lambda: None)
    name = scene.folder.split("/")[0]
    parameters = importlib.import_module(f"examples.mpc.{scene.folder.replace('/', '.')}.params").ExplicitMPCParams(rand_seed=seed, target_type=scene.target)
    return SimpleNamespace(
        parameters=parameters,
        contact=importlib.import_module(f"contact.{name}_collision_detection").Contact(parameters),
        simulator=importlib.import_module(f"envs.{name}_env").MjSimulator(parameters),
        controller=importlib.import_module("planning.mpc_explicit").MPCExplicit(parameters),
    )


def run_peer(checkout: Path, key: str, seed: int) -> dict[str, Any]:
    """A case by its own loop: contacts, controller, simulator. It goes on after its own test until ours is passed as well, or its steps are used up."""
    scene = SCENES[key]
    test = constants(checkout, scene)
    with contextlib.redirect_stdout(io.StringIO()):
        peer = load_peer(checkout, scene, seed)
        p = peer.parameters
        period = float(peer.simulator.model_.opt.timestep * p.frame_skip_)
        out: dict[str, Any] = {"start": p.init_obj_qpos_.tolist(), "joints": p.init_robot_qpos_.tolist(), "goal": [*p.target_p_.tolist(), *p.target_q_.tolist()]}
        out |= {"model": p.model_path_, "period": period, "limit_s": test["most"] * period}
        judge, processor, steps = Judge(test, period), 0.0, 0
        while steps < test["most"] and None in (judge.theirs_s, judge.ours_s):
            q = peer.simulator.get_state()
            begin = time.process_time()
            phi, jacobian = peer.contact.detect_once(peer.simulator)
            found = peer.controller.plan_once(p.target_p_, p.target_q_, q, phi, jacobian, sol_guess=p.sol_guess_)
            processor += time.process_time() - begin
            p.sol_guess_ = found["sol_guess"]
            peer.simulator.step(found["action"])
            steps += 1
            q = peer.simulator.get_state()
            judge.look(steps * period, (math.dist(q[:3], p.target_p_), angle_between(q[3:7], p.target_q_)))
    return out | judge.said() | {"simulated_s": steps * period, "processor_s": processor}


def ask_peer(python: Path, checkout: Path, key: str, seed: int) -> dict[str, Any]:
    done = subprocess.run([python, __file__, str(checkout), "--one", key, str(seed)], capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise SystemExit(f"{PROGRAM}: {key}, seed {seed}: {done.stderr.strip()[-600:]}")
    return json.loads(done.stdout.splitlines()[-1])


# ---- stiction


def run_ours(checkout: Path, key: str, seed: int, case: dict[str, Any]) -> dict[str, Any]:
    """`stiction run` from the same start to the same goal, with as much time by the clock of the plant."""
    import stiction as st

    scene = SCENES[key]
    object_start, goal = case["start"], case["goal"]
    task = st.Task(
        {
            "name": key,
            "scene": {"file": str(checkout / case["model"])} | ({"robot": {"stiffness": scene.stiffness}} if scene.stiffness else {}),
            "start": {"objects": {"obj": {"position": object_start[:3], "quaternion_wxyz": object_start[3:]}}, "joints": case["joints"]},
            "goal": {"objects": {"obj": {"position": goal[:3], "quaternion_wxyz": goal[3:]}}},
            "tolerance": {"position": POSITION, "angle": ANGLE},
        }
    )
    budget = time.process_time() + case["limit_s"] + 10
    ran = st.run(
        task, seed=seed, threads=1, duration=case["limit_s"], timeout_s=900, plan_timeout_s=300, plan_processor_s=15.0, on_progress=lambda _: time.process_time() < budget
    )
    judge = Judge(constants(checkout, scene), case["period"])
    errors = [tuple(error) for error in task.goal_errors(ran.q)]
    for when, error in zip(ran.times, errors):
        judge.look(float(when), error)
    if ran.reached:
        judge.rest(ran.duration_s, errors[-1])
    spent = {"simulated_s": ran.duration_s, "processor_s": sum(plan.processor_s for plan in ran.plans)}
    return judge.said() | spent | {"end": ran.end.name, "message": ran.message}


# ---- the table


def summarise(scene: Scene, program: str, cases: list[dict[str, Any]]) -> dict[str, Any]:
    times = [case["ours_s"] for case in cases if case["ours_s"] is not None]
    return {
        "scene": scene.title,
        "program": program,
        "n": len(cases),
        "theirs": sum(case["theirs_s"] is not None for case in cases),
        "ours": sum(case["ours_s"] is not None for case in cases),
        "held": None if program == PROGRAM else sum(case["end"] == "Reached" for case in cases),
        "median_s": round(statistics.median(times), 2) if times else None,
        "processor_per_s": round(sum(case["processor_s"] for case in cases) / sum(case["simulated_s"] for case in cases), 3),
    }


def packages_of(python: Path) -> str:
    code = "import mujoco, casadi, numpy; print(f'mujoco {mujoco.__version__}, casadi {casadi.__version__}, numpy {numpy.__version__}')"
    return subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def tests_in_words(checkout: Path) -> list[str]:
    out = []
    for scene in SCENES.values():
        test = constants(checkout, scene)
        angle = math.degrees(2 * math.asin(math.sqrt(test["quaternion"])))
        position = f" and {1000 * test['position']:.0f} mm" if math.isfinite(test["position"]) else ", wherever the object is"
        out.append(f"{scene.title}: its test asks for {angle:.0f}°{position}, over {test['in_a_row']:.0f} steps of its controller in a row.")
    return out


def describe(checkout: Path, python: Path, cases: int, commit: str) -> dict[str, Any]:
    return {
        "command": f"experiments/peer_comfree.py CHECKOUT --peer-python VENV/bin/python --cases {cases}",
        "about": [
            f"{PROGRAM} (W. Jin, [arXiv:2408.07855](https://arxiv.org/abs/2408.07855)) is a controller that looks a few steps ahead and plans anew at every step. "
            f"The table runs its published code (repository asu-iris/Complementarity-Free-Dexterous-Manipulation, commit {commit}) on its own scenes. "
            "The repository states no licence, and nothing of it is in this one. `stiction run` gets the same files, starts and goals. This command makes the table:"
        ],
        "notes": ["A run holds its object when it ends with the object at rest at the goal. The median time is that until an object is within 5° and 10 mm, by the clock of the simulation. The last column is processor time of planning per second of that clock."],
        "differs": [
            *tests_in_words(checkout),
            f"{PROGRAM} runs in its own simulator ({packages_of(python)}), which stands still while it computes. With `stiction run` the clock goes on while the planner works.",
            "Both tests may pass at any time of the motion. 5° and 10 mm count as soon as an object is there for one step. A run of `stiction run` that ends with its object at rest at the goal passes the other test as well.",
            "Both have the same limit by the clock of the simulation, which is that of its scripts. Neither was tuned here: its parameters are those of its scripts, ours the defaults.",
            "The files of the fingertips and of the TriFinger have motors. `stiction run` takes the stiffness of the position controller that its simulator adds.",
        ],
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path)
    parser.add_argument("--peer-python", type=Path, default=Path(sys.executable))
    parser.add_argument("--cases", type=int, default=5)
    parser.add_argument("--scenes", nargs="*", choices=SCENES, default=list(SCENES))
    parser.add_argument("--commit", default="87b320f", help="of the checkout (default: %(default)s)")
    parser.add_argument("-o", "--out", type=Path, default=FILE)
    parser.add_argument("--one", nargs=2, metavar=("SCENE", "SEED"), help=argparse.SUPPRESS)
    parsed = parser.parse_args()
    checkout = parsed.checkout.resolve()
    if parsed.one:
        print(json.dumps(run_peer(checkout, parsed.one[0], int(parsed.one[1]))))
        return 0
    sys.path.insert(0, str(ROOT / "build/release/python"))
    rows, everything = [], []
    for key in parsed.scenes:
        theirs, ours = [], []
        for seed in range(parsed.cases):
            theirs.append(ask_peer(parsed.peer_python.absolute(), checkout, key, seed))
            ours.append(run_ours(checkout, key, seed, theirs[-1]))
            print(key, seed, *(f"{name}: theirs {c['theirs_s']}, ours {c['ours_s']} of {c['simulated_s']:.1f} s, {c['processor_s']:.1f} processor s, {c.get('end', '')} {c.get('message', '')} best {c['best']}" for name, c in (("peer", theirs[-1]), ("stiction", ours[-1]))), sep="\n  ", flush=True)  # fmt: skip
        rows += [summarise(SCENES[key], PROGRAM, theirs), summarise(SCENES[key], "`stiction run`", ours)]
        everything.append({"scene": key, "theirs": theirs, "ours": ours})
    page = describe(checkout, parsed.peer_python.absolute(), parsed.cases, parsed.commit) | {"rows": rows}
    parsed.out.write_text(json.dumps(page, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
