"""render TRAJECTORY.csv [--out FOLDER] - stills, a contact sheet and a GIF: bodies, force arrows,
stick and slip by colour."""

import pathlib
import sys
from collections.abc import Callable, Iterable, Iterator

from matplotlib.axes import Axes
from matplotlib.figure import Figure

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402
from PIL import Image  # noqa: E402

from bench import say, style  # noqa: E402
from bench.style import plt  # noqa: E402

MODES = {"stick": "#0072B2", "slip": "#D55E00", "open": "#9a9a9a", "": "#333333"}
FILL, EDGE, GROUND = "#cfd8e3", "#39424e", "#b8ab96"
LIGHT = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])
VIEW = np.radians(28.0), np.radians(22.0)  # azimuth of the view, elevation


class BadTrajectory(Exception):
    pass


def rotation(q: np.ndarray) -> np.ndarray:
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


POS, QUAT, SIZE = ["x_m", "y_m", "z_m"], ["qw", "qx", "qy", "qz"], ["sx", "sy", "sz"]


COLUMNS = [
    "t_s",
    "kind",
    "name",
    "word",
    *POS,
    *QUAT,
    "vx_m_s",
    "vy_m_s",
    "vz_m_s",
    "omega_x_rad_s",
    "omega_y_rad_s",
    "omega_z_rad_s",
    *SIZE,
]
SHAPES = {"point", "sphere", "box", "rod", "disc", "polygon"}


Flat = Callable[[np.ndarray], np.ndarray]  # points in space -> points on the picture
# depth, outline, colour, colour of its edge, depth over the picture (None: hides nothing)
Face = tuple[float, np.ndarray, object, object, Callable[[np.ndarray], float] | None]


def read(path: pathlib.Path) -> pd.DataFrame:
    """The rows of a trajectory file, or BadTrajectory with the reason."""
    try:
        data = pd.read_csv(
            path, dtype={"kind": str, "name": str, "word": str}, keep_default_na=False
        )
    except OSError as error:
        raise BadTrajectory(f"{path}: {str(error).splitlines()[0]}") from None
    except ValueError:
        raise BadTrajectory(
            f"{path}: not a trajectory: need the CSV of simulate --trajectory"
        ) from None
    if list(data.columns) != COLUMNS:
        raise BadTrajectory(f"{path}: not a trajectory: its columns must be {', '.join(COLUMNS)}")
    numbers = data[["t_s", *COLUMNS[4:]]]
    if (
        not all(t.kind in "fi" for t in numbers.dtypes)
        or not np.isfinite(numbers.to_numpy(float)).all()
    ):
        raise BadTrajectory(f"{path}: a number is none, or is not finite")
    count = data["kind"].value_counts()
    if count.get("scene", 0) != 1 or count.get("body", 0) == 0:
        raise BadTrajectory(f"{path}: not a trajectory: needs one `scene` row and rows of bodies")
    if data[data["kind"] == "scene"]["word"].iloc[0] not in ("2", "3"):
        raise BadTrajectory(f"{path}: dimension must be 2 or 3")
    unknown = set(data[data["kind"] == "shape"]["word"]) - SHAPES
    if unknown:
        raise BadTrajectory(f"{path}: no shape {sorted(unknown)[0]}")
    return data


