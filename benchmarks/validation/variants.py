"""Robots with other collision geometry: each engine's hulls in place of the meshes.

Hulls are computed in a process of their own under a limit of CPU time, and kept in a
folder outside the repository, because CoACD takes minutes for some robots.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import importlib.util
import resource
import subprocess
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from assetpipe.geometry import Mesh, read_mesh, write_obj
from assetpipe.robot import MeshShape, Robot, forward_kinematics, home, read_robot
from assetpipe.robot.writer import HullMesh, NewCollision, write_urdf

ENGINES = ("assetpipe", "coacd", "vhacd")
_PACKAGES = {"coacd": "coacd", "vhacd": "vhacdx"}
SAMPLES = ("arm_gripper", "cabinet", "desk_lamp", "toaster")
ROBOTS = {
    "kuka_iiwa": "kuka_iiwa/model.urdf",
    "franka_panda": "franka_panda/panda.urdf",
    "laikago": "laikago/laikago.urdf",
    "mini_cheetah": "mini_cheetah/mini_cheetah.urdf",
    "xarm6": "xarm/xarm6_robot.urdf",
    "r2d2": "r2d2.urdf",
}


def robot_files() -> dict[str, Path]:
    """The sample assets and, where pybullet is installed, six real robots."""
    root = Path(__file__).resolve().parents[2] / "sample_assets"
    found = {name: next((root / name / "urdf").iterdir()) for name in SAMPLES}
    spec = importlib.util.find_spec("pybullet_data")
    if spec is not None and spec.submodule_search_locations:
        data = Path(next(iter(spec.submodule_search_locations)))
        found |= {name: data / path for name, path in ROBOTS.items()}
    return found


@dataclass(frozen=True)
class Hulls:
    """What an engine made of one mesh: hulls (metres, link scale), their certified thickening
    in metres (``nan`` for V-HACD), CPU seconds; no hulls where it did not end."""

    hulls: tuple[Mesh, ...]
    seconds: float
    certificate: float


def hulls_of(mesh: Mesh, engine: str, threshold: float, cache: Path, *, limit: float) -> Hulls:
    """Hulls of a mesh, from the cache or from a process with a limit of CPU seconds."""
    package = _PACKAGES.get(engine)
    version = importlib.metadata.version(package) if package else _own_version()
    key = f"{mesh.digest}-{engine}-{version}-{threshold}"
    file = cache / (hashlib.sha256(key.encode()).hexdigest()[:32] + ".npz")
    known = _read(file) if file.is_file() else None
    if known is None or (not known.hulls and known.seconds < limit):
        cache.mkdir(parents=True, exist_ok=True)
        asked = file.with_suffix(".asked.npz")
        np.savez(asked, vertices=mesh.vertices, faces=mesh.faces)
        command = [sys.executable, __file__, engine, str(threshold), str(asked), str(file)]
        done = subprocess.run(
            command, capture_output=True, preexec_fn=lambda: _limit(limit), check=False
        )
        asked.unlink()
        if done.returncode:
            np.savez(file, count=0, seconds=limit, certificate=np.nan)
    return known if known is not None and known.hulls else _read(file)


def _read(file: Path) -> Hulls:
    with np.load(file) as told:
        return Hulls(
            tuple(Mesh(told[f"v{i}"], told[f"f{i}"]) for i in range(int(told["count"]))),
            float(told["seconds"]),
            float(told["certificate"]),
        )


def _limit(seconds: float) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))


def _own_version() -> str:
    from assetpipe import _core

    return hashlib.sha256(Path(str(_core.__file__)).read_bytes()).hexdigest()[:16]


@dataclass(frozen=True)
class Variant:
    """A robot with one kind of collision geometry.

    Attributes:
        urdf: written for a physics engine; mesh references are absolute.
        placed: every collision mesh in the world with the robot at home, metres.
        hulls: how many; vertices: of all of them.
        certificate: the largest certified thickening over the robot, in units of the tolerance.
    """

    urdf: Path
    placed: tuple[Mesh, ...]
    hulls: int
    vertices: int
    certificate: float


def variants(
    path: Path, folder: Path, cache: Path, *, threshold: float, limit: float, most: int
) -> tuple[dict[str, Variant], list[str]]:
    """A robot with its original meshes and with every engine's hulls.

    Meshes for which an engine failed or needed too long, and those after the first ``most``,
    are left out of every variant.

    Returns:
        Variants by name, and the names of links left out, with the reason.
    """
    robot = read_robot(path).robot
    meshes = {
        (link.name, c.index): (c, read_mesh(c.shape.path).mesh.scaled(c.shape.scale))
        for link in robot.links
        for c in link.collisions
        if isinstance(c.shape, MeshShape) and c.shape.path is not None
    }
    made: dict[str, dict[tuple[str, int], Hulls]] = {engine: {} for engine in ENGINES}
    left: list[str] = []
    for number, (key, (_, mesh)) in enumerate(list(meshes.items())):
        if number >= most:
            del meshes[key]
            continue
        for engine in ENGINES:
            made[engine][key] = hulls_of(mesh, engine, threshold, cache, limit=limit)
            if not made[engine][key].hulls:
                left.append(f"{key[0]} ({engine}: over {limit:.0f} s or failed)")
                del meshes[key]
                break
    frames = forward_kinematics(robot, home(robot))
    placed = tuple(
        mesh.transformed(frames[link] @ c.link_from_shape)
        for (link, _), (c, mesh) in meshes.items()
    )
    gone = {
        (link.name, c.index): () for link in robot.links for c in link.collisions
        if isinstance(c.shape, MeshShape) and (link.name, c.index) not in meshes
    }  # fmt: skip
    found = {
        "original": Variant(
            _written(robot, gone, folder / "original.urdf"),
            placed,
            len(placed),
            sum(len(m.vertices) for m in placed),
            0.0,
        )
    }
    for engine, results in made.items():
        files: dict[tuple[str, int], tuple[NewCollision, ...]] = {}
        for number, key in enumerate(meshes):
            files[key] = tuple(
                NewCollision(HullMesh(str(file)))
                for i, hull in enumerate(results[key].hulls)
                for file in [_obj(hull, folder / f"{engine}-{number}-{i}.obj")]
            )
        used = {key: results[key] for key in meshes}
        worst = [
            used[key].certificate / (threshold * 0.5 * float(np.ptp(mesh.vertices, axis=0).max()))
            for key, (_, mesh) in meshes.items()
        ]
        found[engine] = Variant(
            _written(robot, {**files, **gone}, folder / f"{engine}.urdf"),
            tuple(
                hull.transformed(frames[link] @ meshes[link, i][0].link_from_shape)
                for (link, i), result in used.items()
                for hull in result.hulls
            ),
            sum(len(result.hulls) for result in used.values()),
            sum(len(hull.vertices) for result in used.values() for hull in result.hulls),
            max(worst, default=0.0),
        )
    return found, left


def _obj(hull: Mesh, file: Path) -> Path:
    write_obj(hull, file)
    return file


def _written(
    robot: Robot, files: Mapping[tuple[str, int], tuple[NewCollision, ...]], file: Path
) -> Path:
    """The robot without visuals and with absolute paths, for an engine that shall only collide."""
    from lxml import etree

    root = etree.fromstring(write_urdf(robot, files))
    for visual in list(root.iter("visual")):
        visual.getparent().remove(visual)
    paths = {r.uri: r.resolution.path for r in robot.references}
    for mesh in root.iter("mesh"):
        path = paths.get(mesh.get("filename", ""))
        if path is not None:
            mesh.set("filename", str(path))
    file.write_bytes(etree.tostring(root))
    return file


def _main(engine: str, threshold: str, asked: str, file: str) -> None:
    from cases import ENGINES as RUNS

    from assetpipe import _core
    from assetpipe.decomposition import Tolerance, certify, decompose
    from assetpipe.errors import MeshError
    from assetpipe.geometry import repair

    with np.load(asked) as told:
        mesh = Mesh(told["vertices"], told["faces"])
    if engine == "assetpipe":
        found = decompose(mesh, Tolerance.coacd(float(threshold)), threads=1)
        hulls = [(hull.vertices, hull.faces) for hull in found.hulls]
        upper = found.certificate.upper
    else:
        solid = repair(mesh).solid
        if solid is None:
            raise SystemExit("no solid")
        run = RUNS[engine](solid.vertices, solid.faces, float(threshold))
        hulls = []
        for points in run.hulls:
            with contextlib.suppress(MeshError):  # a flat part has no volume to write
                hulls.append(_core.convex_hull(np.ascontiguousarray(points)))
        # V-HACD's 64 hulls take longer to certify than everything else together.
        upper = np.nan
        if engine == "coacd":
            upper = max(c.upper for c in certify(solid, [Mesh(v, f) for v, f in hulls]))
    arrays = {f"v{i}": v for i, (v, _) in enumerate(hulls)}
    arrays |= {f"f{i}": f for i, (_, f) in enumerate(hulls)}
    np.savez(file, count=len(hulls), seconds=time.process_time(), certificate=upper, **arrays)


if __name__ == "__main__":
    _main(*sys.argv[1:])
