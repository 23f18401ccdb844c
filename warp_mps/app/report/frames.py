"""The frames of a run as the page's player takes them: few enough, in SI units, in whole numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warp_mps.app.animation_reader import Animation, Cloud
from warp_mps.app.report.bounds import axes_of, box_of, seen_of
from warp_mps.app.report.encode import MISSING, Packed, pack, quantize
from warp_mps.app.report.quantities import Range, quantities, range_of, title_of, unit_of
from warp_mps.app.view.colours import owner_of

# by the name of a quantity and the number of a cloud
Table = dict[str, dict[int, np.ndarray]]
# positions, and values to colour by, that a page holds at most, over all frames
MOST_POSITIONS, MOST_VALUES = 2_500_000, 10_000_000
# values up to which they are kept in 16 bits; more of them in 8, without those far off
FINE_VALUES = 2_000_000
# a run is shown for at least this time, if that takes two frames a second or more [s]
SHORTEST = 3.0


@dataclass
class Frames:
    """Data that the player shows.

    Attributes:
        facts: Everything but the packed arrays, ready for JSON; ``{"block": k}`` in it stands for ``blocks[k]``.
        blocks: The packed arrays' texts.
        remarks: Reasons why something is not shown.
    """

    facts: dict[str, Any]
    blocks: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def add(self, packed: Packed) -> dict[str, int]:
        """Take an array in, and return what says where it is."""
        self.blocks.append(packed.text)
        return {"block": len(self.blocks) - 1, "order": packed.order}


def make_frames(animation: Animation) -> Frames:
    """Read and pack the animation of a run."""
    numbers = [number for number, cloud in enumerate(animation.clouds) if len(cloud.ids)]
    moving = sum(len(animation.clouds[number].ids) for number in numbers if _moves(animation, number))
    chosen = _choose_frames(len(animation), moving)
    points = {n: np.stack([animation.points(n, k) for k in chosen]).astype(animation.point_type) for n in numbers}
    axes = axes_of(points, animation.up_axis)
    columns = ["xyz".index(axis) for axis in axes]
    places = {n: animation.meters_per_unit * value[..., columns] for n, value in points.items()}
    low, high = box_of(places)
    seen = seen_of(places, [n for n in numbers if animation.clouds[n].role == "fluid"])
    frames = Frames(
        {
            "axes": axes,
            "dimension": len(axes),
            "up": animation.up_axis,
            "low": low.tolist(),
            "high": high.tolist(),
            "seen": np.clip(seen, low, high).tolist(),
            "times": animation.times[chosen].tolist(),
            "rate": min(animation.playback_rate, max(len(chosen) / SHORTEST, 2.0)),
        }
    )
    if len(chosen) < len(animation):
        frames.remarks.append(f"{len(chosen)} of the {len(animation)} frames of {animation.path.name} are shown.")
    colored = [n for n in numbers if not _is_wall(animation.clouds[n])]
    names = _choose_quantities(frames, animation, colored, len(chosen))
    values = _read_values(animation, colored, chosen, names, axes)
    _add_quantities(frames, values)
    frames.facts["first"] = _first(frames.facts["quantities"], owner_of(animation, "pressure") == "fluid")
    frames.facts["clouds"] = [
        _cloud(frames, animation, n, _pack_places(frames, places[n], low, high), values) for n in numbers
    ]
    return frames


def _moves(animation: Animation, number: int) -> bool:
    """Whether a cloud moves, judged by a sample of the frames."""
    start = animation.points(number, 0)
    return any(not np.array_equal(animation.points(number, frame), start) for frame in animation.sample_frames())


def _is_wall(cloud: Cloud) -> bool:
    return cloud.role == "wall"


def _choose_frames(count: int, particles: int) -> list[int]:
    """Numbers of the frames that are shown, equally far apart, the last one among them."""
    every = max(1, -(-count * particles // MOST_POSITIONS))
    return sorted(range(count - 1, -1, -every))


def _pack_places(frames: Frames, places: np.ndarray, low: np.ndarray, high: np.ndarray) -> dict[str, int]:
    """Pack positions, shape [frames, n, dimension]; one frame if nothing moves."""
    if (places == places[:1]).all():
        places = places[:1]
    size = np.maximum(high - low, 1e-12)
    inside = np.isfinite(places).all(axis=2) & ((places - low >= -1e-6 * size) & (places - high <= 1e-6 * size)).all(2)
    numbers = quantize(places, low, high, MISSING - 1)
    numbers[~inside] = MISSING
    if not inside.all():
        text = "Particles that fly far off are left out of the picture."
        frames.remarks += [text] * (text not in frames.remarks)
    still = {"frames": len(places)}
    # one axis after the other, as neighbours in the file should be alike
    return frames.add(pack(numbers.transpose(0, 2, 1).reshape(len(numbers), -1))) | still


def _choose_quantities(frames: Frames, animation: Animation, numbers: list[int], count: int) -> list[str]:
    """Names of the quantities for which there is room, in `count` frames."""
    sizes: dict[str, int] = {}
    for number in numbers:
        for name in quantities(animation, number, 0, axes=frames.facts["axes"]):
            sizes[name] = sizes.get(name, 0) + count * len(animation.clouds[number].ids)
    kept: list[str] = []
    dropped: list[str] = []
    room = MOST_VALUES
    for name, size in sizes.items():
        room -= size
        (kept if room >= 0 else dropped).append(name)
    if dropped:
        names = ", ".join(title_of(name) for name in dropped)
        frames.remarks.append(f"Left out, as the page would become too large: {names}.")
    return kept


def _read_values(animation: Animation, numbers: list[int], chosen: list[int], names: list[str], axes: str) -> Table:
    """The values of each quantity and cloud, shape [frames, n]."""
    found: Table = {name: {} for name in names}
    for number in numbers:
        rows: dict[str, list[np.ndarray]] = {}
        for frame in chosen:
            values = quantities(animation, number, frame, axes=axes)
            for name in names:
                if name in values:
                    rows.setdefault(name, []).append(values[name]().astype(np.float32))
        for name, items in rows.items():
            if len(items) == len(chosen):
                found[name][number] = np.stack(items)
    return {name: clouds for name, clouds in found.items() if clouds}


def _add_quantities(frames: Frames, values: Table) -> None:
    """Describe the quantities: names, units, ranges and quantization."""
    ranges = {name: range_of(np.concatenate([item.ravel() for item in values[name].values()])) for name in values}
    fine = sum(item.size for clouds in values.values() for item in clouds.values()) <= FINE_VALUES
    frames.facts["quantities"] = [
        {
            "name": name,
            "title": title_of(name),
            "unit": unit_of(name),
            "least": item.least,
            "greatest": item.greatest,
            "shown": item.shown,
            "signed": item.signed,
            # range of the quantized values
            "kept": _quantized_range(item, fine),
            "top": 65535 if fine else 255,
        }
        for name, item in ranges.items()
    ]


def _first(found: list[dict[str, Any]], coupled: bool) -> str:
    """The quantity that is shown first, of fluid and bodies the fluid's; empty if nothing differs."""
    varied = [item["name"] for item in found if item["greatest"] > item["least"]]
    usual = ("pressure", "von_mises") if coupled else ("von_mises", "pressure")
    return next((name for name in (*usual, *varied) if name in varied), "")


def _quantized_range(item: Range, fine: bool) -> tuple[float, float]:
    if fine:
        return item.least, item.greatest
    return max(item.least, item.shown[0]), min(item.greatest, item.shown[1])


def _cloud(
    frames: Frames,
    animation: Animation,
    number: int,
    places: dict[str, int],
    values: Table,
) -> dict[str, Any]:
    cloud = animation.clouds[number]
    scales = {item["name"]: (*item["kept"], item["top"]) for item in frames.facts["quantities"]}
    return {
        "name": cloud.name,
        "role": cloud.role,
        "count": len(cloud.ids),
        "ids": _ids(cloud.ids),
        "width": float(np.median(cloud.widths)) * animation.meters_per_unit,
        "color": cloud.color.tolist(),
        "places": places,
        "values": {
            name: frames.add(pack(quantize(clouds[number], *scales[name])))
            for name, clouds in values.items()
            if number in clouds
        },
    }


def _ids(ids: np.ndarray) -> int | list[int]:
    """Ids, or the first where they count up from it."""
    first = int(ids[0])
    return first if np.array_equal(ids, np.arange(first, first + len(ids))) else [int(value) for value in ids]
