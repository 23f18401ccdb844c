"""The figure and the tables of `docs/resolution.md`: how errors fall with the spacing and with the time step.

The beam and the dam break are those of the examples `compare_models.py` and `dam_break.py`.

Run time: 3 min on one core.
Command: python docs/figures/convergence.py
"""

from __future__ import annotations

import runpy
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np

import warp_mps as mps

mpl.use("agg")
HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parent.parent / "examples"
ROWS, ACROSS = (4, 8, 16), (12, 24, 48)
# arrival of the front of potential flow [s] by its place [m], from tests/validation/potential_flow.py
ARRIVALS = {0.183: 0.05322, 0.276: 0.1154, 0.382: 0.1681, 0.529: 0.2301}


def beam(model: str, rows: int, *, control: float = 0.5, courant: float = 0.25) -> mps.Scene:
    """The beam of `compare_models.py` for five periods."""
    scene = runpy.run_path(str(EXAMPLES / "compare_models.py"))["beam"](model, rows, 0.12)
    return replace(scene, elasticity=mps.Elasticity(model=model, control=control), courant=courant)


def dam(across: int, *, courant: float = 0.2) -> mps.Scene:
    """The column of `dam_break.py` until its front has passed the last place."""
    scene = runpy.run_path(str(EXAMPLES / "dam_break.py"))["dam"](across)
    return replace(scene, duration=0.26, flow=mps.Flow(courant=courant))


def run(scene: mps.Scene) -> tuple[mps.RunSummary, dict[str, np.ndarray], float]:
    """Run a scene; its summary, the time and the first component of each probe, and the wall time [s]."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        summary = mps.run_scene(scene, folder, quiet=True)
        history = mps.read_history(f"{folder}/probes.csv")
    columns = {probe.name: history.probe(probe.name, 0) for probe in scene.probes}
    return summary, {"time": history.times, **columns}, time.perf_counter() - begin


def beam_error(scene: mps.Scene) -> tuple[float, int, float]:
    """Relative error of the frequency, steps, and wall time [s]."""
    summary, _, wall = run(scene)
    return float(summary.measurements[0]["error"]), summary.steps, wall


def dam_error(scene: mps.Scene) -> tuple[np.ndarray, int, float]:
    """Relative lateness of the front at each place, steps, and wall time [s]."""
    summary, columns, wall = run(scene)
    arrivals = np.interp(list(ARRIVALS), np.maximum.accumulate(columns["front"]), columns["time"])
    return arrivals / np.array(list(ARRIVALS.values())) - 1.0, summary.steps, wall


def draw(beams: dict[str, list[float]], fronts: list[np.ndarray]) -> None:
    """Both studies as one figure."""
    from matplotlib.figure import Figure

    mpl.rcParams.update({"svg.fonttype": "none", "font.size": 9, "svg.hashsalt": "convergence"})
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for name, errors in beams.items():
        left.loglog(ROWS, 100.0 * np.abs(errors), "o-", label=name)
    left.loglog(ROWS, 8.0 * (4.0 / np.array(ROWS)) ** 2, "k:", label="second order")
    left.set(title="beam: frequency", xlabel="particles through the thickness", ylabel="error [%]")
    for k, place in enumerate(ARRIVALS):
        right.loglog(ACROSS, [100.0 * abs(front[k]) for front in fronts], "o-", label=f"front at {place} m")
    right.loglog(ACROSS, 20.0 * (12.0 / np.array(ACROSS)), "k:", label="first order")
    right.set(title="dam break: arrival of the front", xlabel="particles across the column", ylabel="late by [%]")
    for axes, ticks in ((left, ROWS), (right, ACROSS)):
        axes.set_xticks(ticks, [str(tick) for tick in ticks])
        axes.minorticks_off()
        axes.legend(fontsize=7, frameon=False)
        axes.grid(alpha=0.3)
    figure.savefig(HERE / "convergence.svg", metadata={"Date": None})


def main() -> None:
    """Run both studies, print their tables, and draw the figure."""
    beams: dict[str, list[float]] = {}
    for name, model, control in (
        ("springs", "springs", 0.5),
        ("hamiltonian, control 0.5", "hamiltonian", 0.5),
        ("hamiltonian, control 0.7", "hamiltonian", 0.7),
    ):
        beams[name] = []
        for rows in ROWS:
            error, steps, wall = beam_error(beam(model, rows, control=control))
            beams[name].append(error)
            print(f"{name}, {rows} rows: {error:+.2%}, {steps} steps, {wall:.1f} s", flush=True)
    for courant in (0.1, 0.25, 0.5, 1.0):
        error, steps, wall = beam_error(beam("hamiltonian", 8, courant=courant))
        print(f"beam, 8 rows, courant {courant}: {error:+.3%}, {steps} steps, {wall:.1f} s", flush=True)
    fronts = []
    for across in ACROSS:
        late, steps, wall = dam_error(dam(across))
        fronts.append(late)
        print(f"dam, {across} across: {np.round(100 * late, 1)} % late, {steps} steps, {wall:.1f} s", flush=True)
    for courant in (0.1, 0.2, 0.4):
        late, steps, wall = dam_error(dam(24, courant=courant))
        print(f"dam, 24 across, courant {courant}: {np.round(100 * late, 1)} % late, {steps} steps, {wall:.1f} s")
    draw(beams, fronts)


if __name__ == "__main__":
    main()
