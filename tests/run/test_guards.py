"""Guards: an invalid solution ends a run with exit code 3 and one line of cause and place; earlier results are kept."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.coupling.scenes import IMPLICIT, WAYS
from tests.elastic.implicit.test_static import cantilever
from tests.elastic.implicit.test_theta_rule import EDGE, TIP, rod
from tests.fluid.scenes import L0, box, scene_of, tank, water
from tests.scenes import beam, ends
from warp_mps.app.cli import main
from warp_mps.fluid.failures import MOST_UNSOLVED
from warp_mps.fluid.pressure import equation
from warp_mps.results.history import read_history
from warp_mps.run.simulation import Simulation
from warp_mps.scene import Body, Elasticity, Flow, Material, Probe, Scene, Support, TableMotion
from warp_mps.usd.case.save import save_stage

FRAMES = {"frame_rate": 100.0, "duration": 0.2}
PLACE = r"particle \d+ of body '\w+' \(from \([-\d., e]+\) m\)"
# every step of the run's clock shows the state
EVERY = {"frame_rate": 1000.0, "sample_rate": 1000.0}


def falling_beam(**fields: Any) -> Scene:
    """A cantilever that falls, in frames of 1 ms."""
    clamp = Support(name="clamp", region=ends(0.006)[0])
    probe = Probe(name="tip", point=(0.15, 0.0))
    motion = {"gravity": (0.0, -9.81), "duration": 0.02, **EVERY}
    return beam(4, supports=(clamp,), probes=(probe,), elasticity=Elasticity(), **{**motion, **fields})


def still_water(**fields: Any) -> Scene:
    """A tank of still water, in frames of 10 ms."""
    return tank((8, 8), **{**FRAMES, **fields})


def gate(density: float = 1100.0, **fields: Any) -> Scene:
    """Water beside an elastic gate, in frames of 10 ms."""
    scene = tank((8, 8), room=(14, 12), **FRAMES)
    material = Material(density, 1e5, 0.3)
    body = Body(name="gate", shape=box([0.16, 0.0], [0.2, 0.16]), material=material, spacing=L0)
    clamp = Support(name="clamp", region=box([0.15, -0.001], [0.21, 0.021]))
    return replace(scene, bodies=(body,), supports=(clamp,), **fields)


def crushed_rod() -> Scene:
    """A rod whose end is drawn through it to the other side, in one implicit step."""
    way = TableMotion(
        times=np.array([0.0, 0.002, 0.003]), displacements=np.array([[0.0, 0.0], [0.0, 0.0], [-0.3, 0.0]])
    )
    supports = (Support(name="clamp", region=EDGE), Support(name="press", region=TIP, motion=way))
    scene = rod(time_step=1e-3, duration=0.01, supports=supports, **EVERY)
    (body,) = scene.bodies
    return replace(scene, bodies=(replace(body, material=replace(body.material, law="neo_hookean")),))


def leak() -> Scene:
    """Water that falls out of its domain."""
    flow = Flow(domain=([-0.3, -0.2], [0.3, 0.5]))
    return scene_of(water([0.0, 0.0], [0.1, 0.1]), gravity=(0.0, -9.81), flow=flow, **{**FRAMES, "duration": 1.0})


# scenes that fail by themselves, and what they are told
FAILING: dict[str, tuple[Callable[[], Scene], str]] = {
    "energy of a solid": (
        lambda: falling_beam(time_step=5e-5),
        rf"the energy balance has grown by \S+ J/m .* \(step \d+\); the fastest particle is {PLACE} at .* m/s; the "
        r"time step of 5e-05 s is above the stability limit of \S+ s: take less than that",
    ),
    "a body that is too fast": (
        lambda: replace(falling_beam(), bodies=(replace(falling_beam().bodies[0], velocity=(0.0, -1e4)),)),
        r"; 'beam' starts at 1e\+04 m/s, faster than pressure waves of 104\.8 m/s: check its velocity and the units$",
    ),
    "fluid lost": (
        leak,
        rf"at t = 0\.21 s: 5 of 25 fluid particles have left the domain: 5 at its low y end, as {PLACE} at .*: "
        r"close the tank on that side, or give flow\.domain",
    ),
    "Newton, static": (
        lambda: cantilever(supports=(), load_steps=2),
        rf"no equilibrium was found beyond a load factor of 0: .*; {PLACE} was furthest from it$",
    ),
    "Newton, implicit steps": (
        crushed_rod,
        rf"the step from 0\.002 to 0\.003 s was not solved: .*; {PLACE} was furthest from a solution$",
    ),
    "stagnating pressure solve": (
        lambda: still_water(flow=Flow(tolerance=1e-17)),
        rf"at t = 0\.\d+ s: the equation of the pressures was not solved in {MOST_UNSOLVED} steps in a row: its "
        rf"residual is \d\.\d+e-1\d of its right-hand side \(asked: 1e-17\), and largest at {PLACE} at \(.*\) m$",
    ),
}  # fmt: skip


def failed(scene: Scene, folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """The line of a run that fails; the results so far are kept, and can be read."""
    stage, out = folder / "case.usda", folder / "out"
    save_stage(scene, stage)
    assert main(["run", str(stage), "--out", str(out), "--quiet"]) == 3
    captured = capsys.readouterr()
    assert captured.out == ""
    *warnings, line = captured.err.splitlines()
    assert all("expect an unstable run" in warning for warning in warnings)
    assert_kept(out, line)
    return line.removeprefix("warp-mps: ")


def assert_kept(out: Path, line: str) -> None:
    """The results before the failure agree, and hold the checkpoint and the reason."""
    from pxr import Usd

    summary = json.loads((out / "run.json").read_text())
    assert summary["status"] == "failed"
    assert line.endswith(summary["reason"])
    times = read_history(out / "probes.csv").times
    assert 0.0 <= times[-1] <= summary["time"] + 1e-12
    stage = Usd.Stage.Open(str(out / "run.usdc"))
    points = next(prim for prim in stage.GetPrimAtPath("/Result").GetChildren() if prim.GetTypeName() == "Points")
    codes = points.GetAttribute("points").GetTimeSamples()
    assert len(codes) >= 1
    assert all(np.isfinite(np.array(points.GetAttribute("points").Get(code))).all() for code in codes)
    assert (out / "checkpoint.npz").exists()


@pytest.mark.parametrize("name", FAILING)
def test_a_run_that_fails_says_why_and_where(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make, expected = FAILING[name]
    assert re.search(expected, failed(make(), tmp_path, capsys))


def test_the_exit_code_of_the_process_is_3(tmp_path: Path) -> None:
    save_stage(falling_beam(), tmp_path / "case.usda")
    command = [sys.executable, "-m", "warp_mps", "run", str(tmp_path / "case.usda"), "--out", str(tmp_path / "out")]
    command += ["--quiet", "--set", "/World/PhysicsScene.mps:timeStep=5e-5"]
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    assert process.returncode == 3
    warning, line = process.stderr.splitlines()
    assert "above the limit" in warning
    assert "the energy balance has grown" in line
    assert_kept(tmp_path / "out", line)


def poke(monkeypatch: pytest.MonkeyPatch, time: float, change: Callable[[Simulation], None]) -> None:
    """Change the state of a run once, before it continues from a time."""
    advance, done = Simulation.advance, []

    def advance_and_poke(simulation: Simulation, steps: int) -> None:
        if simulation.time > time and not done:
            done.append(True)
            change(simulation)
        advance(simulation, steps)

    monkeypatch.setattr(Simulation, "advance", advance_and_poke)


def put(name: str, value: float, *, of: str, at: int = -1) -> Callable[[Simulation], None]:
    """A change of the state of the ``solid`` or the ``fluids`` that gives one particle, the last one, a value."""

    def change(simulation: Simulation) -> None:
        array = getattr(getattr(simulation, of).state, name)
        values = array.numpy().copy()
        values[at] = value
        array.assign(values)

    return change


@pytest.mark.parametrize("number", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["u", "v"])
def test_a_solid_that_is_not_finite(
    name: str, number: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    poke(monkeypatch, 0.005, put(name, number, of="solid"))
    line = failed(falling_beam(), tmp_path, capsys)
    assert re.search(
        rf"the position of {PLACE} is not finite at 0\.00\d+ s \(step \d+\); what acts on the bodies", line
    )
    assert len(read_history(tmp_path / "out" / "probes.csv").times) >= 6


@pytest.mark.parametrize("number", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["x", "u"])
def test_a_fluid_that_is_not_finite(
    name: str, number: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also if particles whose position is NaN are fewer than may leave the domain."""
    monkeypatch.setattr("warp_mps.fluid.failures.LARGEST_LOSS", 1.0)
    poke(monkeypatch, 0.055, put(name, number, of="fluids"))
    line = failed(still_water(), tmp_path, capsys)
    assert re.search(rf"at t = 0\.07 s: the position of {PLACE} is not finite: the flow has collapsed there", line)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", ["u", "v"])
