"""What the studio does behind its page: files that are dropped, tasks that are changed, options, figures, faults, jobs."""

from __future__ import annotations

import contextlib
import io
import json
import logging
import os
import re
import shlex
import shutil
import socket
import sys
import threading
import zipfile
from pathlib import Path

import children
import numpy as np
import pytest

PYTHON = Path(__file__).resolve().parents[2] / "build" / "release" / "python"
if not (PYTHON / "stiction").is_dir():
    pytest.skip("build/release/python/stiction does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(PYTHON))

import stiction as st  # noqa: E402

from stiction_view.plan import rotation_matrices  # noqa: E402
from stiction_view.studio import catalog, exporting, faults, form, problem, results, series, texts, uploads  # noqa: E402
from stiction_view.studio.growing import Trees, farthest_axis  # noqa: E402
from stiction_view.studio.jobs import Job, Worker  # noqa: E402
from stiction_view.studio.own_scene import ObjectSpec, make_spec  # noqa: E402
from stiction_view.studio.picture import Pictures, quaternions  # noqa: E402
from stiction_view.studio.problem import Problem  # noqa: E402
from stiction_view.studio.server import PortTaken, check_port, serving  # noqa: E402

ROBOT = b"""<robot name="pusher"><link name="base"/><link name="tip"><collision><geometry>%s</geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="tip"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="50"/></joint></robot>"""
BALL = b'<sphere radius="0.03"/>'


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    q = rng.normal(size=4)
    return rotation_matrices((q / np.linalg.norm(q))[None])[0]


# ---- files that are dropped ----


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("robot.zip", b"PK\x03\x04rest", "got a file of type '.zip', expected a URDF"),
        ("robot.urdf", b"PK\x03\x04rest", "robot.urdf: got a zip archive, expected a URDF"),
        ("arm.stl", b"\x1f\x8b\x08rest", "got a gzip archive"),
        ("../robot.urdf", ROBOT % BALL, "got a name with a path"),
        ("a/b.urdf", ROBOT % BALL, "got a name with a path"),
        ("run.py", b"print(1)", "got a file of type '.py'"),
        ("robot", b"x", "got a file of type 'nothing'"),
        ("robot.urdf", b"", "got an empty file"),
        ("robot.urdf", b"<robot", "no XML"),
        ("robot.urdf", b'<!DOCTYPE r [<!ENTITY a "b">]><robot/>', "got a document type or entities"),
        ("mesh.dae", b'<!doctype r SYSTEM "file:///etc/passwd"><COLLADA/>', "got a document type"),
        ("big.stl", b"0" * (uploads.MAX_BYTES + 1), "got 20 MB, expected at most 20 MB"),
    ],
)
def test_files_that_are_not_taken(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    kept = uploads.Uploads(tmp_path)
    with pytest.raises(uploads.Refused) as caught:
        kept.add(name, content)
    assert message in str(caught.value)
    assert kept.contents == {} and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "path", ["../mesh.stl", "/etc/mesh.stl", "package://../mesh.stl", "package://robots/../../mesh.stl", "file:///etc/mesh.stl", "~/mesh.stl", "http://host/mesh.stl", "a\\mesh.stl"]
)
def test_robot_that_reads_outside_is_refused_and_leaves_nothing(tmp_path: Path, path: str) -> None:
    kept = uploads.Uploads(tmp_path)
    kept.add("mesh.stl", b"solid")
    with pytest.raises(uploads.Refused, match="expected a path below the file"):
        kept.add("robot.urdf", ROBOT % b'<mesh filename="%s"/>' % path.encode())
    assert kept.robots() == [] and list(tmp_path.iterdir()) == []
    kept.add("good.urdf", ROBOT % BALL)
    assert kept.write_robot("good.urdf").is_file(), "what was refused is not in the way of the next one"


def test_mjcf_that_reads_outside_or_includes_is_refused(tmp_path: Path) -> None:
    kept = uploads.Uploads(tmp_path)
    for text, message in (
        ('<compiler meshdir="../meshes"/>', "without '..'"),
        ('<include file="other.xml"/>', "expected one file that holds the whole robot"),
        ('<compiler meshdir="/root"/><asset><mesh file="a.stl"/></asset>', "expected a path below"),
    ):
        with pytest.raises(uploads.Refused, match=re.escape(message)):
            kept.add("robot.xml", f"<mujoco>{text}</mujoco>".encode())
    assert list(tmp_path.iterdir()) == []


