"""Folds without thickness, taken out of a closed surface.

Where a surface runs over an edge and back in its own plane, its two layers enclose nothing
between them: a flap beside the solid, or a slit in it. Decimated meshes are full of such
folds. Each is taken out by a step that leaves the surface closed, and what it encloses as it
was: the edge is flipped; or the two layers are cut where their borders cross, and what lies
double is left out. Every step makes the area smaller, so they come to an end.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from time import process_time

import numpy as np

from assetpipe.geometry.health.topology import face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import added, length
from assetpipe.geometry.repair.deadline import NEVER, Deadline
from assetpipe.geometry.repair.deviation import RESOLUTION, Side, farthest, farthest_each
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.surface import Corners, Surface, no_corners
from assetpipe.geometry.repair.unite import Shell, shells_of
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Work, stacked
from assetpipe.geometry.strays import referenced

_FLAT = 1e-13
"""Units by which a face without area may be higher than that."""
_LESS = 1.0 - 1e-9
"""Share of the area that a step may leave at most."""
_SHARP = 1e-5
"""Resolution, in units, of the bounds on what a fold's loss moves."""
_ASIDE = 1e-9
"""Share of an edge from its ends within which nothing is cut."""
_CUTS = 6
"""How often edges may be cut that end at a cut: around a true crossing it would not end."""

_PAIR = np.array([[0, 1, 2], [1, 0, 3]])
"""Two faces over one edge."""

Triangle = tuple[int, int, int]
Edge = tuple[int, int]


def unfolded(work: Work, job: Job) -> Work:
    """Rung: folds without thickness are taken out of the shells, within the budget."""
    clock = process_time()
    shells: list[Shell] = []
    number, left = 0, 0
    beside, dropped, change = 0.0, 0.0, 0.0
    lost = [work.lost]
    # What is inside a piece may be in a void that is taken from it later.
    voids = len({shell.volume > 0.0 for shell in work.shells}) > 1
    for shell in work.shells:
        job.deadline.check()
        result = without_folds(shell, job.deadline)
        if max(result.added, result.removed) > job.budget:
            shells.append(shell)
            left += 1
            continue
        shells += result.shells
        number += result.folds
        if result.folds:
            change += added(part.volume for part in result.shells) - shell.volume
        beside, dropped = max(beside, result.added), max(dropped, result.removed)
        lost += [result.inside] * voids
    stay = f"folds without thickness stay in {counted(left, 'piece')}: they reach too far"
    notes = (stay,) * (left > 0)
    work = work.after(notes=work.notes + notes)
    if not number:
        return work
    step = Step(
        Rung.CLEAN,
        f"took {counted(number, 'fold')} without thickness out of the surface",
        moved=max(beside, dropped) * job.frame.scale,
        volume_change=change * job.frame.scale**3,
        seconds=process_time() - clock,
    )
    beside, dropped = max(beside, work.beside), max(dropped, work.dropped)
    return work.after(
        step, shells=tuple(shells), beside=beside, dropped=dropped, lost=stacked(*lost)
    )


@dataclass(frozen=True, eq=False)
class Unfolded:
    """A shell without folds.

    Attributes:
        shells: what is left of it; where folds held pieces together, several.
        folds: how many it had, if any were taken out.
        removed: units, bound on how far the old surface lies from them (zero inside).
        added: units, bound on how far they lie from the old surface.
        inside: triangles that they have not, and that lie in what they enclose.
    """

    shells: tuple[Shell, ...]
    folds: int = 0
    removed: float = 0.0
    added: float = 0.0
    inside: Corners = field(default_factory=no_corners)


