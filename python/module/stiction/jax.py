"""Steps and rollouts through contact as functions of JAX, with gradients: `pip install 'stiction[jax]'`.

    import jax
    jax.config.update("jax_enable_x64", True)
    from stiction.jax import rollout
    gradient = jax.grad(lambda u: (rollout(model, q_start, u)[:, -1, :3] ** 2).sum())(u)

The steps run on the CPU, on all cores, also inside of jax.jit.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from . import _core
from ._extras import require

jax = require("jax", "stiction.jax", "jax")


def _check(name: str, value: Any, dimensions: str) -> Any:
    value = jax.numpy.asarray(value)
    if value.dtype != np.float64:
        raise _core.InvalidInput(f"{name}: got {value.dtype}, expected float64; jax.config.update('jax_enable_x64', True) allows it")
    if value.ndim != dimensions.count(",") + 1:
        raise _core.InvalidInput(f"{name}: got the shape {value.shape}, expected ({dimensions})")
    return value


def _roll(model: _core.Model, options: dict[str, Any], q_start: Any, u: Any) -> Any:
    return np.asarray(_core.rollout_batch(model, np.asarray(q_start), np.asarray(u), **options).q)


def _pull_back(model: _core.Model, options: dict[str, Any], smoothing: Any, q_start: Any, u: Any, D_L_q: Any) -> Any:
    rolled = _core.rollout_batch(model, np.asarray(q_start), np.asarray(u), **options)
    of = options if smoothing is None else options | {"smoothing": smoothing}
    return tuple(map(np.asarray, _core.pull_back_rollout(model, rolled, np.asarray(u), np.asarray(D_L_q), **of)))


def rollout(model: _core.Model, q_start: Any, u: Any, *, gradient_smoothing: Any = None, **options: Any) -> Any:
    """Computes N trajectories of T steps, as a differentiable function of JAX.

    model: Model of the scene.
    q_start: configurations at the start (N, n_q).
    u: commands (N, T, n_a) [m or rad].
    gradient_smoothing: smoothing of the steps whose derivatives are used, such as st.Analytic(kappa=100). None: the smoothing of the steps. An
      exact step has the derivative 0 if nothing touches.
    options: threads, h, smoothing and the other options of stiction.rollout_batch.

    Returns configurations, the start first (N, T + 1, n_q). If a step has no solution, its trajectory stays there. The gradient by a quaternion
    is tangent to the sphere of unit quaternions. There are no second derivatives.
    """
    q_start, u = _check("q_start", q_start, "N, n_q"), _check("u", u, "N, T, n_a")

    def forward(q_start: Any, u: Any) -> Any:
        shape = jax.ShapeDtypeStruct((u.shape[0], u.shape[1] + 1, model.n_q), np.float64)
        return jax.pure_callback(partial(_roll, model, options), shape, q_start, u)

    def backward(saved: Any, D_L_q: Any) -> Any:
        shapes = tuple(jax.ShapeDtypeStruct(x.shape, np.float64) for x in saved)
        return jax.pure_callback(partial(_pull_back, model, options, gradient_smoothing), shapes, *saved, D_L_q)

    rolled = jax.custom_vjp(forward)
    rolled.defvjp(lambda q_start, u: (rolled(q_start, u), (q_start, u)), backward)
    return rolled(q_start, u)


def step(model: _core.Model, q: Any, u: Any, *, gradient_smoothing: Any = None, **options: Any) -> Any:
    """Returns the next configurations (N, n_q) from configurations q (N, n_q) and commands u (N, n_a). Other arguments are those of rollout()."""
    return rollout(model, q, _check("u", u, "N, n_a")[:, None], gradient_smoothing=gradient_smoothing, **options)[:, 1]
