"""`stiction touch`: an arm that feels its way, its report, its page, and what it refuses."""

from __future__ import annotations

import base64
import json
import re
import subprocess
from pathlib import Path

import children
import numpy as np
import pytest
import yaml

import browser
import pictured
from stiction_view import InvalidPlan
from stiction_view.touch import load_touch, tube

ROOT = Path(__file__).resolve().parents[2]
SCENARIO = "reach_past_pillar"


def run(program: Path, *words: object) -> subprocess.CompletedProcess[str]:
    return children.run([program, "touch", *words], limit=300)


@pytest.fixture(scope="module")
def reached(program: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict, dict]:
    """The page, what the program prints with --json, and the data of the page."""
    file = tmp_path_factory.mktemp("touch") / "page.html"
    done = run(program, SCENARIO, "--seed", 0, "--html", file, "--json")
    assert done.returncode == 0, done.stderr
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', file.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    return file, json.loads(done.stdout), json.loads(found.group(1))


def floats(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def test_arm_is_touched_plans_anew_and_reaches_its_goal(reached: tuple[Path, dict, dict]) -> None:
    _, out, _ = reached
    assert out["status"] == "Passed" and out["goal_error"] <= 0.01
    assert len(out["touches"]) >= 1 and len(out["routes"]) == len(out["touches"]) + 1
    assert all(route["found"] for route in out["routes"])
    assert out["routes"][0]["postures"] == 2, "it knows of nothing in its way"
    assert out["routes"][-1]["travel"] > 0
    assert out["settled_peak"] <= 1.2 * out["lambda_max"] <= out["peak_force"] * 10


def test_page_shows_balls_and_routes_from_when_they_were_known(reached: tuple[Path, dict, dict]) -> None:
    file, out, page = reached
    assert file.stat().st_size < 8_000_000
    times, frames = np.array(page["times"]), len(page["times"])
    timed = [mesh for mesh in page["meshes"] if "frames" in mesh]
    balls = [mesh for mesh in timed if mesh["alpha"] < 1]
    assert len(balls) == len(out["touches"])
    for ball, touch in zip(balls, out["touches"]):
        first, last = ball["frames"]
        assert last == frames and times[first] >= touch["time_s"] > times[first - 1]
        points = floats(ball["points"]).reshape(-1, 3)
        centre = np.array(touch["p_W"]) - touch["radius"] * np.array(touch["n_W"])
        np.testing.assert_allclose(np.linalg.norm(points - centre, axis=1), touch["radius"] + touch["spread"], rtol=1e-3)
    routes = [mesh["frames"] for mesh in timed if mesh["alpha"] == 1]
    assert [r[0] for r in routes] == [int(np.searchsorted(times, r["time_s"])) for r in out["routes"]]
    assert [r[1] for r in routes] == [r[0] for r in routes[1:]] + [frames], "one route at a time"
    assert all(mesh["mark"] for mesh in timed) and not any("as" in mesh for mesh in page["meshes"])


def test_page_of_an_arm_with_pictures_has_them_and_the_same_marks(program: Path, tmp_path: Path, reached: tuple[Path, dict, dict]) -> None:
    done = run(program, pictured.of(SCENARIO, tmp_path), "--seed", 0, "--html", tmp_path / "page.html")
    assert done.returncode == 0, done.stderr
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', (tmp_path / "page.html").read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    page = json.loads(found.group(1))
    pictured.check(page)
    marks, before = ([mesh["points"] for mesh in data["meshes"] if mesh.get("mark")] for data in (page, reached[2]))
    assert len(marks) == len(before) and page["arrows"] == reached[2]["arrows"], "pictures change nothing of what is felt"


def test_plots_of_the_page_are_the_figures_of_the_program(reached: tuple[Path, dict, dict]) -> None:
    _, out, page = reached
    forces, left = page["plots"][:2]
    lines = {line["name"]: floats(line["values"]) for line in forces["lines"]}
    measured = [values for name, values in lines.items() if name not in ("felt", "λ_max")]
    assert max(values.max() for values in measured) == pytest.approx(out["peak_force"], rel=1e-5)
    assert lines["felt"].max() > 5, "the arm feels its contact"
    assert floats(left["lines"][0]["values"])[-1] == pytest.approx(out["goal_error"], abs=1e-3)


@browser.needed
def test_page_is_drawn_and_balls_appear(reached: tuple[Path, dict, dict]) -> None:
    file, _, page = reached
    first = max(mesh["frames"][0] for mesh in page["meshes"] if "frames" in mesh)
    with browser.Browser() as window:
        window.open(file)
        window.wait_for(lambda: window.evaluate("document.body !== null && document.body.dataset.drawn === '1'"), 90, "the drawing")
        assert "nothing in its way" in window.evaluate("document.querySelector('#stiction table').textContent")
        for frame in (0, first):
            window.evaluate(f"s = document.getElementById('slider'); s.value = {frame}; s.dispatchEvent(new Event('input'))")
        assert "touched" in window.evaluate("document.querySelector('#stiction table').textContent")
        picture = window.screenshot().astype(int)
        assert ((picture[..., 2] > 120) & (picture[..., 0] < picture[..., 2] - 30)).mean() > 1e-3, "a ball is drawn"
        assert window.errors == [] and [u for u in window.requests if not u.startswith(("file:", "data:"))] == []


def test_tube_surrounds_its_line() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 2, 0]], dtype=float)
    corners = tube(points, 0.1)
    assert corners.shape == (2 * 2 * 6, 3, 3)
    first = corners[:12].reshape(-1, 3)
    np.testing.assert_allclose(np.hypot(first[:, 1], first[:, 2]), 0.1, atol=1e-12)


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"format": "stiction-control"}, "format: got 'stiction-control', expected 'stiction-touch'"),
        ({"format": "stiction-touch", "format_version": 1}, "field 'bodies' is missing"),
    ],
)
def test_bad_document_is_refused_by_file_and_field(tmp_path: Path, document: dict, message: str) -> None:
    file = tmp_path / "page.json"
    file.write_text(json.dumps(document))
    with pytest.raises(InvalidPlan) as caught:
        load_touch(file)
    assert str(caught.value).startswith(f"{file}: ") and message in str(caught.value)


