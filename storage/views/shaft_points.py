"""The points of the isolated shaft of an epoch, for people to look at: mapped from the disk, not loaded.

They are artifacts of the isolation, and no table names them: tables hold results, artifacts can be computed anew and may be
swept. The way to them is on record already and is gone here, so that every workspace has it, also one that was made before
there was anything to look at:

    epochs.run -> runs.cache_key of its stages "preprocessing ..." -> record of the stage -> artifacts "points", "stations"

Where a station was left out for its level, a run isolated the shaft several times. The one that counts is that whose
stations and number of points are those of the published epoch. Of a record only its references and one number are read,
which is less than ``tasks.produced`` knows of it; a test holds both to the same form.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from storage.artifacts import ArtifactRef, get_json, map_array
from storage.errors import StorageError, UsageError
from storage.records import EpochRow, StageRunRow
from storage.views import epoch_rows, run_rows, station_rows
from storage.views.stage_record import stage_record
from storage.workspace import Workspace

ISOLATION: Final = "preprocessing"
REGISTRATION: Final = "registration"
"""Labels of both stages in ``runs``; what follows is the same in both: nothing, or which stations were left out."""

ROUNDING_M: Final = 1e-9
"""Slices reach so much further, so that decimal heights on an end are in (``tasks.slicing``)."""


@dataclass(frozen=True, slots=True, eq=False)
class ShaftPoints:
    """Points of an isolated shaft from the bottom up, with the station that saw each.

    Attributes
    ----------
    points_m : (n, 3) array
        East, north, up in the site frame, metres, float64; up never falls. Mapped read-only from the disk.
    station_index : (n,) array
        Place of each point's station in ``stations``.
    stations : tuple of str
        Ids of the stations that were used.
    """

    structure: str
    epoch: str
    points_m: NDArray[np.float64]
    station_index: NDArray[np.uint16]
    stations: tuple[str, ...]

    def __len__(self) -> int:
        """Count the points."""
        return len(self.points_m)

    def between(self, z_low_m: float, z_high_m: float) -> "ShaftPoints":
        """Points at heights from low to high, both included; found by halving, nothing is copied."""
        rows, up = range(len(self)), self.points_m[:, 2]
        begin = bisect_left(rows, z_low_m, key=lambda row: float(up[row]))
        end = bisect_right(rows, z_high_m, key=lambda row: float(up[row]))
        return self._taken(slice(begin, max(begin, end)))

    def of_slice(self, z_m: float, thickness_m: float) -> "ShaftPoints":
        """Points of a slice of the view ``slices``: its centre's height and its thickness."""
        half = thickness_m / 2 + ROUNDING_M
        return self.between(z_m - half, z_m + half)

    def thinned(self, most: int) -> "ShaftPoints":
        """Every k-th point from the lowest on: the least k by which there are at most ``most``.

        Raises
        ------
        UsageError
            If ``most`` is less than 1.
        """
        if most < 1:
            raise UsageError(f"thinning needs to leave at least 1 point; got {most}")
        return self._taken(slice(None, None, max(1, -(-len(self) // most))))

    def _taken(self, rows: slice) -> "ShaftPoints":
        return replace(self, points_m=self.points_m[rows], station_index=self.station_index[rows])


def shaft_points(ws: Workspace, structure: str, epoch: str) -> ShaftPoints:
    """Map the points of the shaft of an epoch; from a store elsewhere they are fetched into this machine's cache.

    Raises
    ------
    UsageError
        If the structure has no such epoch.
    StorageError
        If the epoch has no isolated shaft, or its points are gone, with what to do.
    """
    isolation = next(_isolations(ws, _epoch(ws, structure, epoch)), None)
    if isolation is None:
        raise StorageError(
            f"the points of {structure}, epoch {epoch} are not in this workspace; {_again(epoch)}"
        )
    try:
        points_m, index = map_array(ws, isolation.points), map_array(ws, isolation.index)
    except StorageError as fault:
        raise StorageError(
            f"the points of {structure}, epoch {epoch} are gone; {_again(epoch)} ({fault})"
        ) from fault
    return ShaftPoints(
        structure,
        epoch,
        cast("NDArray[np.float64]", points_m),
        cast("NDArray[np.uint16]", index),
        isolation.stations,
    )


def _again(epoch: str) -> str:
    return f"to make them anew, run `tiltwatch run FILE --epoch {epoch}` where the campaign file and its scans are"


@dataclass(frozen=True, slots=True)
class _Isolation:
    """What an isolation left behind."""

    points: ArtifactRef
    index: ArtifactRef
    stations: tuple[str, ...]


def _epoch(ws: Workspace, structure: str, epoch: str) -> EpochRow:
    rows = epoch_rows(ws, structure)
    for row in rows:
        if row.epoch == epoch:
            if row.n_points_used:
                return row
            because = f": {row.reason}" if row.reason else ""
            raise StorageError(
                f"epoch {epoch} of {structure} is {row.state} and has no isolated shaft{because}"
            )
    known = ", ".join(row.epoch for row in rows) or "none"
    raise UsageError(f"no epoch {epoch!r} of {structure!r} in the workspace; known: {known}")


def _isolations(ws: Workspace, epoch: EpochRow) -> Iterator[_Isolation]:
    """The isolations of the run that published an epoch which fit what was published, the last first."""
    used = {row.station for row in station_rows(ws, epoch.structure, epoch.epoch) if row.state != "failed"}
    own = [
        row
        for row in run_rows(ws, epoch.run)
        if row.structure == epoch.structure and row.epoch == epoch.epoch and row.outcome == "ok"
    ]
    for row in reversed(own):
        record = stage_record(ws, row) if row.stage.startswith(ISOLATION) else None
        if record is None or record["facts"].get("n_points_used") != epoch.n_points_used:
            continue
        stations = _stations(ws, own, row.stage.removeprefix(ISOLATION))
        if set(stations) == used:
            refs = record["artifacts"]
            yield _Isolation(
                ArtifactRef.from_json(refs["points"]), ArtifactRef.from_json(refs["stations"]), stations
            )


def _stations(ws: Workspace, own: list[StageRunRow], less: str) -> tuple[str, ...]:
    """Stations of a registration in the order of its poses, which is that of the indices of points."""
    for row in reversed(own):
        record = stage_record(ws, row) if row.stage == f"{REGISTRATION}{less}" else None
        if record is not None:
            content = cast("Any", get_json(ws, ArtifactRef.from_json(record["artifacts"][REGISTRATION])))
            return tuple(str(pose["station"]) for pose in content["poses"])
    return ()
