"""Plans and runs as a data set of LeRobot (v3.0): Parquet files and meta data in a folder (docs/exports.md)."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ._core import InvalidInput, Plan, RunResult, Task, version
from ._extras import require
from .exports import POSE, Motion, make_motion, poses_of_objects

VERSION = "v3.0"
FPS = 30
CHUNK = 1000  # files in a folder
FILE_MB = 100  # of data, at most unless one episode is larger
DATA, EPISODES = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet", "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
SERIES = ("observation.state", "observation.environment_state", "action")
QUANTILES = (1, 10, 50, 90, 99)


@dataclass(frozen=True)
class Episode:
    """One episode: frames at equal times."""

    task: str  # in words
    joints: list[str]
    objects: list[str]
    robot: str
    series: dict[str, np.ndarray]  # (frames, n) by name of the feature

    def __len__(self) -> int:
        return len(self.series["action"])


def describe(task: Task) -> str:
    return task.description or task.name


def resample(times: np.ndarray, values: np.ndarray, fps: int) -> np.ndarray:
    """Returns the values (knots, n) at the times 0, 1/fps, 2/fps … up to the last time, linear between knots."""
    at = np.arange(int(np.floor((times[-1] - times[0]) * fps + 1e-9)) + 1) / fps + times[0]
    return np.column_stack([np.interp(at, times, column) for column in values.T]) if values.shape[1] else np.empty((len(at), 0))


def _episode(task: Task, times: np.ndarray, q_all: np.ndarray, u: np.ndarray, fps: int) -> Episode:
    """The action of a frame is the command at the next one."""
    model = task.model
    poses = resample(times, poses_of_objects(model, q_all).reshape(len(times), -1), fps).reshape(-1, len(model.object_names), len(POSE))
    poses[..., 3:] /= np.linalg.norm(poses[..., 3:], axis=2, keepdims=True)
    commands = resample(times, u, fps)
    series = {
        "observation.state": resample(times, q_all[:, -model.n_a :], fps),
        "observation.environment_state": poses.reshape(len(poses), -1),
        "action": np.vstack([commands[1:], u[-1:]]),
    }
    return Episode(describe(task), model.joint_names, model.object_names, task.model.scene.name or task.name, series)


def episode_of(item: Plan | Motion | tuple[Task, RunResult], fps: int) -> Episode:
    """Returns the episode of a plan at the default speed, of a motion, or of the measurements of a run."""
    if isinstance(item, Plan):
        item = make_motion(item)
    if isinstance(item, Motion):
        return _episode(item.plan.task, item.time, item.q_all, item.q_cmd, fps)
    if isinstance(item, tuple) and len(item) == 2 and isinstance(item[0], Task) and isinstance(item[1], RunResult):
        task, run = item
        if len(run.times) == 0:
            raise InvalidInput("items: got a run without samples, expected a run in which something was carried out")
        return _episode(task, np.asarray(run.times), np.asarray(run.q), np.asarray(run.u), fps)
    raise InvalidInput(f"items: got {type(item).__name__}, expected a Plan, a Motion, or (Task, RunResult)")


def write_lerobot(items: Iterable[Plan | Motion | tuple[Task, RunResult]], folder: str | os.PathLike[str], *, fps: int = FPS) -> Path:
    """Writes a data set of LeRobot into a new folder, with one episode for each item.

      items: plans, motions of exports.make_motion(), or runs as (task, result of run()). All items have the same joints and objects.
      folder: the new folder.
      fps: frames per second, in [1, 1000].

    Raises InvalidInput: joints or objects differ, or the folder exists; MissingExtra: Parquet needs `pip install stiction[parquet]`.
    """
    if isinstance(fps, bool) or not isinstance(fps, int) or not 1 <= fps <= 1000:
        raise InvalidInput(f"fps: got {fps}, expected an integer from 1 to 1000")
    require("parquet", "format lerobot", "pyarrow")
    to = Path(os.path.realpath(folder))
    if to.exists() and (not to.is_dir() or any(to.iterdir())):
        raise InvalidInput(f"{to}: got one that is there, expected a new folder for the data set")
    episodes = [episode_of(item, fps) for item in items]
    if not episodes:
        raise InvalidInput("items: got none, expected at least one")
    first = episodes[0]
    for k, episode in enumerate(episodes):
        if (episode.joints, episode.objects) != (first.joints, first.objects):
            raise InvalidInput(f"items[{k}]: got joints {episode.joints} and objects {episode.objects}, expected those of items[0]: {first.joints}, {first.objects}")
    temporary = to.with_name(f".{to.name}.{os.getpid()}")
    try:
        _write(episodes, temporary, fps)
        if to.is_dir():
            to.rmdir()  # it is empty
        temporary.rename(to)
    except OSError as error:
        raise InvalidInput(f"{to}: cannot be written ({error.strerror}), expected a folder to write to") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return to


def _write(episodes: list[Episode], folder: Path, fps: int) -> None:
    tasks = list(dict.fromkeys(episode.task for episode in episodes))
    frames = [_frames(episode, k, sum(map(len, episodes[:k])), tasks.index(episode.task), fps) for k, episode in enumerate(episodes)]
    files = _files(episodes)
    for number in dict.fromkeys(files):
        mine = [table for table, of in zip(frames, files) if of == number]
        merged = {name: np.concatenate([table[name] for table in mine]) for name in mine[0]}
        _parquet(merged, _place(folder, DATA, number))
    head: dict[str, list[Any]] = {}
    for k, (episode, table, number) in enumerate(zip(episodes, frames, files)):
        chunk, file = divmod(number, CHUNK)
        row: dict[str, Any] = {"episode_index": k, "tasks": [episode.task], "length": len(episode)}
        row |= {"data/chunk_index": chunk, "data/file_index": file, "dataset_from_index": int(table["index"][0]), "dataset_to_index": int(table["index"][-1]) + 1}
        row |= {f"stats/{name}/{kind}": value for name, values in table.items() for kind, value in statistics(values).items()}
        row |= {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0}
        for name, value in row.items():
            head.setdefault(name, []).append(value)
    _parquet(head, _place(folder, EPISODES, 0))
    _write_tasks(tasks, folder / "meta" / "tasks.parquet")
    whole = {name: statistics(np.concatenate([table[name] for table in frames])) for name in frames[0]}
    _json(whole, folder / "meta" / "stats.json")
    _json(_info(episodes, len(tasks), fps), folder / "meta" / "info.json")


def _frames(episode: Episode, number: int, first: int, task: int, fps: int) -> dict[str, np.ndarray]:
    n = len(episode)
    out: dict[str, np.ndarray] = {name: values.astype(np.float32) for name, values in episode.series.items()}
    out |= {"timestamp": (np.arange(n) / fps).astype(np.float32), "frame_index": np.arange(n), "episode_index": np.full(n, number)}
    return out | {"index": np.arange(first, first + n), "task_index": np.full(n, task)}


def _files(episodes: list[Episode]) -> list[int]:
    """Number of the file of each episode."""
    out, size, number = [], 0.0, 0
    for episode in episodes:
        more = sum(values.size for values in episode.series.values()) * 4 / 1e6
        if size > 0 and size + more > FILE_MB:
            number, size = number + 1, 0.0
        size += more
        out.append(number)
    return out


def statistics(values: np.ndarray) -> dict[str, list[Any]]:
    """Of the frames of a feature."""
    table = values.reshape(len(values), -1).astype(float)
    out = {"min": table.min(axis=0), "max": table.max(axis=0), "mean": table.mean(axis=0), "std": table.std(axis=0), "count": np.array([len(table)])}
    out |= {f"q{q:02d}": np.percentile(table, q, axis=0) for q in QUANTILES}
    return {name: value.tolist() for name, value in out.items()}


def _info(episodes: list[Episode], tasks: int, fps: int) -> dict[str, Any]:
    first = episodes[0]
    names = {"observation.state": first.joints, "action": first.joints}
    names["observation.environment_state"] = [f"{name}_{axis}" for name in first.objects for axis in POSE]
    features: dict[str, Any] = {name: {"dtype": "float32", "shape": [len(names[name])], "names": names[name]} for name in SERIES}
    features |= {"timestamp": {"dtype": "float32", "shape": [1], "names": None}}
    features |= {name: {"dtype": "int64", "shape": [1], "names": None} for name in ("frame_index", "episode_index", "index", "task_index")}
    return {
        "codebase_version": VERSION,
        "robot_type": first.robot,
        "total_episodes": len(episodes),
        "total_frames": sum(map(len, episodes)),
        "total_tasks": tasks,
        "chunks_size": CHUNK,
        "data_files_size_in_mb": FILE_MB,
        "video_files_size_in_mb": 200,
        "fps": fps,
        "splits": {"train": f"0:{len(episodes)}"},
        "data_path": DATA,
        "video_path": None,
        "features": features,
        "made_by": f"stiction {version()}",
    }


def _place(folder: Path, pattern: str, number: int) -> Path:
    chunk, file = divmod(number, CHUNK)
    return folder / pattern.format(chunk_index=chunk, file_index=file)


def _json(value: Any, file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(value, indent=1, allow_nan=False), encoding="utf-8")


def _parquet(columns: dict[str, Any], file: Path, metadata: dict[bytes, bytes] | None = None) -> None:
    pa, pq = require("parquet", "format lerobot", "pyarrow"), require("parquet", "format lerobot", "pyarrow.parquet")
    arrays = {}
    for name, values in columns.items():
        if isinstance(values, np.ndarray) and values.ndim == 2:
            arrays[name] = pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])
        else:
            arrays[name] = pa.array(values)
    file.parent.mkdir(parents=True, exist_ok=True)
    table = pa.table(arrays)
    pq.write_table(table if metadata is None else table.replace_schema_metadata(metadata), file)


def _write_tasks(tasks: list[str], file: Path) -> None:
    """A table whose index, as pandas reads it, is the text of the task."""
    columns = [
        {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64", "metadata": None},
        {"name": None, "field_name": "__index_level_0__", "pandas_type": "unicode", "numpy_type": "object", "metadata": None},
    ]
    about = {"index_columns": ["__index_level_0__"], "column_indexes": [], "columns": columns, "creator": {"library": "stiction", "version": version()}}
    _parquet({"task_index": list(range(len(tasks))), "__index_level_0__": tasks}, file, {b"pandas": json.dumps(about | {"pandas_version": "2.0.0"}).encode()})
