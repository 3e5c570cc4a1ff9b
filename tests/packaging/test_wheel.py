"""The wheel in an empty environment outside the clone: the command, its pages, the module and the examples."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from outside import BUILD, ROOT, build_consumer, check_wheel, run, same_step
from packaging.requirements import Requirement

VERSION = (ROOT / "VERSION").read_text(encoding="ascii").strip()
pytestmark = pytest.mark.limit(2400)
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The one of the Python of .venv. Built in build/wheel, which stays: a second run compiles what changed."""
    if not (BUILD / "stiction").exists():
        pytest.skip("build/release/stiction does not exist: run `make build`")
    out = tmp_path_factory.mktemp("dist")
    run(ROOT / "scripts/wheel.sh", out, "own", cwd=ROOT, timeout=1800)
    (found,) = out.glob("*.whl")
    return found


@pytest.fixture(scope="module")
def packages(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of packages of a new environment: the wheel by pip (itself a link), what it depends on as links to the packages of .venv (no download)."""
    venv = tmp_path_factory.mktemp("elsewhere") / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", venv, cwd=venv.parent)
    site = Path(run(venv / "bin/python", "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=venv).stdout.strip())
    for entry in Path(sysconfig.get_path("purelib")).iterdir():
        if not (site / entry.name).exists() and not entry.name.startswith("stiction") and entry.suffix != ".pth":
            (site / entry.name).symlink_to(entry)
    run(venv / "bin/python", "-m", "pip", "install", "--no-index", "--quiet", wheel, cwd=venv)
    return site


@pytest.fixture(scope="module")
def scripts(packages: Path) -> Path:
    return packages.parents[2] / "bin"


@pytest.fixture(scope="module")
def plan(scripts: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("plan")
    run(scripts / "stiction", "plan", "planar_pushing", "--seed", 0, "-o", out, "--html", cwd=out)
    return out


def test_the_wheel_is_small_and_names_nothing_of_the_clone(wheel: Path) -> None:
    names = check_wheel(wheel)
    libraries = [name for name in names if re.search(r"\.so(\.|$)", name)]
    assert all(re.fullmatch(r"stiction/_core\..*|stiction\.libs/lib[\w-]+-[0-9a-f]{8}\.so", name) for name in libraries), libraries
    for folder in ("tasks", "tasks/schema", "models", "scenarios", "experiments"):
        files = {path.name for path in (ROOT / folder).iterdir() if path.is_file()}
        there = {Path(name).name for name in names if str(Path(name).parent) == f"stiction/share/stiction/{folder}"}
        assert files == there, folder


@pytest.mark.parametrize("file", ["stiction/bin/stiction", "stiction/_core.*.so"])
def test_shared_libraries_are_the_wheels_own(packages: Path, file: str) -> None:
    (binary,) = packages.glob(file)
    headers = subprocess.run(["objdump", "-p", binary], capture_output=True, text=True, check=True).stdout
    (paths,) = re.findall(r"RUNPATH +(\S+)", headers)
    assert all(path.startswith("$ORIGIN/") for path in paths.split(":"))
    loaded = dict(re.findall(r"(\S+) => (\S+)", run("ldd", binary, cwd=packages).stdout))
    of_every_system = re.compile(r"lib(stdc\+\+|gcc_s|c|m|dl|rt|pthread|z)\.so|ld-linux")
    own = packages / "stiction.libs"
    for name, path in loaded.items():
        assert of_every_system.match(name) or Path(path).resolve().parent == own, f"{name} from {path}"


def test_own_libraries_share_nothing_with_another_version(packages: Path) -> None:
    """Neither their names, by which the loader takes one that is there, nor symbols that it merges over all libraries of a process."""
    libraries = list((packages / "stiction.libs").iterdir())
    assert {re.sub(r"-[0-9a-f]{8}\.so", "", path.name) for path in libraries} == {"libassimp", "libfmt", "libmujoco", "libqhull_r", "libtinyxml2", "libyaml-cpp"}
    for path in libraries:
        (name,) = re.findall(r"SONAME +(\S+)", run("objdump", "-p", path, cwd=packages).stdout)
        assert name == path.name
        assert not re.findall(r" u (\S+)", run("nm", "-D", path, cwd=packages).stdout), f"unique symbols in {name}"


def test_own_libraries_come_first_where_others_are_known_to_the_whole_process(packages: Path, tmp_path: Path) -> None:
    """And nothing is changed elsewhere."""
    script = """
import ctypes, os, runpy, sys
libraries = runpy.run_path(sys.argv[1])["libraries"]
def is_deep():
    with libraries():
        return bool(sys.getdlopenflags() & os.RTLD_DEEPBIND)
found = [is_deep()]
ctypes.CDLL(sys.argv[2])
found.append(is_deep())
ctypes.CDLL(sys.argv[2], ctypes.RTLD_GLOBAL)
print(found + [is_deep(), bool(sys.getdlopenflags() & os.RTLD_DEEPBIND)])
"""
    (mujoco,) = (packages / "mujoco").glob("libmujoco.so.*")
    assert run(sys.executable, "-c", script, packages / "stiction/_own.py", mujoco, cwd=tmp_path).stdout.strip() == "[False, False, True, False]"


def test_versions_are_those_of_the_lock_and_pip_finds_nothing_missing(packages: Path, scripts: Path) -> None:
    locked = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(encoding="utf-8"), flags=re.MULTILINE))
    locked |= dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements-wheel.lock").read_text(encoding="utf-8"), flags=re.MULTILINE))
    extras = PROJECT["project"]["optional-dependencies"]
    asked = [*PROJECT["project"]["dependencies"], *PROJECT["build-system"]["requires"], *(extras[name] for name in ("meshes", "reproduce", "mcap", "cpp"))]
    for requirement in map(Requirement, [word for words in asked for word in ([words] if isinstance(words, str) else words)]):
        assert locked.get(requirement.name, "none") in requirement.specifier, f"{requirement}, locked {locked.get(requirement.name)}"
    assert not [text for text in PROJECT["project"]["dependencies"] if "==" in text], "a pin of the wheel keeps it away from other packages"
    faults = [line for line in subprocess.run([scripts / "python", "-m", "pip", "check"], capture_output=True, text=True).stdout.splitlines() if line.startswith("stiction ")]
    assert not faults


def test_the_command_plans_checks_and_draws(scripts: Path, plan: Path) -> None:
    assert run(scripts / "stiction", "--version", cwd=plan).stdout.split()[-1] == VERSION
    run(scripts / "stiction", "check", plan, cwd=plan)
    (page,) = plan.glob("*.html")
    assert page.stat().st_size > 1e5, "the page holds its viewer"
    run(scripts / "stiction", "view", "planar_hand", "--html", "task.html", cwd=plan)
    assert "<html" in (plan / "task.html").read_text(encoding="utf-8")[:1000].lower()


def test_sense_and_control_find_their_scenarios_and_robots(scripts: Path, tmp_path: Path) -> None:
    sensed = json.loads(run(scripts / "stiction", "sense", "ur5_forearm", "--json", cwd=tmp_path).stdout)
    assert sensed["status"] == "Explained"
    run(scripts / "stiction", "control", "box_in_the_way", "-o", tmp_path, cwd=tmp_path)


def test_the_list_of_experiments_is_there(scripts: Path, tmp_path: Path) -> None:
    names = {path.stem.replace("_", "-", 1).replace("_", ".") for path in ROOT.glob("experiments/figure_*.py")}
    message = run(scripts / "stiction", "reproduce", "no-such-figure", cwd=tmp_path, expected=2).stderr
    assert names and all(name in message for name in names)


def test_a_project_finds_the_library_of_the_wheel(packages: Path, scripts: Path, tmp_path: Path) -> None:
    """By the folder that the module names, with the packages beside it and nothing of the clone."""
    where = run(scripts / "python", "-c", "import stiction; print(stiction.get_cmake_dir())", cwd=tmp_path).stdout.strip()
    consumer = build_consumer(tmp_path, f"-Dstiction_DIR={where}")
    version, task, _, status, moves = run(consumer, "planar_pushing", cwd=tmp_path).stdout.splitlines()
    assert version == VERSION and status == "Solved"
    assert Path(task) == packages / "stiction/share/stiction/tasks/planar_pushing.yaml"
    assert float(moves) == pytest.approx(same_step(scripts / "python", tmp_path), rel=1e-6)
    loaded = run("ldd", consumer, cwd=tmp_path).stdout
    assert str(ROOT) not in loaded and "not found" not in loaded, loaded


@pytest.mark.parametrize("example", sorted(path.name for path in ROOT.glob("python/examples/*.py")))
def test_examples_run_with_the_installed_module(packages: Path, scripts: Path, tmp_path: Path, example: str) -> None:
    run(scripts / "python", packages / "stiction/share/stiction/python/examples" / example, cwd=tmp_path)


@pytest.fixture(scope="module")
def fits() -> ModuleType:
    spec = importlib.util.spec_from_file_location("fits", ROOT / "python/module/stiction/_fits.py")  # its folder has modules named as packages
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_what_does_not_fit_is_named_in_one_sentence(packages: Path, scripts: Path, tmp_path: Path, fits: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    here_fits = run(scripts / "python", "-c", "import stiction._fits; print(stiction._fits.what_does_not_fit(stiction._fits.Path(stiction.__file__).parent))", cwd=tmp_path)
    assert here_fits.stdout.strip() == "None"

    here = (packages / "stiction/built_for.txt").read_text(encoding="ascii")
    (tmp_path / "cpuinfo").write_text("flags : fpu sse2 " + " ".join(fits.V3_FLAGS[2:]) + "\n", encoding="ascii")

    def said(old: str, new: str) -> str:
        (tmp_path / "built_for.txt").write_text(re.sub(old, new, here), encoding="ascii")
        message = fits.what_does_not_fit(tmp_path, tmp_path / "cpuinfo") or ""
        assert "\n" not in message
        return message

    assert "was built for Python 2.7, this is Python" in said(r"python=.*", "python=2.7")
    assert "was built for Python 3.99+, this is Python" in said(r"python=.*", "python=3.99+")
    assert "was built for mips processors, this is" in said(r"processor=.*", "processor=mips")
    assert "this one has no avx, avx2" in said(r"march=.*", "march=x86-64-v3")
    assert said(r"march=.*", "march=") == said(r"python=.*\n(.*)\nmarch=.*", r"python=3.11+\n\1\nmarch=") == ""
    assert "libc=glibc\n" in here

    def unknown(name: str) -> str:
        raise ValueError(f"unrecognized configuration name {name}")

    monkeypatch.setattr(os, "confstr", unknown)
    assert "glibc, which this system" in said(r"march=.*", "march=")


@pytest.mark.parametrize("platform", ["musllinux_1_2_x86_64", "manylinux_2_34_aarch64", "manylinux_2_28_x86_64"])
def test_pip_refuses_the_wheel_elsewhere(wheel: Path, tmp_path: Path, platform: str) -> None:
    words = ("install", "--dry-run", "--no-index", "--no-deps", "--only-binary", ":all:", "--target", tmp_path, wheel)
    refused = run(sys.executable, "-m", "pip", *words, "--platform", platform, cwd=tmp_path, expected=1)
    assert "is not a supported wheel on this platform" in refused.stderr
    run(sys.executable, "-m", "pip", *words, "--platform", "manylinux_2_34_x86_64", cwd=tmp_path)


L_SHAPE = ((0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3))


def test_coacd_is_asked_for_when_a_mesh_needs_it(packages: Path, tmp_path: Path) -> None:
    """Without it, and with one of another version beside it, whose functions take other arguments."""
    site = tmp_path / "site"
    for folder in ("stiction", "stiction.libs"):
        shutil.copytree(packages / folder, site / folder)
    corners = [f"v {x / 50} {y / 50} {z / 50}" for z in (0, 1) for x, y in L_SHAPE]
    caps = [(1, 2, 3), (1, 3, 4), (1, 4, 5), (1, 5, 6)]
    sides = [side for i in range(6) for side in ((i + 1, (i + 1) % 6 + 1, (i + 1) % 6 + 7), (i + 1, (i + 1) % 6 + 7, i + 7))]
    faces = [*((c, b, a) for a, b, c in caps), *((a + 6, b + 6, c + 6) for a, b, c in caps), *sides]
    (tmp_path / "bracket.obj").write_text("\n".join([*corners, *(f"f {a} {b} {c}" for a, b, c in faces)]) + "\n", encoding="ascii")
    task = (packages / "stiction/share/stiction/tasks/planar_pushing.yaml").read_text(encoding="utf-8")
    task = re.sub(r"urdf: .*", f"urdf: {site}/stiction/share/stiction/models/planar_pusher.urdf", task)
    (tmp_path / "bracket.yaml").write_text(re.sub(r"box: \{size: .*?\}", "mesh: {file: bracket.obj}", task), encoding="utf-8")

    def said() -> str:
        return run(site / "stiction/bin/stiction", "lint", "bracket.yaml", cwd=tmp_path, expected=2, STICTION_CACHE=str(tmp_path / "cache")).stderr

    assert "no usable CoACD library" in said() and "pip install 'stiction[meshes]'" in said()
    (site / "coacd").mkdir()
    (site / "coacd/lib_coacd.so").write_bytes(b"")
    (site / "coacd-1.0.7.dist-info").mkdir()
    assert "is of another version" in said()
