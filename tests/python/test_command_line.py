"""What every command has in common: numbers that are refused in the same words, streams that cannot be written, signals, a Python that lacks a package."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import children
import pytest
from limits import within

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build" / "release" / "stiction"
if not PROGRAM.exists():
    pytest.skip(f"{PROGRAM} does not exist: run `make build`", allow_module_level=True)

# ---- words


@pytest.mark.parametrize("words", [["plan", "planar_pushing", "--goal", ""], ["plan", "planar_pushing", "--goal="], ["check", ""], ["export", "", "--format", "csv"], ["plan", "planar_pushing", "-o", ""]], ids=" ".join)
def test_empty_word_is_not_an_option_that_is_missing(words: list[str], tmp_path: Path) -> None:
    """As a variable of a shell that is not set gives it; `export ""` took the plan of the working folder."""
    done = children.run([PROGRAM, *words, "--json"], cwd=tmp_path)
    assert done.returncode == 2 and "got an empty word" in json.loads(done.stdout)["message"], done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", [["simulate", "PLAN", "--speed", "1e-6"], ["export", "PLAN", "--format", "mcap", "--pause", "1e30"], ["export", "PLAN", "--format", "csv", "--speed", "1e-12"]], ids=" ".join)
def test_motions_that_no_one_waits_for_are_refused(words: list[str], real_plan: Path, tmp_path: Path) -> None:
    done = children.run([PROGRAM, *(real_plan if word == "PLAN" else word for word in words), "-o", tmp_path / "out", "--json"])
    assert done.returncode == 2 and "got a motion of" in json.loads(done.stdout)["message"], done.stderr


# ---- numbers

FIRST = {"check": "plan.json", "simulate": "plan.json", "refine": "plan.json", "export": "plan.json", "stream": "plan.json", "benchmark": "push_t_planar", "bench": None}  # others take a task or a scenario
OF_PYTHON = {  # option: (lowest and highest integer, or "> 0" or "≥ 0")
    "export": {"--speed": "> 0", "--pause": "≥ 0"},
    "stream": {"--speed": "> 0", "--pause": "≥ 0", "--duration": "> 0", "--seed": (0, 2**64 - 1), "--threads": (0, 4096), "--foxglove": (0, 65535)},
    "sweep": {"--speed": "> 0", "--timeout": "> 0", "-j": (1, 1024)},
    "benchmark": {"--plan-budget": "> 0", "--duration": "> 0", "-j": (1, 1024)},
}


def numeric_options() -> Iterator[tuple[str, str, object]]:
    """(command, option, what it may be) of all, as the help of the commands says."""
    listed = children.run([PROGRAM, "--help"]).stdout.split("Subcommands:")[1]
    for command in re.findall(r"^  ([a-z]+) ", listed, flags=re.MULTILINE):
        if command in OF_PYTHON:
            yield from ((command, option, may) for option, may in OF_PYTHON[command].items())
            continue
        for option, kind, rest in re.findall(r"^ +(--[a-z-]+) (NUMBER|INTEGER) \(([^)]*)\)", children.run([PROGRAM, command, "--help"]).stdout, flags=re.MULTILINE):
            bounds = re.match(r"(\d+) to (\d+)$", rest)
            if bounds is not None:
                yield command, option, (int(bounds[1]), int(bounds[2]))
            else:
                yield command, option, (0, 2**64 - 1) if kind == "INTEGER" else rest


OPTIONS = list(numeric_options())


def test_every_command_with_a_budget_or_a_seed_has_numeric_options() -> None:
    """Else the tests below look at nothing."""
    found = {(command, option) for command, option, _ in OPTIONS}
    for command in ("plan", "optimize", "check", "simulate", "refine", "solve", "run", "control", "touch", "sweep"):
        assert (command, "--timeout") in found
    for command in ("plan", "optimize", "refine", "solve", "run", "control", "touch"):
        assert (command, "--seed") in found
    assert {("sense", "--port"), ("studio", "--port"), ("bench", "--repeat"), ("sense", "--force"), ("run", "--pose-noise"), ("solve", "--friction")} <= found


@pytest.mark.parametrize(("command", "option", "may"), OPTIONS, ids=[f"{command} {option}" for command, option, _ in OPTIONS])
def test_numbers_that_cannot_be_are_refused_in_the_same_words(command: str, option: str, may: object) -> None:
    wrong = ["nan", "inf", "1e999", "10s", "0x10", "1_0", "9" * 400]
    if isinstance(may, tuple):
        wrong += [str(may[0] - 1), str(may[1] + 1), "1.5", str(2**64), str(2**64 + 1)]
        expected = rf"an integer from {may[0]} to {may[1]}"
    else:
        wrong += ["-1e-9"] + (["0"] if may == "> 0" else [])
        expected = rf"a number {may}"
    first = FIRST.get(command, "planar_pushing")
    for word in wrong if command not in OF_PYTHON else wrong[::3]:  # those start an interpreter
        done = children.run([PROGRAM, command, *([first] if first else []), *([f"{option}={word}"] if option.startswith("--") else [option, word])])
        assert done.returncode == 2, (word, done.stderr)
        assert done.stdout == "" and len(done.stderr.splitlines()) == 1 and len(done.stderr) < 300, (word, done.stderr)
        assert re.search(rf"{option}(/--[a-z]+)?: got '[^']*'( \(\d+ characters\))?, expected ({expected}|\d numbers)", done.stderr), (word, done.stderr)


def test_largest_seed_is_taken(tmp_path: Path) -> None:
    done = children.run([PROGRAM, "plan", "planar_pushing", "--seed", 2**64 - 1, "--goal", "1", "-o", tmp_path])
    assert done.returncode == 2 and "goal" in done.stderr and "--seed" not in done.stderr, done.stderr


@pytest.mark.parametrize("seeds", ["0", "3:1", "3:3", "-2", "a", "1:", "1,", "1:2:3", "18446744073709551616", "0:99999999999"])
def test_seeds_of_a_sweep(seeds: str, tmp_path: Path) -> None:
    done = children.run([PROGRAM, "sweep", "planar_pushing", f"--seeds={seeds}", "-o", tmp_path / "x.csv"])
    assert done.returncode == 2 and f"--seeds: got '{seeds}', expected N > 0" in done.stderr and len(done.stderr) < 300, done.stderr


# ---- streams


@pytest.fixture()
def nobody_reads() -> Iterator[int]:
    """A pipe like that of `| head -1`, whose reader has gone."""
    reader, writer = os.pipe()
    os.close(reader)
    yield writer
    os.close(writer)


COMMANDS = [
    ("plan", ["plan", "planar_pushing", "-o", "FOLDER"], "plan.json"),
    ("plan --json", ["plan", "planar_pushing", "-o", "FOLDER", "--json"], "plan.json"),
    ("simulate", ["simulate", "PLAN", "--speed", "20", "--whole-only", "-o", "FOLDER"], "simulation.json"),
    ("refine", ["refine", "PLAN", "-o", "FOLDER"], "trajectory.csv"),
    ("check", ["check", "PLAN"], None),
    ("export", ["export", "PLAN", "-o", "FOLDER/motion.csv"], "motion.csv"),
    ("export --json", ["export", "PLAN", "-o", "FOLDER/motion.json", "--json"], "motion.json"),
]
IDS = [name for name, _, _ in COMMANDS]


def words_of(words: list[str], plan: Path, folder: Path) -> list[object]:
    return [PROGRAM, *(word.replace("FOLDER", str(folder)).replace("PLAN", str(plan)) for word in words)]


@pytest.mark.parametrize(("words", "file"), [command[1:] for command in COMMANDS], ids=IDS)
def test_pipe_that_nobody_reads_costs_no_result(words: list[str], file: str | None, real_plan: Path, tmp_path: Path, nobody_reads: int) -> None:
    plain = children.run(words_of(words, real_plan, tmp_path / "plain"))
    done = children.run(words_of(words, real_plan, tmp_path), stdout=nobody_reads)
    assert done.returncode == (plain.returncode or 70), "a verdict stays what it is"
    assert "stdout: cannot be written (Broken pipe)" in done.stderr and "Traceback" not in done.stderr and "Exception ignored" not in done.stderr, done.stderr
    assert file is None or (tmp_path / file).stat().st_size > 0


def test_disk_that_is_full_and_streams_that_are_closed(real_plan: Path, tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        done = children.run([PROGRAM, "check", real_plan], stdout=full)
    assert done.returncode == 70 and "stdout: cannot be written (No space left on device)" in done.stderr
    for closed in ("<&-", ">&-", "2>&-", "<&- >&- 2>&-"):
        folder = tmp_path / closed.replace(" ", "")
        done = children.run(["sh", "-c", f'"$0" "$@" {closed}', PROGRAM, "plan", "planar_pushing", "-o", folder])
        assert done.returncode == (70 if ">&-" in closed.split() else 0), (closed, done.stderr)
        json.loads((folder / "plan.json").read_text())  # nothing else was written there


@pytest.mark.parametrize("words", [["--help"], ["plan", "--help"], ["tasks"]], ids=" ".join)
def test_head_of_a_help_is_no_fault(words: list[str], nobody_reads: int) -> None:
    done = children.run([PROGRAM, *words], stdout=nobody_reads)
    assert done.returncode == 70 and done.stderr == "stiction: stdout: cannot be written (Broken pipe); files of the command are whole\n"


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_letters_that_a_terminal_lacks_are_no_fault(encoding: str, real_plan: Path, tmp_path: Path) -> None:
    folder = tmp_path / "→ ziel"
    folder.mkdir()
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    for extra in ([], ["--json"]):
        done = children.run([PROGRAM, "export", real_plan, "-o", folder / "motion.csv", *extra], env=environment, encoding=encoding)
        assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
        assert (folder / "motion.csv").exists()
    assert json.loads(done.stdout)["files"][0] == str(folder / "motion.csv"), "JSON keeps the letters"
    done = children.run([PROGRAM, "export", folder / "nothing.json", "--format", "csv"], env=environment, encoding=encoding)
    assert done.returncode == 2 and "nothing.json" in done.stderr and "Traceback" not in done.stderr, done.stderr


# ---- a Python that lacks something


@pytest.fixture(scope="module")
def bare_python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An interpreter without NumPy and everything else."""
    folder = tmp_path_factory.mktemp("bare")
    done = children.run([sys.executable, "-m", "venv", "--without-pip", folder])
    assert done.returncode == 0, done.stderr
    return folder / "bin" / "python"


