"""`stiction simulate`: one JSON object, the file, the page, exit codes, interruptions, repeatability."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import browser

FAST = ("--speed", 2)


@pytest.fixture(scope="module")
def simulated(stiction, real_plan: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("simulation")
    done = stiction("simulate", real_plan, *FAST, "--html", "--json", "-o", folder)
    assert done.returncode == 1, done.stderr
    assert len(done.stdout.splitlines()) == 1
    (folder / "stdout.json").write_text(done.stdout)
    return folder


def test_json_is_one_object_with_an_error_per_piece(simulated: Path) -> None:
    out = json.loads((simulated / "stdout.json").read_text())
    assert {"status", "seed", "wall_s", "steps", "reached", "error", "max_penetration", "dropped", "pieces"} <= out.keys()
    assert out["status"] == "Missed" and not out["reached"], "at twice the speed of the joints what is pushed slides on"
    assert out["pieces"]
    for piece in out["pieces"]:
        assert piece["begin_s"] < piece["end_s"]
        assert (piece["alone"] is None) == (piece["kind"] == "regrasp")
        error = piece["in_plan"]
        if error["length_position"] >= 1e-4:
            assert error["normalised_position"] == pytest.approx(error["mean_position"] / error["length_position"])
        else:
            assert error["normalised_position"] is None
    document = json.loads((simulated / "simulation.json").read_text())
    assert document["format"] == "stiction-simulation" and document["report"]["pieces"] == out["pieces"]
    assert "simulation.html" in {path.name for path in simulated.iterdir()}


def test_exit_code_says_whether_the_goal_was_reached(stiction, real_plan: Path, tmp_path: Path) -> None:
    """The goal of the file moved away by a metre: nothing can reach it, and the poses of the run do not change."""
    done = stiction("simulate", real_plan, *FAST, "--json")
    assert done.returncode == (0 if json.loads(done.stdout)["reached"] else 1)
    plan = json.loads(real_plan.read_text())
    plan["goal"]["position"][1] += 1.0
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    missed = stiction("simulate", tmp_path, *FAST, "--json")
    assert missed.returncode == 1
    a, b = json.loads(done.stdout), json.loads(missed.stdout)
    assert b["status"] == "Missed" and b["error"]["position"] > 0.5
    assert a["pieces"] == b["pieces"], "equal runs give equal numbers"


def test_one_step_per_edge_predicts_something_else_for_the_same_run(stiction, real_plan: Path, simulated: Path) -> None:
    out = json.loads(stiction("simulate", real_plan, *FAST, "--sub-steps", 1, "--json").stdout)
    before = json.loads((simulated / "stdout.json").read_text())
    assert out["prediction_substeps"] == 1
    assert out["error"]["position"] == pytest.approx(before["error"]["position"], rel=1e-6), "the run is the same"
    moved = [p["in_plan"]["mean_position"] for p in out["pieces"] if p["kind"] == "contact"]
    assert moved != [p["in_plan"]["mean_position"] for p in before["pieces"] if p["kind"] == "contact"]


def test_interrupted_run_says_so(interrupted, real_plan: Path, tmp_path: Path) -> None:
    done = interrupted("simulate", real_plan, "--speed", 0.01, "--json", "-o", tmp_path)
    assert done.returncode == 130, done.stderr
    assert json.loads(done.stdout)["status"] == "Cancelled"
    assert json.loads((tmp_path / "simulation.json").read_text())["report"]["status"] == "Cancelled"


@pytest.mark.parametrize(
    "arguments, parts",
    [
        (("nowhere.json",), ("nowhere.json",)),
        (("PLAN", "--speed", "0"), ("--speed",)),
        (("PLAN", "--sub-steps", "0"), ("--sub-steps",)),
        (("BROKEN",), ("not JSON",)),
    ],
)
def test_mistakes_have_one_clear_message(stiction, real_plan: Path, tmp_path: Path, arguments: tuple, parts: tuple) -> None:
    broken = tmp_path / "broken.json"
    broken.write_text(real_plan.read_text()[:2000])
    done = stiction("simulate", *({"PLAN": real_plan, "BROKEN": broken}.get(word, word) for word in arguments))
    assert done.returncode == 2 and done.stdout == ""
    assert all(part in done.stderr for part in parts), done.stderr


def blue(picture: np.ndarray) -> float:
    """Share of bluish pixels: the ghost of the plan."""
    r, g, b = np.moveaxis(picture.astype(float), 2, 0)
    return float(((b - r > 25) & (b > 120)).mean())


def test_page_draws_plan_and_run_over_each_other(simulated: Path) -> None:
    page = simulated / "simulation.html"
    assert page.stat().st_size < 10_000_000
    with browser.Browser() as window:
        window.open(page)
        window.wait_for(lambda: window.evaluate("!!document.querySelector('.mantine-Slider-track')"), 120, "the time bar")
        text = window.evaluate("document.getElementById('stiction').innerText")
        assert "planned" in text and "simulated" in text and "open loop" in text
        window.evaluate("document.getElementById('stiction').style.display = 'none'")

        def ghost() -> bool:
            window.scrub(0.25)
            return blue(window.screenshot()[:-90]) > 0.002

        window.wait_for(ghost, 180, "the ghost of the plan")
        assert not window.errors and not [url for url in window.requests if url.startswith("http")]


def test_page_of_a_bad_simulation_is_refused(simulated: Path, real_plan: Path, tmp_path: Path) -> None:
    from stiction_view import InvalidPlan
    from stiction_view.overlay import load_simulation

    document = json.loads((simulated / "simulation.json").read_text())
    for change, message in (
        ({"format": "other"}, "format: got 'other'"),
        ({"format_version": 7}, "format_version: got 7"),
        ({"frames": []}, "frames: none"),
        ({"frames": [{**document["frames"][0], "bodies": []}]}, "bodies of shape"),
        ({"frames": [{**document["frames"][0], "torque": [0.0]}]}, "torque of shape"),
    ):
        file = tmp_path / "simulation.json"
        file.write_text(json.dumps({**document, **change}))
        with pytest.raises(InvalidPlan, match=message):
            load_simulation(real_plan, file)
