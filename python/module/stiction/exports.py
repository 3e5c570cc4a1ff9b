"""Plans over time for other programs: CSV, NumPy, JSON, MCAP and LeRobot (docs/exports.md)."""

from __future__ import annotations

import csv
import json
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import _command
from ._core import OPEN_LOOP_SPEED, InvalidInput, Plan, PlanContact, Status, Trajectory, make_trajectory, read_plan, version
from ._files import write_whole

FORMAT = "stiction-motion"
FORMAT_VERSION = 1
POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
CONTACT = ("point", "normal", "force")  # with a component per axis


@dataclass(frozen=True)
class Motion:
    """A plan as time series. The first axis of each array is time."""

    plan: Plan
    time: np.ndarray  # (knots) [s]
    kinds: list[str]  # (knots) of the segment that led there: settle, contact, regrasp
    joints: list[str]
    q_all: np.ndarray  # (knots, n_q) predicted configurations
    q: np.ndarray  # (knots, joints) predicted [m or rad]
    q_cmd: np.ndarray  # commands [m or rad]
    velocity: np.ndarray  # of q on the way to the knot [m/s or rad/s]
    torque: np.ndarray  # K (q_cmd - q) [N or N m]
    objects: list[str]
    poses: np.ndarray  # (knots, objects, 7): x y z [m] qx qy qz qw of X_WB
    contacts: list[list[PlanContact]]  # (knots) of the sub-step that led there
    speed: float  # times the full speed

    def about(self) -> dict[str, Any]:
        """Returns the origin of the motion: task, scene, status, seed, speed and version of the code."""
        plan = self.plan
        return {
            "code_version": version(),
            "task": plan.task.name,
            "scene_sha256": plan.task.scene_sha256,
            "status": plan.status.name,
            "seed": plan.seed,
            "speed": self.speed,
        }


def make_motion(plan: Plan, trajectory: Trajectory | None = None) -> Motion:
    """Returns the motion of a plan at the knots of a trajectory; None: a trajectory at the default speed. Raises InvalidInput: a trajectory of another plan."""
    trajectory = make_trajectory(plan) if trajectory is None else trajectory
    model, t, q_all = plan.task.model, np.asarray(trajectory.times), np.asarray(trajectory.q)
    knots = np.asarray(trajectory.knots)
    if q_all.shape[1] != model.n_q or knots.max() >= len(plan.q):
        raise InvalidInput(f"trajectory: got {q_all.shape[1]} coordinates and knot {knots.max()}, expected {model.n_q} and at most {len(plan.q) - 1}")
    q, q_cmd = q_all[:, -model.n_a :], np.asarray(trajectory.u)
    velocity = np.vstack([np.zeros(model.n_a), np.diff(q, axis=0) / np.diff(t)[:, None]])
    contacts = plan.contacts
    return Motion(
        plan=plan,
        time=t,
        kinds=[plan.segments[segment].kind.name.lower() for segment in trajectory.segments],
        joints=model.joint_names,
        q_all=q_all,
        q=q,
        q_cmd=q_cmd,
        velocity=velocity,
        torque=np.asarray(model.stiffness) * (q_cmd - q),
        objects=model.object_names,
        poses=poses_of_objects(model, q_all),
        contacts=[contacts[knot] for knot in knots],
        speed=trajectory.speed,
    )


def poses_of_objects(model: Any, q: np.ndarray) -> np.ndarray:
    """Returns the poses of the objects (knots, objects, 7). Quaternions do not change their sign from one knot to the next."""
    out = np.empty((len(q), len(model.object_names), len(POSE)))
    for k, state in enumerate(q):
        for i, name in enumerate(model.object_names):
            pose = model.object_pose(state, name)
            out[k, i, :3] = pose.p
            out[k, i, 3:] = np.roll(pose.quaternion_wxyz, -1)
    for k in range(1, len(out)):
        flipped = np.sum(out[k, :, 3:] * out[k - 1, :, 3:], axis=1) < 0
        out[k, flipped, 3:] *= -1
    return out


