"""The page's tables: status, measurements, energy and momentum balances, and settings, as HTML."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from warp_mps.app.report.run_data import Run
from warp_mps.results.energy import ENERGY_NAMES
from warp_mps.results.formatting import duration, percent

STATES = {
    "done": "finished",
    "running": "running",
    "failed": "failed",
    "stopped": "stopped without an error message, for example because its process was killed",
}
RECORDS = {
    "lost": "particles that left the domain",
    "outside": "particles outside the tank at the end",
    "pressure_iterations": "iterations of a pressure solve, mean",
    "most_pressure_iterations": "iterations of a pressure solve, most",
    "worst_pressure_residual": "relative residual of a pressure solve, worst",
    "unsolved": "solves that failed",
}


def state_text(run: Run) -> str:
    """How the run is doing, or how it ended and why."""
    reason = run.summary.reason
    if reason.startswith("interrupted"):
        return reason
    return f"{STATES[run.state]}: {reason}" if reason else STATES[run.state]


def number(value: Any, digits: int = 5) -> str:
    """A number as text; a dash for None or NaN."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "-"
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def cards(run: Run) -> str:
    """The run at a glance."""
    summary = run.summary
    clouds = run.animation.clouds if run.animation else ()
    particles = summary.particles or {cloud.name: len(cloud.ids) for cloud in clouds}
    static = is_static(run)
    found = [("load factor" if static else "simulated", f"{summary.time:.5g}{'' if static else ' s'}")]
    found.append(("particles", f"{sum(particles.values()):,}".replace(",", "\u202f")))
    if summary.dimension and particles:
        found.append(("dimension", f"{summary.dimension}-D"))
    if summary.steps:
        found.append(("steps", f"{summary.steps:,}".replace(",", "\u202f")))
    if summary.wall_seconds:
        found.append(("wall time", duration(summary.wall_seconds)))
    speed = sum(value or 0.0 for value in summary.particle_steps_per_second.values())
    if speed:
        found.append(("particle-steps a second", f"{speed / 1e6:.3g} million"))
    if summary.energy.get("drift") is not None:
        found.append(("energy drift", percent(summary.energy["drift"])))
    errors = [row["error"] for row in summary.measurements if row.get("error") is not None]
    if errors:
        found.append(("largest error", percent(max(errors, key=abs))))
    return "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(text)}</dd></div>" for name, text in found)


def measurements(run: Run) -> str:
    """The measurements, with references and their sources."""
    rows = run.summary.measurements
    if not rows:
        when = "They are made at the end of the run." if run.state == "running" else "None were made."
        return f'<p class="quiet">{when}</p>'
    body = []
    for row in rows:
        unit, value, expected = row.get("unit") or "", row.get("value"), row.get("reference")
        measured = row.get("reason") or "none" if value is None else _valued(value, unit)
        reference = "-" if expected is None else _valued(expected, unit)
        error = percent(row.get("error")) or "-"
        cells = [
            (row.get("name"), ""),
            (measured, "quiet" if value is None else "n"),
            (reference, "n"),
            (error, "n"),
            (row.get("source") or "-", ""),
        ]
        body.append([*cells, (_how(row), "quiet")])
    heads = [("result", ""), ("measured", "n"), ("reference", "n"), ("error", "n"), ("source of the reference", "")]
    note = '<p class="quiet">An error is (measured - reference) over the magnitude of the reference.</p>'
    return _table([*heads, ("how it is measured", "")], body) + note


def measured_text(row: Mapping[str, Any]) -> str:
    """One line on a measurement and its reference."""
    unit, reference = row.get("unit") or "", row.get("reference")
    text = f"{row.get('name')}: " + ("none" if row.get("value") is None else _valued(row["value"], unit))
    text += "" if reference is None else f", reference {_valued(reference, unit)}"
    return text + ("" if row.get("error") is None else f" ({percent(row['error'])})")


def _valued(value: float, unit: str) -> str:
    return f"{number(float(value))} {unit}".strip() if unit != "-" else number(float(value))


def _how(row: Mapping[str, Any]) -> str:
    """The measure, the column and the window of a measurement."""
    if not row.get("column"):
        return ""
    measure, column = str(row.get("measure") or ""), row["column"]
    at = {
        "value_at": f"{column} at {number(row.get('at'))} s",
        "time_at": f"time at which {column} passes {number(row.get('at'))}",
    }
    text = at.get(measure) or f"{measure.replace('_', ' ')} of {column}"
    start, end = row.get("window") or (0.0, None)
    if start or end is not None:
        text += f", from {number(float(start or 0.0))} s" + (f" to {number(float(end))} s" if end is not None else "")
    return text


