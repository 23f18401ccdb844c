"""Runs that are asked to stop, from the command line and from Python, and runs whose output goes nowhere."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.faults.cases import Case, assert_continues, make_case

if not sys.platform.startswith("linux"):
    pytest.skip("the faults are made by Linux's own means", allow_module_level=True)

from tests.faults.processes import PATIENCE, ending, running, wait_for_rows

pytestmark = pytest.mark.usefixtures("interruptible")

SCRIPT = """
import signal, sys
import warp_mps as mps

{before}
mps.run_scene(mps.read_stage(sys.argv[1]), sys.argv[2], quiet=True, checkpoint_interval=0.0)
print("went on")
"""
HANDLES = "signal.signal(signal.SIGTERM, lambda *_: sys.exit(7))"
IGNORES = "signal.signal(signal.SIGTERM, signal.SIG_IGN)"


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """A cantilever that falls, with its continuous run."""
    return make_case("solid", tmp_path_factory.mktemp("cases"))


def ignore(*numbers: signal.Signals) -> Callable[[], None]:
    """What a process does before it starts: ignore signals, as a background job of a shell and nohup do."""
    return lambda: [signal.signal(number, signal.SIG_IGN) for number in numbers] and None


@pytest.mark.parametrize(
    ("number", "ignored", "code", "line"),
    [
        pytest.param(signal.SIGTERM, (), 143, "ended by SIGTERM", marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, (), 129, "ended by SIGHUP", marks=pytest.mark.long),
        pytest.param(signal.SIGINT, (), 130, "interrupted", marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, (signal.SIGINT,), 143, "ended by SIGTERM", marks=pytest.mark.long),
    ],
)
def test_a_command_that_is_asked_to_stop_keeps_its_results(
    case: Case, tmp_path: Path, number: signal.Signals, ignored: tuple, code: int, line: str
) -> None:
    out = tmp_path / "out"
    with running(case, out, prepare=ignore(*ignored)) as process:
        wait_for_rows(process, out, 12)
        process.send_signal(number)
        assert ending(process) == (code, f"warp-mps: {line}; the results so far are kept, continue with --resume")
    summary = json.loads((out / "run.json").read_text())
    assert (summary["status"], summary["reason"]) == ("failed", f"{line}; continue with --resume")
    assert assert_continues(case, out) > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT])
def test_a_signal_that_is_ignored_stays_so(case: Case, tmp_path: Path, number: signal.Signals) -> None:
    with running(case, tmp_path / "out", prepare=ignore(number)) as process:
        wait_for_rows(process, tmp_path / "out", 3)
        process.send_signal(number)
        assert ending(process) == (0, "")


@pytest.mark.parametrize(
    ("before", "number", "code", "reason"),
    [
        ("", signal.SIGTERM, -signal.SIGTERM, "ended by SIGTERM; continue with --resume"),
        pytest.param("", signal.SIGHUP, -signal.SIGHUP, "ended by SIGHUP; continue", marks=pytest.mark.slow),
        pytest.param("", signal.SIGINT, -signal.SIGINT, "interrupted; continue with", marks=pytest.mark.slow),
        pytest.param(HANDLES, signal.SIGTERM, 7, "SystemExit(7)", marks=pytest.mark.long),
        pytest.param(IGNORES, signal.SIGTERM, 0, "", marks=pytest.mark.slow),
    ],
)
def test_a_program_that_is_killed_keeps_its_results(
    case: Case, tmp_path: Path, before: str, number: signal.Signals, code: int, reason: str
) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-c", SCRIPT.format(before=before), str(case.stage), str(out)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        wait_for_rows(process, out, 12)
        process.send_signal(number)
        printed, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == code
    assert printed == ("went on\n" if code == 0 else "")
    assert ("Traceback" in errors) == (number == signal.SIGINT)
    summary = json.loads((out / "run.json").read_text())
    assert summary["status"] == ("done" if code == 0 else "failed")
    assert summary["reason"].startswith(reason)
    assert assert_continues(case, out) > 0.0


@pytest.mark.parametrize("module", ["pxr.Usd._usd", "pxr.Sdf._sdf", "pxr.Sdf.__DOC"])
def test_a_signal_while_usd_is_imported_is_not_lost(module: str) -> None:
    """USD's modules discard the exception of a signal, and go on without what they were to import."""
    code = (
        "import os, signal, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        f"        if name == {module!r}: os.kill(os.getpid(), signal.SIGTERM)\n"
        "signal.signal(signal.SIGTERM, signal.SIG_DFL)\n"
        "sys.meta_path.insert(0, Finder())\n"
        "from warp_mps.app.cli import main\n"
        "sys.exit(main(['check', 'bar_struck_by_wall']))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (
        143,
        "",
        "warp-mps: ended by SIGTERM\n",
    )


@pytest.mark.parametrize(
    ("redirection", "code"),
    [
        pytest.param(">&- 2>&- <&-", 0, marks=pytest.mark.long),
        pytest.param(">/dev/full 2>/dev/full", 0, marks=pytest.mark.long),
        pytest.param("2>&1 | head -n 1; exit ${PIPESTATUS[0]}", 0, marks=pytest.mark.slow),
        pytest.param("2>/dev/full | head -c 1; exit ${PIPESTATUS[0]}", 0, marks=pytest.mark.slow),
    ],
)
def test_a_run_goes_on_whatever_becomes_of_its_output(case: Case, tmp_path: Path, redirection: str, code: int) -> None:
    out = tmp_path / "out"
    command = f'"{sys.executable}" -m warp_mps run "{case.stage}" --out "{out}" {redirection}'
    assert (
        subprocess.run(["bash", "-c", command], capture_output=True, timeout=PATIENCE, check=False).returncode == code
    )
    assert json.loads((out / "run.json").read_text())["status"] == "done"
    assert assert_continues(case, out) > 0.0


@pytest.mark.long
@pytest.mark.parametrize(
    ("rest", "code", "errors"),
    [
        ("list >/dev/full", 3, "warp-mps: standard output cannot be written: No space left on device\n"),
        ("--help >/dev/full", 3, "warp-mps: standard output cannot be written: No space left on device\n"),
        ("list | head -n 1; exit ${PIPESTATUS[0]}", 0, ""),
        ("list >&-", 0, ""),
        ("check nothing 2>/dev/full", 2, ""),
        ("check nothing 2>&-", 2, ""),
    ],
)
def test_the_exit_code_tells_whether_what_was_asked_for_was_printed(rest: str, code: int, errors: str) -> None:
    command = f'"{sys.executable}" -m warp_mps {rest}'
    ended = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (ended.returncode, ended.stderr) == (code, errors)
