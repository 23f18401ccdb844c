"""Shapes: the regions of space that bodies fill and that supports, loads and probes act on.

Shapes are three-dimensional and lie in the scene's coordinates; a two-dimensional scene uses their section at z = 0.
They are united, subtracted and intersected by ``|``, ``-`` and ``&``, and placed by `Shape.moved` and `Shape.turned`.
"""

from warp_mps.shapes.filling import contains, fill, particle_count
from warp_mps.shapes.grid import Fit, Grid, grid_of
from warp_mps.shapes.mesh import Mesh
from warp_mps.shapes.points import Points
from warp_mps.shapes.primitives import Box, Cylinder, Sphere
from warp_mps.shapes.ready_made import check_spacing, median_distance
from warp_mps.shapes.shape import Difference, Intersection, Shape, Union

__all__ = [
    "Box",
    "Cylinder",
    "Difference",
    "Fit",
    "Grid",
    "Intersection",
    "Mesh",
    "Points",
    "Shape",
    "Sphere",
    "Union",
    "check_spacing",
    "contains",
    "fill",
    "grid_of",
    "median_distance",
    "particle_count",
]
