"""Rollouts as functions of PyTorch and JAX. Each part runs where its package is installed: `make learners` installs both and runs this file."""

from __future__ import annotations

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

SMOOTH: dict[str, Any] = {"smoothing": st.Analytic(kappa=1000), "tol_complementarity": 1e-11}


@pytest.fixture(scope="module")
def cube() -> st.Task:
    return st.load_task("allegro_cube")


def commands(task: st.Task) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(1)
    q = np.tile(task.q_start, (3, 1))
    u = q[:, None, -task.model.n_a :] + 0.02 * random.standard_normal((3, 4, task.model.n_a)).cumsum(axis=1)
    return q, u


def expected(task: st.Task, q: np.ndarray, u: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return st.pull_back_rollout(task.model, st.rollout_batch(task.model, q, u, **SMOOTH), u, weights, **SMOOTH)


def test_extra_that_is_missing_is_named() -> None:
    for name in ("torch", "jax"):
        try:
            __import__(name)
        except ImportError:
            with pytest.raises(st.MissingExtra, match=rf"pip install 'stiction\[{name}\]'"):
                __import__(f"stiction.{name}")


def test_gradient_of_torch_is_that_of_the_library(cube: st.Task) -> None:
    torch = pytest.importorskip("torch")
    from stiction.torch import rollout, step

    q, u = commands(cube)
    start, at = torch.tensor(q, requires_grad=True), torch.tensor(u, requires_grad=True)
    rolled = rollout(cube.model, start, at, **SMOOTH)
    weights = np.random.default_rng(2).standard_normal(rolled.shape)
    (rolled * torch.tensor(weights)).sum().backward()
    by_start, by_u = expected(cube, q, u, weights)
    np.testing.assert_array_equal(start.grad.numpy(), by_start)
    np.testing.assert_array_equal(at.grad.numpy(), by_u)
    torch.testing.assert_close(step(cube.model, start, at[:, 0], **SMOOTH), rolled[:, 1])


def test_torch_refuses_what_it_cannot_take(cube: st.Task) -> None:
    torch = pytest.importorskip("torch")
    from stiction.torch import rollout

    q, u = map(torch.tensor, commands(cube))
    with pytest.raises(st.InvalidInput, match=r"^u: got float32, expected float64; convert it with .double\(\)"):
        rollout(cube.model, q, u.float())
    with pytest.raises(st.InvalidInput, match=r"^q_start: got the shape \(3, 1, 23\), expected \(N, n_q\)"):
        rollout(cube.model, q.unsqueeze(1), u)
    with pytest.raises(st.InvalidInput, match="^u: got a tensor on meta, expected one on the CPU"):
        rollout(cube.model, q, u.to("meta"))
    with pytest.raises(st.InvalidInput, match="^u: got ndarray, expected a torch.Tensor"):
        rollout(cube.model, q, u.numpy())
    at = u.clone().requires_grad_()
    (first,) = torch.autograd.grad(rollout(cube.model, q, at).pow(2).sum(), at, create_graph=True)
    with pytest.raises(RuntimeError, match="once_differentiable"):
        first.sum().backward()


def test_gradient_of_jax_is_that_of_the_library(cube: st.Task) -> None:
    jax = pytest.importorskip("jax")
    from stiction.jax import rollout

    q, u = commands(cube)
    with pytest.raises(st.InvalidInput, match="^q_start: got float32, expected float64; jax.config.update"):
        rollout(cube.model, q, u)
    jax.config.update("jax_enable_x64", True)
    weights = np.random.default_rng(2).standard_normal((3, 5, cube.model.n_q))
    loss = jax.jit(lambda start, at: (rollout(cube.model, start, at, **SMOOTH) * weights).sum())
    by_start, by_u = jax.grad(loss, argnums=(0, 1))(q, u)
    for ours, theirs in zip(expected(cube, q, u, weights), (by_start, by_u), strict=True):
        np.testing.assert_array_equal(ours, np.asarray(theirs))
