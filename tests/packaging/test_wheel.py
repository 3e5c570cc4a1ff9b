"""The wheel in an empty environment outside the clone: the command, its pages, the module and the examples."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest
from outside import BUILD, ROOT, build_consumer, run, same_step

VERSION = (ROOT / "VERSION").read_text(encoding="ascii").strip()
LIMIT_BYTES = 15e6
pytestmark = pytest.mark.limit(2400)
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built in build/wheel, which stays: a second run compiles what changed."""
    if not (BUILD / "stiction").exists():
        pytest.skip("build/release/stiction does not exist: run `make build`")
    out = tmp_path_factory.mktemp("dist")
    run(ROOT / "scripts/wheel.sh", out, cwd=ROOT, timeout=1800)
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
    assert wheel.stat().st_size < LIMIT_BYTES
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        assert not [name for name in names if str(ROOT).encode() in archive.read(name)]
    libraries = [name for name in names if re.search(r"\.so(\.|$)", name)]
    assert all(re.fullmatch(r"stiction/(_core\..*|lib/libfmt\.so\.\d+)", name) for name in libraries), libraries
    for folder in ("tasks", "tasks/schema", "models", "scenarios", "experiments"):
        files = {path.name for path in (ROOT / folder).iterdir() if path.is_file()}
        there = {Path(name).name for name in names if str(Path(name).parent) == f"stiction/share/stiction/{folder}"}
        assert files == there, folder


@pytest.mark.parametrize("file", ["stiction/bin/stiction", "stiction/_core.*.so"])
def test_shared_libraries_are_those_of_the_packages_beside_it(packages: Path, file: str) -> None:
    (binary,) = packages.glob(file)
    headers = subprocess.run(["objdump", "-p", binary], capture_output=True, text=True, check=True).stdout
    (paths,) = re.findall(r"RUNPATH +(\S+)", headers)
    assert all(path.startswith("$ORIGIN/") for path in paths.split(":"))
    loaded = dict(re.findall(r"(\S+) => (\S+)", run("ldd", binary, cwd=packages).stdout))
    of_the_compiler = re.compile(r"lib(stdc\+\+|gcc_s|c|m|dl|rt|pthread)\.so|ld-linux")
    for name in re.findall(r"NEEDED +(\S+)", headers):
        assert of_the_compiler.match(name) or loaded[name].startswith(str(packages)), f"{name} from {loaded[name]}"


def test_versions_are_those_of_the_lock_and_pip_finds_nothing_missing(packages: Path, scripts: Path) -> None:
    locked = dict(re.findall(r"^([\w.-]+)==(\S+)", (ROOT / "requirements.lock").read_text(encoding="utf-8"), flags=re.MULTILINE))
    extras = PROJECT["project"]["optional-dependencies"]
    asked = [*PROJECT["project"]["dependencies"], *PROJECT["build-system"]["requires"], *extras["reproduce"], *extras["mcap"], *extras["cpp"]]
    for requirement in asked:
        name, _, version = requirement.partition("==")
        assert name in locked and version in ("", locked[name]), f"{requirement}, locked {locked.get(name)}"
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


def test_another_processor_or_python_is_named(packages: Path, scripts: Path, tmp_path: Path) -> None:
    here_fits = run(scripts / "python", "-c", "import stiction._fits; print(stiction._fits.what_does_not_fit(stiction._fits.Path(stiction.__file__).parent))", cwd=tmp_path)
    assert here_fits.stdout.strip() == "None"
    spec = importlib.util.spec_from_file_location("fits", ROOT / "python/module/stiction/_fits.py")  # its folder has modules named as packages
    fits = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fits)
    V3_FLAGS, what_does_not_fit = fits.V3_FLAGS, fits.what_does_not_fit

    here = (packages / "stiction/built_for.txt").read_text(encoding="ascii")
    (tmp_path / "cpuinfo").write_text("flags : fpu sse2 " + " ".join(V3_FLAGS[2:]) + "\n", encoding="ascii")
    for old, new, expected in [
        (r"python=.*", "python=2.7", "was built for Python 2.7, this is Python"),
        (r"processor=.*", "processor=mips", "was built for mips processors, this is"),
        (r"march=.*", "march=x86-64-v3", "this one has no avx, avx2"),
    ]:
        (tmp_path / "built_for.txt").write_text(re.sub(old, new, here), encoding="ascii")
        assert expected in (what_does_not_fit(tmp_path, tmp_path / "cpuinfo") or "")
    (tmp_path / "built_for.txt").write_text(re.sub(r"march=.*", "march=", here), encoding="ascii")
    assert what_does_not_fit(tmp_path, tmp_path / "cpuinfo") is None
