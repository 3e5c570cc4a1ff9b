"""`stiction run`: a task or a plan in closed loop, its files and page, exit codes, interruptions, messages; the same from Python."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import children
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402


@pytest.fixture(scope="module")
def ran(stiction, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, Path]:
    """A push aside on its way calls for a new plan."""
    folder = tmp_path_factory.mktemp("run")
    done = stiction("run", "planar_hand", "--goal", "0 0.35 0.8", "--seed", 1, "--push", "0.6 0.3 0 20 0", "--planning-rate", 0, "--html", "--json", "-o", folder, timeout=300)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 1
    return json.loads(done.stdout), folder


def test_json_tells_of_plans_and_pieces(ran: tuple[dict, Path]) -> None:
    out, folder = ran
    assert out["status"] == "Reached" and out["reached"]
    assert out["error"]["position"] <= out["tolerance"]["position"] and out["true_error"]["angle"] <= out["tolerance"]["angle"]
    assert out["replans"] >= 1 and len(out["plans"]) >= 2 and out["plans"][1]["cause"]
    assert out["pushes"] == sum(p["kind"] == "contact" for p in out["pieces"]) > 0
    assert any(p["given_up"] for p in out["pieces"])
    assert 0 < out["largest_effort"] <= 1 + 1e-9
    for piece in out["pieces"]:
        assert piece["begin_s"] <= piece["end_s"] <= out["duration_s"]
    document = json.loads((folder / "run.json").read_text())
    assert document["format"] == "stiction-simulation" and document["report"]["pieces"] == out["pieces"]
    assert {"plan.json", "run.json", "run.html"} <= {path.name for path in folder.iterdir()}
    page = (folder / "run.html").read_text()
    assert "closed loop" in page and "planned anew" in page


def test_page_shows_what_the_motors_gave(ran: tuple[dict, Path]) -> None:
    """No step of the simulation is passed over, though the page has fewer pictures."""
    from stiction_view.overlay import load_simulation

    out, folder = ran
    loads = load_simulation(folder / "plan.json", folder / "run.json").plan.loads
    assert loads is not None and loads.limited().any()
    assert loads.effort_share().max() == pytest.approx(out["largest_effort"], rel=1e-4)
    page = (folder / "run.html").read_text()
    assert f"at most {100 * out['largest_effort']:.1f} %" in page and 'id="loads"' in page


def test_same_seed_gives_the_same_run_from_python(ran: tuple[dict, Path]) -> None:
    task = st.load_task("planar_hand")
    task.set_goal([0, 0.35, 0.8])
    run = st.run(task, seed=1, pushes=[(0.6, 0.3, [0, 20, 0])], planning_rate=0)
    out, _ = ran
    assert run.end == st.RunEnd.Reached and run.status == st.Status.Solved
    assert run.duration_s == out["duration_s"] and run.replans == out["replans"] and len(run.pieces) == len(out["pieces"])
    assert run.q.shape == (len(run.times), task.model.n_q) and run.u.shape == (len(run.times), task.model.n_a)
    assert np.all(np.diff(run.times) > 0)
    assert run.true_error.position == pytest.approx(out["true_error"]["position"], abs=1e-12)


def test_clock_goes_on_while_the_planner_works(stiction) -> None:
    """Twice as long at half of the rate, and the same in every run where steps are charged."""
    charged = ("run", "planar_pushing", "--goal", "0 0.7 0", "--plan-step-time", "1e-4", "--json")
    runs = [json.loads(stiction(*charged, *rate).stdout) for rate in ((), ("--planning-rate", 0.5), ("--planning-rate", 0))]
    once, twice, never = (run["plans"][0]["clock_s"] for run in runs)
    assert once > 0.01 and twice == pytest.approx(2 * once, abs=2e-3) and never == 0
    task = st.load_task("planar_pushing")
    task.set_goal([0, 0.7, 0])
    run = st.run(task, plan_step_time_s=1e-4)
    assert run.plans[0].clock_s == once and run.duration_s == runs[0]["duration_s"]
    run = st.run(task)
    assert run.plans[0].clock_s == pytest.approx(run.plans[0].processor_s, abs=2e-3)


class Paced:
    """A plant whose clock goes on by itself."""

    real_time = True

    def __init__(self, task: st.Task) -> None:
        self.plant = st.SimulatedPlant(task)

    def read(self) -> st.Measurement | None:
        return self.plant.read()

    def command(self, u: np.ndarray, period: float) -> bool:
        return self.plant.command(u, period)


def test_plant_with_its_own_clock_is_commanded_while_the_planner_works() -> None:
    task = st.load_task("planar_pushing")
    task.set_goal([0, 0.7, 0])
    run = st.run(task, plant=Paced(task), duration=1e5)
    assert run.reached and run.plans[0].clock_s > 0
    plant = Paced(task)
    plant.real_time = "yes"
    with pytest.raises(st.InvalidInput, match=r"plant.real_time: got a value of type str, expected True or False"):
        st.run(task, plant=plant)


def test_plan_is_the_beginning_of_a_run(stiction, real_plan: Path, tmp_path: Path) -> None:
    done = stiction("run", real_plan, "--duration", 4, "--json", "-o", tmp_path)
    assert done.returncode == 3, done.stderr
    out = json.loads(done.stdout)
    assert out["status"] == "TimeUp", "the plan takes longer than 4 s"
    assert out["pieces"][0]["plan"] == -1, "of the given plan"
    assert out["plan"] == str(real_plan) and (tmp_path / "run.json").exists() and not (tmp_path / "plan.json").exists()


def test_ball_in_an_open_hand_is_turned_by_its_fingers_without_a_plan(stiction, tmp_path: Path) -> None:
    done = stiction("run", "allegro_ball", "--goal", "-0.081 0.001 0.071 0 0 0.7", "--html", "--json", "-o", tmp_path, timeout=120)
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    assert out["reached"] and out["plans"] == []
    assert [piece["kind"] for piece in out["pieces"][:5]] == ["contact"] + 4 * ["regrasp"]
    assert (tmp_path / "run.html").stat().st_size > 1e5
    without = stiction("run", "allegro_ball", "--no-finger-gait", "--duration", 0.5, "--json")
    assert len(json.loads(without.stdout)["plans"]) >= 1


def test_noise_changes_what_is_measured_and_not_what_is_meant(stiction) -> None:
    runs = [stiction("run", "planar_hand", "--goal", "0 0.35 0.3", *noise, "--json") for noise in ((), ("--pose-noise", "0.001,0.01", "--pose-delay", 0.02))]
    assert all(run.returncode == 0 for run in runs), runs[1].stderr
    plain, noisy = (json.loads(run.stdout) for run in runs)
    assert plain["error"]["position"] == pytest.approx(plain["true_error"]["position"], abs=1e-3)
    assert noisy["error"] != noisy["true_error"]
    assert noisy["true_error"]["position"] <= 2 * noisy["tolerance"]["position"]


def test_interrupted_run_keeps_its_files_whole(interrupted, tmp_path: Path) -> None:
    done = interrupted("run", "planar_pushing", "--speed", 0.02, "--duration", 10000, "--json", "-o", tmp_path, after=4)
    assert done.returncode == 130, done.stderr
    assert json.loads(done.stdout)["status"] == "Cancelled"
    if (tmp_path / "run.json").exists():
        assert json.loads((tmp_path / "run.json").read_text())["report"]["status"] == "Cancelled"


@pytest.mark.parametrize(
    "arguments, parts",
    [
        (("no_task",), ("no_task",)),
        (("nowhere.json",), ("nowhere.json",)),
        (("planar_pushing", "--mass", "0"), ("--mass",)),
        (("planar_pushing", "--friction", "-1"), ("--friction",)),
        (("planar_pushing", "--pose-noise", "0.01"), ("--pose-noise",)),
        (("planar_pushing", "--planning-rate", "-1"), ("--planning-rate",)),
        (("planar_pushing", "--plan-step-time", "0"), ("--plan-step-time",)),
        (("planar_pushing", "--pose-delay", "x"), ("--pose-delay",)),
        (("planar_pushing", "--push", "1 2 3"), ("--push: got '1 2 3'", "five numbers")),
        (("planar_pushing", "--push", "1 0 0 0 1"), ("world.push.duration", "0")),
        (("PLAN", "--goal", "0 0 0"), ("--goal", "a plan has its own")),
    ],
)
def test_mistakes_have_one_clear_message(stiction, real_plan: Path, tmp_path: Path, arguments: tuple, parts: tuple) -> None:
    words = [real_plan if word == "PLAN" else word for word in arguments]
    done = stiction("run", *words, "-o", tmp_path / "out")
    assert done.returncode == 2 and done.stdout == "", done.stderr
    assert all(part in done.stderr for part in parts), done.stderr
    assert not (tmp_path / "out/run.json").exists()


def test_mistakes_in_python_are_named() -> None:
    task = st.load_task("planar_pushing")
    for options, words in (({"replans": -1}, "replans: got -1"), ({"mass_scale": 0}, "world.mass: got 0"), ({"speed": 0}, "speed: got 0")):
        with pytest.raises(st.InvalidInput, match=words):
            st.run(task, **options)


def test_robot_behind_its_own_driver_reaches_its_goal_and_is_missed_when_it_is_gone() -> None:
    example = ROOT / "python" / "examples" / "own_robot.py"
    done = children.run([sys.executable, example], env={"PYTHONPATH": str(MODULE)}, limit=120)
    assert done.returncode == 0, done.stderr
    reached, gone = done.stdout.splitlines()
    assert reached.startswith("Reached"), done.stdout
    assert gone == "the plant does not answer"


class Broken:
    """A plant with a driver that fails after some commands."""

    def __init__(self, task: st.Task, fail) -> None:
        self.plant, self.fail, self.commands = st.SimulatedPlant(task), fail, 0

    def read(self) -> st.Measurement | None:
        return self.plant.read()

    def command(self, u: np.ndarray, period: float) -> bool:
        self.commands += 1
        if self.commands > 300:
            return self.fail()
        return self.plant.command(u, period)


def test_driver_that_fails_ends_the_run() -> None:
    task = st.load_task("planar_hand")
    run = st.run(task, plant=Broken(task, lambda: False), seed=0)
    assert run.end == st.RunEnd.Silent and run.status == st.Status.NumericalFailure
    assert run.message == "the plant takes no commands" and len(run.times) > 5
    assert np.isnan(run.largest_effort)

    def raise_error() -> bool:
        raise RuntimeError("the brake is on")

    plant = Broken(task, raise_error)
    with pytest.raises(RuntimeError, match="the brake is on"):
        st.run(task, plant=plant, seed=0)
    assert plant.commands == 301, "nothing is sent after it"
    with pytest.raises(st.InvalidInput, match=r"plant: got an object without read\(\), expected one with read\(\) and command"):
        st.run(task, plant=object())


class Odd:
    """A driver whose answers are changed from its fifth one on."""

    def __init__(self, task: st.Task, read=lambda measured: measured, taken=lambda done: done) -> None:
        self.plant, self.change, self.taken, self.reads, self.sent = st.SimulatedPlant(task), read, taken, 0, []

    def read(self):
        self.reads += 1
        measured = self.plant.read()
        return measured if self.reads < 5 else self.change(measured)

    def command(self, u: np.ndarray, period: float):
        self.sent.append(np.array(u))
        done = self.plant.command(u, period)
        return done if self.reads < 5 else self.taken(done)


def changed(measured: st.Measurement, **fields) -> st.Measurement:
    return st.Measurement(**{name: getattr(measured, name) for name in ("time", "q", "u")} | fields)


def spoilt(numbers: np.ndarray, index: int, value: float) -> np.ndarray:
    out = np.array(numbers)
    out[index] = value
    return out


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: changed(m, q=spoilt(m.q, 0, np.nan)), r"measurement that cannot be: q\[0\]: got nan"),
        (lambda m: changed(m, q=spoilt(m.q, -1, np.inf)), r"measurement that cannot be: q\[4\]: got inf"),
        (lambda m: changed(m, u=spoilt(m.u, 0, np.nan)), "measurement that cannot be: u"),
        (lambda m: changed(m, q=m.q[:-1]), "measurement that cannot be: q: got 4 numbers, expected 5"),
        (lambda m: changed(m, time=np.nan), "measurement that cannot be: time: got nan"),
        (lambda m: changed(m, object_time=np.inf), "measurement that cannot be: object_time: got inf"),
        (lambda m: changed(m, time=m.time - 100), "the clock of the plant went from 0.003 s to -99.996 s between two commands"),
        (lambda m: changed(m, time=m.time + 100), "the clock of the plant went from 0.003 s to 100.004 s between two commands"),
        (lambda m: changed(m, time=0.003), "the clock of the plant stands still at 0.003 s"),
        (lambda m: None, "the plant does not answer"),
    ],
    ids=["q nan", "q inf", "u nan", "q short", "time nan", "object_time inf", "back", "ahead", "still", "none"],
)
def test_driver_that_gives_nonsense_ends_the_run_by_name(change, message: str) -> None:
    task = st.load_task("planar_pushing")
    plant = Odd(task, read=change)
    run = st.run(task, plant=plant, seed=0, timeout_s=60)
    assert run.end == st.RunEnd.Silent and run.status == st.Status.NumericalFailure
    assert re.search(message, run.message), run.message
    assert len(plant.sent) <= 4 + 501 and all(np.isfinite(u).all() for u in plant.sent)


@pytest.mark.parametrize(
    ("driver", "message"),
    [
        ({"read": lambda m: 5}, r"^plant.read\(\): got a value of type int, expected a Measurement, or None where the robot does not answer"),
        ({"read": lambda m: (m.time, m.q, m.u)}, r"^plant.read\(\): got a value of type tuple, expected a Measurement"),
        ({"taken": lambda done: 0}, r"^plant.command\(\): got a value of type int, expected None or True, or False where the command is not taken"),
        ({"taken": lambda done: "ok"}, r"^plant.command\(\): got a value of type str"),
    ],
    ids=["read int", "read tuple", "command int", "command str"],
)
def test_driver_that_gives_another_type_is_a_mistake(driver: dict, message: str) -> None:
    task = st.load_task("planar_pushing")
    plant = Odd(task, **driver)
    with pytest.raises(st.InvalidInput, match=message):
        st.run(task, plant=plant, seed=0, timeout_s=60)
    assert len(plant.sent) <= 5, "nothing is sent after it"


@pytest.mark.parametrize("answer", [False, np.False_, np.bool_(False)])
def test_command_that_is_not_taken_ends_the_run(answer) -> None:
    task = st.load_task("planar_pushing")
    run = st.run(task, plant=Odd(task, taken=lambda done: answer), seed=0, timeout_s=60)
    assert run.end == st.RunEnd.Silent and run.message == "the plant takes no commands"


def test_goal_that_the_motors_cannot_hold_is_told_before_the_run(stiction, tmp_path: Path) -> None:
    """100 N, and a block of 40 kg that has to be lifted by 20 cm."""
    (tmp_path / "heavy.yaml").write_text(
        f"""
scene:
  robots: [{{name: ball, urdf: {ROOT / "models" / "ball_xyz.urdf"}, stiffness: 5000, friction: 0.5}}]
  objects: [{{name: block, joint: free, mass: 40, shapes: [{{box: {{size: [0.4, 0.4, 0.4]}}, friction: 0.5}}]}}]
  fixed: [{{name: ground, friction: 0.5, shapes: [{{half_space: {{}}}}]}}]
start: {{objects: {{block: {{position: [0, 0, 0.2]}}}}, joints: [-0.5, 0, 0.3]}}
goal: {{objects: {{block: {{position: [0, 0, 0.4]}}}}}}
tolerance: {{position: 0.02, angle: 0.1}}
""",
        encoding="utf-8",
    )
    done = stiction("run", tmp_path / "heavy.yaml", "--duration", 0.2, "--timeout", 1, "--json")
    assert done.returncode == 3, done.stderr
    assert "to carry 'block' (40 kg) takes" in done.stderr and "the motors give" in done.stderr, done.stderr
