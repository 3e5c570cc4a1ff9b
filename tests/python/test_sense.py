"""`stiction sense`: built-in scenarios find their contact, series are read, mistakes are named."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path

import jsonschema
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = json.loads((ROOT / "tasks/schema/sensing.schema.json").read_text())
SCENARIOS = [path for path in sorted((ROOT / "scenarios").glob("*.yaml")) if "sensing" in yaml.safe_load(path.read_text())]


def sense(program: Path, scenario: str | Path) -> tuple[int, dict]:
    done = subprocess.run([program, "sense", str(scenario), "--json"], capture_output=True, text=True, timeout=120)
    return done.returncode, json.loads(done.stdout)


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_built_in_scenarios_follow_the_schema_and_find_their_contact(program: Path, path: Path) -> None:
    jsonschema.Draft202012Validator(SCHEMA).validate(yaml.safe_load(path.read_text()))
    code, out = sense(program, path.stem)
    assert code == 0 and out["status"] == "Explained"
    # Behind three joints points of contact fill a patch, of which every sample is one: they lie 2 cm apart.
    assert out["moments"][0]["distance"] < (0.03 if path.stem == "ur5_forearm" else 0.01)


def series(tmp_path: Path, lines: list[str]) -> Path:
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_forearm.yaml").read_text())
    del scenario["joints"], scenario["contact"]
    scenario["series"] = "series.csv"
    (tmp_path / "series.csv").write_text("\n".join(lines))
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    return tmp_path / "scenario.yaml"


def test_series_has_one_answer_a_line(program: Path, tmp_path: Path) -> None:
    still = "0,-1.2,1.6,-1.97,-1.57,0"
    code, out = sense(program, series(tmp_path, ["t,q,tau", f"0,{still},0,0,0,0,0,0", f"0.01,{still},3,4,-2,0,0,0"]))
    assert code == 0
    assert [moment["t"] for moment in out["moments"]] == [0, 0.01]
    assert out["moments"][0]["verdict"] == "BelowThreshold"
    for candidate in out["moments"][1]["candidates"]:
        assert math.isclose(math.hypot(*candidate["f_L"]), math.hypot(*candidate["f_W"]), rel_tol=1e-9)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "series.csv: series: got no line of numbers"),
        (["0,1,2"], "series.csv:1: series: got 3 numbers, expected 13 finite numbers"),
        (["0" + ",0" * 12, "0" + ",0" * 12], "series.csv:2: series: got time 0 after 0, expected times that increase"),
        (["0" + ",0" * 12, "1" + ",nan" * 12], "series.csv:2: series: got '1,nan"),
    ],
    ids=["empty", "too few", "repeated time", "not finite"],
)
def test_mistakes_in_a_series_are_named(program: Path, tmp_path: Path, lines: list[str], message: str) -> None:
    code, out = sense(program, series(tmp_path, lines))
    assert code == 2 and message in out["message"]


def test_force_that_pulls_is_refused(program: Path, tmp_path: Path) -> None:
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_forearm.yaml").read_text())
    scenario["contact"]["force"] = [100, 0, 0]
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    code, out = sense(program, tmp_path / "scenario.yaml")
    assert code == 2 and "outside the friction cone" in out["message"]


def test_two_contacts_are_named_together(program: Path) -> None:
    code, out = sense(program, "ur5_two_contacts")
    assert code == 0
    sets = out["moments"][0]["contact_sets"]
    assert sets["verdict"] == "Explained" and sets["contacts"] == 2
    links = [[contact["link"] for contact in group["contacts"]] for group in sets["groups"]]
    assert ["arm/upper_arm_link", "arm/wrist_3_link"] in links
    best = sets["groups"][links.index(["arm/upper_arm_link", "arm/wrist_3_link"])]
    assert best["freedom"] == 0 and all(contact["point_is_unique"] for contact in best["contacts"])


def test_torques_alone_of_two_contacts_are_ambiguous(program: Path, tmp_path: Path) -> None:
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_two_contacts.yaml").read_text())
    del scenario["base_wrench"]
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    code, out = sense(program, tmp_path / "scenario.yaml")
    sets = out["moments"][0]["contact_sets"]
    assert code == 0 and sets["ambiguous"] and sets["contacts"] == 2
    assert all(group["freedom"] >= 4 for group in sets["groups"]), "six torques, ten numbers"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"sensing": {"max_contacts": 4}}, "max_contacts: got 4, expected an integer from 1 to 3"),
        ({"sensing": {"max_contacts": 2, "rays": 0}}, "rays: got 0 (the exact cone)"),
        ({"contact": {"link": "arm/forearm_link", "point": [0, 0, 0], "force": 1}}, "expected one of the two"),
        ({"contacts": []}, "contacts: got a list of 0, expected at least one contact"),
        ({"base_wrench": {"force": [0, 0, 1]}}, "force"),
        ({"base_wrench": {"moment_noise": 0}}, "moment_noise: got 0"),
    ],
    ids=["four", "exact cone", "both", "none", "given and computed", "no noise"],
)
def test_mistakes_about_several_contacts_are_named(program: Path, tmp_path: Path, change: dict, message: str) -> None:
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_two_contacts.yaml").read_text())
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario | change))
    code, out = sense(program, tmp_path / "scenario.yaml")
    assert code == 2 and message in out["message"]
