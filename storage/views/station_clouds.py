"""What each station of an epoch saw, thinned out and laid in the site frame, for people to look at.

The scans as they were read are artifacts of the stage ``ingest STATION`` and the poses one of the last registration, found
as the points of the shaft are (``storage.views.shaft_points``). Both may have been swept: then the reason stands in the
place of the points.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from storage.artifacts import ArtifactRef, get_json
from storage.clouds import open_cloud
from storage.errors import StorageError
from storage.records import EpochRow, StageRunRow
from storage.views.reading import run_rows, station_rows
from storage.views.stage_record import stage_record
from storage.workspace import Workspace

INGEST: Final = "ingest "
REGISTRATION: Final = "registration"


@dataclass(frozen=True, slots=True, eq=False)
class StationCloud:
    """A station and some of its points (m, 3), evenly chosen, in the site frame, metres.

    ``points_m`` is None where they are gone or the station was not used; ``reason`` says which.
    """

    station: str
    points_m: NDArray[np.float64] | None
    reason: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Pose:
    rotation: NDArray[np.float64]
    position_m: NDArray[np.float64]


def station_clouds(ws: Workspace, epoch: EpochRow, most: int) -> list[StationCloud]:
    """Clouds of all stations of an epoch in the order of their names, at most so many points each.

    Raises
    ------
    StorageError
        If the catalog cannot be read.
    """
    stations = station_rows(ws, epoch.structure, epoch.epoch)
    own = [
        row
        for row in run_rows(ws, epoch.run)
        if row.structure == epoch.structure and row.epoch == epoch.epoch and row.outcome == "ok"
    ]
    poses = _poses(ws, own, {row.station for row in stations if row.state != "failed"})
    scans = {row.stage.removeprefix(INGEST): row for row in own if row.stage.startswith(INGEST)}
    return [
        StationCloud(row.station, None, f"not used: {row.reason or row.state}")
        if row.state == "failed"
        else _cloud(ws, row.station, scans.get(row.station), poses.get(row.station), most)
        for row in stations
    ]


def _cloud(
    ws: Workspace, station: str, scan: StageRunRow | None, pose: _Pose | None, most: int
) -> StationCloud:
    if scan is None or pose is None:
        return StationCloud(station, None, "its scan or its pose is not on record here")
    try:
        ref = _artifact(ws, scan, "points")
        if ref is None:
            return StationCloud(station, None, "its scan was swept from this workspace")
        points_m = open_cloud(ws, ref).sample(most)
    except StorageError as fault:
        return StationCloud(station, None, str(fault))
    return StationCloud(station, np.asarray(points_m @ pose.rotation.T + pose.position_m))


def _poses(ws: Workspace, own: Sequence[StageRunRow], used: set[str]) -> Mapping[str, _Pose]:
    """Poses of the last registration that has all stations that were used, and no others."""
    for row in reversed([row for row in own if row.stage.startswith(REGISTRATION)]):
        try:
            ref = _artifact(ws, row, REGISTRATION)
            content = None if ref is None else cast("Any", get_json(ws, ref))
        except StorageError:
            continue
        if content is not None and {pose["station"] for pose in content["poses"]} == used:
            return {pose["station"]: _pose(pose) for pose in content["poses"]}
    return {}


def _pose(stored: Mapping[str, Any]) -> _Pose:
    return _Pose(np.asarray(stored["rotation"], np.float64), np.asarray(stored["position_m"], np.float64))


def _artifact(ws: Workspace, row: StageRunRow, name: str) -> ArtifactRef | None:
    """Artifact of a stage; None where its record was swept or is of another form."""
    record = stage_record(ws, row)
    return None if record is None else ArtifactRef.from_json(record["artifacts"].get(name))