def test_robot_waits_for_its_meshes_and_is_written_with_them(tmp_path: Path) -> None:
    kept = uploads.Uploads(tmp_path)
    kept.add("robot.urdf", ROBOT % b'<mesh filename="package://arm/meshes/tip.stl"/>')
    assert kept.missing("robot.urdf") == ["tip.stl"]
    with pytest.raises(uploads.Refused, match="names tip.stl, which was not dropped"):
        kept.write_robot("robot.urdf")
    kept.add("tip.stl", b"solid tip\nendsolid")
    file = kept.write_robot("robot.urdf")
    assert (tmp_path / "arm" / "meshes" / "tip.stl").read_bytes() == b"solid tip\nendsolid"
    assert b'filename="arm/meshes/tip.stl"' in file.read_bytes(), "an installed package of that name is not looked for"


def test_materials_of_an_obj_are_not_looked_for(tmp_path: Path) -> None:
    kept = uploads.Uploads(tmp_path)
    kept.add("cup.obj", b"mtllib ../../secret.mtl\nv 0 0 0\n")
    assert b"mtllib" not in kept.write_mesh("cup.obj").read_bytes()


def test_dropped_robot_and_shapes_become_a_task(tmp_path: Path) -> None:
    kept = uploads.Uploads(tmp_path)
    kept.add("pusher.urdf", ROBOT % BALL)
    robot = kept.write_robot("pusher.urdf")
    mesh = tmp_path / "wedge.obj"
    mesh.write_text("v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    for thing in (
        ObjectSpec("box", (0.1, 0.2, 0.05), mass=0.5),
        ObjectSpec("cylinder", (0.05, 0.1)),
        ObjectSpec("sphere", (0.05,)),
        ObjectSpec("capsule", (0.02, 0.1)),
    ):
        made = Problem.of_dict(make_spec(robot, thing), tmp_path)
        task = made.task()
        assert task.model.n_a == 1 and task.model.object_names == ["object"]
        found = [f.kind for f in st.lint(task)]
        assert "unsupported" not in found, "it lies on the floor"
        assert task.goal.X_WG.p[1] > 0
    assert task.model.objects[0].mass == pytest.approx(0.1)
    with pytest.raises(st.InvalidInput):
        make_spec(robot, ObjectSpec("box", (0.1, 0.2, float("nan"))))


# ---- geometry ----


def test_quaternions_and_rotation_vectors_come_back() -> None:
    rng = np.random.default_rng(1)
    half_turns = [np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.diag([-1.0, -1, 1])]
    R = np.array([np.eye(3), *half_turns, *(random_rotation(rng) for _ in range(50))])
    np.testing.assert_allclose(rotation_matrices(quaternions(R)), R, atol=1e-12)
    for rotation in R:
        np.testing.assert_allclose(problem.rotation(problem.rpy(rotation)), rotation, atol=1e-12)
        w = problem.rotation_vector(rotation)
        angle = np.linalg.norm(w)
        K = np.cross(np.eye(3), w) if angle else np.zeros((3, 3))
        series_of = np.eye(3) + np.sinc(angle / np.pi) * K + (0.5 * np.sinc(angle / (2 * np.pi)) ** 2) * (K @ K)
        np.testing.assert_allclose(series_of, rotation, atol=1e-7)
    np.testing.assert_allclose(problem.rotation(problem.rpy(problem.rotation([0.3, np.pi / 2, 0.2]))), problem.rotation([0.3, np.pi / 2, 0.2]), atol=1e-9)


@pytest.mark.parametrize("name", ["planar_hand", "planar_pushing", "allegro_cube", "allegro_door"])
def test_poses_of_objects_come_back(name: str) -> None:
    made = Problem.open(name)
    model = made.model
    rng = np.random.default_rng(0)
    for index, info in enumerate(model.objects):
        delta = np.zeros(model.n_v)
        delta[info.v_begin : info.v_begin + info.n_v] = rng.uniform(0.02, 0.1, info.n_v)
        q = model.retract(made.start, delta)
        back = problem.place(model, made.start, index, model.object_pose(q, info.name))
        np.testing.assert_allclose(model.local(back, q), 0, atol=1e-9)
        again = problem.with_numbers(model, made.start, index, problem.numbers_of(model, q, index))
        np.testing.assert_allclose(model.local(again, q)[info.v_begin : info.v_begin + info.n_v], 0, atol=1e-8)


