"""The bits of results: the same on this machine as where they were recorded."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from golden_hashes import found
from golden_solids import SOLIDS

HERE = Path(__file__).resolve().parent
RECORDED = json.loads((HERE / "hashes.json").read_text())
_HOW = "if results were meant to change: python tests/golden/golden_hashes.py > {}"


def differing(now: dict[str, str], recorded: dict[str, str]) -> list[str]:
    """What changed, one line each."""
    return [
        f"{name}: {recorded.get(name)} is now {now.get(name)}"
        for name in sorted(recorded.keys() | now.keys())
        if recorded.get(name) != now.get(name)
    ]


def test_results_are_those_recorded():
    now = dict(found(list(SOLIDS), threads=2))
    hint = _HOW.format("tests/golden/hashes.json")
    assert not differing(now, RECORDED), hint


def _plain_processor() -> dict[str, str]:
    """Variables that take vector and fused instructions from numpy, BLAS and libm."""
    core = getattr(np, "_core", None) or np.core
    return {
        "NPY_DISABLE_CPU_FEATURES": " ".join(core._multiarray_umath.__cpu_dispatch__),
        "OPENBLAS_CORETYPE": "Nehalem",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F",
    }


def test_a_plainer_processor_gives_the_same_bits():
    names = ["ring", "flask, turned"]
    environment = {
        **os.environ,
        **_plain_processor(),
        "PYTHONPATH": os.pathsep.join([str(HERE.parents[1]), *sys.path]),
    }
    command = [sys.executable, "-W", "ignore", str(HERE / "golden_hashes.py"), *names]
    done = subprocess.run(command, env=environment, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    recorded = {k: v for k, v in RECORDED.items() if k.rsplit(":", 1)[0] in names}
    assert not differing(json.loads(done.stdout), recorded)