@pytest.mark.parametrize(
    ("words", "said"),
    [(["nowhere.yaml"], "nowhere.yaml"), (["box_in_the_way"], "a scenario of control, expected a scenario of touch"), ([SCENARIO, "--tolerance", "-1"], "--tolerance"), ([], "scenario")],
)
def test_bad_input_is_named_and_exits_with_2(program: Path, words: list[str], said: str) -> None:
    done = run(program, *words)
    assert done.returncode == 2 and said in done.stderr


def test_budget_exits_with_3(program: Path) -> None:
    done = run(program, SCENARIO, "--timeout", "1e-6", "--json")
    assert done.returncode == 3 and json.loads(done.stdout)["status"] == "MaxIterations"


# ---- moves until something is felt ----


def test_moves_end_where_the_table_is_felt_and_their_page_shows_them(program: Path, tmp_path: Path) -> None:
    file = tmp_path / "moves.html"
    done = run(program, "lower_until_touch", "--seed", 1, "--html", file, "--json")
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    assert out["status"] == "Passed" and [move["outcome"] for move in out["moves"]] == ["Felt", "Arrived", "Arrived", "Arrived", "Felt"]
    first = out["moves"][0]
    (felt,) = first["felt"]
    assert felt["link"] == "arm/link_7" and felt["probability"] > 0.9 and felt["direction_W"][2] > 0.9
    assert first["contact_s"] <= felt["alarm_s"] < felt["time_s"] <= first["end_s"]
    assert abs(first["correction"]) > 0.003 and abs(first["correction_error"]) < 0.003
    assert 4 <= first["last_force"] <= first["late_peak"] <= 6
    assert "Felt" in done.stderr and "table moved by" in done.stderr
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', file.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None and json.loads(found.group(1))["title"] == "lower_until_touch"
    assert run(program, "lower_until_touch", "--seed", 1, "--tolerance", 0).returncode == 1, "forces are judged against what was asked for"


def test_moves_that_feel_nothing_are_not_done(program: Path, tmp_path: Path) -> None:
    text = (ROOT / "scenarios" / "close_hand.yaml").read_text(encoding="utf-8")
    text = text.replace("../models", str(ROOT / "models")).replace("posture: [0, -0.005, 0.005]", "posture: [0, -0.055, 0.055]")
    (tmp_path / "short.yaml").write_text(text, encoding="utf-8")
    done = run(program, tmp_path / "short.yaml", "--json")
    assert done.returncode == 3
    out = json.loads(done.stdout)
    assert out["status"] == "GaveUp" and out["message"] == "close: 'hand/left' felt nothing" and out["moves"][0]["felt"] == []


def scenario(name: str) -> dict:
    return yaml.safe_load((ROOT / "scenarios" / f"{name}.yaml").read_text(encoding="utf-8"))


def test_mug_is_lowered_until_it_stands(program: Path) -> None:
    done = run(program, "lower_mug", "--seed", 2, "--json")
    out = json.loads(done.stdout)
    assert done.returncode == 0 and out["status"] == "Passed", out["message"]
    down, again = out["moves"][0], out["moves"][-1]
    assert down["felt"][0]["link"] == again["felt"][0]["link"] == "arm/mug"
    assert abs(down["correction"]) > 0.01 and abs(down["correction_error"]) < 1e-3 and abs(again["correction"]) < 1e-3


def test_friction_of_joints_is_felt_as_if_it_were_a_touch(program: Path, tmp_path: Path) -> None:
    """Dry friction of 0.3 N m, with which wrist torques of a few mN m are nothing; and none of it where no joint is said to have any."""
    text = scenario("lower_until_touch")
    urdf = (ROOT / "models/iiwa7_balls.urdf").read_text(encoding="utf-8")
    (tmp_path / "stiff.urdf").write_text(re.sub(r'(type="revolute">)', r'\1<dynamics friction="0.3" damping="0"/>', urdf), encoding="utf-8")
    text["scene"]["robots"][0]["urdf"] = "stiff.urdf"
    text["moves"] = text["moves"][:1]
    outcomes = {}
    for friction in (False, True):
        (tmp_path / "variant.yaml").write_text(yaml.safe_dump(text | {"name": "variant", "plant": {"joint_friction": friction}}), encoding="utf-8")
        outcomes[friction] = json.loads(run(program, tmp_path / "variant.yaml", "--seed", 1, "--json").stdout)
    assert outcomes[False]["status"] == "Passed"
    assert outcomes[True]["status"] == "GaveUp" and outcomes[True]["moves"][0]["outcome"] == "WrongLink"
