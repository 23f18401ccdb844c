"""Locks of result folders: one run at a time, and no lock outlives its process."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.usd.case.stages import write
from warp_mps.app.cli import main
from warp_mps.errors import InputError
from warp_mps.run.locks import NAME, is_locked, lock_folder

fcntl = pytest.importorskip("fcntl")

HOLDER = """
import sys, time
from pathlib import Path
from warp_mps.run.locks import lock_folder
with lock_folder(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def holder(tmp_path: Path) -> Iterator[subprocess.Popen]:
    """Another process that holds the lock of the folder `out`."""
    arguments = [sys.executable, "-c", HOLDER, str(tmp_path / "out")]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


@pytest.mark.parametrize("option", [(), ("--overwrite",), ("--resume",)])
def test_a_second_run_into_a_folder_is_refused(
    holder: subprocess.Popen, tmp_path: Path, option: tuple, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["run", str(write(tmp_path)), "--out", str(out), "--quiet", *option]) == 2
    line = f"warp-mps: {out}: is in use by the run of process {holder.pid}; give another folder or wait\n"
    assert capsys.readouterr().err == line
    assert [path.name for path in out.iterdir()] == [NAME]


def test_a_killed_process_leaves_no_lock(holder: subprocess.Popen, tmp_path: Path) -> None:
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait(timeout=300)
    assert (tmp_path / "out" / NAME).exists()
    with lock_folder(tmp_path / "out"):
        assert (tmp_path / "out" / NAME).read_text() == str(os.getpid())
    assert list((tmp_path / "out").iterdir()) == []


def test_one_process_cannot_hold_it_twice(tmp_path: Path) -> None:
    with lock_folder(tmp_path):
        with pytest.raises(InputError, match=f"in use by the run of process {os.getpid()}"), lock_folder(tmp_path):
            pass
        # the one that was refused has taken nothing away
        with pytest.raises(InputError, match="in use"), lock_folder(tmp_path):
            pass
    with lock_folder(tmp_path):
        pass


def test_a_lock_that_its_owner_has_just_removed_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The owner of the lock ends between the moments at which the next one opens the file and locks it."""
    flock, calls = fcntl.flock, []

    def late(handle: int, how: int) -> None:
        if not calls:
            (tmp_path / NAME).unlink()
        calls.append(handle)
        flock(handle, how)

    monkeypatch.setattr(fcntl, "flock", late)
    with lock_folder(tmp_path):
        assert len(calls) == 2
        assert (tmp_path / NAME).exists()


@pytest.mark.parametrize("code", [errno.ENOLCK, errno.EOPNOTSUPP])
def test_a_file_system_without_locks_is_used_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], code: int
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with lock_folder(tmp_path), lock_folder(tmp_path):
        pass
    assert capsys.readouterr().err == ""


def test_a_system_without_locks_is_used_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fcntl", None)
    with lock_folder(tmp_path), lock_folder(tmp_path):
        assert not (tmp_path / NAME).exists()


def test_folders_that_were_made_for_nothing_are_removed(tmp_path: Path) -> None:
    (tmp_path / "old").mkdir()
    with lock_folder(tmp_path / "a" / "b"), lock_folder(tmp_path / "old"), lock_folder(tmp_path / "kept"):
        assert (tmp_path / "a" / "b").is_dir()
        (tmp_path / "kept" / "file").touch()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kept", "old"]
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["file"]


def test_who_looks_sees_whether_a_run_is_at_work(holder: subprocess.Popen, tmp_path: Path) -> None:
    assert is_locked(tmp_path) is False
    assert is_locked(tmp_path / "out") is True
    holder.kill()
    holder.wait()
    # the file of the lock is still there, its owner is not
    assert (tmp_path / "out" / NAME).exists()
    assert is_locked(tmp_path / "out") is False
    with lock_folder(tmp_path / "out"):
        assert is_locked(tmp_path / "out") is True
