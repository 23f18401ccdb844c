"""Limits of the system and names that cannot be used: one line, an exit code, and nothing left behind."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.faults.cases import Case, assert_continues, make_case
from tests.scenes import beam
from warp_mps.app import address_space
from warp_mps.app.cli import main
from warp_mps.core import device
from warp_mps.errors import InputError
from warp_mps.run.run import run_scene

if not sys.platform.startswith("linux"):
    pytest.skip("the limits are those of Linux", allow_module_level=True)

from tests.faults.processes import ending, running

MANY = 2**40


def limited(kind: int, size: int) -> Callable[[], None]:
    """What a process does before it starts: limit one of its resources."""
    return lambda: resource.setrlimit(kind, (size, size))


@pytest.mark.long
@pytest.mark.parametrize("size", [0, 1000])
def test_a_run_that_cannot_write_its_first_frame(tmp_path: Path, size: int) -> None:
    case = make_case("solid", tmp_path, frames=4)
    out = tmp_path / "out"
    with running(case, out, prepare=limited(resource.RLIMIT_FSIZE, size)) as process:
        code, line = ending(process)
    assert code == 2
    assert line.endswith("cannot be written: Error occurred writing file: File too large" if size else "File too large")
    assert not any(path.name.startswith(".") for path in out.iterdir()) if out.exists() else True


@pytest.mark.long
def test_a_run_that_cannot_be_continued_for_want_of_room_keeps_everything(tmp_path: Path) -> None:
    case = make_case("solid", tmp_path, frames=4)
    out = tmp_path / "out"
    run_scene(case.scene, out, quiet=True)
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    with running(case, out, "--resume", prepare=limited(resource.RLIMIT_FSIZE, 5000)) as process:
        code, line = ending(process)
    assert (code, "run.usdc: cannot be written" in line) == (2, True)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    assert assert_continues(Case("solid", case.stage, case.whole), out) > 0.0


def test_too_small_an_address_space_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for limit, found in ((MANY, False), (2**29, True), (resource.RLIM_INFINITY, False)):
        monkeypatch.setattr(resource, "getrlimit", lambda _, limit=limit: (limit, limit))
        assert bool(address_space.too_small()) is found
    monkeypatch.setattr(resource, "getrlimit", lambda _: (2**29, 2**29))
    assert address_space.too_small().startswith("the address space is 0.50 GiB (ulimit -v), must be at least")


@pytest.mark.parametrize("megabytes", [100, 500])
def test_the_list_of_cases_needs_an_address_space(megabytes: int) -> None:
    size = megabytes * 2**20
    ended = subprocess.run(
        [sys.executable, "-m", "warp_mps", "list"],
        preexec_fn=limited(resource.RLIMIT_AS, size),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    assert "ulimit -v" in ended.stderr


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["run", "beam_first_mode", "--out", ""], "--out: an argument is empty; give a value, such as ."),
        (["run", "beam_first_mode", "--out="], "--out: an argument is empty"),
        (["report", ""], "an argument is empty"),
        (["run", "beam_first_mode", "--out", "x" * 300], ": cannot be written: File name too long"),
        (["run", "x" * 300], "File name too long"),
        (["check", "x" * 300 + ".usda"], "there is no such file"),
        (["report", "x" * 300], "is not a folder"),
        (["run", "beam_first_mode", "--out", "a\udcff"], "a\\udcff': cannot be used: its path is not UTF-8"),
        (["report", "a\udcff"], "a\\udcff: is not a folder"),
    ],
)
def test_names_that_cannot_be_used(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert expected in captured.err
    assert list(tmp_path.iterdir()) == []


def test_in_python_a_folder_needs_a_name() -> None:
    with pytest.raises(InputError, match="folder: is empty"):
        run_scene(beam(2), "")


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (PermissionError(13, "Permission denied", "x"), "the kernels cannot be saved: Permission denied"),
        (OSError(28, "No space left on device"), "the kernels cannot be saved: No space left on device"),
        (
            UnicodeDecodeError("utf-8", b"\xff", 0, 1, "bad"),
            "cannot be loaded .Unicode.*delete this folder",
        ),
        (IsADirectoryError(21, "Is a directory", "x"), "cannot be loaded .*delete this folder"),
        (Exception("Failed to load CPU module"), "cannot be loaded .*delete this folder"),
    ],
)
def test_a_kernel_cache_that_cannot_be_used_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, error: Exception, reason: str
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    # Warp sets the folder as it starts
    cpu = device.open_device("cpu")
    monkeypatch.setattr(device.wp, "load_module", fail)
    monkeypatch.setattr(device.wp.config, "kernel_cache_dir", str(tmp_path))
    with pytest.raises(InputError, match=f"^{tmp_path}: .*{reason}"):
        device.load_modules(["anything"], cpu)


@pytest.mark.long
def test_a_damaged_kernel_cache_is_named(tmp_path: Path) -> None:
    case = make_case("solid", tmp_path, frames=2)
    environment = {**os.environ, "WARP_CACHE_PATH": str(tmp_path / "cache")}
    command = [sys.executable, "-m", "warp_mps", "run", str(case.stage), "--quiet", "--overwrite", "--out"]

    def run() -> tuple[int, str]:
        line = [*command, str(tmp_path / "out")]
        ended = subprocess.run(line, capture_output=True, text=True, check=False, env=environment)
        return ended.returncode, ended.stderr

    assert run() == (0, "")
    for path in (tmp_path / "cache").rglob("*.o"):
        path.write_bytes(b"damaged")
    code, line = run()
    assert (code, line.count("\n")) == (2, 1)
    assert line.startswith(f"warp-mps: {tmp_path / 'cache'}")
    assert line.endswith("; delete this folder\n")
