"""A drawing as GeoJSON: longitude and latitude where the frame is a projected system, else the metres of the site."""

import json
from collections.abc import Callable, Sequence
from math import cos, pi, radians, sin
from typing import Any, Final

from storage.drawing.content import Circle, Drawing, DrawingFrame, Ellipse, Feature, Line, Point, Position
from storage.drawing.projected_system import projected_system

NAME: Final = "geojson"

RING_VERTICES: Final = 72
DEGREE_DIGITS: Final = 10
"""1e-10 degrees are 0.01 mm."""
METRE_DIGITS: Final = 5

Placing = Callable[[Sequence[Position]], list[list[float]]]


def encode(drawing: Drawing) -> bytes:
    """GeoJSON of a drawing; circles become polygons of 72 vertices that lie on them.

    RFC 7946 knows WGS 84 only. Of a local frame nothing could lead there: its coordinates stay metres, and the member
    ``coordinates_are`` says so.
    """
    place, meaning = _placing(drawing.frame)
    content = {
        "type": "FeatureCollection",
        "coordinates_are": meaning,
        "name": f"{drawing.structure} {drawing.epoch} {drawing.what}",
        "features": [_feature(drawing, feature, place) for feature in drawing.features],
    }
    return json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False).encode() + b"\n"


def _feature(drawing: Drawing, feature: Feature, place: Placing) -> dict[str, Any]:
    known = {
        "structure": drawing.structure,
        "epoch": drawing.epoch,
        "epoch_time": drawing.epoch_time.isoformat(),
        "layer": feature.layer,
        **feature.attributes,
    }
    return {"type": "Feature", "geometry": _geometry(feature, place), "properties": known}


def _geometry(feature: Feature, place: Placing) -> dict[str, Any]:
    match feature.shape:
        case Point(at):
            return {"type": "Point", "coordinates": place([at])[0]}
        case Line(start, end):
            return {"type": "LineString", "coordinates": place([start, end])}
        case Circle(center, radius_m):
            ring = _ring(Ellipse(center, radius_m, radius_m, 0.0))
        case Ellipse() as ellipse:
            ring = _ring(ellipse)
    return {"type": "Polygon", "coordinates": [place(ring)]}


def _ring(ellipse: Ellipse) -> list[Position]:
    """Vertices counterclockwise, the first again at the end."""
    east, north, up = ellipse.center
    c, s = cos(radians(ellipse.azimuth_deg)), sin(radians(ellipse.azimuth_deg))
    ring = []
    for number in range(RING_VERTICES):
        turn = 2 * pi * number / RING_VERTICES
        along, left = ellipse.larger_m * cos(turn), ellipse.smaller_m * sin(turn)
        ring.append((east + s * along - c * left, north + c * along + s * left, up))
    return [*ring, ring[0]]


def _placing(frame: DrawingFrame) -> tuple[Placing, str]:
    if frame.epsg is None:
        return (
            _as_metres,
            f"{frame.meaning}: not longitude and latitude, GeoJSON has no place for such a frame",
        )
    from pyproj import Transformer  # noqa: PLC0415 (slow to import)

    to_wgs84 = Transformer.from_crs(projected_system(frame.epsg), "EPSG:4326", always_xy=True)

    def place(positions: Sequence[Position]) -> list[list[float]]:
        easts, norths = ([position[axis] for position in positions] for axis in (0, 1))
        places = zip(*to_wgs84.transform(easts, norths, errcheck=True), positions, strict=True)
        return [
            [
                round(longitude, DEGREE_DIGITS),
                round(latitude, DEGREE_DIGITS),
                round(position[2], METRE_DIGITS),
            ]
            for longitude, latitude, position in places
        ]

    accuracy = f", to {to_wgs84.accuracy:g} m" if to_wgs84.accuracy > 0 else ""
    return place, (
        f"longitude and latitude, WGS 84, from EPSG:{frame.epsg} by {to_wgs84.description}{accuracy}; "
        "heights as the campaign states them, in metres, not above the ellipsoid"
    )


def _as_metres(positions: Sequence[Position]) -> list[list[float]]:
    return [[round(value, METRE_DIGITS) for value in position] for position in positions]
