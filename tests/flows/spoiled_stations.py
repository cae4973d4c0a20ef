"""Epochs of a small campaign in which stations are bad or stated in other ways, for the tests of stations in flows."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tasks.conventions import ARCSEC_RAD, rotation_site_scanner
from tasks.geometry.rotations import rotation_from_vector
from tasks.ingest import read_scan
from tests.faults.sites import FIRST, Site, epoch_text, head_of, stations_of
from tests.unit.ingest.clouds import write_las, write_text

Table = Mapping[str, object]


@dataclass
class Epochs:
    """Collects epochs of a campaign whose scans are those of its first one, spoiled."""

    site: Site
    texts: list[str] = field(default_factory=list)

    def tables(self) -> Sequence[Table]:
        return stations_of(self.site.text(), FIRST)

    def copy(self, epoch: str, stations: Sequence[str]) -> list[Table]:
        """Copy scans of the first epoch; gives their tables."""
        shutil.copytree(self.site.folder / FIRST, self.site.folder / epoch)
        return [
            {**table, "scan": f"{epoch}/{table['id']}.laz"}
            for table in self.tables()
            if table["id"] in stations
        ]

    def add(self, epoch: str, tables: Sequence[Table]) -> None:
        self.texts.append(epoch_text(epoch, len(self.texts), tables))

    def write(self) -> None:
        text = self.site.text()
        self.site.file.write_text(head_of(text) + "\n".join(self.texts), encoding="utf-8")


def pose_of(table: Table) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rotation (3, 3) and position (3,) that a station's table states."""
    return rotation_site_scanner(np.radians(table["heading_deg"])), np.array(table["position_m"])


def bend_shaft(site: Site, table: Table, *lean_arcsec: float) -> None:
    """Let the structure, and nothing else of a scan, lean further: a level error that surroundings do not show."""
    scan = site.folder / str(table["scan"])
    rotation, position_m = pose_of(table)
    points_m = read_scan(scan).points_m @ rotation.T + position_m
    on = np.hypot(points_m[:, 0], points_m[:, 1]) < 12.0
    points_m[on, :2] += points_m[on, 2:] * np.array(lean_arcsec) * ARCSEC_RAD
    write_las(scan, (points_m - position_m) @ rotation)


def write_ptx(site: Site, name: str, tables: Sequence[Table], tilt_rad: Sequence[float]) -> None:
    """Write scans into one PTX file, each of a scanner that is tilted, as its pose there says."""
    tilt = rotation_from_vector(np.array(tilt_rad))
    texts = []
    for table in tables:
        rotation, position_m = pose_of(table)
        points_m = read_scan(site.folder / str(table["scan"])).points_m @ tilt
        axes = (rotation @ tilt).T
        lines = ["1", str(len(points_m))]
        lines += [" ".join(f"{value:.9f}" for value in row) for row in (position_m, *axes)]
        lines += [" ".join(f"{value:.9f}" for value in (*row, 0.0)) for row in axes]
        lines.append(" ".join(f"{value:.9f}" for value in (*position_m, 1.0)))
        lines += [f"{x:.5f} {y:.5f} {z:.5f} 0.5" for x, y, z in points_m.tolist()]
        texts.append("\n".join(lines))
    write_text(site.folder / name, "\n".join(texts) + "\n")
