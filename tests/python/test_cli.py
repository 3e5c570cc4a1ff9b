"""The program: exit codes, one message per mistake, JSON on stdout and nothing else, interruptions, repeatability."""

import json
import math
import os
import pathlib
import resource
import shutil
import signal
import subprocess

import children
import jsonschema
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("STICTION_BIN", ROOT / "build/release/stiction"))

pytestmark = pytest.mark.skipif(not PROGRAM.exists(), reason=f"{PROGRAM} does not exist: run `make build`")


def run(*arguments, timeout=120):
    return children.run([PROGRAM, *arguments], limit=timeout, cwd=os.environ.get("TMPDIR", "/tmp"))


def refused(done, *parts):
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    for part in parts:
        assert part in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """A plan of the planar hand, made once."""
    folder = tmp_path_factory.mktemp("plans") / "hand"
    done = run("plan", "planar_hand", "--seed", 0, "-o", folder, "--json")
    assert done.returncode == 0, done.stderr
    return folder / "plan.json"


def task_file(folder, base, **changes):
    path = folder / "task.yaml"
    path.write_text(yaml.safe_dump({"base": str(ROOT / "tasks" / f"{base}.yaml"), **changes}))
    return path


# ---- what works


def test_version_and_help():
    assert run("--version").stdout.startswith("stiction ")
    assert run("--help").returncode == 0
    assert run("plan", "--help").returncode == 0


def test_tasks_lists_every_task():
    done = run("tasks", "--json")
    assert done.returncode == 0
    names = {task["name"] for task in json.loads(done.stdout)["tasks"]}
    assert names == {path.stem for path in (ROOT / "tasks").glob("*.yaml")}
    assert done.stderr.startswith("task "), "the table is for people: beside JSON it goes to stderr"
    assert run("tasks").stdout.startswith("task ") and run("tasks").stderr == ""


def test_plan_json_is_one_object(tmp_path):
    done = run("plan", "planar_hand", "--seed", 1, "-o", tmp_path, "--json")
    figures = json.loads(done.stdout)
    assert {"status", "seed", "wall_s", "iterations", "error", "plan"} <= figures.keys()
    assert figures["status"] == "Solved" and figures["seed"] == 1
    assert pathlib.Path(figures["plan"]) == tmp_path / "plan.json"
    assert "\r" not in done.stderr, "a progress line without a terminal"
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]


def test_first_plan_is_there_while_a_cheaper_one_is_looked_for(tmp_path):
    with children.Child([PROGRAM, "plan", "planar_hand", "--seed", "1", "--anytime", "--timeout", "60", "-o", tmp_path], cwd=tmp_path) as process:
        first = process.line(limit=30)
        assert "plan after" in first
        assert str(tmp_path / "plan.json") in first and "looking for a cheaper one" in first
        assert run("check", tmp_path).returncode == 0, "a whole plan, while the search goes on"
        assert process.poll() is None
        done = process.stop(limit=30)
    assert done.returncode == 130, "ended by a signal, with the best plan"
    assert run("check", tmp_path).returncode == 0


@pytest.mark.parametrize("threads", [1, 2])
def test_plan_profile_says_where_the_processor_time_went(tmp_path, threads):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = run("plan", "allegro_cube", "--seed", 1, "--threads", threads, "-o", tmp_path, "--json", "--profile")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    figures = json.loads(done.stdout)
    profile = figures["profile"]
    in_all = sum(entry["processor_s"] for entry in profile.values())
    assert 0.5 * spent < in_all < spent, "the rest is reading, writing and threads that wait"
    assert profile["grasping"]["calls"] <= figures["regrasps"]["tried"] <= profile["letting_go"]["calls"]
    assert all(entry["processor_s"] > 0 for entry in profile.values() if entry["calls"] > 0)
    table = done.stderr[done.stderr.index("activity ") :].splitlines()[1:]
    assert {line.split()[0] for line in table} == {name for name, entry in profile.items() if entry["calls"] > 0}


@pytest.mark.parametrize("task, published", [("planar_pushing_table_3_2", True), ("planar_hand", False)])
def test_plan_says_that_published_edges_are_not_simulated(tmp_path, task, published):
    """`check` refuses what only the single steps of the thesis reach; `plan` says so before."""
    planned = run("plan", task, "-o", tmp_path)
    assert planned.returncode == 0, planned.stderr
    assert ("as published, not simulated in sub-steps" in planned.stdout) == published
    assert run("check", tmp_path).returncode == (1 if published else 0)
    answer = run("plan", task, "-o", tmp_path, "--json")
    assert json.loads(answer.stdout)["thesis_edges"] == published


