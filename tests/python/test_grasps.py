"""Held grasps of search trees, and episodes that start from them. What needs Gymnasium runs where it is installed: `make learners` installs it."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402
from stiction._episodes import Episodes, _turn  # noqa: E402
from stiction.grasps import _Trial  # noqa: E402

ALL = {"starts": None, "increment": None, "max_steps": 50, "lost": None, "threads": 0}


@pytest.fixture(scope="module")
def ball() -> st.Task:
    return st.load_task("allegro_ball")


@pytest.fixture(scope="module")
def grasps(ball: st.Task) -> st.Grasps:
    return st.find_grasps(ball, count=12, seed=0)


def turned_by(model: st.Model, a: np.ndarray, b: np.ndarray) -> float:
    return float(np.linalg.norm(model.local(a, b)[3:6]))


# ---- grasps


def test_grasps_stay_where_they_are_by_a_loop_of_single_steps(ball: st.Task, grasps: st.Grasps) -> None:
    model, law = ball.model, st.FrictionLaw.Coulomb
    assert len(grasps) == 12 and (grasps.margin >= 0.1).all() and (grasps.contacts > 0).all()
    for q, u, margin in zip(grasps.q[::3], grasps.u[::3], grasps.margin[::3]):
        for scale in (1.0, 1 - margin):
            at = q
            for _ in range(15):
                step = st.step(model, at, u, friction_law=law, friction_scale=scale)
                assert step.status == st.Status.Solved
                at = step.q_next
            assert np.linalg.norm(at[:3] - q[:3]) <= ball.goal.tol_position and turned_by(model, q, at) <= ball.goal.tol_angle


FINGERS = """<robot name="gripper"><link name="base"/>
  <link name="left"><collision name="tip"><geometry><sphere radius="0.02"/></geometry></collision></link>
  <link name="right"><collision name="tip"><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="left" type="prismatic"><parent link="base"/><child link="left"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="100" velocity="1"/></joint>
  <joint name="right" type="prismatic"><parent link="base"/><child link="right"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="100" velocity="1"/></joint>
