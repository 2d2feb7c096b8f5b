"""Approximate convex decomposition of polygons in the manner of Lien & Amato 2006, §7.

Question: how many parts, how much time and which convexity (Eq. 9) do the four
measures give over the tolerance, against the minimum-component exact
decomposition (Keil & Snoeyink 1998), and how does the time grow with n·r?

    cargo build --release -p assetpipe-polygon --example minimum_convex
    python -m benchmarks.polygon --baseline crates/target/release/examples/minimum_convex

Prints Markdown tables; ``--pictures DIR`` draws plots like Figures 14 to 17.
Times are CPU times of one core, the best of three.
"""

from __future__ import annotations

import argparse
import subprocess
import time
from pathlib import Path

import numpy as np
import shapely

from assetpipe import polygon

MEASURES = ("sl", "sp", "h1", "h2")


def maze(teeth: int = 160) -> np.ndarray:
    """A spiral corridor with walls across it: 5 vertices and about 2.5 notches a wall."""
    ring = [(0.0, 0.0)]
    for k in range(teeth):
        x = 2.0 * k
        high = 12.0 + 6.0 * np.sin(0.21 * k)
        ring += [(x + 1.0, 0.5), (x + 1.0, high), (x + 1.4, high), (x + 1.4, 0.5)]
    ring += [(2.0 * k, -3.0) for k in range(teeth, -1, -1)]
    points = np.array(ring)
    angle = points[:, 0] / 40.0
    radius = 20.0 + 3.5 * points[:, 0] / 40.0 + points[:, 1] * 0.9
    return np.c_[radius * np.cos(angle), radius * np.sin(angle)]


def wrinkled_maze(teeth: int = 32, factor: int = 5, wrinkle: float = 0.004) -> np.ndarray:
    """The same with a fifth of the walls, each edge wrinkled: as many vertices and notches,
    but most notches are shallow, as those of the paper's models are."""
    ring = maze(teeth)
    rng = np.random.default_rng(7)
    ends = np.roll(ring, -1, axis=0)
    share = np.arange(factor)[:, None, None] / factor
    dense = (ring * (1 - share) + ends * share).transpose(1, 0, 2)
    length = np.linalg.norm(ends - ring, axis=1)[:, None, None]
    noise = rng.normal(size=dense.shape) * wrinkle * length
    noise[:, 0] = 0.0
    return (dense + noise).reshape(-1, 2)


def creature(limbs: int, vertices: int, seed: int) -> np.ndarray:
    """A body with bent limbs whose skin is wrinkled: about half its vertices are notches.

    The shape comes from the first numbers of the seed, the wrinkles from its own
    stream, so that more vertices draw the same shape more finely.
    """
    rng = np.random.default_rng(seed)
    body = [shapely.Point(0, 0).buffer(14)]
    for k in range(limbs):
        angle = 2 * np.pi * (k + rng.uniform(-0.2, 0.2)) / limbs
        place = np.zeros(2)
        path = [place]
        for _ in range(5):
            place = place + rng.uniform(10, 15) * np.array([np.cos(angle), np.sin(angle)])
            path.append(place)
            angle += rng.uniform(-0.5, 0.5)
        body.append(shapely.LineString(path).buffer(rng.uniform(2.0, 4.0), quad_segs=6))
    whole = shapely.union_all(body)
    whole = max(getattr(whole, "geoms", [whole]), key=lambda g: g.area)
    line = shapely.LinearRing(whole.exterior.coords)
    at = np.linspace(0, line.length, vertices, endpoint=False)
    points = shapely.get_coordinates(shapely.line_interpolate_point(line, at))
    step = line.length / vertices
    noise = np.random.default_rng(seed + 1).normal(size=(vertices, 2)) * min(0.06, 0.15 * step)
    return points + noise


def slice_of(name: str) -> np.ndarray | None:
    """The outline of a horizontal slice of a real robot link, in the mesh's unit."""
    root = Path(__file__).resolve().parents[2] / "shared" / "data" / "cad"
    path = root / f"{name}.off"
    if not path.exists():
        return None
    import trimesh

    mesh = trimesh.load(path)
    best: np.ndarray | None = None
    for axis in np.eye(3):
        for share in (0.35, 0.5, 0.65):
            low, high = mesh.bounds @ axis
            section = mesh.section(axis, axis * (low + share * (high - low)))
            if section is None:
                continue
            for loop in section.discrete:
                flat = np.delete(loop, np.argmax(axis), axis=1)[:-1]
                if shapely.Polygon(flat).is_valid and (best is None or len(flat) > len(best)):
                    best = flat
    return best


def refined(ring: np.ndarray, factor: int = 8, seed: int = 7) -> np.ndarray:
    """The same shape with ``factor`` times the vertices, wrinkled by a thousandth of an edge."""
    rng = np.random.default_rng(seed)
    ends = np.roll(ring, -1, axis=0)
    share = np.arange(factor)[:, None, None] / factor
    dense = (ring * (1 - share) + ends * share).transpose(1, 0, 2)
    length = np.linalg.norm(ends - ring, axis=1)[:, None, None]
    wrinkle = rng.normal(size=dense.shape) * 1e-3 * length
    wrinkle[:, 0] = 0.0
    return (dense + wrinkle).reshape(-1, 2)


def models() -> dict[str, np.ndarray]:
    found = {
        "maze": maze(),
        "wrinkled maze": wrinkled_maze(),
        "creature A": creature(7, 1204, 3),
        "creature B": creature(9, 1037, 11),
    }
    for name in ("icub_index", "so101_base", "pr2_faroll"):
        outline = slice_of(name)
        if outline is not None:
            found[f"slice {name}"] = outline
    return {name: ring for name, ring in found.items() if shapely.Polygon(ring).is_valid}


