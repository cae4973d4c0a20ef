"""Alarms: what rules find in the record of a structure, and what becomes of it until a person has closed it.

A kind of rule is one file of this folder that defines ``KIND``; it is found by itself.
"""

from typing import Final

from tasks.alarms.by_hand import DEEDS, objection
from tasks.alarms.deliveries import Message, Subscription, due_messages
from tasks.alarms.history import FOUND, Alarm, alarms_of
from tasks.alarms.model import SEVERITIES, Finding, Point, Rule, RuleKind
from tasks.alarms.record import (
    Change,
    ChartPoint,
    Deviation,
    EpochState,
    PendingEpoch,
    Record,
    Trend,
)
from tasks.alarms.state_machine import Step, closing, follow_apart, follow_rule, settle, unmuting
from tasks.geometry.variants import discover

RULES: Final[dict[str, RuleKind]] = dict(sorted(discover(__name__, "KIND", RuleKind).items()))
"""The kinds of rules by name."""

__all__ = [
    "DEEDS",
    "FOUND",
    "RULES",
    "SEVERITIES",
    "Alarm",
    "Change",
    "ChartPoint",
    "Deviation",
    "EpochState",
    "Finding",
    "Message",
    "PendingEpoch",
    "Point",
    "Record",
    "Rule",
    "RuleKind",
    "Step",
    "Subscription",
    "Trend",
    "alarms_of",
    "closing",
    "due_messages",
    "follow_apart",
    "follow_rule",
    "objection",
    "settle",
    "unmuting",
]
