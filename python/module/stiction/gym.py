"""Tasks as environments of Gymnasium (docs/learning.md).

    import stiction.gym
    envs = stiction.gym.make_vec("allegro_ball", num_envs=256, starts="grasps.npz")

The extra `stiction[gym]` brings Gymnasium.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from ._core import InvalidInput, Task, load_task
from ._episodes import Episodes, Outcome
from ._extras import require
from .grasps import Grasps, find_grasps, read_grasps

if TYPE_CHECKING:
    import gymnasium
else:
    gymnasium = require("gym", "stiction.gym", "gymnasium")
    require("gym", "stiction.gym", "gymnasium.vector")

ID = "stiction/Task-v0"


def _task(task: str | os.PathLike[str] | Task) -> Task:
    return task if isinstance(task, Task) else load_task(task)


def _grasps(task: Task, name: str, given: Any, seed: int) -> Grasps | None:
    if given is None or isinstance(given, Grasps):
        return given
    if isinstance(given, int) and not isinstance(given, bool):
        return find_grasps(task, count=given, seed=seed)
    if isinstance(given, (str, os.PathLike)):
        return read_grasps(given, task)
    raise InvalidInput(f"{name}: got {type(given).__name__}, expected None, Grasps, a file, or how many to find")


def _spaces(episodes: Episodes) -> tuple[Any, Any]:
    """Of the observations and actions of one episode."""
    observation = gymnasium.spaces.Box(-np.inf, np.inf, (episodes.size,), np.float32)
    return observation, gymnasium.spaces.Box(-1.0, 1.0, (episodes.model.n_a,), np.float32)


def _details(episodes: Episodes, outcome: Outcome | None = None) -> dict[str, np.ndarray]:
    error = episodes.error
    out = {"position_error": error[:, 0].copy(), "angle_error": error[:, 1].copy()}
    if outcome is not None:
        out |= {"success": outcome.success, "lost": outcome.lost, "unsolved": outcome.unsolved}
    return out


class TaskVectorEnv(gymnasium.vector.VectorEnv):  # type: ignore[misc]
    """Vector environment: N episodes of a task, stepped in parallel. An episode that has ended restarts at the next step (AutoresetMode.NEXT_STEP)."""

    def __init__(self, episodes: Episodes) -> None:
        self.metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP, "render_modes": []}
        self.episodes = episodes
        self.num_envs = episodes.number
        self.single_observation_space, self.single_action_space = _spaces(episodes)
        batch = gymnasium.vector.utils.batch_space
        self.observation_space, self.action_space = batch(self.single_observation_space, self.num_envs), batch(self.single_action_space, self.num_envs)
        self._ended = np.ones(self.num_envs, dtype=bool)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self._ended = np.zeros(self.num_envs, dtype=bool)
        self.episodes.reset(np.ones(self.num_envs, dtype=bool), self.np_random)
        return self.episodes.observe(), self._infos(_details(self.episodes), np.ones(self.num_envs, dtype=bool))

    def step(self, actions: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        again, going = self._ended, ~self._ended
        if again.any():
            self.episodes.reset(again, self.np_random)
        outcome = self.episodes.step(np.asarray(actions, dtype=float), going)
        terminated = outcome.success | outcome.lost
        reward = np.where(going, outcome.reward, 0.0)
        self._ended = terminated | outcome.truncated
        return self.episodes.observe(), reward, terminated, outcome.truncated, self._infos(_details(self.episodes, outcome), going)

    @staticmethod
    def _infos(details: dict[str, np.ndarray], known: np.ndarray) -> dict[str, Any]:
        return details | {f"_{name}": known.copy() for name in details}


class TaskEnv(gymnasium.Env):  # type: ignore[misc]
    """Environment with one episode of a task at a time."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, episodes: Episodes) -> None:
        self.episodes = episodes
        self.observation_space, self.action_space = _spaces(episodes)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        self.episodes.reset(np.ones(1, dtype=bool), self.np_random)
        return self.episodes.observe()[0], self._info(_details(self.episodes))

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        outcome = self.episodes.step(np.asarray(action, dtype=float)[None], np.ones(1, dtype=bool))
        ended = bool(outcome.success[0] or outcome.lost[0])
        return self.episodes.observe()[0], float(outcome.reward[0]), ended, bool(outcome.truncated[0]), self._info(_details(self.episodes, outcome))

    @staticmethod
    def _info(details: dict[str, np.ndarray]) -> dict[str, Any]:
        return {name: value[0].item() for name, value in details.items()}


def make_vec(
    task: str | os.PathLike[str] | Task,
    num_envs: int,
    *,
    starts: Grasps | str | os.PathLike[str] | int | None = None,
    goals: Grasps | str | os.PathLike[str] | int | None = None,
    increment: Any = None,
    max_steps: int = 200,
    lost: float | None = None,
    seed: int = 0,
    threads: int = 0,
) -> TaskVectorEnv:
    """Makes a task into a gymnasium.vector.VectorEnv, for reinforcement learning.

      task: Task, or its name or file.
      num_envs: number N of episodes that are stepped together.
      starts: grasps from which episodes start at random: Grasps, their file, or the number of grasps to find with find_grasps(). None: every
        episode starts at the start of the task.
      goals: grasps, as above. Each episode takes an object pose of one of them as its goal, away from its start. None: the goal of the task.
      increment: largest change of a command in a step of 0.1 s [rad or m], > 0, or one number for each joint. None: 0.05 rad and 0.02 m.
      max_steps: number of steps after which an episode is truncated.
      lost: an episode ends if the object is farther from its goal than at the start by this distance [m]. None: 20 tolerances.
      seed: of the search for grasps.
      threads: 0: all cores. The result does not depend on this number.

    The observation (float32) contains the joint positions, the commands minus the joint positions, the position and the first two columns of
    the rotation matrix of each object, and the translation and rotation vector from the object to its goal. The action is the change of the
    commands, in [-1, 1] times `increment`. The reward is the decrease of the distance from the goal, in tolerances of position and angle, plus
    10 when the goal is reached. Raises InvalidInput; MissingExtra: gymnasium is not installed.
    """
    one = _task(task)
    held, wanted = _grasps(one, "starts", starts, seed), _grasps(one, "goals", goals, seed)
    return TaskVectorEnv(Episodes(one, num_envs, starts=held, goals=wanted, increment=increment, max_steps=max_steps, lost=lost, threads=threads))


def make(
    task: str | os.PathLike[str] | Task, *, starts: Any = None, goals: Any = None, increment: Any = None, max_steps: int = 200, lost: float | None = None, seed: int = 0
) -> TaskEnv:
    """Makes a task into a gymnasium.Env. The arguments are those of make_vec()."""
    one = _task(task)
    held, wanted = _grasps(one, "starts", starts, seed), _grasps(one, "goals", goals, seed)
    return TaskEnv(Episodes(one, 1, starts=held, goals=wanted, increment=increment, max_steps=max_steps, lost=lost, threads=1))


if ID not in gymnasium.registry:  # gymnasium.make_vec("stiction/Task-v0", num_envs=8, task="allegro_ball")
    gymnasium.register(ID, entry_point=f"{__name__}:make", vector_entry_point=f"{__name__}:make_vec", disable_env_checker=True)
