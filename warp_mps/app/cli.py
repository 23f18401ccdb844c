"""The commands of ``warp-mps`` and their exit codes.

0: done. 2: the input is wrong. 3: the run failed. 130: interrupted by Ctrl-C. 129, 143: ended by SIGHUP, SIGTERM.
"""

from __future__ import annotations

import errno
import functools
import importlib
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from tyro.conf import Positional, UseAppendAction, arg

from warp_mps.app import address_space, result_commands
from warp_mps.app.arguments import parse
from warp_mps.core.interrupts import first_interrupt_only, raise_when_killed
from warp_mps.core.streams import patient_streams, say
from warp_mps.errors import InputError, RunError
from warp_mps.version import __version__

# as in `warp_mps.scene.choices`, whose package imports NumPy, which --help need not wait for; a test compares them
PrecisionName = Literal["float64", "float32"]
ElasticModelName = Literal["hamiltonian", "springs"]
PRECISIONS: tuple[PrecisionName, ...] = get_args(PrecisionName)
ELASTIC_MODELS: tuple[ElasticModelName, ...] = get_args(ElasticModelName)
SUBJECTS: tuple[Literal["elastic", "fluids", "coupling"], ...] = ("elastic", "fluids", "coupling")
Case = Annotated[str, arg(metavar="CASE", help="Path of a stage, or the name of a shipped case (see list).")]
Device = Annotated[str, arg(metavar="DEVICE", help="cpu, or a CUDA device such as cuda:0.")]
Precision = Annotated[PrecisionName, arg(help="Number type: float64 to trust, float32 for GPU speed.")]
Threads = Annotated[int, arg(metavar="T", help="CPU threads that share the particles; helps from some thousands on.")]
Duration = Annotated[float | None, arg(metavar="S", help="Simulated time [s], instead of the stage's.")]
Changes = UseAppendAction[
    Annotated[
        tuple[str, ...],
        arg(name="set", metavar="/PRIM.ATTR=VALUE", help="Change an attribute of the stage, in its units; repeatable."),
    ]
]
External = Annotated[bool, arg(help="Let the stage refer to files outside its folder.")]


def list_cases() -> int:
    """List the shipped cases, with a line on each."""
    from warp_mps.app.printing import print_cases

    return print_cases()


def check(
    case: Positional[Case],
    *,
    json: Annotated[bool, arg(help="Print the check as JSON.")] = False,
    duration: Duration = None,
    changes: Changes = (),
    allow_external: External = False,
) -> int:
    """Read a case and print what it is and what a run would cost: sizes, masses, time step, memory. Runs nothing."""
    from warp_mps.app.check_printing import print_check

    return print_check(_read(case, changes, duration, allow_external=allow_external), as_json=json)


def run(
    case: Positional[Case],
    *,
    out: Annotated[Path | None, arg(metavar="DIR", help="Folder of the results; default: runs/CASE.")] = None,
    device: Device = "cpu",
    precision: Precision = "float64",
    threads: Threads = 1,
    duration: Duration = None,
    overwrite: Annotated[bool, arg(help="Replace results that the folder holds.")] = False,
    resume: Annotated[bool, arg(help="Continue from the folder's checkpoint.")] = False,
    checkpoint_interval: Annotated[float, arg(metavar="S", help="Wall seconds between two checkpoints.")] = 60.0,
    quiet: Annotated[bool, arg(help="Show no progress.")] = False,
    changes: Changes = (),
    allow_external: External = False,
) -> int:
    """Run a case: leaves run.usdc (animation), probes.csv, run.json (summary) and checkpoint.npz in a folder."""
    from warp_mps.app.printing import print_summary
    from warp_mps.run.run import run_scene

    scene = _read(case, changes, duration, allow_external=allow_external)
    folder = out or Path("runs") / scene.name
    start = functools.partial(run_scene, scene, folder, device=device, precision=precision, threads=threads)
    try:
        summary = start(overwrite=overwrite, resume=resume, checkpoint_interval=checkpoint_interval, quiet=quiet)
    except KeyboardInterrupt as interrupt:
        if (folder / "checkpoint.npz").exists():
            how = "the results so far are kept, continue with --resume"
            return _fail(f"{_cause(interrupt)}; {how}", _code(interrupt))
        raise
    print_summary(summary, folder)
    return 0


def validate(
    cases: Positional[Annotated[tuple[str, ...], arg(metavar="CASE", help="Cases; all shipped ones if none.")]] = (),
    *,
    out: Annotated[Path | None, arg(metavar="DIR", help="Keep the results here; default: a temporary folder.")] = None,
    device: Device = "cpu",
    precision: Precision = "float64",
    allow_external: External = False,
) -> int:
    """Run cases and print each measurement beside its reference: measured, reference, error, source."""
    from warp_mps.app.validate import validate_cases

    return validate_cases(cases, out=out, device=device, precision=precision, allow_external=allow_external)


