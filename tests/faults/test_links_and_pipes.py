"""Links and pipes in a folder of results: nothing elsewhere is overwritten, and no command waits for ever."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from tests.app.results import write_result
from tests.scenes import beam
from warp_mps.app.cli import main
from warp_mps.errors import InputError
from warp_mps.observers.checkpoint import load_checkpoint
from warp_mps.results.atomic_write import create_file, replacing, write_whole
from warp_mps.results.history import read_history
from warp_mps.results.summary import read_summary
from warp_mps.run.locks import is_locked, lock_folder
from warp_mps.run.run import run_scene

if not hasattr(os, "mkfifo"):
    pytest.skip("there are no pipes", allow_module_level=True)

RESULTS = ("run.json", "probes.csv", "run.usdc", "checkpoint.npz", "checkpoint.prev.npz")
GUESSED = (".run.json.new", ".report.html.new", ".new.picture.png", "checkpoint.npz.new", ".probes.csv.new")
HIDDEN = (".run.a.usdc", ".run.b.usdc", ".run.a.new", ".run.a.whole.usdc")


@pytest.fixture
def victim(tmp_path: Path) -> Path:
    """A file outside the folder of results."""
    path = tmp_path / "victim"
    path.write_text("precious")
    return path


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_run_writes_through_no_link(tmp_path: Path, victim: Path, overwrite: bool) -> None:
    out = tmp_path / "out"
    out.mkdir()
    for name in (*GUESSED, *HIDDEN, *(RESULTS if overwrite else ())):
        (out / name).symlink_to(victim)
    scene = beam(2, duration=2e-4, frame_rate=1e4)
    assert run_scene(scene, out, quiet=True, overwrite=overwrite).status == "done"
    assert victim.read_text() == "precious"
    assert not any((out / name).is_symlink() for name in RESULTS)


@pytest.mark.parametrize(
    "command", ["report", pytest.param("picture", marks=pytest.mark.long), "convert", "convert --to usd --colour speed"]
)
def test_a_command_writes_through_no_link(tmp_path: Path, victim: Path, command: str) -> None:
    out = tmp_path / "out"
    write_result(out)
    (out / "pvd").mkdir()
    named = ("report.html", "picture.png", "run_speed.usdc", "pvd/run.pvd", "pvd/block_0000.vtp", "pvd/floor_0002.vtp")
    for name in (*GUESSED, *named):
        (out / name).symlink_to(victim)
    before = sorted(path.name for path in out.iterdir())
    name, *options = command.split()
    assert main([name, str(out), *options]) == 2  # what is there stays unless it may be replaced
    assert main([name, str(out), *options, "--overwrite"]) == 0
    assert victim.read_text() == "precious"
    assert sorted(path.name for path in out.iterdir()) == before


def test_a_folder_that_is_a_link_is_not_filled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_result(tmp_path / "out")
    (tmp_path / "other").mkdir()
    (tmp_path / "other/block_0000.vtp").write_text("precious")
    (tmp_path / "out/pvd").symlink_to("../other")
    assert main(["convert", str(tmp_path / "out"), "--overwrite"]) == 2
    assert "out/pvd: is a link to another folder, must be a folder; remove the link" in capsys.readouterr().err
    assert (tmp_path / "other/block_0000.vtp").read_text() == "precious"


@pytest.mark.parametrize("kind", ["link", "hard link", "pipe", "folder"])
def test_what_is_no_lock_is_refused(tmp_path: Path, victim: Path, kind: str) -> None:
    out = tmp_path / "out"
    out.mkdir()
    lock = out / ".lock"
    makers = {"link": lambda: lock.symlink_to(victim), "hard link": lambda: lock.hardlink_to(victim)}
    {**makers, "pipe": lambda: os.mkfifo(lock), "folder": lock.mkdir}[kind]()
    with pytest.raises(InputError, match=r"\.lock: is no file of its own"), lock_folder(out):
        pass
    assert is_locked(out) is None
    assert victim.read_text() == "precious"


@pytest.mark.parametrize("name", RESULTS)
def test_a_pipe_ends_every_command(tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / name)
    readers = {"run.json": read_summary, "probes.csv": read_history}
    for reader in (readers[name],) if name in readers else ():
        with pytest.raises(InputError, match="cannot be read: Not a regular file"):
            reader(tmp_path / name)
    if name.startswith("checkpoint"):
        with pytest.raises(InputError, match="is damaged"):
            load_checkpoint(tmp_path, "case")
    for command in ("report", "plot", "picture"):
        assert main([command, str(tmp_path)]) == 2
        assert re.fullmatch("warp-mps: [^\n]+\n", capsys.readouterr().err)


def test_a_temporary_file_cannot_be_guessed_and_is_removed(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    names = []
    for _ in range(2):
        with replacing(path) as temporary:
            names.append(temporary.name)
            temporary.write_text("text")
    assert names[0] != names[1]
    assert path.read_text() == "text"

    def fail() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert path.read_text() == "text"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(FileExistsError):
        create_file(path)
    # a temporary file of a longest name has a name that is not too long
    write_whole(tmp_path / ("x" * 251 + ".txt"), "text")
    assert oct(path.stat().st_mode & 0o777) == oct(0o666 & ~_umask())


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


@pytest.mark.parametrize("left", ["run.usdc", "probes.csv", "checkpoint.npz"])
def test_results_without_a_summary_are_results(tmp_path: Path, left: str) -> None:
    scene = beam(2, duration=2e-4, frame_rate=1e4)
    run_scene(scene, tmp_path, quiet=True)
    for path in tmp_path.iterdir():
        if path.name != left:
            path.unlink()
    content = (tmp_path / left).read_bytes()
    with pytest.raises(InputError, match=f"already has results, {left}; use --overwrite"):
        run_scene(scene, tmp_path, quiet=True)
    assert (tmp_path / left).read_bytes() == content
