"""The judge: what a motion is worth, from its states and contact forces alone. The same functions
judge the engines and our own formulations; no engine is asked what it thinks of itself.

    error        |got - expected| of the scene's first kinematic check [its unit]
    penetration  largest overlap of any pair, from the shapes and the poses [m]
    creep        largest distance that a body still goes after the scene is at rest, over the time
                 left [m/s]
    energy gain  largest rise of kinetic plus gravitational energy over any earlier value [J]
    coulomb      mean over the steps of  sum |f_t - P(f_t - (m/h) u_t)| / sum f_n,  P the projection
                 on the disc of radius mu f_n, f the mean force of the step, u the velocity at the
                 contact after it, m the reduced mass of the pair [1]; 0 for exact Coulomb friction
"""

from __future__ import annotations

import dataclasses

import numpy as np

from engine_room import geometry
from engine_room.motion import Contact, Motion
from engine_room.scene import Scene

SAMPLES = 40  # states at which overlaps and contact laws are looked at
KINEMATIC = ("state", "max_drift", "window_max", "window_min")


@dataclasses.dataclass
class Verdict:
    """Everything that is measured; None where the motion or the scene does not tell."""

    error: float | None
    error_quantity: str
    penetration: float
    creep: float | None
    energy_gain: float | None
    coulomb: float | None
    n_contact: int | None
    finite: bool


# ---- quantities -------------------------------------------------------------------------------


def angle(q: np.ndarray) -> np.ndarray:
    """Planar turn about z of quaternions (..., 4) [rad], continuous in time."""
    return np.unwrap(2.0 * np.arctan2(q[..., 3], q[..., 0]), period=4.0 * np.pi, axis=0)


def quantity(scene: Scene, m: Motion, check: dict) -> np.ndarray:
    """BODY.NAME of a check at every time (FORMATS 5); along `dir`, or the length, of a vector."""
    name, _, what = check["var"].partition(".")
    body = scene.index()[name]
    columns = {"pos": m.pos, "vel": m.vel, "omega": m.omega}
    plain = {
        f"{p}{a}": (key, i) for p, key in (("", "pos"), ("v", "vel")) for i, a in enumerate("xyz")
    }
    plain |= {f"omega.{a}": ("omega", i) for i, a in enumerate("xyz")}
    if what == "angle":
        return angle(m.quat[:, body])
    if what == "omega" and scene.dim == 2:
        return m.omega[:, body, 2]
    if what in plain:
        key, i = plain[what]
        return columns[key][:, body, i]
    values = columns[what][:, body]
    if check["type"] == "max_drift" and "dir" not in check:
        return values  # the departure of the vector
    if "dir" in check:
        along = np.array([*check["dir"], 0.0][:3])
        return values @ along
    return np.linalg.norm(values, axis=1)


def measured(scene: Scene, m: Motion, check: dict) -> float:
    """The number that a kinematic check compares."""
    x = quantity(scene, m, check)
    if check["type"] == "state":
        return float(np.interp(check["t"], m.t, x))
    late = (m.t >= check.get("t0", 0.0) - 1e-9) & (m.t <= check.get("t1", np.inf) + 1e-9)
    if check["type"] == "max_drift":
        away = x[late] - x[0]
        return float(np.max(np.abs(away) if away.ndim == 1 else np.linalg.norm(away, axis=1)))
    return float(np.max(x[late]) if check["type"] == "window_max" else np.min(x[late]))


def applies(check: dict, laws: list[str]) -> bool:
    """A kinematic check of rigid contact with isotropic friction."""
    forms = check.get("forms", [])
    return (
        check["type"] in KINEMATIC
        and not check.get("nd")
        and (not forms or bool({*forms} & {*laws}))
    )


def error(scene: Scene, m: Motion, laws: list[str]) -> tuple[float | None, str]:
    """(error of the first check that applies, what it is of)."""
    for check in scene.checks:
        if applies(check, laws):
            got = measured(scene, m, check)
            text = f"{check['type']} {check['var']}"
            return abs(got - check["value"]), text
    return None, ""


# ---- overlaps ---------------------------------------------------------------------------------


def samples(m: Motion) -> np.ndarray:
    """Rows of a motion that are looked at, the last among them."""
    return np.unique(np.linspace(0, len(m.t) - 1, min(SAMPLES, len(m.t))).round().astype(int))


def penetration(scene: Scene, m: Motion) -> float:
    """Largest overlap at the samples [m], at least 0."""
    deepest = 0.0
    radius = [geometry.reach(b) for b in scene.bodies]
    for k in samples(m):
        for i, body in enumerate(scene.bodies):
            if not body.free:
                continue
            for plane in scene.planes:
                deepest = max(deepest, -geometry.to_plane(body, m.pos[k, i], m.quat[k, i], plane))
        for i, j in scene.pairs():
            if np.linalg.norm(m.pos[k, i] - m.pos[k, j]) < radius[i] + radius[j]:
                gap, _ = geometry.between(
                    scene.bodies[i],
                    m.pos[k, i],
                    m.quat[k, i],
                    scene.bodies[j],
                    m.pos[k, j],
                    m.quat[k, j],
                )
                deepest = max(deepest, -gap)
    return deepest


