"""A case made of an asset: a stage references a mesh in another file, and gives it a role.

Physics: a rubber ring (a torus, 60 mm across its middle line, 24 mm thick; E 10 MPa, nu 0.45, 1100 kg/m^3) rotates
about one of its diameters, without gravity.
Reference: the volume 2 pi^2 R r^2 = 0.0853 litres and, of a rigid ring, the angular momentum
m (R^2/2 + 5 r^2/8) omega = 0.000507 kg m^2/s; both are conserved, and the ring is nearly rigid at 10 rad/s.
Run time: 12 s on one core, 3 s with --quick (a spacing of 3 instead of 2 mm).
Command: python examples/mesh_asset.py [--quick]
Expect: both within 0.3 %, 2 % with --quick, and a change of the angular momentum below 1e-10.
"""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

import warp_mps as mps

MIDDLE, HALF = 30.0, 12.0  # radii of the middle line and of the section [mm]
DENSITY, SPIN = 1100.0, 10.0  # [kg/m^3, rad/s]

# --- the asset, as it may come from a modelling program: no word of physics in it


def write_asset(path: Path, around: int = 96, across: int = 48) -> None:
    """A torus about z as a mesh of quadrilaterals, in millimetres."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    mesh = UsdGeom.Mesh.Define(stage, "/Ring")
    stage.SetDefaultPrim(mesh.GetPrim())
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    radius = MIDDLE + HALF * np.cos(v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), HALF * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    k, m = (i + 1) % around, (j + 1) % across
    faces = np.stack([i * across + j, k * across + j, k * across + m, i * across + m], axis=-1)
    mesh.CreatePointsAttr(points.astype(np.float32).tolist())
    mesh.CreateFaceVertexCountsAttr([4] * len(faces))
    mesh.CreateFaceVertexIndicesAttr(faces.ravel().tolist())
    mesh.CreateSubdivisionSchemeAttr("none")
    stage.Save()


# --- the case, which references it


def write_case(path: Path, asset: str, spacing: float) -> None:
    """A stage in millimetres whose one body is the asset."""
    stage, types = Usd.Stage.CreateNew(str(path)), Sdf.ValueTypeNames
    UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)

    def put(prim: Usd.Prim, **values: tuple[Sdf.ValueTypeName, object]) -> None:
        for name, (kind, value) in values.items():
            prim.CreateAttribute(f"mps:{name}", kind).Set(value)

    scene = UsdPhysics.Scene.Define(stage, "/Scene")
    scene.CreateGravityMagnitudeAttr(0.0)
    put(scene.GetPrim(), duration=(types.Double, 0.02), frameRate=(types.Double, 200.0))
    rubber = stage.DefinePrim("/Rubber", "Material")
    # kilograms per cubic millimetre
    UsdPhysics.MaterialAPI.Apply(rubber).CreateDensityAttr(DENSITY * 1e-9)
    # Pa = kg/(m s^2), here kg/(mm s^2)
    put(rubber, youngsModulus=(types.Double, 1e7 * 1e-3), poissonsRatio=(types.Double, 0.45))
    ring = stage.DefinePrim("/Ring")
    ring.GetReferences().AddReference(asset)
    ring.CreateRelationship("material:binding:physics").SetTargets(["/Rubber"])
    put(ring, role=(types.Token, "body"), spacing=(types.Double, spacing))
    put(ring, angularVelocity=(types.Double3, Gf.Vec3d(SPIN, 0.0, 0.0)))
    spin = stage.DefinePrim("/Spin", "Xform")
    put(spin, role=(types.Token, "probe"), quantity=(types.Token, "angular_momentum"))
    spin.CreateRelationship("mps:target").SetTargets(["/Ring"])
    stage.Save()


def main(quick: bool = False) -> tuple[float, float, float]:
    """Run it; relative errors of volume and angular momentum, and the relative change of the latter."""
    spacing = 0.003 if quick else 0.002
    with tempfile.TemporaryDirectory() as folder:
        write_asset(Path(folder) / "ring.usda")
        write_case(Path(folder) / "case.usda", "./ring.usda", 1e3 * spacing)
        summary = mps.run_scene(mps.read_stage(f"{folder}/case.usda"), f"{folder}/run", quiet=True)
        momentum = mps.read_history(f"{folder}/run/probes.csv").probe("Spin", 0)
    volume = summary.particles["Ring"] * spacing**3
    exact = 2.0 * math.pi**2 * MIDDLE * HALF**2 * 1e-9
    inertia = DENSITY * exact * (MIDDLE**2 / 2 + 5 * HALF**2 / 8) * 1e-6
    errors = volume / exact - 1.0, momentum[0] / (inertia * SPIN) - 1.0, float(np.ptp(momentum) / momentum[0])
    print(f"volume {1e3 * volume:.4f} litres ({errors[0]:+.2%}), {summary.particles['Ring']} particles")
    print(f"angular momentum {momentum[0]:.6f} kg m^2/s ({errors[1]:+.2%}), relative change {errors[2]:.0e}")
    return errors


if __name__ == "__main__":
    main(quick="--quick" in sys.argv)
