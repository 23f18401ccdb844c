"""Random scenes of water and bodies in a tank, whose results are read by USD alone: nothing may go wrong silently.

As a script, ``python -m tests.faults.random_scenes [SCENES [SEED]]``, it runs so many and prints what became of them.
A scene is silent if its run ends with exit 0 and without a remark, although its result shows one of these: numbers that
are not finite, water in a wall or under its tank, water within a body, energy from nowhere, or water that should rest
and does not.
"""

from __future__ import annotations

import collections
import contextlib
import io
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom

import warp_mps as mps
from warp_mps.scene import Scene

SPACING, GRAVITY = 0.01, 9.81
# in spacings: how far water may be within a wall or from where it rests, and how near to a particle of a body it may be
IN_WALL, AT_REST, IN_BODY = 0.2, 0.5, 0.4
# part of the water that may be too near to a body; part of the exchanged energy that may come from nowhere
SHARE_IN_BODY, ENERGY_GAINED = 0.02, 0.1


@dataclass(frozen=True)
class Outcome:
    """What became of a scene.

    Attributes:
        number: Its number.
        what: What it is.
        code: Exit code of its run.
        remarks: Remarks on it, or why it was refused or failed.
        faults: What its result shows.
    """

    number: int
    what: str
    code: int
    remarks: tuple[str, ...]
    faults: tuple[str, ...]

    @property
    def silent(self) -> bool:
        """Whether something is wrong without a remark."""
        said = " ".join(self.remarks)
        return self.code == 0 and any(not any(word in said for word in _about(fault)) for fault in self.faults)


def _about(fault: str) -> tuple[str, ...]:
    """What a remark on a fault speaks of; none excuses numbers that are not finite."""
    about = {
        "in ": ("outside the tank", "spacings thick"),
        "under": ("outside the tank",),
        "energy": ("energy",),
        "moved": ("spacings apart", "would fit"),
        "within": ("spacings of the water thick", "particle thick"),
    }
    return next((words for key, words in about.items() if key in fault), ())


def make(number: int, *, seed: int = 0) -> tuple[Scene, bool]:
    """A random scene, and whether everything in it should rest."""
    random = np.random.default_rng([seed, number])
    dimension = 3 if random.random() < 0.1 else 2
    width, depth = (random.uniform(8, 26), random.uniform(4, 12)) if dimension == 2 else (8.0, 5.0)
    if random.random() < 0.5:
        width, depth = np.round(width), np.round(depth)
    thickness = random.choice([3.0, 3.0, 3.4, 2.6, 4.0])
    fill = random.choice([1.0, 1.0, 0.5, 0.7])
    top = depth + random.choice([2.0, 6.0, 10.0])
    across = (0.0, 6.0)
    walls = _tank(dimension, width, top, across, thickness)
    water = mps.Fluid(name="water", shape=_box(dimension, (0.0, 0.0), (fill * width, depth), across), spacing=SPACING)
    bodies, supports = _bodies(random, dimension, width, depth, across)
    between = "none" if not bodies or random.random() < 0.5 else "all"
    scene = Scene(
        name=f"random_{number}",
        dimension=dimension,
        walls=walls,
        fluids=(water,),
        bodies=bodies,
        supports=supports,
        contact=mps.Contact(between=between),
        gravity=(0.0, -GRAVITY, 0.0)[:dimension],
        duration=float(random.uniform(0.05, 0.2)) * (1.0 if dimension == 2 else 0.3),
    )
    return scene, fill == 1.0 and not bodies


def _box(dimension: int, low: tuple, high: tuple, across: tuple[float, float]) -> mps.Box:
    low, high = (*low, across[0]), (*high, across[1])
    return mps.Box.from_corners(
        [float(SPACING * c) for c in low[:dimension]], [float(SPACING * c) for c in high[:dimension]]
    )