def write_csv(motion: Motion, file: Path) -> list[Path]:
    """Writes one row per knot to `file`, and one row per contact of a knot to the file with `.contacts` before its suffix."""
    series = {"q": motion.q, "q_cmd": motion.q_cmd, "velocity": motion.velocity, "torque": motion.torque}
    head = ["time_s", "segment", *(f"{name}_{joint}" for name in series for joint in motion.joints), *(f"{name}_{axis}" for name in motion.objects for axis in POSE)]
    table = np.hstack([*series.values(), motion.poses.reshape(len(motion.time), -1)])
    rows = ([t, kind, *row] for t, kind, row in zip(motion.time.tolist(), motion.kinds, table.tolist()))
    contact_head = ["time_s", "a", "b", *(f"{name}_{axis}" for name in CONTACT for axis in "xyz"), "friction", "gap"]
    contact_rows = (
        [t, c.a, c.b, *(x for name in CONTACT for x in getattr(c, name).tolist()), c.friction, c.gap]
        for t, contacts in zip(motion.time.tolist(), motion.contacts)
        for c in contacts
    )
    beside = file.with_name(f"{file.stem}.contacts{file.suffix}")
    return [write_table(file, head, rows), write_table(beside, contact_head, contact_rows)]


def write_table(file: Path, head: Sequence[str], rows: Any) -> Path:
    def write(to: Path) -> None:
        with to.open("w", encoding="utf-8", newline="") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(head)
            writer.writerows(rows)

    return write_whole(file, write)


def write_npz(motion: Motion, file: Path) -> list[Path]:
    """Writes the arrays to an .npz file without pickles: np.load(file)["q"]."""
    flat = [(k, c) for k, contacts in enumerate(motion.contacts) for c in contacts]
    arrays = {name: getattr(motion, name) for name in ("time", "q", "q_cmd", "velocity", "torque", "poses")}
    arrays |= {name: np.array(getattr(motion, name), dtype=str) for name in ("kinds", "joints", "objects")}
    arrays |= {f"contact_{name}": np.array([getattr(c, name) for _, c in flat], dtype=str) for name in "ab"}
    arrays |= {f"contact_{name}": np.array([getattr(c, name) for _, c in flat]).reshape(-1, 3) for name in CONTACT}
    arrays |= {f"contact_{name}": np.array([getattr(c, name) for _, c in flat], dtype=float) for name in ("friction", "gap")}
    arrays |= {"contact_knot": np.array([k for k, _ in flat], dtype=int)}
    arrays |= {name: np.array(value) for name, value in motion.about().items()}

    def save(to: Path) -> None:
        with to.open("wb") as out:  # given a name it would add to it
            np.savez_compressed(out, **arrays)

    return [write_whole(file, save)]


def write_json(motion: Motion, file: Path) -> list[Path]:
    """Writes one JSON object with the fields of docs/exports.md."""
    knots = [
        {
            "time": t,
            "segment": kind,
            **{name: getattr(motion, name)[k].tolist() for name in ("q", "q_cmd", "velocity", "torque")},
            "objects": [{"position": pose[:3], "quaternion_xyzw": pose[3:]} for pose in motion.poses[k].tolist()],
            "contacts": [
                {"a": c.a, "b": c.b, **{name: getattr(c, name).tolist() for name in CONTACT}, "friction": c.friction, "gap": c.gap} for c in motion.contacts[k]
            ],
        }
        for k, (t, kind) in enumerate(zip(motion.time.tolist(), motion.kinds))
    ]
    head = {"format": FORMAT, "format_version": FORMAT_VERSION, **motion.about(), "joints": motion.joints, "objects": motion.objects}
    text = json.dumps(head, ensure_ascii=False)[:-1] + ',"knots":[\n' + ",\n".join(json.dumps(knot, allow_nan=False) for knot in knots) + "\n]}\n"
    return [write_whole(file, lambda to: to.write_text(text, encoding="utf-8"))]


def write_mcap(motion: Motion, file: Path) -> list[Path]:
    from . import _mcap

    return [write_whole(file, lambda to: _mcap.write(motion, to))]


def write_lerobot(motion: Motion, folder: Path) -> list[Path]:
    from . import lerobot

    return [lerobot.write_lerobot([motion], folder)]


WRITERS: dict[str, Callable[[Motion, Path], list[Path]]] = {"csv": write_csv, "npz": write_npz, "json": write_json, "mcap": write_mcap, "lerobot": write_lerobot}


def format_of(file: Path, given: str | None) -> str:
    """Returns the format for a file. Raises InvalidInput: unknown format."""
    found = file.suffix[1:] if given is None else given
    if found not in WRITERS:
        field = "format" if given is not None else f"{file}: format"
        raise InvalidInput(f"{field}: got '{found}', expected one of {', '.join(sorted(WRITERS))}")
    return found


