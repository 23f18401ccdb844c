"""Points as VTK's XML files: what ParaView, VisIt and VTK itself open.

The format is that of "VTK XML Formats" in The VTK User's Guide (Kitware): a ``.vtp`` holds the points of one moment as
PolyData, one vertex a point, and at its end each array as base64 text of its length in bytes and its values; a ``.pvd``
lists which files belong to which time.
"""

from __future__ import annotations

import base64
import sys
from collections.abc import Iterable, Mapping
from xml.sax.saxutils import quoteattr

import numpy as np

_TYPES = {"f4": "Float32", "f8": "Float64", "i4": "Int32", "i8": "Int64"}
_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"


def polydata(
    points: np.ndarray,
    arrays: Mapping[str, np.ndarray],
    *,
    units: Mapping[str, str],
    facts: Mapping[str, str | float],
) -> str:
    """The text of a ``.vtp`` file.

    Args:
        points: Positions, shape [n, 3].
        arrays: Values at the points by name, shape [n], [n, 3] or [n, 3, 3].
        units: Units of some of the arrays, which ParaView shows.
        facts: Field data of the whole file; ``TimeValue`` is the time [s].
    """
    count = len(points)
    vertices = np.arange(count, dtype=np.int32)
    data = _Appended()
    lines = [
        '<?xml version="1.0"?>',
        f'<VTKFile type="PolyData" version="1.0" byte_order="{_ORDER}" header_type="UInt64">',
        "<PolyData>",
        "<FieldData>",
        *(_fact(name, value) for name, value in facts.items()),
        "</FieldData>",
        f'<Piece NumberOfPoints="{count}" NumberOfVerts="{count}" NumberOfLines="0" NumberOfStrips="0"'
        ' NumberOfPolys="0">',
        "<PointData>",
        *(data.add(name, values, units.get(name, "")) for name, values in arrays.items()),
        "</PointData>",
        "<Points>",
        data.add("Points", points),
        "</Points>",
        "<Verts>",
        data.add("connectivity", vertices),
        data.add("offsets", vertices + np.int32(1)),
        "</Verts>",
        "</Piece>",
        "</PolyData>",
        f'<AppendedData encoding="base64">\n_{data.text()}\n</AppendedData>',
        "</VTKFile>",
    ]
    return "\n".join(lines) + "\n"


def collection(files: Iterable[tuple[float, str, str]]) -> str:
    """The text of a ``.pvd`` file.

    Args:
        files: Time [s], name of the body and name of the file, of every ``.vtp``.
    """
    entries, parts = [], dict[str, int]()
    for time, name, file in files:
        part = parts.setdefault(name, len(parts))
        entries.append(
            f'<DataSet timestep="{time!r}" group="" part="{part}" name={quoteattr(name)} file={quoteattr(file)}/>'
        )
    head = ['<?xml version="1.0"?>', f'<VTKFile type="Collection" version="0.1" byte_order="{_ORDER}">']
    return "\n".join([*head, "<Collection>", *entries, "</Collection>", "</VTKFile>"]) + "\n"


class _Appended:
    """The arrays of a file, which follow one another at its end."""

    def __init__(self) -> None:
        self._blocks: list[str] = []
        self._length = 0

    def add(self, name: str, values: np.ndarray, unit: str = "") -> str:
        """Take an array in, and return the element that says what and where it is."""
        values = np.ascontiguousarray(values)
        length = np.array([values.nbytes], dtype=np.uint64).tobytes()
        offset = self._length
        self._blocks.append(base64.b64encode(length + values.tobytes()).decode("ascii"))
        self._length += len(self._blocks[-1])
        # the key under which VTK keeps the unit of an array
        key = f'<InformationKey name="UNITS_LABEL" location="vtkDataArray">{unit}</InformationKey>' if unit else ""
        components = int(np.prod(values.shape[1:], dtype=int))
        return (
            f'<DataArray type="{_TYPES[values.dtype.str[1:]]}" Name={quoteattr(name)} '
            f'NumberOfComponents="{components}" format="appended" offset="{offset}">{key}</DataArray>'
        )

    def text(self) -> str:
        """All arrays."""
        return "".join(self._blocks)


def _fact(name: str, value: str | float) -> str:
    if isinstance(value, str):
        # a text is the codes of its bytes, up to a zero
        codes = " ".join(str(code) for code in [*value.encode("utf-8"), 0])
        return f'<Array type="String" Name={quoteattr(name)} NumberOfTuples="1" format="ascii">\n{codes}\n</Array>'
    return (
        f'<DataArray type="Float64" Name={quoteattr(name)} NumberOfTuples="1" format="ascii">\n'
        f"{float(value)!r}\n</DataArray>"
    )
