"""run and demo: what they tell and how they end."""

import io
import json
from pathlib import Path

import pytest

from flows.ledger import StageEvent
from flows.outcome import EpochOutcome, RunOutcome
from flows.progress import progress, stage_line
from flows.run_report import answer_of, conditions_of_run, exit_code_of, tell_errors, tell_results
from flows.terminal import Terminal, use_terminal
from tasks.settings import load_campaign
from tests.flows.calls import call, call_process
from tests.flows.stored_campaign import Stored, publish, stored_campaign

OK = EpochOutcome("e1", "ok", (), bad_input=False)
BAD = EpochOutcome("e2", "degraded", ("station ST02: no such file",), bad_input=True)
FAULT = EpochOutcome(
    "e2", "failed", ("fault of the program: ValueError: x",), bad_input=False, fault="Traceback x"
)
WEAK = EpochOutcome("e2", "degraded", ("no relative errors",), bad_input=False)
FAIL = {"verdict": "fail", "allowable_m": 0.0605}


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    return stored_campaign(tmp_path)


def _outcome(stored: Stored, *epochs: EpochOutcome) -> RunOutcome:
    return RunOutcome("run-1", stored.workspace.root, computed=7, cached=3, epochs=epochs)


@pytest.mark.parametrize(
    ("epochs", "fail_on", "code"),
    [
        ((OK,), None, 0),
        ((OK, WEAK), None, 0),
        ((OK, WEAK), "quality", 4),
        ((OK, WEAK), "warning", 0),
        ((OK, BAD), None, 3),
        ((OK, BAD), "alarm", 3),
        ((BAD, FAULT), None, 1),
    ],
)
def test_exit_code_follows_the_worst_epoch(
    epochs: tuple[EpochOutcome, ...], fail_on: str | None, code: int
) -> None:
    assert exit_code_of(epochs, [], fail_on) == code


@pytest.mark.parametrize(("fail_on", "code"), [(None, 0), ("quality", 6), ("warning", 6), ("alarm", 6)])
def test_alarm_counts_from_every_level_on(stored: Stored, fail_on: str | None, code: int) -> None:
    publish(stored, "e1", 0, FAIL)
    outcome = _outcome(stored, OK)
    found = conditions_of_run(load_campaign(stored.file), outcome)
    assert exit_code_of(outcome.epochs, found, fail_on) == code


def test_significant_change_fails_from_warning_on_but_not_from_alarm_on(stored: Stored) -> None:
    publish(stored, "e1", 0)
    publish(stored, "e2", 1, moved_m=0.05)
    outcome = _outcome(stored, EpochOutcome("e2", "ok", (), bad_input=False))
    found = conditions_of_run(load_campaign(stored.file), outcome)
    assert [exit_code_of(outcome.epochs, found, level) for level in ("quality", "warning", "alarm")] == [
        5,
        5,
        0,
    ]


def test_answer_keeps_the_contract(stored: Stored) -> None:
    publish(stored, "e1", 0)
    outcome = _outcome(stored, OK, BAD)
    answer = answer_of(outcome, conditions_of_run(load_campaign(stored.file), outcome))
    assert answer["workspace"] == str(stored.workspace.root)
    assert (answer["run"], answer["stages"]) == ("run-1", {"computed": 7, "cached": 3})
    assert [(epoch["epoch"], epoch["state"]) for epoch in answer["epochs"]] == [
        ("e1", "ok"),
        ("e2", "degraded"),
    ]
    assert answer["epochs"][1]["errors"] == ["station ST02: no such file"]


@pytest.mark.parametrize(("all_epochs", "titles"), [(False, ["e2"]), (True, ["e1", "e2"])])
def test_tables_are_those_of_the_newest_epoch_unless_all_are_wanted(
    capsys: pytest.CaptureFixture[str], stored: Stored, all_epochs: bool, titles: list[str]
) -> None:
    publish(stored, "e1", 0)
    publish(stored, "e2", 1)
    outcome = _outcome(stored, OK, EpochOutcome("e2", "ok", (), bad_input=False))
    campaign = load_campaign(stored.file)
    tell_results(campaign, outcome, conditions_of_run(campaign, outcome), all_epochs=all_epochs)
    out = capsys.readouterr().out
    assert out.splitlines()[0].startswith(
        "e1: ok, 920.8 ± 4.0 mm (k=2) at 102 m, towards 129.2° (A/paper), ok"
    )
    found = [line for line in out.splitlines() if line.startswith("Table 1.")]
    assert found == [f"Table 1. Fit of the axis, chimney-01, epoch {epoch}, method paper" for epoch in titles]
    assert "Table 3. Against the control F/paper, method paper" in out
    assert "run run-1: 7 stages computed, 3 cached" in out


