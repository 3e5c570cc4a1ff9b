"""Many steps in one call, and tasks that differ from others."""

from __future__ import annotations

import sys
from pathlib import Path

import children
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MODULE = ROOT / "build" / "release" / "python"
if not (MODULE / "stiction").is_dir():
    pytest.skip(f"{MODULE} does not exist: run `make build`", allow_module_level=True)
sys.path.insert(0, str(MODULE))

import stiction as st  # noqa: E402


@pytest.fixture(scope="module")
def ball() -> st.Task:
    return st.load_task("allegro_ball")


def states(task: st.Task, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Configurations near the start, the fingers disturbed, and commands near them."""
    random = np.random.default_rng(3)
    q = np.tile(task.q_start, (n, 1))
    q[:, -task.model.n_a :] += 0.05 * random.standard_normal((n, task.model.n_a))
    return q, q[:, -task.model.n_a :] + 0.05 * random.standard_normal((n, task.model.n_a))


def test_batch_has_the_bits_of_single_cold_steps(ball: st.Task) -> None:
    q, u = states(ball, 40)
    options = {"h": 0.1, "smoothing": st.Analytic(kappa=1000)}
    batch = st.step_batch(ball.model, q, u, with_A=True, with_B=True, threads=2, **options)
    assert len(batch) == 40 and batch.failed == 0 and batch.solved.all()
    assert batch.A.shape == (40, ball.model.n_v, ball.model.n_v) and batch.B.shape == (40, ball.model.n_v, ball.model.n_a)
    for i in range(40):
        single = st.step(ball.model, q[i], u[i], with_A=True, with_B=True, **options)
        np.testing.assert_array_equal(batch.q_next[i], single.q_next)
        np.testing.assert_array_equal(batch.torque[i], single.torque)
        np.testing.assert_array_equal(batch.A[i], single.A)
        np.testing.assert_array_equal(batch.B[i], single.B)


def test_arrays_of_a_batch_outlive_it(ball: st.Task) -> None:
    q, u = states(ball, 8)
    B = st.step_batch(ball.model, q, u, with_B=True).B
    again = st.step_batch(ball.model, q, u, with_B=True).B
    np.testing.assert_array_equal(B, again)
    assert not B.flags.writeable


def test_batch_names_what_is_wrong(ball: st.Task) -> None:
    q, u = states(ball, 8)
    model = ball.model
    with pytest.raises(st.InvalidInput, match=rf"^q.shape\[1\]: got 3 numbers, expected {model.n_q}$"):
        st.step_batch(model, q[:, :3], u)
    with pytest.raises(st.InvalidInput, match="^u: got 7 commands, expected 8, one for each q$"):
        st.step_batch(model, q, u[:7])
    with pytest.raises(st.InvalidInput, match="^threads: got -2"):
        st.step_batch(model, q, u, threads=-2)
    u[5, 2] = np.inf
    with pytest.raises(st.InvalidInput, match="^step 5: u"):
        st.step_batch(model, q, u)


def test_task_with_other_values_leaves_the_first_as_it_is() -> None:
    task = st.load_task("planar_pushing")
    before = task.q_start.copy()
    start = before + [0.01, 0, 0, 0, 0]
    other = task.with_(start=start, goal=[0.05, 0.0, 0.0], options={"seed": 5})
    np.testing.assert_array_equal(other.q_start, start)
    np.testing.assert_array_equal(task.q_start, before)
    assert other.options.seed == 5 and task.options.seed == 0
    assert not np.allclose(other.goal.X_WG.p, task.goal.X_WG.p)
    with pytest.raises(st.InvalidInput, match="^start: got 2 numbers, expected 5"):
        task.with_(start=[0, 0])
    with pytest.raises(st.InvalidInput, match="^goal: got 2 numbers"):
        task.with_(goal=[0, 0])


def test_plan_from_another_start_is_accepted_from_its_file(tmp_path: Path) -> None:
    task = st.load_task("planar_pushing")
    other = task.with_(start=task.q_start + [0.02, 0.01, 0, 0, 0])
    plan = st.plan(other, seed=0).plan
    assert plan.status == st.Status.Solved
    np.testing.assert_array_equal(plan.q[0], other.q_start)
    plan.write(tmp_path / "plan.json")
    again = st.read_plan(tmp_path / "plan.json")
    np.testing.assert_array_equal(again.task.q_start, other.q_start)
    report = st.check_plan(again)
    assert report.pass_, [item for item in report.items if not item.pass_]
    done = children.run([ROOT / "build/release/stiction", "check", tmp_path / "plan.json"], limit=60)
    assert done.returncode == 0 and "the start was given by the caller" in done.stdout


def commands(task: st.Task, n: int, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Starts and commands that wander from them."""
    q, u = states(task, n)
    return q, u[:, None] + 0.02 * np.random.default_rng(4).standard_normal((n, steps, task.model.n_a)).cumsum(axis=1)


def test_rollouts_are_steps_one_after_the_other(ball: st.Task) -> None:
    q, u = commands(ball, 3, 4)
    rolled = st.rollout_batch(ball.model, q, u, threads=2)
    assert rolled.q.shape == (3, 5, ball.model.n_q) and not rolled.q.flags.writeable
    assert rolled.failed == 0 and rolled.steps == [4, 4, 4] and len(rolled) == 3
    np.testing.assert_array_equal(rolled.q[:, 0], q)
    for t in range(4):
        np.testing.assert_array_equal(rolled.q[:, t + 1], st.step_batch(ball.model, rolled.q[:, t], u[:, t]).q_next)


def test_gradient_of_rollouts_is_the_slope_along_a_direction(ball: st.Task) -> None:
    """Of commands in any layout and type of number, and with the gradient of a part of the configurations alone."""
    q, u = commands(ball, 2, 5)
    options = {"smoothing": st.Analytic(kappa=1000), "tol_complementarity": 1e-11}
    rolled = st.rollout_batch(ball.model, q, u, **options)
    slope = np.zeros_like(rolled.q)
    slope[:, -1, :3] = [1.0, -2.0, 0.5]
    by_start, by_u = st.pull_back_rollout(ball.model, rolled, np.asfortranarray(u), slope.tolist(), **options)
    assert by_start.shape == q.shape and by_u.shape == u.shape
    along = np.random.default_rng(5).standard_normal(u.shape)

    def loss(s: float) -> np.ndarray:
        return st.rollout_batch(ball.model, q, u + s * along, **options).q[:, -1, :3] @ np.array([1.0, -2.0, 0.5])

    expected = (8 * (loss(1e-5) - loss(-1e-5)) - loss(2e-5) + loss(-2e-5)) / 12e-5
    assert np.abs(expected).min() > 1e-3
    np.testing.assert_allclose((by_u * along).sum(axis=(1, 2)), expected, rtol=1e-5)


def test_rollouts_name_what_is_wrong(ball: st.Task) -> None:
    q, u = commands(ball, 2, 3)
    with pytest.raises(st.InvalidInput, match=r"^u.shape\[2\]: got 15 numbers, expected 16"):
        st.rollout_batch(ball.model, q, u[:, :, 1:])
    with pytest.raises(st.InvalidInput, match="^u: got 1 trajectories, expected 2, one for each start"):
        st.rollout_batch(ball.model, q, u[:1])
    with pytest.raises(st.InvalidInput, match=r"^u: got an array of shape \(3, 16\), expected three dimensions"):
        st.rollout_batch(ball.model, q, u[0])
    rolled = st.rollout_batch(ball.model, q, u)
    with pytest.raises(st.InvalidInput, match="^D_L_q: got 3 configurations a trajectory, expected 4"):
        st.pull_back_rollout(ball.model, rolled, u, rolled.q[:, 1:])


def test_kept_workspace_gives_the_same_bits_and_belongs_to_its_model() -> None:
    task = st.load_task("planar_hand")
    model, random = task.model, np.random.default_rng(0)
    q = np.tile(task.q_start, (50, 1))
    u = q[:, -model.n_a :] + 0.05 * random.standard_normal((50, model.n_a))
    work = st.BatchWorkspace(model, threads=2)
    for _ in range(2):
        np.testing.assert_array_equal(st.step_batch(model, q, u, workspace=work).q_next, st.step_batch(model, q, u).q_next)
    rolled = st.rollout_batch(model, q, u[:, None], workspace=work)
    weights = random.standard_normal(rolled.q.shape)
    for kept, own in zip(st.pull_back_rollout(model, rolled, u[:, None], weights, workspace=work), st.pull_back_rollout(model, rolled, u[:, None], weights)):
        np.testing.assert_array_equal(kept, own)
    other = st.load_task("planar_pushing")
    with pytest.raises(st.InvalidInput, match="^workspace: got one of another model, expected one of this model"):
        st.step_batch(other.model, other.q_start[None], other.q_start[None, 3:], workspace=work)
    with pytest.raises(st.InvalidInput, match="^threads: got 2, expected 0 with a workspace, which has its own"):
        st.step_batch(model, q, u, threads=2, workspace=work)
