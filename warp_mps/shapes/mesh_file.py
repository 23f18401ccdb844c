"""Closed surfaces of triangles in STL, OBJ and PLY files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from warp_mps.errors import InputError
from warp_mps.shapes.closed_surface import open_edge, same_places
from warp_mps.shapes.numbers import is_number, shown

KINDS = (".stl", ".obj", ".ply")
# a mesh is flat if its smallest principal extent is below this share of the largest
FLAT = 1e-9


def read_mesh(path: Path, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """Read a closed surface.

    Args:
        path: An STL, OBJ or PLY file.
        scale: Metres per unit of the file.

    Returns:
        Vertices [m], shape [n, 3], and the vertices of each triangle, shape [m, 3].

    Raises:
        InputError: trimesh is not installed, the file cannot be read, or the surface is not closed.
    """
    where = str(path)
    if path.suffix.lower() not in KINDS:
        raise InputError(where, "", f"is not a mesh file that can be read: its name must end in {', '.join(KINDS)}")
    if not (is_number(scale) and 0.0 < scale < np.inf):
        raise InputError(where, "scale", f"must be finite and above 0, not {shown(scale)}")
    if not path.is_file():
        raise InputError(where, "", "there is no such file")
    try:
        import trimesh
    except ImportError:
        reason = "needs trimesh to be read: pip install 'warp_mps[mesh]'"
        raise InputError(where, "", reason) from None
    try:
        # merges the corners that triangles share, which STL repeats for each
        mesh: Any = trimesh.load(path, force="mesh")
        points, triangles = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64)
    except Exception as error:  # the parsers of trimesh raise exceptions of any kind
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(where, "", f"cannot be read as {path.suffix[1:].upper()}: {reason[:200]}") from None
    if not len(triangles) or not np.isfinite(points).all():
        raise InputError(
            where, "", "holds no triangles" if not len(triangles) else "holds vertices that are not finite"
        )
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[-1] <= FLAT * extents[0]:
        raise InputError(where, "", "encloses no volume: all its vertices lie in a plane")
    source, places = same_places(points)
    hole = open_edge(places[triangles], scale * points[source])
    if hole:
        reason = f"the mesh is not closed: every edge must belong to exactly two triangles, {hole}"
        raise InputError(where, "", f"{reason}; close the hole in the program that made the file")
    return scale * points, triangles
