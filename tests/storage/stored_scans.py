"""An epoch with the scans of two stations, their poses and the isolated shaft, as a run leaves it."""

import json
from dataclasses import replace

import numpy as np

from storage.artifacts import put_array, put_json
from storage.catalog import rebuild_catalog
from storage.clouds import put_cloud
from storage.digests import text_sha256
from storage.ledger import append_run, store_settings
from storage.publish import publish_epoch
from storage.workspace import Workspace
from tasks.caching import record_name
from tasks.produced import Cost, Produced, record_result
from tests.storage.campaign import SETTINGS, STRUCTURE, epoch_tables, stage_run_row, station_row

LOOKING_EAST = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
"""A scanner that looks east: what is ahead of it (+y) is east of it."""
POSITION = [100.0, 50.0, 1.5]
N_SHAFT = 400
STAGES = {
    "ingest ST01": "ingest-1",
    "ingest ST02": "ingest-2",
    "registration": "registration-1",
    "registration without ST03": "registration-2",
    "preprocessing without ST03": "preprocessing-2",
}


def keep_scans(ws: Workspace) -> None:
    """Records of two scans (a cloud and an array), of two registrations, of which the last counts, and of a shaft."""
    ahead = np.column_stack([np.zeros(100), np.arange(100.0), np.zeros(100)])
    _record(ws, "ingest-1", Produced(Cost(0.1, 100, None), {"points": put_cloud(ws, "scan", [ahead])}))
    _record(ws, "ingest-2", Produced(Cost(0.1, 100, None), {"points": put_array(ws, "scan", ahead)}))
    for number, shift in ((1, 7.0), (2, 0.0)):
        pose = {"rotation": LOOKING_EAST, "position_m": [POSITION[0] + shift, *POSITION[1:]]}
        poses = [{"station": station, **pose} for station in ("ST01", "ST02")]
        ref = put_json(ws, "registration", {"poses": poses})
        _record(ws, f"registration-{number}", Produced(Cost(0.1, 200, None), {"registration": ref}))
    up = np.linspace(2.0, 102.0, N_SHAFT)
    angle = np.arange(N_SHAFT) * 0.7
    points = np.column_stack([4.0 * np.cos(angle) + 0.007 * up, 4.0 * np.sin(angle) - 0.0057 * up, up])
    stations = (np.arange(N_SHAFT) % 2).astype(np.uint16)
    refs = {"points": put_array(ws, "shaft", points), "stations": put_array(ws, "shaft-stations", stations)}
    _record(ws, "preprocessing-2", Produced(Cost(0.1, 200, None), refs, {"n_points_used": N_SHAFT}))


def publish_scans(ws: Workspace, **tables: list[object]) -> None:
    """Publish the epoch e0 with two stations and one that failed, and the ledger of its run."""
    store_settings(ws, text_sha256(SETTINGS), SETTINGS)
    whole = epoch_tables("e0", n_points_used=N_SHAFT)
    failed = replace(station_row("e0", "ST03"), state="failed", reason="cut short")
    whole["stations"] = [station_row("e0", "ST01"), station_row("e0", "ST02"), failed]
    publish_epoch(ws, STRUCTURE, "e0", {**whole, **tables})
    row = stage_run_row("run-1", "e0")
    append_run(
        ws, "run-1", STRUCTURE, [replace(row, stage=stage, cache_key=key) for stage, key in STAGES.items()]
    )
    rebuild_catalog(ws)


def _record(ws: Workspace, key: str, produced: Produced) -> None:
    """As Prefect writes it: the result of a stage as JSON in JSON."""
    content = json.dumps({"metadata": {}, "result": json.dumps(produced.to_json())}).encode()
    assert record_result(content) == produced
    path = ws.root / record_name(key)
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
