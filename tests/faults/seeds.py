"""Sound stages, which the malformed ones are made from."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from tests.fluid.scenes import tank
from tests.scenes import HAMILTONIAN, RUBBER, STEEL, beam, block, ends, scene_of
from tests.shapes.surfaces import cube
from warp_mps.scene import Body, Contact, HarmonicRotation, Load, Part, Probe, Scene, Support, TableMotion, Wall
from warp_mps.shapes import Box, Mesh, Points
from warp_mps.usd.case.save import save_stage
from warp_mps.usd.shipped_cases import shipped_cases

SHIPPED = (
    *("beam_first_mode_as_published", "mass_spring_free", "ring_collision", "block_on_wall", "paddle_and_block"),
    *("bar_struck_by_wall", "sandwich_cantilever", "turek_csm1", "twisting_column_3d", "rubber_drop_3d"),
    *("sloshing_tank", "dam_break", "dam_break_3d", "elliptical_drop", "square_patch", "standing_wave"),
)


def seeds() -> dict[str, str]:
    """Texts of sound stages, by name: shipped ones, and some with what none of these has."""
    cases = shipped_cases()
    made = {"implicit": _implicit(), "mesh": _mesh(), "points": _points(), "tank": _tank(), "gate": _gate()}
    with tempfile.TemporaryDirectory() as scratch:
        for name, scene in made.items():
            cases[name] = Path(scratch) / f"{name}.usda"
            save_stage(scene, cases[name])
        return {name: cases[name].read_text(encoding="utf-8") for name in (*SHIPPED, *made)}


def _implicit() -> Scene:
    """A clamped beam that is shaken in implicit steps, and drawn at by a load."""
    table = TableMotion(times=np.array([0.0, 0.1, 0.2]), displacements=np.array([[0.0, 0.0], [0.0, 0.01], [0.0, 0.0]]))
    clamp = Support(name="clamp", region=ends(0.006)[0], motion=table)
    load = Load(name="pull", region=ends(0.006)[1], force=(0.0, -1.0))
    probes = (Probe(name="tip", point=(0.15, 0.0)), Probe(name="clamp", quantity="reaction", support="clamp"))
    steps = {"integrator": "implicit", "time_step": 1e-3, "contact": Contact(between="none"), "elasticity": HAMILTONIAN}
    return beam(4, supports=(clamp,), loads=(load,), probes=probes, **steps)


def _mesh() -> Scene:
    """A block that is a closed mesh, partly of another material, above a wall that turns."""
    points, triangles = cube()
    part = Part(name="core", region=Box((0.5, 0.5, 0.5)), material=STEEL)
    body = Body(name="block", shape=Mesh(points, triangles), material=RUBBER, spacing=0.125, parts=(part,))
    turn = HarmonicRotation(amplitude=0.1, frequency=2.0, pivot=(0.0, -0.6, 0.0), axis=(0.0, 0.0, 1.0))
    wall = Wall(name="floor", shape=Box((2.0, 0.25, 2.0), (0.0, -0.75, 0.0)), spacing=0.125, rotation=turn)
    probe = Probe(name="core", quantity="stress", region=Box((0.6, 0.6, 0.6)))
    return scene_of(body, dimension=3, walls=(wall,), probes=(probe,), outputs=("stress",), gravity=(0.0, -9.81, 0.0))


def _points() -> Scene:
    """Ready-made particles with velocities, and a block."""
    at = np.stack(np.meshgrid(np.arange(6.0), np.arange(4.0), indexing="ij"), axis=2).reshape(-1, 2) * 0.01
    cloud = Points(at + np.array([0.1, 0.0]), np.full_like(at, -0.5))
    return scene_of(block(2), Body(name="cloud", shape=cloud, material=RUBBER, spacing=0.01))


def _gate() -> Scene:
    """Water that leans on an elastic plate."""
    plate = Body(name="plate", shape=Box((0.04, 0.2), (0.18, 0.1)), material=STEEL, spacing=0.02)
    clamp = Support(name="clamp", region=Box((0.04, 0.04), (0.18, 0.02)))
    probe = Probe(name="push", quantity="contact_force", body="plate")
    return tank((8, 6), room=(12, 10), bodies=(plate,), supports=(clamp,), probes=(probe,))


def _tank() -> Scene:
    """Water in a tank that slides by a table."""
    table = TableMotion(times=np.array([0.0, 0.1]), displacements=np.array([[0.0, 0.0], [0.01, 0.0]]))
    probe = Probe(name="push", quantity="contact_force", body="x_low")
    return tank((6, 6), room=(8, 10), wall={"motion": table}, probes=(probe,))
