"""Constraints on probes and measurements: quantities of their place, existing components, times within the run."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

from warp_mps.scene.choices import ABOUT_QUANTITIES, AT_MEASURES, MEASURE_UNITS, PROBE_QUANTITIES, PROBE_UNITS
from warp_mps.scene.components import component_names
from warp_mps.scene.validation.fluids import check_probed_fluid, probe_quantities
from warp_mps.scene.validation.rules import choice, named, place, positive, require, vector

if TYPE_CHECKING:
    from warp_mps.scene import Measurement, Probe, Scene


def check_probe(scene: Scene, probe: Probe) -> None:
    """Check a probe.

    Raises:
        InputError: Something is not allowed.
    """
    where = place(probe, "probe")
    reason = f"is {probe.name!r}, must not end like the name of a component, {probe.name.rpartition('.')[2]!r}"
    require(not re.search(r"\.[xyz]{1,2}$", probe.name), where, "name", reason)
    given = [p for p in (probe.point, probe.region, probe.body, probe.support) if p is not None]
    require(len(given) == 1, where, "target", "must be exactly one of a point, a region, a body and a support")
    _check_target(probe, scene, where)
    _check_quantity(probe, scene, where)
    if probe.point is not None:
        vector(probe.point, scene.dimension, where, "point")
    moment = probe.quantity in ABOUT_QUANTITIES
    reason = f"is missing: a {probe.quantity} needs the point that it is taken about"
    require(not moment or probe.about is not None, where, "about", reason)
    require(moment or probe.about is None, where, "about", f"needs {' or '.join(ABOUT_QUANTITIES)}")
    if probe.about is not None:
        vector(probe.about, scene.dimension, where, "about")
    check_probed_fluid(probe, scene, where)


def _check_target(probe: Probe, scene: Scene, where: str) -> None:
    """Refuse a probe of something that the scene does not have."""
    filled, supports = [item.name for item in scene.filled], [support.name for support in scene.supports]
    if probe.body is not None:
        hint = f"is {probe.body!r}, which is a support: name it by support, not by body"
        require(probe.body in filled or probe.body not in supports, where, "target", hint)
        named(probe.body, filled, where, "target", "body, wall or fluid")
    if probe.support is not None:
        hint = f"is {probe.support!r}, which is not a support: name it by body"
        require(probe.support in supports or probe.support not in filled, where, "target", hint)
        named(probe.support, supports, where, "target", "support")


def _check_quantity(probe: Probe, scene: Scene, where: str) -> None:
    """Refuse a quantity that its place does not have, and say which places have it."""
    known = probe_quantities(probe, scene)
    reason = f"is {probe.quantity!r}, must be one of: {', '.join(known)}"
    others = [place for place, quantities in PROBE_QUANTITIES.items() if probe.quantity in quantities]
    if others:
        reason += f"; {probe.quantity} is of a {' or a '.join(others)}"
    require(probe.quantity in known, where, "quantity", reason)


def check_measurement(scene: Scene, measurement: Measurement) -> None:
    """Check a measurement.

    Raises:
        InputError: Something is not allowed.
    """
    where = place(measurement, "measurement")
    known = {probe.name: probe for probe in scene.probes}
    named(measurement.probe, list(known), where, "probe", "probe")
    own = PROBE_UNITS[known[measurement.probe].quantity][scene.dimension - 2]
    choice(measurement.unit, ("", *MEASURE_UNITS.get(measurement.measure, (own,))), where, "unit")
    names = component_names(known[measurement.probe].quantity, scene.frame.axes)
    good = 0 <= measurement.component < max(len(names), 1)
    reason = (
        f"must be one of the {len(names)} components of its probe"
        if names
        else "must be 0: its probe has one component"
    )
    require(good, where, "component", reason)
    end = scene.duration if measurement.end is None else measurement.end
    good = 0.0 <= measurement.start < end
    require(good, where, "start", f"is {measurement.start:g} s, must lie before the end, {end:g} s")
    needed = measurement.measure in AT_MEASURES
    require(needed or measurement.at is None, where, "at", f"is only for the measures {' and '.join(AT_MEASURES)}")
    if needed:
        reason = f"is None, must be a number: {measurement.measure} needs it"
        require(measurement.at is not None, where, "at", reason)
    if measurement.measure == "value_at":
        good = measurement.start <= (measurement.at or 0.0) <= end
        reason = f"is {measurement.at:g} s, must lie between {measurement.start:g} and {end:g} s"
        require(good, where, "at", reason)
    harmonic = measurement.measure.startswith("harmonic")
    require(harmonic or measurement.frequency == 0.0, where, "frequency", "is only for the harmonic measures")
    if harmonic:
        positive(measurement.frequency, where, "frequency")


def names_of_bodies(names: Iterable[str], scene: Scene, where: str, attribute: str) -> None:
    """Refuse names that are of no elastic body.

    Raises:
        InputError: There is one.
    """
    known = [body.name for body in scene.bodies]
    for name in names:
        named(name, known, where, attribute, "body")
