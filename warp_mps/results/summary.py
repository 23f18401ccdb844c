"""The summary of a run, run.json: the case, how the run ended, its speed, and its measurements."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from warp_mps.errors import InputError
from warp_mps.results.atomic_write import write_whole
from warp_mps.results.energy import ENERGY_NAMES
from warp_mps.results.formatting import duration, finite, percent
from warp_mps.results.history import History
from warp_mps.results.measures import evaluate, require_history
from warp_mps.results.regular_file import read_regular
from warp_mps.results.summary_check import ABSENT, wrong_item

if TYPE_CHECKING:
    from warp_mps.scene import Measurement, Scene
    from warp_mps.scene.choices import PrecisionName

RunStatus = Literal["running", "done", "failed"]
STATUSES: tuple[RunStatus, ...] = get_args(RunStatus)


@dataclass(kw_only=True)
class RunSummary:
    """Contents of run.json.

    Attributes:
        case: Name of the case.
        status: One of `STATUSES`.
        reason: Why the run failed, else empty.
        device: Device that it ran on.
        precision: ``float64`` or ``float32``.
        versions: Versions of the program and of what it stands on, by name.
        dimension: 2 or 3.
        particles: Number of particles of each body.
        settings: The case's settings; see :func:`warp_mps.results.settings.scene_settings`.
        steps: Steps done.
        time: Simulated time [s].
        wall_seconds: Wall time of the steps [s], with that of the runs that it continues, up to their checkpoints.
        particle_steps_per_second: Speed over that time [1/s], under ``solid`` and ``fluid``.
        energy: Energies at the end, the ``unaccounted`` loss, and ``drift``, None with fluids; see
            :func:`energy_record`.
        momentum_error: Largest resultant of the internal forces in a frame, as a part of the largest sum of their
            magnitudes [-].
        fluid: Of fluids, particles `lost` from the domain and those that are `outside` their tank at the end, with no
            wall and no body below them, iterations and largest true residual of the pressure solves, and how many
            stayed `unsolved`.
        implicit: Of a static analysis and of implicit steps, statistics of the solvers: `equilibria` solved,
            Newton iterations, iterations of the linear solver, renewals of its coarse level, largest residual
            relative to the forces.
        coupling: Of water and bodies together: mean and largest number of fixed-point `passes` of a step, steps
            that stayed `unconverged`, the largest residual of a step, and the work of the water on the bodies [J].
        measurements: Results; see :func:`measurement_rows`.
        remarks: What should be known before the numbers are believed: of the case, and of the run at its end.
    """

    case: str
    status: RunStatus = "running"
    reason: str = ""
    device: str = "cpu"
    precision: PrecisionName = "float64"
    versions: dict[str, str] = field(default_factory=dict)
    dimension: int = 2
    particles: dict[str, int] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    steps: int = 0
    time: float = 0.0
    wall_seconds: float = 0.0
    particle_steps_per_second: dict[str, float | None] = field(default_factory=dict)
    energy: dict[str, float | None] = field(default_factory=dict)
    momentum_error: float | None = None
    fluid: dict[str, float] = field(default_factory=dict)
    implicit: dict[str, float] = field(default_factory=dict)
    coupling: dict[str, float] = field(default_factory=dict)
    measurements: list[dict[str, Any]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        """A few lines: simulated time, speed, energies at the end, and measurements."""
        return outline(self)

    def write(self, path: str | Path) -> None:
        """Write run.json in one atomic step; NaN and infinity become null."""
        text = json.dumps(finite(dataclasses.asdict(self)), indent=2, allow_nan=False)
        write_whole(path, text + "\n")


def read_summary(path: str | Path) -> RunSummary:
    """Read run.json; unknown keys are ignored.

    Raises:
        InputError: The file is missing or is not the summary of a run, or an item of it is of a wrong type.
    """
    try:
        data = json.loads(read_regular(path))
    except OSError as error:
        raise InputError(str(path), "", f"cannot be read: {error.strerror}") from error
    # brackets too deep for the parser
    except (ValueError, RecursionError) as error:
        raise InputError(str(path), "", f"is not valid JSON: {error}") from error
    if not isinstance(data, dict) or "case" not in data or data.get("status") not in list(STATUSES):
        raise InputError(str(path), "", "is not the summary of a run: a case and a status are missing")
    wrong = wrong_item(data)
    if wrong is not None:
        raise InputError(str(path), "", f"is not the summary of a run: {wrong}")
    for name in ("fluid", "implicit", "coupling"):
        # a statistic that is not finite is null
        data[name] = {key: value for key, value in data.get(name, {}).items() if value is not None}
    data["measurements"] = [{**ABSENT, **row} for row in data.get("measurements", [])]
    known = {item.name for item in dataclasses.fields(RunSummary)}
    return RunSummary(**{name: value for name, value in data.items() if name in known})


def energy_record(history: History, *, fluids: bool = False) -> dict[str, float | None]:
    """Energies at the end of a history and their relative drift.

    What was ``dissipated`` is as in probes.csv, and ``unaccounted`` is what the energy balance
    (:class:`warp_mps.results.energy.Energy`) has lost since the start beside it, that nothing counts: held - work +
    dissipated + unaccounted stays what it was. The drift is the largest change of the balance, divided by the largest
    of the energy that motion and deformation held and of the work put in. Fluids lose energy by viscosity, impacts and
    collisions, all unaccounted, so that their runs have no drift.

    Args:
        history: The energies.
        fluids: Whether they are those of fluids.
    """
    energies = history.energies()
    if not energies:
        return {}
    record: dict[str, float | None] = {name: getattr(energies[-1], name) for name in ENERGY_NAMES}
    record["unaccounted"] = energies[0].balance - energies[-1].balance
    if fluids:
        record["drift"] = None
        return record
    scale = max(max(energy.exchanged, abs(energy.work)) for energy in energies)
    drift = max(abs(energy.balance - energies[0].balance) for energy in energies)
    record["drift"] = drift / scale if scale > 0.0 else 0.0
    return record


def measurement_rows(scene: Scene, history: History) -> list[dict[str, Any]]:
    """Evaluate all measurements of a scene.

    Returns:
        A row for each: ``name, value, unit, reference, error, source``, and how it was drawn: the ``measure``, the
        ``column`` of probes.csv, the ``window`` of time [s], whose end may be None, and ``at``. The error is
        (value - reference)/|reference|, None without a reference or where it is 0. A value that cannot be drawn is
        None, and ``reason`` then says why: a run that ended early is not compared with a reference for a later time.
    """
    return [_row(measurement, history, scene.duration) for measurement in scene.measurements]


def _row(measurement: Measurement, history: History, duration: float) -> dict[str, Any]:
    row: dict[str, Any] = {
        "name": measurement.name,
        "value": None,
        "unit": measurement.unit,
        "reference": measurement.reference,
        "error": None,
        "source": measurement.source,
        "measure": measurement.measure,
        "column": None,
        "window": [measurement.start, measurement.end],
        "at": measurement.at,
    }
    try:
        row["column"] = history.label(measurement.probe, measurement.component)
        values = history.probe(measurement.probe, measurement.component)
        require_history(measurement, duration, history.last_time)
        row["value"] = evaluate(measurement, history.times, values)
    except (ValueError, KeyError) as error:
        row["reason"] = str(error.args[0])
        return row
    if measurement.reference:
        row["error"] = (row["value"] - measurement.reference) / abs(measurement.reference)
    return row


def outline(summary: RunSummary) -> str:
    """Headline of a run, its energies at the end, and its measurements, a line each."""
    unit = "J/m" if summary.dimension == 2 else "J"
    reason = f" ({summary.reason})" if summary.reason else ""
    energies = {name: value for name, value in summary.energy.items() if value and name != "drift"}
    shown = ", ".join(f"{name} {value:.4g}" for name, value in energies.items())
    return "\n".join(
        [
            f"{headline(summary)}; {summary.status}{reason}",
            "particles: " + ", ".join(f"{name} {count}" for name, count in summary.particles.items()),
            *([f"energy [{unit}]: {shown}"] if shown else []),
            *(f"{row['name']}: {_measured(row)}" for row in summary.measurements),
        ]
    )


def _measured(row: dict[str, Any]) -> str:
    if row["value"] is None:
        return str(row.get("reason", "none"))
    text = f"{row['value']:.5g} {row['unit']}".rstrip()
    if row["reference"] is None:
        return text
    error = f", {percent(row['error'])}" if row["error"] is not None else ""
    return f"{text} (reference {row['reference']:.5g}{error})"


def headline(summary: RunSummary) -> str:
    """One line: steps, simulated time, speed and accuracy of a run."""
    speed = sum(value or 0.0 for value in summary.particle_steps_per_second.values())
    return (
        f"{summary.case}: {summary.steps} steps, {summary.time:.6g} s simulated in {duration(summary.wall_seconds)} "
        f"({speed / 1e6:.3g} million particle-steps a second), {_account(summary)}"
    )


def _account(summary: RunSummary) -> str:
    """Accuracy of a run: its energy drift, or with fluids, which dissipate, statistics of the pressure solves."""
    if not summary.fluid:
        return f"energy drift {percent(summary.energy.get('drift'))}"
    lost, outside, unsolved = (int(summary.fluid.get(name, 0)) for name in ("lost", "outside", "unsolved"))
    text = f"{summary.fluid.get('pressure_iterations', 0.0):.3g} iterations a pressure solve"
    text += f", {unsolved} UNSOLVED" if unsolved else ""
    if summary.coupling:
        unconverged = int(summary.coupling.get("unconverged", 0))
        text += f", {summary.coupling.get('passes', 0.0):.3g} passes a step between water and bodies"
        text += f", {unconverged} steps UNCONVERGED" if unconverged else ""
    text += f", {outside} particles outside the tank" if outside else ""
    return text + (f", {lost} particles lost" if lost else "")
