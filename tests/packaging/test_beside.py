"""The wheel beside packages that bring other versions of the same libraries. `make release` runs this, since it fetches packages."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from outside import ROOT, check_wheel, run

pytestmark = [pytest.mark.release, pytest.mark.limit(1800)]

# Pinocchio's wheels of version 3 name no versions of the libraries that they need.
OTHERS = {
    "oldest": ("mujoco==3.3.7", "pin==3.4.0", "cmeel-urdfdom<5", "cmeel-tinyxml2<11"),
    "newer": ("mujoco==3.5.0", "pin==3.9.0", "cmeel-urdfdom<5", "cmeel-tinyxml2<11"),
    "latest": ("mujoco", "pin"),
}
LOWEST = ("numpy==1.26.4", "viser==1.1.0", "trimesh==4.0.0", "websockets==13.1", "example-robot-data==4.4.0")

# A plan, its check and its run in MuJoCo after the modules of the command line are imported, and one figure of each of the others.
WORK = """
import ctypes, glob, importlib, json, sys
for name in sys.argv[1:]:
    ctypes.CDLL(glob.glob(sys.prefix + "/lib/python3*/site-packages/" + name)[0], ctypes.RTLD_GLOBAL) if "*" in name else importlib.import_module(name)
import stiction as st
plan = st.plan(st.load_task("planar_pushing"), seed=0, timeout_s=120.0).plan
out = {"passed": st.check_plan(plan).pass_, "q": plan.q.tolist(), "reached": st.run(plan).reached}
if mujoco := sys.modules.get("mujoco"):
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><body><freejoint/><geom size='0.1'/></body></worldbody></mujoco>")
    data = mujoco.MjData(model)
    for _ in range(100):
        mujoco.mj_step(model, data)
    out["mujoco"] = [mujoco.__version__, float(data.qpos[2])]
if pin := sys.modules.get("pinocchio"):
    import numpy
    out["pin"] = [pin.__version__, pin.exp3(numpy.array([0.0, 0.0, numpy.pi / 2])).tolist()[1][0]]
if coal := sys.modules.get("coal"):
    away = coal.Transform3s.Identity()
    away.setTranslation(numpy.array([2.0, 0.0, 0.0]))
    out["coal"] = coal.distance(coal.Sphere(0.5), coal.Transform3s.Identity(), coal.Sphere(0.5), away, coal.DistanceRequest(), coal.DistanceResult())
print(json.dumps(out))
"""


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory, pytestconfig: pytest.Config) -> Path:
    folder = pytestconfig.getoption("--wheels")
    if folder is None:
        pytest.skip("no --wheels FOLDER: `make release` makes them and names it")
    words = (sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", tmp_path_factory.mktemp("reachable"), "websockets")
    if subprocess.run(words, capture_output=True, cwd="/").returncode != 0:
        pytest.skip("pip reaches no registry of packages")
    return Path(ROOT, folder)


def test_there_is_a_wheel_for_3_11_and_one_for_all_later_versions(wheels: Path) -> None:
    by_tag = {wheel.name.split("-", 2)[2]: wheel for wheel in wheels.glob("*.whl")}
    assert by_tag.keys() == {"cp311-cp311-manylinux_2_34_x86_64.whl", "cp312-abi3-manylinux_2_34_x86_64.whl"}
    extensions = [name for tag in sorted(by_tag) for name in check_wheel(by_tag[tag]) if "/_core." in name and name.endswith(".so")]
    assert extensions == ["stiction/_core.cpython-311-x86_64-linux-gnu.so", "stiction/_core.abi3.so"]


def install(wheels: Path, folder: Path, *packages: str) -> Path:
    """The folder of programs of a new environment with the wheel and these packages, resolved together."""
    run(sys.executable, "-m", "venv", folder / "venv", cwd=folder)
    run(folder / "venv/bin/pip", "install", "--quiet", "--find-links", wheels, "stiction", *packages, cwd=folder, timeout=900)
    return folder / "venv/bin"


def work(bin_folder: Path, *modules: str) -> dict[str, Any]:
    out: dict[str, Any] = json.loads(run(bin_folder / "python", "-c", WORK, *modules, cwd=bin_folder).stdout)
    assert out["passed"] and out["reached"]
    return out


@pytest.mark.parametrize("others", OTHERS)
def test_other_versions_in_the_same_process_change_nothing(wheels: Path, tmp_path: Path, others: str) -> None:
    there = install(wheels, tmp_path, *OTHERS[others])
    alone = work(there)
    fall = -9.81 * 0.002**2 * 100 * 101 / 2
    for modules in (("stiction", "mujoco", "pinocchio", "coal"), ("coal", "pinocchio", "mujoco", "stiction"), ("mujoco/libmujoco.so.*", "mujoco", "pinocchio", "coal")):
        out = work(there, *modules)
        assert out["q"] == alone["q"], f"another plan after {modules}"
        (mujoco, height), (pin, sine), distance = out["mujoco"], out["pin"], out["coal"]
        asked = dict(text.split("==") for text in OTHERS[others] if "==" in text)
        assert {"mujoco": mujoco, "pin": pin}.items() >= asked.items()
        assert (height, sine, distance) == pytest.approx((fall, 1.0, 1.0), abs=1e-6)


@pytest.mark.parametrize("others", ["pin", "mujoco", "judo-rai", "robosuite", "crocoddyl", "gymnasium", "torch", "pin==3.4.0 mujoco==3.3.7"])
def test_pip_finds_versions_that_go_together(wheels: Path, tmp_path: Path, others: str) -> None:
    words = ("install", "--dry-run", "--quiet", "--ignore-installed", "--report", tmp_path / "report.json", "--find-links", wheels, "stiction", *others.split())
    run(sys.executable, "-m", "pip", *words, cwd=tmp_path, timeout=600)
    chosen = {item["metadata"]["name"].lower(): item for item in json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))["install"]}
    assert Path(chosen["stiction"]["download_info"]["url"]).parent.name == wheels.name, "the wheel of this clone, and not an older one of a registry"
    assert {text.split("==")[0] for text in others.split()} <= chosen.keys()


def test_the_lowest_versions_are_enough(wheels: Path, tmp_path: Path) -> None:
    there = install(wheels, tmp_path, *LOWEST)
    work(there)
    run(there / "stiction", "view", "ur5_mesh_push", "--html", "page.html", cwd=tmp_path)
    assert json.loads(run(there / "stiction", "sense", "ur5_forearm", "--json", cwd=tmp_path).stdout)["status"] == "Explained"
