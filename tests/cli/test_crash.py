"""A file that makes a reader in C++ crash is one line, and the program lives on."""

import os
import signal
import sys

import numpy as np
import pytest
from command import mpfcad

from mpfcad.boundary.apart import apart, tell_stage
from mpfcad.cad import write_step
from mpfcad.cli import run_app
from mpfcad.errors import ExportError, InputError
from mpfcad.film import Groove, PrismFilm


def double(value):
    print("what a library prints is dropped")
    os.write(1, b"\x00\xff")
    return 2 * value


def crash(number):
    tell_stage("reading film.step")
    os.kill(os.getpid(), number)


def spin(path):
    tell_stage("reading film.step")
    while True:
        pass


def load_then_answer(value):
    import slow_library

    return value + slow_library.VALUE


def refuse(path):
    raise InputError(f"{path}: row 3: expected numbers")


def fail():
    raise ZeroDivisionError("division by zero")


def test_an_answer_comes_back():
    assert apart("a.step", "a solid", double, 21) == 42


def test_a_crash_is_one_line_that_says_what_was_read():
    told = []
    with pytest.raises(ExportError, match=r"a: its reader crashed while reading film\.step \(SIG"):
        apart("a", "an export", crash, signal.SIGSEGV, kind=ExportError, stage=told.append)
    assert told == ["reading film.step"]


def test_a_call_without_end_is_stopped(monkeypatch, tmp_path):
    if os.name == "nt":  # where no process's time is counted
        return
    module = sys.modules["mpfcad.boundary.apart"]
    (tmp_path / "a").write_bytes(bytes(100_000))
    monkeypatch.setattr(module, "_PATIENCE", 1.0)
    monkeypatch.setattr(module, "_PATIENCE_MB", 10.0)
    says = r"a: its reader did not end within 2 s of a processor while reading film\.step: expect"
    with pytest.raises(InputError, match=says):
        apart("a", "a solid", spin, tmp_path / "a")


def test_loading_a_library_is_none_of_a_calls_time(monkeypatch, tmp_path):
    text = "import time\nwhile time.process_time() < 3:\n    pass\nVALUE = 2\n"
    (tmp_path / "slow_library.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    module = sys.modules["mpfcad.boundary.apart"]
    monkeypatch.setattr(module, "_PATIENCE", 1.0)
    assert apart("a", "a solid", load_then_answer, 1, libraries=("slow_library", "none")) == 3
    if os.name != "nt":
        with pytest.raises(InputError, match="did not end within 1 s of a processor"):
            apart("a", "a solid", load_then_answer, 1)


def test_a_call_that_needs_no_file_has_ten_seconds():
    module = sys.modules["mpfcad.boundary.apart"]
    assert module._patience(()) == 10


def test_an_error_is_the_same_error():
    with pytest.raises(InputError, match=r"^b: row 3: expected numbers$"):
        apart("b", "a table", refuse, "b")
    with pytest.raises(InputError, match=r"b: not readable \(ZeroDivisionError"):
        apart("b", "a table", fail)


def test_a_step_file_that_is_none_is_one_line(tmp_path, capfd):
    (tmp_path / "a.step").write_text("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=(;\nENDSEC;\n")
    assert run_app(["trace", str(tmp_path / "a.step")]) == 2
    error = capfd.readouterr().err
    assert error.count("\n") == 1 and "a.step" in error


def test_a_step_file_that_crashes_its_kernel_is_one_line(tmp_path):
    """OCCT dies of a plane whose direction it does not know (signal 11)."""
    film = PrismFilm(Groove(0.05, 0.025), 0.2, 2.0, "filled", np.array([60.0, 60.0]))
    write_step(film, tmp_path / "a.step")
    data = (tmp_path / "a.step").read_bytes()
    (tmp_path / "a.step").write_bytes(data.replace(b"DIRECTION", b"DIRECTI^N", 1))
    result = mpfcad("trace", "a.step", cwd=tmp_path)
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("\n") == 1 and "a.step: " in result.stderr


def test_what_a_library_says_of_a_damaged_file_is_not_printed(tmp_path):
    import struct

    tag = struct.pack("<HHII", 256, 44, 1, 7)
    (tmp_path / "a.tif").write_bytes(b"II*\0" + struct.pack("<IH", 8, 1) + tag + bytes(4))
    result = mpfcad("judge", "a.tif", "--pixel-mm", "0.1", cwd=tmp_path)
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("\n") == 1 and "a.tif" in result.stderr
