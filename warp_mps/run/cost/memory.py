"""Memory that a run needs, and how much there is."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping

from warp_mps.core.weights import lattice_neighbours
from warp_mps.coupling.integrator_choice import takes_implicit_steps
from warp_mps.errors import InputError
from warp_mps.fluid.neighbour_room import most_particles
from warp_mps.particles.filling import count_particles
from warp_mps.scene import Body, Scene
from warp_mps.scene.validation.rules import kind_of, place

# memory of the program itself, with its libraries and kernels [bytes]; 290 to 310 MiB measured
PROGRAM = 300 * 2**20
# memory per particle of a scene of fluids, walls and markers of bodies included [bytes] (2-D, 3-D); tanks of 0.04 and
# 0.13 million particles took 1610 in 2-D and 1930 in 3-D, and less where most are of walls; neighbour lists that have
# to grow to twice the room, which dam breaks do not need, take 1000 and 1600 more
BYTES_OF_FLUID = {2: 1700, 3: 2100}
# memory per particle of a body, and per pair [bytes] (2-D, 3-D); blocks of 0.16 and 0.04 million particles took 1200
# and 1820 a particle at the peak, where these figures give 1220 and 1860
BYTES_PER_PARTICLE = {2: 900, 3: 1000}
BYTES_PER_PAIR = {2: 40, 3: 48}
# additional memory per particle of contact between bodies of equal spacing, and of friction [bytes] (2-D, 3-D); 320 and
# 550, 450 and 920 measured
BYTES_OF_CONTACT = {2: 350, 3: 450}
BYTES_OF_FRICTION = {2: 560, 3: 930}
# additional memory per marker of a body in water, mostly of the interface quasi-Newton method [bytes] (2-D, 3-D);
# columns of water against blocks took 3800 to 8100 in 2-D and 8900 in 3-D
BYTES_OF_MARKER = {2: 8500, 3: 10000}
# additional memory per particle of implicit steps and statics [bytes] (2-D, 3-D); 1150 and 1850 measured, of which
# aggregates take 490 and 730, most of it during setup
BYTES_OF_SOLVER = {2: 1200, 3: 2000}
# cells of the lattices about shapes up to which the particles in them are counted; they take a minute or two
MOST_CELLS = 1e8


def memory_of(scene: Scene, particles: Mapping[str, int]) -> float:
    """Memory that a run with so many particles of each body, wall and fluid needs at most [bytes]."""
    d, elastic, total = scene.dimension, sum(particles[body.name] for body in scene.bodies), sum(particles.values())
    pairs = lattice_neighbours(d, scene.elasticity.effective_radius)
    implicit = scene.implicit or bool(scene.fluids and scene.bodies and takes_implicit_steps(scene))
    own = BYTES_PER_PARTICLE[d] + BYTES_PER_PAIR[d] * pairs + (BYTES_OF_SOLVER[d] if implicit else 0)
    dry = total - sum(particles[fluid.name] for fluid in scene.fluids)
    wet = total - elastic if scene.fluids else 0
    # without fluids, walls take as much memory as bodies
    solid = elastic if scene.fluids else total
    seen = sum(particles[body.name] / _finer(scene, body) ** d for body in scene.bodies) if scene.fluids else 0.0
    water = wet * BYTES_OF_FLUID[d] + seen * (BYTES_OF_FLUID[d] + BYTES_OF_MARKER[d])
    return solid * own + dry * contact_of(scene, BYTES_OF_CONTACT, BYTES_OF_FRICTION) + water


def _finer(scene: Scene, body: Body) -> int:
    """Particles of a body along a spacing of the fluid."""
    return max(1, round(scene.fluids[0].spacing / body.spacing))


def contact_of(scene: Scene, touching: Mapping[int, float], friction: Mapping[int, float]) -> float:
    """Additional cost of contact per particle: the first where bodies can touch, and the second with friction."""
    several = len(scene.bodies) + len(scene.walls) > 1
    if scene.contact.between == "none" or not (several or scene.contact.between == "all"):
        return 0.0
    slides = scene.contact.friction or any(wall.friction for wall in scene.walls)
    return touching[scene.dimension] + (friction[scene.dimension] if slides else 0.0)


def refuse_too_large(scene: Scene, *, available: float | None = None, memory: str = "memory") -> None:
    """Refuse a run that is too large, before any of it is allocated.

    Args:
        scene: The case.
        available: Memory that there is [bytes]; None is that of the machine.
        memory: What kind of memory it is.

    Raises:
        InputError: It needs more memory than is available, or has more fluid particles than its pressure equation can
            count; the line names the largest body, wall or fluid.
    """
    available = available_memory() if available is None else available
    particles = count_particles(scene)
    if _excess(scene, particles, available, memory) and sum(particles.values()) <= MOST_CELLS:
        particles = count_particles(scene, exact=True)
    excess = _excess(scene, particles, available, memory)
    if excess:
        among = scene.fluids if excess.startswith("the pressure") else scene.filled
        item = max(among, key=lambda one: particles[one.name])
        reason = f"{item.spacing:g} m makes {particles[item.name]:.4g} particles; {excess}"
        raise InputError(place(item, kind_of(item)), "spacing", reason)


def _excess(scene: Scene, particles: Mapping[str, int], available: float, memory: str) -> str:
    """What a run with so many particles of each body, wall and fluid has too much of; empty if nothing."""
    liquid = sum(particles[fluid.name] for fluid in scene.fluids)
    most = most_particles(scene.dimension, scene.flow.radius(scene.dimension))
    needed = memory_of(scene, particles)
    if needed > available:
        here = f"{available / 2**30:.3g} GiB are available"
        return f"the run needs about {needed / 2**30:.3g} GiB of {memory} and {here}"
    return f"the pressure equation takes at most {most:.4g} of fluids" if liquid > most else ""


def available_memory() -> float:
    """Memory that can be taken without swapping [bytes]; infinite where the system does not say."""
    return min(_free_memory(), _left_of_limit())


def _left_of_limit() -> float:
    """Memory that the process may still take [bytes], where its address space is limited."""
    try:
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if limit == resource.RLIM_INFINITY:
            return math.inf
        with open("/proc/self/statm", encoding="ascii") as file:
            return max(0.0, limit - float(file.read().split()[0]) * resource.getpagesize())
    except (ImportError, OSError, ValueError):
        return math.inf


def _free_memory() -> float:
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            values = dict(line.split(":") for line in file)
        return float(values["MemAvailable"].split()[0]) * 1024.0
    except (OSError, KeyError, ValueError):
        pass
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (OSError, ValueError, AttributeError):
        return float("inf")
