"""Alarms reach a real mail server, a real web server and a program; each once, and again after a failure."""

import json
import os
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from flows.alarm_delivery import Alarmed, evaluate_and_deliver
from flows.alarm_events import tell_prefect
from flows.alarm_targets import Letter, send
from storage.views import alarm_event_rows
from tasks.alarm_deeds import Deed, act_on_alarm
from tasks.settings import load_campaign
from tasks.settings.notify import CommandTarget, EmailTarget, Notify, WebhookTarget
from tests.flows.alarm_receivers import Desk, Mailbox, free_port, http_server, mail_server
from tests.flows.stored_campaign import Stored, publish, stored_campaign

NOW = datetime(2026, 4, 1, 8, 0, tzinfo=UTC)
PASS = {"verdict": "pass", "allowable_m": 2.0, "verdict_reason": None}
FAIL = {"verdict": "fail", "allowable_m": 0.0605, "verdict_reason": None}

RULE = '[[alarms]]\nid = "limit"\nwhen = "limit"\nseverity = "alarm"\nnotify = ["to"]\n'
MAIL = '[[notify]]\nid = "to"\nkind = "email"\nurl_env = "TEST_URL"\n'
HOOK = '[[notify]]\nid = "to"\nkind = "webhook"\nurl_env = "TEST_URL"\n'


def command(*words: str, timeout_s: float = 30.0) -> str:
    return (
        f'[[notify]]\nid = "to"\nkind = "command"\ncommand = {json.dumps(words)}\ntimeout_s = {timeout_s}\n'
    )


MAIL_TARGET = EmailTarget(id="to", kind="email", url_env="TEST_URL")
HOOK_TARGET = WebhookTarget(id="to", kind="webhook", url_env="TEST_URL")
LETTER = Letter(title="t", body="b", severity="alarm", is_over=False, facts={"alarm": "limit-e1"})


@pytest.fixture
def stored(tmp_path: Path) -> Stored:
    return stored_campaign(tmp_path)


def tell(stored: Stored, *tables: str) -> None:
    """Add tables to the campaign file."""
    with stored.file.open("a", encoding="utf-8") as file:
        file.write("".join(tables))


def alarmed(stored: Stored, now: datetime = NOW) -> Alarmed:
    return evaluate_and_deliver(stored.workspace, load_campaign(stored.file), now)


def logged(stored: Stored) -> list[tuple[str, str | None]]:
    return [(row.action, row.target) for row in alarm_event_rows(stored.workspace, "chimney-01")]


