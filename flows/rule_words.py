"""The rules of alarms of a campaign in words, for the dashboard."""

from dashboard.rule import RuleWords
from tasks.alarms import RULES
from tasks.settings import Campaign
from tasks.settings.alarms import COMMON_KEYS, Alarm


def rule_words(campaign: Campaign) -> tuple[RuleWords, ...]:
    """Say what each rule looks for, with which figures, and what to do when it is broken."""
    return tuple(_words(rule) for rule in campaign.alarm_rules)


def _words(rule: Alarm) -> RuleWords:
    kind = RULES[rule.when]
    own = {key: value for key, value in rule.model_dump().items() if key not in COMMON_KEYS}
    settings = ", ".join(f"{key} = {_written(value)}" for key, value in own.items() if value is not None)
    return RuleWords(rule.id, rule.when, rule.severity, kind.description, settings, kind.advice)


def _written(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value).lower()