class Run:
    """A trajectory file in memory: what there is, and the poses and forces at each time."""

    def __init__(self, path: pathlib.Path) -> None:
        data = read(path)
        scene = data[data["kind"] == "scene"].iloc[0]
        self.title, self.dim = scene["name"], int(scene["word"])
        self.planes = [
            (p[POS].to_numpy(float), p[SIZE].to_numpy(float))
            for _, p in data[data["kind"] == "plane"].iterrows()
        ]
        vertices = {
            n: g[POS].to_numpy(float)[:, :2]
            for n, g in data[data["kind"] == "vertex"].groupby("name")
        }
        self.shapes = {}
        for _, s in data[data["kind"] == "shape"].iterrows():
            self.shapes.setdefault(s["name"], []).append(
                (
                    s["word"],
                    s[SIZE].to_numpy(float),
                    s[POS].to_numpy(float),
                    rotation(s[QUAT].to_numpy(float)),
                    vertices.get(s["name"]),
                )
            )
        bodies = data[data["kind"] == "body"]
        self.times = np.array(sorted(bodies["t_s"].unique()))
        self.bodies = {t: g for t, g in bodies.groupby("t_s")}
        self.contacts = {t: g for t, g in data[data["kind"] == "contact"].groupby("t_s")}
        self.names = list(dict.fromkeys(bodies["name"]))
        force = np.linalg.norm(data[data["kind"] == "contact"][SIZE].to_numpy(float), axis=1)
        self.force = float(np.quantile(force[force > 0], 0.98)) if (force > 0).any() else 1.0
        self.size = max((self.radius(n) for n in self.names), default=1.0)
        self.look()

    def radius(self, name: str) -> float:
        return max(
            (
                np.linalg.norm(p) + np.abs(corners(w, s, v)).max()
                for w, s, p, _, v in self.shapes.get(name, [])
            ),
            default=0.05,
        )

    def look(self) -> None:
        """What the bodies sweep over the run: in space (low, high) and on the picture (view: low
        and high corner)."""
        flat = (lambda p: p[:, :2]) if self.dim == 2 else projection()[0]
        space, seen = [], []
        for t in self.times[np.unique(np.linspace(0, len(self.times) - 1, 25).astype(int))]:
            for _, body in self.bodies[t].iterrows():
                r, at = rotation(body[QUAT].to_numpy(float)), body[POS].to_numpy(float)
                for word, size, pos, turn, vertices in self.shapes.get(body["name"], []):
                    ball = word == "sphere"
                    points = (
                        (at + pos @ r.T)[None, :]
                        if ball
                        else at + (pos + corners(word, size, vertices) @ turn.T) @ r.T
                    )
                    reach = size[0] if ball else 0.0
                    space += [points.min(axis=0) - reach, points.max(axis=0) + reach]
                    on = flat(points)
                    seen += [on.min(axis=0) - reach, on.max(axis=0) + reach]
        self.low, self.high = np.min(space, axis=0), np.max(space, axis=0)
        low, high = np.min(seen, axis=0), np.max(seen, axis=0)
        margin = 0.06 * np.max(high - low) + 0.25 * min(self.size, 0.3 * np.max(high - low))
        self.view = low - margin, high + margin

    def mark(self) -> float:
        """Size of arrow heads and contact points: smaller where bodies are small on the picture."""
        return float(np.clip(5.0 * self.size / np.max(self.view[1] - self.view[0]), 0.4, 1.0))

    def ratio(self) -> float:
        """Height over width of the picture."""
        low, high = self.view
        return min(1.5, max(0.3, (high - low)[1] / (high - low)[0]))

    def nearest(self, t: float) -> float:
        return self.times[np.argmin(np.abs(self.times - t))]


# ---- the plane -----------------------------------------------------------------------------------


def outline(word: str, size: np.ndarray, vertices: np.ndarray | None) -> np.ndarray:
    """Corner points of a planar shape in its own frame."""
    if vertices is not None:
        return vertices
    if word == "box":
        a, b = size[:2]
        return np.array([[-a, -b], [a, -b], [a, b], [-a, b]])
    if word == "rod":
        return np.array([[-size[0], 0], [size[0], 0]])
    a = np.linspace(0, 2 * np.pi, 49)
    if word == "point":
        return np.zeros((1, 2))
    return size[0] * np.column_stack([np.cos(a), np.sin(a)])


