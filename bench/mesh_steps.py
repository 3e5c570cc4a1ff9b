#!/usr/bin/env python3
"""Times exact steps of robots with their meshes beside those of the same robots made of primitives.

    .venv/bin/python bench/mesh_steps.py [--repeat 5] [--program build/release/stiction] > mesh_steps.json

Robots of the package example-robot-data: two arms that push a box over a table, whose twins have a capsule about as large in the place of each mesh, and a hand that turns
a cube, with the meshes that show it in the place of its boxes. Each plans for itself, and steps are timed at the states of its own plans. One JSON object on stdout, as of
`stiction bench`; the table on stderr.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np
import trimesh
from public_robots import PACKAGES
from runs import ROOT, exit_with

ROBOTS = PACKAGES / "example-robot-data" / "robots"
ARMS = {  # URDF, stiffness [N m/rad], start, where the box is
    "panda": ("panda_description/urdf/panda.urdf", 400, [0, -0.785, 0, -2.356, 0, 1.571, 0.785, 0, 0], 0.5),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", 1000, [0, -1.57, 1.57, -1.57, -1.57, 0], 0.7),
}
HAND = "allegro_hand_description/urdf/allegro_right_hand.urdf"
BOX, CUBE = 0.1, 0.06  # edges [m]
PALM = 0.095  # from the wrist of the hand to the frame of its URDF [m]


def find_mesh(mesh, urdf):
    name = mesh.get("filename")
    if name.startswith("package://"):
        return PACKAGES / name.removeprefix("package://")
    return urdf.parent / name


def matrix_of(origin):
    if origin is None:
        return np.eye(4)
    numbers = {key: [float(x) for x in origin.get(key, "0 0 0").split()] for key in ("xyz", "rpy")}
    out = trimesh.transformations.euler_matrix(*numbers["rpy"])
    out[:3, 3] = numbers["xyz"]
    return out


def origin_of(matrix):
    spell = lambda values: " ".join(f"{x:.9g}" for x in values)
    return ElementTree.Element("origin", xyz=spell(matrix[:3, 3]), rpy=spell(trimesh.transformations.euler_from_matrix(matrix)))


def capsule_like(corners):
    """Radius, length and frame of a capsule along the longest edge of the box around corners (n × 3): half the mean of its other edges thick, and as long as the box."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    edges = high - low
    axis = int(np.argmax(edges))
    radius = np.delete(edges, axis).mean() / 2
    frame = trimesh.geometry.align_vectors([0, 0, 1], np.eye(3)[axis])
    frame[:3, 3] = (low + high) / 2
    return radius, max(edges[axis] - 2 * radius, 0.1 * radius), frame


def of_capsules(urdf):
    """The text of a URDF with a capsule for each mesh that touches."""
    tree = ElementTree.parse(urdf)
    for collision in tree.iter("collision"):
        geometry = collision.find("geometry")
        mesh = geometry.find("mesh")
        if mesh is None:
            continue
        scale = [float(x) for x in mesh.get("scale", "1 1 1").split()]
        radius, length, frame = capsule_like(trimesh.load(find_mesh(mesh, urdf), force="mesh").vertices * scale)
        origin = collision.find("origin")
        frame = matrix_of(origin) @ frame
        if origin is not None:
            collision.remove(origin)
        collision.append(origin_of(frame))
        geometry.remove(mesh)
        ElementTree.SubElement(geometry, "capsule", radius=f"{radius:.6g}", length=f"{length:.6g}")
    return ElementTree.tostring(tree.getroot(), encoding="unicode")


def as_it_looks(urdf):
    """The text of a URDF whose links touch with what shows them."""
    tree = ElementTree.parse(urdf)
    for link in tree.iter("link"):
        for collision in link.findall("collision"):
            link.remove(collision)
        for visual in link.findall("visual"):
            collision = ElementTree.SubElement(link, "collision")
            collision.extend(part for part in visual if part.tag in ("origin", "geometry"))
    return ElementTree.tostring(tree.getroot(), encoding="unicode")


def push(robot, start, x):
    box = {"name": "box", "joint": "free", "mass": 0.5, "shapes": [{"box": {"size": [BOX] * 3}, "friction": 0.5}]}
    table = {"name": "table", "friction": 0.4, "shapes": [{"half_space": {}}]}
    return {
        "scene": {"robots": [robot], "objects": [box], "fixed": [table]},
        "start": {"objects": {"box": {"position": [x, -0.1, BOX / 2]}}, "joints": start},
        "goal": {"objects": {"box": {"position": [x, 0.1, BOX / 2], "rpy": [0, 0, 0.8]}}},
        "tolerance": {"position": 0.02, "angle": 0.1},
    }


def turn(robot):
    cube = {"name": "cube", "joint": "free", "mass": 0.1, "shapes": [{"box": {"size": [CUBE] * 3}, "friction": 1.0}]}
    at = [-0.085, -0.005, 0.0113 + CUBE / 2]
    start = dict.fromkeys(("joint_1.0", "joint_5.0", "joint_9.0"), 0.3) | {"joint_12.0": 0.8, "joint_13.0": 1.0}
    return {
        "scene": {"robots": [robot], "objects": [cube]},
        "start": {"objects": {"cube": {"position": at}}, "joints": start},
        "goal": {"objects": {"cube": {"position": at, "rpy": [0, 0, math.pi / 2]}}},
        "tolerance": {"position": 0.01, "angle": 0.1},
    }


def make_tasks():
    """Name → task, a mesh and its twin after each other."""
    tasks = {}
    for name, (file, stiffness, start, x) in ARMS.items():
        robot = {"name": name, "stiffness": stiffness, "friction": 0.6}
        urdf = ROBOTS / file
        tasks[f"mesh_{name}"] = push(robot | {"urdf": str(urdf)}, start, x)
        tasks[f"twin_{name}"] = push(robot | {"urdf": of_capsules(urdf)}, start, x)
    hand = {"name": "hand", "stiffness": 3, "friction": 1.0, "base": {"position": [-PALM, 0, 0], "rpy": [0, -math.pi / 2, 0]}}
    urdf = ROBOTS / HAND
    tasks["mesh_allegro"] = turn(hand | {"urdf": as_it_looks(urdf)})
    tasks["twin_allegro"] = turn(hand | {"urdf": str(urdf)})
    return tasks


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/stiction")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        words = [str(arguments.program), "bench", "--json", "--filter", "step_exact/", "--repeat", str(arguments.repeat)]
        for name, task in make_tasks().items():
            file = pathlib.Path(folder) / f"{name}.yaml"
            file.write_text(json.dumps({"name": name, "description": "A robot with meshes, or its twin."} | task))
            words += ["--task", str(file)]
        done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"stiction bench: {done.stderr.strip()}")
    results = json.loads(done.stdout)
    by_name = {row["name"]: row for row in results["results"]}
    for name, row in by_name.items():
        twin = by_name.get(name.replace("/mesh_", "/twin_"), row)
        if twin is row:
            continue
        row["ratio_to_twin"] = row["median_s"] / twin["median_s"]
        print(f"{name}: {1e6 * row['median_s']:.1f} µs, {row['ratio_to_twin']:.2f} times its twin, {row['allocations']} allocations", file=sys.stderr)
    json.dump(results, sys.stdout)
    print()


if __name__ == "__main__":
    exit_with("mesh_steps", main)