def test_plan_file_follows_its_schema(plan):
    schemas = {path.name: json.loads(path.read_text()) for path in (ROOT / "tasks/schema").glob("*.json")}
    from referencing import Registry, Resource

    registry = Registry().with_resources([(name, Resource.from_contents(schema)) for name, schema in schemas.items()])
    for schema in schemas.values():
        jsonschema.Draft202012Validator.check_schema(schema)
    data = json.loads(plan.read_text())
    jsonschema.Draft202012Validator(schemas["plan.schema.json"], registry=registry).validate(data)
    assert plan.stat().st_size < 6e6
    assert str(ROOT) not in plan.read_text(), "an absolute path"

    validator = jsonschema.Draft202012Validator(schemas["task.schema.json"], registry=registry)
    for path in (ROOT / "tasks").glob("*.yaml"):
        task = yaml.safe_load(path.read_text())
        if "base" in task:
            base = yaml.safe_load((path.parent / task.pop("base")).read_text())
            task = merge(base, task)
        validator.validate(task)


def merge(base, over):
    if not isinstance(base, dict) or not isinstance(over, dict):
        return over
    return base | {key: merge(base[key], value) if key in base else value for key, value in over.items()}


def test_check_json_is_one_object(plan):
    done = run("check", plan.parent, "--json")
    report = json.loads(done.stdout)
    assert report["status"] == "Passed" and done.returncode == 0
    assert report["steps"] == 3 * report["knots"] and "iterations" not in report
    names = {item["name"] for item in report["checks"]}
    assert {"goal_position", "goal_angle", "penetration", "joint_limits", "force_cone", "force_gap", "failed_steps"} <= names


