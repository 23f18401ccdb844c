"""Lines of native libraries: they are diverted from the error stream, and only they."""

from __future__ import annotations

import os
import sys

import pytest

from warp_mps.core.native_output import native_errors


def test_native_lines_are_diverted(capfd: pytest.CaptureFixture[str]) -> None:
    with native_errors() as diverted:
        os.write(2, b"from a library\n")
        diverted.seek(0)
        assert diverted.read() == b"from a library\n"
    os.write(2, b"after\n")
    assert capfd.readouterr().err == "after\n"


def test_the_stream_returns_after_an_error(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyError), native_errors():
        raise KeyError
    os.write(2, b"after\n")
    assert capfd.readouterr().err == "after\n"


def test_a_closed_stream_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    def closed(_stream: int) -> int:
        raise OSError

    monkeypatch.setattr(os, "dup", closed)
    with native_errors() as diverted:
        assert diverted.read() == b""


def test_no_stream_of_python(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "__stderr__", None)
    with native_errors():
        os.write(2, b"from a library\n")
    assert capfd.readouterr().err == ""
