"""A search while it runs: its trees as lines that become more, and the way to the node that is nearest the goal."""

from __future__ import annotations

import threading

import numpy as np
import stiction as st
import viser

from ..bodies import OBJECT, OBJECT_AXES, TREE

ROOT = "/growing"


def farthest_axis(start: st.Pose, goal: st.Pose, length: float) -> int:
    """That axis of an object whose end goes farthest from start to goal."""
    return int(np.argmax(np.linalg.norm(goal.p[:, None] + length * goal.R - start.p[:, None] - length * start.R, axis=0)))


class Trees:
    """What was told of the trees of a run: where the end of an axis of the object is at each node. Told by one thread, read by another."""

    def __init__(self, model: st.Model, name: str, axis: int, length: float):
        self.model, self.name, self.axis, self.length = model, name, axis, length
        self._lock = threading.Lock()
        self._ends: dict[int, list[np.ndarray]] = {}  # of each tree
        self._parents: dict[int, list[int]] = {}
        self._new: list[np.ndarray] = []  # edges (2, 3) that were not asked for yet
        self._best = (np.inf, 0, -1)  # tolerances from the goal, tree, node

    def take(self, growth: st.Growth) -> None:
        poses = [self.model.object_pose(q, self.name) for q in growth.q]
        ends = [X.p + self.length * X.R[:, self.axis] for X in poses]
        with self._lock:
            known, parents = self._ends.setdefault(growth.tree, []), self._parents.setdefault(growth.tree, [])
            known += ends
            parents += growth.parents
            self._new += [np.array([known[parent], end]) for parent, end in zip(growth.parents, ends) if parent >= 0]
            if growth.best_ratio < self._best[0]:
                self._best = (growth.best_ratio, growth.tree, growth.best)

    def edges(self) -> np.ndarray:
        """Those that came since the last call (n, 2, 3), without those along which the object rests [m]."""
        with self._lock:
            new, self._new = self._new, []
        out = np.array(new).reshape(-1, 2, 3)
        return out[np.linalg.norm(out[:, 1] - out[:, 0], axis=1) > 1e-3 * self.length]

    def way(self) -> np.ndarray:
        """From the start to the node that is nearest the goal (n, 2, 3) [m]."""
        with self._lock:
            _, tree, node = self._best
            ends, parents = self._ends.get(tree, []), self._parents.get(tree, [])
            points = []
            while node >= 0:
                points.append(ends[node])
                node = parents[node]
        points.reverse()
        return np.array([points[:-1], points[1:]]).swapaxes(0, 1).reshape(-1, 2, 3)


class Growing:
    """Trees as they are drawn; show() adds what came."""

    def __init__(self, server: viser.ViserServer, trees: Trees):
        self.scene, self.trees = server.scene, trees
        self.root = self.scene.add_frame(ROOT, show_axes=False)
        self.parts: list[viser.LineSegmentsHandle] = []
        self.best: viser.LineSegmentsHandle | None = None
        self.numbered = 0

    def show(self, visible: bool) -> None:
        if self.root.visible != visible:
            self.root.visible = visible
        edges = self.trees.edges()
        if len(edges) == 0:
            return
        while self.parts and len(self.parts[-1].points) <= len(edges):  # few parts, and none of them sent often
            last = self.parts.pop()
            edges = np.concatenate([last.points, edges])
            last.remove()
        self.parts.append(self._add(edges, TREE, 1.0))
        way = self.trees.way()
        if len(way) > 0:
            if self.best is not None:
                self.best.remove()
            self.best = self._add(way, OBJECT[0], 3.0)

    def _add(self, lines: np.ndarray, color: tuple[int, int, int], width: float) -> viser.LineSegmentsHandle:
        self.numbered += 1
        return self.scene.add_line_segments(f"{ROOT}/part{self.numbered}", lines.astype(np.float32), color, thickness=width, thickness_units="screen")

    def end(self) -> None:
        self.root.remove()  # and all below it
        self.parts, self.best = [], None


def start_growing(server: viser.ViserServer, task: st.Task, size: float) -> Growing:
    """Of a plan that is about to be searched for. `size`: half the extent of its object [m]."""
    model, goal = task.model, task.goal
    name, length = model.object_names[goal.object], OBJECT_AXES * size
    axis = farthest_axis(model.object_pose(task.q_start, name), goal.X_WG, length)
    return Growing(server, Trees(model, name, axis, length))
