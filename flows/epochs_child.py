"""The process that a guarded run gives its epochs to: ``python -m flows.epochs_child``, the request on the last word.

It tells nobody but the journal of the run, which the parent reads along and a later run finds.
"""
# ruff: noqa: PLC0415 (heavy imports stand behind the tie to the parent)

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from flows.child_process import end_with_parent


@dataclass(frozen=True, slots=True)
class ChildRequest:
    """Which epochs of which run to process."""

    campaign_file: str
    workspace: str
    epochs: Sequence[str]
    schemes: Sequence[str]
    run: str
    structure: str
    scans: Mapping[str, str] = field(default_factory=dict)
    """Digests of the scans that the run has seen so far, and whose they were first."""

    def command(self) -> list[str]:
        """Command line of the child; its modules are those of this checkout, wherever it is started."""
        return [sys.executable, "-P", "-m", "flows.epochs_child", json.dumps(asdict(self))]


def main(words: Sequence[str]) -> None:
    """Process the epochs of a request; how each ended stands in the journal."""
    end_with_parent()
    request = ChildRequest(**json.loads(words[-1]))
    from prefect import tags

    from flows.epochs_loop import EpochsRequest, process_epochs
    from flows.flow_run_states import tag_of
    from flows.known_code import known_code
    from flows.ledger import RunLedger, current_ledger
    from flows.quiet_engine import quiet_engine
    from storage.presence import held_in_place
    from storage.run_record import journal_of
    from storage.workspace import Workspace
    from tasks.settings.intake import load_with_intake

    place = Workspace(Path(request.workspace))
    ledger = RunLedger(request.run, request.structure, lambda _event: None, scans=dict(request.scans))
    ledger.journal = journal_of(place, request.run)
    current_ledger.set(ledger)
    asked = EpochsRequest(
        request.campaign_file, request.workspace, tuple(request.epochs), tuple(request.schemes)
    )
    held = held_in_place(place.root)
    with held, known_code(place), tags(tag_of(request.run)), quiet_engine():
        process_epochs(asked, load_with_intake(Path(request.campaign_file), Path(request.workspace)), place)


if __name__ == "__main__":
    main(sys.argv)