def without_folds(shell: Shell, deadline: Deadline = NEVER) -> Unfolded:
    """Take the folds out of a closed shell; those that no step makes smaller stay."""
    found = folds(shell.vertices, shell.faces)
    if not found:
        return Unfolded((shell,))
    layers = _Layers(shell.vertices, shell.faces)
    taken = layers.unfold(found, deadline)
    kept = [face for face in layers.faces if face is not None]
    if not taken or not kept:
        return Unfolded((shell,))
    vertices, faces = np.array(layers.points), np.array(kept, dtype=np.int64)
    before, after = set(map(tuple, shell.faces.tolist())), set(kept)
    lost = shell.faces[[face not in after for face in map(tuple, shell.faces.tolist())]]
    fresh = faces[[face not in before for face in kept]]
    new, gone = Surface(vertices, faces), shell.vertices[lost]
    removed = _bound(new, gone, "solid", deadline)
    return Unfolded(
        tuple(shells_of(*split_nonmanifold(*referenced(vertices, faces))[:2])),
        len(found),
        removed,
        _bound(Surface(shell.vertices, shell.faces), vertices[fresh], "surface", deadline),
        gone[_each_bound(new, gone, deadline) > removed + 2.0 * _SHARP],
    )


def _each_bound(target: Surface, corners: Corners, deadline: Deadline) -> FloatArray:
    """(n,) how far each triangle reaches from a surface."""
    number = len(corners)
    return farthest_each(
        target,
        corners,
        np.arange(number),
        number,
        side="surface",
        resolution=_SHARP,
        deadline=deadline,
    )


def _bound(target: Surface, corners: Corners, side: Side, deadline: Deadline) -> float:
    """How far triangles reach; the sharper resolution can run out of triangles."""
    return min(
        farthest(target, corners, side=side, resolution=resolution, deadline=deadline)
        for resolution in (RESOLUTION, _SHARP)
    )


def folds(vertices: FloatArray, faces: IntArray) -> list[Edge]:
    """Folded edges of a closed surface.

    The two faces of a fold lie on one another in one plane, but for rounding, with no
    material between. A sharp edge with material between is none, however thin it is.

    Args:
        vertices: (n, 3) units.
        faces: (m, 3).
    """
    from assetpipe import _core

    return _core.folds(np.ascontiguousarray(vertices), np.ascontiguousarray(faces), 1.0)


