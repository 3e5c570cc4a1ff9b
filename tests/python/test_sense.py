"""`stiction sense`: built-in scenarios find their contact, series are read, mistakes are named."""

from __future__ import annotations

import json
import math
from pathlib import Path

import children
import jsonschema
import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
SCHEMA = json.loads((ROOT / "tasks/schema/sensing.schema.json").read_text())
FILES = {path: yaml.safe_load(path.read_text()) for path in sorted((ROOT / "scenarios").glob("*.yaml"))}
SCENARIOS = [path for path, content in FILES.items() if "sensing" in content and "poke" not in content]
POKED = [path for path, content in FILES.items() if "poke" in content]


NAMES = ",".join(["t", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))])


def sense(program: Path, scenario: str | Path) -> tuple[int, dict]:
    done = children.run([program, "sense", str(scenario), "--json"], limit=120)
    return done.returncode, json.loads(done.stdout)


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: path.stem)
def test_built_in_scenarios_follow_the_schema_and_find_their_contact(program: Path, path: Path) -> None:
    jsonschema.Draft202012Validator(SCHEMA).validate(yaml.safe_load(path.read_text()))
    code, out = sense(program, path.stem)
    assert code == 0 and out["status"] == "Explained"
    # Behind three joints points of contact fill a patch, of which every sample is one: they lie 2 cm apart.
    assert out["moments"][0]["distance"] < (0.03 if path.stem == "ur5_forearm" else 0.01)


@pytest.mark.parametrize("path", POKED, ids=lambda path: path.stem)
def test_pushes_of_a_simulated_robot_are_found_on_their_links(program: Path, path: Path) -> None:
    scenario = FILES[path]
    jsonschema.Draft202012Validator(SCHEMA).validate(scenario)
    code, out = sense(program, path.stem)
    assert code == 0 and len(out["moments"]) == round(scenario["poke"]["duration"] / scenario["poke"]["period"])
    pushes = scenario["poke"]["pushes"]
    for push in pushes:
        settled = [m for m in out["moments"] if push["begin"] + 0.1 < m["t"] <= push["begin"] + push["duration"]]
        found = []
        for m in settled:
            acting = [p["link"] for p in pushes if p["begin"] < m["t"] <= p["begin"] + p["duration"]]
            if len(acting) == 1:
                found.append(push["link"] in [c["link"] for c in m["candidates"] if c["explains"]])
            else:
                found.append(acting in [[c["link"] for c in group["contacts"]] for group in m["contact_sets"]["groups"]])
        assert len(settled) >= 5 and sum(found) >= 0.85 * len(settled), found
    before = [m for m in out["moments"] if m["t"] < min(push["begin"] for push in scenario["poke"]["pushes"])]
    assert all("distance" not in m for m in before) and sum(m["verdict"] == "BelowThreshold" for m in before) >= 0.9 * len(before)


def test_series_of_numpy_is_that_of_a_csv_file(program: Path, tmp_path: Path) -> None:
    tutorial = ROOT / "docs" / "tutorials"
    scenario = yaml.safe_load((tutorial / "touch.yaml").read_text())
    table = np.loadtxt(tutorial / "touch.csv", delimiter=",", skiprows=1)
    arrays = {"t": table[:, 0], "q": table[:, 1:7], "tau": table[:, 7:]}
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario | {"series": "series.npz"}))
    np.savez(tmp_path / "series.npz", **arrays)
    answers = [sense(program, file)[1]["moments"] for file in (tutorial / "touch.yaml", tmp_path / "scenario.yaml")]
    assert [[c["p_W"] for c in m["candidates"]] for m in answers[0]] == [[c["p_W"] for c in m["candidates"]] for m in answers[1]]
    np.savez(tmp_path / "series.npz", **arrays | {"q": np.asfortranarray(arrays["q"]), "tau": arrays["tau"].astype(np.float32)})
    assert [m["verdict"] for m in sense(program, tmp_path / "scenario.yaml")[1]["moments"]] == [m["verdict"] for m in answers[0]]

    def refusal(**change: object) -> str:
        np.savez(tmp_path / "series.npz", **{name: array for name, array in (arrays | change).items() if array is not None})
        return children.run([program, "sense", tmp_path / "scenario.yaml"], limit=60).stderr

    assert "series.npz: series: got no array 'tau', expected t, q and tau" in refusal(tau=None)
    assert "series.npz: series: got q of shape (10, 5), expected (10, 6)" in refusal(q=arrays["q"][:, :5])
    assert "series.npz: series: got t[3] = 0 after 0.1, expected times that increase" in refusal(t=arrays["t"] * (np.arange(10) != 3))
    assert "a number of tau that is not finite" in refusal(tau=arrays["tau"] * np.nan)
    assert "'q' of another type" in refusal(q=arrays["q"].astype(int))
    names = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
    order = np.argsort(names)
    assert "with no 'arm/elbow_joint'" in refusal(joints=["elbow" if name == "elbow_joint" else name for name in names])
    assert "with more than one 'arm/shoulder_pan_joint'" in refusal(joints=["shoulder_pan_joint"] * 6)
    np.savez(tmp_path / "series.npz", t=arrays["t"], q=arrays["q"][:, order], tau=arrays["tau"][:, order], joints=np.array(names)[order])
    by_name = sense(program, tmp_path / "scenario.yaml")[1]["moments"]
    assert [[c["p_W"] for c in m["candidates"]] for m in by_name] == [[c["p_W"] for c in m["candidates"]] for m in answers[0]]
    np.savez_compressed(tmp_path / "series.npz", **arrays)
    assert "which is compressed" in children.run([program, "sense", tmp_path / "scenario.yaml"], limit=60).stderr
    for content in (b"", b"PK", (tmp_path / "series.npz").read_bytes()[:500]):
        (tmp_path / "series.npz").write_bytes(content)
        done = children.run([program, "sense", tmp_path / "scenario.yaml"], limit=60)
        assert done.returncode == 2 and "expected a file of numpy.savez" in done.stderr


