"""Pieces that manifold3d tears while it tidies them.

``torn_shell.npz`` is such a shell, of a random solid whose halves were put together with a wall
between them: needles next to an edge run back and forth in one plane.
"""

from pathlib import Path

import numpy as np
import trimesh
from jobs import job_on

from assetpipe.geometry import Mesh, Rung
from assetpipe.geometry.repair.deadline import NEVER
from assetpipe.geometry.repair.measured import moved_by_union
from assetpipe.geometry.repair.remake import remade
from assetpipe.geometry.repair.unite import Shell, unite
from assetpipe.geometry.repair.work import Work


def torn() -> Shell:
    data = np.load(Path(__file__).parent / "torn_shell.npz")
    return Shell.of(data["vertices"], data["faces"].astype(np.int64))


def box_at(corner: np.ndarray) -> Shell:
    made = trimesh.creation.box((0.1, 0.1, 0.1)).apply_translation(corner)
    return Shell.of(np.asarray(made.vertices), np.asarray(made.faces))


def test_a_piece_that_a_union_would_tear_is_made_a_body_by_winding_number() -> None:
    shell = torn()
    whole = job_on(Mesh(shell.vertices, shell.faces))
    pieces = (shell, box_at(shell.vertices.max(axis=0)))
    before = unite(pieces, "keep")
    assert before is not None
    assert max(moved_by_union(before, NEVER)) > whole.budget
    work = remade(Work(shell.vertices, shell.faces[:0], shells=pieces), whole)
    assert [step.rung for step in work.steps] == [Rung.WINDING]
    assert work.shells[-1] is pieces[1]
    after = unite(work.shells, "keep")
    assert after is not None
    assert max(moved_by_union(after, NEVER)) < whole.budget / 10.0
    assert abs(work.shells[0].volume - shell.volume) < 0.01 * shell.volume
    assert len(work.lost) == len(shell.faces)


def test_sound_pieces_stay_as_they_are() -> None:
    shell = box_at(np.zeros(3))
    work = Work(shell.vertices, shell.faces[:0], shells=(shell, shell.reversed()))
    assert remade(work, job_on(Mesh(shell.vertices, shell.faces))) is work
