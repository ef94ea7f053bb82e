"""render TRAJECTORY.csv [--out FOLDER] - stills, a contact sheet and a GIF: bodies, force arrows, stick and slip by colour."""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402
from PIL import Image  # noqa: E402

from bench import style  # noqa: E402
from bench.style import plt  # noqa: E402

MODES = {"stick": "#0072B2", "slip": "#D55E00", "open": "#9a9a9a", "": "#333333"}
FILL, EDGE, GROUND = "#cfd8e3", "#39424e", "#b8ab96"
LIGHT = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])
VIEW = np.radians(28.0), np.radians(22.0)  # azimuth of the view, elevation


class BadTrajectory(Exception):
    pass


def rotation(q):
    w, x, y, z = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


POS, QUAT, SIZE = ["x_m", "y_m", "z_m"], ["qw", "qx", "qy", "qz"], ["sx", "sy", "sz"]


class Run:
    """A trajectory file in memory: what there is, and the poses and forces at each time."""

    def __init__(self, path):
        try:
            data = pd.read_csv(path, dtype={"kind": str, "name": str, "word": str}, keep_default_na=False)
        except (OSError, ValueError) as error:
            raise BadTrajectory(f"{path}: {error}") from None
        if "kind" not in data or not (data["kind"] == "scene").any():
            raise BadTrajectory(f"{path}: not a trajectory (no `scene` row)")
        scene = data[data["kind"] == "scene"].iloc[0]
        self.title, self.dim = scene["name"], int(scene["word"])
        self.planes = [(p[POS].to_numpy(float), p[SIZE].to_numpy(float)) for _, p in data[data["kind"] == "plane"].iterrows()]
        vertices = {n: g[POS].to_numpy(float)[:, :2] for n, g in data[data["kind"] == "vertex"].groupby("name")}
        self.shapes = {}
        for _, s in data[data["kind"] == "shape"].iterrows():
            self.shapes.setdefault(s["name"], []).append((s["word"], s[SIZE].to_numpy(float), s[POS].to_numpy(float),
                                                          rotation(s[QUAT].to_numpy(float)), vertices.get(s["name"])))
        bodies = data[data["kind"] == "body"]
        self.times = np.array(sorted(bodies["t_s"].unique()))
        self.bodies = {t: g for t, g in bodies.groupby("t_s")}
        self.contacts = {t: g for t, g in data[data["kind"] == "contact"].groupby("t_s")}
        self.names = list(dict.fromkeys(bodies["name"]))
        force = np.linalg.norm(data[data["kind"] == "contact"][SIZE].to_numpy(float), axis=1)
        self.force = float(np.quantile(force[force > 0], 0.98)) if (force > 0).any() else 1.0
        reach = [max(self.radius(n), 1e-6) for n in self.names]
        at = bodies[POS].to_numpy(float)
        self.size = max(reach) if reach else 1.0
        self.low = at.min(axis=0) - self.size * 1.3
        self.high = at.max(axis=0) + self.size * 1.3

    def radius(self, name):
        return max((np.linalg.norm(p) + (np.abs(v).max() if v is not None else np.linalg.norm(s) if w == "box" else s.max())
                    for w, s, p, _, v in self.shapes.get(name, [])), default=0.05)

    def nearest(self, t):
        return self.times[np.argmin(np.abs(self.times - t))]


# ---- the plane -------------------------------------------------------------------------------------------------------------

def outline(word, size, vertices):
    """Corner points of a planar shape in its own frame."""
    if vertices is not None:
        return vertices
    if word == "box":
        a, b = size[:2]
        return np.array([[-a, -b], [a, -b], [a, b], [-a, b]])
    if word == "rod":
        return np.array([[-size[0], 0], [size[0], 0]])
    a = np.linspace(0, 2 * np.pi, 49)
    return size[0] * np.column_stack([np.cos(a), np.sin(a)])


