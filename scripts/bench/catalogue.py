"""catalogue [--pictures] [--stdout] [SCENE...] - the catalogue of scenes as Markdown, and a picture
of each."""

from __future__ import annotations

import pathlib
import re
import sys
import tempfile
from typing import TYPE_CHECKING

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from bench import binary, experiments, say  # noqa: E402

if TYPE_CHECKING:  # pictures need it, the text does not
    from PIL import Image

FOLDER = binary.ROOT / "problems" / "scenes"

# ---- text ----------------------------------------------------------------------------------------


def number(x: float) -> str:
    return f"{x:.6g}"


def bound(p: dict) -> str:
    if p["kind"] == "choice":
        return " or ".join(p["words"])
    return f"{number(p['min'])} to {number(p['max'])}"


def value(p: dict) -> str:
    return p["default"] if p["kind"] == "choice" else number(p["default"])


def predicted(c: dict) -> str:
    """Quantity, where and what: the default tolerance stands in `lcpbench list scenes --format
    json`."""
    at = f" at {number(c['time_s'])} s" if c["time_s"] is not None else ""
    what = f" = {number(c['value'])} {c['unit']}" if c["value"] is not None else ""
    only = f" ({', '.join(c['formulations'])})" if c["formulations"] else ""
    return f"`{c['quantity']}`{at}{what}: {c['source']}{only}"


def linked(text: str) -> str:
    """Sections of docs/MATHEMATICS.md as links: "MATHEMATICS B2, B3"."""
    page = "../../docs/MATHEMATICS.md"
    return re.sub(r"MATHEMATICS (\w[\w.]*\w)", rf"[MATHEMATICS \1]({page}#\1)", text)


def source(cite: str) -> str:
    """Keys of docs/references.bib: "lemke1965; cottle1992, 4.4"."""
    return f"[{cite}](../../docs/references.bib)" if cite else "none"


def paragraph(s: dict) -> list[str]:
    lines = [
        f"## {s['name']}",
        "",
        f"![{s['title']}](pictures/{s['name']}.png)",
        "",
        linked(s["about"]),
        "",
    ]
    lines += ["| parameter | default | range | unit | |", "|---|---|---|---|---|"]
    lines += [
        f"| `{p['name']}` | {value(p)} | {bound(p)} | {p['unit']} | {p['help']} |"
        for p in s["parameters"]
    ]
    size = (
        f"{s['bodies']} bodies"
        if s["bodies"] > 1
        else "one body"
        if s["bodies"] == 1
        else "generalised coordinates"
    )
    lines += [
        "",
        (
            f"{'Planar' if s['dim'] == 2 else 'Spatial'}, {size}, {number(s['duration_s'])} s in"
            f" steps of {number(s['step_s'])} s. Effects: {', '.join(s['effects'])}. Source:"
            f" {source(s['cite'])}."
        ),
        "",
        "Predicted:",
        "",
    ]
    seen = list(dict.fromkeys(predicted(c) for c in s["predictions"]))
    shown = seen if len(seen) <= 6 else seen[:5] + [f"and {len(seen) - 5} more"]
    return lines + [f"- {line}" for line in shown] + [""]


def markdown(all_scenes: list[dict]) -> str:
    lines = [
        "# The scenes",
        "",
        (
            "Written by `scripts/catalogue` from `lcpbench list scenes --format json`; the"
            " pictures, by `scripts/render`, show a run at its start,"
        ),
        (
            "in the middle and at its end: bodies, contact forces as arrows, blue where a contact"
            " sticks, orange where it slips."
        ),
        "",
        "| scene | |",
        "|---|---|",
    ]
    lines += [f"| [{s['name']}](#{s['name']}) | {s['title']} |" for s in all_scenes] + [""]
    for s in all_scenes:
        lines += paragraph(s)
    return "\n".join(lines).rstrip() + "\n"


# ---- pictures ------------------------------------------------------------------------------------


def picture(s: dict) -> Image.Image:
    import numpy as np

    from bench import render

    asked = experiments.of("pictures")
    extra = next(
        (e for e in asked["scenes"] if e["scene"].partition(":")[0] == s["name"]),
        {"scene": s["name"]},
    )
    way = {**asked["plane" if s["dim"] == 2 else "space"], **extra}
    shares = extra.get("times", (0, 0.5, 1))
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "t.csv"
        binary.simulate(way["scene"], *experiments.way(way), "--trajectory", path)
        run = render.Run(path)
    times = [run.nearest(run.times[0] + share * (run.times[-1] - run.times[0])) for share in shares]
    times[0] = run.times[min(1, len(run.times) - 1)]  # forces belong to steps
    if "look" in extra:
        run.view = tuple(np.array(corner) for corner in extra["look"])
    return render.strip(run, list(dict.fromkeys(times)))


def main() -> int:
    parser = say.Arguments(
        prog="scripts/catalogue",
        description="The catalogue of scenes as Markdown, and a picture of each.",
    )
    parser.add_argument("--pictures", action="store_true", help="draw the pictures as well")
    parser.add_argument(
        "--stdout", action="store_true", help="print the catalogue instead of writing it"
    )
    parser.add_argument("scene", nargs="*", help="scenes to draw (default: all)")
    args = parser.parse_args()
    everything = binary.listed("scenes")
    unknown = set(args.scene) - {s["name"] for s in everything}
    if unknown:
        say.complain(f"catalogue: no scene {', '.join(sorted(unknown))}")
        return 2
    if args.stdout:
        print(markdown(everything), end="")
        return 0
    (FOLDER / "README.md").write_text(markdown(everything), encoding="utf-8")
    if args.pictures:
        (FOLDER / "pictures").mkdir(exist_ok=True)
        for s in everything:
            if not args.scene or s["name"] in args.scene:
                picture(s).save(FOLDER / "pictures" / f"{s['name']}.png", optimize=True)
                print(
                    f"{s['name']}.png:"
                    f" {(FOLDER / 'pictures' / (s['name'] + '.png')).stat().st_size} bytes",
                    flush=True,
                )
    return 0


if __name__ == "__main__":
    sys.exit(main())
