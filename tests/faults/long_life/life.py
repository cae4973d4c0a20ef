"""One campaign that lives: epoch after epoch is published, assessed and put on record as a run does it."""

import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from flows.assess_structure import assess_structure
from flows.ledger import RunLedger
from flows.outcome import EpochOutcome
from flows.record_keeping import kept_record
from flows.settled_epochs import scans_seen, settle_epochs
from storage.catalog import rebuild_catalog
from storage.ledger import store_settings
from storage.publish import publish_epoch
from storage.run_record import record_of_this_process, remove_record
from storage.workspace import Workspace, open_workspace
from tasks.settings import Campaign, load_campaign
from tests.faults.long_life.template import (
    Template,
    epoch_name,
    epoch_time,
    rows_of_epoch,
    stages_of_run,
)
from tests.flows.campaigns import STRUCTURE, ignore

REPLACED_EVERY: Final = 10
"""After so many epochs the last one is published with other results, and its old ones are kept as a version."""


@dataclass
class Life:
    """A workspace, the whole campaign that it will hold, and how long each step took since it was last asked."""

    template: Template
    workspace: Workspace
    campaign: Campaign
    assess_every: int = 1
    """After so many epochs the structure is assessed; as often as it is published where it is 1."""
    seconds: dict[str, list[float]] = field(default_factory=dict)

    def live(self, number: int) -> None:
        """Do what a run does that finds one epoch more."""
        self._run(number)
        if number % REPLACED_EVERY == REPLACED_EVERY - 1:
            self._run(number, version=1)

    def taken(self) -> Mapping[str, list[float]]:
        """Seconds of every step since the last call."""
        taken, self.seconds = self.seconds, {}
        return taken

    def _run(self, number: int, version: int = 0) -> None:
        ws, run = self.workspace, f"run-{number:05d}-{version}"
        campaign = self.campaign.model_copy(update={"epochs": self.campaign.epochs[: number + 1]})
        ledger = RunLedger(run, STRUCTURE, ignore)
        with self._timed("the whole of it"):
            with kept_record(ws, ledger, record_of_this_process(run, STRUCTURE, "own")):
                seen = scans_seen(campaign, [epoch_name(number)])
                with self._timed("settings stored"):
                    store_settings(ws, campaign.digest, campaign.filled_in_json())
                for row in stages_of_run(self.template, number, run):
                    ledger.put_down(row)
                rows = rows_of_epoch(self.template, number, run, campaign.digest, version=version)
                with self._timed("published"):
                    publish_epoch(ws, STRUCTURE, epoch_name(number), rows)
                with self._timed("settled"):
                    done = EpochOutcome(epoch_name(number), "ok", (), bad_input=False)
                    settle_epochs(ws, campaign, [done], seen)
                with self._timed("catalog follows"):
                    rebuild_catalog(ws)
                if (number + 1) % self.assess_every == 0:
                    with self._timed("assessed"):
                        assess_structure(ws, campaign)
            rebuild_catalog(ws)
        remove_record(ws, run)

    @contextmanager
    def _timed(self, step: str) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self.seconds.setdefault(step, []).append(time.perf_counter() - began)


def begun_life(template: Template, folder: Path, epochs: int, assess_every: int = 1) -> Life:
    """A campaign file of so many epochs and one more, whose scans are there, and an empty workspace."""
    file = folder / "campaign.toml"
    file.write_text(_campaign_text(template, folder, epochs), encoding="utf-8")
    return Life(template, open_workspace(folder / "ws"), load_campaign(file), assess_every)


def _campaign_text(template: Template, folder: Path, epochs: int) -> str:
    """All epochs rest on the scans of the template's first one, the one more on those of its second."""
    head, first, last = template.campaign_file.read_text(encoding="utf-8").split("\n[[epochs]]\n")
    texts = [head]
    for number in range(epochs + 1):
        source = first if number < epochs else last
        texts.append(_epoch_text(template.campaign_file.parent, folder, source, number))
    return "\n[[epochs]]\n".join(texts)


def _epoch_text(home: Path, folder: Path, source: str, number: int) -> str:
    name, lines = epoch_name(number), []
    (folder / name).mkdir(parents=True)
    for line in source.splitlines():
        key, _, value = line.partition(" = ")
        if key == "scan":
            scan = Path(value.strip('"'))
            os.link(home / scan, folder / name / scan.name)
            lines.append(f'scan = "{name}/{scan.name}"')
        elif key == "time":
            lines.append(f"time = {epoch_time(number).isoformat()}")
        elif key == "reference":
            lines += ["reference = true"] if number == 0 else []
        else:
            lines.append(f'id = "{name}"' if not lines else line)
    return "\n".join(lines)
