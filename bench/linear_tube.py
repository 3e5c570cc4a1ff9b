"""The tube of a plan by linear propagation, to be compared with the bundle of stiction.calc_tube(): derivatives of the steps of a plan, one after the other.

    E_{k+1} = A_k E_k ,    G_{k+1} = A_k G_k + D_k ,    b_{k+1} = A_k b_k + (exact step ⊖ smoothed step)

E: half axes of the start's error. G: what friction and masses do, D_k by central differences of the step over their whole sets. b: what smoothing adds. The radius at a rest
is that of the zonotope of all of them, with the motion of the object alone.
"""

import dataclasses

import numpy as np

from by_task import stiction as st


@dataclasses.dataclass
class LinearRest:
    centre: st.Pose
    position: float
    angle: float


def half_axes(model, errors):
    """Of the start (n_v, directions): as draw_world() has it, each direction alone."""
    gravity = np.array(model.scene.gravity)
    axes = []
    for item in model.objects:
        place = np.arange(item.v_begin, item.v_begin + item.n_v)
        if item.n_v == 6:
            up = gravity / np.linalg.norm(gravity) if np.any(gravity) else None
            for k in range(6):
                axis = np.zeros(model.n_v)
                axis[place[k]] = errors.position if k < 3 else errors.angle
                if up is None or (abs(up[k % 3]) < 0.5) == (k < 3):
                    axes.append(axis)
            continue
        for v in place:
            axis = np.zeros(model.n_v)
            axis[v] = errors.angle if model.dofs[v].kind == st.DofKind.Revolute else errors.position
            axes.append(axis)
    return np.array(axes).T


def weights(model, count, share):
    """Force of gravity on free objects that are heavier by a share (steps, n_v)."""
    tau = np.zeros((count, model.n_v))
    for item in model.objects:
        if item.n_v == 6:
            tau[:, item.v_begin : item.v_begin + 3] = share * item.mass * np.array(model.scene.gravity)
    return tau


def linear_tube(plan, errors, kappa=None):
    """Rests of the plan. kappa: sharpness of the smoothed derivatives; None: those of exact steps."""
    model, name = plan.task.model, plan.task.model.object_names[plan.task.goal.object]
    q, u = plan.q[:-1], plan.u[1:]
    how = {"h": plan.h, "threads": 1}
    exact = st.step_batch(model, q, u, **how)
    smoothing = st.Exact() if kappa is None else st.Analytic(kappa=kappa)
    local = st.step_batch(model, q, u, with_A=True, smoothing=smoothing, **({**how, "tol_complementarity": 1e-8}))
    difference = lambda a, b: np.array([model.local(x, y) for x, y in zip(a.q_next, b.q_next, strict=True)])
    softer, harder = (st.step_batch(model, q, u, friction_scale=1 + sign * errors.friction, **how) for sign in (-1, 1))
    lighter, heavier = (st.step_batch(model, q, u, tau_ext=weights(model, len(q), sign * errors.mass), **how) for sign in (-1, 1))
    D = np.stack([difference(softer, harder) / 2, difference(lighter, heavier) / 2], axis=2)
    bias = difference(local, exact) if kappa else np.zeros((len(q), model.n_v))
    ends = np.cumsum([len(segment.q) for segment in plan.segments])
    rests = {int(ends[rest.last_segment]) for rest in st.calc_tube(plan, scenarios=1).rests}
    first = sum(len(segment.q) for segment in plan.segments if segment.kind == st.SegmentKind.Settle)
    E, G, b, out = half_axes(model, errors), np.zeros((model.n_v, 2)), np.zeros(model.n_v), []
    for k in range(first, len(q)):
        A = local.A[k]
        with np.errstate(over="ignore", invalid="ignore"):  # such a tube has no bound
            E, G, b = A @ E, A @ G + D[k], A @ b + bias[k]
        if k + 1 in rests:
            out.append(radius(model, name, plan.q[k + 1], np.column_stack([E, G, b])))
    return out


def radius(model, name, q, generators):
    """Of the zonotope with these generators (n_v, generators): how far each of them moves the object, by differences of its pose."""
    pose = model.object_pose(q, name)
    if not np.all(np.abs(generators) < 1e100):
        return LinearRest(pose, np.inf, np.inf)
    position, angle, step = np.zeros(3), 0.0, 1e-6
    for generator in generators.T:
        size = max(np.abs(generator).max(), 1e-12)
        moved = model.object_pose(model.retract(q, generator * (step / size)), name)
        R = pose.R.T @ moved.R
        turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        position += np.abs(moved.p - pose.p) * size / step
        angle += np.linalg.norm(turn) * size / step
    return LinearRest(pose, float(np.linalg.norm(position)), float(angle))
