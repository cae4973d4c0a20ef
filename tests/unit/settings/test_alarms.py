"""The grammar of alarms is closed: what is not in it is refused with the way out, and secrets have no place in it."""

import typing
from dataclasses import fields
from pathlib import Path

import pytest

from storage.errors import InputError
from tasks.alarm_evaluation import rule_of
from tasks.alarms import RULES, SEVERITIES
from tasks.settings.alarms import COMMON_KEYS, DEFAULT_ALARMS, Alarm, AlarmTable, Severity
from tests.unit.settings.campaign_text import FEWEST, WHOLE, edited, load

EVERY_KIND = """
[[alarms]]
id = "limit"
when = "limit"
at_least = "cannot tell"
severity = "alarm"
notify = ["office", "desk", "siren"]
mute_hours_between = 12.0
[[alarms]]
id = "ahead"
when = "share-of-limit"
share = 0.8
[[alarms]]
id = "base"
when = "moved"
quantity = "base"
confirm = true
[[alarms]]
id = "fast"
when = "rate"
mm_per_year = 5.0
[[alarms]]
id = "soon"
when = "rate"
limit_within_years = 10.0
[[alarms]]
id = "drift"
when = "cusum"
signal = "watch"
severity = "info"
[[alarms]]
id = "seen"
when = "quality"
coverage_deg = 270.0
[[alarms]]
id = "few"
when = "quality"
stations = 4
[[alarms]]
id = "missed"
when = "missed-campaign"
interval_days = 182.0
grace_days = 14.0
[[alarms]]
id = "late"
when = "late-station"
hours = 6.0
[[notify]]
id = "office"
kind = "email"
url_env = "TILTWATCH_MAIL_URL"
[[notify]]
id = "desk"
kind = "webhook"
url_env = "TILTWATCH_DESK_URL"
[[notify]]
id = "siren"
kind = "command"
command = ["./siren", "--loud"]
timeout_s = 10.0
"""

ALARM = '[[alarms]]\nid = "a"\n'
TARGET = '[[notify]]\nid = "t"\n'
HEARS = '[[alarms]]\nid = "a"\nwhen = "moved"\nnotify = ["t"]\n'

FAULTS = [
    (
        ALARM,
        "alarms[a].when: is required; known: limit, share-of-limit, moved, rate, cusum, quality, missed-",
    ),
    (ALARM + 'when = "movd"', "alarms[a].when: 'movd' is not known; did you mean 'moved'?"),
    ('[[alarms]]\nwhen = "moved"', "alarms[#1].id: is required; meaning: name of the rule"),
    (
        ALARM + 'when = "moved"\nsignal = "watch"',
        "alarms[a].signal: unknown key; known: id, severity, notify",
    ),
    (ALARM + 'when = "moved"\nconfrm = true', "alarms[a].confrm: unknown key; did you mean 'confirm'?"),
    (
        ALARM + 'when = "moved"\np = 0.0',
        "alarms[a].p: should be greater than 0, got 0.0; meaning: probability",
    ),
    (ALARM + 'when = "moved"\np = "1 %"', "alarms[a].p: needs a number, got '1 %'"),
    (ALARM + 'when = "moved"\nquantity = "top"', "alarms[a].quantity: should be 'lean', 'base', 'bending'"),
    (
        ALARM + 'when = "moved"\nseverity = "bad"',
        "alarms[a].severity: should be 'info', 'warning' or 'alarm'",
    ),
    (ALARM + 'when = "moved"\nclear_ratio = 1.1', "alarms[a].clear_ratio: should be less than or equal to 1"),
    (ALARM + 'when = "missed-campaign"', "alarms[a].interval_days: is required; meaning: time between two"),
    (ALARM + 'when = "late-station"\nhours = 0.0', "alarms[a].hours: should be greater than 0"),
    (
        ALARM + 'when = "rate"',
        "alarms[a]: needs one of mm_per_year, limit_within_years, got none; write one [[al",
    ),
    (
        ALARM + 'when = "quality"\nstations = 3\nsigma_mm = 2.0',
        "alarms[a]: needs one of state, sigma_mm, coverage_deg, stations, got sigma_mm and stations",
    ),
    (
        ALARM + 'when = "limit"',
        "alarms[a]: judges by a limit, and the campaign has none; add a [limits] table",
    ),
    (
        ALARM + 'when = "rate"\nlimit_within_years = 5.0',
        "alarms[a]: judges by a limit, and the campaign has none",
    ),
    (
        f'{ALARM}when = "moved"\n{ALARM}when = "cusum"',
        "alarms[#2 a].id: id of a rule 'a' is taken by alarms[#1 a].id; choose another",
    ),
    (
        ALARM + 'when = "moved"\nnotify = ["x"]',
        "alarms[a].notify: unknown target 'x'; add a [[notify]] table",
    ),
    (
        f'{HEARS}{TARGET}kind = "command"\ncommand = ["a"]\n[[alarms]]\nid = "b"\nwhen = "cusum"\nnotify = ["tt"]',
        "alarms[b].notify: unknown target 'tt'; did you mean 't'?",
    ),
    (
        f'{TARGET}kind = "command"\ncommand = ["a"]',
        "notify[t]: is named by no rule, and would never hear of anything",
    ),
    (
        f'{HEARS}{TARGET}kind = "pigeon"',
        "notify[t].kind: 'pigeon' is not known; known: email, webhook, command",
    ),
    (
        f'{HEARS}{TARGET}kind = "email"\nurl = "mailto://me:secret@host"',
        "notify[t].url: unknown key; did you mean 'url_env'?",
    ),
    (
        f'{HEARS}{TARGET}kind = "email"\nurl_env = "mailto://me:secret@host"',
        "notify[t].url_env: needs the name of an environment variable, and got something else that is not shown",
    ),
    (
        f'{HEARS}{TARGET}kind = "command"\ncommand = []',
        "notify[t].command: names no program; write command = [",
    ),
    (
        f'{HEARS}{TARGET}kind = "command"\ncommand = "a b"',
        "notify[t].command: needs an array, got 'a b'; meaning:",
    ),
    (
        f'{HEARS}{TARGET}kind = "command"\ncommand = ["a"]\n{TARGET}kind = "command"\ncommand = ["b"]',
        "notify[#2 t].id: id of a target 't' is taken by notify[#1 t].id; choose another",
    ),
    ("[alarms]\nwhen = 1", "alarms: needs an array, got a table"),
]


