"""What must hold between [[alarms]], [[notify]] and the rest of a campaign file."""

from collections.abc import Iterator

from tasks.settings.alarms import Alarm, LimitAlarm, RateAlarm, ShareOfLimitAlarm
from tasks.settings.campaign import Campaign
from tasks.settings.limits import Limits
from tasks.settings.problems import Problem, nearest


def problems_of_alarms(campaign: Campaign) -> Iterator[Problem]:
    """List rules that name unknown targets, targets that no rule names, and rules that could never speak up."""
    yield from _targets(campaign)
    without_limit = campaign.limits == Limits()
    for rule in campaign.alarms or ():
        if without_limit and _needs_a_limit(rule):
            yield Problem(
                f"alarms[{rule.id}]",
                "judges by a limit, and the campaign has none",
                "add a [limits] table, or drop the rule",
            )


def _targets(campaign: Campaign) -> Iterator[Problem]:
    known = [target.id for target in campaign.notify]
    named = set()
    for rule in campaign.alarms or ():
        for name in rule.notify:
            named.add(name)
            if name not in known:
                hint = nearest(name, known) if known else "add a [[notify]] table with that id"
                yield Problem(f"alarms[{rule.id}].notify", f"unknown target {name!r}", hint)
    for name in known:
        if name not in named:
            yield Problem(
                f"notify[{name}]",
                "is named by no rule, and would never hear of anything",
                f'add notify = ["{name}"] to the [[alarms]] tables that it shall hear of',
            )


def _needs_a_limit(rule: Alarm) -> bool:
    if isinstance(rule, RateAlarm):
        return rule.limit_within_years is not None
    return isinstance(rule, LimitAlarm | ShareOfLimitAlarm)
