"""The published JSON schema of scenes accepts what the tasks use and refuses what the reader refuses."""

import copy
import json
import os
import pathlib
import sys

import children
import jsonschema
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
TASKS = sorted((ROOT / "tasks").glob("*.yaml"))
SCHEMA = json.loads((ROOT / "tasks/schema/scene.schema.json").read_text())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def merge(base, over):
    if not isinstance(base, dict) or not isinstance(over, dict):
        return over
    return base | {key: merge(base[key], value) if key in base else value for key, value in over.items()}


def load(path):
    task = yaml.safe_load(path.read_text())
    base = task.pop("base", None)
    return merge(load(path.parent / base), task) if base else task


def test_schema_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    assert len(TASKS) >= 6


@pytest.mark.parametrize("path", TASKS, ids=lambda p: p.stem)
def test_every_task_scene_is_valid(path):
    VALIDATOR.validate(load(path)["scene"])


@pytest.mark.parametrize("path", sorted((ROOT / "tests/world/data").glob("*.yaml")), ids=lambda p: p.stem)
def test_every_test_scene_is_valid(path):
    VALIDATOR.validate(load(path))


def change(scene, path, value):
    scene = copy.deepcopy(scene)
    at = scene
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return scene


@pytest.mark.parametrize(
    "path, value",
    [
        (["gravty"], [0, 0, 0]),
        (["gravity"], [0, 0]),
        (["contact_distance"], 0),
        (["max_contacts"], 2.5),
        (["objects", 0, "mass"], -1),
        (["objects", 0, "joint"], "floating"),
        (["objects", 0, "axis"], [0, 0, 1]),
        (["objects", 0, "name"], "a/b"),
        (["objects", 0, "shapes"], []),
        (["objects", 0, "shapes"], [{"half_space": {}}]),
        (["objects", 0, "shapes", 0, "box"], {"size": [1, 1, 1]}),
        (["robots", 0, "stiffness"], -3),
        (["robots", 0, "mjcf"], "hand.xml"),
        (["robots", 0], {"name": "hand"}),
        (["robots", 0], {"name": "hand", "mjcf": "hand.xml", "friction": 1}),
        (["robots", 0, "base"], {"rpy": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}),
        (["filters"], [{"exclude": ["a", "b"], "max_distance": 1}]),
        (["filters"], [{"limit": ["a", "b"]}]),
    ],
    ids=str,
)
def test_mistakes_are_refused(path, value):
    scene = load(ROOT / "tasks/allegro_ball.yaml")["scene"]
    VALIDATOR.validate(scene)
    assert not VALIDATOR.is_valid(change(scene, path, value))


def test_options_of_the_planner_are_written_down_as_the_program_has_them():
    environment = os.environ | {"PYTHONPATH": str(ROOT / "build/release/python")}
    done = children.run([sys.executable, ROOT / "scripts/options.py", "--check"], env=environment)
    assert done.returncode == 0, done.stderr


def test_users_have_ten_options():
    schema = json.loads((ROOT / "tasks/schema/planner.schema.json").read_text())
    assert len(set(schema["properties"]) - {"thesis"}) <= 10
