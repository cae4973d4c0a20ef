"""A campaign of two epochs in its file, more of them on the way to an inbox, and settings that change."""

import os
import shutil
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final
from uuid import uuid4

from tasks.settings.toml_text import toml_text
from tasks.simulated_campaign import SimulatedCampaignRequest, write_simulated_campaign

IN_FILE: Final = 2
"""Epochs that the campaign file has; the others come through the inbox."""

STATIONS: Final = 5
SETTINGS: Final = ("", "voxel_m = 0.006", "voxel_m = 0.008")
"""What [preprocessing] says in turn: other points, other results, and the old ones are kept as a version."""


@dataclass(frozen=True)
class Site:
    """Where everything lies."""

    folder: Path
    epochs: Sequence[Mapping[str, Any]] = field(default=(), repr=False)
    """All epochs that were simulated, as the campaign file would state them."""

    @property
    def file(self) -> Path:
        return self.folder / "site" / "campaign.toml"

    @property
    def workspace(self) -> Path:
        return self.folder / "ws"

    @property
    def inbox(self) -> Path:
        return self.folder / "inbox"

    @property
    def reports(self) -> Path:
        return self.folder / "reports"

    def set_up(self, number: int) -> None:
        """Give the campaign file the settings of that turn, at once, as an editor saves it."""
        text = (self.folder / "head.toml").read_text(encoding="utf-8")
        wanted = SETTINGS[number % len(SETTINGS)]
        if wanted:
            text = text.replace("[limits]", f"[preprocessing]\n{wanted}\n\n[limits]")
        temp = self.file.with_name(f".campaign.{uuid4().hex}")
        temp.write_text(text, encoding="utf-8")
        temp.replace(self.file)

    def send(self, epoch: Mapping[str, Any], station: Mapping[str, Any]) -> None:
        """Put a scan and its sidecar into the inbox, each in place at once."""
        name = f"{epoch['id']}-{station['id']}"
        stated = {key: value for key, value in station.items() if key not in ("id", "scan")}
        stated = {"epoch": epoch["id"], "id": station["id"], "time": epoch["time"], **stated}
        sidecar = self.folder / f"{name}.toml"
        sidecar.write_text(toml_text("", stated), encoding="utf-8")
        sidecar.replace(self.inbox / sidecar.name)
        scan = self.folder / f"{name}.laz"
        shutil.copyfile(self.file.parent / str(station["scan"]), scan)
        scan.replace(self.inbox / scan.name)

    def complete(self, epoch: Mapping[str, Any]) -> None:
        """Say that no more stations come."""
        (self.inbox / f"{epoch['id']}.complete").touch()

    def lonely(self, folder: Path) -> "Site":
        """The campaign as it is now, in a workspace of its own: what came through the inbox counts as before."""
        alone = Site(folder)
        shutil.copytree(self.folder / "site", folder / "site", copy_function=os.link)
        alone.workspace.mkdir()
        shutil.copytree(self.workspace / "intake", alone.workspace / "intake")
        return alone


def made_site(folder: Path, epochs: int, points: int, seed: int) -> Site:
    """Simulate all epochs, and leave the first of them in the campaign file."""
    request = SimulatedCampaignRequest(epochs=IN_FILE + epochs, stations=STATIONS, points=points, seed=seed)
    file = write_simulated_campaign(folder / "site", request)
    text = file.read_text(encoding="utf-8")
    head = "\n[[epochs]]\n".join(text.split("\n[[epochs]]\n")[: IN_FILE + 1])
    (folder / "head.toml").write_text(head, encoding="utf-8")
    site = Site(folder, tomllib.loads(text)["epochs"])
    for place in (site.inbox, site.reports):
        place.mkdir()
    site.set_up(0)
    return site
