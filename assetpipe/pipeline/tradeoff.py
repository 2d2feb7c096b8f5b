"""What accuracy costs in time: one robot or mesh, built at many settings and measured."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import InputError, Location, UsageError
from assetpipe.pipeline.build import build_all
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.executors.task import Cancelled
from assetpipe.pipeline.progress import Listener, Progress, Token, cancelled_by, silent
from assetpipe.pipeline.result import BuildResult, RobotResult
from assetpipe.validation.cost import query_microseconds, step_microseconds


@dataclass(frozen=True)
class Setting:
    """One way to build.

    Attributes:
        engine: of decomposition.
        effort: of our own search; empty for other engines, which have none.
        tolerance: as asked.
    """

    engine: str
    effort: str
    tolerance: Tolerance

    @property
    def curve(self) -> str:
        """Settings that differ in tolerance only lie on one curve."""
        return f"{self.engine} {self.effort}".strip()


@dataclass(frozen=True)
class Row:
    """What one setting gave and cost.

    Attributes:
        engine: of decomposition.
        effort: of the search.
        tolerance: as asked, for people.
        seconds: from reading to hulls, all meshes, one process and one thread.
        hulls: of all distinct meshes.
        vertices: of all hulls.
        error: largest certified thickening, metres.
        bytes: of all hull files.
        query_us: mean over the meshes of the time of an FCL distance query, microseconds.
        step_us: of a PyBullet step with the robot, microseconds; ``None`` for meshes.
        kept: meshes that could not be decomposed at this setting.
    """

    engine: str
    effort: str
    tolerance: str
    seconds: float
    hulls: int
    vertices: int
    error: float
    bytes: int
    query_us: float
    step_us: float | None
    kept: int

    @property
    def curve(self) -> str:
        """See :attr:`Setting.curve`."""
        return f"{self.engine} {self.effort}".strip()


@dataclass(frozen=True)
class Tradeoff:
    """All rows, and where to stop paying for accuracy.

    Attributes:
        name: of the robot or mesh.
        rows: in the order asked.
        meshes: distinct meshes.
        raw_query_us: an FCL distance query with the original meshes, microseconds.
        knee: index of the suggested row, or ``None`` where no curve has three points.
    """

    name: str
    rows: tuple[Row, ...]
    meshes: int
    raw_query_us: float
    knee: int | None

    @property
    def suggestion(self) -> str | None:
        """The knee's ``--tolerance``."""
        return None if self.knee is None else self.rows[self.knee].tolerance

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "name": self.name,
            "meshes": self.meshes,
            "raw_query_us": self.raw_query_us,
            "rows": [asdict(row) for row in self.rows],
            "knee": self.knee,
            "suggested_tolerance": self.suggestion,
        }


def settings(
    tolerances: Sequence[Tolerance], efforts: Sequence[str], engines: Sequence[str]
) -> tuple[Setting, ...]:
    """Every combination; engines without efforts once a tolerance, single hulls once.

    Raises:
        UsageError: nothing to combine.
    """
    if not (tolerances and efforts and engines):
        raise UsageError("a tradeoff needs at least one tolerance, one effort and one engine")
    found: dict[Setting, None] = {}
    for engine in engines:
        for effort in efforts if engine == "assetpipe" else ("",):
            for tolerance in tolerances[:1] if engine == "hull" else tolerances:
                found[Setting(engine, effort, tolerance)] = None
    return tuple(found)


def measure(
    source: Path,
    chosen: Sequence[Setting],
    *,
    config: Config,
    on_progress: Listener = silent,
    cancel: Token | Cancelled | None = None,
) -> Tradeoff:
    """Build at every setting, one after the other, and measure each.

    Args:
        source: a URDF, a xacro file or a mesh.
        chosen: what to build.
        config: everything else; its cache, validation and number of jobs are not used,
            since times are wanted and shared cores blur them.
        on_progress: hears of it.
        cancel: stops it.

    Raises:
        InputError: the source is several robots, or has no mesh that can be decomposed.
        CancelledError: ``cancel`` said so.
    """
    stop = cancelled_by(cancel)
    rows: list[Row] = []
    raw: float | None = None
    name, count = source.name, 0
    for number, setting in enumerate(chosen):
        where = f"{setting.curve} at {setting.tolerance}"
        began = number

        def listen(event: Progress, where: str = where, began: int = began) -> None:
            on_progress(Progress(event.stage, where, began, len(chosen), event.fraction))

        with tempfile.TemporaryDirectory(prefix="assetpipe-tradeoff-") as folder:
            result = build_all(
                (source,),
                Path(folder, "out"),
                config=_at(config, setting),
                cache=Cache(Path(folder, "cache")),
                on_progress=listen,
                cancel=stop,
            )
            robot = _only(result, source)
            name, count = robot.name, len(robot.meshes)
            if raw is None:
                raw = _raw_query(robot)
            rows.append(_row(setting, result, robot))
        on_progress(Progress("done", where, number + 1, len(chosen), 1.0))
    return Tradeoff(name, tuple(rows), count, raw or 0.0, knee(rows))


