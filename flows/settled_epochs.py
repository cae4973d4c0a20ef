"""Which epochs of a campaign need no second look: so that epoch 101 costs what one epoch costs."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Final

from flows.outcome import EpochOutcome
from storage.errors import InputError
from storage.settled import settle, settled_by, stamps_of
from storage.verified import Stamp
from storage.workspace import Workspace
from tasks.code_version import library_versions
from tasks.settings import Campaign, Epoch

NO_RESULT: Final = {"alarms", "notify", "schedule", "execution", "files"}
"""Tables of the campaign file that change no result of an epoch."""

PACKAGES: Final = ("flows", "tasks", "storage")

ROOT: Final = Path(__file__).resolve().parents[1]


def chosen_epochs(campaign: Campaign, campaign_file: str, names: Sequence[str]) -> list[str]:
    """Epochs that are asked for, all where none is named, the earliest first.

    Raises
    ------
    InputError
        If one is not known.
    """
    known = [epoch.id for epoch in sorted(campaign.epochs, key=lambda epoch: epoch.time)]
    unknown = [name for name in names if name not in known]
    if unknown:
        raise InputError(f"{campaign_file}: no epoch {unknown[0]!r}; known: {', '.join(known)}")
    return [name for name in known if not names or name in names]


def settled_outcomes(place: Workspace, campaign: Campaign, epochs: Sequence[str]) -> dict[str, EpochOutcome]:
    """Epochs whose scans, settings and code did not change since they were published, with how they ended then."""
    found, inputs = {}, _Inputs(campaign)
    for name in epochs:
        epoch = campaign.epoch(name)
        if epoch is None:
            continue
        scans = _scans(campaign, epoch)
        published_by = settled_by(place, campaign.structure.id, name, inputs.digest_of(epoch), scans)
        if published_by is not None:
            notes = (f"unchanged since run {published_by}",)
            found[name] = EpochOutcome(name, "ok", (), bad_input=False, notes=notes)
    return found


Seen = Mapping[str, Mapping[Path, Stamp | None]]
"""Epoch to the scans that it rests on, as they were before a run read them."""


def scans_seen(campaign: Campaign, epochs: Sequence[str]) -> Seen:
    """Look at the scans of epochs before they are processed: one that is replaced meanwhile must be read again."""
    known = [epoch for epoch in campaign.epochs if epoch.id in epochs]
    return {epoch.id: stamps_of(_scans(campaign, epoch)) for epoch in known}


def settle_epochs(place: Workspace, campaign: Campaign, outcomes: Sequence[EpochOutcome], seen: Seen) -> None:
    """Put down the epochs that ended without any fault or refusal.

    Raises
    ------
    StorageError
        If the disk refuses.
    """
    inputs = _Inputs(campaign)
    for outcome in outcomes:
        epoch = campaign.epoch(outcome.epoch)
        if epoch is not None and outcome.state == "ok" and not outcome.bad_input and outcome.fault is None:
            settle(place, campaign.structure.id, epoch.id, inputs.digest_of(epoch), seen[epoch.id])


@lru_cache(maxsize=1)
def program_digest() -> str:
    """Digest of all sources and numeric libraries: whatever changed in them, the epochs are looked at once more."""
    digest = hashlib.sha256("\n".join(library_versions()).encode())
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*")):
            if path.suffix in (".py", ".sql"):
                digest.update(path.relative_to(ROOT).as_posix().encode() + b"\n" + path.read_bytes())
    return digest.hexdigest()


class _Inputs:
    """What the results of epochs follow from beside their scans; the settings are written out once for all epochs."""

    def __init__(self, campaign: Campaign) -> None:
        whole = json.loads(campaign.filled_in_json())
        self._settings = {name: table for name, table in whole.items() if name not in NO_RESULT}
        self._epochs = {one["id"]: one for one in self._settings.pop("epochs")}
        self._reference = campaign.reference_epoch.id

    def digest_of(self, epoch: Epoch) -> str:
        """Digest of the settings, of the epoch and the reference epoch in them, and of the program."""
        needed = [self._epochs[name] for name in sorted({epoch.id, self._reference})]
        text = json.dumps([self._settings, needed, program_digest()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def _scans(campaign: Campaign, epoch: Epoch) -> list[Path]:
    """Scans of an epoch and of the reference epoch, which may hold its frame."""
    needed = {epoch.id, campaign.reference_epoch.id}
    return [campaign.scan_path(scan) for one in campaign.epochs if one.id in needed for scan in one.scans]
