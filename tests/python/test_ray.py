"""A sweep on a cluster of Ray with two raylets: one is killed, the object store is full, the head goes away; no row is lost, and none is wrong."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import children
import pytest
from ray_cluster import STORE_MB

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
sys.path.insert(0, str(MODULE))
pytest.importorskip("ray", reason="ray is not installed: `make release-check` runs this")
st = pytest.importorskip("stiction")

START_S = 60.0  # for a cluster


@dataclasses.dataclass(frozen=True)
class Works:
    """Takes its time, and says where it was done; leaves a file for each start. It kills the raylet that started it and itself, unless that is the one to be spared."""

    folder: str
    seconds: float = 0.3
    spared: int = -1

    columns: ClassVar[tuple[str, ...]] = ("value", "node")

    def __call__(self, case: Any) -> list[dict[str, Any]]:
        import ray

        (Path(self.folder) / f"{case.seed}-{time.monotonic_ns()}").touch()
        if self.spared not in (-1, os.getppid()):
            for process in (os.getppid(), os.getpid()):  # as a machine that is switched off
                os.kill(process, signal.SIGKILL)
        time.sleep(self.seconds)
        node = ray.get_runtime_context().get_node_id() if ray.is_initialized() else "none"
        return [{"status": "Solved", "value": 3 * case.seed, "node": node} for _ in case.friction]


class Served(children.Child):
    """ray_cluster.py"""

    def __init__(self, nodes: int, python_path: str) -> None:
        super().__init__([sys.executable, ROOT / "tests" / "python" / "ray_cluster.py", nodes], stdin=-1, stderr=None, env={**os.environ, "PYTHONPATH": python_path, "RAY_DEDUP_LOGS": "0"})
        said = json.loads(self.line(START_S))
        self.address, self.head, self.raylets = said["address"], said["head"], said["raylets"]

    def fill(self) -> int:
        assert self.stdin is not None
        self.stdin.write("fill\n")
        self.stdin.flush()
        return int(self.line(START_S))


@pytest.fixture(scope="module")
def cluster() -> Iterator[Served]:
    with Served(2, os.pathsep.join([str(MODULE), str(Path(__file__).parent)])) as served:
        yield served


@pytest.fixture
def starts(tmp_path: Path) -> Path:
    folder = tmp_path / "starts"
    folder.mkdir()
    return folder


def seeds_in(folder: Path) -> Counter:
    return Counter(int(path.name.split("-")[0]) for path in folder.iterdir())


def test_both_machines_work(cluster: Served, starts: Path, tmp_path: Path) -> None:
    rows = st.sweep("planar_pushing", seeds=6, out=tmp_path / "sweep.csv", run=Works(str(starts)), ray=cluster.address)
    assert {row["seed"]: (row["status"], row["attempts"], row["value"]) for row in rows} == {seed: ("Solved", 1, 3 * seed) for seed in range(6)}
    assert len({row["node"] for row in rows}) == 2 and seeds_in(starts) == {seed: 1 for seed in range(6)}


def test_an_object_store_that_is_full_does_not_matter(cluster: Served, starts: Path, tmp_path: Path) -> None:
    """Rows are small, and go past the store."""
    assert cluster.fill() > STORE_MB, "Ray moves objects to the disk"
    rows = st.sweep("planar_pushing", seeds=4, out=tmp_path / "sweep.csv", run=Works(str(starts)), ray=cluster.address)
    assert [row["value"] for row in sorted(rows, key=lambda row: row["seed"])] == [0, 3, 6, 9] and {row["attempts"] for row in rows} == {1}


def test_the_benchmark_runs_on_it(cluster: Served, tmp_path: Path) -> None:
    from stiction._benchmark import BenchmarkRun, benchmark

    run = BenchmarkRun(str(tmp_path / "tasks"))
    rows, missing = benchmark(["push_t_planar", "planar_pushing"], seeds=[0], out=tmp_path / "results.csv", scenes=None, run=run, ray=cluster.address)
    assert {(row["task"], row["status"], row["accepted"], row["reached"]) for row in rows} == {(name, "Reached", True, True) for name in ("push_t_planar", "planar_pushing")}
    assert not missing


def test_a_job_that_does_not_end_is_ended(cluster: Served, starts: Path) -> None:
    from stiction._jobs import Ray, Stopped, run_all
    from stiction.sweeps import Case

    cases = [Case("planar_pushing", {}, seed) for seed in range(2)]
    done = list(run_all(Ray(cluster.address, limit_s=3.0), Works(str(starts), seconds=300.0), cases))
    assert [(attempts, result) for _, attempts, result in done] == [(1, Stopped("its process was ended after 3 s"))] * 2


def test_a_machine_that_is_killed_loses_no_row(cluster: Served, starts: Path, tmp_path: Path) -> None:
    run = Works(str(starts), seconds=0.5, spared=cluster.raylets[0])
    rows = st.sweep("planar_pushing", seeds=12, out=tmp_path / "sweep.csv", run=run, ray=cluster.address)
    assert {row["seed"]: (row["status"], row["value"]) for row in rows} == {seed: ("Solved", 3 * seed) for seed in range(12)}
    tried = {row["seed"]: row["attempts"] for row in rows if row["attempts"] > 1}
    assert tried and {seed: count for seed, count in seeds_in(starts).items() if count > 1} == tried, "what was under way there was started again"
    assert len({row["node"] for row in rows}) == 1, "the other machine did everything"


def test_a_head_that_goes_away_is_one_sentence_and_the_sweep_goes_on_elsewhere(cluster: Served, starts: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from stiction import _jobs

    monkeypatch.setattr(_jobs, "SILENCE_S", 1.0)
    monkeypatch.setattr(_jobs, "CLUSTER_LOOK_S", 0.5)

    def kill(progress: Any) -> None:
        if progress.done == 2:
            os.kill(cluster.head, signal.SIGKILL)

    file, run = tmp_path / "sweep.csv", Works(str(starts), seconds=1.0)
    with pytest.raises(_jobs.Vanished, match=rf"^ray: the cluster at {cluster.address} has vanished: its head does not answer for 1 s$"):
        st.sweep("planar_pushing", seeds=12, out=file, run=run, ray=cluster.address, on_progress=kill)
    kept = st.sweeps.read_table(file)
    assert 2 <= len(kept) < 12 and {row["status"] for row in kept} == {"Solved"}, "what is not done is not recorded as dead"
    for path in starts.iterdir():
        path.unlink()
    rows = st.sweep("planar_pushing", seeds=12, out=file, run=run, processes=4)
    assert sorted(row["value"] for row in rows) == [3 * seed for seed in range(12)]
    assert seeds_in(starts) == {seed: 1 for seed in range(12) if seed not in {row["seed"] for row in kept}}


def test_the_command_says_that_the_cluster_vanished(program: Path, tmp_path: Path) -> None:
    """The raylet to which the command belongs is killed: Ray itself would give every run back as dead."""
    with Served(1, str(MODULE)) as served:
        words = [program, "sweep", "planar_pushing", "--seeds", "500", "--no-refine", "--ray", served.address, "-o", tmp_path / "sweep.csv", "--json"]
        with children.Child(words, env={**os.environ, "STICTION_PYTHON": sys.executable}) as child:
            for line in child.stderr:
                if line.startswith("3 of 500"):
                    os.kill(served.raylets[0], signal.SIGKILL)
                    break
            done = child.finish()
    assert done.returncode == 70, done.stderr
    message = json.loads(done.stdout)["message"]
    assert message == f"ray: the cluster at {served.address} has vanished: its process on this machine has ended; the rows so far are in {tmp_path / 'sweep.csv'}, the same command goes on"
    assert message in done.stderr and "Traceback" not in done.stderr
    assert {row["status"] for row in st.sweeps.read_table(tmp_path / "sweep.csv")} == {"Solved"}


def test_machines_without_the_package_are_named_before_anything_runs(starts: Path, tmp_path: Path) -> None:
    with Served(1, "") as served:
        with pytest.raises(st.InvalidInput, match=rf"ray: got '{served.address}', whose machine \S+ cannot load stiction \(No module named 'stiction'\), expected stiction {st.version()} on every machine"):
            st.sweep("planar_pushing", seeds=2, out=tmp_path / "sweep.csv", run=Works(str(starts)), ray=served.address)
    assert not list(starts.iterdir())
