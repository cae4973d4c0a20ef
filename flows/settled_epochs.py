"""Which epochs of a campaign need no second look: so that epoch 101 costs what one epoch costs."""

import hashlib
import json
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

from flows.outcome import EpochOutcome
from storage.parquet import read_rows
from storage.records import EpochRow
from storage.settled import is_settled, settle
from storage.tables import table_path
from storage.workspace import Workspace
from tasks.settings import Campaign, Epoch

NO_RESULT: Final = {"alarms", "notify", "schedule", "execution", "files"}
"""Tables of the campaign file that change no result of an epoch."""


PACKAGES: Final = ("flows", "tasks", "storage")

ROOT: Final = Path(__file__).resolve().parents[1]


def settled_outcomes(place: Workspace, campaign: Campaign, epochs: Sequence[str]) -> dict[str, EpochOutcome]:
    """Epochs whose scans, settings and code did not change since they were published, with how they ended then."""
    found = {}
    for name in epochs:
        epoch = campaign.epoch(name)
        if epoch is not None and is_settled(place, *_key(campaign, epoch)):
            path = table_path(place, "epochs", campaign.structure.id, name)
            (row,) = read_rows(path, "epochs", EpochRow)
            reasons = () if row.reason is None else (row.reason,)
            notes = (f"unchanged since run {row.run}",)
            found[name] = EpochOutcome(name, row.state, reasons, bad_input=False, notes=notes)
    return found


def settle_epochs(place: Workspace, campaign: Campaign, outcomes: Sequence[EpochOutcome]) -> None:
    """Put down the epochs that ended without any fault or refusal.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    for outcome in outcomes:
        epoch = campaign.epoch(outcome.epoch)
        if epoch is not None and outcome.state == "ok" and not outcome.bad_input and outcome.fault is None:
            settle(place, *_key(campaign, epoch))


@lru_cache(maxsize=1)
def _program() -> str:
    """Digest of all sources of the program: whatever changed in it, the epochs are looked at once more."""
    digest = hashlib.sha256()
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*")):
            if path.suffix in (".py", ".sql"):
                digest.update(path.relative_to(ROOT).as_posix().encode() + b"\n" + path.read_bytes())
    return digest.hexdigest()


def _key(campaign: Campaign, epoch: Epoch) -> tuple[str, str, str, list[Path]]:
    """Structure, epoch, digest of all that the result follows from beside the scans, and the scans."""
    needed = {epoch.id, campaign.reference_epoch.id}
    settings = campaign.model_dump(mode="json", exclude=NO_RESULT)
    settings["epochs"] = [one for one in settings["epochs"] if one["id"] in needed]
    text = json.dumps([settings, _program()], sort_keys=True)
    scans = [campaign.scan_path(scan) for one in campaign.epochs if one.id in needed for scan in one.scans]
    return campaign.structure.id, epoch.id, hashlib.sha256(text.encode()).hexdigest(), scans
