"""`stiction stream`"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from . import _command
from ._core import InvalidInput, Plan, RunResult, Task, load_task, read_plan, run
from ._rerun import DEFAULT as RERUN
from .exports import describe_miss
from .streams import FOXGLOVE_PORT, Stream, stream


def make_parser() -> argparse.ArgumentParser:
    parser = _command.make_parser("stream", "Shows a plan in Foxglove or rerun, repeated until Ctrl-C, or shows a run in closed loop live.")
    parser.add_argument("target", metavar="PLAN|TASK", help="plan file or its folder; with --run also the name or file of a task")
    parser.add_argument(
        "--foxglove", type=_command.integer(0, 65535), nargs="?", const=FOXGLOVE_PORT, metavar="PORT", help=f"port of the server for Foxglove, 0: any free port (default: {FOXGLOVE_PORT})"
    )
    parser.add_argument("--host", default="127.0.0.1", help="address of the server; everybody who can reach it can watch (default: %(default)s)")
    parser.add_argument("--rerun", nargs="?", const=RERUN, metavar="FILE|ADDRESS", help=f"file .rrd to write, or address of a running viewer (default: {RERUN})")
    parser.add_argument("--run", action="store_true", help="simulate a run in closed loop in MuJoCo, and show it")
    parser.add_argument("--now", action="store_true", help="begin before a viewer is connected")
    parser.add_argument("--once", action="store_true", help="play the plan once")
    parser.add_argument("--speed", type=_command.positive, default=1.0, help="factor on the full speed that follows from the object and the motors; above 1 only pushes are faster (default: %(default)s)")
    parser.add_argument("--pause", type=_command.nonnegative, default=0.0, help="for a plan, time of constant commands between pushes and regrasps [s] (default: %(default)s)")
    parser.add_argument("--seed", type=_command.integer(0, 2**64 - 1), metavar="N", help="seed of a run (default: the seed of the target)")
    parser.add_argument("--duration", type=_command.positive, default=600.0, metavar="S", help="largest length of a run by the clock of the plant [s] (default: %(default)s)")
    parser.add_argument("--threads", type=_command.integer(0, 4096), default=0, metavar="N", help="threads of the planner in a run (default: all cores)")
    return parser


def load(target: str, running: bool) -> Plan | Task:
    """Raises InvalidInput."""
    if target.endswith(".json") or Path(target).is_dir():
        return read_plan(Path(target))
    task = load_task(target)
    if not running:
        raise InvalidInput(f"PLAN: got the task '{target}', expected a plan (`stiction plan {target}`), or --run")
    return task


def main(words: Sequence[str]) -> int:
    a = make_parser().parse_args(words)
    shown = load(a.target, a.run)
    if a.foxglove is None and a.rerun is None:
        raise InvalidInput("--foxglove, --rerun: got neither, expected at least one")
    with stream(shown, foxglove=a.foxglove, host=a.host, rerun=a.rerun) as to:
        for address in to.addresses:
            _command.say(f"{address}{'   (Ctrl-C ends)' if '://' in address else ''}", sys.stderr)
        try:
            while not a.now and not to.wait():
                pass
        except KeyboardInterrupt:
            return _command.DONE
        return _run(a, shown, to) if a.run else _play(a, shown, to)


def _run(a: argparse.Namespace, shown: Plan | Task, to: Stream) -> int:
    # The run waits for the eye: wall time has no bound here, the clock of the plant has one.
    done: RunResult = run(shown, seed=a.seed, speed=a.speed, duration=a.duration, threads=a.threads, timeout_s=1e9, on_sample=to)
    task = shown.task if isinstance(shown, Plan) else shown
    result = {"status": done.end.name, "task": task.name, "reached": done.reached, "duration_s": done.duration_s, "message": done.message, "sent": to.addresses}
    rows = {"run": f"{done.duration_s:.1f} s, {len(done.plans)} plans, {len(done.pieces)} pieces", "sent to": ", ".join(to.addresses)}
    _command.report(a, f"{task.name}: {'goal reached' if done.reached else done.message}", rows, result)
    return _command.DONE if done.reached else _command.NOT_SOLVED


def _play(a: argparse.Namespace, plan: Plan | Task, to: Stream) -> int:
    assert isinstance(plan, Plan)
    once = a.once or not to.live
    duration, times = 0.0, 0
    try:
        while times == 0 or not once:
            duration = to.play(speed=a.speed, pause=a.pause)
            times += 1
    except KeyboardInterrupt:
        if once:
            return _command.INTERRUPTED
    miss = describe_miss(plan)
    if miss:
        _command.say(f"stiction: warning: {a.target}: {miss}", sys.stderr)
    result = {"status": "Done" if not miss else "NotSolved", "task": plan.task.name, "duration_s": duration, "times": times, "sent": to.addresses}
    _command.report(a, f"{plan.task.name}: shown", {"motion": f"{duration:.1f} s, {times} times", "sent to": ", ".join(to.addresses)}, result)
    return _command.DONE if not miss else _command.NOT_SOLVED
