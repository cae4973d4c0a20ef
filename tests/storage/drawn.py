"""A stored epoch with three kinds of slices, drawn in all formats, and a small cloud."""

import io
from dataclasses import replace

import numpy as np

from storage.catalog import rebuild_catalog
from storage.drawing import DrawingChoice, DrawingFrame, export_geometry
from storage.drawing.content import DrawnCloud
from storage.publish import publish_epoch
from storage.workspace import Workspace
from tests.storage.campaign import STRUCTURE, epoch_tables, epoch_time, fill, slice_row, tilt_row

LOCAL = DrawingFrame((100.0, -50.0, 12.5))
UTM50 = DrawingFrame((440_000.0, 4_420_000.0, 45.0), 32650)
HOSTILE = 'bent\n  0\nENDSEC "</script>" %%d; DROP TABLE'
STATIONS = ("ST01", 'ST,"02"')

OVAL = {"ovality_m": 0.05, "ovality_azimuth_deg": 30.0, "roundness_m": 0.1, "contour": "ellipse"}
NO_CONTOUR = {
    "center_east_m": None,
    "center_north_m": None,
    "radius_m": None,
    "state": "failed",
    "reason": "no points",
}


def fill_drawn(ws: Workspace) -> None:
    """Two epochs: e0 as it comes; e1 with a round, an oval, a square and a failed slice, and a hostile warning."""
    fill(ws, 1)
    tables = epoch_tables("e1", 1)
    kinds = ({}, OVAL, {"contour": "polygon"}, NO_CONTOUR)
    tables["slices"] = [replace(slice_row("e1", index), **changed) for index, changed in enumerate(kinds)]
    primary = replace(tilt_row("e1", 1), warning=HOSTILE, base_sigma_m=0.0011)
    control = replace(
        tilt_row("e1", 1),
        scheme="F",
        lean_cov_ee=None,
        lean_cov_en=None,
        lean_cov_nn=None,
        deviation_sigma_m=None,
    )
    tables["tilt"] = [primary, control]
    publish_epoch(ws, STRUCTURE, "e1", tables)
    rebuild_catalog(ws)


def choice(frame: DrawingFrame = LOCAL, **changed: str) -> DrawingChoice:
    return replace(DrawingChoice(STRUCTURE, ("A", "paper"), lambda _epoch: frame), **changed)


def drawn(ws: Workspace, what: str, file_format: str, wanted: DrawingChoice | None = None) -> bytes:
    out = io.BytesIO()
    export_geometry(ws, what, file_format, wanted or choice(), out)
    return out.getvalue()


def small_cloud(frame: DrawingFrame = LOCAL) -> DrawnCloud:
    rng = np.random.default_rng(4)
    points = rng.uniform((-3.0, -3.0, 2.0), (3.0, 3.0, 100.0), (500, 3))
    return DrawnCloud(
        STRUCTURE, "e1", epoch_time(1), frame, STATIONS, points, np.arange(500, dtype=np.uint16) % 2
    )
