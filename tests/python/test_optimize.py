"""`stiction optimize`: results, files that view and check read, exit codes, messages."""

import json
import os
import pathlib
import sys

import children
import numpy as np
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "build/release/python"))
PROGRAM = pathlib.Path(os.environ.get("STICTION_BIN", ROOT / "build/release/stiction"))


def run(*words):
    return children.run([PROGRAM, *words], limit=120)


def test_result_file_and_json_agree_and_check_reads_the_plan(tmp_path):
    done = run("optimize", "impc_planar_pushing", "-o", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    assert out == json.loads((tmp_path / "optimize.json").read_text())
    assert out["status"] == "Solved" and out["iterations"] == 10 and len(out["history"]) == 11
    totals = [entry["cost"]["total"] for entry in out["history"]]
    assert totals == sorted(totals, reverse=True)
    assert out["error"]["position"] < out["tolerance"]["position"]
    checked = json.loads(run("check", tmp_path, "--json").stdout)
    values = {item["name"]: item for item in checked["checks"]}
    for name in ("start", "goal", "dynamics", "error", "stored_position", "stored_force", "joint_limits", "command_limits"):
        assert values[name]["pass"], name


def test_threads_do_not_change_the_result(tmp_path):
    outs = []
    for threads in (1, 2):
        done = run("optimize", "impc_planar_hand", "--iterations", 2, "--threads", threads, "-o", tmp_path / str(threads), "--json")
        outs.append(json.loads(done.stdout)["cost"])
    assert outs[0] == outs[1]


def test_no_time_keeps_the_guess_and_exits_3(tmp_path):
    done = run("optimize", "impc_planar_pushing", "--timeout", "1e-9", "-o", tmp_path, "--json")
    assert done.returncode == 3
    out = json.loads(done.stdout)
    assert out["status"] == "MaxIterations" and out["iterations"] == 0
    assert (tmp_path / "plan.json").exists()


@pytest.mark.parametrize(
    "change, text",
    [
        ({"forces": {"rays": 3}}, "forces.rays: got 3"),
        ({"forces": {}, "solver": "receding"}, "forces: got the receding solver"),
        ({"horizon": 0}, "optimize.horizon"),
        ({"analytic": {"kappa": 0}}, "optimize.analytic.kappa"),
        ({"weights": {"input": -1}}, "weights.R[0]: got -1"),
        ({"weights": {"objects": {"bax": 1}}}, "'bax'"),
        ({"weights": {"objects": {"box": [1, 2]}}}, "optimize.weights.objects.box"),
        ({"input_bound": 0}, "input_bound: got 0"),
        ({"scheme": "smooth"}, "scheme: got 'smooth'"),
        ({"randomized_first": {"samples": 0}}, "optimize.randomized_first.samples"),
        ({"horizn": 3}, "horizn"),
        ({"regularisation": {"epsilon": 1, "ratio": 1}}, "either 'ratio' or 'epsilon'"),
    ],
    ids=str,
)
def test_mistakes_are_named(tmp_path, change, text):
    path = tmp_path / "task.yaml"
    path.write_text(yaml.safe_dump({"base": str(ROOT / "tasks/impc_planar_pushing.yaml"), "optimize": change}))
    done = run("optimize", path, "-o", tmp_path / "out")
    assert done.returncode == 2
    assert text in done.stderr


def test_task_without_the_section_and_unknown_scheme(tmp_path):
    done = run("optimize", "planar_hand", "-o", tmp_path)
    assert done.returncode == 2 and "no section 'optimize'" in done.stderr
    done = run("optimize", "impc_planar_hand", "--scheme", "magic", "-o", tmp_path)
    assert done.returncode == 2 and "randomized-zeroth" in done.stderr


def test_zeroth_order_without_disturbed_states_goes_without_A(tmp_path):
    for scheme, use_A in (("randomized-zeroth", False), ("randomized-first", True)):
        done = run("optimize", "impc_planar_pushing", "--scheme", scheme, "--iterations", 1, "-o", tmp_path, "--json")
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["options"]["use_A"] is use_A


# ---- Python


def test_module_gives_what_the_program_gives(tmp_path):
    st = pytest.importorskip("stiction")
    task = st.load_task("impc_planar_hand")
    seen = []
    result = st.optimize(task, iterations=2, on_progress=lambda p: seen.append(p.iteration))
    assert result.status == st.Status.Solved and seen == [1, 2]
    assert result.q.shape == (21, task.model.n_q) and result.u.shape == (20, task.model.n_a)
    program = json.loads(run("optimize", "impc_planar_hand", "--iterations", 2, "-o", tmp_path, "--json").stdout)
    assert result.cost.total == program["cost"]["total"]
    assert [entry.best for entry in result.history] == [entry["best"] for entry in program["history"]]


def test_module_names_mistakes_and_stops_at_an_error_of_the_caller():
    st = pytest.importorskip("stiction")
    task = st.load_task("impc_planar_pushing")
    with pytest.raises(ValueError, match="scheme: got 'magic'"):
        st.optimize(task, scheme="magic")
    with pytest.raises(ValueError, match="forces: got the receding solver"):
        st.optimize(task, solver="receding", forces=True)
    with pytest.raises(ValueError, match="no section 'optimize'"):
        st.optimize(st.load_task("planar_hand"))
    with pytest.raises(ZeroDivisionError):
        st.optimize(task, on_progress=lambda p: 1 / 0)


def test_a_first_guess_in_contact_gives_exact_gradients_something_to_follow():
    st = pytest.importorskip("stiction")
    task = st.load_task("impc_planar_hand")
    apart = st.optimize(task, scheme="exact")
    assert apart.cost.total == apart.history[0].cost.total  # no finger touches, so that no command changes anything
    touching = task.q_start[3:] + 0.08 * np.array([-1, -1, 1, 1])
    found = st.optimize(task, scheme="exact", u_guess=np.tile(touching, (20, 1)))
    assert found.cost.total < 0.1 * apart.cost.total
    with pytest.raises(st.InvalidInput, match=r"u_guess.shape\[0\].*19.*20"):
        st.optimize(task, u_guess=np.tile(touching, (19, 1)))