# ---- tasks that are changed ----


def test_unchanged_task_is_that_of_the_command() -> None:
    made = Problem.open("allegro_cube")
    assert made.in_file() and made.task_file() is None
    assert shlex.split(made.command(20))[:5] == ["stiction", "plan", "allegro_cube", "--seed", "0"]
    assert made.task().scene_sha256 == made.given.scene_sha256


def test_goal_start_and_options_are_in_the_task_and_in_what_reproduces_it(tmp_path: Path, stiction) -> None:
    made = Problem.open("allegro_cube")
    X = made.model.object_pose(made.goal, "cube")
    made.set_goal(st.Pose(problem.rotation([0, 0, 0.4]), X.p))
    words = shlex.split(made.command(20))
    assert words[2] == "allegro_cube"
    np.testing.assert_allclose([float(x) for x in words[words.index("--goal") + 1].split()], [-0.065, 0, 0.0411, 0, 0, 0.4], atol=1e-9)

    made.set_joint(3, 0.25)
    made.set_start(0, st.Pose(problem.rotation([0, 0, 0.1]), X.p + [0.001, 0, 0]))
    made.options = form.changed(made.given.options, {**made.given.options.to_dict(), "goal_bias": 0.35, "friction": 0.75})
    task = made.task()
    np.testing.assert_allclose(task.q_start, made.start, atol=1e-9)
    assert problem.rpy(task.goal.X_WG.R)[2] == pytest.approx(0.4)

    file = tmp_path / "task.yaml"
    text = made.task_file()
    assert text is not None
    file.write_text(text)
    again = st.load_task(file)
    np.testing.assert_allclose(again.q_start, made.start, atol=1e-9)
    assert (again.options.goal_bias, again.options.friction) == (0.35, 0.75)
    assert again.scene_sha256 == task.scene_sha256
    words = shlex.split(made.command(20))
    assert words[2] == "task.yaml" and float(words[words.index("--goal") + 1].split()[-1]) == pytest.approx(0.4)
    done = stiction("lint", file, "--goal", words[words.index("--goal") + 1])
    assert done.returncode == 0 and "nothing found" in done.stdout, done.stdout + done.stderr

    made.reset()
    assert made.in_file() and made.task_file() is None


def test_goal_of_a_hinge_stays_inside_its_limits() -> None:
    made = Problem.open("allegro_door")
    names = problem.names_of(made.model, made.goal_object)
    assert len(names) == len(made.goal_numbers()) and all(name.endswith("[rad]") for name in names)
    made.set_goal_numbers([100.0] * len(names))
    made.task()  # takes it


# ---- options ----


def test_fields_are_those_of_the_schema_and_take_the_values_of_the_task() -> None:
    options = st.load_task("allegro_cube").options
    fields = form.fields(options)
    names = [f.name for f in fields]
    assert len(set(names)) == len(names) and set(options.to_dict()) <= set(names) | {"seed", "threads"}
    assert all(f.meaning for f in fields)
    given = options.to_dict()
    values = {f.name: f.read(f.write(given.get(f.name))) for f in fields}
    assert form.changed(options, values) == {}
    bias = next(f for f in fields if f.name == "goal_bias")
    assert (bias.kind, bias.low, bias.high) == ("number", 0, 1)
    assert next(f for f in fields if f.name == "friction_law").choices == ("anitescu", "coulomb")
    assert form.changed(options, {**values, "anytime": True}) == {"anytime": True}
    with pytest.raises(st.InvalidInput, match="goal_bias"):
        form.changed(options, {**values, "goal_bias": 2.0})


# ---- what is at fault, where ----