def draw_plane(ax: Axes, run: Run, t: float) -> None:
    low, high = run.view
    span, middle = np.max(high - low), (low + high) / 2
    for foot, normal in run.planes:
        along = np.array([-normal[1], normal[0]])
        base = foot[:2] + along * np.dot(middle - foot[:2], along)
        ends = [base - along * span * 2, base + along * span * 2]
        ax.fill(
            *np.array([*ends, ends[1] - normal[:2] * span * 3, ends[0] - normal[:2] * span * 3]).T,
            color="#efeae2",
            zorder=0,
        )
        ax.plot(*np.array(ends).T, color=GROUND, linewidth=1.6, zorder=1)
    for _, body in run.bodies[t].iterrows():
        r, at = rotation(body[QUAT].to_numpy(float)), body[POS].to_numpy(float)
        for word, size, pos, turn, vertices in run.shapes.get(body["name"], []):
            local = outline(word, size, vertices)
            points = (at + (pos + np.column_stack([local, np.zeros(len(local))]) @ turn.T) @ r.T)[
                :, :2
            ]
            if np.max(np.ptp(points, axis=0)) < 0.02 * span:
                ax.plot(*points.mean(axis=0), "o", color=EDGE, markersize=8, zorder=3)
                continue
            ax.fill(*points.T, facecolor=FILL, edgecolor=EDGE, linewidth=1.0, zorder=2)
            if word in ("sphere", "disc"):  # a spoke shows the turning
                ax.plot(*np.array([at[:2], points[0]]).T, color=EDGE, linewidth=0.8, zorder=3)
    for point, force, color in arrows(run, t):
        arrow(ax, point[:2], force[:2], color, run.mark())
    frame_view(ax, run)


def frame_view(ax: Axes, run: Run) -> None:
    low, high = run.view
    half = np.maximum((high - low) / 2, [0.0, 0.3 * (high - low)[0] / 2])
    half = np.maximum(half, [half[1] / 1.5, 0.0])
    ax.set_xlim(*((low + high)[0] / 2 + half[0] * np.array([-1, 1])))
    ax.set_ylim(*((low + high)[1] / 2 + half[1] * np.array([-1, 1])))


def arrow(
    ax: Axes, here: np.ndarray, force: np.ndarray, color: str, mark: float, alpha: float = 1.0
) -> None:
    if np.linalg.norm(force) > 1e-9:
        ax.annotate(
            "",
            here + force,
            here,
            zorder=5,
            arrowprops={
                "arrowstyle": "-|>",
                "color": color,
                "lw": 0.6 + mark,
                "shrinkA": 0,
                "shrinkB": 0,
                "mutation_scale": 9 * mark,
                "alpha": alpha,
            },
        )
    ax.plot(
        *here, "o", color=color, markersize=1 + 2.5 * mark, zorder=6, alpha=alpha, markeredgewidth=0
    )


def arrows(run: Run, t: float) -> Iterator[tuple[np.ndarray, np.ndarray, str]]:
    """Contact points with their force, scaled so that a large force is as long as the largest body;
    colour: the mode."""
    for _, c in run.contacts[t].iterrows() if t in run.contacts else ():
        yield (
            c[POS].to_numpy(float),
            c[SIZE].to_numpy(float) / run.force * run.size * 1.2,
            MODES.get(c["word"], MODES[""]),
        )


# ---- space ---------------------------------------------------------------------------------------


def camera() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    azimuth, elevation = VIEW
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0])
    away = np.array(
        [
            -np.sin(azimuth) * np.cos(elevation),
            np.cos(azimuth) * np.cos(elevation),
            -np.sin(elevation),
        ]
    )
    return right, np.cross(right, away), away


def projection() -> tuple[Flat, np.ndarray]:
    """Points in space to points on the picture, and the direction away from the eye."""
    right, up, away = camera()
    return (lambda p: np.column_stack([p @ right, p @ up])), away


def corners(word: str, size: np.ndarray, vertices: np.ndarray | None) -> np.ndarray:
    """Points whose hull holds the shape, in its own frame; a ball's are those of its bounding
    box."""
    if vertices is not None:
        return np.column_stack([vertices, np.zeros(len(vertices))])
    if word == "rod":
        half = np.array([size[0] + size[1], size[1], size[1]])
    elif word == "disc":
        half = np.array([size[0], size[0], size[2]])
    else:
        half = np.array([0.0, 0.0, 0.0]) if word == "point" else size
    return np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half


