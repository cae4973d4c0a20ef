"""What the page in three dimensions asks for: itself, the scene as JSON, the points as bytes."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import flask
import numpy as np

from dashboard import numbers
from dashboard.address import Address, address_of
from dashboard.content.cloud import cloud_bytes
from dashboard.content.scene import Scene, scene_of
from dashboard.content.surface import SkinMap, range_mm, skin_map
from dashboard.reader import Reader
from dashboard.view import Site, View, open_view
from storage.errors import TiltwatchError, UsageError
from storage.views import station_rows, surface_map_rows
from storage.views.shaft_points import ShaftPoints, shaft_points

POINTS: Final = 1_000_000
"""Points that are sent to whoever names no number."""

MOST_POINTS: Final = 3_000_000
"""More than this takes a browser's memory for nothing."""

POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; "
    "connect-src 'self'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)

_HERE: Final = Path(__file__).parent
_STATIC: Final = {
    "page.js": ("page", "text/javascript"),
    "scene.js": ("page", "text/javascript"),
    "shaders.js": ("page", "text/javascript"),
    "labels.js": ("page", "text/javascript"),
    "panel.js": ("page", "text/javascript"),
    "page.css": ("page", "text/css"),
    "three.module.js": ("vendor", "text/javascript"),
    "three.core.js": ("vendor", "text/javascript"),
    "OrbitControls.js": ("vendor", "text/javascript"),
}
"""Files that the page may load, and what they are."""


def three_routes(reader: Reader, sites: Mapping[str, Site]) -> flask.Blueprint:
    """Make the addresses ``/3d``, ``/3d/scene.json``, ``/3d/points.bin`` and ``/3d/static/...``.

    The query is that of the other pages, and ``points``: at most so many are sent. What cannot be shown is answered by
    404 with the reason as plain text.
    """
    routes = flask.Blueprint("three", __name__)

    @routes.get("/3d")
    def page() -> flask.Response:
        return _file(_HERE / "page" / "page.html", "text/html")

    @routes.get("/3d/static/<name>")
    def static(name: str) -> flask.Response:
        if name not in _STATIC:
            return _refused("there is no such file")
        folder, kind = _STATIC[name]
        return _file(_HERE / folder / name, kind)

    @routes.get("/3d/scene.json")
    def scene() -> flask.Response:
        return _answered(reader, sites, _scene_answer)

    @routes.get("/3d/points.bin")
    def points() -> flask.Response:
        return _answered(reader, sites, _points_answer)

    return routes


def _answered(
    reader: Reader, sites: Mapping[str, Site], answer: Callable[[View], flask.Response]
) -> flask.Response:
    try:
        address = address_of("3d", flask.request.query_string.decode(errors="replace"))
        view = open_view(reader, address, sites)
        if view is None:
            raise UsageError(
                "the workspace holds no epoch yet; process the campaign with `tiltwatch run FILE`"
            )
        response = answer(view)
    except TiltwatchError as fault:
        return _refused(str(fault))
    response.headers["Cache-Control"] = "no-store"
    return response


def _points_answer(view: View) -> flask.Response:
    points = _points_of(view)
    scene = _scene_of(view, points)
    content = cloud_bytes(points, _wanted_points(view.address), scene.axis, scene.origin_m, _skin_of(view))
    return flask.Response(content, mimetype="application/octet-stream")


def _scene_answer(view: View) -> flask.Response:
    points = _points_of(view)
    scene, skin = _scene_of(view, points), _skin_of(view)
    return flask.jsonify(
        {
            "what": _what(view),
            "n_points": len(points),
            "asked_points": _wanted_points(view.address),
            "origin_m": scene.origin_m.tolist(),
            "top_m": scene.top_m,
            "axis": _axis_of(view, scene),
            "rings": [asdict(ring) for ring in scene.rings],
            "stations": [asdict(pin) for pin in scene.stations],
            "station_names": list(points.stations),
            "range_mm": None if skin is None else range_mm(skin.deviation_m),
            "links": {
                "back": view.asked.at("overview").href,
                "slice": view.asked.at("slice").href,
            },
        }
    )


def _what(view: View) -> dict[str, str]:
    """Names and states, as they are: the page inserts them as text."""
    return {
        "structure": view.structure,
        "name": view.site.name,
        "epoch": view.epoch.epoch,
        "day": numbers.day(view.epoch.epoch_time),
        "result": "/".join(view.result),
        "state": view.condition.level.name.lower(),
    }


def _axis_of(view: View, scene: Scene) -> dict[str, Any] | None:
    tilt = view.tilt()
    if tilt is None:
        return None
    direction = float(np.degrees(np.arctan2(*scene.axis.lean)) % 360.0)
    return {
        "lean": scene.axis.lean.tolist(),
        "lean_azimuth_deg": direction,
        "azimuth": numbers.degrees(tilt.azimuth_deg, 1),
        "tilt": numbers.dms(tilt.tilt_deg, 0),
        "deviation": numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m),
        "height_m": tilt.height_m,
    }


def _points_of(view: View) -> ShaftPoints:
    return view.reader.ask(shaft_points, view.structure, view.epoch.epoch)


def _scene_of(view: View, points: ShaftPoints) -> Scene:
    stations = view.reader.ask(station_rows, view.structure, view.epoch.epoch)
    return scene_of(points, view.tilt(), view.slices(), stations)


def _skin_of(view: View) -> SkinMap | None:
    return skin_map(view.reader.ask(surface_map_rows, view.structure, view.epoch.epoch))


def _wanted_points(address: Address) -> int:
    text = address.more.get("points", str(POINTS))
    if not text.isascii() or not text.isdigit() or not 1 <= int(text[:12]) <= MOST_POINTS:
        raise UsageError(f"points needs a number from 1 to {MOST_POINTS}; got {text[:40]!r}")
    return int(text)


def _file(path: Path, kind: str) -> flask.Response:
    response = flask.Response(path.read_bytes(), mimetype=kind)
    response.headers["Content-Security-Policy"] = POLICY
    response.headers["Cache-Control"] = "no-cache"
    response.add_etag()
    response.make_conditional(flask.request)
    return response


def _refused(reason: str) -> flask.Response:
    return flask.Response(f"{reason}\n", 404, mimetype="text/plain")
