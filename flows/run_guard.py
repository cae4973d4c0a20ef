"""What guards an unattended run: how long an epoch may take, and how often it is tried again."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flows.outcome import EpochOutcome
from tasks.settings import Campaign


@dataclass(frozen=True, slots=True)
class RunGuard:
    """How long an epoch may take, and how often one that met a fault or its limit is tried again."""

    time_limit_s: float
    retries: int = 0
    retry_delay_s: float = 0.0


def guard_of(campaign: Campaign) -> RunGuard:
    """The guard that the campaign file asks for in [schedule]."""
    asked = campaign.schedule
    return RunGuard(asked.time_limit_s, asked.retries, asked.retry_delay_s)


def with_retries(
    process: Callable[[Sequence[str]], Sequence[EpochOutcome]], epochs: Sequence[str], guard: RunGuard
) -> list[EpochOutcome]:
    """Process epochs, and those that ended by a fault again.

    What was finished before the fault is found in the cache. Bad input is not tried again: it would be bad again.
    """
    outcomes = {outcome.epoch: outcome for outcome in process(epochs)}
    for _retry in range(guard.retries):
        again = [epoch for epoch in epochs if outcomes[epoch].fault]
        if not again:
            break
        time.sleep(guard.retry_delay_s)
        outcomes.update({outcome.epoch: outcome for outcome in process(again)})
    return [outcomes[epoch] for epoch in epochs]