def notches(ring: np.ndarray) -> int:
    if not shapely.LinearRing(ring).is_ccw:
        ring = ring[::-1]
    a, b = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return int((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] < 0).sum())


def timed(ring: np.ndarray, tolerance: float, measure: str, repeats: int = 3):
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        found = polygon.decompose(ring, tolerance, concavity=measure)
        best = min(best, time.process_time() - start)
    return found, best


def minimum(ring: np.ndarray, baseline: Path) -> tuple[int, float]:
    text = "\n".join(f"{float(x)!r} {float(y)!r}" for x, y in ring)
    runs = [
        subprocess.run([baseline], input=text, capture_output=True, text=True, check=True)
        for _ in range(3)
    ]
    parts = [run.stdout.split() for run in runs]
    return int(parts[0][0]), min(float(seconds) for _, seconds in parts)


def comparison(rings: dict[str, np.ndarray], baseline: Path | None) -> None:
    print("| model | n | r | R | concavity | convexity | parts ACD:MCD | time ACD:MCD |")
    print("|---|---|---|---|---|---|---|---|")
    for name, ring in rings.items():
        radius = shapely.minimum_bounding_radius(shapely.Polygon(ring))
        exact, seconds = minimum(ring, baseline) if baseline else (0, np.nan)
        for share in (0.0, 0.0012, 0.005):
            found, spent = timed(ring, share * radius, "h2")
            print(
                f"| {name} | {len(ring)} | {notches(ring)} | {radius:.1f} | {share * radius:.3g} "
                f"| {100 * found.convexity:.2f} % | {len(found.parts)}:{exact} "
                f"({exact / len(found.parts):.2f}) "
                f"| {1e3 * spent:.1f}:{1e3 * seconds:.1f} ms ({seconds / spent:.1f}) |"
            )


def sweep(rings: dict[str, np.ndarray], pictures: Path | None) -> None:
    shares = np.array([0.3, 0.1, 0.03, 0.01, 0.003, 0.001, 0.0])
    print("\n| model | measure | parts at τ/R = " + ", ".join(f"{s:g}" for s in shares) + " |")
    print("|---|---|---|")
    for name, ring in rings.items():
        radius = shapely.minimum_bounding_radius(shapely.Polygon(ring))
        curves = {}
        for measure in MEASURES:
            runs = [timed(ring, s * radius, measure, 1) for s in shares]
            curves[measure] = runs
            counts = ", ".join(str(len(found.parts)) for found, _ in runs)
            print(f"| {name} | {measure} | {counts} |")
        if pictures:
            draw(name, ring, shares, curves, pictures, radius)


def draw(name, ring, shares, curves, pictures: Path, radius: float) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 2.8), dpi=80, layout="constrained")
    axes = figure.subplots(1, 4)
    shown = polygon.decompose(ring, 0.01 * radius)
    for part in shown.parts:
        axes[0].fill(*part.exterior.xy, alpha=0.6, lw=0.3, ec="black")
    axes[0].set_aspect("equal")
    axes[0].set_axis_off()
    axes[0].set_title(f"{name}: {len(shown.parts)} parts at τ = R/100", fontsize=8)
    at = np.maximum(shares, 3e-4)
    for measure, runs in curves.items():
        axes[1].loglog(at, [len(f.parts) for f, _ in runs], marker=".", label=measure)
        axes[2].loglog(at, [1e3 * t for _, t in runs], marker=".")
        axes[3].semilogx(at, [f.convexity for f, _ in runs], marker=".")
    for axis, title in zip(axes[1:], ("parts", "CPU time (ms)", "convexity (Eq. 9)"), strict=True):
        axis.set_title(title, fontsize=8)
        axis.set_xlabel("τ / R (left end: 0)", fontsize=8)
        axis.tick_params(labelsize=7)
    axes[1].legend(fontsize=7)
    pictures.mkdir(parents=True, exist_ok=True)
    figure.savefig(pictures / f"polygon_{name.replace(' ', '_')}.png")


def refinement(rings: dict[str, np.ndarray]) -> None:
    print("\n| model | n | parts at τ = R/10, R/30, R/100, R/300 | same shape, 8 n |")
    print("|---|---|---|---|")
    for name, ring in rings.items():
        dense = refined(ring)
        if not shapely.Polygon(dense).is_valid:
            continue
        radius = shapely.minimum_bounding_radius(shapely.Polygon(ring))
        counts = [
            [len(polygon.decompose(r, radius / s).parts) for s in (10, 30, 100, 300)]
            for r in (ring, dense)
        ]
        print(f"| {name} | {len(ring)} | {counts[0]} | {counts[1]} |")


def growth() -> None:
    print("\n| measure | shape | time ~ (n·r)^k, n from 1,000 to 32,000, τ = 0 |")
    print("|---|---|---|")
    for measure in ("sl", "sp"):
        for name, make in (
            ("creature", lambda n: creature(7, n, 3)),
            ("maze", lambda n: maze(n // 5)),
        ):
            sizes, times = [], []
            for n in (1000, 2000, 4000, 8000, 16000, 32000):
                ring = make(n)
                if not shapely.Polygon(ring).is_valid:
                    continue
                sizes.append(len(ring) * notches(ring))
                times.append(timed(ring, 0.0, measure, 2)[1])
            exponent = np.polyfit(np.log(sizes), np.log(times), 1)[0]
            print(f"| {measure} | {name} | {exponent:.2f} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--baseline", type=Path)
    parser.add_argument("--pictures", type=Path)
    given = parser.parse_args()
    rings = models()
    comparison(rings, given.baseline)
    sweep(rings, given.pictures)
    refinement(rings)
    growth()


if __name__ == "__main__":
    main()