</robot>"""


def test_margin_of_a_pinch_is_that_of_coulomb() -> None:
    """Two fingers bear a weight of 2 N by friction alone: 2 mu N >= 2 N. They press with 4.5 N at mu = 0.5, so that 1 - 2/4.5 = 0.56 of the friction can go."""
    task = st.Task(
        {
            "name": "pinch",
            "scene": {
                "gravity": [0, 0, -10],
                "robots": [{"name": "gripper", "urdf": FINGERS, "stiffness": 200, "friction": 0.5}],
                "objects": [{"name": "block", "joint": "planar_yz", "mass": 0.2, "shapes": [{"box": {"size": [0.1, 0.1, 0.1]}, "friction": 0.5}]}],
            },
            "start": {"objects": {"block": {"coordinates": [0, 0, 0]}}, "joints": [-0.07, 0.07]},
            "goal": {"objects": {"block": {"coordinates": [0.1, 0.1, 0]}}},
            "tolerance": {"position": 0.01, "angle": 0.1},
        }
    )
    trial = _Trial(task, 1)
    q = np.tile(task.q_start, (3, 1))
    u = q[:, 3:] + np.outer([0.0225, 0.0102, 0.0], [1, -1])  # the second presses with 2.04 N, just enough; the third does not press
    resting, commands = trial.settle(q, u)
    np.testing.assert_allclose(commands, u[:2])
    np.testing.assert_allclose(trial.friction_margin(resting, commands), [0.5, 0.0])
    contacts, alone = trial.count_contacts(resting, commands)
    assert contacts.tolist() == [2, 2] and alone.all()


def test_contacts_are_those_of_the_robot_and_no_grasp_is_there_twice(ball: st.Task, grasps: st.Grasps) -> None:
    contacts = st.step(ball.model, grasps.q[0], grasps.u[0], friction_law=st.FrictionLaw.Coulomb).contacts
    on_ball = [c for c in contacts if c.active and any(name.startswith("ball/") for name in (c.a, c.b))]
    assert grasps.contacts[0] == len(on_ball) and grasps.alone.all(), "nothing but the hand is there"
    assert len(np.unique(np.hstack([grasps.pose, grasps.q]).round(4), axis=0)) == len(grasps)


def test_same_seed_gives_the_same_grasps_in_a_file(ball: st.Task, grasps: st.Grasps, tmp_path: Path) -> None:
    again = st.find_grasps(ball, count=12, seed=0, threads=1)
    np.testing.assert_array_equal(again.q, grasps.q)
    read = st.read_grasps(grasps.write(tmp_path / "grasps.npz"), ball)
    assert read.joints == ball.model.joint_names and read.object == "ball"
    for name in ("q", "u", "pose", "margin", "contacts", "alone"):
        np.testing.assert_array_equal(getattr(read, name), getattr(grasps, name))
    with pytest.raises(st.InvalidInput, match="scene_sha256: got that of another scene"):
        st.read_grasps(tmp_path / "grasps.npz", st.load_task("allegro_cube"))
    (tmp_path / "no.npz").write_text("no", encoding="ascii")
    with pytest.raises(st.InvalidInput, match="no.npz: cannot be read .no archive of numpy.savez., expected a file that `stiction grasps` wrote"):
        st.read_grasps(tmp_path / "no.npz", ball)


def test_options_out_of_range_are_named(ball: st.Task) -> None:
    for wrong, name in (({"count": 0}, "count"), ({"tilt": 2.0}, "tilt"), ({"least_margin": 1.0}, "least_margin")):
        with pytest.raises(st.InvalidInput, match=f"^{name}: got"):
            st.find_grasps(ball, **wrong)


def test_command_writes_grasps_of_an_own_task(stiction, tmp_path: Path) -> None:
    done = stiction("grasps", ROOT / "tasks" / "planar_hand.yaml", "--count", 5, "-o", tmp_path / "g.npz", "--json")
    assert done.returncode == 0, done.stderr
    out = json.loads(done.stdout)
    with np.load(tmp_path / "g.npz") as data:
        assert out["grasps"] == len(data["q"]) == 5 and data["u"].shape == (5, 4) and out["least_margin"] >= 0.1


# ---- forces from outside, many poses and errors with one call


def test_weights_aside_lean_as_far_as_the_angle_says(ball: st.Task) -> None:
    tau = np.array([st.calc_weights_aside(ball.model, ball.q_start[None], 0.1, draw)[0] for draw in range(4)])
    np.testing.assert_allclose(np.linalg.norm(tau[:, :3], axis=1), 0.05 * 10 * np.tan(0.1), rtol=1e-12)
    np.testing.assert_allclose(tau[:, 2], 0, atol=1e-15)
    with pytest.raises(st.InvalidInput, match=r"^draw: got 4, expected \[0, 3\]"):
        st.calc_weights_aside(ball.model, ball.q_start[None], 0.1, 4)


def test_batch_with_forces_is_a_loop_of_steps_with_forces(ball: st.Task) -> None:
    tau = 0.1 * np.random.default_rng(0).standard_normal((3, ball.model.n_v))
    q = np.tile(ball.q_start, (3, 1))
    u = q[:, -ball.model.n_a :]
    batch = st.step_batch(ball.model, q, u, tau_ext=tau)
    for i in range(3):
        np.testing.assert_array_equal(batch.q_next[i], st.step(ball.model, q[i], u[i], tau_ext=tau[i]).q_next)
    assert np.abs(batch.q_next - st.step_batch(ball.model, q, u).q_next).max() > 1e-4
    with pytest.raises(st.InvalidInput, match=r"^tau_ext.shape\[1\]: got 2 numbers, expected 22"):
        st.step_batch(ball.model, q, u, tau_ext=tau[:, :2])


def test_poses_and_goal_errors_of_many_states_are_those_of_each(ball: st.Task, grasps: st.Grasps) -> None:
    poses, errors = ball.model.object_poses(grasps.q, "ball"), ball.goal_errors(grasps.q)
    X_WG = ball.goal.X_WG
    for q, pose, error in zip(grasps.q, poses, errors):
        X = ball.model.object_pose(q, "ball")
        np.testing.assert_array_equal(pose, [*X.p, *X.quaternion_wxyz])
        angle = np.arccos(np.clip((np.trace(X.R.T @ X_WG.R) - 1) / 2, -1, 1))
        np.testing.assert_allclose(error, [np.linalg.norm(X.p - X_WG.p), angle], rtol=1e-6, atol=1e-9)
    with pytest.raises(st.InvalidInput, match="'pen'"):
        ball.model.object_poses(grasps.q, "pen")


# ---- episodes


def test_episode_is_a_rollout_of_its_commands_and_rewards_add_up(ball: st.Task) -> None:
    episodes = Episodes(ball, 2, **ALL)
    everything, random = np.ones(2, dtype=bool), np.random.default_rng(0)
    episodes.reset(everything, random)
    actions = random.uniform(-1, 1, (5, 2, ball.model.n_a))
    before, total = episodes.error.copy(), np.zeros(2)
    u = [episodes.u.copy()]
    for action in actions:
        outcome = episodes.step(action, everything)
        total += outcome.reward
        u.append(np.clip(u[-1] + 0.05 * action, ball.model.lower, ball.model.upper))
    rolled = st.rollout_batch(ball.model, np.tile(ball.q_start, (2, 1)), np.stack(u[1:], axis=1), friction_law=st.FrictionLaw.Coulomb, effort_limits=True)
    np.testing.assert_allclose(episodes.q, rolled.q[:, -1], atol=1e-12)
    np.testing.assert_allclose(total, ((before - episodes.error) / (ball.goal.tol_position, ball.goal.tol_angle)).sum(axis=1))
    assert not outcome.success.any() and (episodes.steps == 5).all()


def test_episode_ends_at_the_goal_where_the_object_is_lost_and_after_its_steps(ball: st.Task, grasps: st.Grasps) -> None:
    everything = np.ones(1, dtype=bool)
    pose = grasps.pose[0]
    x, y, z, w = pose[4], pose[5], pose[6], pose[3]
    rpy = [np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), np.arcsin(2 * (w * y - z * x)), np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))]
    there = ball.with_(goal=[*pose[:3] + [0, 0, 0.012], *rpy])  # just out of tolerance, so that it starts; the hand does not move
    assert (there.goal_errors(grasps.q[:1])[0] < (0.013, 1e-6)).all()
    random = np.random.default_rng(0)
    held = Episodes(there, 1, **ALL | {"starts": grasps[:1], "max_steps": 3})
    held.reset(everything, random)
    ends = [held.step(np.zeros((1, 16)), everything) for _ in range(3)]
    assert [bool(end.truncated[0]) for end in ends] == [False, False, True] and not any(end.success[0] or end.lost[0] for end in ends)
    near = Episodes(ball.with_(goal=[*pose[:3], *rpy]), 1, **ALL)
    near.q, near.u = grasps.q[:1].copy(), grasps.u[:1].copy()
    outcome = near.step(np.zeros((1, 16)), everything)
    assert outcome.success[0] and outcome.reward[0] >= 10
    box = Episodes(st.load_task("planar_pushing"), 1, **ALL | {"lost": 0.02})  # its goal is below, and the hand pushes it upwards
    box.reset(everything, random)
    lost = [bool(box.step(np.array([[0.0, 1.0]]), everything).lost[0]) for _ in range(20)]
    assert lost[-1] and not lost[0]


def test_observation_says_where_things_are_and_where_to(ball: st.Task, grasps: st.Grasps) -> None:
    episodes = Episodes(ball, 4, **ALL | {"starts": grasps})
    episodes.reset(np.ones(4, dtype=bool), np.random.default_rng(1))
    seen = episodes.observe()
    assert seen.shape == (4, 2 * 16 + 9 + 6) and seen.dtype == np.float32
    q, n_a = episodes.q[2], 16
    X, G = ball.model.object_pose(q, "ball"), ball.goal.X_WG
    np.testing.assert_allclose(seen[2, :16], q[-n_a:], atol=1e-6)
    np.testing.assert_allclose(seen[2, 16:32], episodes.u[2] - q[-n_a:], atol=1e-6)
    np.testing.assert_allclose(seen[2, 32:41], [*X.p, *X.R[:, 0], *X.R[:, 1]], atol=1e-6)
    turn = seen[2, 44:].astype(float)
    angle = np.linalg.norm(turn)
    K = np.array([[0, -turn[2], turn[1]], [turn[2], 0, -turn[0]], [-turn[1], turn[0], 0]]) / angle
    R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    np.testing.assert_allclose(R @ X.R, G.R, atol=1e-5)
    np.testing.assert_allclose(seen[2, 41:44], G.p - X.p, atol=1e-6)


def test_rotation_to_itself_and_by_half_a_turn() -> None:
    one = np.array([[1.0, 0, 0, 0]])
    np.testing.assert_array_equal(_turn(one, one), np.zeros((1, 3)))
    np.testing.assert_allclose(_turn(one, np.array([[0.0, 0, 1, 0]])), [[0, np.pi, 0]])
    np.testing.assert_allclose(_turn(one, np.array([[1.0, 5e-9, 0, 0]])), [[1e-8, 0, 0]], rtol=1e-6)


def test_goals_are_poses_of_other_grasps_and_errors_those_of_the_task(ball: st.Task, grasps: st.Grasps) -> None:
    episodes = Episodes(ball, 40, **ALL | {"starts": grasps, "goals": grasps})
    everything = np.ones(40, dtype=bool)
    episodes.reset(everything, np.random.default_rng(0))
    assert len(np.unique(episodes.goal, axis=0)) > 3, "goals differ"
    for q, goal, error in zip(episodes.q[::8], episodes.goal[::8], episodes.error[::8]):
        assert (grasps.pose == goal).all(axis=1).any()
        w, x, y, z = goal[3:]
        rpy = [np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), np.arcsin(2 * (w * y - z * x)), np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))]
        np.testing.assert_allclose(error, ball.with_(goal=[*goal[:3], *rpy]).goal_errors(q[None])[0], rtol=1e-5, atol=1e-7)
        assert (error > (ball.goal.tol_position, ball.goal.tol_angle)).any(), "away from the start"
    seen = episodes.observe()
    np.testing.assert_allclose(seen[:, 41:44], episodes.goal[:, :3] - seen[:, 32:35], atol=1e-6)
    with pytest.raises(st.InvalidInput, match="^goals: got grasps of another scene"):
        Episodes(st.load_task("allegro_cube"), 2, **ALL | {"goals": grasps})


def test_episodes_refuse_what_they_cannot_take(ball: st.Task, grasps: st.Grasps) -> None:
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"increment": [0.1, 0.1]}, "^increment: got"),
        ({"increment": -1.0}, "^increment: got -1.0"),
        ({"max_steps": 0}, "^max_steps: got 0"),
    ]
    for changes, message in wrong:
        with pytest.raises(st.InvalidInput, match=message):
            Episodes(ball, 2, **ALL | changes)
    with pytest.raises(st.InvalidInput, match="^num_envs: got 0"):
        Episodes(ball, 0, **ALL)
    with pytest.raises(st.InvalidInput, match="^starts: got grasps of another scene"):
        Episodes(st.load_task("allegro_cube"), 2, **ALL | {"starts": grasps})
    with pytest.raises(st.InvalidInput, match=r"^actions: got the shape \(3,\), expected \(2, 16\)"):
        Episodes(ball, 2, **ALL).step(np.zeros(3), np.ones(2, dtype=bool))
    with pytest.raises(st.InvalidInput, match="^actions: got numbers that are not finite"):
        Episodes(ball, 1, **ALL).step(np.full((1, 16), np.nan), np.ones(1, dtype=bool))


def test_gym_without_gymnasium_names_the_extra() -> None:
    try:
        __import__("gymnasium")
    except ImportError:
        with pytest.raises(st.MissingExtra, match=r"pip install 'stiction\[gym\]'"):
            __import__("stiction.gym")


def test_environment_passes_the_checker_of_gymnasium(ball: st.Task, grasps: st.Grasps) -> None:
    pytest.importorskip("gymnasium")
    from gymnasium.utils.env_checker import check_env
    from stiction.gym import make

    check_env(make(ball, starts=grasps), skip_render_check=True)
    check_env(make("planar_pushing"), skip_render_check=True)


def test_vector_environment_begins_anew_after_an_end_and_starts_at_grasps(ball: st.Task, grasps: st.Grasps) -> None:
    gymnasium = pytest.importorskip("gymnasium")
    import stiction.gym as gym

    envs = gymnasium.make_vec(gym.ID, num_envs=3, vectorization_mode="vector_entry_point", task="planar_pushing", max_steps=2)
    assert isinstance(envs.unwrapped, gym.TaskVectorEnv)
    assert envs.metadata["autoreset_mode"] == gymnasium.vector.AutoresetMode.NEXT_STEP
    first, _ = envs.reset(seed=3)
    assert first in envs.observation_space
    ends, rewards = [], []
    for _ in range(5):
        _, reward, terminated, truncated, infos = envs.step(np.ones((3, 2), dtype=np.float32))
        ends.append(truncated[0])
        rewards.append(reward[0])
        assert set(infos) >= {"success", "_success", "lost", "unsolved", "position_error", "angle_error"} and not terminated.any()
    assert ends == [False, True, False, False, True] and rewards[2] == 0, "the third step begins the next episode"
    many = gym.make_vec(ball, 5, starts=grasps, goals=grasps)
    first, _ = many.reset(seed=0)
    again, _ = many.reset(seed=0)
    np.testing.assert_array_equal(again, first)
    held = {q[-16:].astype(np.float32).tobytes() for q in grasps.q}
    assert all(seen[:16].tobytes() in held for seen in first), "episodes start at grasps"