def test_overlap_is_found_at_its_place_with_its_depth() -> None:
    made = Problem.open("allegro_cube")
    pictures = Pictures(made.model)
    assert [f.kind for f in faults.find(made, pictures)] == []
    X = made.model.object_pose(made.start, "cube")
    made.set_start(0, st.Pose(X.R, X.p - [0, 0, 0.01]))
    overlap = next(f for f in faults.find(made, pictures) if f.kind == "overlap")
    assert overlap.label == "overlap of cube and hand_root: 10 mm" and "cube" in overlap.bodies and not overlap.at_goal
    assert overlap.point is not None and abs(overlap.point[2] - 0.0061) < 0.006, "between the palm and the lowest face"


def test_goal_out_of_reach_and_start_in_the_air_are_found() -> None:
    made = Problem.open("allegro_cube")
    X = made.model.object_pose(made.goal, "cube")
    made.set_goal(st.Pose(X.R, X.p + [1.0, 0, 0]))
    made.set_start(0, st.Pose(X.R, X.p + [0, 0, 0.2]))
    found = {f.kind: f for f in faults.find(made, Pictures(made.model))}
    reach = found["reach"]
    assert reach.at_goal and reach.label.startswith("out of reach: ")
    np.testing.assert_allclose(reach.point, X.p + [1.0, 0, 0])
    air = found["unsupported"]
    gap = float(re.search(r"nothing supports it: ([\d.]+) m$", air.label).group(1))
    assert 0.05 < gap < 0.2 and not air.at_goal and air.point is not None, "less than it was lifted: fingers are nearer than the palm"


# ---- figures ----


@pytest.fixture(scope="module")
def planned() -> results.Result:
    task = st.load_task("planar_pushing")
    out = st.plan(task, seed=0, timeout_s=200)
    assert out.status == st.Status.Solved
    return results.make_result(1, out.plan, Pictures(task.model), Problem.open("planar_pushing").command(20), None, out.reason, out.wall_s)


def test_series_are_recomputed_from_the_plan(planned: results.Result) -> None:
    plan, model = planned.plan, planned.plan.task.model
    q, u = plan.q[1:], plan.u[1:]
    np.testing.assert_allclose(planned.series.torque, model.stiffness * (u - q[:, model.n_qu :]), atol=1e-12)
    assert len(planned.drawn.poses) == len(q)
    pressed = np.isfinite(planned.series.friction_use)
    assert pressed.any() and planned.series.friction_use[pressed].max() <= 1 + 1e-4, "forces stay in their cones"
    assert "%" in planned.series.line(int(np.flatnonzero(pressed)[0]))


def test_friction_use_of_a_known_force() -> None:
    contact = {"force": [0.3, 0.0, 1.0], "normal": [0, 0, 1], "friction": 0.5, "gap": 0.002}
    knot = {"u": [0.2], "joints": [0.1], "contacts": [contact]}
    free = {"u": [0.2], "joints": [0.2], "contacts": []}
    scene = "- {name: arm/a, lower: -1, upper: 1, stiffness: 10, effort: 4}\n"
    made = series.make_series({"joints": ["arm/a"], "geometries": [], "scene_text": scene, "segments": [{"knots": [knot, free]}]})
    np.testing.assert_allclose(made.friction_use[0], 0.6)
    np.testing.assert_allclose(made.force[0], np.sqrt(1.09))
    np.testing.assert_allclose(made.effort_share(), [0.25, 0.0], atol=1e-12)
    assert np.isnan(made.friction_use[1]) and "nothing touches" in made.line(1)
    assert "**motors** 25.0 % of their effort (arm/a)" in made.line(0) and "max_force" not in made.line(0)


def test_fragile_thing_is_in_the_figures_of_a_knot() -> None:
    contact = {"a": 0, "b": 1, "force": [0.0, 0.3, -1.5], "normal": [0, 0, -1], "friction": 0.5, "gap": 0.0}
    knots = [{"u": [0.2], "joints": [0.1], "contacts": contacts} for contacts in ([contact], [])]
    scene = "- {name: arm/a, lower: -1, upper: 1, stiffness: 10}\n- {name: egg/shell, shape: {sphere: 0.02}, pose: {p: [0, 0, 0]}, friction: 1, max_force: 6}\n"
    made = series.make_series({"joints": ["arm/a"], "geometries": [{"name": "arm/tip/ball"}, {"name": "egg/shell"}], "scene_text": scene, "segments": [{"knots": knots}]})
    assert "no motor has a limit" in made.line(0) and np.isnan(made.effort_share()).all()
    assert "**max_force** 25.0 % (arm/tip/ball – egg/shell: 1.5 of 6 N)" in made.line(0)
    assert "**max_force** 0.0 %, nothing touches" in made.line(1)
    np.testing.assert_allclose(made.press_share(), [0.25, 0.0])


