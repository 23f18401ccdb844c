"""Records of a scene refuse what is wrong in themselves as soon as they are made."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.refusals import assert_refused
from tests.scenes import RUBBER, block
from warp_mps.scene import Body, Fluid, Material, Measurement, Probe, Scene, Support
from warp_mps.shapes import Box

BOX = Box((0.1, 0.1))


@pytest.mark.parametrize(
    ("make", "where", "attribute", "reason"),
    [
        (lambda: Material(density=-1, youngs_modulus=1e6, poissons_ratio=0.3), "material", "density", "above 0"),
        (lambda: Material(1000, "1e6", 0.3), "material", "youngs_modulus", "is '1e6', must be a number"),  # type: ignore[arg-type]
        (lambda: Body(name="b 1", shape=BOX, material=RUBBER, spacing=0.01), "body 'b 1'", "name", "letters, digits"),
        (lambda: Fluid(name="", shape=BOX, spacing=0.01), "fluid ''", "name", "is empty"),
        (lambda: Support(name="a\nb", region=BOX), "support 'a\\nb'", "name", "must be printable"),
        (lambda: Probe(name="=cmd|x", point=(0, 0)), "probe '=cmd|x'", "name", "must not begin with '='"),
        (lambda: Probe(name="a\u2028b", point=(0, 0)), "probe 'a\\u2028b'", "name", "must be printable"),
        (lambda: Probe(name="x" * 201, point=(0, 0), path="/p"), "/p", "name", "has 201 characters, at most 200"),
        (lambda: Measurement(name="@m", measure="maximum", probe="tip"), "measurement '@m'", "name", "with '@'"),
    ],
)
def test_a_record_refuses_its_own_fields(make: Callable[[], object], where: str, attribute: str, reason: str) -> None:
    assert_refused(make, where, attribute, reason)


@pytest.mark.parametrize(
    ("probe", "attribute", "reason"),
    [
        ({"body": "grip", "quantity": "reaction"}, "target", "is 'grip', which is a support: name it by support"),
        ({"support": "block"}, "target", "is 'block', which is not a support: name it by body"),
        ({"body": "ghost"}, "target", "is 'ghost', must name a body, wall or fluid: one of: block"),
        ({"body": "block", "quantity": "reaction"}, "quantity", "reaction is of a support"),
        ({"point": (0.0, 0.0), "name": "tip.x"}, "name", "must not end like the name of a component, 'x'"),
    ],
)
def test_a_probe_of_the_wrong_place_is_told_where(probe: dict[str, object], attribute: str, reason: str) -> None:
    given = {"name": "tip", "path": "/tip", **probe}
    supports = (Support(name="grip", region=Box((0.01, 1.0))),)
    scene = {"bodies": (block(2),), "supports": supports, "duration": 1.0}
    assert_refused(lambda: Scene(probes=(Probe(**given),), **scene), "/tip", attribute, reason)  # type: ignore[arg-type]
