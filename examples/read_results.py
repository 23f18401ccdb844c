"""What a run leaves in its folder, and how to read it: history, summary and animation.

Physics: two rubber rings collide (the shipped case `ring_collision`, of Robortella, Nishimoto and Cheng).
Reference: animation and history must agree: the same momentum and kinetic energy from the velocities of the particles,
and the same path of the centre of each ring from their positions.
Run time: 2 s on one core, 1 s with --quick (a third of the time).
Command: python examples/read_results.py [--quick]
Expect: agreement to 1e-6, the seven digits of the animation; the momentum of both together is zero.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom

import warp_mps as mps

# --- a run with more probes than the case has


def run(folder: Path, duration: float) -> mps.Scene:
    """Run the shipped case, with probes of momentum and kinetic energy."""
    scene = mps.read_stage(mps.find_case("ring_collision"))
    more = [
        mps.Probe(name=f"{body.name}_{quantity}", body=body.name, quantity=quantity)
        for body in scene.bodies
        for quantity in ("position", "momentum", "kinetic_energy")
    ]
    scene = replace(scene, probes=(*scene.probes, *more), duration=duration, measurements=())
    mps.run_scene(scene, folder, quiet=True)
    return scene


# --- the animation: any program that reads USD can do this


def read_animation(path: Path) -> dict[str, dict[str, np.ndarray]]:
    """Times [s], positions [m] and velocities [m/s] of every body, shapes [frames] and [frames, n, 3]."""
    stage = Usd.Stage.Open(str(path))
    unit, rate = UsdGeom.GetStageMetersPerUnit(stage), stage.GetTimeCodesPerSecond()
    bodies = {}
    for prim in stage.GetDefaultPrim().GetChildren():
        points = UsdGeom.Points(prim)
        codes = points.GetPointsAttr().GetTimeSamples()
        # zero unless the scene is far from the origin of the stage
        origin = np.array(points.ComputeLocalToWorldTransform(Usd.TimeCode.Default()).ExtractTranslation())
        bodies[prim.GetName()] = {
            "times": np.array(codes) / rate,
            "places": unit * (origin + np.array([points.GetPointsAttr().Get(code) for code in codes], dtype=float)),
            "velocities": unit * np.array([points.GetVelocitiesAttr().Get(code) for code in codes], dtype=float),
        }
    return bodies


def main(quick: bool = False) -> dict[str, float]:
    """Run, read and compare; the greatest relative difference of each quantity."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = run(folder, 0.02 if quick else 0.06)
        history = mps.read_history(folder / "probes.csv")
        summary = mps.read_summary(folder / "run.json")
        bodies = read_animation(folder / "run.usdc")
    print(f"{summary.case}: {summary.status}, {summary.steps} steps, energy drift {summary.energy['drift']:.1e}")
    differences: dict[str, float] = {}
    total = np.zeros(2)
    for body in scene.bodies:
        found = bodies[body.name]
        # the particles are of equal mass, per metre of depth
        mass = body.material.density * body.spacing**2
        rows = np.searchsorted(history.times, found["times"] - 1e-9)
        known = {
            "position": found["places"].mean(axis=1)[:, 0],
            "momentum": mass * found["velocities"].sum(axis=1)[:, 0],
            "kinetic_energy": 0.5 * mass * (found["velocities"] ** 2).sum(axis=(1, 2)),
        }
        for quantity, values in known.items():
            said = history.probe(f"{body.name}_{quantity}", 0)[rows]
            apart = float(np.abs(values - said).max() / np.abs(said).max())
            differences[quantity] = max(apart, differences.get(quantity, 0.0))
            print(f"{body.name:6} {quantity:15} {said[0]:+.5f} to {said[-1]:+.5f}, difference {apart:.0e}")
        total += [history.probe(f"{body.name}_momentum", axis)[-1] for axis in (0, 1)]
    print(f"momentum of both at the end: {np.abs(total).max():.0e} kg/s")
    return {**differences, "total": float(np.abs(total).max())}


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
