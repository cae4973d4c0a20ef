"""Errors are lines; a fault of the program leaves its traceback in a file."""

from pathlib import Path

import pytest

from flows import cli
from flows.global_options import split_command_line
from flows.terminal import Terminal, use_terminal
from storage.errors import InputError, ShapeError
from tests.flows.calls import Called, call


@pytest.fixture
def raising(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> pytest.MonkeyPatch:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return monkeypatch


def _call(
    capsys: pytest.CaptureFixture[str], patch: pytest.MonkeyPatch, error: BaseException, *words: str
) -> Called:
    def fail(*_words: object, **_options: object) -> None:
        raise error

    patch.setattr("tasks.settings.Campaign.model_json_schema", fail)
    return call(capsys, "schema", *words)


def test_bad_input_is_one_error_line_a_problem(
    capsys: pytest.CaptureFixture[str], raising: pytest.MonkeyPatch
) -> None:
    called = _call(capsys, raising, InputError("a: b; c\nd: e; f"))
    assert (called.code, called.out, called.err) == (3, "", "error: a: b; c\nerror: d: e; f\n")


def test_fault_names_the_log_and_shows_no_traceback(
    capsys: pytest.CaptureFixture[str], raising: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    called = _call(capsys, raising, ZeroDivisionError("division by zero"))
    (log,) = tmp_path.glob("tiltwatch-*.log")
    assert called.code == 1
    expected = (
        f"error: this is a fault of tiltwatch: ZeroDivisionError: division by zero; traceback in {log}\n"
    )
    assert called.err == expected
    assert "Traceback (most recent call last)" in log.read_text("utf-8")


def test_misuse_inside_the_program_is_a_fault_too(
    capsys: pytest.CaptureFixture[str], raising: pytest.MonkeyPatch
) -> None:
    called = _call(capsys, raising, ShapeError("needs (n, 3)"))
    assert called.code == 1
    assert called.err.startswith(
        "error: this is a fault of tiltwatch: ShapeError: needs (n, 3); traceback in "
    )


def test_very_verbose_shows_the_traceback(
    capsys: pytest.CaptureFixture[str], raising: pytest.MonkeyPatch
) -> None:
    called = _call(capsys, raising, ZeroDivisionError("division by zero"), "-vv")
    assert "Traceback (most recent call last)" in called.err


def test_log_goes_into_the_workspace_once_it_is_known(
    capsys: pytest.CaptureFixture[str], raising: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from flows.faults import report_fault  # noqa: PLC0415 (as the command line does)

    (tmp_path / "ws").mkdir()
    use_terminal(Terminal(log_folder=tmp_path / "ws" / "logs"))
    try:
        report_fault(ValueError("x"), wants_json=False)
    finally:
        use_terminal(Terminal())
    assert str(tmp_path / "ws" / "logs" / "tiltwatch-") in capsys.readouterr().err


def test_interruption_ends_with_130(capsys: pytest.CaptureFixture[str], raising: pytest.MonkeyPatch) -> None:
    called = _call(capsys, raising, KeyboardInterrupt())
    assert (called.code, called.err) == (130, "error: interrupted; what was finished is kept\n")


def test_reader_that_goes_away_is_no_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    gone: list[bool] = []
    monkeypatch.setattr("flows.terminal.forget_stdout", lambda: gone.append(True))
    called = _call(capsys, monkeypatch, BrokenPipeError())
    assert (called.code, called.err, gone) == (0, "", [True])


@pytest.mark.parametrize(
    ("words", "verbosity"),
    [(["-v", "run"], 1), (["run", "-vv"], 2), (["run", "--verbose", "-v"], 2), (["run"], 0)],
)
def test_verbosity_may_stand_anywhere(words: list[str], verbosity: int) -> None:
    call_line = split_command_line(words)
    assert (call_line.terminal.verbosity, call_line.words) == (verbosity, ("run",))


def test_words_after_two_dashes_are_left_alone() -> None:
    assert split_command_line(["check", "--", "-v"]).words == ("check", "--", "-v")


def test_entry_point_is_the_one_of_the_project() -> None:
    assert callable(cli.main)
