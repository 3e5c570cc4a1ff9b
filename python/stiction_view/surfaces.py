"""Triangles that are looked at, made few and smooth."""

from __future__ import annotations

import numpy as np

Surface = tuple[np.ndarray, np.ndarray]  # vertices (n, 3), triangles (m, 3)

CREASE = 0.7  # [rad] across edges sharper than this the light breaks


def _numbered(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where each row of (n, 3) integers stands first, and the number of its kind."""
    rows = np.ascontiguousarray(keys.astype(np.int64)).view([("", np.int64)] * keys.shape[1]).ravel()
    _, first, number = np.unique(rows, return_index=True, return_inverse=True)
    return first, number.ravel()


def _without_flat(triangles: np.ndarray) -> np.ndarray:
    """Those whose three corners differ, each once."""
    a, b, c = triangles.T
    kept = triangles[(a != b) & (b != c) & (c != a)]
    first, _ = _numbered(np.sort(kept, axis=1)) if len(kept) else (np.empty(0, dtype=int), None)
    return kept[np.sort(first)]


def _used(vertices: np.ndarray, triangles: np.ndarray) -> Surface:
    used, corners = np.unique(triangles, return_inverse=True)
    return vertices[used], corners.reshape(-1, 3)


def weld(surface: Surface) -> Surface:
    """Points that files repeat for every triangle or normal, each once."""
    vertices, triangles = np.asarray(surface[0], dtype=float), np.asarray(surface[1])
    size = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
    if size == 0:
        return vertices[:0], triangles[:0]
    first, number = _numbered(np.round(vertices / (1e-6 * size)))
    return _used(vertices[first], _without_flat(number[triangles]))


def _planes(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (m, 3) and areas (m) of triangles; the normal of a triangle without area is 0."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    twice = np.linalg.norm(cross, axis=1)
    return cross / np.where(twice > 0, twice, 1)[:, None], twice / 2


def _cluster(surface: Surface, cell: float) -> Surface:
    """One vertex for all in a cell of a grid: the point nearest to the planes of the triangles that meet there (Lindstrom 2000)."""
    vertices, triangles = surface
    _, number = _numbered(np.floor((vertices - vertices.min(axis=0)) / cell))
    count = number.max() + 1
    kept = _without_flat(number[triangles])
    normal, area = _planes(vertices, triangles)
    middle = vertices[triangles].mean(axis=1)
    A, b, mean, members = np.zeros((count, 3, 3)), np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
    np.add.at(mean, number, vertices)
    np.add.at(members, number, 1)
    mean /= members[:, None]
    outer = area[:, None, None] * normal[:, :, None] * normal[:, None, :]
    for k in range(3):
        of = number[triangles[:, k]]
        np.add.at(A, of, outer)
        np.add.at(b, of, np.einsum("nij,nj->ni", outer, middle - mean[of]))
    weight = 0.05 * np.trace(A, axis1=1, axis2=2) + 1e-30
    step = np.linalg.solve(A + weight[:, None, None] * np.eye(3), b[:, :, None])[:, :, 0]
    return _used(mean + np.clip(step, -cell / 2, cell / 2), kept)


def simplify(surface: Surface, most: int) -> Surface:
    """At most so many triangles; a surface that has no more stays as it is."""
    vertices, triangles = surface
    if len(triangles) <= most:
        return surface
    cell = float(np.sqrt(2 * _planes(vertices, triangles)[1].sum() / most))
    while True:
        out = _cluster(surface, cell)
        if len(out[1]) <= most:
            return out
        cell *= max(1.05, float(np.sqrt(len(out[1]) / most)))


def split_creases(surface: Surface) -> Surface:
    """Vertices doubled along sharp edges, so that normals that are means over triangles leave these sharp."""
    vertices, triangles = surface
    if not len(triangles):
        return surface
    normal, _ = _planes(vertices, triangles)
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    corner = np.arange(3 * len(triangles))
    after = np.roll(corner.reshape(-1, 3), -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    same = (low[order[1:]] == low[order[:-1]]) & (high[order[1:]] == high[order[:-1]])
    one, two = order[:-1][same], order[1:][same]  # sides of triangles that share an edge
    smooth = np.einsum("ij,ij->i", normal[one // 3], normal[two // 3]) >= np.cos(CREASE)
    one, two = one[smooth], two[smooth]
    turned = start[one] == end[two]  # as neighbours do whose triangles wind alike
    pairs = np.concatenate([np.column_stack([one, np.where(turned, after[two], two)]), np.column_stack([after[one], np.where(turned, two, after[two])])])
    group = corner.copy()
    while True:
        least = np.minimum(group[pairs[:, 0]], group[pairs[:, 1]])
        before = group.copy()
        np.minimum.at(group, pairs[:, 0], least)
        np.minimum.at(group, pairs[:, 1], least)
        group = group[group]
        if (group == before).all():
            break
    _, first, number = np.unique(group, return_index=True, return_inverse=True)
    return vertices[start[first]], number.reshape(-1, 3)


def share_out(counts: list[int], most: int) -> int:
    """The largest limit for each that keeps the sum below `most`."""
    low, high = 1, max([1, *counts])
    while low < high:
        middle = (low + high + 1) // 2
        if sum(min(count, middle) for count in counts) <= most:
            low = middle
        else:
            high = middle - 1
    return low


def find_ways_out(points: np.ndarray, normals: np.ndarray, surface: Surface, most: float) -> np.ndarray:
    """How far each point (n, 3) has to go along its normal until no triangle within `most` lies before it; 0: none does. Lines meet triangles after Möller and Trumbore 1997."""
    vertices, triangles = surface
    out = np.zeros(len(points))
    if not len(triangles):
        return out
    a = vertices[triangles[:, 0]]
    ab, ac = vertices[triangles[:, 1]] - a, vertices[triangles[:, 2]] - a
    low, high = (f(vertices[triangles], axis=1) for f in (np.min, np.max))
    for i, (p, n) in enumerate(zip(points, normals)):
        ends = np.stack([p, p + most * n])
        near = np.flatnonzero(((low <= ends.max(axis=0)) & (high >= ends.min(axis=0))).all(axis=1))
        across = np.cross(n, ac[near])
        slant = np.einsum("ij,ij->i", ab[near], across)
        with np.errstate(divide="ignore", invalid="ignore"):  # triangles along the line are not met
            from_a = p - a[near]
            u = np.einsum("ij,ij->i", from_a, across) / slant
            turned = np.cross(from_a, ab[near])
            v = turned @ n / slant
            t = np.einsum("ij,ij->i", ac[near], turned) / slant
            met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= most)
        out[i] = t[met].max(initial=0)
    return out
