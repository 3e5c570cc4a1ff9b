#!/usr/bin/env python3
"""Goals in a row within 50 s: a cube in the LEAP hand by the policy of MuJoCo Playground and by `stiction run`, and one in the Allegro hand.

    experiments/goals_in_row.py CHECKOUT --peer-python VENV/bin/python

CHECKOUT is a copy of google-deepmind/mujoco_playground (Apache-2.0), VENV an environment with mujoco, onnxruntime and numpy. Starts and goals follow the rule of
its LeapCubeReorient: joints and cube are drawn around its keyframe, the cube with any orientation, and when the cube is within 0.1 rad of its goal the next one is
turned by 0.5 to 2.5 rad about each axis of the cube from the one before. A cube that falls by 0.05 m below the hand ends the run. Both programs get the same starts and
goals and the same simulation, that of its scene, in which `stiction run` is a program that commands joints. Takes about twenty processor minutes.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "python/module/stiction/benchmark_rows.json"
PROGRAM = "policy of MuJoCo Playground"
DURATION = 50.0  # of a run by the clock of the simulation [s]
ANGLE = 0.1  # its success test [rad]
PLACE = np.array([0.1, 0.0, 0.05])  # of the cube, around which it starts [m]
LOWEST = -0.05  # a cube below this has been dropped [m]
GOALS = 200  # more than anyone reaches
SCENE = "mujoco_playground/_src/manipulation/leap_hand/xmls/scene_mjx_cube.xml"
POLICY = "mujoco_playground/experimental/sim2sim/onnx/leap_reorient_policy.onnx"


# ---- rotations, as quaternions w x y z


def times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w, v, x, u = a[0], a[1:], b[0], b[1:]
    return np.array([w * x - v @ u, *(w * u + x * v + np.cross(v, u))])


def turn_by(vector: np.ndarray) -> np.ndarray:
    angle = float(np.linalg.norm(vector))
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * vector / max(angle, 1e-300))])


def angle_between(a: np.ndarray, b: np.ndarray) -> float:
    """Of two unit quaternions [rad]."""
    return 2 * math.acos(min(1.0, abs(float(np.dot(a, b)))))


def draw_quaternion(rng: np.random.Generator) -> np.ndarray:
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def draw_goals(rng: np.random.Generator) -> list[list[float]]:
    """The first one is any orientation. The goal of its environment turns at 1 to 5 rad/s about each axis, twice a control step of 0.05 s, by 0.8 of that in the next
    step and so on: by 0.5 of it in all."""
    out = [draw_quaternion(rng)]
    while len(out) < GOALS:
        q = times(out[-1], turn_by(0.5 * rng.uniform(1, 5, 3)))
        out.append(q / np.linalg.norm(q))
    return [q.tolist() for q in out]


class Judge:
    """Which goals are reached, by the orientation alone; the next one counts from then on."""

    def __init__(self, goals: list[list[float]]) -> None:
        self.goals, self.reached, self.dropped_s = np.array(goals), [], None

    @property
    def goal(self) -> np.ndarray:
        return self.goals[len(self.reached)]

    def look(self, when: float, position: np.ndarray, quaternion: np.ndarray) -> bool:
        """Whether it goes on."""
        if angle_between(quaternion, self.goal) < ANGLE:
            self.reached.append(when)
        if position[2] < LOWEST:
            self.dropped_s = when
        return self.dropped_s is None


# ---- its simulation


def load_model(checkout: Path, timestep: float) -> Any:
    """Its scene without the meshes that are to be seen only, some of which are not in its repository."""
    import mujoco

    os.chdir(checkout)
    spec = mujoco.MjSpec.from_file(SCENE)
    for geom in [geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_MESH]:
        spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    model = spec.compile()
    model.opt.timestep = timestep
    return model


def draw_start(model: Any, rng: np.random.Generator) -> np.ndarray:
    """q: 16 joints, then the position and the quaternion of the cube."""
    lower, upper = model.actuator_ctrlrange.T
    joints = np.clip(model.key("home").qpos[:16] + 0.1 * rng.normal(size=16), lower, upper)
    return np.array([*joints, *(PLACE + rng.uniform(-0.01, 0.01, 3)), *draw_quaternion(rng)])


class World:
    """Its simulation, one tick of which is a step of it."""

    def __init__(self, checkout: Path, seed: int, timestep: float) -> None:
        import mujoco

        rng = np.random.default_rng(seed)
        self.step, self.model = mujoco.mj_step, load_model(checkout, timestep)
        self.data = mujoco.MjData(self.model)
        self.start = draw_start(self.model, rng)
        self.judge = Judge(draw_goals(rng))
        self.data.qpos[:], self.data.ctrl[:] = self.start, self.start[:16]
        mujoco.mj_forward(self.model, self.data)

    @property
    def joints(self) -> np.ndarray:
        return self.data.qpos[:16]

    @property
    def cube(self) -> tuple[np.ndarray, np.ndarray]:
        return self.data.qpos[16:19], self.data.qpos[19:]

    def look(self) -> bool:
        return self.judge.look(self.data.time, *self.cube)


def said(world: World, processor_s: float, **more: Any) -> dict[str, Any]:
    return {"reached": world.judge.reached, "dropped_s": world.judge.dropped_s, "simulated_s": world.data.time, "processor_s": processor_s} | more


# ---- its policy, in its own environment


def run_policy(checkout: Path, seed: int, timestep: float, noise: bool) -> dict[str, Any]:
    """As its play_leap_reorient.py: every 0.05 s it sees joints, their commands, cube and goal, and moves the commands. @param noise  as in its environment"""
    import onnxruntime

    rng = np.random.default_rng([seed, 1])
    level = 1.0 if noise else 0.0

    world = World(checkout, seed, timestep)
    session = onnxruntime.InferenceSession(POLICY, providers=["CPUExecutionProvider"])
    data, judge = world.data, world.judge
    lower, upper = world.model.actuator_ctrlrange.T
    action, processor = np.zeros(16, dtype=np.float32), 0.0
    steps = round(0.05 / timestep)
    while data.time < DURATION - 1e-9:
        joints = world.joints + level * rng.uniform(-0.05, 0.05, 16)
        cube = world.cube[1] + level * 0.1 * rng.normal(size=4)
        w, x, y, z = times(cube / np.linalg.norm(cube), judge.goal * [1, -1, -1, -1])
        rows = [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
        palm = data.sensor("palm_position").data - data.sensor("cube_position").data + level * rng.uniform(-0.02, 0.02, 3)
        seen = np.hstack([joints, joints - data.ctrl, palm, rows, action]).astype(np.float32)
        begin = time.process_time()
        action = session.run(["continuous_actions"], {"obs": seen.reshape(1, -1)})[0][0]
        processor += time.process_time() - begin
        data.ctrl[:] = np.clip(data.ctrl + 0.5 * action, lower, upper)
        for _ in range(steps):
            world.step(world.model, data)
        if not world.look():
            break
    return said(world, processor)


def ask_policy(python: Path, checkout: Path, seed: int, timestep: float, noise: bool) -> dict[str, Any]:
    words = ["--one", str(seed), "--timestep", str(timestep), *(["--noise"] if noise else [])]
    done = subprocess.run([python, str(Path(__file__).resolve()), str(checkout), *words], capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise SystemExit(f"{PROGRAM}: seed {seed}: {done.stderr.strip()[-600:]}")
    return json.loads(done.stdout.splitlines()[-1])


# ---- stiction


def roll_pitch_yaw(q: np.ndarray) -> list[float]:
    w, x, y, z = q
    return [
        math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))),
        math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    ]


def describe_goals(name: str, place: np.ndarray, room: float, goals: list[list[float]]) -> list[dict[str, Any]]:
    """Orientations, with the object as far beside its place as that, at any height."""
    bounds = [*([float(place[i] - room), float(place[i] + room)] for i in range(2)), None]
    return [{"objects": {name: {"position": bounds, "rpy": roll_pitch_yaw(np.array(goal))}}} for goal in goals]


class Plant:
    """Its simulation as what `stiction run` commands. Joints by their names; the cube first, its quaternion x y z w."""

    def __init__(self, st: Any, world: World, joint_names: list[str]) -> None:
        self.st, self.world, self.last_look = st, world, 0.0
        mine = [world.model.joint(int(world.model.actuator_trnid[k, 0])).name for k in range(world.model.nu)]
        self.order = [mine.index(name.split("/")[-1]) for name in joint_names]

    def read(self) -> Any:
        w = self.world
        q = np.concatenate([w.cube[0], np.roll(w.cube[1], -1), w.joints[self.order]])
        return self.st.Measurement(time=w.data.time, q=q, u=w.data.ctrl[self.order])

    def command(self, u: np.ndarray, period: float) -> bool:
        w = self.world
        ctrl, target = w.data.ctrl, np.empty(16)
        target[self.order] = u
        steps = max(1, round(period / w.model.opt.timestep))
        for k in range(steps):
            ctrl[:] += (target - ctrl) / (steps - k)
            w.step(w.model, w.data)
        if w.data.time - self.last_look >= 0.05 - 1e-9:
            self.last_look = w.data.time
            w.look()
        return True


def processor_of(ran: Any) -> float:
    return sum(plan.processor_s for plan in ran.plans)


def run_leap(checkout: Path, seed: int, timestep: float) -> dict[str, Any]:
    """`stiction run` in its simulation, with the clock going on while it plans."""
    import stiction as st

    world = World(checkout, seed, timestep)
    task = st.Task({
        "name": "leap_goals",
        "scene": {"file": str(checkout / SCENE)},
        "start": {"keyframe": "home"},
        "goal": {"objects": {"cube": {"position": PLACE.tolist()}}},
        "tolerance": {"position": 0.03, "angle": ANGLE},
    })  # fmt: skip
    plant = Plant(st, world, list(task.model.joint_names))
    goals = describe_goals("cube", PLACE, 0.03, world.judge.goals.tolist())
    ran = st.run(
        task, goals=goals, hold=0, plant=plant, seed=seed, threads=1, duration=DURATION, timeout_s=3600, plan_timeout_s=600, plan_processor_s=15.0,
        on_progress=lambda _: world.judge.dropped_s is None,
    )  # fmt: skip
    return said(world, processor_of(ran), **tell(ran))


def run_allegro(seed: int) -> dict[str, Any]:
    """A cube that lies in the Allegro hand: each goal is turned by 21° to 90° about any axis from the one before, as those of Sphere-100 from its start."""
    import stiction as st

    rng = np.random.default_rng(seed)
    task = st.load_task("allegro_cube")
    place, goals = task.q_start[:3], [np.array([1.0, 0, 0, 0])]
    for _ in range(GOALS):
        axis = rng.normal(size=3)
        goals.append(times(goals[-1], turn_by(math.radians(rng.uniform(21, 90)) * axis / np.linalg.norm(axis))))
    ran = st.run(
        task, goals=describe_goals("cube", place, 0.02, [g.tolist() for g in goals[1:]]), hold=0, seed=seed, threads=1, duration=DURATION, timeout_s=3600,
        plan_timeout_s=600, plan_processor_s=15.0,
    )  # fmt: skip
    dropped = ran.duration_s if ran.end == st.RunEnd.Dropped else None
    return {"reached": [g.end_s for g in ran.goals if g.reached], "dropped_s": dropped, "simulated_s": ran.duration_s, "processor_s": processor_of(ran)} | tell(ran)


def tell(ran: Any) -> dict[str, Any]:
    return {
        "end": ran.end.name,
        "message": ran.message,
        "plans": [[round(p.time, 2), round(p.clock_s, 2), p.status.name, p.joined, p.cause, p.reason] for p in ran.plans],
        "pieces": [[round(p.begin_s, 2), round(p.end_s, 2), p.kind.name, p.given_up] for p in ran.pieces],
    }


# ---- the table


def summarise(title: str, program: str, cases: list[dict[str, Any]]) -> dict[str, Any]:
    reached = [len(case["reached"]) for case in cases]
    ways = [later - earlier for case in cases for earlier, later in zip([0.0, *case["reached"]], case["reached"])]
    return {
        "scene": title,
        "program": program,
        "n": len(cases),
        "goals": sum(reached),
        "median": statistics.median(reached),
        "least": min(reached),
        "most": max(reached),
        "dropped": sum(case["dropped_s"] is not None for case in cases),
        "median_s": round(statistics.median(ways), 2) if ways else None,
        "simulated_s": round(sum(case["simulated_s"] for case in cases), 1),
        "processor_per_s": round(sum(case["processor_s"] for case in cases) / sum(case["simulated_s"] for case in cases), 3),
    }


def describe(cases: int, commit: str, timestep: float) -> dict[str, Any]:
    return {
        "command": f"experiments/goals_in_row.py CHECKOUT --peer-python VENV/bin/python --cases {cases}",
        "about": [
            "A goal is an orientation of a cube in a hand. As soon as the cube is within 0.1 rad of it the next one counts, until 50 s of the clock of the simulation are over or the cube falls. "
            f"In the LEAP hand, the published policy and `stiction run` get the goals, starts and simulation of LeapCubeReorient of MuJoCo Playground (commit {commit}). "
            "In the Allegro hand `stiction run` alone turns the cube of `allegro_cube` by 21° to 90° about any axis from one goal to the next."
        ],
        "notes": ["A way is that from one goal to the next. The last column is processor time of planning, or of the policy, per second of the clock."],
        "differs": [
            "The policy was trained on this scene with noise in what it sees. In the first line it sees joints and cube exactly, as in the script of its makers, and so does `stiction run`.",
            f"The simulation has steps of {1000 * timestep:g} ms, in place of 10 ms in training and 2 ms in that script. Goals come at once, where those of the environment turn there within half a second.",
            "`stiction run` has default settings apart from `hold`, which is 0, and the clock goes on while it plans. It also keeps the cube within 30 mm of its place in the hand (20 mm in the Allegro hand), which the count does not ask for.",
            "The Allegro hand is simulated by `stiction run`. A cube has fallen there when it is more than its length below all planned places.",
        ],
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path)
    parser.add_argument("--peer-python", type=Path, default=Path(sys.executable))
    parser.add_argument("--cases", type=int, default=10)
    parser.add_argument("--timestep", type=float, default=0.001, help="of its simulation [s] (default: %(default)s)")
    parser.add_argument("--commit", default="d5e6b47", help="of the checkout (default: %(default)s)")
    parser.add_argument("--log", type=Path, help="file for what each run did, from which the same command goes on")
    parser.add_argument("-o", "--out", type=Path, default=FILE)
    parser.add_argument("--one", type=int, metavar="SEED", help=argparse.SUPPRESS)
    parser.add_argument("--noise", action="store_true", help=argparse.SUPPRESS)
    parsed = parser.parse_args()
    checkout = parsed.checkout.resolve()
    if parsed.one is not None:
        print(json.dumps(run_policy(checkout, parsed.one, parsed.timestep, parsed.noise)))
        return 0
    sys.path.insert(0, str(ROOT / "build/release/python"))
    peer = parsed.peer_python.absolute()  # its scene is read from within the checkout
    out, log = parsed.out.resolve(), parsed.log and parsed.log.resolve()
    known = json.loads(log.read_text(encoding="utf-8")) if log and log.exists() else {}
    programs = {
        ("LEAP hand", PROGRAM): lambda seed: ask_policy(peer, checkout, seed, parsed.timestep, False),
        ("LEAP hand", f"{PROGRAM}, with its noise"): lambda seed: ask_policy(peer, checkout, seed, parsed.timestep, True),
        ("LEAP hand", "`stiction run`"): lambda seed: run_leap(checkout, seed, parsed.timestep),
        ("Allegro hand", "`stiction run`"): run_allegro,
    }
    rows = []
    for (title, program), run in programs.items():
        cases = []
        for seed in range(parsed.cases):
            key = f"{title}, {program}, {seed}"
            if key not in known:
                known[key] = run(seed)
                if log:
                    log.write_text(json.dumps(known), encoding="utf-8")
            case = known[key]
            cases.append(case)
            print(key, f"{len(case['reached'])} goals in {case['simulated_s']:.1f} s", f"dropped at {case['dropped_s']}", f"{case['processor_s']:.1f} processor s", case.get("message", ""), sep=": ", flush=True)
        rows.append(summarise(title, program, cases))
    page = describe(parsed.cases, parsed.commit, parsed.timestep) | {"rows": rows}
    out.write_text(json.dumps(page, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
