"""A run in VTK's HDF files: one file a body, wall or fluid, with all its frames.

The format is "VTKHDF" of VTK's documentation (Kitware), PolyData with time steps: the values of all frames follow one
another in one dataset, and offsets say where each frame begins. The vertices are the same in every frame.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

import numpy as np

from warp_mps.app.animation_reader import Animation, refuse_existing, refuse_link
from warp_mps.app.convert.pvd import units_of
from warp_mps.app.view.figures import write_file
from warp_mps.errors import InputError

CELLS = ("Vertices", "Lines", "Polygons", "Strips")


def convert_to_vtkhdf(folder: Path, *, overwrite: bool = False) -> int:
    """Write `folder`/vtkhdf/NAME.vtkhdf for each body, wall and fluid of a run.

    Args:
        folder: Folder of the run.
        overwrite: Whether to replace files that are there.

    Raises:
        InputError: There is no run in the folder, the files exist or cannot be written, or there is no h5py.
    """
    if find_spec("h5py") is None:
        raise InputError("--to", "", "vtkhdf needs h5py: pip install warp_mps[vtkhdf], or choose pvd")
    animation = Animation(folder, finite=True)
    refuse_link(folder / "vtkhdf")
    paths = [folder / "vtkhdf" / f"{cloud.name}.vtkhdf" for cloud in animation.clouds]
    for path in paths:
        refuse_existing(path, overwrite)
    for number, path in enumerate(paths):
        write_file(path, partial(_write, animation, number))
    print(f"{len(paths)} files, {len(animation)} frames; open those in {paths[0].parent} in ParaView")
    return 0


def _write(animation: Animation, number: int, path: Path) -> None:
    import h5py

    cloud, frames = animation.clouds[number], len(animation)
    count = len(cloud.ids)
    # HDF5 itself crashes when it cannot write
    with path.open("r+b") as written, keeping_errors(written) as target, h5py.File(target, "w") as file:
        for name, value in {**animation.provenance, "metersPerUnit": animation.meters_per_unit}.items():
            file.attrs[name] = value
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = (2, 1)
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
        root["NumberOfPoints"] = np.array([count])
        for kind in CELLS:
            own = count if kind == "Vertices" else 0
            root[f"{kind}/NumberOfCells"] = np.array([own])
            root[f"{kind}/NumberOfConnectivityIds"] = np.array([own])
            root[f"{kind}/Offsets"] = np.arange(own + 1)
            root[f"{kind}/Connectivity"] = np.arange(own)
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = frames
        steps["Values"] = animation.times
        steps["NumberOfParts"] = np.ones(frames, dtype=np.int64)
        steps["PartOffsets"] = np.zeros(frames, dtype=np.int64)
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            steps[name] = np.zeros((frames, len(CELLS)), dtype=np.int64)
        steps["PointOffsets"] = count * np.arange(frames)
        for name, values in {"id": cloud.ids, "width": cloud.widths}.items():
            root[f"PointData/{name}"] = values
            steps[f"PointDataOffsets/{name}"] = np.zeros(frames, dtype=np.int64)
        for frame in range(frames):
            for name, values in _arrays(animation, number, frame).items():
                if name not in root:
                    width = animation.point_type if name == "Points" else np.float32
                    root.create_dataset(name, (frames * count, *values.shape[1:]), width)
                    if name.startswith("PointData/"):
                        steps[name.replace("PointData", "PointDataOffsets")] = count * np.arange(frames)
                root[name][frame * count : (frame + 1) * count] = values
        for name, unit in units_of(animation).items():
            if name in root["PointData"]:
                root["PointData"][name].attrs["units"] = unit


class _Target(io.RawIOBase):
    """A file to write to, which keeps its first error instead of raising it."""

    def __init__(self, file: IO[bytes]) -> None:
        self.error: OSError | None = None
        self._file = file

    def write(self, data: Any) -> int:
        """Write, unless an earlier write has failed; the number of bytes."""
        try:
            if self.error is None:
                self._file.write(data)
                self._file.flush()
        except OSError as error:
            self.error = error
        return memoryview(data).nbytes

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a position."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """The position."""
        return self._file.tell()

    def readinto(self, buffer: Any) -> int:
        """Read, of what could not be written zeros."""
        data = self._file.read(memoryview(buffer).nbytes).ljust(memoryview(buffer).nbytes, b"\0")
        memoryview(buffer).cast("B")[:] = data
        return len(data)

    def truncate(self, size: int | None = None) -> int:
        """Set the size, unless an earlier write has failed."""
        try:
            return self._file.truncate(size) if self.error is None else size or 0
        except OSError as error:
            self.error = error
            return size or 0


@contextlib.contextmanager
def keeping_errors(file: IO[bytes]) -> Iterator[_Target]:
    """A file for HDF5, whose first error is raised after the body.

    Raises:
        OSError: It could not be written.
    """
    target = _Target(file)
    yield target
    if target.error is not None:
        raise target.error


def _arrays(animation: Animation, number: int, frame: int) -> dict[str, np.ndarray]:
    """Quantities that vary, by the names of the datasets; tensors as rows of nine numbers."""
    values = {"velocity": animation.velocities(number, frame), **animation.quantities(number, frame)}
    flat = {name: array.reshape(len(array), -1) if array.ndim > 2 else array for name, array in values.items()}
    return {
        "Points": animation.points(number, frame),
        **{f"PointData/{name}": array for name, array in flat.items()},
    }