def shaded(tint: np.ndarray, normal: np.ndarray) -> tuple[float, ...]:
    return tuple(
        np.clip(tint * (0.62 + 0.38 * max(0.0, float(np.dot(normal, LIGHT)))) * 1.06, 0, 1)
    )


def hidden(faces: list[Face], here: np.ndarray, depth: float, size: float) -> bool:
    """Is the point, `depth` away, behind one of the faces drawn? `front` of a face: how far away it
    is at a point of the picture."""
    return any(
        front(here) < depth - 1e-3 * size and inside(here, points)
        for _, points, _, _, front in faces
        if front is not None
    )


def inside(here: np.ndarray, points: np.ndarray) -> bool:
    """Is the point inside a convex outline?"""
    side = np.roll(points, -1, axis=0) - points
    cross = side[:, 0] * (here[1] - points[:, 1]) - side[:, 1] * (here[0] - points[:, 0])
    return bool((cross > 0).all() or (cross < 0).all())


def plane_front(
    points: np.ndarray, normal: np.ndarray, flat: Flat, away: np.ndarray
) -> Callable[[np.ndarray], float]:
    """Depth of the plane of a face over the picture."""
    on, depth = flat(points), points @ away
    slope = np.linalg.lstsq(np.column_stack([on, np.ones(len(on))]), depth, rcond=None)[0]
    return lambda here: float(slope[0] * here[0] + slope[1] * here[1] + slope[2])


def ball(
    centre: np.ndarray,
    radius: float,
    turn: np.ndarray,
    flat: Flat,
    away: np.ndarray,
    tint: np.ndarray,
) -> list[Face]:
    """A ball as seen from afar: discs of growing brightness towards the light, and a great circle
    that shows its turning."""
    a = np.linspace(0, 2 * np.pi, 33)
    ring = np.column_stack([np.cos(a), np.sin(a)])
    middle, depth = flat(centre[None, :])[0], float(centre @ away)
    lit = flat(LIGHT[None, :])[0]
    out = []
    for i, share in enumerate((1.0, 0.85, 0.7, 0.5, 0.3)):
        color = tuple(np.clip(tint * (0.72 + 0.085 * i), 0, 1))
        front = (
            (lambda here: depth - np.sqrt(max(0.0, radius**2 - np.sum((here - middle) ** 2))))
            if i == 0
            else None
        )
        out.append(
            (
                depth - 1e-6 * i * radius,
                middle + radius * (share * ring + (1 - share) * 0.8 * lit),
                color,
                EDGE if i == 0 else color,
                front,
            )
        )
    circle = radius * np.column_stack([ring, np.zeros(len(ring))]) @ turn.T
    for k in range(len(circle) - 1):
        if circle[k] @ away < 0 and circle[k + 1] @ away < 0:
            out.append((depth - 1e-5 * radius, flat(centre + circle[k : k + 2]), EDGE, EDGE, None))
    return out


def mesh(word: str, size: np.ndarray) -> list[np.ndarray]:
    """Faces of a box, rod, disc or cylinder in its own frame, each an array of corners seen
    counter-clockwise from outside."""
    if word == "box":
        c = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
        return [
            c[i]
            for i in (
                [0, 1, 3, 2],
                [4, 6, 7, 5],
                [0, 4, 5, 1],
                [2, 3, 7, 6],
                [0, 2, 6, 4],
                [1, 5, 7, 3],
            )
        ]
    if word == "rod":
        return tube(max(size[1], 0.03 * size[0]), size[0], axis=0)
    return tube(size[0], max(size[2], 0.04 * size[0]), axis=2)