def accounts(run: Run) -> str:
    """Energies at the end and what became of them, the momentum, and what the solvers did."""
    summary, unit = run.summary, "J/m" if run.summary.dimension == 2 else "J"
    rows = [
        (words, number(summary.energy.get(name)), unit)
        for name, words in ENERGY_NAMES.items()
        if summary.energy.get(name)
    ]
    drift, lost = summary.energy.get("drift"), summary.energy.get("unaccounted")
    if drift is None and lost:
        rows.append(("unaccounted: lost by impacts, collisions and viscosity of the fluid", number(lost), unit))
    if drift is not None:
        rows.append(("change of the energy balance, largest, over the largest energy or work", percent(drift), ""))
    if summary.momentum_error is not None:
        text = "resultant of the internal forces, largest, over the sum of their magnitudes"
        rows.append((text, number(summary.momentum_error, 2), ""))
    for record in (summary.fluid, summary.implicit):
        words = {name: RECORDS.get(name, name.replace("_", " ")) for name in record}
        rows += [(words[name], number(value, 3), "") for name, value in record.items()]
    if not rows:
        return '<p class="quiet">None are there yet.</p>'
    body = [[(name, ""), (value, "n"), (text, "")] for name, value, text in rows]
    moment = "at the end" if run.state == "done" else "at the last row"
    return _table([(f"energies {moment}, momentum, solvers", ""), ("", "n"), ("", "")], body)


def settings(run: Run) -> str:
    """The case's settings, part by part, and what computed it."""
    found = {name: value for name, value in run.summary.settings.items() if name != "description"}
    scene = {name: value for name, value in found.items() if not isinstance(value, Mapping)}
    parts = {name: value for name, value in found.items() if isinstance(value, Mapping)}
    blocks = [_block("case", _flat(scene))] if scene else []
    for group, value in parts.items():
        named = all(isinstance(item, Mapping) for item in value.values())
        entries = (
            {f"{_words(group)}: {name}": item for name, item in value.items()} if named else {_words(group): value}
        )
        blocks += [_block(name, _flat(item)) for name, item in entries.items()]
    computed = {
        "device": run.summary.device,
        "precision": run.summary.precision,
        **run.summary.versions,
        **(run.animation.provenance if run.animation else {}),
    }
    return "".join([*blocks, _block("computed with", _flat({k: v for k, v in computed.items() if v != ""}))])


def is_static(run: Run) -> bool:
    """Whether the times are load factors."""
    noted = run.animation.provenance if run.animation else {}
    return "static" in (run.summary.settings.get("analysis"), noted.get("analysis"))


def _flat(values: Mapping[str, Any], before: str = "") -> list[tuple[str, str]]:
    """Names and texts of nested settings."""
    rows = []
    for name, value in values.items():
        label = f"{before}{_words(name)}"
        if isinstance(value, Mapping):
            rows += _flat(value, f"{label}, ")
        else:
            rows.append((label, _text(value)))
    return rows


def _text(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_text(item) if not isinstance(item, list) else f"({_text(item)})" for item in value)
    return number(value, 6) if not isinstance(value, str) else value.replace("_", " ")


def _words(name: str) -> str:
    return name.replace("_", " ")


def _block(title: str, rows: Iterable[tuple[str, str]]) -> str:
    lines = "".join(f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in rows)
    return f'<div class="block"><h3>{escape(title)}</h3><table>{lines}</table></div>'


def _table(heads: Sequence[tuple[str, str]], rows: Iterable[Sequence[tuple[Any, str]]]) -> str:
    """A table of texts, each with its class: ``n`` for numbers."""

    def line(cells: Sequence[tuple[Any, str]], tag: str) -> str:
        return "".join(f'<{tag} class="{kind}">{escape(str(text))}</{tag}>' for text, kind in cells)

    body = "".join(f"<tr>{line(cells, 'td')}</tr>" for cells in rows)
    return f'<div class="wide"><table><thead><tr>{line(heads, "th")}</tr></thead><tbody>{body}</tbody></table></div>'
