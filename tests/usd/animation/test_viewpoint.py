"""Directions of view."""

from __future__ import annotations

import numpy as np
import pytest

from warp_mps.usd.animation.viewpoint import plane_axes, space_axes


@pytest.mark.parametrize("normal", [0, 1, 2])
@pytest.mark.parametrize("up", [1, 2])
def test_planes_are_seen_upright_and_not_mirrored(normal: int, up: int) -> None:
    axes = plane_axes(normal, up)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert abs(axes[2, normal]) == 1.0
    assert normal == up or axes[1, up] == 1.0


@pytest.mark.parametrize("view", [None, (0.5, 0.4, 1.0), (0.0, 0.0, -2.0), (0.0, 3.0, 0.0)])
@pytest.mark.parametrize("up", [1, 2])
def test_space_is_seen_upright_and_not_mirrored(view: tuple[float, float, float] | None, up: int) -> None:
    axes = space_axes(up, None if view is None else np.array(view))
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[1, up] >= 0.0
    if view is None:
        assert axes[2, up] == pytest.approx(0.38 / np.linalg.norm([0.5, 0.38, 1.0]))
