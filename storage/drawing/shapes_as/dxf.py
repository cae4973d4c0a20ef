"""A drawing as DXF (AutoCAD 2010): metres, a layer for each thing of each scheme, attributes as extended data."""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from math import cos, radians, sin
from typing import TYPE_CHECKING, Any, Final

from storage.drawing.content import Circle, Drawing, Ellipse, Feature, Line, Point, Position, Shape

if TYPE_CHECKING:
    from ezdxf.document import Drawing as Document

NAME: Final = "dxf"

APPLICATION: Final = "TILTWATCH"
TEXT_HEIGHT_M: Final = 0.15
FROM_THE_SOUTH: Final = (0.0, -1.0, 0.0)
LONGEST_TEXT: Final = 240
"""Extended data holds strings of 255 bytes; signs of three bytes are cut earlier."""

COLORS: Final = {
    "axis": 5,
    "plumb": 8,
    "lean": 1,
    "foot": 5,
    "top": 5,
    "circle": 4,
    "ellipse": 6,
    "centre": 4,
}
"""AutoCAD's colour numbers: blue, grey, red, cyan, magenta."""


def encode(drawing: Drawing) -> bytes:
    """DXF of a drawing; equal drawings give equal bytes (no dates, no GUIDs of its own)."""
    with _without_dates():
        from ezdxf import units  # noqa: PLC0415 (slow to import)
        from ezdxf.filemanagement import new  # noqa: PLC0415

        document = new("R2010", units=units.M)
        document.appids.add(APPLICATION)
        for name, value in _about(drawing).items():
            document.header.custom_vars.append(name, _one_line(value))
        for feature in drawing.features:
            _draw(document, feature)
        # ezdxf takes them out of a set, in an order that differs from process to process
        for kind in sorted(document.entitydb.dxf_types_in_use()):
            document.classes.add_class(kind)
        text = io.StringIO(newline="")
        document.write(text)
    return text.getvalue().encode("utf-8", "replace")


@contextmanager
def _without_dates() -> Iterator[None]:
    from ezdxf._options import options  # noqa: PLC0415 (slow to import)

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _about(drawing: Drawing) -> dict[str, str]:
    return {
        "structure": drawing.structure,
        "epoch": drawing.epoch,
        "epoch_time": drawing.epoch_time.isoformat(),
        "coordinates": drawing.frame.meaning,
    }


def _draw(document: "Document", feature: Feature) -> None:
    layer = _layer_name(feature)
    if layer not in document.layers:
        document.layers.add(layer, color=COLORS.get(feature.layer, 7))
    entity = _entity(document.modelspace(), feature.shape, layer)
    known = [f"{name}={value}" for name, value in feature.attributes.items() if value is not None]
    entity.set_xdata(APPLICATION, [(1000, _short(_one_line(text))) for text in known])
    if feature.label:
        _write_beside(document, feature)


def _entity(space: Any, shape: Shape, layer: str) -> Any:
    how = {"layer": layer}
    match shape:
        case Point(at):
            return space.add_point(at, how)
        case Line(start, end):
            return space.add_line(start, end, how)
        case Circle(center, radius_m):
            return space.add_circle(center, radius_m, how)
        case Ellipse(center, larger_m, smaller_m, azimuth_deg):
            turn = radians(azimuth_deg)
            larger = (larger_m * sin(turn), larger_m * cos(turn), 0.0)
            return space.add_ellipse(center, larger, smaller_m / larger_m, dxfattribs=how)


def _write_beside(document: "Document", feature: Feature) -> None:
    layer = f"{_layer_name(feature)}_text"
    if layer not in document.layers:
        document.layers.add(layer, color=7)
    # %% begins a control code in a TEXT
    text = _short(_one_line(feature.label)).replace("%%", "%")
    east, north, up = _beside(feature.shape)
    # upright, to be read from the south: flat on the ground the words of all slices would lie on one another
    how = {"layer": layer, "insert": (east, up, -north), "height": TEXT_HEIGHT_M, "extrusion": FROM_THE_SOUTH}
    document.modelspace().add_text(text, dxfattribs=how)


def _beside(shape: Shape) -> Position:
    match shape:
        case Point(at) | Line(_, at):
            return (at[0] + TEXT_HEIGHT_M, at[1], at[2])
        case Circle(center, reach_m) | Ellipse(center, reach_m):
            return (center[0] + reach_m + TEXT_HEIGHT_M, center[1], center[2])


def _layer_name(feature: Feature) -> str:
    name = "_".join(
        str(part) for part in (feature.layer, *(feature.attributes.get(key) for key in ("scheme", "method")))
    )
    return re.sub(r"[^A-Za-z0-9_.-]", "_", name)


def _one_line(text: str) -> str:
    """Text without signs that would end the line or begin a group of the file."""
    return re.sub(r"[\x00-\x1f\x7f\u2028\u2029\ud800-\udfff]+", " ", text)


def _short(text: str) -> str:
    while len(text.encode()) > LONGEST_TEXT:
        text = text[:-1]
    return text
