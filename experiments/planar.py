"""Pictures of the planar systems, in the y–z plane."""

from __future__ import annotations

import numpy as np
import stiction as st
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

FINGER_RADIUS = 0.05  # of the spheres of the planar hand [m]
BALL_RADIUS = 0.25
PUSHER_RADIUS = 0.1
BOX_SIZE = 1.0


def draw_object(ax: Axes, name: str, q_u: np.ndarray, **style) -> None:
    """The ball of a hand with a line that shows its angle, or the box, at (y, z, θ about x)."""
    y, z, angle = q_u[:3]
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    style = {"fill": False, "lw": 1.2} | style
    if name == "planar_pushing":
        corners = BOX_SIZE / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        ax.add_patch(Polygon(corners @ turn.T + (y, z), **style))
    else:
        ax.add_patch(Circle((y, z), BALL_RADIUS, **style))
    size = BOX_SIZE / 2 if name == "planar_pushing" else BALL_RADIUS
    end = turn @ (0, size) + (y, z)
    ax.plot([y, end[0]], [z, end[1]], color=style.get("ec", "k"), lw=style["lw"], ls=style.get("ls", "-"))


def draw_robot(ax: Axes, model: st.Model, q: np.ndarray, colour: str = "0.6") -> None:
    poses = model.calc_kinematics(q).X_WB
    radius = PUSHER_RADIUS if model.n_a == 2 else FINGER_RADIUS
    for geometry in model.geometries:
        if model.bodies[geometry.body].kind == st.BodyKind.Object:
            continue
        X_WB = poses[geometry.body]
        centre = np.asarray(X_WB.R) @ np.asarray(geometry.X_BG.p) + np.asarray(X_WB.p)
        ax.add_patch(Circle(centre[1:], radius, color=colour, lw=0))


def finish(ax: Axes) -> None:
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.grid(False)
    ax.set_xticks([])
    ax.set_yticks([])
