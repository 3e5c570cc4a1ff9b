#!/usr/bin/env python3
"""How often `stiction repair` makes a plan of a demonstration that breaks the laws of contact, and at which price.

    .venv/bin/python bench/demonstrations.py [--budget 15] [--only TASK] [--damage NAME] > demonstrations.json

Demonstrations are plans of built-in tasks, short ones and long ones, that are spoiled afterwards in one of several ways: by the errors of a camera, by another frame rate, by gaps, by another tempo, by an object that
is larger than the one that was shown, by a hand whose links are longer. Commands are taken away, so that nothing tells how hard the fingers pressed. Of each: whether the plan ends within the tolerances of the task and
`check` accepts it, how far the object is from where it was shown, how far joints had to move, and processor time. One JSON object on stdout, a line for each demonstration and tables on stderr.
"""

import argparse
import dataclasses
import json
import re
import statistics
import sys
import time

import numpy as np
import yaml
from by_task import stiction as st
from runs import ROOT
from stiction.demonstrations import Demonstration
from stiction.exports import make_motion

FRAMES = 30.0  # a second, of a camera
SPEED = 1.0  # of what is shown, times the full speed


@dataclasses.dataclass(frozen=True)
class Source:
    """A plan that is shown: the first `segments` of it, all if None."""

    task: str
    seed: int
    goal: tuple[float, ...] | None = None
    segments: int | None = None

    @property
    def name(self):
        return self.task + ("" if self.goal is None else " to " + " ".join(f"{x:g}" for x in self.goal)) + ("" if self.segments is None else f", {self.segments} segments")


SOURCES = (
    Source("planar_pushing", 0),
    Source("planar_pushing", 1),
    Source("planar_hand", 0, (0.0, 0.35, 0.6)),
    Source("planar_hand", 1, (0.0, 0.35, 1.5)),
    Source("planar_hand", 3),
    Source("iiwa_bimanual_planar", 0, segments=4),
    Source("iiwa_bimanual_planar", 1),
    Source("allegro_ball", 0, segments=10),
    Source("allegro_ball", 1),
    Source("ur5_mesh_push", 0),
)


def errors(random, n, columns, size):
    """Slow errors: a dozen independent ones over the demonstration, straight between them."""
    knots = np.linspace(0, n - 1, 12)
    return np.column_stack([np.interp(np.arange(n), knots, random.normal(0, size, 12)) for _ in range(columns)])


def resample(shown, times):
    """The demonstration at other times."""
    joints = np.column_stack([np.interp(times, shown.time, column) for column in shown.joints.T])
    poses = np.column_stack([np.interp(times, shown.time, column) for column in shown.poses.reshape(len(shown.poses), -1).T]).reshape(len(times), *shown.poses.shape[1:])
    poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)
    return Demonstration(times, joints, None, poses)


def at_camera_rate(shown):
    return resample(shown, np.append(np.arange(0, shown.time[-1] - 0.5 / FRAMES, 1 / FRAMES), shown.time[-1]))


def moved(shown, task, joints, positions):
    """With errors of joints and of positions; a planar object stays in its plane, as the tracker of whoever shows it knows."""
    poses = shown.poses.copy()
    axis = task.model.planar_axis
    for i in range(3):
        if i != axis:
            poses[:, task.goal.object, i] += positions[:, i]
    return dataclasses.replace(shown, joints=np.clip(shown.joints + joints, task.model.lower, task.model.upper), poses=poses)


def noise(shown, task, random):
    """Slow errors of 3 mm and 0.01 rad."""
    shown = at_camera_rate(shown)
    n = len(shown.time)
    return moved(shown, task, errors(random, n, shown.joints.shape[1], 0.01), errors(random, n, 3, 0.003)), task


def jitter(shown, task, random):
    """Errors of 1 mm and 0.005 rad, of each frame anew."""
    shown = at_camera_rate(shown)
    n = len(shown.time)
    return moved(shown, task, random.normal(0, 0.005, shown.joints.shape), random.normal(0, 0.001, (n, 3))), task


def gaps(shown, task, random):
    """A third of all frames is lost, in pieces of a third of a second, with slow errors."""
    shown, task = noise(shown, task, random)
    length = max(1, round(FRAMES / 3))
    kept = np.ones(len(shown.time), dtype=bool)
    for begin in range(length, len(kept) - length, 3 * length):
        kept[begin : begin + length] = False
    return resample(shown, shown.time[kept]), task


def tempo(shown, task, random):
    """Now half as fast and now twice as fast, and few frames."""
    times = np.arange(0, shown.time[-1], 1 / FRAMES)
    pace = np.exp(errors(random, len(times), 1, 0.5)[:, 0])
    warped = np.concatenate([[0], np.cumsum(pace[1:] / FRAMES)])
    return dataclasses.replace(resample(shown, times), time=warped), task


def larger(shown, task, random):
    """The object is 5 % larger than the one that was shown: the fingers stand in it."""
    document = document_of(task)
    for entry in document["scene"]["objects"]:
        for shape in entry["shapes"]:
            grow(shape, 1.05)
    return at_camera_rate(shown), remade(document)


def retargeted(shown, task, random):
    """The links of the robot are 5 % longer than those that were shown."""
    document = document_of(task)
    for entry in document["scene"]["robots"]:
        entry["urdf"] = lengthen(task.model.scene.robot_urdfs[entry["name"]], 1.05)
    return at_camera_rate(shown), remade(document)


DAMAGES = {change.__name__: change for change in (noise, jitter, gaps, tempo, larger, retargeted)}


