"""Small simulated campaigns for the tests of flows, and how to run them."""

import json
from collections.abc import Sequence
from pathlib import Path

from flows.ledger import StageEvent
from flows.outcome import EpochOutcome, RunOutcome
from flows.run_campaign import RunRequest, run_campaign
from storage.parquet import read_rows
from storage.records import TABLES, StageRunRow
from storage.tables import table_path
from storage.workspace import Workspace
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign

STRUCTURE = "demo-chimney"


def small_campaign(folder: Path, epochs: int = 1, stations: int = 3, points: int = 40_000) -> Path:
    """Simulate a small campaign; gives its campaign file."""
    request = SimulatedCampaignRequest(epochs=epochs, stations=stations, points=points, seed=1)
    return write_simulated_campaign(folder, request)


def run(
    campaign_file: Path, workspace: Path, *, epochs: Sequence[str] = (), schemes: Sequence[str] = ()
) -> RunOutcome:
    """Run a campaign quietly."""
    return run_campaign(RunRequest(campaign_file, workspace, tuple(epochs), tuple(schemes)), ignore)


def ignore(_event: StageEvent) -> None:
    """Listen to no stage."""


def computed_stages(outcome: RunOutcome) -> set[str]:
    """Labels of the stages that a run computed."""
    return {row.stage for row in stage_rows(outcome) if row.state == "computed"}


def stage_rows(outcome: RunOutcome) -> list[StageRunRow]:
    """What the ledger says of a run; nothing of one that asked for no stage."""
    path = table_path(Workspace(outcome.workspace), "runs", STRUCTURE, outcome.run)
    if not path.exists():
        return []
    return list(read_rows(path, "runs", StageRunRow))


def rows(workspace: Path, table: str, epoch: str) -> list:  # type: ignore[type-arg]
    """Published rows of an epoch."""
    return list(read_rows(table_path(Workspace(workspace), table, STRUCTURE, epoch), table, TABLES[table]))


def only_epoch(outcome: RunOutcome) -> EpochOutcome:
    """The epoch of a run of one."""
    (epoch,) = outcome.epochs
    return epoch


def replace_text(path: Path, old: str, new: str, count: int = -1) -> None:
    """Edit a file; the text must be there."""
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{path} holds no {old!r}"
    path.write_text(text.replace(old, new, count), encoding="utf-8")


def truth_of(campaign_file: Path, epoch: str) -> dict:  # type: ignore[type-arg]
    """What the simulation knows of an epoch."""
    return json.loads((campaign_file.parent / epoch / "truth.json").read_text(encoding="utf-8"))