def test_lines_that_are_missing_are_said_and_candidates_start_afresh(program: Path, tmp_path: Path) -> None:
    still = "0,-1.2,1.6,-1.97,-1.57,0"
    times = [0, 0.01, 0.02, 0.03, 0.5, 0.51]
    file = series(tmp_path, [NAMES, *(f"{t},{still},3,4,-2,0,0,0" for t in times)])
    done = children.run([program, "sense", file, "--json"], limit=60)
    assert done.returncode == 0 and "no line for 0.47 s before t = 0.500 s" in done.stderr
    moments = json.loads(done.stdout)["moments"]
    points = [[c["p_W"] for c in m["candidates"]] for m in moments]
    assert points[4] == points[0] and points[0]


def series(tmp_path: Path, lines: list[str]) -> Path:
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_forearm.yaml").read_text())
    del scenario["joints"], scenario["contact"]
    scenario["series"] = "series.csv"
    (tmp_path / "series.csv").write_text("\n".join(lines))
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario))
    return tmp_path / "scenario.yaml"


def test_series_has_one_answer_a_line(program: Path, tmp_path: Path) -> None:
    still = "0,-1.2,1.6,-1.97,-1.57,0"
    code, out = sense(program, series(tmp_path, [NAMES, f"0,{still},0,0,0,0,0,0", f"0.01,{still},3,4,-2,0,0,0"]))
    assert code == 0
    assert [moment["t"] for moment in out["moments"]] == [0, 0.01]
    assert out["moments"][0]["verdict"] == "BelowThreshold"
    for candidate in out["moments"][1]["candidates"]:
        assert math.isclose(math.hypot(*candidate["f_L"]), math.hypot(*candidate["f_W"]), rel_tol=1e-9)


def test_columns_of_a_log_are_taken_by_their_names(program: Path, tmp_path: Path) -> None:
    """A log of ROS has its joints in the order of the alphabet."""
    tutorial = ROOT / "docs" / "tutorials"
    scenario = yaml.safe_load((tutorial / "touch.yaml").read_text())
    table = np.loadtxt(tutorial / "touch.csv", delimiter=",", skiprows=1)
    names = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
    order = sorted(range(6), key=lambda j: names[j])
    head = ["__time", *(f"/joint_states/{names[j]}/{what}" for j in order for what in ("effort", "position", "velocity"))]
    lines = [[row[0], *(x for j in order for x in (row[7 + j], row[1 + j], 0))] for row in table]
    (tmp_path / "log.csv").write_text("\n".join(",".join(map(str, line)) for line in [head, *lines]))
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario | {"series": "log.csv"}))
    done = children.run([program, "sense", tmp_path / "scenario.yaml", "--json"], limit=120)
    assert done.returncode == 0 and "columns that are not read: '/joint_states/elbow_joint/velocity'" in done.stderr and "efforts are taken" in done.stderr
    of_the_tutorial = sense(program, tutorial / "touch.yaml")[1]["moments"]
    assert [[c["p_W"] for c in m["candidates"]] for m in json.loads(done.stdout)["moments"]] == [[c["p_W"] for c in m["candidates"]] for m in of_the_tutorial]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "series.csv: series: got no line of numbers"),
        (["0,1,2"], "series.csv:1: series: got 3 numbers, expected 13 finite numbers"),
        (["0" + ",0" * 12, "0" + ",0" * 12], "series.csv:2: series: got time 0 after 0, expected times that increase"),
        (["0" + ",0" * 12, "1" + ",nan" * 12], "series.csv:2: series: got '1,nan"),
        (["0" + ",nan" * 12, "1" + ",0" * 12], "series.csv:1: series: got '0,nan"),
        (["t,q,tau", "0" + ",0" * 12], "series.csv:1: series: got no column for the position of the joint 'arm/shoulder_pan_joint' among 't', 'q', 'tau'"),
    ],
    ids=["empty", "too few", "repeated time", "not finite", "first line not finite", "names of no joint"],
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
        ({"sensing": {"friction": -0.5}}, "scenario.yaml:30: sensing.friction: got -0.5, expected a number ≥ 0"),
        ({"contact": {"link": "arm/forearm_link", "point": [0, 0, 0], "force": 1}}, "expected one of the two"),
        ({"contacts": []}, "contacts: got a list of 0, expected at least one contact"),
        ({"base_wrench": {"force": [0, 0, 1]}}, "force"),
        ({"base_wrench": {"moment_noise": 0}}, "moment_noise: got 0"),
    ],
    ids=["four", "exact cone", "friction", "both", "none", "given and computed", "no noise"],
)
def test_mistakes_about_several_contacts_are_named(program: Path, tmp_path: Path, change: dict, message: str) -> None:
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_two_contacts.yaml").read_text())
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario | change))
    code, out = sense(program, tmp_path / "scenario.yaml")
    assert code == 2 and message in out["message"]