def knee(rows: Sequence[Row]) -> int | None:
    """Where more hulls stop buying much accuracy.

    On the first curve with at least three points that no other beats, in the logarithms of error
    and of hulls, each stretched to 0…1: the point farthest below the line between the
    curve's ends (the idea of Satopää et al. 2011, "Finding a Kneedle in a Haystack").
    """
    for curve in dict.fromkeys(row.curve for row in rows):
        own = [i for i, row in enumerate(rows) if row.curve == curve and row.error > 0]
        front = [i for i in own if not any(_beats(rows[j], rows[i]) for j in own)]
        front.sort(key=lambda i: (-rows[i].error, rows[i].hulls))
        if len(front) < 3:
            continue
        x = [math.log(rows[i].hulls) for i in front]
        y = [math.log(rows[i].error) for i in front]
        wide, high = (x[-1] - x[0]), (y[0] - y[-1])
        if wide <= 0 or high <= 0:
            continue
        gains = [1.0 - (a - x[0]) / wide - (b - y[-1]) / high for a, b in zip(x, y, strict=True)]
        best = max(range(len(front)), key=lambda k: gains[k])
        return front[best] if gains[best] > 0 else front[len(front) // 2]
    return None


def _beats(a: Row, b: Row) -> bool:
    """Whether a is at least as good as b in error and hulls, and better in one."""
    return a.error <= b.error and a.hulls <= b.hulls and (a.error < b.error or a.hulls < b.hulls)


def _at(config: Config, setting: Setting) -> Config:
    changes: dict[str, Any] = {
        "engine": setting.engine,
        "tolerance": setting.tolerance,
        "jobs": 1,
        "validation": {**config.validation.model_dump(), "checks": []},
    }
    if setting.effort:
        changes["effort"] = setting.effort
    return config.with_changes(**changes)


def _only(result: BuildResult, source: Path) -> RobotResult:
    if len(result.robots) != 1:
        names = ", ".join(robot.name for robot in result.robots)
        raise InputError(
            f"a tradeoff is measured on one robot or mesh; found {names or 'none'}",
            location=Location(source),
        )
    robot = result.robot
    if not any(mesh.treatment == "decomposed" for mesh in robot.meshes):
        first = next((str(f) for f in result.findings), "it has no collision mesh")
        raise InputError(f"there is nothing to decompose: {first}", location=Location(source))
    return robot


def _row(setting: Setting, result: BuildResult, robot: RobotResult) -> Row:
    done = [mesh for mesh in robot.meshes if mesh.treatment == "decomposed"]
    size = sum(
        (result.out / file).stat().st_size
        for file in sorted({hull.file for link in robot.links.values() for hull in link.hulls})
    )
    queries = [
        query_microseconds([hull.mesh for hull in outcome.hulls], convex=True)
        for outcome in outcomes(robot).values()
    ]
    return Row(
        engine=setting.engine,
        effort=setting.effort,
        tolerance=_asked(setting.tolerance),
        seconds=sum(mesh.seconds or 0.0 for mesh in robot.meshes),
        hulls=sum(int(mesh.facts["hulls"]) for mesh in done),
        vertices=sum(int(mesh.facts["hull_vertices"]) for mesh in done),
        error=max(float(mesh.facts["certificate"]["thickening"]["upper"]) for mesh in done),
        bytes=size,
        query_us=sum(queries) / len(queries),
        step_us=None if robot.urdf is None else step_microseconds(result.urdf),
        kept=len(robot.meshes) - len(done),
    )


def _raw_query(robot: RobotResult) -> float:
    solids = [o.solid for o in outcomes(robot).values() if o.solid is not None]
    return sum(query_microseconds([s], convex=False) for s in solids) / max(1, len(solids))


def outcomes(robot: RobotResult) -> Mapping[int, Any]:
    """Outcomes of the decomposed meshes, by their number."""
    found = {}
    for link in robot.links.values():
        for element in link.collisions:
            if element.treatment == "decomposed" and element.mesh is not None:
                found[element.mesh] = link.load(element.mesh)
    return found


def _asked(tolerance: Tolerance) -> str:
    """As the command line writes it."""
    return str(tolerance).replace(" ", "") if tolerance.unit != "coacd" else str(tolerance)
