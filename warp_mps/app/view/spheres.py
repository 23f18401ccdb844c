"""Rendering of spheres: visibility by a depth buffer, and shading.

Every sphere covers a disc of pixels, and each pixel keeps the nearest surface, whatever the order of the spheres.
Lengths are in pixels across the picture and in any one unit along the line of sight.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

NOTHING = -1
# direction to the light, along the picture's right, its top, and towards the viewer
LIGHT = np.array([-0.42, 0.62, 0.66]) / np.linalg.norm([-0.42, 0.62, 0.66])
HALFWAY = (LIGHT + np.eye(3)[2]) / np.linalg.norm(LIGHT + np.eye(3)[2])
AMBIENT, DIFFUSE, GLOSS = 0.55, 0.52, 0.16
# smaller spheres would fall between the pixels
SMALLEST = 0.75
# samples that are held at a time
CHUNK = 2_000_000


@dataclass(frozen=True)
class Spheres:
    """Spheres before a camera.

    Attributes:
        centres: Columns and rows of their centres [px], shape [n, 2].
        depths: Distances of their centres from the camera, shape [n].
        radii: Radii of their discs [px], shape [n].
        bulges: Radii in the unit of the depths, shape [n].
    """

    centres: np.ndarray
    depths: np.ndarray
    radii: np.ndarray
    bulges: np.ndarray


@dataclass(frozen=True)
class Surface:
    """The visible sphere in each pixel.

    Attributes:
        owners: Number of the sphere, `NOTHING` in an empty pixel, shape [height, width].
        depths: Distance of its surface, infinite in an empty pixel, shape [height, width].
    """

    owners: np.ndarray
    depths: np.ndarray

    @property
    def covered(self) -> np.ndarray:
        """Where there is a sphere, shape [height, width]."""
        return self.owners != NOTHING


def nearest(spheres: Spheres, width: int, height: int) -> Surface:
    """The nearest sphere in each pixel of a picture."""
    depths = np.full(width * height, np.inf, dtype=np.float32)
    owners = np.full(width * height, NOTHING, dtype=np.int32)
    for numbers, pixels, distances in _samples(spheres, width, height):
        np.minimum.at(depths, pixels, distances)
        wins = depths[pixels] == distances
        owners[pixels[wins]] = numbers[wins]
    return Surface(owners.reshape(height, width), depths.reshape(height, width))


def shade(spheres: Spheres, surface: Surface, colors: np.ndarray) -> np.ndarray:
    """Colours of the pixels that show a sphere, under a light from the upper left.

    Args:
        spheres: The spheres.
        surface: Where they are seen.
        colors: Their colours, from 0 to 1, shape [n, 3].

    Returns:
        Colours, zero where there is no sphere, shape [height, width, 3].
    """
    rows, columns = np.nonzero(surface.covered)
    owners = surface.owners[rows, columns]
    radii = np.maximum(spheres.radii[owners], SMALLEST)
    normals = np.empty((len(owners), 3), dtype=np.float32)
    normals[:, 0] = (columns + 0.5 - spheres.centres[owners, 0]) / radii
    normals[:, 1] = -(rows + 0.5 - spheres.centres[owners, 1]) / radii
    normals[:, 2] = np.sqrt(np.maximum(1.0 - normals[:, 0] ** 2 - normals[:, 1] ** 2, 0.0))
    lit = np.maximum(normals @ LIGHT.astype(np.float32), 0.0)
    gloss = np.maximum(normals @ HALFWAY.astype(np.float32), 0.0) ** 24
    image = np.zeros((*surface.owners.shape, 3), dtype=np.float32)
    bright = (AMBIENT + DIFFUSE * lit)[:, None] * colors[owners] + (GLOSS * gloss)[:, None]
    image[rows, columns] = np.clip(bright, 0.0, 1.0)
    return image


def ambient_occlusion(depths: np.ndarray, reach: int, unit: float) -> np.ndarray:
    """How much each pixel lies behind its neighbours, as a factor on its light, shape [height, width].

    Edges and gaps darken as in M. Boucheny, *Interactive scientific visualization of large datasets* (2009).

    Args:
        depths: Distances, infinite where there is nothing, shape [height, width].
        reach: Distance of the neighbours that are looked at [px].
        unit: Difference in depth that counts as one.
    """
    behind = np.zeros_like(depths)
    known = np.isfinite(depths)
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)):
        other = np.roll(depths, (down * reach, right * reach), axis=(0, 1))
        behind += np.clip(np.where(known, depths, 0.0) - np.where(known, other, np.inf), 0.0, 2.0 * unit)
    return np.where(known, np.exp(-0.03 * behind / unit), 1.0)


def _samples(spheres: Spheres, width: int, height: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Numbers of spheres, pixels that they cover and depths there, some spheres of about one size at a time."""
    radii = np.maximum(spheres.radii, SMALLEST)
    reaches = np.ceil(radii).astype(int)
    outside = np.any(spheres.centres < -radii[:, None], axis=1)
    outside |= np.any(spheres.centres > np.array([width, height]) + radii[:, None], axis=1)
    for reach in np.unique(reaches[~outside]):
        offsets = np.arange(-reach, reach + 1)
        members = np.nonzero((reaches == reach) & ~outside)[0]
        size = max(1, CHUNK // len(offsets) ** 2)
        for first in range(0, len(members), size):
            numbers = members[first : first + size]
            columns = np.floor(spheres.centres[numbers, 0]).astype(int)[:, None] + offsets
            rows = np.floor(spheres.centres[numbers, 1]).astype(int)[:, None] + offsets
            across = ((columns + 0.5 - spheres.centres[numbers, :1]) / radii[numbers, None]) ** 2
            down = ((rows + 0.5 - spheres.centres[numbers, 1:]) / radii[numbers, None]) ** 2
            # pixels outside the picture belong to no sphere
            across[(columns < 0) | (columns >= width)] = np.inf
            down[(rows < 0) | (rows >= height)] = np.inf
            squares = down[:, :, None] + across[:, None, :]
            which, row, column = np.nonzero(squares < 1.0)
            pixels = rows[which, row] * width + columns[which, column]
            rise = np.sqrt(1.0 - squares[which, row, column])
            found = numbers[which]
            yield found, pixels, (spheres.depths[found] - spheres.bulges[found] * rise).astype(np.float32)
