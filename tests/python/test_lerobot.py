"""Data sets of LeRobot. Files are written and read back where pyarrow is installed; what goes into them is looked at everywhere."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402
from stiction import exports, lerobot  # noqa: E402


@pytest.fixture(scope="module")
def plans() -> list[st.Plan]:
    task = st.load_task("planar_hand")
    return [st.plan(task.with_(goal=[0.0, 0.35, angle]), seed=0).plan for angle in (0.3, -0.4)]


def test_frames_lie_on_the_motion_at_equal_times(plans: list[st.Plan]) -> None:
    motion = exports.make_motion(plans[0])
    episode = lerobot.episode_of(plans[0], 20)
    n = len(episode)
    assert n == int(motion.time[-1] * 20 + 1e-9) + 1
    k = n // 2
    at = k / 20
    for j in range(4):
        assert episode.series["observation.state"][k, j] == pytest.approx(np.interp(at, motion.time, motion.q[:, j]))
        assert episode.series["action"][k, j] == pytest.approx(np.interp(at + 1 / 20, motion.time, motion.q_cmd[:, j])), "the command at the next frame"
    np.testing.assert_array_equal(episode.series["action"][-1], motion.q_cmd[-1])
    pose = episode.series["observation.environment_state"][k]
    assert pose[1] == pytest.approx(np.interp(at, motion.time, motion.poses[:, 0, 1])) and np.linalg.norm(pose[3:]) == pytest.approx(1)


def test_run_is_an_episode_of_what_was_measured(plans: list[st.Plan]) -> None:
    run = st.run(plans[0], seed=0)
    episode = lerobot.episode_of((plans[0].task, run), 30)
    assert len(episode) == int((run.times[-1] - run.times[0]) * 30 + 1e-9) + 1
    np.testing.assert_allclose(episode.series["observation.state"][0], run.q[0, -4:])
    with pytest.raises(st.InvalidInput, match=r"^items: got int, expected a Plan, a Motion, or \(Task, RunResult\)"):
        lerobot.episode_of(1, 30)  # type: ignore[arg-type]


def test_statistics_are_those_of_numbers_that_are_known() -> None:
    values = np.arange(101.0)[:, None] * [1, -2]
    out = lerobot.statistics(values)
    assert out["min"] == [0, -200] and out["max"] == [100, 0] and out["mean"] == [50, -100] and out["count"] == [101]
    assert out["q01"] == pytest.approx([1, -198]) and out["q50"] == pytest.approx([50, -100])
    assert out["std"] == pytest.approx([np.sqrt(850), 2 * np.sqrt(850)])


def test_bad_input_is_named(plans: list[st.Plan], tmp_path: Path) -> None:
    with pytest.raises(st.InvalidInput, match="^fps: got 0, expected an integer from 1 to 1000"):
        lerobot.write_lerobot(plans, tmp_path / "a", fps=0)
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        with pytest.raises(st.MissingExtra, match=r"pip install 'stiction\[parquet\]'"):
            lerobot.write_lerobot(plans, tmp_path / "a")
        return
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "file").write_text("x", encoding="ascii")
    with pytest.raises(st.InvalidInput, match="there: got one that is there, expected a new folder"):
        lerobot.write_lerobot(plans, tmp_path / "there")
    with pytest.raises(st.InvalidInput, match="^items: got none"):
        lerobot.write_lerobot([], tmp_path / "b")
    other = st.plan(st.load_task("planar_pushing"), seed=0).plan
    with pytest.raises(st.InvalidInput, match=r"^items\[1\]: got joints \['hand/y', 'hand/z'\]"):
        lerobot.write_lerobot([plans[0], other], tmp_path / "b")


def test_data_set_says_what_the_motions_say(plans: list[st.Plan], tmp_path: Path) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    folder = lerobot.write_lerobot([*plans, (plans[0].task, st.run(plans[0], seed=0))], tmp_path / "set", fps=25)
    info = json.loads((folder / "meta/info.json").read_text(encoding="utf-8"))
    data = pq.read_table(folder / info["data_path"].format(chunk_index=0, file_index=0))
    episodes = pq.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pydict()
    assert info["codebase_version"] == "v3.0" and info["total_episodes"] == 3 and info["total_frames"] == len(data) == sum(episodes["length"])
    assert set(info["features"]) == set(data.column_names) and info["fps"] == 25
    assert episodes["dataset_from_index"] == [0, *np.cumsum(episodes["length"])[:-1].tolist()]
    state = np.array(data["observation.state"].to_pylist())
    for k, plan in enumerate(plans):
        rows = np.flatnonzero(np.array(data["episode_index"]) == k)
        assert rows[0] == episodes["dataset_from_index"][k] and rows[-1] + 1 == episodes["dataset_to_index"][k]
        np.testing.assert_allclose(state[rows], lerobot.episode_of(plan, 25).series["observation.state"], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(np.array(data["timestamp"])[:5], np.arange(5) / 25, atol=1e-7)
    stats = json.loads((folder / "meta/stats.json").read_text(encoding="utf-8"))
    np.testing.assert_allclose(stats["observation.state"]["mean"], state.mean(axis=0), rtol=1e-5)
    assert stats["action"]["count"] == [len(data)]
    tasks = pq.read_table(folder / "meta/tasks.parquet")
    assert json.loads(tasks.schema.metadata[b"pandas"])["index_columns"] == ["__index_level_0__"] and tasks["__index_level_0__"].to_pylist() == [plans[0].task.description]


def test_command_writes_several_plans_as_episodes(plans: list[st.Plan], stiction, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STICTION_PYTHON", sys.executable)  # which may have more packages than the one of the build
    files = []
    for k, plan in enumerate(plans):
        files.append(tmp_path / f"plan_{k}.json")
        plan.write(files[-1])
    wrong = stiction("export", *files, "-o", tmp_path / "motion.csv")
    assert wrong.returncode == 2 and "got csv with several plans or --fps, expected lerobot" in wrong.stderr
    try:
        pq = __import__("pyarrow.parquet").parquet
    except ImportError:
        done = stiction("export", *files, "--format", "lerobot", "-o", tmp_path / "set")
        assert done.returncode == 70 and "pip install 'stiction[parquet]'" in done.stderr and not (tmp_path / "set").exists()
        return
    done = stiction("export", *files, "--format", "lerobot", "-o", tmp_path / "set", "--fps", 10, "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["files"] == [str(tmp_path / "set")]
    assert pq.read_table(tmp_path / "set/meta/episodes/chunk-000/file-000.parquet").num_rows == 2


def test_loader_of_lerobot_reads_it(plans: list[st.Plan], tmp_path: Path) -> None:
    """Where the package lerobot is installed, which brings gigabytes."""
    loader = pytest.importorskip("lerobot.datasets.lerobot_dataset")
    folder = lerobot.write_lerobot(plans, tmp_path / "set")
    data = loader.LeRobotDataset("stiction/test", root=folder)
    assert data.num_episodes == 2 and data.fps == 30 and data.meta.get_task_index(plans[0].task.description) == 0
    item = data[3]
    np.testing.assert_allclose(item["observation.state"].numpy(), lerobot.episode_of(plans[0], 30).series["observation.state"][3], rtol=1e-6)
    assert item["task"] == plans[0].task.description and item["action"].shape == (4,)