IN_PYTHON = [
    ["export", "PLAN", "--format", "csv"],
    ["sweep", "planar_pushing"],
    ["studio"],
    ["sense", "ur5_forearm", "--live"],
    ["reproduce", "all", "-o", "FOLDER"],
    ["view", "PLAN", "--html", "FOLDER/x.html"],
]


@pytest.mark.parametrize("words", IN_PYTHON, ids=lambda words: words[0])
def test_python_without_numpy_is_a_fault_of_the_installation(words: list[str], bare_python: Path, real_plan: Path, tmp_path: Path) -> None:
    environment = {"PATH": "/usr/bin:/bin", "STICTION_PYTHON": str(bare_python)}
    done = children.run(words_of(words, real_plan, tmp_path), env=environment, cwd=tmp_path)
    assert done.returncode == 70, done.stderr
    assert "Traceback" not in done.stderr and str(bare_python) in done.stderr and "STICTION_PYTHON" in done.stderr, done.stderr


def test_python_without_numpy_says_so_in_json(bare_python: Path, real_plan: Path, tmp_path: Path) -> None:
    environment = {"PATH": "/usr/bin:/bin", "STICTION_PYTHON": str(bare_python)}
    done = children.run([PROGRAM, "export", real_plan, "--format", "csv", "--json"], env=environment, cwd=tmp_path)
    assert done.returncode == 70 and json.loads(done.stdout)["status"] == "Error" and "numpy" in json.loads(done.stdout)["message"].lower()


