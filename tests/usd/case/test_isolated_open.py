"""Opening a stage in a process of its own is limited in processor time, so that a busy machine refuses nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdf

from tests.usd.case.stages import write
from warp_mps.errors import InputError
from warp_mps.usd.case import isolated_open, open_stage
from warp_mps.usd.case.layers import check_layers

# a child as slow as a test wants: it says that it is ready, and then waits or computes
WAITING = "import sys, time; print('ready', flush=True); time.sleep(float(sys.argv[1]))"
COMPUTING = (
    "from warp_mps.usd.case.isolated_process import limit_time\n"
    "print('ready', flush=True)\n"
    "limit_time(0.1)\n"
    "while True: pass\n"
)


def start(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> None:
    """Let the isolated process start Python with some arguments instead of its own process."""

    def replaced(command: list[str], environment: dict[str, str], errors: object) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, *arguments], env=environment, stdout=subprocess.PIPE)

    monkeypatch.setattr(isolated_open, "_start", replaced)


def test_a_good_stage_passes(tmp_path: Path) -> None:
    isolated_open.open_isolated(write(tmp_path), allow_external=False)


def test_a_process_that_waits_longer_than_its_processor_time_passes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(isolated_open, "CPU_TIME", 0.2)
    start(monkeypatch, "-c", WAITING, "0.5")
    isolated_open.open_isolated(write(tmp_path), allow_external=False)


def test_a_process_that_computes_too_long_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("resource")
    start(monkeypatch, "-c", COMPUTING)
    with pytest.raises(InputError, match="takes USD more than 6 s of processor time to compose"):
        isolated_open.open_isolated(write(tmp_path), allow_external=False)


def test_a_process_that_waits_for_ever_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(isolated_open, "CPU_TIME", 0.01)
    start(monkeypatch, "-c", WAITING, "600")
    with pytest.raises(InputError, match="takes USD more than 0 s of wall time to compose"):
        isolated_open.open_isolated(write(tmp_path), allow_external=False)


def test_what_only_the_second_opening_notices_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def noticed(path: Path, *, allow_external: bool) -> list[Sdf.Layer]:
        os.write(2, b"failed call to posix_madvise(139999, 2101772)ret=12, errno=0 'Success'\n")
        return check_layers(path, allow_external=allow_external)

    monkeypatch.setattr(open_stage, "check_layers", noticed)
    with pytest.raises(InputError, match="is damaged: it refers to what lies beyond its end"):
        open_stage.open_stage(write(tmp_path))
    assert capfd.readouterr().err == ""