# ---- motion and energy ------------------------------------------------------------------------


def creep(scene: Scene, m: Motion, rests_from: float | None) -> float | None:
    """Largest speed, on the mean, of a free body after `rests_from` [m/s]."""
    if rests_from is None or rests_from >= m.t[-1]:
        return None
    k = int(np.searchsorted(m.t, rests_from - 1e-9))
    free = [i for i, b in enumerate(scene.bodies) if b.free]
    away = np.linalg.norm(m.pos[-1, free] - m.pos[k, free], axis=1)
    return float(away.max() / (m.t[-1] - m.t[k]))


def energy(scene: Scene, m: Motion) -> np.ndarray:
    """Kinetic energy and that of gravity at every time [J]."""
    total = np.zeros(len(m.t))
    for i, b in enumerate(scene.bodies):
        if not b.free:
            continue
        total += 0.5 * b.mass * np.sum(m.vel[:, i] ** 2, axis=1)
        total -= b.mass * m.pos[:, i] @ scene.gravity
        turned = np.array(
            [geometry.rotation(q).T @ w for q, w in zip(m.quat[:, i], m.omega[:, i], strict=True)]
        )
        total += 0.5 * turned**2 @ b.inertia
    return total


def energy_gain(scene: Scene, m: Motion) -> float | None:
    """Largest rise over an earlier value [J]; None where loads or drives do work."""
    if scene.has_work:
        return None
    e = energy(scene, m)
    return float(np.max(e - np.minimum.accumulate(e)))


# ---- Coulomb's law ----------------------------------------------------------------------------


def upward(scene: Scene, m: Motion, k: int, c: Contact) -> np.ndarray | None:
    """Unit direction from b to a at row k, from the shapes and poses; None: no such pair."""
    index = scene.index()
    i = index.get(c.a)
    if i is None:
        return None
    for plane in scene.planes:
        if plane.name == c.b:
            return plane.up
    j = index.get(c.b)
    if j is None:
        return None
    _, up = geometry.between(
        scene.bodies[i], m.pos[k, i], m.quat[k, i], scene.bodies[j], m.pos[k, j], m.quat[k, j]
    )
    return up


def contact_speed(scene: Scene, m: Motion, k: int, c: Contact) -> np.ndarray:
    """Velocity of a relative to b at the contact point, at row k [m/s]."""
    index = scene.index()

    def at(name: str) -> np.ndarray:
        i = index.get(name)
        if i is None:
            return np.zeros(3)
        return m.vel[k, i] + np.cross(m.omega[k, i], c.point - m.pos[k, i])

    return at(c.a) - at(c.b)


def reduced_mass(scene: Scene, c: Contact) -> float:
    index = scene.index()
    inverse = sum(
        1.0 / scene.bodies[index[n]].mass
        for n in (c.a, c.b)
        if n in index and scene.bodies[index[n]].free
    )
    return 1.0 / inverse if inverse > 0 else 0.0


def projected(v: np.ndarray, radius: float) -> np.ndarray:
    length = float(np.linalg.norm(v))
    return v if length <= radius else v * (radius / length)


def step_residual(scene: Scene, m: Motion, k: int, h: float) -> float | None:
    """Residual of the step that ends at row k; None where no contact pushes."""
    off, pushed = 0.0, 0.0
    for c in m.contacts[k - 1]:
        up = upward(scene, m, k, c)
        if up is None:
            continue
        push = max(float(c.force @ up), 0.0)
        rub = c.force - (c.force @ up) * up
        u = contact_speed(scene, m, k, c)
        u = u - (u @ up) * up
        aim = rub - reduced_mass(scene, c) / h * u
        off += float(np.linalg.norm(rub - projected(aim, scene.friction * push)))
        pushed += push
    return off / pushed if pushed > 0 else None


def coulomb(scene: Scene, m: Motion) -> float | None:
    """Mean residual at the samples; None where forces cannot be read, or nothing rubs."""
    if m.contacts is None or scene.friction == 0:
        return None
    rows = [k for k in samples(m) if k > 0]
    found = [step_residual(scene, m, k, float(m.t[k] - m.t[k - 1])) for k in rows]
    told = [r for r in found if r is not None]
    return float(np.mean(told)) if told else None


# ---- the verdict ------------------------------------------------------------------------------


def judge(
    scene: Scene, local: Motion, world: Motion, laws: list[str], rests_from: float | None
) -> Verdict:
    """`local` is the motion in the frame of the drive, where driven bodies stand still; `world` the
    same in the world, of which the checks speak."""
    finite = bool(np.isfinite(local.pos).all() and np.isfinite(local.vel).all())
    if not finite:
        return Verdict(None, "", np.inf, None, None, None, None, False)
    wrong, what = error(scene, world, laws)
    most = None if local.contacts is None else max((len(c) for c in local.contacts), default=0)
    return Verdict(
        wrong,
        what,
        penetration(scene, local),
        creep(scene, local, rests_from),
        energy_gain(scene, local),
        coulomb(scene, local),
        most,
        True,
    )