def test_folder_with_a_module_of_the_same_name_is_not_read(real_plan: Path, tmp_path: Path) -> None:
    (tmp_path / "numpy.py").write_text("raise SystemExit('the wrong one')\n")
    for name in ("json", "signal", "queue", "random"):  # of Python itself, for the first process and for those that it starts
        (tmp_path / f"{name}.py").write_text("raise SystemExit('the wrong one')\n")
    done = children.run([PROGRAM, "export", real_plan, "-o", "motion.csv"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    done = children.run([PROGRAM, "sweep", "planar_pushing", "-j", "1", "-o", "sweep.csv", "--json"], cwd=tmp_path)
    assert done.returncode == 0 and (tmp_path / "sweep.csv").read_text().count("Solved") == 1, done.stderr


# ---- outputs


@pytest.mark.parametrize("words", [["plan", "planar_pushing"], ["export", "PLAN", "--format", "csv"], ["sweep", "planar_pushing"], ["refine", "PLAN"], ["reproduce", "figure-2.1"]], ids=lambda words: words[0])
def test_stdout_is_no_output_that_makes_a_file_of_this_name(words: list[str], real_plan: Path, tmp_path: Path) -> None:
    words = [str(real_plan) if word == "PLAN" else word for word in words]
    for output in (["-o", "-"], ["-o-"], ["--out", "-"], ["--out=-"]):
        done = children.run([PROGRAM, *words, *output], cwd=tmp_path)
        assert done.returncode == 2 and "got '-', expected the name of a file or folder" in done.stderr, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_page_is_not_written_to_stdout(real_plan: Path, tmp_path: Path) -> None:
    done = children.run([PROGRAM, "view", real_plan, "--html", "-"], cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("stiction: --html: got '-'") and list(tmp_path.iterdir()) == []


def test_imported_task_may_go_to_stdout_by_name(tmp_path: Path) -> None:
    scene = tmp_path / "scene.xml"
    scene.write_text(
        "<mujoco><worldbody><body name='arm'><joint name='x' type='slide' axis='1 0 0'/><geom size='.05' mass='1'/></body>"
        "<body name='box' pos='.3 0 0'><joint name='b' type='slide' axis='1 0 0'/><geom size='.1' mass='1'/></body></worldbody>"
        "<actuator><position joint='x' kp='100'/></actuator></mujoco>"
    )
    plain = children.run([PROGRAM, "import", scene], cwd=tmp_path)
    assert plain.returncode == 0, plain.stderr
    for output in (["-o", "-"], ["-o-"], ["--out", "-"], ["--out=-"]):
        named = children.run([PROGRAM, "import", scene, *output], cwd=tmp_path)
        assert named.returncode == 0 and named.stdout == plain.stdout, named.stderr
    assert list(tmp_path.iterdir()) == [scene]


@pytest.mark.parametrize("words", [["export", "PLAN", "--format", "csv"], ["report", "PLAN"], ["sweep", "planar_pushing"]], ids=lambda words: words[0])
def test_link_to_a_pipe_is_a_pipe(words: list[str], real_plan: Path, tmp_path: Path) -> None:
    """/dev/stdout leads to a name that is no path."""
    done = children.run([PROGRAM, *(real_plan if word == "PLAN" else word for word in words), "-o", "/dev/stdout"], cwd=tmp_path)
    assert done.returncode == 2 and "/dev/stdout: got a device or a pipe, expected a file to write" in done.stderr, done.stderr


@pytest.mark.parametrize("name", ["../../elsewhere", "/tmp/elsewhere", "two\nlines"])
def test_name_of_a_task_leads_to_no_other_folder(name: str, tmp_path: Path) -> None:
    here = tmp_path / "a" / "b"
    here.mkdir(parents=True)
    (here / "task.yaml").write_text(json.dumps({"base": str(ROOT / "tasks" / "planar_pushing.yaml"), "name": name}))
    done = children.run([PROGRAM, "plan", "task.yaml", "--seed", "0", "--json"], cwd=here)
    assert done.returncode == 0, done.stderr
    folder = name.replace("/", "_").replace("\n", "_") + "-seed0"
    assert sorted(path.name for path in here.iterdir()) == sorted([folder, "task.yaml"]) and (here / folder / "plan.json").exists()


# ---- inputs


def test_plan_and_task_come_through_a_pipe(real_plan: Path, tmp_path: Path) -> None:
    """As of `<(gunzip -c plan.json.gz)`."""
    for command, file in (("check", real_plan), ("lint", ROOT / "tasks" / "planar_pushing.yaml")):
        pipe = tmp_path / f"{command}.yaml"
        os.mkfifo(pipe)
        source = tmp_path / f"{command}.txt"
        source.write_text(file.read_text().replace("../models", str(ROOT / "models")))
        with children.Child(["sh", "-c", 'exec cat "$0" > "$1"', source, pipe]):  # waits until the pipe is read
            done = children.run([PROGRAM, command, pipe], cwd=tmp_path)
        assert done.returncode == 0, done.stderr


def test_plan_of_a_task_that_came_through_a_pipe_keeps_the_text(tmp_path: Path) -> None:
    """A pipe cannot be read again. Its paths are relative to the working folder."""
    (tmp_path / "task.yaml").write_text((ROOT / "tasks" / "planar_pushing.yaml").read_text().replace("../models", "models"))
    (tmp_path / "models").symlink_to(ROOT / "models")
    pipe = tmp_path / "elsewhere" / "pipe"
    pipe.parent.mkdir()
    os.mkfifo(pipe)
    with children.Child(["sh", "-c", 'exec cat "$0" > "$1"', tmp_path / "task.yaml", pipe]):
        done = children.run([PROGRAM, "plan", pipe, "-o", "out"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    pipe.unlink()
    done = children.run([PROGRAM, "check", "out"], cwd=tmp_path)
    assert done.returncode == 0, done.stderr + done.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["plan", "PLAN"], "top level: got a plan file, expected a task; `stiction check` and the other commands for plans read it"),
        (["sense", "PLAN"], "top level: got a plan file, expected a scenario of sensing"),
        (["check", "tasks/planar_pushing.yaml"], "file: got a YAML file, expected a plan file (plan.json), as `stiction plan` writes it"),
        (["plan", "scenarios/ur5_forearm.yaml"], "top level: got a scenario of sensing, expected a task; `stiction sense` reads it"),
        (["plan", "scenarios/feel_table.yaml"], "top level: got a scenario of touch, expected a task; `stiction touch` reads it"),
        (["sense", "scenarios/box_in_the_way.yaml"], "top level: got a scenario of control, expected a scenario of sensing; `stiction control` reads it"),
        (["control", "tasks/planar_hand.yaml"], "top level: got a task, expected a scenario of control; `stiction plan` reads it"),
        (["touch", "tasks/planar_hand.yaml"], "top level: got a task, expected a scenario of touch; `stiction plan` reads it"),
        (["sense", "planar_hand"], "scenario: got 'planar_hand', which is a task"),
        (["plan", "ur5_forearm"], "task: got 'ur5_forearm', which is a scenario of sense, control or touch"),
        (["lint", "tasks"], "task: got 'tasks', expected a file"),
        (["lint", "tasks/"], "file: got a folder, expected a YAML file"),
        (["check", "nothing"], "nothing: file: got no file of this name, expected a plan file"),
        (["check", "/dev/null"], "/dev/null: file: got a device, expected a plan file"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_file_of_another_kind_is_one_sentence(words: list[str], message: str, real_plan: Path) -> None:
    done = children.run([PROGRAM, *(real_plan if word == "PLAN" else word for word in words)], cwd=ROOT)
    assert done.returncode == 2 and message in done.stderr and done.stderr.count("\n") == 1, done.stderr


# ---- signals

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


def wait_until_it_opens(child: children.Child) -> None:
    """Until a program handles signals and sleeps, as it does nowhere but at a pipe that nobody has opened to write."""
    with within(children.LIMIT, f"a program that sleeps: {child.args!r}"):
        while True:
            status = dict(line.split(":\t", 1) for line in Path(f"/proc/{child.pid}/status").read_text().splitlines() if ":\t" in line)
            caught = int(status.get("SigCgt", "0"), 16)  # a program that has ended has none
            if all(caught >> (number - 1) & 1 for number in SIGNALS) and status["State"].startswith("S"):
                return
            assert child.poll() is None, child.communicate()
            time.sleep(0.01)


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("command", ["plan", "lint", "solve", "optimize", "run", "check", "simulate", "refine", "sense", "control", "touch"])
def test_signal_while_files_are_read_is_code_130(command: str, number: signal.Signals, tmp_path: Path) -> None:
    """Nothing has been computed yet that could be kept."""
    waits = tmp_path / ("plan.json" if command in ("check", "simulate", "refine") else "task.yaml")
    os.mkfifo(waits)
    with children.Child([PROGRAM, command, waits, "--json"], cwd=tmp_path) as child:
        wait_until_it_opens(child)  # nobody writes: a program that had the file open would refuse it, perhaps before the signal
        done = child.stop(number)
    assert done.returncode == 130 and done.stderr == "stiction: interrupted\n", done.stderr
    assert json.loads(done.stdout)["status"] == "Cancelled"


KEPT = [
    ("plan", ["plan", "TASK", "--timeout", "100", "-o", "FOLDER"], "plan.json"),
    ("solve", ["solve", "TASK", "--timeout", "100", "-o", "FOLDER"], "plan.json"),
    ("optimize", ["optimize", "impc_planar_hand", "--iterations", "1000000", "--timeout", "100", "-o", "FOLDER"], "plan.json"),
    ("run", ["run", "planar_pushing", "--speed", "0.02", "--duration", "10000", "-o", "FOLDER"], "run.json"),
    ("simulate", ["simulate", "PLAN", "--speed", "0.001", "-o", "FOLDER"], "simulation.json"),
]


@pytest.fixture()
def endless(tmp_path: Path) -> Path:
    """A task that is planned until its time is used up: no arm reaches its goal, and there are more extensions than time."""
    import yaml

    task = tmp_path / "task.yaml"
    changes = {"planner": {"max_iterations": 2**31 - 1}, "goal": {"objects": {"ball": {"coordinates": [3.0, 3.0, 0.0]}}}}
    task.write_text(yaml.safe_dump({"base": str(ROOT / "tasks/planar_hand.yaml"), **changes}))
    return task


@pytest.mark.parametrize(("words", "file"), [command[1:] for command in KEPT], ids=[command[0] for command in KEPT])
def test_hangup_keeps_the_result_as_ctrl_c_does(words: list[str], file: str, endless: Path, real_plan: Path, tmp_path: Path) -> None:
    words = [word.replace("TASK", str(endless)) for word in words]
    with children.Child([*words_of(words, real_plan, tmp_path), "--json"]) as child:
        with pytest.raises(subprocess.TimeoutExpired):
            child.communicate(timeout=5)
        done = child.stop(signal.SIGHUP)
    assert done.returncode == 130, done.stderr
    assert json.loads(done.stdout)["status"] == "Cancelled"
    assert (tmp_path / file).stat().st_size > 0


def test_program_that_nohup_started_goes_on_at_a_hangup(endless: Path, tmp_path: Path) -> None:
    with children.Child(["sh", "-c", 'trap "" HUP; exec "$0" "$@"', PROGRAM, "plan", endless, "--timeout", 100, "-o", tmp_path]) as child:
        for _ in range(2):
            with pytest.raises(subprocess.TimeoutExpired):
                child.communicate(timeout=3)
            child.send_signal(signal.SIGHUP)
        assert child.stop(signal.SIGINT).returncode == 130
    assert (tmp_path / "plan.json").exists()


@pytest.mark.parametrize("number", SIGNALS)
def test_signal_ends_a_sweep_as_ctrl_c_does(number: signal.Signals, tmp_path: Path) -> None:
    file = tmp_path / "sweep.csv"
    with children.Child([PROGRAM, "sweep", "planar_pushing", "--seeds", "1000", "-j", "1", "--no-refine", "-o", file]) as child:
        for line in child.stderr:
            if line.startswith("2 of 1000"):
                break
        done = child.stop(number)
    assert done.returncode == 130 and "the same command goes on" in done.stderr and "Traceback" not in done.stderr, done.stderr
    assert len(file.read_text(encoding="utf-8").splitlines()) >= 3


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signal_while_python_starts_is_code_130(number: signal.Signals, tmp_path: Path) -> None:
    """Modules in C++ abort where an exception comes up in their start, and the interpreter knows nothing of SIGTERM."""
    for after in (0.02, 0.05, 0.1, 0.2):
        with children.Child([PROGRAM, "grasps", "planar_hand", "--count", "10000", "-o", tmp_path / "none.npz", "--json"]) as child:
            time.sleep(after)
            done = child.stop(number)
        assert done.returncode == 130 and json.loads(done.stdout)["status"] == "Cancelled" and "Traceback" not in done.stderr, done.stderr


ENDLESS = """
import os, signal, sys, threading
sys.path.insert(0, sys.argv[1])
import stiction as st
plan = st.plan(st.load_task("planar_pushing"), seed=0).plan
plant, t = st.Plant(plan.task.model), st.make_trajectory(plan, speed=1e-3)
threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    {call}
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.parametrize("call", ["st.transfer(plan, speed=1e-3, alone=False)", "st.transfer(plan, speed=1e-3, whole=False)", "st.simulate(plant, t.q[0], t.times, t.u)"])
def test_ctrl_c_ends_simulations_of_the_module(call: str) -> None:
    done = children.run([sys.executable, "-c", ENDLESS.replace("{call}", call), ROOT / "build/release/python"], limit=60)
    assert done.stdout == "interrupted\n", done.stderr


def test_grasps_found_before_ctrl_c_are_kept(tmp_path: Path) -> None:
    words = ["grasps", "planar_hand", "--count", "100000", "--timeout", "1000", "-o", tmp_path / "grasps.npz", "--json"]
    with children.Child([PROGRAM, *words]) as child:
        with pytest.raises(subprocess.TimeoutExpired):
            child.communicate(timeout=6)
        done = child.stop(signal.SIGINT)
    assert done.returncode == 130 and json.loads(done.stdout)["status"] == "Cancelled", done.stderr
    assert (tmp_path / "grasps.npz").stat().st_size > 0


def test_signals_are_those_of_a_program_in_the_foreground_also_in_the_background(endless: Path, tmp_path: Path) -> None:
    """A script that is started with & ignores SIGINT, and so does what it starts."""
    with children.Child(["sh", "-c", 'trap "" INT; exec "$0" "$@"', PROGRAM, "plan", endless, "--timeout", 100, "-o", tmp_path]) as child:
        with pytest.raises(subprocess.TimeoutExpired):
            child.communicate(timeout=3)
        assert child.stop(signal.SIGINT).returncode == 130