def test_a_body_in_water_that_is_not_finite(
    name: str,
    way: dict,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Whether it takes many explicit steps in one of the water, or an implicit one, whose solver names the particle."""
    poke(monkeypatch, 0.055, put(name, np.nan, of="solid", at=9))
    line = failed(gate(**way), tmp_path, capsys)
    if way is IMPLICIT:
        assert re.search(r"the step from 0\.06 to \S+ s was not solved: .*; particle \d+ of body 'gate'", line)
    else:
        assert re.search(
            rf"at t = 0\.06 s: (the position of )?{PLACE} .*: the forces between water and bodies are no", line
        )
        assert "particle 9 of body 'gate'" in line


def test_a_body_in_water_that_explodes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    poke(monkeypatch, 0.055, put("v", 1e5, of="solid", at=9))
    line = failed(gate(), tmp_path, capsys)
    assert re.search(rf"at t = 0\.06\d* s: {PLACE} at \(.*\) m moves at \S+ m/s: ", line)
    assert line.endswith(("time step underflow", "the forces between water and bodies are not finite"))


def test_passes_that_do_not_converge(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As where a body is much lighter than the water, and there is one pass a step alone."""
    monkeypatch.setattr("warp_mps.coupling.passes.MOST_PASSES", 1)
    line = failed(gate(density=50.0), tmp_path, capsys)
    assert re.search(
        rf"at t = 0\.\d+ s: the coupling of water and bodies did not converge in {MOST_UNSOLVED} steps in a row", line
    )
    assert re.search(rf"forces on the bodies still change by \S+ of themselves, and most at {PLACE} at \(.*\) m$", line)
    assert "'gate'" in line


def test_a_fluid_whose_energy_grows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stir(simulation: Simulation) -> None:
        state = simulation.fluids.state
        u = state.u.numpy().copy()
        u[-64:, 0] += np.where(np.arange(64) % 2, 3.0, -3.0)
        state.u.assign(u)

    poke(monkeypatch, 0.055, stir)
    line = failed(still_water(), tmp_path, capsys)
    assert re.search(rf"the energy balance has grown by .*; the fastest particle is {PLACE} at .* m/s; the flow", line)


@pytest.mark.parametrize("way", WAYS)
def test_a_body_in_water_whose_energy_grows(
    way: dict, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By a part of what still water may gain."""

    def push(simulation: Simulation) -> None:
        v = simulation.solid.state.v.numpy().copy()
        v[:, 0] += 0.1
        simulation.solid.state.v.assign(v)

    poke(monkeypatch, 0.055, push)
    line = failed(gate(**way), tmp_path, capsys)
    assert re.search(rf"the energy balance of the bodies has grown by .* at 0\.07 s .*{PLACE}.*; the bodies have", line)


def test_a_fluid_whose_steps_collapse(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    poke(monkeypatch, 0.055, put("u", 1e5, of="fluids"))
    line = failed(still_water(), tmp_path, capsys)
    assert re.search(rf"at t = 0\.06\d* s: {PLACE} at \(.*\) m moves at .* m/s: it runs away, the flow", line)
    assert len(read_history(tmp_path / "out" / "probes.csv").times) == 7


def test_a_pressure_solve_without_iterations_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(equation, "MAX_ITERATIONS", 2)
    line = failed(tank((8, 8), room=(12, 12), **FRAMES), tmp_path, capsys)
    assert f"the equation of the pressures was not solved in {MOST_UNSOLVED} steps in a row" in line
    assert re.search(rf"\(asked: 0\.0001\), and largest at {PLACE}", line)


def test_single_steps_that_are_not_solved_do_not_stop_a_run() -> None:
    """Only consecutive steps do: an initial guess of the pressure that is NaN costs one solve."""
    simulation = Simulation(still_water())
    for _ in range(2 * MOST_UNSOLVED):
        put("p", np.nan, of="fluids", at=0)(simulation)
        simulation.advance(1)
    assert simulation.record()["fluid"]["unsolved"] == 2 * MOST_UNSOLVED
    assert simulation.fluids.trouble() is None