@pytest.mark.parametrize("name", ["ur5_forearm", "ur5_two_contacts", "panda_poked"])
def test_rest_and_sign_of_torques_that_are_computed_are_refused(program: Path, tmp_path: Path, name: str) -> None:
    scenario = FILES[ROOT / "scenarios" / f"{name}.yaml"]
    for key, value in (("sign", -1), ("rest", {"seconds": [0, 1]}), ("rest", {})):
        (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario | {"sensing": scenario["sensing"] | {key: value}}), encoding="utf-8")
        done = children.run([program, "sense", tmp_path / "scenario.yaml"])
        assert done.returncode == 2 and f"sensing.{key}: got '{key}' of torques that are computed from contacts" in done.stderr, done.stderr
    for words in (["--turn"], ["--rest", "0", "1"]):
        done = children.run([program, "sense", name, *words])
        assert done.returncode == 2 and f"{words[0]}: got a scenario whose torques are computed from contacts" in done.stderr, done.stderr


def test_noise_of_the_command_line_stands_for_that_of_rest(program: Path, tmp_path: Path) -> None:
    """Of few rows the threshold is larger than four deviations; a given noise is no estimate."""
    scenario = yaml.safe_load((ROOT / "scenarios/ur5_forearm.yaml").read_text())
    del scenario["joints"], scenario["contact"]
    scenario |= {"series": "series.csv", "sensing": {"rest": {"rows": [0, 4]}, "noise": "rest"}}
    random = np.random.default_rng(0)
    rows = [[0.1 * k, 0, -1.2, 1.6, -1.97, -1.57, 0, *random.normal(0, 0.05, 6)] for k in range(5)]
    (tmp_path / "series.csv").write_text("\n".join([NAMES, *(",".join(map(str, row)) for row in rows)]), encoding="utf-8")
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(scenario), encoding="utf-8")
    done = children.run([program, "sense", tmp_path / "scenario.yaml", "--noise", "0.5", "--json"])
    assert done.returncode == 0, done.stderr
    assert [moment["largest"]["threshold"] for moment in json.loads(done.stdout)["moments"]] == pytest.approx([2.0] * 5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [({"period": 1e-4}, "poke.period: got 0.0001, expected at least 0.0002 s"), ({"duration": 1e30}, "poke.duration: got 1e+30, expected at most 1e+06 times the period")],
)
def test_times_of_a_simulated_robot_that_cannot_be_kept_are_refused(program: Path, tmp_path: Path, changes: dict, message: str) -> None:
    scenario = FILES[POKED[0]]
    (tmp_path / "scenario.yaml").write_text(json.dumps(scenario | {"poke": scenario["poke"] | changes}), encoding="utf-8")
    done = children.run([program, "sense", tmp_path / "scenario.yaml"])
    assert done.returncode == 2 and message in done.stderr, done.stderr


def test_moments_of_a_simulated_robot_lie_a_period_apart(program: Path, tmp_path: Path) -> None:
    """Of 0.25 s and 2.5 ms, of which the impedance controller has 12 or 13 periods."""
    scenario = FILES[ROOT / "scenarios" / "panda_poked.yaml"]
    poke = scenario["poke"] | {"period": 0.0025, "duration": 0.25, "pushes": [scenario["poke"]["pushes"][0] | {"begin": 0.1, "duration": 0.1}]}
    (tmp_path / "scenario.yaml").write_text(json.dumps(scenario | {"poke": poke}), encoding="utf-8")
    code, out = sense(program, tmp_path / "scenario.yaml")
    assert code == 0 and [m["t"] for m in out["moments"]] == pytest.approx([0.0025 * (k + 1) for k in range(100)], abs=1.001e-4)