def test_every_kind_of_rule_and_target_is_read(tmp_path: Path) -> None:
    campaign = load(tmp_path, WHOLE + EVERY_KIND)
    assert {rule.when for rule in campaign.alarm_rules} == set(RULES)
    assert [target.kind for target in campaign.notify] == ["email", "webhook", "command"]


@pytest.mark.parametrize(("text", "message"), FAULTS)
def test_what_is_not_in_the_grammar_is_refused_with_a_way_out(
    tmp_path: Path, text: str, message: str
) -> None:
    with pytest.raises(InputError) as caught:
        load(tmp_path, f"{FEWEST}{text}\n")
    assert message in str(caught.value)
    assert "secret" not in str(caught.value)


def test_a_rule_by_the_limit_is_fine_where_there_is_one(tmp_path: Path) -> None:
    assert load(tmp_path, f'{WHOLE}{ALARM}when = "limit"\n').alarms


def test_keys_of_the_tables_are_those_of_the_rules() -> None:
    tables = typing.get_args(typing.get_args(Alarm)[0])
    assert {typing.get_args(t.model_fields["when"].annotation)[0] for t in tables} == set(RULES)
    for table in tables:
        (name,) = typing.get_args(table.model_fields["when"].annotation)
        assert set(table.model_fields) - COMMON_KEYS == {field.name for field in fields(RULES[name].rule)}, (
            name
        )
    assert set(AlarmTable.model_fields) | {"when"} == COMMON_KEYS
    assert typing.get_args(Severity) == SEVERITIES


def test_without_rules_those_of_the_manual_hold_and_nobody_is_told(tmp_path: Path) -> None:
    campaign = load(tmp_path, FEWEST)
    assert campaign.alarm_rules == DEFAULT_ALARMS
    assert [(rule.id, rule.severity) for rule in DEFAULT_ALARMS] == [
        ("moved-5pct", "info"),
        ("moved-1pct", "warning"),
        ("moved-confirmed", "alarm"),
        ("cusum-watch", "warning"),
        ("cusum-alarm", "alarm"),
        ("limit", "alarm"),
        ("quality", "info"),
    ]
    assert all(rule.notify == () for rule in DEFAULT_ALARMS)
    assert all(rule_of(rule) for rule in DEFAULT_ALARMS)


def test_an_empty_list_means_no_rules(tmp_path: Path) -> None:
    assert (
        load(tmp_path, edited("schema_version = 1\n", "schema_version = 1\nalarms = []\n")).alarm_rules == ()
    )
