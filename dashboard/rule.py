"""What a rule of alarms says, in words: the campaign file has it, the catalog has not."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RuleWords:
    """A rule of a campaign file.

    ``means`` is what its kind looks for, ``settings`` its own figures as text, ``advice`` what to do when it is broken.
    """

    rule: str
    kind: str
    severity: str
    means: str
    settings: str
    advice: str