def tube(radius: float, half: float, axis: int) -> list[np.ndarray]:
    a = np.linspace(0, 2 * np.pi, 25)
    ring = radius * np.column_stack([np.cos(a), np.sin(a)])
    lift = (
        (lambda p, h: np.array([p[0], p[1], h]))
        if axis == 2
        else (lambda p, h: np.array([h, p[0], p[1]]))
    )
    sides = [
        np.array(
            [
                lift(ring[i], -half),
                lift(ring[i + 1], -half),
                lift(ring[i + 1], half),
                lift(ring[i], half),
            ]
        )
        for i in range(24)
    ]
    return sides + [
        np.array([lift(p, -half) for p in ring[::-1]]),
        np.array([lift(p, half) for p in ring]),
    ]


def draw_space(ax: Axes, run: Run, t: float) -> None:
    flat, away = projection()
    centre = (run.low + run.high) / 2
    span = np.max(run.high - run.low)
    for foot, normal in run.planes:
        a = np.cross(normal, [0.0, 1.0, 0.0] if abs(normal[1]) < 0.9 else [1.0, 0.0, 0.0])
        a /= np.linalg.norm(a)
        b = np.cross(normal, a)
        base = centre - normal * np.dot(centre - foot, normal)
        corners = np.array(
            [base + span * 0.75 * (i * a + j * b) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        )
        ax.fill(*flat(corners).T, facecolor="#efeae2", edgecolor=GROUND, linewidth=0.8, zorder=0)
        for k in np.linspace(-0.75, 0.75, 7)[1:-1]:
            for p, q in ((a, b), (b, a)):
                ax.plot(
                    *flat(
                        np.array(
                            [base + span * (k * p - 0.75 * q), base + span * (k * p + 0.75 * q)]
                        )
                    ).T,
                    color="#ded5c6",
                    linewidth=0.5,
                    zorder=0.5,
                )
    # depth, corners on the picture, colour of the face, colour of its outline, depth over the
    # picture
    faces = []
    tint = np.array([int(FILL[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    for _, body in run.bodies[t].iterrows():
        r, at = rotation(body[QUAT].to_numpy(float)), body[POS].to_numpy(float)
        for word, size, pos, turn, _ in run.shapes.get(body["name"], []):
            if word in ("sphere", "point"):
                faces += ball(
                    at + pos @ r.T,
                    size[0] if word == "sphere" else 0.02 * np.max(run.view[1] - run.view[0]),
                    r @ turn,
                    flat,
                    away,
                    tint,
                )
                continue
            for face in mesh(word, size):
                points = at + (pos + face @ turn.T) @ r.T
                normal = np.cross(points[1] - points[0], points[2] - points[0])
                length = np.linalg.norm(normal)
                if length == 0 or np.dot(normal, away) > 0:
                    continue
                color = shaded(tint, normal / length)
                faces.append(
                    (
                        float(np.mean(points @ away)),
                        flat(points),
                        color,
                        color if word != "box" and len(face) == 4 else EDGE,
                        plane_front(points, normal, flat, away),
                    )
                )
    faces.sort(key=lambda f: -f[0])
    ax.add_collection(
        PolyCollection(
            [f[1] for f in faces],
            facecolors=[f[2] for f in faces],
            edgecolors=[f[3] for f in faces],
            linewidths=0.5,
            zorder=2,
        )
    )
    for point, force, color in arrows(run, t):
        here, tip = flat(np.array([point, point + force]))
        arrow(
            ax,
            here,
            tip - here,
            color,
            run.mark(),
            0.4 if hidden(faces, here, float(point @ away), run.size) else 1.0,
        )
    frame_view(ax, run)


# ---- pictures ------------------------------------------------------------------------------------


def picture(ax: Axes, run: Run, t: float) -> None:
    (draw_plane if run.dim == 2 else draw_space)(ax, run, t)
    ax.set_aspect("equal")
    ax.axis("off")
    ax.set_title(f"t = {t:.3g} s", fontsize=8, fontweight=400)


def key(figure: Figure, run: Run, times: list[float]) -> None:
    """Names the colours that the pictures at these times show."""
    there = {c for t in times for c in (run.contacts[t]["word"] if t in run.contacts else ())}
    handles = [
        plt.Line2D([], [], color=MODES[m], marker="o", markersize=4, label=n)
        for m, n in (
            ("stick", "stick"),
            ("slip", "slip"),
            ("open", "no force"),
            ("", "mode not told"),
        )
        if m in there
    ]
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=7)


def frame(run: Run, t: float, width: float = 4.2) -> Figure:
    figure, ax = plt.subplots(figsize=(width, width * run.ratio() + 0.6))
    picture(ax, run, t)
    figure.suptitle(run.title, fontsize=8)
    key(figure, run, [t])
    return figure


def raster(figure: Figure) -> Image.Image:
    """The figure as an image of few colours."""
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    plt.close(figure)
    told = [255] * 3 + [
        int(c[i : i + 2], 16) for c in MODES.values() for i in (1, 3, 5)
    ]  # rare on the picture, but what it is about
    palette = Image.new("P", (1, 1))
    palette.putpalette(image.quantize(56).getpalette()[: 3 * 56] + told)
    return image.quantize(palette=palette, dither=Image.Dither.NONE)


def strip(run: Run, times: Iterable[float]) -> Image.Image:
    """A small picture of a few moments side by side."""
    figure, axes = plt.subplots(
        1, len(times), figsize=(2.2 * len(times), 2.2 * run.ratio() + 0.5), dpi=110, squeeze=False
    )
    for ax, t in zip(axes.flat, times, strict=True):
        picture(ax, run, t)
    key(figure, run, times)
    return raster(figure)


def main() -> int:
    parser = say.Arguments(
        prog="scripts/render", description="Pictures of a run: stills, a contact sheet and a GIF."
    )
    parser.add_argument("trajectory", help="file written by lcpbench simulate --trajectory")
    parser.add_argument("--out", help="folder of the pictures (default: beside the file)")
    parser.add_argument(
        "--frames", type=int, default=40, help="frames of the GIF (default: 40, 0: no GIF)"
    )
    parser.add_argument(
        "--times", help="times of the stills [s], separated by commas (default: six over the run)"
    )
    args = parser.parse_args()
    path = pathlib.Path(args.trajectory)
    try:
        run = Run(path)
        wanted = (
            [float(t) for t in args.times.split(",")]
            if args.times
            else np.linspace(run.times[0], run.times[-1], 6)
        )
    except (BadTrajectory, ValueError) as error:
        say.complain(error)
        return 2
    out = pathlib.Path(args.out or path.with_suffix(""))
    out.mkdir(parents=True, exist_ok=True)
    times = [run.nearest(t) for t in wanted]
    for i, t in enumerate(times):
        figure = frame(run, t)
        figure.savefig(out / f"still_{i}.png", metadata={"Software": "lcpbench"})
        plt.close(figure)
    columns = min(3, len(times))
    lines = -(-len(times) // columns)
    figure, axes = plt.subplots(
        lines,
        columns,
        figsize=(style.PAGE, (style.PAGE / columns * run.ratio() + 0.25) * lines + 0.35),
        squeeze=False,
    )
    for ax in axes.flat[len(times) :]:
        ax.axis("off")
    for ax, t in zip(axes.flat, times, strict=False):
        picture(ax, run, t)
    key(figure, run, times)
    style.save(figure, out, "sheet")
    print(out / "sheet.png")
    if args.frames > 0:
        images = []
        for t in np.linspace(run.times[0], run.times[-1], args.frames):
            figure = frame(run, run.nearest(t), width=3.6)
            figure.set_dpi(100)
            images.append(raster(figure))
        duration = max(40, int(1000 * (run.times[-1] - run.times[0]) / max(1, len(images) - 1)))
        images[0].save(
            out / "run.gif", save_all=True, append_images=images[1:], duration=duration, loop=0
        )
        print(out / "run.gif")
    return 0


if __name__ == "__main__":
    sys.exit(main())
