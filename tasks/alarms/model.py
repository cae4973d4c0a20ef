"""What a rule of alarms is, and what it finds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from tasks.alarms.record import Record

SEVERITIES: Final = ("info", "warning", "alarm")
"""From the least to the gravest."""

GUARD_SIGMAS: Final = 2.0
"""Half-width of the band within which a rule does not decide, k = 2 as in the verdicts of limits."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What a rule found at one time.

    Neither ``broken`` nor ``eased``: the value lies between the two thresholds, and an alarm stays as it was.
    """

    value: float
    limit_value: float
    unit: str
    broken: bool
    eased: bool
    what: str
    falls: bool = False
    """Whether a smaller value is worse."""


@dataclass(frozen=True, slots=True)
class Point:
    """A time at which a rule is looked at; ``finding`` is None where nothing can be told."""

    place: str
    """Id of the epoch that the point belongs to: the newest where the rule is about the time since."""
    epoch: str | None
    """Id of the epoch that an alarm is about; None where it is about none."""
    finding: Finding | None
    by_clock: bool = False
    """Whether time changes the finding: when it is over, it was true before."""


class Rule(Protocol):
    """A rule with its thresholds."""

    def points(self, record: Record) -> Sequence[Point]:
        """What the rule finds, the earliest first."""


@dataclass(frozen=True, slots=True)
class RuleKind:
    """A kind of rule: ``[[alarms]]`` tables name it by ``when``."""

    name: str
    description: str
    advice: str
    """What to do next when it is broken."""
    rule: Callable[..., Rule]
    """The class of its rules; its fields are the keys of the table that are not those of every rule."""
    apart: bool = False
    """Whether each point stands for itself, so that several alarms of one rule may be active at once."""


def millimetres(metres: float) -> str:
    """A length for people."""
    return f"{1e3 * metres:.1f} mm"