def draw_plane(ax, run, t):
    span = np.max(run.high[:2] - run.low[:2])
    for foot, normal in run.planes:
        along = np.array([-normal[1], normal[0]])
        middle = (run.low[:2] + run.high[:2]) / 2
        base = foot[:2] + along * np.dot(middle - foot[:2], along)
        ends = [base - along * span * 2, base + along * span * 2]
        ax.fill(*np.array([*ends, ends[1] - normal[:2] * span * 3, ends[0] - normal[:2] * span * 3]).T, color="#efeae2", zorder=0)
        ax.plot(*np.array(ends).T, color=GROUND, linewidth=1.6, zorder=1)
    for _, body in run.bodies[t].iterrows():
        r, at = rotation(body[QUAT].to_numpy(float)), body[POS].to_numpy(float)
        for word, size, pos, turn, vertices in run.shapes.get(body["name"], []):
            local = outline(word, size, vertices)
            points = (at + (pos + np.column_stack([local, np.zeros(len(local))]) @ turn.T) @ r.T)[:, :2]
            if word == "point":
                ax.plot(*at[:2], "o", color=EDGE, markersize=6, zorder=3)
                continue
            ax.fill(*points.T, facecolor=FILL, edgecolor=EDGE, linewidth=1.0, zorder=2)
            if word in ("sphere", "disc"):  # a spoke shows the turning
                ax.plot(*np.array([at[:2], points[0]]).T, color=EDGE, linewidth=0.8, zorder=3)
    for point, force, color in arrows(run, t):
        tip = point[:2] + force[:2]
        if np.linalg.norm(force[:2]) > 1e-9:
            ax.annotate("", tip, point[:2], zorder=5, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.6, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9})
        ax.plot(*point[:2], "o", color=color, markersize=3.5, zorder=6)
    centre, half = (run.low[:2] + run.high[:2]) / 2, np.maximum((run.high - run.low)[:2] / 2, 0.55 * np.max((run.high - run.low)[:2]) / 2)
    ax.set_xlim(centre[0] - half[0], centre[0] + half[0])
    ax.set_ylim(centre[1] - half[1], centre[1] + half[1])


def arrows(run, t):
    """Contact points with their force, scaled so that a large force is as long as the largest body; colour: the mode."""
    for _, c in (run.contacts[t].iterrows() if t in run.contacts else ()):
        yield c[POS].to_numpy(float), c[SIZE].to_numpy(float) / run.force * run.size * 1.2, MODES.get(c["word"], MODES[""])


# ---- space -----------------------------------------------------------------------------------------------------------------

def camera():
    azimuth, elevation = VIEW
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0])
    away = np.array([-np.sin(azimuth) * np.cos(elevation), np.cos(azimuth) * np.cos(elevation), -np.sin(elevation)])
    return right, np.cross(right, away), away


def mesh(word, size, vertices):
    """Faces of a shape in its own frame, each an array of corners."""
    if word == "box":
        c = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size
        return [c[i] for i in ([0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3])]
    if word == "rod":
        return tube(max(size[1], 0.03 * size[0]), size[0], axis=0)
    if word == "disc":
        return tube(size[0], max(size[2], 0.04 * size[0]), axis=2)
    r = size[0] if size[0] > 0 else 0.05
    u, v = np.linspace(0, 2 * np.pi, 21), np.linspace(-np.pi / 2, np.pi / 2, 11)
    p = lambda a, b: r * np.array([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)])  # noqa: E731
    return [np.array([p(u[i], v[j]), p(u[i + 1], v[j]), p(u[i + 1], v[j + 1]), p(u[i], v[j + 1])]) for i in range(20) for j in range(10)]


def tube(radius, half, axis):
    a = np.linspace(0, 2 * np.pi, 25)
    ring = radius * np.column_stack([np.cos(a), np.sin(a)])
    lift = (lambda p, h: np.array([p[0], p[1], h])) if axis == 2 else (lambda p, h: np.array([h, p[0], p[1]]))
    sides = [np.array([lift(ring[i], -half), lift(ring[i + 1], -half), lift(ring[i + 1], half), lift(ring[i], half)]) for i in range(24)]
    return sides + [np.array([lift(p, -half) for p in ring[::-1]]), np.array([lift(p, half) for p in ring])]