def test_everything_holds_what_the_program_reads(planned: results.Result, tmp_path: Path, stiction) -> None:
    name, content = exporting.export(planned, exporting.EVERYTHING)
    assert name == "planar_pushing-seed0.zip"
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        motions = {"motion.csv", "motion.contacts.csv", "motion.npz", "motion.json", "motion.mcap"}
        assert set(archive.namelist()) == {"plan.json", "plan.html", "reproduce.txt", *motions}
        archive.extractall(tmp_path)
    done = stiction("check", tmp_path / "plan.json")
    assert done.returncode == 0, done.stdout + done.stderr
    text = (tmp_path / "reproduce.txt").read_text()
    assert st.version() in text and "stiction plan planar_pushing --seed 0" in text
    lines = (tmp_path / "motion.csv").read_text().splitlines()
    assert len(lines) == 1 + len(st.make_trajectory(planned.plan).times) == 1 + len(np.load(tmp_path / "motion.npz")["time"])
    again = st.plan(st.load_task("planar_pushing"), seed=planned.plan.seed, timeout_s=200).plan
    np.testing.assert_array_equal(again.q, planned.plan.q)


def run_in_shell(text: str, program: Path, folder: Path) -> None:
    done = children.run(["bash", "-e"], input=text, cwd=folder, limit=300, env={**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"})
    assert done.returncode == 0, done.stdout + done.stderr


def test_text_that_reproduces_gives_the_same_plan_in_a_shell(tmp_path: Path, program: Path) -> None:
    made = Problem.open("planar_pushing")
    made.set_start_numbers(0, [0.05, 0.0, 0.1])
    made.set_goal_numbers([0.1, 0.3, 0.2])
    made.options, made.seed = {"goal_bias": 0.4}, 3
    out = st.plan(made.task(), options=made.options, seed=made.seed, timeout_s=200)
    result = results.make_result(1, out.plan, Pictures(made.model), made.command(200), made.task_file(), out.reason, out.wall_s)
    run_in_shell(exporting.reproduce(result), program, tmp_path)
    again = st.read_plan(tmp_path / "out" / "plan.json")
    np.testing.assert_array_equal(again.q, out.plan.q)
    np.testing.assert_array_equal(again.u, out.plan.u)


def test_task_of_a_dropped_robot_is_whole_in_another_folder(tmp_path: Path) -> None:
    (home := tmp_path / "uploads").mkdir()
    kept = uploads.Uploads(home)
    kept.add("pusher.urdf", ROBOT % BALL)
    made = Problem.of_dict(make_spec(kept.write_robot("pusher.urdf"), ObjectSpec("box", (0.1, 0.2, 0.05))), home)
    digest, text = made.task().scene_sha256, made.task_file()
    assert text is not None and "pusher.urdf" in made.files()
    shutil.rmtree(home)
    (tmp_path / "task.yaml").write_text(text)
    assert st.load_task(tmp_path / "task.yaml").scene_sha256 == digest


def test_report_of_a_problem_has_the_plan_and_no_folder_of_this_machine(planned: results.Result) -> None:
    name, content = exporting.export(planned, exporting.REPORT)
    assert name.endswith("-report.zip")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        found = {file: archive.read(file).decode() for file in archive.namelist()}
    assert json.loads(found["report.json"])["tried"]["seed"] == planned.plan.seed and json.loads(found["plan.json"])["seed"] == planned.plan.seed
    assert str(Path(__file__).resolve().parents[2]) not in "".join(found.values())


def test_one_format_is_one_file_and_what_is_missing_is_named(planned: results.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    name, content = exporting.export(planned, "json")
    assert name == "planar_pushing-seed0-motion.json" and json.loads(content)["format"] == "stiction-motion"
    name, content = exporting.export(planned, "csv")  # contacts are in a file of their own
    assert name == "planar_pushing-seed0-csv.zip" and zipfile.ZipFile(io.BytesIO(content)).namelist() == ["motion.csv", "motion.contacts.csv"]
    monkeypatch.setitem(sys.modules, "mcap_ros2.writer", None)
    with pytest.raises(st.MissingExtra, match=r"pip install 'stiction\[mcap\]'"):
        exporting.export(planned, "mcap")
    assert b"# left out: " in exporting.files(planned, exporting.EVERYTHING)["reproduce.txt"]


def test_check_of_a_plan_in_words(planned: results.Result) -> None:
    assert results.check(planned) == "**check** passed"


# ---- long work ----


def test_false_of_the_callback_keeps_the_best_path_so_far() -> None:
    seen = []

    def stop(progress: st.Progress) -> bool:
        seen.append(progress.iteration)
        return len(seen) < 3

    out = st.plan(st.load_task("allegro_cube_180"), seed=0, timeout_s=200, on_progress=stop)
    assert out.status == st.Status.Cancelled and len(seen) >= 3 and len(out.plan.q) >= 1


def test_trees_are_told_while_they_grow() -> None:
    task = st.load_task("planar_hand")
    trees = Trees(task.model, task.model.object_names[task.goal.object], 0, 0.1)
    edges = []

    def take(growth: st.Growth) -> None:
        assert growth.q.shape == (len(growth.parents), task.model.n_q) and growth.first + len(growth.parents) > growth.best >= 0
        trees.take(growth)
        edges.append(trees.edges())

    out = st.plan(task, seed=0, timeout_s=200, on_growth=take)
    assert out.status == st.Status.Solved
    np.testing.assert_array_equal(out.plan.q, st.plan(task, seed=0, timeout_s=200).plan.q)
    way, name = trees.way(), trees.name
    first, last = (task.model.object_pose(q, name) for q in (out.plan.q[0], out.plan.q[-1]))
    np.testing.assert_allclose(way[0, 0], first.p + 0.1 * first.R[:, 0], atol=1e-9)
    np.testing.assert_allclose(way[-1, 1], last.p + 0.1 * last.R[:, 0], atol=1e-9)
    np.testing.assert_array_equal(way[1:, 0], way[:-1, 1])
    assert len(np.concatenate(edges)) > 0

    # Of several trees one that is overtaken is told to where it came, and counted to where it would have been: what is told once is seen with one.
    edges.clear()
    trees = Trees(task.model, task.model.object_names[task.goal.object], 0, 0.1)
    out = st.plan(task, seed=0, timeout_s=200, options={"trees": 1}, on_growth=take)
    assert 0 < len(np.concatenate(edges)) <= out.nodes


def test_an_error_in_what_is_told_of_growth_is_that_of_the_call() -> None:
    def fail(_: st.Growth) -> None:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        st.plan(st.load_task("allegro_cube_180"), seed=0, timeout_s=200, on_growth=fail)


def test_axis_that_is_drawn_is_the_one_that_moves() -> None:
    quarter = st.Pose(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([0.0, -0.05, 0.0]))
    assert farthest_axis(st.Pose(np.eye(3), np.zeros(3)), quarter, 0.1) == 1, "the end of y goes back by more than that of x, and z stays where it turns"


def test_worker_runs_one_job_and_says_what_failed() -> None:
    worker, gate, ended = Worker(), threading.Event(), threading.Event()
    done: list[Job] = []

    def finish(job: Job) -> None:
        done.append(job)
        ended.set()

    def wait(job: Job) -> str:
        assert gate.wait(10)
        return "cancelled" if job.cancelled.is_set() else "ran"

    assert worker.start(Job("first", wait, finish))
    assert not worker.start(Job("second", wait, finish)), "one at a time"
    worker.cancel()
    gate.set()
    assert ended.wait(10) and done[0].result == "cancelled" and worker.job is None
    ended.clear()
    assert worker.start(Job("third", lambda _: 1 / 0, finish))
    assert ended.wait(10) and isinstance(done[1].error, ZeroDivisionError)


# ---- what can be opened ----


def test_catalog_has_tasks_and_scenarios_and_the_files_of_a_folder(tmp_path: Path) -> None:
    entries, first = catalog.find(None)
    kinds = {e.source: e.kind for e in entries}
    assert kinds["allegro_cube"] == catalog.TASK and kinds["panda_wrist"] == catalog.SENSE and kinds["box_in_the_way"] == catalog.CONTROL
    assert first is not None and first.kind == catalog.TASK
    root = Path(__file__).resolve().parents[2]
    (tmp_path / "one.yaml").write_text((root / "docs/tutorials/push.yaml").read_text())
    (tmp_path / "two.yaml").write_text((root / "scenarios/ur5_forearm.yaml").read_text())
    own, first = catalog.find(str(tmp_path))
    assert [(e.label, e.kind) for e in own[:2]] == [("one", catalog.TASK), ("two (sense)", catalog.SENSE)] and first == own[0]
    for shown, message in ((str(tmp_path / "none.yaml"), "does not exist"), ("no_such_task", "expected a file, a folder, or one of")):
        with pytest.raises(ValueError, match=message):
            catalog.find(shown)
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match="without .yaml files"):
        catalog.find(str(tmp_path / "empty"))


def test_files_that_are_named_like_a_built_in_task_or_each_other_are_told_apart(tmp_path: Path) -> None:
    file = Path(__file__).resolve().parents[2] / "tasks" / "planar_hand.yaml"
    entries, first = catalog.find(str(file))
    assert first is not None and first.source == file and first.label == "planar_hand"
    assert [e.label for e in entries if e.source == "planar_hand"] == ["planar_hand (built-in)"]
    for name in ("one.yaml", "one.yml", "planar_pushing.yaml"):
        (tmp_path / name).write_text(file.read_text())
    own, _ = catalog.find(str(tmp_path))
    assert [e.label for e in own[:3]] == ["one", "one.yml", "planar_pushing"]
    for some in (entries, own):
        assert len({e.label for e in some}) == len(some), "a list with two of the same leaves the page empty"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("", ""),
        ("<joint> *a* ``b & \\", "\\<joint> \\*a\\* \\`\\`b \\& \\\\"),
        ("![a](b) [c](d) [0, 0.25]", "!\\[a\\](b) [c\\](d) [0, 0.25]"),
        ("`stiction import` of `<a>`", "`stiction import` of \\`\\<a>\\`"),
        ("__init__ _base_ left_arm_2 ~~x~~ ~y~", "\\_\\_init\\_\\_ \\_base\\_ left_arm_2 \\~\\~x\\~\\~ \\~y\\~"),
        ("# x", "\\# x"),
        ("a\n- x\n  + y\n> z", "a\n\\- x\n  \\+ y\n\\> z"),
        ("1. x\n 23) y\n0.5 N\n-5 N", "1\\. x\n 23\\) y\n0.5 N\n\\-5 N"),
        ("a\n===\nb | c\n--- | ---\n|:-:|", "a\n\\===\nb | c\n\\--- | ---\n\\|:-:|"),
        ("a # b - c > d 1. e", "a # b - c > d 1. e"),
    ],
)
def test_text_of_others_is_no_markup(text: str, shown: str) -> None:
    assert texts.plain(text) == shown


