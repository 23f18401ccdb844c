"""Style of the figures, and writing them to files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl

from warp_mps.errors import InputError
from warp_mps.results.atomic_write import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK, FAINT = "#24292f", "#d8dee4"
# distinguishable without colour vision (Okabe and Ito), the darkest first
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": "#8c959f",
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-3, 4),
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "svg.hashsalt": "warp-mps",
}


@contextmanager
def style() -> Iterator[None]:
    """Context with the style of the figures."""
    with mpl.rc_context(STYLE):
        yield


def require_format(path: Path, formats: Sequence[str]) -> None:
    """Refuse a file name with an unsupported suffix.

    Raises:
        InputError: The name ends otherwise.
    """
    if path.suffix.lower().lstrip(".") not in formats:
        raise InputError(str(path), "", f"must end in {' or '.join(f'.{name}' for name in formats)}")


def save(figure: Figure, path: Path) -> None:
    """Write a figure in one step, in a folder that is made if need be.

    Raises:
        InputError: It cannot be written.
    """
    write_file(path, lambda temporary: figure.savefig(temporary, format=path.suffix[1:].lower()))


def write_file(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file in one step, in a folder that is made if need be.

    Args:
        path: The file.
        write: Writes to the path that it is given, which lies in the same folder and ends likewise.

    Raises:
        InputError: It cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            write(temporary)
    except OSError as error:
        raise InputError(str(path), "", f"cannot be written: {error.strerror}") from error