def describe_miss(plan: Plan) -> str | None:
    """Returns a sentence on a plan that does not reach its goal. None: the plan reaches its goal."""
    if plan.status == Status.Solved:
        return None
    error, goal = plan.error, plan.task.goal
    return (
        f"the plan does not reach its goal (status {plan.status.name}): it ends {1e3 * error.position:.2f} mm and {error.angle:.4f} rad away, "
        f"the tolerances are {1e3 * goal.tol_position:.2f} mm and {goal.tol_angle:.4f} rad; a longer search may reach it (`stiction plan --timeout`)"
    )


def write(plan: Plan, file: str | os.PathLike[str], *, format: str | None = None, trajectory: Trajectory | None = None) -> list[Path]:
    """Writes a plan for other programs, as Plan.export() does."""
    if miss := describe_miss(plan):
        warnings.warn(miss, stacklevel=2)
    return write_motion(plan, Path(file), format_of(Path(file), format), trajectory)


def write_motion(plan: Plan, file: Path, format: str, trajectory: Trajectory | None) -> list[Path]:
    return WRITERS[format](make_motion(plan, trajectory), file)


def make_parser() -> _command.Parser:
    parser = _command.make_parser("export", "Writes plans over time for other programs: joints, commands, velocities, torques, poses of objects, contacts.")
    parser.add_argument("plans", type=Path, nargs="+", metavar="PLAN", help="plan file, or its folder; several become the episodes of a data set (lerobot)")
    parser.add_argument("--format", metavar="FORMAT", help=f"one of {', '.join(sorted(WRITERS))} (default: the suffix of FILE)")
    parser.add_argument("-o", "--out", type=Path, metavar="FILE", help="a new folder for lerobot (default: motion.FORMAT in the folder of the plan)")
    parser.add_argument(
        "--speed",
        type=_command.positive,
        default=OPEN_LOOP_SPEED,
        help="factor on the full speed that follows from the object and the motors; above 1 only pushes are faster. Without feedback most plans succeed at 0.1, and few at 1 "
        "(default: %(default)s)",
    )
    parser.add_argument("--pause", type=_command.nonnegative, default=0.0, help="time of constant commands between pushes and regrasps [s] (default: %(default)s)")
    parser.add_argument("--fps", type=_command.integer(1, 1000), metavar="N", help="frames per second of lerobot (default: 30)")
    return parser


def main(words: Sequence[str]) -> int:
    """`stiction export`"""
    parser = make_parser()
    arguments = parser.parse_args(words)
    if arguments.format is None and arguments.out is None:
        parser.error("format: got none, expected --format, or -o with a file whose name ends in it")
    given = arguments.plans[0]
    folder = given if given.is_dir() else given.parent
    file = arguments.out or folder / f"motion.{arguments.format}"
    format = format_of(file, arguments.format)
    if format != "lerobot" and (len(arguments.plans) > 1 or arguments.fps is not None):
        parser.error(f"format: got {format} with several plans or --fps, expected lerobot, a data set of episodes at equal times")
    plans = [read_plan(plan) for plan in arguments.plans]
    motions = [make_motion(plan, make_trajectory(plan, speed=arguments.speed, pause=arguments.pause)) for plan in plans]
    files = _write_all(motions, file, format, arguments.fps)
    missed = False
    for name, plan in zip(arguments.plans, plans):
        if miss := describe_miss(plan):
            missed = True
            _command.say(f"stiction: warning: {name}: {miss}", sys.stderr)
    knots, duration = sum(len(motion.time) for motion in motions), sum(float(motion.time[-1]) for motion in motions)
    plan = plans[0]
    rows = {"motion": f"{knots} knots, {duration:.1f} s at {motions[0].speed:g} of the full speed"} | {"file" if i == 0 else "and": str(path) for i, path in enumerate(files)}
    status = plan.status.name if len(plans) == 1 else "Solved" if not missed else "NotSolved"
    result: dict[str, object] = {"status": "NotSolved" if missed else "Done", "plan_status": status, "task": plan.task.name, "seed": plan.seed, "format": format}
    result |= {"speed": motions[0].speed, "knots": knots, "duration_s": duration, "files": [str(path) for path in files]}
    title = f"{plan.task.name}, seed {plan.seed}: exported" if len(plans) == 1 else f"{len(plans)} plans exported"
    _command.report(arguments, title, rows, result)
    return _command.NOT_SOLVED if missed else _command.DONE


def _write_all(motions: list[Motion], file: Path, format: str, fps: int | None) -> list[Path]:
    if format != "lerobot":
        return WRITERS[format](motions[0], file)
    from . import lerobot

    return [lerobot.write_lerobot(motions, file, fps=fps or lerobot.FPS)]