def test_own_task_is_found_from_its_plan(tmp_path):
    path = task_file(tmp_path, "planar_hand", name="mine")
    done = run("plan", path, "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("mine, seed 0: solved") and done.stderr == "", "without --json the summary is what `> log` keeps"
    data = json.loads((tmp_path / "out/plan.json").read_text())
    assert data["task"] == {"name": "mine", "builtin": False, "file": "../task.yaml"}
    assert run("check", tmp_path / "out").returncode == 0


def test_goal_of_the_command_line(tmp_path):
    done = run("plan", "planar_hand", "--goal", "0.02 0.35 0.3", "-o", tmp_path)
    assert done.returncode == 0, done.stderr
    goal = json.loads((tmp_path / "plan.json").read_text())["goal"]
    assert goal["position"] == pytest.approx([0, 0.02, 0.35]) and goal["from"] == "command_line"
    assert goal["quaternion_wxyz"][1] == pytest.approx(math.sin(0.15))


def test_same_seed_same_plan_for_any_number_of_threads(tmp_path):
    plans = []
    for threads in (1, 2):
        done = run("plan", "planar_hand", "--seed", 3, "--threads", threads, "-o", tmp_path / str(threads))
        assert done.returncode == 0, done.stderr
        data = json.loads((tmp_path / str(threads) / "plan.json").read_text())
        assert data.pop("timing")["threads"] == threads
        assert len(data.pop("sha256")) == 64
        plans.append(json.dumps(data))
    assert plans[0] == plans[1]


# ---- the budget and interruptions


UNREACHABLE = ("plan", "planar_hand", "--goal", "3 3 0")


def test_unreachable_goal_ends_at_the_timeout_with_the_best_plan(tmp_path):
    done = run(*UNREACHABLE, "--timeout", 1, "-o", tmp_path, "--json")
    assert done.returncode == 3, done.stderr
    assert json.loads(done.stdout)["status"] == "MaxIterations"
    assert json.loads((tmp_path / "plan.json").read_text())["status"] == "MaxIterations"
    assert run("check", tmp_path).returncode == 1


def test_budget_that_ends_before_the_check_or_the_run_is_no_verdict(plan):
    """Codes 0 and 1 are verdicts; a run that did not come to one is not done within its budget."""
    for command in ("check", "simulate"):
        done = run(command, plan, "--timeout", 1e-9, "--json")
        assert done.returncode == 3, done.stderr
        assert json.loads(done.stdout)["status"] == "MaxIterations"


def test_results_lie_in_one_folder(tmp_path):
    """Those of a task in TASK-seedN, those of a plan beside it."""
    for code, *arguments in (
        (0, "plan", "planar_pushing", "--seed", 4),
        (0, "refine", "planar_pushing-seed4", "--seed", 7, "--threads", 1),
        (1, "simulate", "planar_pushing-seed4", "--whole-only", "--speed", 4, "--html"),  # four times the speed of the joints: what is pushed slides on
        (0, "optimize", "impc_planar_hand", "--iterations", 1),
    ):
        done = children.run([PROGRAM, *arguments], cwd=tmp_path)
        assert done.returncode == code, done.stderr
    found = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    pushing, hand = "planar_pushing-seed4", "impc_planar_hand-seed0"
    assert found == {
        *(f"{pushing}/{name}" for name in ("plan.json", "simulation.json", "simulation.html", "refined/plan.json", "refined/trajectory.csv")),
        *(f"{hand}/{name}" for name in ("plan.json", "optimize.json")),
    }


def test_faults_of_the_installation_are_not_mistakes_of_the_caller(plan, tmp_path):
    """The page maker of a program without its Python packages."""
    import shutil

    program = tmp_path / "bin/stiction"
    program.parent.mkdir()
    shutil.copy(PROGRAM, program)
    broken = tmp_path / "share/stiction/python/stiction_view"
    broken.mkdir(parents=True)
    (broken / "__init__.py").write_text("raise RuntimeError('broken')")
    done = children.run([program, "view", plan, "--html", tmp_path / "x.html"])
    assert done.returncode == 70, done.stderr


def test_lint_names_what_is_wrong_and_plan_warns_of_it(tmp_path):
    path = task_file(tmp_path, "planar_pushing", start={"joints": [0.0, 0.05]})
    done = run("lint", path, "--json")
    assert done.returncode == 1, done.stderr
    report = json.loads(done.stdout)
    assert [finding["kind"] for finding in report["findings"]] == ["overlap"]
    message = report["findings"][0]["message"]
    assert "overlap by" in message and "box" in message and "ball" in message
    planned = run("plan", path, "--timeout", 1e-3, "-o", tmp_path / "out", "--json")
    assert f"stiction: warning: {message}" in planned.stderr and json.loads(planned.stdout)["warnings"] == [message]
    clean = run("lint", "planar_pushing")
    assert clean.returncode == 0 and clean.stdout == "planar_pushing: nothing found\n"


def test_view_of_a_task_shows_it_before_it_is_planned(tmp_path):
    page = tmp_path / "task.html"
    done = run("view", task_file(tmp_path, "planar_hand"), "--html", page)
    assert done.returncode == 0, done.stderr
    assert page.stat().st_size > 10_000
    assert "<td>status</td><td>not planned</td>" in page.read_text()
    assert not list(tmp_path.glob("*.json"))
    run("plan", "allegro_ball", "--timeout", 1e-9, "-o", tmp_path / "short")
    assert json.loads((tmp_path / "short" / "plan.json").read_text())["statistics"]["iterations"] == 0
    assert run("view", tmp_path / "short", "--html", page).returncode == 0
    assert "<td>status</td><td>MaxIterations</td>" in page.read_text(), "a search, though its time was over before its first iteration"
    run("plan", "planar_pushing", "--timeout", 1e-9, "-o", tmp_path / "still")
    done = run("view", tmp_path / "still", "--html", page)
    assert (done.returncode, "plan.json: segments: got no knots, expected a plan that moves" in done.stderr) == (2, True), done.stderr
    assert run("view", "planar_hnd").returncode == 2


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_run_keeps_the_best_plan(interrupted, tmp_path, number):
    done = interrupted(*UNREACHABLE, "--timeout", 60, "-o", tmp_path, "--json", after=3, number=number)
    assert done.returncode == 130, done.stderr
    assert json.loads(done.stdout)["status"] == "Cancelled"
    assert json.loads((tmp_path / "plan.json").read_text())["status"] == "Cancelled"
    assert run("check", tmp_path, "--json").returncode == 1


# ---- mistakes: one clear message, exit code 2


@pytest.mark.parametrize(
    "arguments, parts",
    [
        ((), ("subcommand",)),
        (("fly",), ("'fly'", "plan")),
        (("plan",), ("task",)),
        (("plan", "planar_hnd"), ("'planar_hnd'", "did you mean 'planar_hand'")),
        (("plan", "no/such.yaml"), ("no/such.yaml",)),
        (("plan", "planar_hand", "--seed", "-1"), ("--seed",)),
        (("plan", "planar_hand", "--timeout", "0"), ("--timeout",)),
        (("plan", "planar_hand", "--threads", "-2"), ("--threads",)),
        (("refine", "plan.json", "--seed", "x"), ("--seed", "'x'")),
        (("simulate", "plan.json", "--timeout", "-1"), ("--timeout",)),
        (("plan", "planar_hand", "--goal", "1 2"), ("goal", "2 numbers", "3")),
        (("plan", "planar_hand", "--goal", "1 2 x"), ("--goal", "'x'", "a number")),
        (("plan", "planar_hand", "--goal", "1 2 nan"), ("goal", "nan", "finite")),
        (("plan", "allegro_ball", "--goal", "0 0 0"), ("goal", "6 (x y z roll pitch yaw of 'ball')")),
        (("check", "no/such/plan"), ("no/such/plan",)),
        (("view", "no/such/plan"), ("no/such/plan",)),
        (("bench", "--filter", "no such row"), ("--filter", "no such row")),
        (("bench", "--repeat", "0"), ("--repeat",)),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)
def test_wrong_command_lines(arguments, parts):
    refused(run(*arguments), *parts)


def test_json_also_when_refused():
    done = run("plan", "planar_hnd", "--json")
    assert done.returncode == 2
    assert json.loads(done.stdout)["status"] == "InvalidInput"
    assert "planar_hnd" in json.loads(done.stdout)["message"]


@pytest.mark.parametrize(
    "base, changes, parts",
    [
        ("planar_hand", {"goals": {}}, ("task.yaml:", "goals", "unknown key")),
        ("planar_hand", {"planner": {"goal_bais": 1}}, ("planner.goal_bais", "did you mean 'goal_bias'")),
        ("planar_hand", {"planner": {"thesis": {"gamma": "much"}}}, ("planner.thesis.gamma", "'much'", "a number")),
        ("planar_hand", {"planner": {"thesis": {"h": float("inf")}}}, ("planner.thesis.h", "finite")),
        ("planar_hand", {"planner": {"advanced": {"single_step": True}}}, ("planner.advanced.single_step", "`thesis`", "docs/options.md")),
        ("planar_hand", {"tolerance": {"angle": float("nan")}}, ("tolerance.angle", "finite")),
        ("planar_hand", {"start": {"joints": [0, 0, 0, 9]}}, ("start.joints", "joint_2 = 9", "joint limits")),
        ("planar_hand", {"start": {"joints": {"left/elbow": 0}}}, ("left/elbow",)),
        ("planar_hand", {"goal": {"objects": {"left": {"coordinates": [0, 0, 0]}}}}, ("goal.objects",)),
        ("planar_hand", {"goal": {"objects": {"ball": {"coordinates": [0, 0]}}}}, ("goal.objects.ball.coordinates", "3 numbers")),
        ("allegro_ball", {"start": {"objects": {"ball": {"quaternion_wxyz": [1, 1, 1, 1]}}}}, ("quaternion_wxyz", "unit quaternion")),
        ("allegro_ball", {"scene": {"gravity": [0, 0]}}, ("scene.gravity", "3 numbers")),
        ("allegro_ball", {"scene": {"robots": [{"name": "hand", "urdf": "gone.urdf", "stiffness": 1}]}}, ("scene.robots[0].urdf", "gone.urdf")),
        ("allegro_ball", {"scene": {"robots": [{"name": "hand", "urdf": "task.yaml", "stiffness": 1}]}}, ("task.yaml",)),
        ("planar_pushing", {"scene": {"robots": [{"name": "hand", "urdf": str(ROOT / "models/planar_pusher.urdf"), "stiffness": -1}]}}, ("stiffness", "-1")),
        (
            "planar_pushing",
            {"scene": {"objects": [{"name": "box", "joint": "planar_yz", "mass": -5, "shapes": [{"box": {"size": [1, 1, 1]}}]}]}},
            ("scene.objects[0].mass", "-5"),
        ),
    ],
    ids=lambda value: json.dumps(value)[:60] if isinstance(value, dict) else None,
)
def test_wrong_task_files(tmp_path, base, changes, parts):
    refused(run("plan", task_file(tmp_path, base, **changes), "-o", tmp_path / "out"), *parts)
    assert not (tmp_path / "out/plan.json").exists()


def test_mesh_that_is_missing(tmp_path):
    (tmp_path / "robot.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"><collision><geometry><mesh filename="gone.stl"/></geometry></collision></link>'
        '<joint name="j" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    path = task_file(tmp_path, "planar_pushing", scene={"robots": [{"name": "hand", "urdf": "robot.urdf", "stiffness": 1}]})
    refused(run("plan", path, "-o", tmp_path / "out"), "gone.stl")


def test_output_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("x")
    refused(run("plan", "planar_hand", "-o", tmp_path / "file" / "out"), str(tmp_path / "file"))


def edited(plan, folder, change):
    data = json.loads(plan.read_text())
    change(data)
    (folder / "plan.json").write_text(json.dumps(data))
    return folder


def set_item(*path_and_value):
    *path, key, value = path_and_value

    def change(data):
        for step in path:
            data = data[step]
        data[key] = value

    return change


@pytest.mark.parametrize(
    "change, parts",
    [
        (set_item("format_version", 2), ("format_version", "2")),
        (set_item("format", "x"), ("format",)),
        (lambda data: data.pop("segments"), ("segments",)),
        (set_item("extra", 1), ("extra",)),
        (set_item("segments", 0, "knots", 0, "u", [1.0]), ("segments[0].knots[0].u", "1 numbers", "4")),
        (set_item("scene_text", "nothing"), ("scene_sha256",)),
        (set_item("task", "file", "planar_pushing.yaml"), ("scene_sha256", "planar_pushing")),
        (set_item("task", "file", "../../x.yaml"), ("task.file",)),
        (set_item("joints", ["a", "b", "c", "d"]), ("joints[0]", "'a'")),
        (set_item("options", "goal_bias", 4), ("options.goal_bias", "4")),
        (set_item("geometries", 0, "friction", 100.0), ("geometries[0]", "friction")),
        (set_item("geometries", 1, "position", [0, 0, 0.3]), ("geometries[1]", "pose")),
        (set_item("geometries", 0, "shape", {"type": "sphere", "radius": 0.001}), ("geometries[0]", "shape")),
    ],
)
def test_plan_files_that_are_not_read(plan, tmp_path, change, parts):
    refused(run("check", edited(plan, tmp_path, change)), "plan.json", *parts)


def test_truncated_plan_file(plan, tmp_path):
    text = plan.read_text()
    (tmp_path / "plan.json").write_text(text[: len(text) // 2])
    refused(run("check", tmp_path), "plan.json", "only part of it")


def last_contact_knot(data):
    return [knot for segment in data["segments"] for knot in segment["knots"] if knot["contacts"]][-1]


def forge_command(data):
    data["segments"][-1]["knots"][0]["u"][0] += 0.02


def forge_state(data):
    data["segments"][-1]["knots"][0]["objects"][0]["coordinates"][0] += 0.005


def forge_force(data):
    contact = max(last_contact_knot(data)["contacts"], key=lambda c: sum(f * f for f in c["force"]))
    contact["force"] = [-10 * f for f in contact["force"]]


def remove_knots(data):
    del data["segments"][-1]


def move_goal(data):
    data["goal"]["position"][1] += 0.03


def any_contact(data):
    return last_contact_knot(data)["contacts"][0]


EDITS = [
    forge_command,
    forge_state,
    forge_force,
    remove_knots,
    move_goal,
    lambda data: any_contact(data).update(friction=100.0),
    lambda data: any_contact(data).update(gap=-0.5),
    lambda data: any_contact(data)["point"].__setitem__(0, 1.0),
    set_item("options", "h", 10.0),
    set_item("statistics", "failed_steps", 77),
    set_item("statistics", "regrasps", "tried", 1000),
    set_item("status", "MaxIterations"),
    set_item("seed", 12345),
    set_item("timing", "wall_s", 0.001),
    set_item("code_version", "9.9.9"),
    set_item("tree", 0, "object", [0.0, 0, 0, 1, 0, 0, 0]),
    set_item("step", "contact_margin", 0.5),
    set_item("goal", "from", "command_line"),
]


@pytest.mark.parametrize("change", EDITS)
def test_forged_plans_fail_the_check(plan, tmp_path, change):
    before = {item["name"] for item in json.loads(run("check", plan, "--json").stdout)["checks"] if not item["pass"]}
    done = run("check", edited(plan, tmp_path, change), "--json")
    assert done.returncode == 1, done.stderr
    report = json.loads(done.stdout)
    assert report["status"] == "Failed"
    assert {item["name"] for item in report["checks"] if not item["pass"]} - before, "no check fails that did not fail before"


def test_releases_of_a_cube_on_a_palm_are_stable(tmp_path):
    done = run("plan", "allegro_cube", "--seed", 0, "-o", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    regrasps = json.loads(done.stdout)["regrasps"]
    assert regrasps["in_plan"] > 0 and regrasps["unstable"] == 0
    assert "\n  unstable" not in done.stderr
    report = json.loads(run("check", tmp_path, "--json").stdout)
    assert next(item["value"] for item in report["checks"] if item["name"] == "unstable_releases") == 0


def test_contacts_of_plans_by_coulombs_law_stay_closed(tmp_path):
    """Of a thing pushed over a table: it slides in every plan, by how much is up to the search."""
    gaps = opened = 0.0
    for seed in range(3):
        done = run("plan", "ur5_mesh_push", "--seed", seed, "-o", tmp_path / "out", "--json")
        assert done.returncode == 0, done.stderr
        report = json.loads(run("check", tmp_path / "out", "--json").stdout)
        assert report["status"] == "Passed"
        gaps += next(item["value"] for item in report["checks"] if item["name"] == "force_gap")
        data = json.loads((tmp_path / "out/plan.json").read_text())
        assert data["step"]["friction_law"] == "coulomb"
        data["step"]["friction_law"] = "anitescu"
        (tmp_path / "forged.json").write_text(json.dumps(data))
        report = json.loads(run("check", tmp_path / "forged.json", "--json").stdout)
        assert {"dynamics", "stored_position"} <= {item["name"] for item in report["checks"] if not item["pass"]}
        opened += next(item["value"] for item in report["checks"] if item["name"] == "force_gap")
    assert gaps < 0.2 * opened, "anitescu, the same commands: a contact opens by μ times what it slides"


def test_start_in_penetration_is_planned_from_the_projected_state(tmp_path):
    path = task_file(tmp_path, "planar_pushing", start={"joints": [0.0, 0.05]})
    done = run("plan", path, "--goal", "0 0.55 0", "--timeout", 20, "-o", tmp_path / "out", "--json")
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert figures["start_projected"] and figures["start_penetration"] > 0.01
    kinds = [segment["kind"] for segment in json.loads((tmp_path / "out/plan.json").read_text())["segments"]]
    assert kinds[0] == "settle"


@pytest.mark.parametrize("rows", ["cone/22dof_20contacts", "residual/rays_4", "discriminate/", "contact_qp/3", "contact_estimate/"])
def test_bench_prints_the_agreed_object(rows):
    done = run("bench", "--filter", rows, "--repeat", 1, "--json")
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert list(data) == ["machine", "commit", "results"] and data["results"]
    for row in data["results"]:
        assert list(row) == ["name", "median_s", "p95_s", "p99_s", "published_s", "peer_s", "ratio", "allocations", "contacts"]
        assert row["median_s"] > 0


def test_bench_without_its_program_says_what_to_do(tmp_path):
    """A wheel carries `stiction` alone."""
    alone = tmp_path / "stiction"
    shutil.copy2(PROGRAM, alone)
    done = subprocess.run([alone, "bench", "--json"], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert done.returncode == 70
    assert str(tmp_path / "stiction-bench") in done.stderr and "make bench" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert json.loads(done.stdout)["status"] == "Error"


def test_bench_passes_its_words_on():
    done = run("bench", "--help")
    assert done.returncode == 0 and "--filter" in done.stdout and "--repeat" in done.stdout
    done = run("bench", "--repeat", 0, "--json")
    assert done.returncode == 2 and json.loads(done.stdout)["status"] == "InvalidInput"
    assert "--repeat" in done.stderr
    done = run("bench", "--repetitions", 3, "--json")
    assert done.returncode == 2 and json.loads(done.stdout)["status"] == "InvalidInput"
    assert "--repetitions" in done.stderr and "`stiction bench --help`" in done.stderr


def test_bench_times_steps_of_a_task(tmp_path):
    path = task_file(tmp_path, "planar_pushing").rename(tmp_path / "mine.yaml")
    done = run("bench", "--task", path, "--task", "planar_pushing", "--filter", "step_exact/", "--repeat", 1, "--json")
    assert done.returncode == 0, done.stderr
    rows = {row["name"]: row for row in json.loads(done.stdout)["results"]}
    assert list(rows) == [f"step_exact/{task}{warm}" for task in ("mine", "planar_pushing") for warm in ("", "/warm")]
    assert rows["step_exact/mine"]["contacts"] == rows["step_exact/planar_pushing"]["contacts"]
    assert rows["step_exact/mine/warm"]["allocations"] == 0
    refused(run("bench", "--task", tmp_path / "other.yaml"), "other.yaml")
