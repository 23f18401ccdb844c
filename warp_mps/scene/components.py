"""Names and places of the components of recorded quantities: scalars, vectors, axial vectors and symmetric tensors."""

from __future__ import annotations

TENSORS = ("stress", "strain")
SCALARS = ("von_mises", "strain_energy", "pressure", "elevation", "kinetic_energy", "volume")
AXIAL = ("rotation", "angular_momentum", "section_moment", "contact_moment")
# rows and columns of the components of a symmetric tensor; in a plane the third axis is its normal
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def tensor_places(dimension: int) -> tuple[tuple[int, int], ...]:
    """Rows and columns of a symmetric tensor that are recorded: in 2-D without shears across the plane, which are 0."""
    return _PLACES[:4] if dimension == 2 else _PLACES


def component_names(quantity: str, axes: str) -> tuple[str, ...]:
    """Names of the components of a quantity along the stage's axes, in the order of their columns.

    Args:
        quantity: A quantity that a probe can record.
        axes: The stage's axes along which the scene's axes lie, such as ``xz``.

    Returns:
        The axes of a vector, pairs of axes of a tensor, and nothing for a scalar.
    """
    if quantity in SCALARS or (quantity in AXIAL and len(axes) == 2):
        return ()
    if quantity not in TENSORS:
        return tuple(axes)
    every = axes if len(axes) == 3 else axes + next(axis for axis in "xyz" if axis not in axes)
    return tuple("".join(sorted(every[row] + every[column])) for row, column in tensor_places(len(axes)))