def document_of(task):
    """The YAML of a built-in task, with what its bases say; paths are absolute."""
    def read(name):
        document = yaml.safe_load((ROOT / "tasks" / f"{name}.yaml").read_text(encoding="utf-8"))
        base = document.pop("base", None)
        return document if base is None else merged(read(base.removesuffix(".yaml")), document)

    document = read(task.name)
    for entry in document["scene"]["robots"]:
        if entry["urdf"].startswith(".."):
            entry["urdf"] = str((ROOT / "tasks" / entry["urdf"]).resolve())
    return document


def merged(below, above):
    return {key: merged(below[key], above[key]) if key in above and isinstance(below.get(key), dict) and isinstance(above[key], dict) else above.get(key, below.get(key)) for key in {**below, **above}}


def remade(document):
    """The task of a changed document. Its goal does not count: a repair goes where the demonstration ends."""
    return st.Task(document, base=ROOT / "tasks")


def grow(shape, factor):
    """Lengths of a shape, in place."""
    for parameters in shape.values():
        if isinstance(parameters, dict):
            for key, value in parameters.items():
                if key in ("radius", "length", "size", "half_length", "scale"):
                    parameters[key] = [factor * x for x in value] if isinstance(value, list) else factor * value


def lengthen(urdf, factor):
    """Every offset between a joint and the link before it, and the offsets of shapes."""
    return re.sub(r'(<origin[^>]*xyz=")([^"]+)"', lambda m: m[1] + " ".join(repr(factor * float(x)) for x in m[2].split()) + '"', urdf)


def shown_of(source):
    """The task, and its plan as a demonstration without commands."""
    task = st.load_task(source.task)
    if source.goal is not None:
        task = task.with_(goal=list(source.goal))
    found = st.plan(task, seed=source.seed, threads=1, timeout_s=60)
    if found.status != st.Status.Solved:
        raise RuntimeError(f"{source.name}: no plan: {found.reason}")
    plan = found.plan if source.segments is None else found.plan[: source.segments]
    motion = make_motion(plan, st.make_trajectory(plan, speed=SPEED))
    return task, Demonstration(motion.time, motion.q, None, motion.poses)


def measure(source, damage, number, budget_s):
    task, shown = shown_of(source)
    spoiled, task = DAMAGES[damage](shown, task, np.random.default_rng(number))
    begin = time.process_time()
    end = begin + budget_s
    done = st.repair(task, spoiled, threads=1, timeout_s=20 * budget_s, on_progress=lambda share: time.process_time() < end)
    goal = task.goal
    return {
        "source": source.name, "damage": damage, "duration_s": float(spoiled.time[-1]), "frames": len(spoiled.time), "knots": len(done.plan.q) - 1,
        "held": done.holds, "complete": done.complete, "accepted": done.accepted, "share": float(done.times[-1] / spoiled.time[-1]),
        "end_position": float(done.position_error[-1]), "end_angle": float(done.angle_error[-1]), "tolerance": [goal.tol_position, goal.tol_angle],
        "worst_position": float(done.position_error.max()), "worst_angle": float(done.angle_error.max()), "joint_change": float(done.joint_change.max()),
        "processor_s": time.process_time() - begin,
    }  # fmt: skip


def describe(row):
    verdict = "held" if row["held"] else "not accepted" if row["complete"] else f"ends at {100 * row['share']:.0f} %"
    return (
        f"{row['source']}, {row['damage']}: {verdict}; {1e3 * row['end_position']:.1f} mm and {row['end_angle']:.3f} rad at the end, joints {row['joint_change']:.2f}, "
        f"{row['knots']} knots, {row['processor_s']:.1f} s"
    )


def table(rows, key):
    lines = [f"| {key} | demonstrations | plan at its end, accepted | followed to the end | off at the end, median | joints change, median | processor time, median |", "|---|---|---|---|---|---|---|"]
    for name in dict.fromkeys(row[key] for row in rows):
        mine = [row for row in rows if row[key] == name]
        middle = {field: statistics.median(row[field] for row in mine) for field in ("end_position", "end_angle", "joint_change", "processor_s")}
        lines.append(
            f"| {name} | {len(mine)} | {sum(row['held'] for row in mine)} | {sum(row['complete'] for row in mine)} | {1e3 * middle['end_position']:.1f} mm, {middle['end_angle']:.3f} rad | "
            f"{middle['joint_change']:.2f} | {middle['processor_s']:.1f} s |"
        )
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--budget", type=float, default=15.0, help="processor time of a repair [s] (default: %(default)g)")
    parser.add_argument("--only", action="append", metavar="TASK")
    parser.add_argument("--damage", action="append", choices=list(DAMAGES))
    arguments = parser.parse_args()
    rows = []
    for k, source in enumerate(SOURCES):
        for i, damage in enumerate(DAMAGES):
            # Four ways for each plan, so that each way comes as often on short and on long ones.
            if (i + k) % 3 == 2 or (arguments.only and source.task not in arguments.only) or (arguments.damage and damage not in arguments.damage):
                continue
            row = measure(source, damage, len(DAMAGES) * k + i, arguments.budget)
            print(describe(row), file=sys.stderr, flush=True)
            rows.append(row)
    for key in ("source", "damage"):
        print(table(rows, key), file=sys.stderr)
    print(f"{sum(row['held'] for row in rows)} of {len(rows)}", file=sys.stderr)
    print(json.dumps({"budget_s": arguments.budget, "rows": rows}))


if __name__ == "__main__":
    main()