def _tank(dimension: int, width: float, top: float, across: tuple[float, float], t: float) -> tuple[mps.Wall, ...]:
    low, high = (across[0] - t, across[1] + t) if dimension == 3 else across
    boxes = {
        "floor": ((-t, -t), (width + t, 0.0), (low, high)),
        "left": ((-t, 0.0), (0.0, top), (low, high)),
        "right": ((width, 0.0), (width + t, top), (low, high)),
    }
    if dimension == 3:
        boxes["back"] = ((0.0, 0.0), (width, top), (low, across[0]))
        boxes["front"] = ((0.0, 0.0), (width, top), (across[1], high))
    return tuple(
        mps.Wall(name=name, shape=_box(dimension, *corners), spacing=SPACING) for name, corners in boxes.items()
    )


def _bodies(
    random: np.random.Generator, dimension: int, width: float, depth: float, across: tuple[float, float]
) -> tuple[tuple[mps.Body, ...], tuple[mps.Support, ...]]:
    """Up to two blocks in the water or at its surface, and a flap that is clamped in the floor."""
    bodies, supports = [], []
    spacing = SPACING * random.choice([1.0, 0.5]) if dimension == 2 else SPACING
    for name in ("one", "two")[: random.integers(0, 3)]:
        size = np.round(random.uniform(2, 5, 2))
        left = {"one": 0.0, "two": 0.5 * width}[name]
        x = random.uniform(left, left + max(0.5 * width - size[0], 0.0))
        y = random.uniform(0.0, depth)
        shape = _box(dimension, (x, y), (x + size[0], y + size[1]), (across[0] + 1.0, across[1] - 1.0))
        modulus = 10.0 ** random.uniform(4.0, 6.0)
        material = mps.Material(
            density=random.uniform(100, 3000), youngs_modulus=modulus, poissons_ratio=random.uniform(0.0, 0.45)
        )
        bodies.append(mps.Body(name=name, shape=shape, material=material, spacing=float(spacing)))
    if not bodies and random.random() < 0.5:
        foot = _box(dimension, (0.5 * width, 0.0), (0.5 * width + 2.0, 2.0), across)
        shape = _box(dimension, (0.5 * width, 0.0), (0.5 * width + 2.0, 0.8 * depth), across)
        material = mps.Material(density=1200.0, youngs_modulus=10.0 ** random.uniform(5.0, 7.0), poissons_ratio=0.3)
        bodies.append(mps.Body(name="flap", shape=shape, material=material, spacing=float(spacing)))
        supports.append(mps.Support(name="foot", region=foot))
    return tuple(bodies), tuple(supports)


def lifted(scene: Scene, height: float) -> Scene:
    """The scene with its floor drawn higher [m]."""
    up = (0.0, height, 0.0)[: scene.dimension]
    walls = tuple(
        replace(wall, shape=replace(wall.shape, center=np.add(wall.shape.center[: scene.dimension], up)))
        if wall.name == "floor"
        else wall
        for wall in scene.walls
    )
    return replace(scene, walls=walls)


def run(number: int, folder: Path, *, seed: int = 0) -> Outcome:
    """Run a scene, and read its result."""
    scene, rests = make(number, seed=seed)
    what = f"{scene.dimension}-D, {len(scene.bodies)} bodies, contact {scene.contact.between}"
    remarks: list[str] = []
    code = 0
    with contextlib.redirect_stderr(io.StringIO()):
        try:
            remarks = mps.run_scene(scene, folder, quiet=True, overwrite=True).remarks
        except mps.InputError as error:
            return Outcome(number, what, 2, (str(error),), ())
        except mps.RunError as error:
            code, remarks = 3, [str(error)]
    faults = tuple(find_faults(scene, folder, rests=rests))
    return Outcome(number, what, code, tuple(remarks), faults)


def find_faults(scene: Scene, folder: Path, *, rests: bool) -> Iterator[str]:
    """What is wrong in a result, as its files show it.

    Args:
        scene: The case.
        folder: Folder of the result.
        rests: Whether its water should stay where it is.
    """
    clouds = _clouds(folder / "run.usdc", scene.dimension)
    if not all(np.isfinite(frame).all() for frames in clouds.values() for frame in frames):
        yield "points that are not finite"
        return
    water, spacing = clouds["water"], scene.fluids[0].spacing
    yield from _in_walls(scene, water[-1], spacing)
    for body in scene.bodies:
        near = _nearest(water[-1], clouds[body.name][-1]) < IN_BODY * min(spacing, body.spacing)
        if near.mean() > SHARE_IN_BODY:
            yield f"{near.sum()} of {len(near)} water particles within {body.name}"
    moved = np.abs(water[-1].mean(axis=0) - water[0].mean(axis=0)).max() / spacing
    if rests and moved > AT_REST:
        yield f"water at rest has moved by {moved:.2f} spacings"
    yield from _energy(folder / "probes.csv", scene)


