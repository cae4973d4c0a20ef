"""A small structure, scans of it as a field unit sends them, and a watch that is stepped by hand."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flows.watch.events import Teller, WatchEvent
from flows.watch.loop import Pace, Watch
from flows.watch.place import WatchPlace
from storage.digests import file_sha256
from storage.workspace import open_workspace
from tasks.conventions import rotation_site_scanner
from tasks.settings.toml_text import toml_text

HEAD = """\
schema_version = 1
[structure]
id = "silo"
kind = "silo"
height_m = 30.0
shaft_z_m = [1.0, 30.0]
radius_m = [4.0, 4.0]
[frame]
axes = "ENU"
"""
SEEN_FROM_M = 60.0
TIME = datetime(2026, 3, 11, 6, 0, tzinfo=UTC)


class HeardTeller(Teller):
    """A teller whose events can be looked at."""

    heard: list[WatchEvent]

    def tell(self, event: WatchEvent) -> None:
        self.heard.append(event)
        super().tell(event)


@dataclass
class Site:
    """A folder with a campaign file and an inbox, and a clock that only goes when it is told to."""

    folder: Path
    keeps: bool = False
    now_s: float = 0.0
    now: datetime = TIME
    watch: Watch = field(init=False)
    teller: HeardTeller = field(init=False)

    def __post_init__(self) -> None:
        self.inbox.mkdir(parents=True, exist_ok=True)
        if not self.file.exists():
            self.file.write_text(HEAD, encoding="utf-8")
        self.begin()

    @property
    def file(self) -> Path:
        return self.folder / "silo.toml"

    @property
    def inbox(self) -> Path:
        return self.folder / "inbox"

    @property
    def workspace(self) -> Path:
        return self.folder / "workspace"

    def begin(self, run_timeout_s: float = 0.5) -> None:
        """Begin a watch, as after a restart."""
        ws = open_workspace(self.workspace)
        place = WatchPlace(self.file, "silo", ws, self.inbox, keeps=self.keeps)
        self.teller = HeardTeller(ws, "silo", as_json=True, now=lambda: self.now)
        self.teller.heard = []
        pace = Pace(interval_s=0.01, settle_s=10.0, run_timeout_s=run_timeout_s)
        self.watch = Watch(place, self.teller, pace, clock=lambda: self.now_s, now=lambda: self.now)

    def look(self) -> list[WatchEvent]:
        """Look twice, so that what lies there settles; gives what was told."""
        before = len(self.teller.heard)
        for _ in range(2):
            self.watch.step()
            self.now_s += 10.0
        return self.teller.heard[before:]

    def kinds(self) -> list[str]:
        """Kinds of what is told by a look."""
        return [event.kind for event in self.look()]

    def send(self, station: str, azimuth_deg: float = 0.0, *, into: str = "", **changes: object) -> Path:
        """Put a scan and its sidecar into the inbox; without heading_deg there is no preview, which is quicker."""
        path = self.inbox / into / f"{station}.csv"
        path.parent.mkdir(exist_ok=True)
        write_scan(path, azimuth_deg)
        self.send_sidecar(station, azimuth_deg, into=into, **changes)
        return path

    def send_sidecar(
        self, station: str, azimuth_deg: float = 0.0, *, into: str = "", **changes: object
    ) -> Path:
        """Put a sidecar into the inbox; a change to None leaves a key out."""
        table = {
            "epoch": "2026-03",
            "time": TIME,
            "position_m": list(position_m(azimuth_deg)),
            **changes,
        }
        path = self.inbox / into / f"{station}.toml"
        path.write_text(toml_text("", table), encoding="utf-8")
        return path


def reasons(events: Sequence[WatchEvent], kind: str = "kept") -> list[str]:
    """What events of a kind say."""
    return ["\n".join(event.lines) for event in events if event.kind == kind]


def position_m(azimuth_deg: float) -> tuple[float, float, float]:
    """Where a scanner stands that sees the silo from an azimuth."""
    azimuth = np.radians(azimuth_deg)
    return (float(SEEN_FROM_M * np.sin(azimuth)), float(SEEN_FROM_M * np.cos(azimuth)), 1.5)


def visible_wall_m(azimuth_deg: float, n: int = 4000) -> NDArray[np.float64]:
    """Points (n, 3) of the half of the wall that faces a scanner, site frame, 5 mm of noise."""
    rng = np.random.default_rng(round(azimuth_deg) + 1)
    turn = np.radians(azimuth_deg + rng.uniform(-84.0, 84.0, n))
    radius_m = 4.0 + rng.normal(0.0, 0.005, n)
    return np.column_stack([radius_m * np.sin(turn), radius_m * np.cos(turn), rng.uniform(0.5, 30.5, n)])


def write_scan(path: Path, azimuth_deg: float) -> None:
    """Write what a scanner with heading 0 sees from an azimuth, in its own frame."""
    points_m = (visible_wall_m(azimuth_deg) - position_m(azimuth_deg)) @ rotation_site_scanner(0.0)
    rows = "\n".join(",".join(f"{value:.4f}" for value in point) for point in points_m)
    path.write_text(f"x,y,z\n{rows}\n", encoding="utf-8")


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    return file_sha256(path)


def in_inbox(site: Site) -> list[str]:
    """Names of the files in the inbox."""
    return sorted(path.name for path in site.inbox.rglob("*") if path.is_file())


def in_scans(site: Site) -> list[str]:
    """Scans and sidecars that were taken in."""
    home = site.folder / "inbox-scans"
    return sorted(path.relative_to(home).as_posix() for path in home.rglob("*") if path.is_file())