def test_a_mail_says_what_was_found_what_to_do_and_where(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    with mail_server() as box:
        monkeypatch.setenv("TEST_URL", mail_url(box))
        tell(stored, RULE, MAIL)
        publish(stored, "e1", 0, FAIL)
        assert alarmed(stored).failures == ()
    (mail,) = box.mails
    assert mail["Subject"] == "ALARM chimney-01: limit raised (epoch e1)"
    assert mail["To"] == "office@example.org"
    text = mail.get_body(("plain", "html")).get_content()
    for words in (
        "Structure: Heritage chimney (chimney-01)",
        "Epoch: e1, measured 2025-03-13 22:00 UTC",
        "Rule: limit (the deviation is beyond the allowable one",
        "Found: the deviation is 920.8 mm ± 4.0 mm (k=2), the allowable one 60.5 mm: verdict fail",
        "Value: 920.8 mm, limit 60.5 mm",
        "What to do: Check that the epoch is sound",
        "tiltwatch acknowledge FILE limit-e1 --name YOU --note WHY",
    ):
        assert words in text
    assert logged(stored) == [("raised", None), ("delivered", "to")]


def test_each_event_is_delivered_once(stored: Stored, monkeypatch: pytest.MonkeyPatch) -> None:
    with mail_server() as box:
        monkeypatch.setenv("TEST_URL", mail_url(box))
        tell(stored, RULE, MAIL)
        publish(stored, "e1", 0, FAIL)
        for hour in range(3):
            alarmed(stored, NOW + timedelta(hours=hour))
        assert len(box.mails) == 1
        publish(stored, "e2", 1, PASS)
        assert alarmed(stored, NOW + timedelta(days=1)).failures == ()
        assert [mail["Subject"] for mail in box.mails][1:] == ["ALARM chimney-01: limit eased (epoch e2)"]


def test_a_refused_mail_is_sent_on_a_later_run(stored: Stored, monkeypatch: pytest.MonkeyPatch) -> None:
    with mail_server() as box:
        monkeypatch.setenv("TEST_URL", mail_url(box))
        tell(stored, RULE, MAIL)
        publish(stored, "e1", 0, FAIL)
        box.answer = "451 later"
        assert len(alarmed(stored).failures) == 1
        box.answer = "250 taken"
        assert alarmed(stored, NOW + timedelta(seconds=30)).sent == ()
        assert alarmed(stored, NOW + timedelta(seconds=90)).failures == ()
        assert len(box.mails) == 1
    assert logged(stored) == [("raised", None), ("delivery failed", "to"), ("delivered", "to")]


@pytest.mark.filterwarnings("ignore:Requiring AUTH while not requiring TLS")
def test_a_login_is_used_and_no_secret_gets_into_the_log(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    tell(stored, RULE, MAIL)
    publish(stored, "e1", 0, FAIL)
    with mail_server(with_login=True) as box:
        monkeypatch.setenv("TEST_URL", mail_url(box, "bell:wr0ng-word@"))
        (failure,) = alarmed(stored).failures
        monkeypatch.setenv("TEST_URL", mail_url(box, "bell:s3cret-word@"))
        assert alarmed(stored, NOW + timedelta(hours=1)).failures == ()
    assert len(box.mails) == 1
    assert box.logins[-1] == ("bell", "s3cret-word")
    assert failure.startswith("limit-e1 to to: ")
    for secret in ("wr0ng-word", "s3cret-word"):
        assert all(secret not in path.read_bytes().decode("latin-1") for path in files_of(stored))


def test_a_web_service_gets_the_text_and_the_event_as_fields(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    with http_server() as desk:
        monkeypatch.setenv("TEST_URL", hook_url(desk))
        tell(stored, RULE, HOOK)
        publish(stored, "e1", 0, FAIL)
        assert alarmed(stored).failures == ()
    (post,) = desk.posts
    assert post["title"] == "ALARM chimney-01: limit raised (epoch e1)"
    assert "What to do: " in post["message"]
    assert (post["alarm"], post["rule"], post["severity"], post["action"], post["unit"]) == (
        "limit-e1",
        "limit",
        "alarm",
        "raised",
        "m",
    )
    assert float(post["value"]) == pytest.approx(0.92077, abs=1e-5)


@pytest.mark.parametrize("status", [404, 500])
def test_a_web_service_that_fails_is_told_with_its_answer(
    monkeypatch: pytest.MonkeyPatch, status: int
) -> None:
    with http_server() as desk:
        monkeypatch.setenv("TEST_URL", hook_url(desk))
        desk.status = status
        assert str(status) in (send(HOOK_TARGET, LETTER, Path()) or "")


@pytest.mark.parametrize(
    ("target", "url", "reason"),
    [
        (MAIL_TARGET, None, "the environment variable TEST_URL is not set"),
        (
            MAIL_TARGET,
            "json://127.0.0.1/x",
            "the environment variable TEST_URL holds no mailto:// or mailtos:// URL",
        ),
        (HOOK_TARGET, "nonsense", "the environment variable TEST_URL holds no URL that apprise understands"),
        (HOOK_TARGET, "json://127.0.0.1:{port}/t0ken", "A Connection error occurred"),
    ],
)
def test_a_target_that_cannot_be_reached_is_told_without_secrets(
    monkeypatch: pytest.MonkeyPatch, target: Notify, url: str | None, reason: str
) -> None:
    if url is None:
        monkeypatch.delenv("TEST_URL", raising=False)
    else:
        monkeypatch.setenv("TEST_URL", url.format(port=free_port()))
    failure = send(target, LETTER, Path()) or ""
    assert reason in failure
    assert "t0ken" not in failure


def test_a_dead_target_costs_its_time_limit_once_a_run(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("TEST_URL", raising=False)
    tell(stored, RULE, RULE.replace('"limit"\nwhen', '"again"\nwhen'), MAIL)
    publish(stored, "e1", 0, FAIL)
    found = alarmed(stored)
    assert (len(found.events), len(found.failures)) == (2, 1)
    assert len(alarmed(stored, NOW + timedelta(seconds=1)).failures) == 1


SAVE = "import sys, pathlib; pathlib.Path('got.json').write_text(sys.stdin.read())"


def test_a_command_gets_the_event_on_stdin_in_the_folder_of_the_campaign(stored: Stored) -> None:
    tell(stored, RULE, command(sys.executable, "-c", SAVE))
    publish(stored, "e1", 0, FAIL)
    assert alarmed(stored).failures == ()
    got = json.loads((stored.file.parent / "got.json").read_text())
    assert (got["alarm"], got["epoch"], got["severity"], got["unit"]) == ("limit-e1", "e1", "alarm", "m")
    assert got["happened_at"] == "2026-04-01T08:00:00+00:00"
    assert got["text"].startswith("Structure: Heritage chimney")


@pytest.mark.parametrize(
    ("words", "timeout_s", "reason"),
    [
        ((sys.executable, "-c", "import sys; sys.exit('no paper')"), 30.0, "ended with 1: no paper"),
        (("no-such-program-here",), 30.0, "no-such-program-here cannot be started: No such file"),
        ((sys.executable, "-c", "import time; time.sleep(60)"), 0.5, "took longer than 0.5 s and was ended"),
        (("sh", "-c", "sleep 60 & sleep 60"), 0.5, "took longer than 0.5 s and was ended"),
        (("true", "; touch shell-was-here"), 30.0, ""),
    ],
    ids=["fails", "is not there", "hangs", "leaves children", "is no shell"],
)
def test_a_command_that_fails_is_told(
    tmp_path: Path, words: tuple[str, ...], timeout_s: float, reason: str
) -> None:
    target = CommandTarget(id="to", kind="command", command=words, timeout_s=timeout_s)
    assert reason in (send(target, LETTER, tmp_path) or "")
    assert list(tmp_path.iterdir()) == []


def test_what_is_muted_is_not_sent_and_told_when_the_time_is_over(stored: Stored) -> None:
    tell(stored, RULE, command(sys.executable, "-c", SAVE))
    publish(stored, "e1", 0, PASS)
    publish(stored, "e2", 1, FAIL)
    tell_nobody = load_campaign(stored.file).model_copy(update={"notify": ()})
    evaluate_and_deliver(stored.workspace, tell_nobody, NOW)
    mute = Deed(action="muted", person="Ann", until=NOW + timedelta(days=1))
    act_on_alarm(stored.workspace, "chimney-01", "limit-e2", mute, NOW + timedelta(minutes=1))
    assert alarmed(stored, NOW + timedelta(hours=1)).sent == ()
    found = alarmed(stored, NOW + timedelta(days=1, hours=1))
    assert [event.action for event in found.events] == ["unmuted"]
    assert [event.action for event in found.sent] == ["delivered"]
    got = json.loads((stored.file.parent / "got.json").read_text())
    assert got["title"] == "ALARM chimney-01: limit not muted any more, and still there (epoch e2)"
    assert "Found: the deviation is" in got["text"]


def test_prefect_is_told_nothing_where_no_server_is_named(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PREFECT_API_URL", raising=False)
    publish(stored, "e1", 0, FAIL)
    assert tell_prefect(alarmed(stored).events) == 0


def test_prefect_is_at_home_in_the_workspace_when_it_is_told_of_alarms(
    stored: Stored, monkeypatch: pytest.MonkeyPatch
) -> None:
    # what is set on the way is taken back with the rest
    for name in ("PREFECT_HOME", "DO_NOT_TRACK", "PREFECT_LOGGING_LEVEL", "RAY_USAGE_STATS_ENABLED"):
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setenv("PREFECT_API_URL", "http://127.0.0.1:9/api")
    homes: list[str] = []
    monkeypatch.setattr(
        "flows.alarm_delivery.tell_prefect", lambda _rows: homes.append(os.environ.get("PREFECT_HOME", ""))
    )
    publish(stored, "e1", 0, FAIL)
    assert alarmed(stored).events
    assert Path(homes[0]).parent == stored.workspace.prefect


def mail_url(box: Mailbox, login: str = "") -> str:
    return (
        f"mailto://{login}127.0.0.1:{box.port}?from=tiltwatch@example.org&to=office@example.org&mode=insecure"
    )


def hook_url(desk: Desk) -> str:
    return f"json://127.0.0.1:{desk.port}/alarms"


def files_of(stored: Stored) -> list[Path]:
    return [Path(folder) / name for folder, _, names in os.walk(stored.workspace.root) for name in names]
