"""A workspace to look at: three structures and twelve epochs, with what goes wrong in the field, run for real."""

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tasks.simulated_campaign import write_simulated_campaign
from tasks.simulation.kinds import request_of_kind

CHIMNEY, TOWER, SILO = "chimney-01", "tower-02", "silo-03"
EPOCHS: Final = {"chimney": 8, "tower": 4, "silo": 1}
HELD_BACK: Final = "2026-10"
"""The last epoch of the chimney: it is measured, but not in the campaign file yet."""
FAILED: Final = "2025-07"
"""An epoch of the tower whose scans were all cut short in the copying."""
DEGRADED: Final = "2025-10"
"""One in which a single station was."""
RUN_S: Final = 240.0


@dataclass(frozen=True, slots=True)
class DemoSite:
    """Where it lies: a campaign file a structure, and the workspace that they share."""

    root: Path

    @property
    def workspace(self) -> Path:
        """The workspace of all three."""
        return self.root / "workspace"

    def campaign(self, kind: str) -> Path:
        """The campaign file of a structure, by its kind."""
        return self.root / kind / "campaign.toml"

    def publish_the_next(self) -> None:
        """Add the epoch that was held back to the chimney's campaign, and run it."""
        whole = (self.root / "chimney" / "whole.toml").read_text()
        self.campaign("chimney").write_text(whole)
        _run(self, "chimney")


def make_demo_site(root: Path, points: int = 12_000, stations: int = 6) -> DemoSite:
    """Simulate three structures, spoil what is to be spoiled, and run them: a minute on two cores."""
    site = DemoSite(root)
    for seed, (kind, epochs) in enumerate(EPOCHS.items(), start=1):
        request = request_of_kind(kind, epochs=epochs, stations=stations, points=points, seed=seed)
        write_simulated_campaign(root / kind, request)
    _spoil_scans(root / "tower")
    _name_structures(site)
    for kind in EPOCHS:
        _run(site, kind)
    return site


def _spoil_scans(tower: Path) -> None:
    for scan in (tower / FAILED).glob("*.laz"):
        scan.write_bytes(scan.read_bytes()[:200])
    scan = tower / DEGRADED / "ST03.laz"
    scan.write_bytes(scan.read_bytes()[:5000])


def _name_structures(site: DemoSite) -> None:
    names = {
        "chimney": (CHIMNEY, "Heritage chimney"),
        "tower": (TOWER, "Tower 2"),
        "silo": (SILO, "Silo <b>3</b>"),
    }
    for kind, (structure, name) in names.items():
        file = site.campaign(kind)
        text = file.read_text()
        text = re.sub(
            r'\[structure\]\nid = "[^"]*"\nname = "[^"]*"',
            f'[structure]\nid = "{structure}"\nname = "{name}"',
            text,
        )
        if kind == "silo":
            text = re.sub(r"\[limits\]\n(?:[^\n\[]+\n)+", "", text)
        if kind == "chimney":
            (file.parent / "whole.toml").write_text(text)
            text = text[: text.index(f'[[epochs]]\nid = "{HELD_BACK}"')]
        file.write_text(text)


def _run(site: DemoSite, kind: str) -> None:
    command = [
        sys.executable,
        "-m",
        "flows.cli",
        "run",
        str(site.campaign(kind)),
        "--workspace",
        str(site.workspace),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=RUN_S, check=False)
    # 3: the failed epoch of the tower; the others are whole
    if done.returncode not in (0, 3):
        raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr[-3000:]}")
