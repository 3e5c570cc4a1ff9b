"""Runs of `stiction control` for the figures of chapter 5."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import stiction as st
import yaml

ROOT = Path(__file__).resolve().parents[1]
LAWS = {"contact_aware": "contact-aware", "null_space": "null space", "unconstrained": "unconstrained"}
COLOURS = {"contact_aware": "C0", "null_space": "C1", "unconstrained": "C3"}
LAMBDA_MAX = 15.0  # of the scenarios [N], thesis section 5.6
THRESHOLD = 5.0  # force from which a contact counts [N]
FRICTION = 0.3  # of the scenarios
START_SPREAD = 2e-3  # [rad]
# Torques of noisy runs: white noise and offsets that change over a radian [N m], masses that are wrong; standard deviations.
NOISE, OFFSETS, MASSES = 0.05, 0.1, 0.01


@dataclass(frozen=True)
class Run:
    """What the program says, and a column for each quantity of control.csv, a value a tick."""

    summary: dict[str, Any]
    columns: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> Any:
        return self.summary[name]


def program() -> str:
    """The command line beside the module, as a build has it, or the one of an installation."""
    beside = Path(st.__file__).absolute().parents[2] / "stiction"
    found = str(beside) if beside.is_file() else shutil.which("stiction")
    if found is None:
        raise RuntimeError(f"no program 'stiction' at {beside} nor on the path")
    return found


def find(name: str) -> Path:
    """A built-in scenario, or one of the experiments."""
    file = ROOT / "scenarios" / f"{name}.yaml"
    return file if file.is_file() else ROOT / "experiments/scenes" / f"{name}.yaml"


def write_variant(file: Path, changes: dict[str, Any], folder: Path) -> Path:
    """The scenario with other keys, those of maps added to what is there, as a file elsewhere."""
    scenario = yaml.safe_load(file.read_text(encoding="utf-8"))
    for robot in scenario["scene"]["robots"]:
        robot["urdf"] = str((file.parent / robot["urdf"]).resolve())
    for key, value in changes.items():
        scenario[key] = scenario[key] | value if isinstance(value, dict) else value
    variant = folder / file.name
    variant.write_text(yaml.safe_dump(scenario, sort_keys=False), encoding="utf-8")
    return variant


def run(name: str, law: str = "contact_aware", *, changes: dict[str, Any] | None = None, **options: float) -> Run:
    """One run of a scenario. `changes`: other keys of the file; `options`: of the command line, lambda_max=8 is --lambda-max 8."""
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        scenario = write_variant(find(name), changes, folder) if changes else find(name)
        words = [program(), "control", str(scenario), "--law", law, "--json", "-o", str(folder / "out")]
        for option, value in options.items():
            words += [f"--{option.replace('_', '-')}", f"{value:g}"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):  # 1: forces above their bound, which baselines are expected to have
            raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip()}")
        file = folder / "out/control.csv"
        names = file.read_text(encoding="utf-8").split("\n", 1)[0].split(",")
        table = np.loadtxt(file, delimiter=",", skiprows=1, ndmin=2)
    return Run(json.loads(done.stdout), dict(zip(names, table.T, strict=True)))


def run_seeds(name: str, law: str, seeds: int, *, noisy: bool = False, base: dict[str, float] | None = None, changes: dict[str, Any] | None = None, **options: float) -> list[Run]:
    """Runs that differ as hardware does from day to day: joints at the start by 2 mrad (standard deviation), friction by a third. `noisy`: contacts are known
    from joint torques alone, with noise, offsets and masses that differ, too, and where there is a `base` from the wrench there. As many programs at a time as there are processors."""
    start = np.array(yaml.safe_load(find(name).read_text(encoding="utf-8"))["start"])

    def run_seed(seed: int) -> Run:
        random = np.random.default_rng(seed)
        joints = start + START_SPREAD * random.standard_normal(start.size)
        friction = random.uniform(2 / 3, 4 / 3)
        all_changes = {"start": joints.tolist()} | (changes or {})
        if noisy:
            masses = MASSES * float(random.standard_normal())
            all_changes["estimator"] = {"contacts": "estimated", "noise": NOISE, "bias": OFFSETS, "bias_reach": 1, "inertia_error": masses, "seed": seed}
            if base is not None:
                all_changes["estimator"]["base_wrench"] = base
        return run(name, law, changes=all_changes, **({"friction": friction} | options))

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(run_seed, range(seeds)))


def span(values: list[float], digits: int = 2, unit: str = "") -> str:
    """Mean and range of runs."""
    return f"{np.mean(values):.{digits}f}{unit} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def series(runs: dict[str, Run], *names: str) -> dict[str, np.ndarray]:
    """Columns of a CSV file: time, then each quantity of each run. Runs of one scenario have the same ticks."""
    first = next(iter(runs.values()))
    return {"time_s": first.columns["time"]} | {f"{name}:{law}": r.columns[name] for law, r in runs.items() for name in names}


def draw_range(axes: Any, law: str, time: np.ndarray, data: np.ndarray, every: int = 8) -> None:
    """Mean and range of runs of a law, one a row of `data`, at every so many of the samples, and half as many."""
    axes.fill_between(time[:: 2 * every], data.min(axis=0)[:: 2 * every], data.max(axis=0)[:: 2 * every], color=COLOURS[law], alpha=0.25, lw=0)
    axes.plot(time[::every], data.mean(axis=0)[::every], color=COLOURS[law], lw=1, label=LAWS[law])


def add_bounds(axes: Any) -> None:
    axes.axhline(THRESHOLD, color="C3", lw=0.8, ls="--")
    axes.axhline(LAMBDA_MAX, color="C2", lw=0.8, ls="--")
