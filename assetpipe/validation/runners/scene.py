"""Run a scene: plan it, answer it, and say what every effect was worth."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from assetpipe.errors import ConfigError, Location
from assetpipe.findings import Finding, Severity
from assetpipe.validation.dynamics.process import default_engine
from assetpipe.validation.effects import EFFECTS, Plan, plan
from assetpipe.validation.effects.plan import Backend
from assetpipe.validation.runners.dynamics import SimulationError, run_dynamics
from assetpipe.validation.runners.queries import Measured, run_queries
from assetpipe.validation.scenes.assets import SceneAsset
from assetpipe.validation.scenes.build import AssetProvider, build_assets
from assetpipe.validation.scenes.schema import EffectName, Scene, Switch, load_scene

Depth = Literal["answer", "sensitivity"]


@dataclass(frozen=True)
class Toggled:
    """The scene again with one effect the other way round.

    Attributes:
        effect: which one, or ``everything`` for all effects on.
        state: what it was switched to.
        answer, measure: what came out; ``None`` where the engine failed.
        seconds: CPU time.
        same: whether answer and measure agree with the plan's, within the tolerance.
        message: why there is no answer.
    """

    effect: EffectName | Literal["everything"]
    state: Switch
    answer: bool | None
    measure: float | None
    seconds: float
    same: bool
    message: str = ""

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "effect": self.effect,
            "state": self.state,
            "answer": self.answer,
            "measure": self.measure,
            "seconds": self.seconds,
            "same": self.same,
            "message": self.message,
        }


@dataclass(frozen=True)
class SceneResult:
    """What a scene answered.

    Attributes:
        name: of the scene's file, or its title.
        title: of the scene.
        question: asked.
        plan: how it was answered, with a reason for every effect.
        measured: the answer; ``None`` where the engine could not run.
        seconds: CPU time of answering: world, queries or steps; not of making assets.
        asset_seconds: CPU time of making the assets.
        expected: whether it is what the scene expects; ``None`` where it expects nothing.
        toggled: with sensitivity, the scene once more for every effect, and with all.
        message: why there is no answer.
        file: the scene's file.
    """

    name: str
    title: str
    question: str
    plan: Plan
    measured: Measured | None
    seconds: float
    asset_seconds: float
    expected: bool | None
    expectation: str
    toggled: tuple[Toggled, ...] = ()
    message: str = ""
    file: Path | None = None

    @property
    def answer(self) -> bool | None:
        """Yes or no, or ``None``."""
        return self.measured.answer if self.measured else None

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "name": self.name,
            "title": self.title,
            "question": self.question,
            "answer": self.answer,
            "measure": self.measured.measure if self.measured else None,
            "unit": self.measured.unit if self.measured else None,
            "evidence": dict(self.measured.evidence) if self.measured else {},
            "expected": self.expected,
            "expectation": self.expectation,
            "seconds": self.seconds,
            "asset_seconds": self.asset_seconds,
            "plan": self.plan.as_dict(),
            "toggled": [t.as_dict() for t in self.toggled],
            "message": self.message,
        }

    def findings(self) -> tuple[Finding, ...]:
        """What went wrong, as findings."""
        where = Location(self.file) if self.file else None
        if self.measured is None:
            return (
                Finding("AP411", Severity.ERROR, f"scene '{self.name}': {self.message}", where),
            )
        if self.expected is False:
            said = {True: "yes", False: "no", None: "no answer"}[self.measured.answer]
            return (
                Finding(
                    "AP410",
                    Severity.ERROR,
                    f"scene '{self.name}' ({self.question}): {said}, "
                    f"{_number(self.measured)}; expected "
                    f"{self.expectation}",
                    where,
                ),
            )
        return ()


def _number(measured: Measured) -> str:
    if measured.measure is None:
        return "nothing to measure"
    return f"{measured.measure:.4g} {measured.unit}"


@dataclass(frozen=True)
class SceneOptions:
    """How to run a scene.

    Attributes:
        depth: ``sensitivity`` also runs it with every effect toggled, and with all on.
        effects: overrules, on top of the scene's own.
        engine: for dynamics; by default the first that is installed.
        timeout: seconds for one simulation.
    """

    depth: Depth = "answer"
    effects: Mapping[EffectName, Switch] = field(default_factory=dict)
    engine: Backend | None = None
    timeout: float = 300.0


def explain_scene(
    name: str | Path,
    *,
    options: SceneOptions | None = None,
    provider: AssetProvider | None = None,
) -> Plan:
    """Plan a scene without running it; its assets are made, for the plan needs them.

    Raises:
        ConfigError: the scene does not fit its schema or its assets.
    """
    chosen = options or SceneOptions()
    scene, path = load_scene(name)
    with _located(path):
        assets = build_assets(scene, path, provider=provider)
        return plan(scene, assets, effects=chosen.effects, engine=_engine(chosen))


def run_scene(
    name: str | Path,
    *,
    options: SceneOptions | None = None,
    provider: AssetProvider | None = None,
) -> SceneResult:
    """Run a scene from a file, or a shipped one by name.

    Raises:
        ConfigError: the scene does not fit its schema or its assets.
        InputError: a file of its assets cannot be read.
    """
    scene, path = load_scene(name)
    with _located(path):
        started = time.process_time()
        assets = build_assets(scene, path, provider=provider)
        made = time.process_time() - started
        result = answer_scene(scene, assets, options=options, name=path.stem)
    return replace(result, asset_seconds=made, file=path)


@contextmanager
def _located(path: Path) -> Iterator[None]:
    """Errors about a scene's words say in which file they stand."""
    try:
        yield
    except ConfigError as error:
        if error.location is not None:
            raise
        raise ConfigError(error.message, location=Location(path)) from error