# ---- the port ----


def test_port_in_use_is_one_message() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(PortTaken, match=rf"--port: got {port} of 127.0.0.1, which is in use; expected a free one"):
            check_port("127.0.0.1", port)


@pytest.mark.parametrize("sent", [b"", b"GET", b"not HTTP\r\n\r\n"])
def test_browser_that_hangs_up_is_not_logged(sent: bytes, caplog: pytest.LogCaptureFixture) -> None:
    with serving("127.0.0.1", 0) as server:
        with socket.create_connection(("127.0.0.1", server.get_port()), timeout=30) as visitor:
            visitor.sendall(sent)
            visitor.shutdown(socket.SHUT_WR)
            with contextlib.suppress(ConnectionResetError):
                while visitor.recv(4096):  # until the server has dropped it
                    pass
    assert caplog.records == []
    fault = ValueError("of the server")
    logging.getLogger("websockets.server").error("opening handshake failed", exc_info=fault)
    assert [r.exc_info[1] for r in caplog.records if r.exc_info] == [fault]


def test_program_says_what_it_cannot_open(stiction) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        done = stiction("studio", "--port", taken.getsockname()[1])
    assert done.returncode == 2 and "which is in use" in done.stderr and done.stdout == ""
    done = stiction("studio", "no_such_task", "--port", 0)
    assert done.returncode == 2 and "got 'no_such_task'" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert json.dumps(done.stdout) == '""'
