"""`stiction refine`: the new plan passes the checker, its timed commands keep the speed limits, mistakes are named."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import yaml


@pytest.fixture(scope="module")
def refined(stiction, real_plan: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("refined")
    done = stiction("refine", real_plan, "-o", folder, "--json")
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 1
    return folder, json.loads(done.stdout)


def test_refined_plan_passes_the_checker(stiction, refined: tuple[Path, dict]) -> None:
    folder, out = refined
    assert {"status", "seed", "wall_s", "steps", "variant", "pushes", "regrasps", "knots", "error", "plan"} <= out.keys()
    done = stiction("check", folder, "--json")
    assert done.returncode == 0, done.stderr
    item = next(check for check in json.loads(done.stdout)["checks"] if check["name"] == "regrasp_contact")
    assert item["value"] == 0 and item["limit"] == 0


def test_timed_commands_go_from_rest_to_rest_with_torques_of_the_springs(refined: tuple[Path, dict]) -> None:
    folder, out = refined
    with open(folder / "trajectory.csv", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    table = np.array(rows, dtype=float)
    plan = json.loads((folder / "plan.json").read_text())
    n = len(plan["joints"])
    assert header == ["time_s", *plan["joints"], *(f"torque_{joint}" for joint in plan["joints"])]
    assert np.all(np.diff(table[:, 0]) > 0) and table[-1, 0] == pytest.approx(out["duration_s"])
    speed = np.diff(table[:, 1 : n + 1], axis=0) / np.diff(table[:, 0])[:, None]
    assert np.abs(speed[[0, -1]]).max() < 0.3 * np.abs(speed).max(), "from rest to rest: what is pushed is damped"
    end = plan["segments"][-1]["knots"][-1]
    assert table[-1, 1 : n + 1] == pytest.approx(end["u"])
    stretch = np.subtract(end["u"], end["joints"])
    assert np.all(table[-1, n + 1 :] * stretch >= 0) and np.count_nonzero(stretch) == np.count_nonzero(table[-1, n + 1 :])


def test_same_plan_same_file(stiction, real_plan: Path, refined: tuple[Path, dict], tmp_path: Path) -> None:
    assert stiction("refine", real_plan, "-o", tmp_path).returncode == 0
    a, b = (json.loads((folder / "plan.json").read_text()) for folder in (refined[0], tmp_path))
    for data in (a, b):  # the digest is also of the times
        del data["timing"], data["sha256"]
    assert a == b


def test_plan_that_is_none_is_refused(stiction, real_plan: Path, tmp_path: Path) -> None:
    plan = json.loads(real_plan.read_text())
    plan["status"] = "MaxIterations"
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    done = stiction("refine", tmp_path)
    assert done.returncode == 2 and "status" in done.stderr and "MaxIterations" in done.stderr
    assert not (tmp_path / "refined").exists()
    missing = stiction("refine", tmp_path / "nothing.json")
    assert missing.returncode == 2 and "nothing.json" in missing.stderr


def test_refined_plans_keep_every_promise_at_a_small_step(stiction, tmp_path: Path) -> None:
    refined = 0
    for seed in range(4):
        plan = tmp_path / str(seed)
        assert stiction("plan", "planar_hand", "--seed", seed, "-o", plan).returncode == 0
        done = stiction("refine", plan, "-o", plan / "refined", "--json")
        assert done.returncode == 0, done.stderr
        out = json.loads(done.stdout)
        assert out["h"] <= 0.02 or out["variant"] == "unchanged"
        refined += out["variant"] != "unchanged"
        done = stiction("check", plan / "refined", "--json")
        assert done.returncode == 0, done.stderr
        values = {check["name"]: check["value"] for check in json.loads(done.stdout)["checks"]}
        assert values["penetration"] <= 1
        assert values["joint_limits"] == 0
        assert values["regrasp_contact"] == 0, "fingers that move touch nothing before the end"
    assert refined >= 2, "most plans can be refined"


def test_where_a_push_fails_after_a_wide_regrasp_a_narrower_one_is_taken(stiction, root: Path, tmp_path: Path) -> None:
    """In small steps nothing comes of these plans, and at the steps of the plan the first clearance that holds is not always one for the push after it."""
    least = []
    (tmp_path / "task.yaml").write_text(f"base: {root}/tasks/planar_hand_fixed_y.yaml\nplanner: {{margins: true}}\n")
    for seed in (1, 3):
        plan = tmp_path / str(seed)
        assert stiction("plan", tmp_path / "task.yaml", "--seed", seed, "--timeout", 120, "-o", plan).returncode == 0
        done = stiction("refine", plan, "-o", plan / "refined", "--json")
        assert done.returncode == 0, done.stderr
        out = json.loads(done.stdout)
        assert stiction("check", plan / "refined").returncode == 0
        if out["variant"] != "unchanged":
            least.append(out["least_clearance"])
    length = 0.07746  # L of the fingers (L.1), of which RefineOptions::clearances are 0.2, 0.1, 0.05 and 0.02
    assert least and 0.02 * length * (1 - 1e-4) <= min(least) < 0.2 * length


def hardest_brace(plan: dict) -> float:
    """Largest normal force [N] of the robot on itself or on what does not move, in pushes."""
    robot_or_fixed = {i for i, geometry in enumerate(plan["geometries"]) if not geometry["name"].startswith("bucket/")}
    contacts = [c for segment in plan["segments"] if segment["kind"] == "contact" for knot in segment["knots"] for c in knot["contacts"]]
    normal = lambda c: sum(n * f for n, f in zip(c["normal"], c["force"]))
    return max((abs(normal(c)) for c in contacts if {c["a"], c["b"]} <= robot_or_fixed), default=0)


def test_arms_do_not_lean_on_each_other(stiction, root: Path, tmp_path: Path) -> None:
    """A push ends before the robot presses on itself harder than with five times the weight of the bucket of 0.5 kg."""
    for seed in range(3):
        done = stiction("plan", "iiwa_bimanual", "--seed", seed, "-o", tmp_path)
        assert done.returncode == 0, done.stderr
        assert hardest_brace(json.loads((tmp_path / "plan.json").read_text())) <= 5 * 0.5 * 9.81 * 1.01
