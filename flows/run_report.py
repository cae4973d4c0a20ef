"""What a run tells when it ends: a line an epoch, the tables of the paper, and the exit code."""

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Final

from flows.condition_text import EXIT_CODES, facts_of, summary_of
from flows.faults import keep_log
from flows.outcome import EpochOutcome, RunOutcome
from flows.terminal import Json, complain, say
from storage.views.condition import Condition, Level, conditions
from storage.workspace import Workspace
from tasks.reporting import epoch_tables_text
from tasks.settings import Campaign

FAULT: Final = 1
BAD_INPUT: Final = 3

LOWEST_LEVEL: Final = {"quality": Level.QUALITY, "warning": Level.WARNING, "alarm": Level.ALARM}
"""From which level on ``--fail-on`` counts."""


def conditions_of_run(campaign: Campaign, outcome: RunOutcome) -> list[Condition]:
    """State of the epochs of a run, the earliest first."""
    ran = {epoch.epoch for epoch in outcome.epochs}
    found = conditions(Workspace(outcome.workspace), campaign.structure.id, campaign.report.primary)
    return [condition for condition in found if condition.epoch.epoch in ran]


def exit_code_of(epochs: Sequence[EpochOutcome], found: Sequence[Condition], fail_on: str | None) -> int:
    """Exit code of a run: 1 for a fault of the program, 3 for bad input, else what ``--fail-on`` asks for."""
    if any(epoch.fault for epoch in epochs):
        return FAULT
    if any(epoch.bad_input for epoch in epochs):
        return BAD_INPUT
    if fail_on is None:
        return 0
    without_result = Level.QUALITY if any(epoch.state != "ok" for epoch in epochs) else Level.OK
    worst = max([without_result, *(condition.level for condition in found)])
    return EXIT_CODES[worst] if worst >= LOWEST_LEVEL[fail_on] else 0


def tell_errors(epochs: Sequence[EpochOutcome]) -> None:
    """Say on stderr what went wrong in which epoch; tracebacks go to a log file."""
    for epoch in epochs:
        grave = epoch.bad_input or epoch.fault or epoch.state == "failed"
        complain(*(f"{'error' if grave else 'warning'}: {epoch.epoch}: {reason}" for reason in epoch.reasons))
        complain(*(f"note: {epoch.epoch}: {note}" for note in epoch.notes))
        if epoch.fault:
            complain(f"error: {epoch.epoch}: traceback in {keep_log(epoch.fault)}")


def tell_results(
    campaign: Campaign, outcome: RunOutcome, found: Sequence[Condition], *, all_epochs: bool
) -> None:
    """Print a line an epoch, and the tables of the newest epoch or of all."""
    say(*(summary_of(condition) for condition in found))
    place = Workspace(outcome.workspace)
    for condition in found if all_epochs else found[-1:]:
        say(*epoch_tables_text(place, campaign.structure.id, condition.epoch.epoch))
    say("", f"run {outcome.run}: {outcome.computed} stages computed, {outcome.cached} cached")
    say(f"results in {outcome.workspace}")


def answer_of(outcome: RunOutcome, found: Sequence[Condition]) -> dict[str, Json]:
    """Answer of a run for programs."""
    now = datetime.now(UTC)
    facts = {condition.epoch.epoch: facts_of(condition, now) for condition in found}
    return {
        "workspace": str(outcome.workspace),
        "run": outcome.run,
        "stages": {"computed": outcome.computed, "cached": outcome.cached},
        "epochs": [
            {
                **facts.get(epoch.epoch, {}),
                "epoch": epoch.epoch,
                "state": epoch.state,
                "errors": list(epoch.reasons),
                "notes": list(epoch.notes),
                "storage_fault": epoch.storage_fault,
            }
            for epoch in outcome.epochs
        ],
    }