def answer_scene(
    scene: Scene,
    assets: Mapping[str, SceneAsset],
    *,
    options: SceneOptions | None = None,
    name: str | None = None,
) -> SceneResult:
    """Plan and answer a scene whose assets are made.

    Raises:
        ConfigError: the scene names links or joints that its assets do not have.
    """
    chosen = options or SceneOptions()
    engine = _engine(chosen)
    planned = plan(scene, assets, effects=chosen.effects, engine=engine)
    measured, seconds, message = attempt(scene, assets, planned, chosen)
    expected, expectation = _expected(scene, measured)
    toggled: list[Toggled] = []
    if chosen.depth == "sensitivity" and measured is not None:
        cases: list[tuple[EffectName | Literal["everything"], Switch, Plan]] = []
        for effect in EFFECTS:
            state: Switch = "off" if planned.effect(effect).is_on else "on"
            effects = {**chosen.effects, effect: state}
            cases.append((effect, state, plan(scene, assets, effects=effects, engine=engine)))
        full = plan(scene, assets, engine=engine, scope="everything")
        for label, state, again in [*cases, ("everything", "on", full)]:
            found, cost, said = attempt(scene, assets, again, chosen)
            toggled.append(
                Toggled(
                    label,
                    state,
                    found.answer if found else None,
                    found.measure if found else None,
                    cost,
                    found is not None and same_answer(scene, planned, measured, again, found),
                    said,
                )
            )
    return SceneResult(
        name=name or scene.title,
        title=scene.title,
        question=scene.question,
        plan=planned,
        measured=measured,
        seconds=seconds,
        asset_seconds=0.0,
        expected=expected,
        expectation=expectation,
        toggled=tuple(toggled),
        message=message,
    )


def _engine(options: SceneOptions) -> Backend:
    return options.engine or default_engine() or "none"


def attempt(
    scene: Scene, assets: Mapping[str, SceneAsset], planned: Plan, options: SceneOptions
) -> tuple[Measured | None, float, str]:
    """Answer one plan: what was measured, CPU seconds, and why nothing was measured."""
    if planned.method != "dynamics":
        _import_libraries()
        started = time.process_time()
        measured = run_queries(scene, assets, planned)
        return measured, time.process_time() - started, ""
    if planned.backend == "none":
        return None, 0.0, "no physics engine is installed: pip install 'assetpipe[mujoco]'"
    try:
        run = run_dynamics(scene, assets, planned, timeout=options.timeout)
    except SimulationError as error:
        return None, 0.0, error.message
    return run.measured, run.build_seconds + run.run_seconds, ""


def _import_libraries() -> None:
    """Importing is not answering: it happens once, before the clock runs."""
    for module in ("fcl", "igl", "scipy.sparse.csgraph"):
        import_module(module)


def same_answer(
    scene: Scene, planned: Plan, first: Measured, other_plan: Plan, second: Measured
) -> bool:
    """Whether two runs say the same: the same yes or no, and the same measure within the
    scene's tolerance where both measure the same thing."""
    if first.answer is not None or second.answer is not None:
        same = first.answer == second.answer
    else:
        same = True
    comparable = first.unit == second.unit and (
        scene.expect.measure is not None or first.answer is None
    )
    moved = planned.method != "nothing" and other_plan.method != "nothing"
    if first.measure is None or second.measure is None:
        return same and first.measure == second.measure if comparable else same
    if same and comparable and moved:
        return abs(first.measure - second.measure) <= scene.expect.tolerance
    return same


def _expected(scene: Scene, measured: Measured | None) -> tuple[bool | None, str]:
    wanted = scene.expect
    parts: list[str] = []
    if wanted.answer is not None:
        parts.append(wanted.answer)
    if wanted.measure is not None:
        parts.append(f"{wanted.measure:g} ± {wanted.tolerance:g}")
    said = ", ".join(parts)
    if measured is None or not parts:
        return None, said
    fits = True
    if wanted.answer is not None:
        fits = measured.answer is (wanted.answer == "yes")
    if wanted.measure is not None:
        told = measured.measure
        fits = fits and told is not None and abs(told - wanted.measure) <= wanted.tolerance
    return fits, said
