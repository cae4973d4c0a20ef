"""An epoch with an isolated shaft, as a run leaves it: records of stages, their artifacts, and the ledger."""

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from storage.artifacts import ArtifactRef, put_array, put_json
from storage.catalog import rebuild_catalog
from storage.digests import text_sha256
from storage.ledger import append_run, store_settings
from storage.publish import publish_epoch
from storage.records import StageRunRow
from storage.workspace import Workspace
from tasks.caching import record_name
from tasks.produced import Cost, Produced, record_result
from tests.storage.campaign import SETTINGS, STRUCTURE, epoch_tables, stage_run_row, station_row


def keep_isolation(
    ws: Workspace,
    points_m: NDArray[np.float64],
    index: NDArray[np.uint16],
    stations: Sequence[str],
    less: str = "",
) -> ArtifactRef:
    """Records and artifacts of a registration and an isolation; gives the reference to the points."""
    poses = {"poses": [{"station": station} for station in stations]}
    registration = {"registration": put_json(ws, "registration", poses)}
    refs = {"points": put_array(ws, "shaft", points_m), "stations": put_array(ws, "shaft-stations", index)}
    cost = Cost(0.1, len(points_m), None)
    _record(ws, f"registration-1{less}", Produced(cost, registration))
    _record(ws, f"preprocessing-1{less}", Produced(cost, refs, {"n_points_used": len(points_m)}))
    return refs["points"]


def publish(ws: Workspace, *less: str, n_points_used: int, state: str = "ok", **tables: list[object]) -> None:
    """Publish the epoch e0 with two stations and one that failed; the ledger has the isolations without ``less``."""
    store_settings(ws, text_sha256(SETTINGS), SETTINGS)
    reason = None if state == "ok" else "no scan"
    whole = epoch_tables("e0", n_points_used=n_points_used, state=state, reason=reason)
    whole["stations"] = [
        station_row("e0", "ST01"),
        station_row("e0", "ST02"),
        replace(station_row("e0", "ST03"), state="failed", reason="left out"),
    ]
    publish_epoch(ws, STRUCTURE, "e0", {**whole, **tables})
    append_run(ws, "run-1", STRUCTURE, [row for name in less for row in _stages(name)])
    rebuild_catalog(ws)


def _stages(less: str) -> list[StageRunRow]:
    """In the ledger, in the order in which they were asked for."""
    row = stage_run_row("run-1", "e0")
    return [
        replace(row, stage=f"{stage}{less}", cache_key=f"{stage}-1{less}")
        for stage in ("registration", "preprocessing")
    ]


def _record(ws: Workspace, key: str, produced: Produced) -> None:
    """As Prefect writes it: the result of a stage as JSON in JSON."""
    content = json.dumps({"metadata": {}, "result": json.dumps(produced.to_json())}).encode()
    assert record_result(content) == produced
    path = ws.root / record_name(key)
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)


def wall(
    n: int, seed: int = 1, radius_m: float = 4.0, sigma_m: float = 0.002
) -> tuple[NDArray[np.float64], NDArray[np.uint16]]:
    """Points (n, 3) on the shaft that the rows of ``tests.storage.campaign`` lean as, from the bottom up; stations."""
    rng = np.random.default_rng(seed)
    z_m = np.sort(rng.uniform(1.0, 102.0, n))
    azimuth = rng.uniform(0.0, 2.0 * np.pi, n)
    radial_m = radius_m + rng.normal(0.0, sigma_m, n)
    east = 0.01 + 0.007 * z_m + radial_m * np.sin(azimuth)
    north = -0.02 - 0.0057 * z_m + radial_m * np.cos(azimuth)
    return np.column_stack([east, north, z_m]), (azimuth > np.pi).astype(np.uint16)