def bench(
    sizes: Annotated[
        tuple[int, ...],
        arg(metavar="N", help="Numbers of particles; by default 1e3 to 1e6, of fluids 1e3 to 1e5, in 3-D 3e4."),
    ] = (),
    *,
    of: Annotated[tuple[Literal["elastic", "fluids", "coupling"], ...], arg(help="Benchmarks to run.")] = SUBJECTS,
    device: Device = "cpu",
    models: Annotated[tuple[ElasticModelName, ...], arg(help="Elastic models.")] = ELASTIC_MODELS,
    dimensions: Annotated[tuple[Literal[2, 3], ...], arg(help="Dimensions.")] = (2, 3),
    precisions: Annotated[tuple[PrecisionName, ...], arg(help="Number types.")] = PRECISIONS,
    threads: Threads = 1,
) -> int:
    """Measure the speed of an elastic block, of a dam break, and of water on a plate, with shares. Takes minutes."""
    from warp_mps.app.bench.coupling import bench_coupling
    from warp_mps.app.bench.fluids import bench_fluids
    from warp_mps.app.bench.solids import bench_solid

    if min(sizes, default=1) < 1:
        raise InputError("--sizes", "", f"is {sizes}, must be whole numbers from 1 on")
    if "elastic" in of:
        bench_solid(sizes, models=models, dimensions=dimensions, precisions=precisions, device=device, threads=threads)
    if "fluids" in of:
        bench_fluids(sizes, dimensions=dimensions, precisions=precisions, device=device)
    if "coupling" in of:
        bench_coupling(sizes, dimensions=dimensions, precisions=precisions, device=device)
    return 0


# commands whose result is in files, not on standard output
LEAVE_FILES = {"run", "convert", "plot", "picture", "video", "report"}
COMMANDS: dict[str, Callable[..., int]] = {
    "list": list_cases,
    "check": check,
    "run": run,
    "validate": validate,
    "bench": bench,
    "convert": result_commands.convert,
    "plot": result_commands.plot,
    "picture": result_commands.picture,
    "video": result_commands.video,
    "report": result_commands.report,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    # a batch system ends a job by SIGTERM, a terminal by SIGHUP: treat them as Ctrl-C, so that all results are kept
    with patient_streams() as (output, _):
        try:
            with raise_when_killed(again=False):
                code = _end(arguments)
        except KeyboardInterrupt as interrupt:
            code = _fail(_cause(interrupt), _code(interrupt))
        output.flush()
        # a reader that has gone, such as head, wants no more
        if output.failure is None or isinstance(output.failure, BrokenPipeError):
            return code
        say(f"standard output cannot be written: {getattr(output.failure, 'strerror', output.failure)}")
        return code if code or set(arguments[:1]) & LEAVE_FILES else 3


def _end(arguments: list[str]) -> int:
    """Run a command, and say in one line how it ended if it ended badly."""
    try:
        # a second Ctrl-C must not interrupt the saving that the first one started
        with first_interrupt_only():
            if arguments == ["--version"]:
                print(f"warp-mps {__version__}")
                return 0
            command = parse(COMMANDS, arguments)
            if reason := address_space.too_small():
                return _fail(reason, 2)
            # before any module imports USD by itself, where a signal would be lost
            importlib.import_module("warp_mps.usd")
            return command()
    except SystemExit as help_was_shown:
        return int(help_was_shown.code or 0)
    except (InputError, RunError, MemoryError, OSError) as error:
        return _fail(*_reason(error))


def _reason(error: Exception) -> tuple[str, int]:
    """A line on an error, and the exit code."""
    if isinstance(error, InputError):
        from warp_mps.usd.case.stage_errors import stage_error

        # name the attribute of the stage, not the field of the scene
        return str(stage_error(error)), 2
    if isinstance(error, MemoryError):
        return "there is not enough memory; a larger mps:spacing makes fewer particles", 3
    if isinstance(error, OSError):
        # a file that could be used a moment ago, or a name that no file can have
        named = "" if error.filename is None else f"{error.filename}: "
        return f"{named}{error.strerror or error}", 2 if error.errno == errno.ENAMETOOLONG else 3
    return str(error), 3


def _cause(interrupt: KeyboardInterrupt) -> str:
    return str(interrupt) or "interrupted"


def _code(interrupt: KeyboardInterrupt) -> int:
    """The exit code that a shell gives to a process that a signal ended."""
    return 128 + getattr(interrupt, "number", signal.SIGINT)


def _read(case: str, changes: Sequence[str], duration: float | None, *, allow_external: bool) -> Any:
    """The scene of a case, changed as the user wishes."""
    from warp_mps.usd.case.read import read_stage
    from warp_mps.usd.shipped_cases import find_case

    overrides = dict(_parse_change(change) for change in changes)
    scene = read_stage(find_case(case), overrides=overrides, allow_external=allow_external)
    return scene if duration is None else _lasting(scene, duration)


def _lasting(scene: Any, duration: float) -> Any:
    """A scene with a new duration [s]; measurements that need later times are dropped, and a line names them.

    One whose window is open ends where the case does, and its reference is the value up to there.
    """
    from dataclasses import replace

    from warp_mps.results.measures import used_until

    last = min(duration, scene.duration)
    kept = [item for item in scene.measurements if used_until(item, scene.duration) <= last and item.start < last]
    shortened = replace(scene, duration=duration, measurements=tuple(kept))
    left_out = [item.name for item in scene.measurements if item not in kept]
    if left_out:
        say(f"not measured, because the run ends at {duration:g} s: {', '.join(left_out)}")
    return shortened


def _parse_change(change: str) -> tuple[str, str]:
    path, equals, value = change.partition("=")
    if not equals or "." not in path or not path.startswith("/"):
        raise InputError("--set", change, "must be /Prim.attribute=value, e.g. /World/beam.mps:spacing=0.005")
    return path.strip(), value.strip()


def _fail(message: str, code: int) -> int:
    say(message)
    return code
