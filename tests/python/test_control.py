"""`stiction control`: scenarios of contact-aware control, judged by their forces."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import children
import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = [path for path in sorted((ROOT / "scenarios").glob("*.yaml")) if "\nreference:" in path.read_text()]


def run(program: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return children.run([program, "control", *words], limit=300)


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda path: path.stem)
def test_scenarios_keep_their_forces_bounded_where_tracking_alone_does_not(program: Path, scenario: Path) -> None:
    done = run(program, str(scenario), "--json")
    assert done.returncode == 0, done.stderr
    ours = json.loads(done.stdout)
    assert ours["bounded_s"] > 1 and ours["bound_error"] <= 2 and ours["bound_p95"] <= 1.2 * ours["lambda_max"] and ours["unsolved_ticks"] == 0
    assert ours["above_ticks"] <= 0.01 * ours["settled_ticks"], "single ticks alone"
    # What is above the bound by more than a fifth came in a tick, and not by the command.
    assert ours["settled_peak"] <= 1.2 * ours["lambda_max"] or ours["commanded_rise"] < 0.1 * ours["peak_rise"]
    done = run(program, str(scenario), "--law", "unconstrained", "--json")
    assert done.returncode == 1, done.stderr
    tracking = json.loads(done.stdout)
    assert tracking["status"] == "Failed" and tracking["mean_force"] > 2 * ours["mean_force"]
    assert ours["peak_force"] <= (1 + 1e-9) * tracking["peak_force"], "up to rounding both laws come in alike"


def test_run_whose_contacts_are_all_too_short_to_be_judged_does_not_pass(program: Path) -> None:
    done = run(program, "box_in_the_way", "--law", "unconstrained", "--settle", "20", "--json")
    result = json.loads(done.stdout)
    assert (done.returncode, result["status"], result["settled_ticks"]) == (1, "Failed", 0) and result["peak_force"] > result["lambda_max"]
    assert "no contact lasted as long as --settle, so no force was judged" in done.stderr


def test_samples_have_a_line_a_tick(program: Path, tmp_path: Path) -> None:
    done = run(program, str(SCENARIOS[0]), "-o", str(tmp_path), "--json")
    assert done.returncode == 0, done.stderr
    lines = (tmp_path / "control.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + round(json.loads(done.stdout)["duration_s"] / 0.005)
    assert len({line.count(",") for line in lines}) == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere.yaml"], "nowhere.yaml"),
        ([str(SCENARIOS[0]), "--lambda-max", "0"], "--lambda-max"),
        ([str(SCENARIOS[0]), "--law", "magic"], "--law"),
        ([str(SCENARIOS[0]), "--friction", "-1"], "--friction"),
        ([], "scenario"),
    ],
)
def test_bad_input_is_named_and_exits_with_2(program: Path, words: list[str], said: str) -> None:
    done = run(program, *words)
    assert done.returncode == 2 and said in done.stderr


def test_budget_exits_with_3(program: Path) -> None:
    assert run(program, str(SCENARIOS[0]), "--timeout", "1e-6").returncode == 3
