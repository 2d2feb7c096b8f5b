"""Accuracy against time: table, CSV, picture and a page that holds all of it."""

from __future__ import annotations

import base64
import csv
import html
import io
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

HEADINGS = {
    "curve": "engine",
    "tolerance": "tolerance",
    "seconds": "build s",
    "hulls": "hulls",
    "vertices": "vertices",
    "error": "certified mm",
    "bytes": "kB",
    "query_us": "query µs",
    "step_us": "step µs",
    "kept": "kept",
}
"""Columns and their headings."""


def cells(row: Mapping[str, Any]) -> list[str]:
    """One row as text, in the order of :data:`HEADINGS`."""
    step = row["step_us"]
    return [
        f"{row['engine']} {row['effort']}".strip(),
        str(row["tolerance"]),
        f"{row['seconds']:.2f}",
        str(row["hulls"]),
        str(row["vertices"]),
        f"{row['error'] * 1000:.3g}",
        f"{row['bytes'] / 1000:.0f}",
        f"{row['query_us']:.1f}",
        "–" if step is None else f"{step:.0f}",
        str(row["kept"]),
    ]


def show_tradeoff(console: Console, record: Mapping[str, Any]) -> None:
    """The table, the knee marked.

    Args:
        console: where to.
        record: :meth:`assetpipe.pipeline.tradeoff.Tradeoff.as_dict`.
    """
    table = Table(box=SIMPLE_HEAD, title=_title(record), title_justify="left")
    for key, heading in HEADINGS.items():
        table.add_column(heading, justify="left" if key in ("curve", "tolerance") else "right")
    for number, row in enumerate(record["rows"]):
        table.add_row(*cells(row), style="bold green" if number == record["knee"] else None)
    console.print(table)
    console.print(_advice(record))


def write_csv(path: Path, record: Mapping[str, Any]) -> None:
    """All rows, SI units, one line each."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(record["rows"][0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(record["rows"])


def can_draw() -> bool:
    """Whether matplotlib is there (the extra ``plots``)."""
    return find_spec("matplotlib") is not None


def write_picture(path: Path, record: Mapping[str, Any]) -> None:
    """Error against time and error against hulls, as PNG."""
    path.write_bytes(_draw(record))


def write_page(path: Path, record: Mapping[str, Any]) -> None:
    """A page that needs nothing but itself: table, and the picture where it can be drawn."""
    heads = "".join(f"<th>{html.escape(text)}</th>" for text in HEADINGS.values())
    lines = []
    for number, row in enumerate(record["rows"]):
        mark = ' class="knee"' if number == record["knee"] else ""
        lines.append(
            f"<tr{mark}>" + "".join(f"<td>{html.escape(c)}</td>" for c in cells(row)) + "</tr>"
        )
    picture = ""
    if can_draw():
        data = base64.b64encode(_draw(record)).decode("ascii")
        picture = f'<img alt="error against time and hulls" src="data:image/png;base64,{data}">'
    path.write_text(
        "<!doctype html>\n"
        '<html lang="en"><meta charset="utf-8">'
        f"<title>{html.escape(_title(record))}</title>\n"
        "<style>body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;"
        "padding:0 1rem;color:#222}table{border-collapse:collapse}th,td{padding:.25rem .7rem;"
        "text-align:right;border-bottom:1px solid #ddd}th:first-child,td:first-child{"
        "text-align:left}.knee{background:#e6f4ea;font-weight:600}img{max-width:100%}</style>\n"
        f"<h1>{html.escape(_title(record))}</h1>\n<p>{html.escape(_advice(record))}</p>\n"
        f"{picture}\n<table><tr>{heads}</tr>\n" + "\n".join(lines) + "\n</table>\n"
        "<p>Certified: the largest proved distance of any point of a hull from the solid. "
        "Build: reading, repair and decomposition of all meshes on one core. Query: one FCL "
        "distance query against the hulls of a mesh. Step: PyBullet, robot on its base among "
        "falling balls.</p></html>\n",
        encoding="utf-8",
    )


def _title(record: Mapping[str, Any]) -> str:
    return f"{record['name']}: what accuracy costs ({record['meshes']} meshes)"


def _advice(record: Mapping[str, Any]) -> str:
    raw = f"Original meshes: {record['raw_query_us']:.1f} µs a query."
    if record["knee"] is None:
        return f"{raw} Too few points for a knee."
    row = record["rows"][record["knee"]]
    return (
        f"Suggested: --tolerance {record['suggested_tolerance']} ({row['hulls']} hulls, "
        f"certified {row['error'] * 1000:.3g} mm, {row['seconds']:.2f} s); beyond it more "
        f"hulls buy less accuracy. {raw}"
    )


def _draw(record: Mapping[str, Any]) -> bytes:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4.2), sharey=True)
    curves: dict[str, list[Mapping[str, Any]]] = {}
    for row in record["rows"]:
        curves.setdefault(f"{row['engine']} {row['effort']}".strip(), []).append(row)
    for name, rows in curves.items():
        errors = [row["error"] * 1000 for row in rows]
        left.plot([row["seconds"] for row in rows], errors, "o-", label=name, lw=1.4, ms=4)
        right.plot([row["hulls"] for row in rows], errors, "o-", label=name, lw=1.4, ms=4)
    if record["knee"] is not None:
        row = record["rows"][record["knee"]]
        for axes, key in ((left, "seconds"), (right, "hulls")):
            axes.plot(row[key], row["error"] * 1000, "o", ms=13, mfc="none", mec="k")
        right.annotate(
            f"--tolerance {record['suggested_tolerance']}",
            (row["hulls"], row["error"] * 1000),
            textcoords="offset points",
            xytext=(12, 10),
        )
    for axes, label in ((left, "build time, s"), (right, "hulls")):
        axes.set(xscale="log", yscale="log", xlabel=label)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
        axes.grid(which="major", alpha=0.25)
    left.set_ylabel("certified error, mm")
    left.legend(frameon=False, fontsize=9)
    figure.suptitle(_title(record))
    figure.tight_layout()
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    pyplot.close(figure)
    return buffer.getvalue()
