"""Small cases with some tens of frames, and what must hold of their results after a fault."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tests.coupling.scenes import IMPLICIT, RUBBING, busy
from tests.fluid.scenes import L0, tank
from tests.scenes import beam, ends
from warp_mps.results.history import read_history
from warp_mps.results.summary import read_summary
from warp_mps.run.run import run_scene
from warp_mps.scene import Elasticity, HarmonicMotion, Probe, Scene, Support
from warp_mps.shapes import Box
from warp_mps.usd.case.read import read_stage
from warp_mps.usd.case.save import save_stage

RESULTS = {"checkpoint.npz", "checkpoint.prev.npz", "probes.csv", "run.json", "run.usdc"}


@dataclass(frozen=True)
class Case:
    """A case with its continuous run.

    Attributes:
        name: One of `SCENES`.
        stage: Its stage.
        whole: Folder of the continuous run.
    """

    name: str
    stage: Path
    whole: Path

    @property
    def scene(self) -> Scene:
        """The scene of the stage, as a process that reads it has it."""
        return read_stage(self.stage)


def make_case(name: str, folder: Path, *, frames: int = 60) -> Case:
    """Save the stage of a case in a folder, and run it there."""
    case = Case(name, folder / f"{name}.usda", folder / f"{name}_whole")
    save_stage(SCENES[name](frames), case.stage)
    run_scene(case.scene, case.whole, quiet=True)
    return case


def _solid(frames: int) -> Scene:
    """A cantilever that falls."""
    clamp = Support(name="clamp", region=ends(0.006)[0])
    probe = Probe(name="tip", point=(0.15, 0.0))
    motion = {"gravity": (0.0, -9.81), "duration": frames / 1000.0, "frame_rate": 1000.0, "sample_rate": 2000.0}
    return beam(4, supports=(clamp,), probes=(probe,), elasticity=Elasticity(), name="solid", **motion)


def _fluid(frames: int) -> Scene:
    """A column that falls over in a shaken tank, in steps as long as its speed allows."""
    wall = {"motion": HarmonicMotion(amplitude=(0.01, 0.0), frequency=3.0)}
    probe = Probe(name="force", quantity="contact_force", body="x_low")
    return tank(
        (6, 10), room=(12, 12), wall=wall, probes=(probe,), duration=frames / 100.0, frame_rate=100.0, name="fluid"
    )


def _wet(frames: int) -> Scene:
    """Blocks in a shaken tank that rub against each other and the walls, in explicit steps within the water's."""
    return _coupled("wet", frames, RUBBING)


def _implicit(frames: int) -> Scene:
    """The blocks, in implicit steps; the heavy one is held, for nothing else keeps it from the floor."""
    held = Support(name="rod", region=Box((1.0, 2.0 * L0), (0.0, 4.0 * L0)), bodies=("heavy",))
    return _coupled("implicit", frames, {**IMPLICIT, "supports": (held,)})


def _coupled(name: str, frames: int, way: dict[str, Any]) -> Scene:
    probes = (Probe(name="light", quantity="contact_force", body="light"),)
    return busy(probes=probes, duration=frames / 200.0, frame_rate=200.0, name=name, **way)


SCENES: dict[str, Callable[[int], Scene]] = {"solid": _solid, "fluid": _fluid, "wet": _wet, "implicit": _implicit}


def assert_readable(case: Case, folder: Path) -> None:
    """Every file opens and holds, as far as it goes, what the continuous run's holds."""
    if (folder / "probes.csv").exists():
        rows = read_history(folder / "probes.csv").rows
        assert rows == read_history(case.whole / "probes.csv").rows[: len(rows)]
    if (folder / "run.json").exists():
        assert read_summary(folder / "run.json").case == case.name
    if (folder / "run.usdc").exists():
        found, whole = animation(folder), animation(case.whole)
        for path, samples in found.items():
            assert list(samples) == list(whole[path])[: len(samples)], path
            assert all(np.array_equal(values, whole[path][code]) for code, values in samples.items()), path


def assert_continues(case: Case, folder: Path) -> float:
    """Check that a run resumes to the results of the continuous run; the time of its checkpoint [s], -1 without one."""
    start = -1.0
    if (folder / "checkpoint.npz").exists() or (folder / "checkpoint.prev.npz").exists():
        first = _first_time(case, folder)
        run_scene(case.scene, folder, resume=True, quiet=True)
        start = first
    else:
        run_scene(case.scene, folder, overwrite=True, quiet=True)
    assert_same(case, folder)
    return start


def assert_same(case: Case, folder: Path) -> None:
    """The results are those of the continuous run, and nothing else is in the folder."""
    assert (folder / "probes.csv").read_bytes() == (case.whole / "probes.csv").read_bytes()
    found, whole = animation(folder), animation(case.whole)
    assert found.keys() == whole.keys()
    for path, samples in whole.items():
        assert list(found[path]) == list(samples), path
        assert all(np.array_equal(values, found[path][code]) for code, values in samples.items()), path
    summaries = [json.loads((where / "run.json").read_text()) for where in (folder, case.whole)]
    for key in ("status", "reason", "steps", "time", "energy", "measurements", "particles"):
        assert summaries[0][key] == summaries[1][key], key
    assert {path.name for path in folder.iterdir()} <= RESULTS


def animation(folder: Path) -> dict[str, dict[float, np.ndarray]]:
    """Every sample of an animation, by attribute and time code."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(folder / "run.usdc"))
    return {
        str(attribute.GetPath()): {code: np.array(attribute.Get(code)) for code in attribute.GetTimeSamples()}
        for prim in stage.Traverse()
        for attribute in prim.GetAttributes()
        if attribute.GetNumTimeSamples()
    }


def _first_time(case: Case, folder: Path) -> float:
    from warp_mps.observers.checkpoint import load_checkpoint
    from warp_mps.run.provenance import fingerprint

    return load_checkpoint(folder, fingerprint(case.scene, "float64")).time
