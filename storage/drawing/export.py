"""Geometry of an epoch as a file that CloudCompare, CAD and GIS open; the same bytes for the same results."""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from storage.atomic import Writer
from storage.drawing.axis import axis_features
from storage.drawing.chosen import DrawingChoice, epoch_with_axes, epoch_with_points, of_the_axes
from storage.drawing.content import Drawing, DrawingFrame, DrawnCloud, Feature
from storage.drawing.formats import CLOUD, GEOMETRY, cloud_writer_of, encoder_of
from storage.drawing.projected_system import projected_system
from storage.drawing.slice_circles import slice_features
from storage.errors import UsageError
from storage.named_files import write_named_file
from storage.records import EpochRow
from storage.views import one_catalog, slice_rows_of, tilt_rows
from storage.views.shaft_points import shaft_points
from storage.workspace import Workspace


@dataclass(frozen=True, slots=True)
class Exported:
    """What was written: of which epoch, how many shapes or points, in which frame, and what the user should know."""

    epoch: str
    count: int
    coordinates: str
    warnings: tuple[str, ...] = ()


def export_geometry(
    ws: Workspace, what: str, file_format: str, choice: DrawingChoice, out: Path | BinaryIO
) -> Exported:
    """Write geometry of an epoch in the frame of the campaign's positions.

    Parameters
    ----------
    what : str
        ``axis`` (axis, plumb line, foot, top, lean), ``slice-circles`` or ``cloud`` (the isolated shaft).
    file_format : str
        Name of a format that can hold it.
    out : Path or binary file
        Where to; a file at a path appears whole or not at all.

    Raises
    ------
    UsageError
        If there is no such thing, format, epoch, scheme or method.
    StorageError
        If there is nothing to draw, it is gone, or the file cannot be written.
    InputError
        If the frame is no projected system in metres with axes east and north.
    """
    if what not in GEOMETRY:
        raise UsageError(f"unknown geometry {what!r}; known: {', '.join(GEOMETRY)}")
    return (_export_cloud if what == CLOUD else _export_shapes)(ws, what, file_format, choice, out)


def _export_shapes(
    ws: Workspace, what: str, file_format: str, choice: DrawingChoice, out: Path | BinaryIO
) -> Exported:
    encode = encoder_of(what, file_format)
    with one_catalog(ws):
        epoch = epoch_with_axes(ws, choice)
        frame = _frame(choice, epoch)
        features, missing = (_axes if what == "axis" else _slices)(ws, choice, epoch, frame)
    drawing = Drawing(what, choice.structure, epoch.epoch, epoch.epoch_time, frame, features)
    _write(out, encode(drawing))
    warnings = tuple(text for text in (missing, frame.warning, _local(frame, file_format)) if text)
    return Exported(epoch.epoch, len(features), frame.meaning, warnings)


def _frame(choice: DrawingChoice, epoch: EpochRow) -> DrawingFrame:
    frame = choice.frame_of(epoch)
    if frame.epsg is not None:
        projected_system(frame.epsg)
    return frame


def _axes(
    ws: Workspace, choice: DrawingChoice, epoch: EpochRow, frame: DrawingFrame
) -> tuple[list[Feature], str]:
    rows = of_the_axes(tilt_rows(ws, choice.structure, epoch.epoch), choice, epoch.epoch)
    return [feature for row in rows for feature in axis_features(row, frame)], ""


def _slices(
    ws: Workspace, choice: DrawingChoice, epoch: EpochRow, frame: DrawingFrame
) -> tuple[list[Feature], str]:
    rows = of_the_axes(slice_rows_of(ws, choice.structure, epoch.epoch), choice, epoch.epoch)
    features = [feature for row in rows for feature in slice_features(row, frame)]
    missing = sum(row.center_east_m is None for row in rows)
    told = (
        f"{missing} of {len(rows)} slices have no contour and are not drawn; `export slices` has the reasons"
    )
    return features, told if missing else ""


def _local(frame: DrawingFrame, file_format: str) -> str:
    if file_format != "geojson" or frame.epsg is not None:
        return ""
    return (
        "the frame is local: the file holds metres, not longitude and latitude, and a GIS will lay it beside Africa; "
        "state [frame] horizontal and origin_m, or export dxf"
    )


def _export_cloud(
    ws: Workspace, _what: str, file_format: str, choice: DrawingChoice, out: Path | BinaryIO
) -> Exported:
    write = cloud_writer_of(file_format)
    if choice.names_an_axis:
        raise UsageError("the cloud is the same for all schemes and methods; leave --scheme and --method out")
    with one_catalog(ws):
        epoch = epoch_with_points(ws, choice)
        frame = _frame(choice, epoch)
        points = shaft_points(ws, choice.structure, epoch.epoch)
    cloud = DrawnCloud(
        choice.structure,
        epoch.epoch,
        epoch.epoch_time,
        frame,
        points.stations,
        points.points_m,
        points.station_index,
    )
    _write(out, lambda file: write(cloud, file))
    warnings = (frame.warning,) if frame.warning else ()
    return Exported(epoch.epoch, len(points), frame.meaning, warnings)


def _write(out: Path | BinaryIO, content: bytes | Writer) -> None:
    if isinstance(out, Path):
        write_named_file(out, content)
    elif isinstance(content, bytes):
        out.write(content)
    else:
        whole = io.BytesIO()  # a pipe cannot seek, which LAS needs
        content(whole)
        out.write(whole.getbuffer())
