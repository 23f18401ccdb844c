"""Closed surfaces of triangles for the tests."""

from __future__ import annotations

import numpy as np


def cube() -> tuple[np.ndarray, np.ndarray]:
    """The unit cube about the origin, 12 triangles."""
    points = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]) - 0.5
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, np.array([(a, b, c) for q in quads for a, b, c in (q[:3], (q[0], *q[2:]))])


def icosphere(levels: int, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """A sphere of 20 * 4^levels triangles."""
    g = 0.5 * (1 + np.sqrt(5))
    first = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0)]
    points = np.array([*first, *((z, x, y) for x, y, z in first), *((y, z, x) for x, y, z in first)], float)
    distance = np.linalg.norm(points[:, None] - points, axis=2)
    near = np.isclose(distance, 2.0)
    triangles = np.array(
        [(a, b, c) for a in range(12) for b in range(a) for c in range(b) if near[a, b] and near[b, c] and near[a, c]]
    )
    for _ in range(levels):
        points, triangles = _split(points, triangles)
    return points / np.linalg.norm(points, axis=1)[:, None] * radius, triangles


def _split(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    unique, index = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    middle = points[unique].sum(1)
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    ab, bc, ca = (len(points) + index.reshape(-1, 3)).T
    a, b, c = triangles.T
    points = points / np.linalg.norm(points, axis=1)[:, None]
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([points, middle]), np.concatenate([np.stack(part, axis=1) for part in parts])


def torus(ring: float, tube: float, n: int = 96) -> tuple[np.ndarray, np.ndarray]:
    """A torus about the z axis, 2 n^2 triangles."""
    u, v = np.meshgrid(*[np.arange(n) * 2 * np.pi / n] * 2, indexing="ij")
    rho = ring + tube * np.cos(v)
    points = np.stack([rho * np.cos(u), rho * np.sin(u), tube * np.sin(v)], axis=2).reshape(-1, 3)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a, b, c, d = i * n + j, (i + 1) % n * n + j, (i + 1) % n * n + (j + 1) % n, i * n + (j + 1) % n
    return points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
