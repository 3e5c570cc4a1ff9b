"""Steps and rollouts through contact as functions of PyTorch, with gradients: `pip install 'stiction[torch]'`.

    import torch
    import stiction as st
    from stiction.torch import rollout
    task = st.load_task("allegro_cube")
    q = rollout(task.model, q_start, u, smoothing=st.Analytic(kappa=100))  # (N, T + 1, n_q)
    q[:, -1, :3].sub(goal).pow(2).sum().backward()                         # u.grad: the adjoint of the steps (S.25)

Tensors are of float64 and on the CPU; the steps run on all cores.
"""

from __future__ import annotations

from typing import Any

from . import _core
from ._extras import require

torch = require("torch", "stiction.torch", "torch")


def _array(name: str, tensor: Any, dimensions: str) -> Any:
    """Of a tensor, for the library."""
    if not isinstance(tensor, torch.Tensor):
        raise _core.InvalidInput(f"{name}: got {type(tensor).__name__}, expected a torch.Tensor")
    if tensor.device.type != "cpu":
        raise _core.InvalidInput(f"{name}: got a tensor on {tensor.device}, expected one on the CPU; move it with .cpu()")
    if tensor.dtype != torch.float64:
        raise _core.InvalidInput(f"{name}: got {str(tensor.dtype).removeprefix('torch.')}, expected float64; convert it with .double()")
    if tensor.dim() != dimensions.count(",") + 1:
        raise _core.InvalidInput(f"{name}: got the shape {tuple(tensor.shape)}, expected ({dimensions})")
    return tensor.detach().numpy()


class _Rollout(torch.autograd.Function):  # type: ignore[misc, name-defined]
    @staticmethod
    def forward(context: Any, q_start: Any, u: Any, model: _core.Model, options: dict[str, Any], smoothing: Any, strict: bool) -> Any:
        commands = _array("u", u, "N, T, n_a")
        rolled = _core.rollout_batch(model, _array("q_start", q_start, "N, n_q"), commands, **options)
        if strict and rolled.failed:
            first = next(i for i, status in enumerate(rolled.status) if status != _core.Status.Solved)
            raise ArithmeticError(f"trajectory {first}, step {rolled.steps[first]}: {rolled.status[first].name}; strict=False leaves it where it is")
        context.of = model, rolled, commands, options if smoothing is None else options | {"smoothing": smoothing}
        return torch.from_numpy(rolled.q.copy())

    @staticmethod
    @torch.autograd.function.once_differentiable  # type: ignore[untyped-decorator, unused-ignore]
    def backward(context: Any, D_L_q: Any) -> Any:
        model, rolled, commands, options = context.of
        by_start, by_u = _core.pull_back_rollout(model, rolled, commands, D_L_q.numpy(), **options)
        return torch.from_numpy(by_start.copy()), torch.from_numpy(by_u.copy()), None, None, None, None


def rollout(model: _core.Model, q_start: Any, u: Any, *, gradient_smoothing: Any = None, strict: bool = True, **options: Any) -> Any:
    """Computes N trajectories of T steps, as a differentiable function of PyTorch.

    model: Model of the scene.
    q_start: configurations at the start (N, n_q).
    u: commands (N, T, n_a) [m or rad].
    gradient_smoothing: smoothing of the steps whose derivatives are used, such as st.Analytic(kappa=100). None: the smoothing of the steps. An
      exact step has the derivative 0 if nothing touches.
    strict: True: a step without a solution raises ArithmeticError. False: its trajectory stays there, and the gradient passes that step
      unchanged.
    options: threads, h, smoothing and the other options of stiction.rollout_batch.

    Returns configurations, the start first (N, T + 1, n_q). The gradient by a quaternion is tangent to the sphere of unit quaternions. There are
    no second derivatives.
    """
    return _Rollout.apply(q_start, u, model, options, gradient_smoothing, strict)


def step(model: _core.Model, q: Any, u: Any, *, gradient_smoothing: Any = None, strict: bool = True, **options: Any) -> Any:
    """Returns the next configurations (N, n_q) from configurations q (N, n_q) and commands u (N, n_a). Other arguments are those of rollout()."""
    if isinstance(u, torch.Tensor) and u.dim() != 2:
        raise _core.InvalidInput(f"u: got the shape {tuple(u.shape)}, expected (N, n_a)")
    return rollout(model, q, u.unsqueeze(1), gradient_smoothing=gradient_smoothing, strict=strict, **options)[:, 1]
