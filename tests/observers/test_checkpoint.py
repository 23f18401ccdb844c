"""Checkpoints: whole or not there, and of this case or refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.observers.views import FakeView, blocks, view_of
from warp_mps.errors import InputError, RunError
from warp_mps.observers import checkpoint as cp


@pytest.fixture
def view() -> FakeView:
    return view_of(blocks())


def save(folder: Path, step: int, fingerprint: str = "case") -> None:
    arrays = {"x": np.arange(1000.0) * step, "file": np.array(step, dtype=np.int32), "flags": np.zeros((2, 0), bool)}
    cp.save_checkpoint(folder, fingerprint, cp.Checkpoint(step, step * 0.1, arrays))


def test_arrays_come_back_bit_for_bit(tmp_path: Path) -> None:
    save(tmp_path, 3)
    loaded = cp.load_checkpoint(tmp_path, "case")
    assert (loaded.step, loaded.time) == (3, 3 * 0.1)
    assert loaded.arrays["x"].tobytes() == (np.arange(1000.0) * 3).tobytes()
    assert loaded.arrays["file"].dtype == np.int32
    assert loaded.arrays["file"].shape == ()
    assert loaded.arrays["flags"].shape == (2, 0)


def test_the_newest_is_loaded_and_the_one_before_is_kept(tmp_path: Path) -> None:
    for step in (1, 2, 3):
        save(tmp_path, step)
    assert cp.load_checkpoint(tmp_path, "case").step == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == [cp.NAME, cp.PREVIOUS]
    (tmp_path / cp.NAME).unlink()
    assert cp.load_checkpoint(tmp_path, "case").step == 2


@pytest.mark.parametrize("part", [0.0, 0.3, 0.6, 0.99])
def test_a_truncated_file_falls_back_to_the_one_before(tmp_path: Path, part: float) -> None:
    save(tmp_path, 1)
    save(tmp_path, 2)
    content = (tmp_path / cp.NAME).read_bytes()
    (tmp_path / cp.NAME).write_bytes(content[: int(part * len(content))])
    assert cp.load_checkpoint(tmp_path, "case").step == 1


def test_an_altered_file_falls_back_to_the_one_before(tmp_path: Path) -> None:
    save(tmp_path, 1)
    save(tmp_path, 2)
    content = bytearray((tmp_path / cp.NAME).read_bytes())
    content[len(content) // 2] ^= 1
    (tmp_path / cp.NAME).write_bytes(content)
    assert cp.load_checkpoint(tmp_path, "case").step == 1


@pytest.mark.parametrize("change", [{"step": 7}, {"time": 0.0}, {"fingerprint": "mine"}])
def test_altered_metadata_are_noticed(tmp_path: Path, change: dict) -> None:
    save(tmp_path, 1)
    save(tmp_path, 2)
    rewrite_metadata(tmp_path / cp.NAME, change)
    assert cp.load_checkpoint(tmp_path, "case").step == 1


def rewrite_metadata(path: Path, change: dict) -> None:
    with np.load(path) as file:
        entries = {name: file[name] for name in file.files}
    metadata = json.loads(str(entries[cp.METADATA])) | change
    np.savez(path, **entries | {cp.METADATA: np.array(json.dumps(metadata))})


def test_two_damaged_files_are_refused(tmp_path: Path) -> None:
    save(tmp_path, 1)
    save(tmp_path, 2)
    for name in (cp.NAME, cp.PREVIOUS):
        (tmp_path / name).write_bytes(b"PK")
    with pytest.raises(InputError, match="damaged"):
        cp.load_checkpoint(tmp_path, "case")


def test_another_case_is_refused(tmp_path: Path) -> None:
    save(tmp_path, 1)
    with pytest.raises(InputError, match="another case, precision or version"):
        cp.load_checkpoint(tmp_path, "other")


@pytest.mark.parametrize("version", [1, 99])
def test_another_version_is_refused(tmp_path: Path, version: int) -> None:
    save(tmp_path, 1)
    rewrite_metadata(tmp_path / cp.NAME, {"version": version})
    with pytest.raises(InputError, match=f"format version {version}, this program reads {cp.VERSION}"):
        cp.load_checkpoint(tmp_path, "case")


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no checkpoint"):
        cp.load_checkpoint(tmp_path, "case")


class Harmful:
    """What does harm where it is loaded."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple:
        return Path.touch, (self.path,)