def _in_walls(scene: Scene, water: np.ndarray, spacing: float) -> Iterator[str]:
    floor = 0.0
    for wall in scene.walls:
        low, high = _corners(wall.shape, scene.dimension)
        inside = np.all((water > low + IN_WALL * spacing) & (water < high - IN_WALL * spacing), axis=1)
        floor = min(floor, low[1])
        if inside.any():
            yield f"{inside.sum()} water particles in {wall.name}"
    under = water[:, 1] < floor
    if under.any():
        yield f"{under.sum()} water particles under the tank"


def _energy(path: Path, scene: Scene) -> Iterator[str]:
    rows = np.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2)
    if not np.isfinite(rows).all():
        yield "rows that are not finite"
        return
    kinetic, elastic, contact, potential, work, dissipated = rows[:, -6:].T
    balance = kinetic + elastic + contact + potential - work + dissipated
    exchanged = max(np.ptp(potential), np.max(kinetic + elastic + contact), np.abs(work).max())
    settled = (
        GRAVITY * 1000.0 * SPACING * sum(float(np.prod(fluid.shape.size[: scene.dimension])) for fluid in scene.fluids)
    )
    gained = balance.max() - balance[0]
    if gained > ENERGY_GAINED * (exchanged + settled):
        yield f"energy has grown by {gained / exchanged:.2f} of the exchanged"


def _corners(shape: mps.Box, dimension: int) -> tuple[np.ndarray, np.ndarray]:
    center, half = np.asarray(shape.center, float), 0.5 * np.asarray(shape.size, float)
    return (center - half)[:dimension], (center + half)[:dimension]


def _clouds(path: Path, dimension: int) -> dict[str, list[np.ndarray]]:
    """Points of every frame of every cloud, by name, in the file's coordinates."""
    stage = Usd.Stage.Open(str(path))
    found: dict[str, list[np.ndarray]] = {}
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Points):
            attribute = UsdGeom.Points(prim).GetPointsAttr()
            matrix = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
            times = attribute.GetTimeSamples() or [Usd.TimeCode.Default()]
            frames = [np.asarray(attribute.Get(time), float) @ matrix[:3, :3] + matrix[3, :3] for time in times]
            found[prim.GetName()] = [frame[:, :dimension] for frame in frames]
    return found


def _nearest(queries: np.ndarray, points: np.ndarray) -> np.ndarray:
    return np.array([np.linalg.norm(points - query, axis=1).min() for query in queries])


def campaign(count: int, *, seed: int = 0, first: int = 0) -> Iterator[Outcome]:
    """Run so many scenes."""
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(first, first + count):
            yield run(number, Path(scratch) / "run", seed=seed)


def main(count: int = 200, seed: int = 0, first: int = 0) -> int:
    """Run many scenes and print what became of them; the number of silent ones."""
    table: collections.Counter = collections.Counter()
    for outcome in campaign(count, seed=seed, first=first):
        table[_kind(outcome)] += 1
        if outcome.faults or outcome.code:
            print(
                f"{outcome.number} {outcome.what}: {_kind(outcome)}: {'; '.join((*outcome.faults, *outcome.remarks))}"
            )
            sys.stdout.flush()
    print(", ".join(f"{kind}: {number}" for kind, number in sorted(table.items())))
    return table["SILENT"]


def _kind(outcome: Outcome) -> str:
    if outcome.code:
        return {2: "refused (exit 2)", 3: "failed (exit 3)"}[outcome.code]
    if outcome.silent:
        return "SILENT"
    if outcome.faults:
        return "faults, remarked"
    return "sound, with remarks" if outcome.remarks else "sound"


if __name__ == "__main__":
    sys.exit(min(main(*map(int, sys.argv[1:])), 1))
