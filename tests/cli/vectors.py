"""Vectors and rotations of three dimensions, as lists."""

import math

Vector = list[float]


def turn(q: Vector, x: Vector) -> Vector:
    w, u = q[0], q[1:]
    t = [2 * c for c in cross(u, x)]
    return [a + w * b + c for a, b, c in zip(x, t, cross(u, t), strict=True)]


def cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a: Vector, b: Vector) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def back(q: Vector) -> Vector:
    return [q[0], -q[1], -q[2], -q[3]]


def less(a: Vector, b: Vector) -> Vector:
    return [x - y for x, y in zip(a, b, strict=True)]


def more(a: Vector, way: float, b: Vector) -> Vector:
    return [x + way * y for x, y in zip(a, b, strict=True)]


def unit(v: Vector) -> Vector | None:
    size = math.hypot(*v)
    return [x / size for x in v] if size > 1e-12 else None


def space(v: Vector) -> Vector:
    return [*v, 0.0][:3]
