"""Streams that are closed, full or broken, and say nothing of it."""

from __future__ import annotations

import io
import os
from pathlib import Path

import pytest

from warp_mps.core import streams
from warp_mps.core.streams import PatientStream, patient_streams, say


def test_a_whole_stream_is_written_to() -> None:
    file = io.StringIO()
    stream = PatientStream(file)
    assert stream.write("text") == 4
    stream.flush()
    assert file.getvalue() == "text"
    assert stream.failure is None
    assert stream.isatty() is False


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no such device")
def test_a_full_stream_keeps_its_error() -> None:
    with open("/dev/full", "w") as file:
        stream = PatientStream(file)
        stream.write("text")
        stream.flush()
        assert isinstance(stream.failure, OSError)
        assert stream.failure.strerror == "No space left on device"


def test_a_missing_and_a_closed_stream_take_everything(tmp_path: Path) -> None:
    missing = PatientStream(None)
    missing.write("text")
    missing.flush()
    assert (missing.failure, missing.isatty()) == (None, False)
    file = (tmp_path / "file").open("w")
    file.close()
    closed = PatientStream(file)
    closed.write("text")
    assert isinstance(closed.failure, ValueError)


def test_characters_that_a_stream_lacks_are_escaped(tmp_path: Path) -> None:
    with (tmp_path / "file").open("w", encoding="ascii") as file:
        PatientStream(file).write("\u00e9\udcff")
    assert (tmp_path / "file").read_text() == "\\xe9\\udcff"


def test_a_line_needs_no_standard_error(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    say("heard")
    assert capsys.readouterr().err == "warp-mps: heard\n"
    monkeypatch.setattr(streams.sys, "stderr", None)
    say("not heard")
    assert capsys.readouterr().out == ""


def test_streams_are_given_back() -> None:
    before = streams.sys.stdout, streams.sys.stderr
    with patient_streams():
        assert isinstance(streams.sys.stdout, PatientStream)
    assert (streams.sys.stdout, streams.sys.stderr) == before
