"""alarms, acknowledge, mute, unmute, close: what is listed, what is on record, and what status makes of it."""

import json
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from storage.alarm_log import append_alarm_event
from storage.errors import StorageError
from storage.records import AlarmEventRow
from storage.series import publish_series
from storage.views import alarm_event_rows, alarm_rows
from tasks.alarm_evaluation import PendingEpoch, evaluate_alarms
from tasks.settings import load_campaign
from tests.flows.alarm_receivers import http_server
from tests.flows.calls import ROOT, call
from tests.flows.stored_campaign import Stored, publish, publish_without_result, stored_campaign
from tests.flows.stored_series import change_test, chart_row, trend_row

PASS = {"verdict": "pass", "allowable_m": 2.0, "verdict_reason": None}
FAIL = {"verdict": "fail", "allowable_m": 0.0605, "verdict_reason": None}
NOW = datetime(2026, 4, 1, 8, 0, tzinfo=UTC)
LIMIT = '[[alarms]]\nid = "limit"\nwhen = "limit"\nseverity = "alarm"\n'
MISSED = '[[alarms]]\nid = "missed"\nwhen = "missed-campaign"\ninterval_days = 30.0\n'
LATE = '[[alarms]]\nid = "late"\nwhen = "late-station"\nhours = 6.0\n'


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    return stored_campaign(tmp_path)


def rules(stored: Stored, *tables: str) -> None:
    with stored.file.open("a", encoding="utf-8") as file:
        file.write("".join(tables))


def evaluate(
    stored: Stored, now: datetime = NOW, pending: tuple[PendingEpoch, ...] | None = None
) -> list[str]:
    added = evaluate_alarms(stored.workspace, load_campaign(stored.file), now, pending)
    return [f"{row.action} {row.alarm}" for row in added]


def test_rules_of_the_manual_hold_where_the_file_names_none(stored: Stored) -> None:
    publish(stored, "e1", 0, FAIL)
    publish(stored, "e2", 1, FAIL, moved_m=0.05)
    assert sorted(evaluate(stored)) == [
        "raised limit-e1",
        "raised moved-1pct-e2",
        "raised moved-5pct-e2",
    ]
    publish(stored, "e3", 2, FAIL, moved_m=0.05)
    assert "raised moved-confirmed-e3" in evaluate(stored)
    assert evaluate(stored, NOW + timedelta(days=100)) == []


def test_series_of_the_structure_raise_alarms_too(stored: Stored) -> None:
    rate = '[[alarms]]\nid = "fast"\nwhen = "rate"\nmm_per_year = 4.0\n'
    cusum = '[[alarms]]\nid = "drift"\nwhen = "cusum"\n'
    base = '[[alarms]]\nid = "base"\nwhen = "moved"\nquantity = "base"\np = 0.05\n'
    rules(stored, rate, cusum, base)
    for number in range(2):
        publish(stored, f"e{number + 1}", number, PASS)
    series = {"trends": [trend_row("e2")], "control_chart": [chart_row("e2", 5.5)]}
    publish_series(
        stored.workspace, "chimney-01", {**series, "change_tests": [change_test("e2", "base", 0.02)]}
    )
    assert sorted(evaluate(stored)) == ["raised base-e2", "raised drift-e2", "raised fast-e2"]
    publish_series(
        stored.workspace, "chimney-01", {**series, "change_tests": [change_test("e2", "base", 0.6)]}
    )
    assert evaluate(stored) == ["closed base-e2"]


