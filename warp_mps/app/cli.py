"""The commands of ``warp-mps`` and their exit codes.

0: done. 2: the input is wrong. 3: the run failed. 130: interrupted.
"""

from __future__ import annotations

import functools
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from tyro.conf import Positional, UseAppendAction, arg

from warp_mps.app import result_commands
from warp_mps.app.arguments import parse
from warp_mps.core.interrupts import first_interrupt_only
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
    except KeyboardInterrupt:
        if (folder / "checkpoint.npz").exists():
            return _fail("interrupted; the results so far are kept, continue with --resume", INTERRUPTED)
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


INTERRUPTED = 130
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
    if arguments == ["--version"]:
        print(f"warp-mps {__version__}")
        return 0
    # a batch system ends a job by SIGTERM: treat it as Ctrl-C, so that all results are kept
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    try:
        # a second Ctrl-C must not interrupt the saving that the first one started
        with first_interrupt_only():
            return parse(COMMANDS, arguments)()
    except InputError as error:
        from warp_mps.usd.case.stage_errors import stage_error

        # name the attribute of the stage, not the field of the scene
        return _fail(str(stage_error(error)), 2)
    except RunError as error:
        return _fail(str(error), 3)
    except MemoryError:
        return _fail("there is not enough memory; a larger mps:spacing makes fewer particles", 3)
    except KeyboardInterrupt:
        return _fail("interrupted", INTERRUPTED)


def _read(case: str, changes: Sequence[str], duration: float | None, *, allow_external: bool) -> Any:
    """The scene of a case, changed as the user wishes."""
    from warp_mps.usd.case.read import read_stage
    from warp_mps.usd.shipped_cases import find_case

    overrides = dict(_parse_change(change) for change in changes)
    scene = read_stage(find_case(case), overrides=overrides, allow_external=allow_external)
    return scene if duration is None else _lasting(scene, duration)


def _lasting(scene: Any, duration: float) -> Any:
    """A scene with a new duration [s]; measurements that need later times are dropped, and a line names them."""
    from dataclasses import replace

    from warp_mps.scene.validation.probes import is_past

    kept = [item for item in scene.measurements if not is_past(item, duration)]
    shortened = replace(scene, duration=duration, measurements=tuple(kept))
    left_out = [item.name for item in scene.measurements if item not in kept]
    if left_out:
        _say(f"not measured, because the run ends at {duration:g} s: {', '.join(left_out)}")
    return shortened


def _parse_change(change: str) -> tuple[str, str]:
    path, equals, value = change.partition("=")
    if not equals or "." not in path or not path.startswith("/"):
        raise InputError("--set", change, "must be /Prim.attribute=value, e.g. /World/beam.mps:spacing=0.005")
    return path.strip(), value.strip()


def _fail(message: str, code: int) -> int:
    _say(message)
    return code


def _say(message: str) -> None:
    print(f"warp-mps: {message}", file=sys.stderr)