@pytest.mark.parametrize("entry", [cp.METADATA, "state.x"])
def test_pickled_objects_are_not_loaded(tmp_path: Path, entry: str) -> None:
    save(tmp_path, 1)
    save(tmp_path, 2)
    with np.load(tmp_path / cp.NAME) as file:
        entries = dict(file)
    np.savez(tmp_path / cp.NAME, **entries | {entry: np.array([Harmful(tmp_path / "harm")], dtype=object)})
    said: list[str] = []
    assert cp.load_checkpoint(tmp_path, "case", announce=said.append).step == 1
    assert [line.partition(";")[0] for line in said] == [f"{tmp_path / cp.NAME} is damaged"]
    (tmp_path / cp.PREVIOUS).unlink()
    with pytest.raises(InputError, match="damaged"):
        cp.load_checkpoint(tmp_path, "case")
    assert not (tmp_path / "harm").exists()


def test_the_writer_saves_at_its_interval_and_at_the_end(tmp_path: Path, view: FakeView) -> None:
    now = [0.0]
    writer = cp.CheckpointWriter(tmp_path, "case", every=1, interval=60.0, clock=lambda: now[0])
    for step, now[0] in ((1, 30.0), (2, 61.0), (3, 90.0)):
        view.step = step
        view.displacements[:] = step
        writer.observe(view)
    assert cp.load_checkpoint(tmp_path, "case").step == 2
    view.displacements[:] = 99.0
    writer.close()
    loaded = cp.load_checkpoint(tmp_path, "case")
    assert loaded.step == 3
    assert (loaded.arrays["displacements"] == 3.0).all()


def test_a_state_that_blew_up_is_never_saved(tmp_path: Path, view: FakeView) -> None:
    writer = cp.CheckpointWriter(tmp_path, "case", every=1, interval=0.0)
    view.step = 1
    writer.observe(view)
    view.step = 2
    view.velocities[0, 0] = np.nan
    writer.observe(view)
    writer.close()
    assert cp.load_checkpoint(tmp_path, "case").step == 1


def test_a_writer_that_saw_nothing_writes_nothing(tmp_path: Path) -> None:
    cp.CheckpointWriter(tmp_path, "case", every=1).close()
    assert list(tmp_path.iterdir()) == []


def test_any_byte_that_is_altered_is_noticed(tmp_path: Path) -> None:
    """Or it is one that says nothing, such as the time of day in the container: then all comes back as it was."""
    arrays = {"x": np.arange(20.0), "count": np.array(3)}
    cp.save_checkpoint(tmp_path, "case", cp.Checkpoint(1, 0.1, arrays))
    cp.save_checkpoint(tmp_path, "case", cp.Checkpoint(2, 0.2, arrays))
    content = (tmp_path / cp.NAME).read_bytes()
    fallen_back = 0
    for index in range(len(content)):
        altered = bytearray(content)
        altered[index] ^= 0x81
        (tmp_path / cp.NAME).write_bytes(altered)
        loaded = cp.load_checkpoint(tmp_path, "case")
        fallen_back += loaded.step == 1
        assert loaded.time == loaded.step / 10
        assert loaded.arrays.keys() == arrays.keys()
        assert all(np.array_equal(loaded.arrays[name], array) for name, array in arrays.items())
    assert fallen_back > 0.7 * len(content)


def test_the_fallback_is_announced(tmp_path: Path) -> None:
    said: list[str] = []
    save(tmp_path, 1)
    save(tmp_path, 2)
    cp.load_checkpoint(tmp_path, "case", announce=said.append)
    assert said == []
    (tmp_path / cp.NAME).write_bytes(b"PK")
    cp.load_checkpoint(tmp_path, "case", announce=said.append)
    assert said == [f"{tmp_path / cp.NAME} is damaged; going on from {cp.PREVIOUS}, at 0.1 s"]


def test_a_checkpoint_that_cannot_be_written_leaves_those_before_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save(tmp_path, 1)
    save(tmp_path, 2)

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np.lib.format, "write_array", full)
    with pytest.raises(RunError, match="cannot be written: No space left"):
        save(tmp_path, 3)
    assert cp.load_checkpoint(tmp_path, "case").step == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == [cp.NAME, cp.PREVIOUS]
