"""warp_mps: elastic structures and water by the Moving Particle Semi-implicit method (MPS), in NVIDIA Warp.

A case is a USD stage or a `Scene` made in Python; a result is a USD animation. A first simulation::

    import warp_mps as mps

    rubber = mps.Material(density=1000.0, youngs_modulus=1e7, poissons_ratio=0.3)
    beam = mps.Body(name="beam", shape=mps.Box((0.16, 0.02)), material=rubber, spacing=0.0025)
    clamp = mps.Support(name="clamp", region=mps.Box((0.01, 0.04), center=(-0.08, 0.0)))
    tip = mps.Probe(name="tip", point=(0.078, 0.0))
    scene = mps.Scene(bodies=(beam,), supports=(clamp,), probes=(tip,), gravity=(0.0, -9.81), duration=0.5)
    summary = mps.run_scene(scene, "runs/first")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from warp_mps.version import __version__ as __version__

if TYPE_CHECKING:
    from warp_mps.app.notebook import picture, plot, report, video
    from warp_mps.errors import InputError, RunError
    from warp_mps.observers.base import Observer, View
    from warp_mps.results.history import read_history
    from warp_mps.results.summary import RunSummary, read_summary
    from warp_mps.run.inventory.case_check import CaseCheck, check
    from warp_mps.run.run import run_scene
    from warp_mps.run.simulation import Simulation
    from warp_mps.scene import (
        Body,
        BodyForce,
        Contact,
        Elasticity,
        Flow,
        Fluid,
        HarmonicMotion,
        HarmonicRotation,
        Liquid,
        Load,
        Material,
        Measurement,
        Part,
        Probe,
        Scene,
        StageFrame,
        Support,
        TableMotion,
        TableRotation,
        VelocityField,
        Wall,
        fill_to,
        tank,
    )
    from warp_mps.shapes import Box, Cylinder, Difference, Intersection, Mesh, Points, Shape, Sphere, Union
    from warp_mps.usd.case.read import read_stage
    from warp_mps.usd.case.save import save_stage
    from warp_mps.usd.shipped_cases import find_case, shipped_cases


# where each public name is defined; they are imported when they are first used, for Warp and USD take seconds to load
_HOMES = {
    "warp_mps.app.notebook": ("picture", "plot", "report", "video"),
    "warp_mps.usd.shipped_cases": ("find_case", "shipped_cases"),
    "warp_mps.errors": ("InputError", "RunError"),
    "warp_mps.observers.base": ("Observer", "View"),
    "warp_mps.results.history": ("read_history",),
    "warp_mps.results.summary": ("RunSummary", "read_summary"),
    "warp_mps.run.inventory.case_check": ("CaseCheck", "check"),
    "warp_mps.run.run": ("run_scene",),
    "warp_mps.scene": (
        *(
            "Body",
            "BodyForce",
            "Contact",
            "Elasticity",
            "Flow",
            "Fluid",
            "HarmonicMotion",
            "HarmonicRotation",
            "Liquid",
            "Load",
        ),
        *("Material", "Measurement"),
        *("Part", "Probe", "Scene", "StageFrame", "Support", "TableMotion", "TableRotation", "VelocityField", "Wall"),
        *("fill_to", "tank"),
    ),
    "warp_mps.shapes": (
        *("Box", "Cylinder", "Difference", "Intersection", "Mesh", "Points", "Shape", "Sphere", "Union"),
    ),
    "warp_mps.run.simulation": ("Simulation",),
    "warp_mps.usd.case.read": ("read_stage",),
    "warp_mps.usd.case.save": ("save_stage",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Body",
    "BodyForce",
    "Box",
    "CaseCheck",
    "Contact",
    "Cylinder",
    "Difference",
    "Elasticity",
    "Flow",
    "Fluid",
    "HarmonicMotion",
    "HarmonicRotation",
    "InputError",
    "Intersection",
    "Liquid",
    "Load",
    "Material",
    "Measurement",
    "Mesh",
    "Observer",
    "Part",
    "Points",
    "Probe",
    "RunError",
    "RunSummary",
    "Scene",
    "Shape",
    "Simulation",
    "Sphere",
    "StageFrame",
    "Support",
    "TableMotion",
    "TableRotation",
    "Union",
    "VelocityField",
    "View",
    "Wall",
    "check",
    "fill_to",
    "find_case",
    "picture",
    "plot",
    "read_history",
    "read_stage",
    "read_summary",
    "report",
    "run_scene",
    "save_stage",
    "shipped_cases",
    "tank",
    "video",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
