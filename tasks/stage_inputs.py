"""What stages load by reference, and the memory that they ask for before they do."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from storage.artifacts import ArtifactRef, get_array, get_json
from storage.clouds import StoredCloud, open_cloud
from storage.places import workspace_at
from storage.shared_arrays import share_array
from tasks.exchange import rebuild
from tasks.memory_needs import need_of_ingest, need_of_isolation, need_of_registration, need_of_shaft
from tasks.memory_room import room_for
from tasks.placing import PlacedCloud
from tasks.preprocessing import ShaftModel
from tasks.produced import Json
from tasks.registration import Registration, StableSurroundings, StationScan

JsonRef = dict[str, Json]
Room = AbstractContextManager[None]


def json_of(workspace: str, ref: JsonRef) -> Any:
    """Plain values."""
    return get_json(workspace_at(workspace), ArtifactRef.from_json(ref))


def array_of(workspace: str, ref: JsonRef) -> Any:
    """An array of its own."""
    return get_array(workspace_at(workspace), ArtifactRef.from_json(ref))


def shared_array_of(workspace: str, ref: JsonRef) -> Any:
    """An array that other stages hold, too: not to be written to."""
    return share_array(workspace_at(workspace), ArtifactRef.from_json(ref))


def cloud_of(workspace: str, ref: JsonRef) -> StoredCloud:
    """Points of a scan, to be read in chunks."""
    return open_cloud(workspace_at(workspace), ArtifactRef.from_json(ref))


def shaft_cloud_of(workspace: str, shaft: dict[str, Any]) -> PlacedCloud:
    """Points of an isolated shaft with their stations, which other stages hold, too."""
    points_m = shared_array_of(workspace, shaft["points"])
    return PlacedCloud(points_m, shared_array_of(workspace, shaft["stations"]))


def shaft_model_of(workspace: str, ref: JsonRef) -> ShaftModel:
    """The rough model of a shaft."""
    return rebuild(ShaftModel, json_of(workspace, ref))


def registration_of(workspace: str, ref: JsonRef) -> Registration:
    """The poses of an epoch."""
    return rebuild(Registration, json_of(workspace, ref))


def stable_of(workspace: str, refs: dict[str, JsonRef]) -> StableSurroundings:
    """What does not move around the structure."""
    return StableSurroundings(**{name: array_of(workspace, ref) for name, ref in refs.items()})


def station_scan_of(workspace: str, station: dict[str, Any]) -> StationScan:
    """A scan with the pose that is stated for it."""
    position_m = station["position_m"]
    return StationScan(
        station["station"],
        cloud_of(workspace, station["points"]),
        None if position_m is None else np.array(position_m),
        station["heading_rad"],
    )


def room_for_ingest(path: Path, suffix: str) -> Room:
    """Memory for reading a scan file; that it is not there is for its reader to tell."""
    size = path.stat().st_size if path.is_file() else 0
    return room_for(need_of_ingest(str(path), suffix, size))


def room_for_registration(scans: list[StoredCloud]) -> Room:
    """Memory for the joint adjustment of scans."""
    return room_for(need_of_registration(len(scan) for scan in scans))


def room_for_isolation(scans: list[StoredCloud], most_points: int) -> Room:
    """Memory for taking the shaft out of scans."""
    return room_for(need_of_isolation(sum(len(scan) for scan in scans), most_points))


def room_for_shaft(shaft: dict[str, Any], what: str, *, by_faces: bool = False) -> Room:
    """Memory for a stage on an isolated shaft."""
    # float64 x, y, z; the few bytes of the header are of no account
    n_points = int(shaft["points"]["size"]) // 24
    return room_for(need_of_shaft(n_points, what, by_faces=by_faces))