def test_errors_name_epoch_and_reason(capsys: pytest.CaptureFixture[str]) -> None:
    tell_errors([OK, BAD, WEAK])
    expected = "error: e2: station ST02: no such file\nwarning: e2: no relative errors\n"
    assert capsys.readouterr().err == expected


def test_fault_of_an_epoch_leaves_its_traceback_in_a_file(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    tell_errors([FAULT])
    (log,) = tmp_path.glob("tiltwatch-*.log")
    assert f"error: e2: traceback in {log}" in capsys.readouterr().err
    assert "Traceback x" in log.read_text("utf-8")


@pytest.mark.parametrize(
    ("event", "line"),
    [
        (
            StageEvent("e1", "ingest ST01", "computed", 2.0, 1000),
            "e1 ingest ST01: computed in 2.0 s, 1,000 points, 500 points/s",
        ),
        (StageEvent("e1", "axis A/paper", "computed", 0.25), "e1 axis A/paper: computed in 0.2 s"),
        (StageEvent("e1", "ingest ST01", "cached", None, 1000), "e1 ingest ST01: cached"),
        (
            StageEvent("e1", "ingest ST01", "refused", None, None, "no points"),
            "e1 ingest ST01: refused: no points",
        ),
    ],
)
def test_stage_is_told_in_one_line(event: StageEvent, line: str) -> None:
    assert stage_line(event) == line


def test_progress_off_a_terminal_is_one_line_a_finished_stage(capsys: pytest.CaptureFixture[str]) -> None:
    with progress() as listen:
        listen(StageEvent("e1", "registration", "started"))
        listen(StageEvent("e1", "registration", "cached"))
    assert capsys.readouterr().err == "e1 registration: cached\n"


def test_quiet_progress_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    use_terminal(Terminal(quiet=True))
    try:
        with progress() as listen:
            listen(StageEvent("e1", "registration", "cached"))
    finally:
        use_terminal(Terminal())
    assert capsys.readouterr().err == ""


def test_progress_on_a_terminal_shows_the_stage_and_keeps_failures(monkeypatch: pytest.MonkeyPatch) -> None:
    class Screen(io.StringIO):
        def isatty(self) -> bool:
            return True

    screen = Screen()
    monkeypatch.setattr("sys.stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with progress() as listen:
        listen(StageEvent("e1", "registration", "started"))
        listen(StageEvent("e1", "registration", "computed", 1.0, 10))
        listen(StageEvent("e1", "axis F/paper", "refused", None, None, "needs at least 2 centres [got 0]"))
    assert "e1  done  1 computed, 1 refused, 10 points/s" in screen.getvalue()
    assert "axis F/paper: refused: needs at least 2 centres [got 0]" in screen.getvalue()


def test_run_of_a_bad_file_is_refused_before_anything_starts(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "campaign.toml").write_text("schema_version = 1\n", encoding="utf-8")
    called = call(capsys, "run", tmp_path / "campaign.toml", "--json")
    assert (called.code, called.answer["ok"], called.answer["exit_code"]) == (3, False, 3)
    assert "campaign.toml: structure: is required" in called.err
    assert not (tmp_path / "tiltwatch-data").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--epoch", "e9"], "error: unknown epoch 'e9'; known: e1, e2\n"),
        (["--scheme", "Z"], "error: unknown slicing scheme 'Z'; known: A, B, C, D, E, F, G, S\n"),
    ],
)
def test_run_of_an_unknown_name_lists_the_known(
    capsys: pytest.CaptureFixture[str], stored: Stored, words: list[str], message: str
) -> None:
    called = call(capsys, "run", stored.file, *words)
    # after the line that says what is being read
    assert (called.code, called.err.splitlines(keepends=True)[1:]) == (2, [message])


@pytest.mark.slow
def test_demo_finds_the_truth_and_the_second_run_computes_nothing(tmp_path: Path) -> None:
    words = [
        "demo",
        "--workspace",
        tmp_path / "ws",
        "--epochs",
        2,
        "--stations",
        3,
        "--points",
        30_000,
        "--json",
    ]
    first, second = call_process(*words), call_process(*words)
    assert first.code == 0, first.err
    found = json.loads(first.out)["found"]
    robust = [lean for lean in found["leans"] if (lean["scheme"], lean["method"]) == ("A", "robust")]
    assert [lean["epoch"] for lean in robust] == ["2025-01", "2025-04"]
    # 60 arcsec is 10 times the sigma of three stations: a wrong sign or frame is thousands
    assert max(lean["error_arcsec"] for lean in robust) < 60.0
    assert json.loads(second.out)["stages"]["computed"] == 0
