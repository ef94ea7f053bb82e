"""Gaps between the bodies of a scene, from their poses: exact for balls and planes; for convex
hulls the least overlap over all axes of the separating-axis theorem, which is their depth where
they overlap."""

from __future__ import annotations

import itertools

import numpy as np

from engine_room.scene import Body, Plane

EDGE = 1e-9  # shorter than this, a cross product of two edges is no axis


def rotation(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _hull(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Face normals and edge directions of a prism or a box, from its corners: those of all planes
    through three corners with every other corner on one side."""
    scale = np.abs(points).max()
    normals: list[np.ndarray] = []
    for i, j, k in itertools.combinations(range(len(points)), 3):
        n = np.cross(points[j] - points[i], points[k] - points[i])
        length = np.linalg.norm(n)
        if length < EDGE * scale**2:
            continue
        n = n / length
        side = (points - points[i]) @ n
        if side.max() > EDGE * scale and side.min() < -EDGE * scale:
            continue
        if all(abs(abs(n @ m) - 1) > EDGE for m in normals):
            normals.append(n)
    edges: list[np.ndarray] = []
    for n, m in itertools.combinations(normals, 2):
        e = np.cross(n, m)
        length = np.linalg.norm(e)
        if length > EDGE and all(abs(abs(e @ d) / length - 1) > EDGE for d in edges):
            edges.append(e / length)
    return np.array(normals), np.array(edges)


_hulls: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}


def hull(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    key = points.tobytes()
    if key not in _hulls:
        _hulls[key] = _hull(points)
    return _hulls[key]


def to_plane(body: Body, pos: np.ndarray, quat: np.ndarray, plane: Plane) -> float:
    """Signed distance [m]."""
    if body.part.kind == "ball":
        return float(plane.up @ pos) - plane.offset - float(body.part.size[0])
    return float(((body.part.points @ rotation(quat).T + pos) @ plane.up).min()) - plane.offset


def reach(body: Body) -> float:
    """Radius of a sphere about the centre that holds the body."""
    if body.part.kind == "ball":
        return float(body.part.size[0])
    return float(np.linalg.norm(body.part.points, axis=1).max())


def between(
    a: Body, pa: np.ndarray, qa: np.ndarray, b: Body, pb: np.ndarray, qb: np.ndarray
) -> tuple[float, np.ndarray]:
    """(gap [m], unit direction from b to a). Overlap is negative; of hulls apart the gap is a lower
    bound of their distance."""
    if a.part.kind == "ball" and b.part.kind == "ball":
        d = pa - pb
        length = float(np.linalg.norm(d))
        up = d / length if length > 0 else np.array([0.0, 0.0, 1.0])
        return length - float(a.part.size[0] + b.part.size[0]), up
    if a.part.kind == "ball":
        return _ball_hull(a, pa, b, pb, qb)
    if b.part.kind == "ball":
        gap, up = _ball_hull(b, pb, a, pa, qa)
        return gap, -up
    return _hulls_gap(a, pa, qa, b, pb, qb)


def _axes(ra: np.ndarray, rb: np.ndarray, a: Body, b: Body) -> np.ndarray:
    na, ea = hull(a.part.points)
    nb, eb = hull(b.part.points)
    na, ea, nb, eb = na @ ra.T, ea @ ra.T, nb @ rb.T, eb @ rb.T
    crossed = np.cross(ea[:, None, :], eb[None, :, :]).reshape(-1, 3)
    length = np.linalg.norm(crossed, axis=1)
    crossed = crossed[length > 1e-6] / length[length > 1e-6, None]
    return np.vstack([na, nb, crossed])


def _hulls_gap(
    a: Body, pa: np.ndarray, qa: np.ndarray, b: Body, pb: np.ndarray, qb: np.ndarray
) -> tuple[float, np.ndarray]:
    ra, rb = rotation(qa), rotation(qb)
    axes = _axes(ra, rb, a, b)
    on_a = (a.part.points @ ra.T) @ axes.T + pa @ axes.T
    on_b = (b.part.points @ rb.T) @ axes.T + pb @ axes.T
    above = on_a.min(axis=0) - on_b.max(axis=0)  # a above b along the axis
    below = on_b.min(axis=0) - on_a.max(axis=0)
    i, j = int(np.argmax(above)), int(np.argmax(below))
    if above[i] >= below[j]:
        return float(above[i]), axes[i]
    return float(below[j]), -axes[j]


def _ball_hull(
    ball: Body, centre: np.ndarray, other: Body, pos: np.ndarray, quat: np.ndarray
) -> tuple[float, np.ndarray]:
    """Of a box: by the nearest point of it."""
    if other.part.kind != "box":
        raise NotImplementedError("a ball on a hull")
    turn = rotation(quat)
    local = turn.T @ (centre - pos)
    near = np.clip(local, -other.part.size, other.part.size)
    out = local - near
    length = float(np.linalg.norm(out))
    r = float(ball.part.size[0])
    if length > 0:
        return length - r, turn @ (out / length)
    depth = other.part.size - np.abs(local)
    k = int(np.argmin(depth))
    up = np.zeros(3)
    up[k] = 1.0 if local[k] >= 0 else -1.0
    return -float(depth[k]) - r, turn @ up