def draw_space(ax, run, t):
    right, up, away = camera()
    flat = lambda p: np.column_stack([p @ right, p @ up])  # noqa: E731
    centre = (run.low + run.high) / 2
    span = np.max(run.high - run.low)
    for foot, normal in run.planes:
        a = np.cross(normal, [0.0, 1.0, 0.0] if abs(normal[1]) < 0.9 else [1.0, 0.0, 0.0])
        a /= np.linalg.norm(a)
        b = np.cross(normal, a)
        base = centre - normal * np.dot(centre - foot, normal)
        corners = np.array([base + span * 0.75 * (i * a + j * b) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        ax.fill(*flat(corners).T, facecolor="#efeae2", edgecolor=GROUND, linewidth=0.8, zorder=0)
        for k in np.linspace(-0.75, 0.75, 7)[1:-1]:
            for p, q in ((a, b), (b, a)):
                ax.plot(*flat(np.array([base + span * (k * p - 0.75 * q), base + span * (k * p + 0.75 * q)])).T, color="#ded5c6", linewidth=0.5, zorder=0.5)
    faces = []
    for _, body in run.bodies[t].iterrows():
        r, at = rotation(body[QUAT].to_numpy(float)), body[POS].to_numpy(float)
        for word, size, pos, turn, vertices in run.shapes.get(body["name"], []):
            smooth = word not in ("box",)
            for face in mesh(word, size, vertices):
                points = at + (pos + face @ turn.T) @ r.T
                normal = np.cross(points[1] - points[0], points[2] - points[0])
                length = np.linalg.norm(normal)
                if length == 0:
                    normal = np.cross(points[2] - points[0], points[3] - points[0])
                    length = np.linalg.norm(normal)
                if length == 0 or np.dot(normal, away) > 0:
                    continue
                shade = 0.62 + 0.38 * max(0.0, float(np.dot(normal / length, LIGHT)))
                faces.append((float(np.mean(points @ away)), points, shade, smooth))
    base = np.array([int(FILL[i:i + 2], 16) / 255 for i in (1, 3, 5)])
    for _, points, shade, smooth in sorted(faces, key=lambda f: -f[0]):
        color = tuple(np.clip(base * shade * 1.06, 0, 1))
        ax.fill(*flat(points).T, facecolor=color, edgecolor=color if smooth else EDGE, linewidth=0.3 if smooth else 0.8, zorder=2)
    for point, force, color in arrows(run, t):
        here, tip = flat(np.array([point, point + force]))
        if np.linalg.norm(force) > 1e-9:
            ax.annotate("", tip, here, zorder=5, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.5, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9})
        ax.plot(*here, "o", color=color, markersize=3, zorder=6)
    corners = np.array([[x, y, z] for x in (run.low[0], run.high[0]) for y in (run.low[1], run.high[1]) for z in (run.low[2], run.high[2])])
    seen = flat(corners)
    ax.set_xlim(seen[:, 0].min(), seen[:, 0].max())
    ax.set_ylim(seen[:, 1].min(), seen[:, 1].max())


# ---- pictures --------------------------------------------------------------------------------------------------------------

def picture(ax, run, t):
    (draw_plane if run.dim == 2 else draw_space)(ax, run, t)
    ax.set_aspect("equal")
    ax.axis("off")
    ax.set_title(f"t = {t:.3g} s", fontsize=8, fontweight="normal")


def key(figure):
    handles = [plt.Line2D([], [], color=MODES[m], marker="o", markersize=4, label=n) for m, n in
               (("stick", "stick"), ("slip", "slip"), ("open", "no force"), ("", "mode not told"))]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=7)


def frame(run, t, width=4.2):
    box = run.high - run.low
    ratio = min(1.4, max(0.6, box[1] / box[0])) if run.dim == 2 else 0.85
    figure, ax = plt.subplots(figsize=(width, width * ratio))
    picture(ax, run, t)
    figure.suptitle(run.title, fontsize=8)
    key(figure)
    return figure


def main():
    parser = argparse.ArgumentParser(prog="scripts/render", description="Pictures of a run: stills, a contact sheet and a GIF.")
    parser.add_argument("trajectory", help="file written by lcpbench simulate --trajectory")
    parser.add_argument("--out", help="folder of the pictures (default: beside the file)")
    parser.add_argument("--frames", type=int, default=40, help="frames of the GIF (default: 40, 0: no GIF)")
    parser.add_argument("--times", help="times of the stills [s], separated by commas (default: six over the run)")
    args = parser.parse_args()
    path = pathlib.Path(args.trajectory)
    try:
        run = Run(path)
        wanted = [float(t) for t in args.times.split(",")] if args.times else np.linspace(run.times[0], run.times[-1], 6)
    except (BadTrajectory, ValueError) as error:
        print(error, file=sys.stderr)
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
    figure, axes = plt.subplots(lines, columns, figsize=(style.PAGE, 2.2 * lines + 0.3), squeeze=False)
    for ax in axes.flat[len(times):]:
        ax.axis("off")
    for ax, t in zip(axes.flat, times):
        picture(ax, run, t)
    key(figure)
    style.save(figure, out, "sheet")
    print(out / "sheet.png")
    if args.frames > 0:
        images = []
        for t in np.linspace(run.times[0], run.times[-1], args.frames):
            figure = frame(run, run.nearest(t), width=3.6)
            figure.set_dpi(100)
            figure.canvas.draw()
            images.append(Image.fromarray(np.asarray(figure.canvas.buffer_rgba())).convert("RGB").quantize(64))
            plt.close(figure)
        duration = max(40, int(1000 * (run.times[-1] - run.times[0]) / max(1, len(images) - 1)))
        images[0].save(out / "run.gif", save_all=True, append_images=images[1:], duration=duration, loop=0)
        print(out / "run.gif")
    return 0


if __name__ == "__main__":
    sys.exit(main())