def test_a_missed_campaign_is_found_without_a_run_and_counts_for_the_newest_epoch(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    rules(stored, MISSED)
    publish(stored, "e1", 0, PASS)
    assert call(capsys, "status", stored.file).code == 0
    called = call(capsys, "alarms", stored.file, "--evaluate", "--json")
    assert called.code == 5
    (alarm,) = called.answer["alarms"]
    assert (alarm["alarm"], alarm["epoch"], alarm["unit"], alarm["state"]) == ("missed-e1", None, "d", "new")
    status = call(capsys, "status", stored.file)
    assert status.code == 5
    assert "  warning: rule missed: the newest epoch, e1, was measured" in status.out
    assert call(capsys, "alarms", stored.file, "--evaluate").err.startswith("0 events added")


def test_a_new_epoch_eases_a_missed_campaign(stored: Stored) -> None:
    rules(stored, MISSED)
    publish(stored, "e1", 0, PASS)
    assert evaluate(stored, datetime(2025, 5, 1, tzinfo=UTC)) == ["raised missed-e1"]
    publish(stored, "e2", 1, PASS)
    assert evaluate(stored, datetime(2026, 3, 20, tzinfo=UTC)) == ["eased missed-e1"]


def test_a_late_station_is_an_alarm_of_its_epoch_until_it_arrives(stored: Stored) -> None:
    rules(stored, LATE)
    publish(stored, "e1", 0, PASS)
    waiting = PendingEpoch(epoch="e2", first_arrival=NOW, missing=("ST02",))
    assert evaluate(stored, NOW + timedelta(hours=5), (waiting,)) == []
    assert evaluate(stored, NOW + timedelta(hours=7), (waiting,)) == ["raised late-e2"]
    assert evaluate(stored, NOW + timedelta(hours=8)) == []  # a run that does not look into the inbox
    publish(stored, "e2", 1, PASS)
    assert evaluate(stored, NOW + timedelta(hours=9)) == ["eased late-e2"]


def test_a_degraded_epoch_is_still_a_matter_of_quality_under_the_rules_of_the_manual(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    publish_without_result(stored, "e1", 0, state="failed", reason="no scan of the epoch could be read")
    called = call(capsys, "alarms", stored.file, "--evaluate")
    assert called.code == 0
    assert "info    new  quality-e1" in called.out
    assert "the epoch is failed: no scan of the epoch could be read" in called.out
    assert call(capsys, "status", stored.file).code == 4


def test_an_acknowledged_alarm_still_counts_and_a_muted_one_does_not(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    rules(stored, MISSED)
    publish(stored, "e1", 0, PASS)
    call(capsys, "alarms", stored.file, "--evaluate")
    called = call(
        capsys, "acknowledge", stored.file, "missed-e1", "--name", "Ann", "--note", "crew is on its way"
    )
    assert called.code == 0
    assert called.out.splitlines()[1] == "        by Ann: crew is on its way"
    assert call(capsys, "status", stored.file).code == 5
    answer = call(capsys, "mute", stored.file, "missed-e1", "--name", "Ann", "--days", "3", "--json").answer
    assert (answer["alarm"]["state"], answer["alarm"]["person"]) == ("muted", "Ann")
    assert call(capsys, "status", stored.file).code == 0
    assert call(capsys, "alarms", stored.file).code == 0
    assert call(capsys, "unmute", stored.file, "missed-e1", "--name", "Bob").code == 0
    called = call(capsys, "alarms", stored.file)
    assert called.code == 5
    assert "acknowledged" in called.out


def test_a_closed_alarm_leaves_the_list_and_its_rule_speaks_at_the_next_epoch(
    capsys: pytest.CaptureFixture[str], stored: Stored
) -> None:
    rules(stored, LIMIT)
    publish(stored, "e1", 0, FAIL)
    assert call(capsys, "alarms", stored.file, "--evaluate").code == 6
    assert call(capsys, "close", stored.file, "limit-e1", "--name", "Ann", "--note", "design lean").code == 0
    called = call(capsys, "alarms", stored.file, "--evaluate")
    assert (called.code, called.out) == (0, "no open alarms; 1 closed (--all)\n")
    assert "by Ann: design lean" in call(capsys, "alarms", stored.file, "--all").out
    publish(stored, "e2", 1, FAIL)
    called = call(capsys, "alarms", stored.file, "--evaluate")
    assert called.code == 6
    assert "limit-e2" in called.out


def test_a_recomputed_epoch_closes_its_alarm(stored: Stored) -> None:
    rules(stored, LIMIT)
    publish(stored, "e1", 0, FAIL)
    assert evaluate(stored) == ["raised limit-e1"]
    publish(stored, "e1", 0, PASS)
    assert evaluate(stored) == ["closed limit-e1"]
    (alarm,) = alarm_rows(stored.workspace, "chimney-01")
    assert (alarm.state, alarm.person) == ("closed", None)
    assert (alarm.note or "").startswith(
        "the finding is gone: since e1 was computed anew, or the rule changed"
    )


def test_a_rule_that_was_taken_out_closes_its_alarms(stored: Stored) -> None:
    publish(stored, "e1", 0, FAIL)
    assert evaluate(stored) == ["raised limit-e1"]
    rules(stored, MISSED)
    assert evaluate(stored, datetime(2025, 3, 20, tzinfo=UTC)) == ["closed limit-e1"]


def test_a_mute_runs_out(stored: Stored, capsys: pytest.CaptureFixture[str]) -> None:
    rules(stored, LIMIT)
    publish(stored, "e1", 0, FAIL)
    evaluate(stored)
    called = call(capsys, "mute", stored.file, "limit-e1", "--name", "Ann", "--until", "2100-01-01")
    assert "muted until 2100-01-01 00:00 UTC" in called.out
    assert evaluate(stored, datetime(2099, 12, 31, tzinfo=UTC)) == []
    assert evaluate(stored, datetime(2100, 1, 2, tzinfo=UTC)) == ["unmuted limit-e1"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("acknowledge", "x", "--name", "A", "--note", "n"), "chimney-01 has no alarm 'x'; open: limit-e1"),
        (
            ("unmute", "limit-e1", "--name", "A"),
            "alarm 'limit-e1' is not muted; `tiltwatch alarms FILE --all`",
        ),
        (("close", "limit-e1", "--name", " ", "--note", "n"), "--name needs 1 to 2000 printable characters"),
        (("mute", "limit-e1", "--name", "A", "--until", "soon"), "--until needs a date or a time with its"),
        (
            ("mute", "limit-e1", "--name", "A", "--until", "2100-01-01T06:00"),
            "needs its offset from UTC; write",
        ),
        (
            ("mute", "limit-e1", "--name", "A", "--until", "2020-01-01"),
            "cannot be muted until 2020-01-01 00:00",
        ),
        (("mute", "limit-e1", "--name", "A", "--days", "-1"), "cannot be muted until"),
        (("mute", "limit-e1", "--name", "A", "--days", "1e12"), "--until needs a date or a time"),
        (
            ("mute", "limit-e1", "--name", "A", "--days", "1", "--until", "2100-01-01"),
            "say the same thing; write",
        ),
        (("acknowledge", "limit-e1", "--name", "A"), "--note"),
    ],
)
def test_wrong_words_are_answered_with_the_right_ones(
    capsys: pytest.CaptureFixture[str], listed: Stored, words: tuple[str, ...], message: str
) -> None:
    called = call(capsys, words[0], listed.file, *words[1:])
    assert called.code == 2
    assert message in called.err
    assert len(alarm_event_rows(listed.workspace, "chimney-01")) == 1


@pytest.fixture(scope="module")
def listed(tmp_path_factory: pytest.TempPathFactory) -> Stored:
    """A workspace with one alarm, which the tests of wrong words leave as it is."""
    made = stored_campaign(tmp_path_factory.mktemp("listed"))
    rules(made, LIMIT)
    publish(made, "e1", 0, FAIL)
    evaluate(made)
    return made


def test_two_processes_at_once_add_each_event_once(stored: Stored) -> None:
    publish(stored, "e1", 0, FAIL)
    publish(stored, "e2", 1, FAIL, moved_m=0.05)
    words = [sys.executable, "-m", "flows.cli", "alarms", str(stored.file), "--evaluate", "--json"]
    both = [
        subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE) for _ in range(2)
    ]
    answers = [json.loads(process.communicate(timeout=120)[0]) for process in both]
    assert [process.returncode for process in both] == [6, 6]
    assert [len(answer["alarms"]) for answer in answers] == [3, 3]
    raised = [row.alarm for row in alarm_event_rows(stored.workspace, "chimney-01")]
    assert sorted(raised) == sorted(set(raised))
    assert len(raised) == 3