class _Layers:
    """A closed surface while folds are taken out of it: faces by their directed edges."""

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        self.points: list[FloatArray] = list(vertices)
        self.faces: list[Triangle | None] = []
        self._at: dict[Edge, int] = {}
        self._age: dict[int, int] = {}
        for a, b, c in faces.tolist():
            self._enter(len(self.faces), (a, b, c))

    def unfold(self, found: list[Edge], deadline: Deadline) -> int:
        """Take out the folds at the edges ``found`` and those that come up; how many steps."""
        waiting = found[::-1]
        steps = 0
        while waiting:
            made = self._step(*waiting.pop())
            if made is None:
                continue
            steps += 1
            deadline.check()
            for face in made:
                waiting += _around(face)
        return steps

    def _step(self, a: int, b: int) -> list[Triangle] | None:
        """Make less of a fold at an edge; the faces that are new, or ``None``."""
        if (a, b) not in self._at or (b, a) not in self._at:
            return None
        c, d = self._apex(a, b), self._apex(b, a)
        if c == d:
            return self._replaced([(a, b), (b, a)], [])
        corners = [self.points[v] for v in (a, b, c, d)]
        old, flipped = [(a, b, c), (b, a, d)], [(a, d, c), (b, c, d)]
        most, area = self._area(old), self._area(flipped)
        on_c, on_d = (_halves_edge(corners[0], corners[1], apex) for apex in corners[2:])
        if on_c != on_d and area <= most and self._least(flipped) > 2.0 * self._least(old):
            return self._replaced([(a, b), (b, a)], flipped)
        if not folds(np.array(corners), _PAIR):
            return None
        if area < _LESS * most:
            made = self._replaced([(a, b), (b, a)], flipped)
            if made is not None:
                return made
        x = len(self.points)
        for p, q, left in (
            ((a, c), (b, d), [(b, c, x), (a, d, x)]),
            ((c, b), (d, a), [(a, x, c), (b, x, d)]),
        ):
            point = self._crossing(p, q)
            age = 1 + max(self._age.get(v, 0) for v in (*p, *q))
            if point is None or age > _CUTS:
                continue
            self.points.append(point)
            self._age[x] = age
            halves = [*self._halves(*p, x), *self._halves(*q, x)]
            made = self._replaced([(a, b), (b, a), p, q], left + halves)
            if made is not None:
                return made
            self.points.pop()
        return None

    def _crossing(self, p: Edge, q: Edge) -> FloatArray | None:
        """Where two edges in one plane cross, away from their ends."""
        start, end, other, far = (self.points[v] for v in (*p, *q))
        along, across, between = end - start, far - other, other - start
        normal = np.cross(along, across)
        size = _dot(normal, normal)
        if size == 0.0:
            return None
        s = _dot(np.cross(between, across), normal) / size
        t = _dot(np.cross(between, along), normal) / size
        if not (_ASIDE < s < 1.0 - _ASIDE and _ASIDE < t < 1.0 - _ASIDE):
            return None
        return np.asarray(start + s * along)

    def _halves(self, p: int, q: int, x: int) -> list[Triangle]:
        """The face at a directed edge, cut at ``x`` on that edge."""
        apex = self._apex(p, q)
        return [(p, x, apex), (x, q, apex)]

    def _replaced(self, old: list[Edge], new: list[Triangle]) -> list[Triangle] | None:
        """Put faces in the place of those at the edges ``old``, if the surface stays one.

        Faces that are there from both sides then go, among the new ones and with others.
        """
        gone = {self._at[edge] for edge in old}
        left: list[Triangle] = []
        for face in new:
            back = [other for other in left if _is_back(face, other)]
            if back:
                left.remove(back[0])
                continue
            a, b, c = face
            index = self._at.get((b, a))
            if index is not None and index not in gone and self._apex(b, a) == c:
                gone.add(index)
                continue
            left.append(face)
        edges = [edge for face in left for edge in _around(face)]
        taken = (self._at.get(edge) for edge in edges)
        if len(set(edges)) < len(edges) or any(i is not None and i not in gone for i in taken):
            return None
        beside = []
        for index in sorted(gone):
            for a, b in _around(self._face(index)):
                beside.append((b, a))
                del self._at[a, b]
            self.faces[index] = None
        for face in left:
            self._enter(len(self.faces), face)
        if left:
            return left
        rest = {self._at[edge] for edge in beside if edge in self._at}
        return [self._face(index) for index in sorted(rest)]

    def _enter(self, index: int, face: Triangle) -> None:
        self.faces.append(face)
        for edge in _around(face):
            self._at[edge] = index

    def _apex(self, a: int, b: int) -> int:
        face = self._face(self._at[a, b])
        return face[(face.index(a) + 2) % 3]

    def _face(self, index: int) -> Triangle:
        face = self.faces[index]
        assert face is not None  # noqa: S101 - only faces that are there have edges
        return face

    def _area(self, faces: list[Triangle]) -> float:
        return added(self._areas(faces).tolist())

    def _least(self, faces: list[Triangle]) -> float:
        """The smallest area."""
        return float(self._areas(faces).min())

    def _areas(self, faces: list[Triangle]) -> FloatArray:
        # Corners in one order: rounding must not make a face larger or smaller than itself.
        corners = np.array([self.points[v] for face in faces for v in sorted(face)])
        return face_areas(corners, np.arange(len(corners)).reshape(-1, 3))[0]


def _around(face: Triangle) -> list[Edge]:
    a, b, c = face
    return [(a, b), (b, c), (c, a)]


def _is_back(face: Triangle, other: Triangle) -> bool:
    """Whether two faces are the two sides of one triangle."""
    a, b, c = face
    return other in ((a, c, b), (c, b, a), (b, a, c))


def _halves_edge(a: FloatArray, b: FloatArray, c: FloatArray) -> bool:
    """Whether c lies on the edge (a, b): the face of the three has no area."""
    along, aside = b - a, c - a
    size = _dot(along, along)
    share = _dot(along, aside) / size if size > 0.0 else 0.0
    return 0.0 < share < 1.0 and length(aside - share * along) <= _FLAT


def _dot(a: FloatArray, b: FloatArray) -> float:
    return added((a * b).tolist())
