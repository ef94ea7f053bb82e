"""How far shapes reach into planes and into each other, from their definitions alone: a sphere, a
disc, a rod and a capsule are a segment along x with a radius, a box is its half edges."""

import math

from random_scenes import Scene
from vectors import Vector, back, cross, dot, less, more, space, turn, unit

Pose = tuple[Vector, Vector]  # place and quaternion


def reach(shape: Scene, q: Vector, way: Vector) -> float:
    """How far the shape reaches from its centre along the way."""
    n = turn(back(q), way)
    if shape["type"] == "box":
        return dot([abs(c) for c in n], space(shape["half"]))
    return shape.get("half_length", 0.0) * abs(n[0]) + shape.get("r", 0.0)


def behind(shape: Scene, x: Vector, q: Vector, normal: Vector, offset: float) -> float:
    return offset - dot(normal, x) + reach(shape, q, normal)


def axes(shape: Scene, q: Vector) -> list[Vector]:
    units = [[float(k == m) for m in range(3)] for k in range(3)]
    return [turn(q, e) for e in units]


def ends(shape: Scene, pose: Pose) -> list[Vector]:
    """Points that the shape is spanned by, but for its radius."""
    x, q = pose
    e = axes(shape, q)
    if shape["type"] != "box":
        half = shape.get("half_length", 0.0)
        return [more(x, s * half, e[0]) for s in ((-1, 1) if half > 0 else (1,))]
    a, b, c = space(shape["half"])
    corners = [more(more(x, s * a, e[0]), t * b, e[1]) for s in (-1, 1) for t in (-1, 1)]
    return corners if c == 0 else [more(p, s * c, e[2]) for p in corners for s in (-1, 1)]


def nearest(shape: Scene, pose: Pose, p: Vector) -> Vector:
    """Point of the segment, or of the box, that is nearest to p."""
    x, q = pose
    local = turn(back(q), less(p, x))
    half = space(shape["half"]) if shape["type"] == "box" else [shape.get("half_length", 0.0), 0, 0]
    kept = [max(-h, min(h, c)) for c, h in zip(local, half, strict=True)]
    return [a + b for a, b in zip(x, turn(q, kept), strict=True)]


def ways(a: Scene, b: Scene, one: Pose, other: Pose) -> list[Vector]:
    """Directions in which the shapes are apart where they are apart at all: normals of faces,
    products of edges, and from a point of one to the nearest of the other."""
    of_one, of_other = axes(a, one[1]), axes(b, other[1])
    found = of_one + of_other + [cross(u, v) for u in of_one for v in of_other]
    found += [less(nearest(b, other, p), p) for p in ends(a, one)]
    found += [less(nearest(a, one, p), p) for p in ends(b, other)]
    found += [less(one[0], other[0])]
    return [u for u in map(unit, found) if u is not None]


def depth(a: Scene, b: Scene, one: Pose, other: Pose, way: Vector) -> float:
    apart = abs(dot(less(one[0], other[0]), way))
    return reach(a, one[1], way) + reach(b, other[1], way) - apart


def between(
    dim: int, a: Scene, b: Scene, one: Pose, other: Pose, enough: float = -math.inf
) -> float:
    """Least way to part the shapes, negative where they are apart; any number below `enough` where
    it is. Never less than the truth, and the truth where a face, an edge or a point touches."""
    if radius(a) + radius(b) < math.dist(one[0], other[0]):
        return -math.inf
    best = math.inf
    for way in ways(a, b, one, other):
        if dim == 2 and abs(way[2]) > 1e-9:
            continue
        best = min(best, depth(a, b, one, other, way))
        if best < enough:
            break
    return best


def radius(shape: Scene) -> float:
    """Radius of the ball that holds it."""
    if shape["type"] == "box":
        return math.hypot(*shape["half"])
    return shape.get("half_length", 0.0) + shape.get("r", 0.0)