def test_a_crash_between_two_events_is_made_good_by_the_next_evaluation(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    publish(stored, "e1", 0, FAIL)
    publish(stored, "e2", 1, FAIL, moved_m=0.05)
    written: list[AlarmEventRow] = []

    def stop_after_two(*arguments: object) -> None:
        if len(written) == 2:
            raise StorageError("no space left")
        append_alarm_event(*arguments)
        written.append(arguments[1])

    monkeypatch.setattr("storage.alarm_log.append_alarm_event", stop_after_two)
    with pytest.raises(StorageError, match="no space left"):
        evaluate(stored)
    monkeypatch.undo()
    added = evaluate(stored)
    assert len(added) == 1
    assert evaluate(stored) == []
    assert len({row.alarm for row in alarm_event_rows(stored.workspace, "chimney-01")}) == 3


def test_the_list_of_alarms_has_the_gravest_first(capsys: pytest.CaptureFixture[str], stored: Stored) -> None:
    publish(stored, "e1", 0, FAIL)
    publish(stored, "e2", 1, FAIL, moved_m=0.05)
    called = call(capsys, "alarms", stored.file, "--evaluate")
    assert [line.split()[0] for line in called.out.splitlines()] == ["alarm", "warning", "info"]


def test_a_trial_message_says_which_targets_take_it(
    capsys: pytest.CaptureFixture[str], stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert call(capsys, "alarms", str(stored.file), "--trial").code == 2
    rules(
        stored,
        LIMIT,
        'notify = ["desk", "bell"]\n',
        '[[notify]]\nid = "desk"\nkind = "webhook"\nurl_env = "DESK_URL"\n',
        '[[notify]]\nid = "bell"\nkind = "email"\nurl_env = "BELL_URL"\n',
    )
    monkeypatch.delenv("BELL_URL", raising=False)
    with http_server() as desk:
        monkeypatch.setenv("DESK_URL", f"json://127.0.0.1:{desk.port}/hook")
        tried = call(capsys, "alarms", str(stored.file), "--trial")
    assert tried.code == 3
    assert "desk: taken" in tried.out
    assert "bell: not taken: the environment variable BELL_URL is not set" in tried.out
    (post,) = desk.posts
    assert "trial" in post["title"]
    assert post["action"] == "trial"
    # no alarm: nothing is put into the log, and no workspace is needed
    assert not stored.workspace.catalog.exists()
