"""The dashboard: one page frame, filled anew when the address or the catalog changes."""

import json
import logging
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

import flask
from dash import ALL, Dash, Input, Output, State, callback_context, dcc, html, no_update
from dash.development.base_component import Component
from plotly.utils import PlotlyJSONEncoder

from dashboard.address import Address, address_of
from dashboard.downloads import serve_files
from dashboard.filled import Content, FilledPages
from dashboard.page import pages
from dashboard.reader import Reader
from dashboard.shell import CHOICES, message_frame
from dashboard.slides import follow_slides
from dashboard.three.routes import three_routes
from dashboard.view import Site, View, open_view
from storage.errors import TiltwatchError, UsageError
from storage.workspace import Workspace

LOOK_EVERY_MS: Final = 3000
"""How often an open page asks whether there is a newer catalog."""

NO_CATALOG: Final = "none yet"

_LOG: Final = logging.getLogger("tiltwatch.dashboard")


def make_app(workspace: Workspace, sites: Mapping[str, Site]) -> Dash:
    """Make the application over a workspace.

    Parameters
    ----------
    workspace : Workspace
        Its catalog is read, nothing is written.
    sites : mapping
        Structure to what its campaign file says; structures without one are shown with their ids. The first that has
        an epoch is shown to whoever asks for none.
    """
    reader = Reader(workspace)
    filled = FilledPages(reader, sites)
    app = Dash(
        __name__,
        title="tiltwatch",
        update_title=None,  # type: ignore[arg-type]
        assets_folder=str(Path(__file__).parent / "assets"),
        serve_locally=True,
        suppress_callback_exceptions=True,
        meta_tags=[{"name": "viewport", "content": "width=device-width, initial-scale=1"}],
    )
    app.layout = _layout
    _fill_pages(app, reader, filled)
    _follow_catalog(app, reader)
    _follow_choices(app)
    _follow_clicks(app)
    follow_slides(app)
    _serve_tables(app.server, reader, sites)
    serve_files(app.server, reader, sites)
    app.server.register_blueprint(three_routes(reader, sites))
    _warm(filled)
    return app


def _warm(filled: FilledPages) -> None:
    """Fill the first page before the first visitor comes: drawing for the first time takes a second and a half."""
    try:
        json.dumps(filled.at(Address()), cls=PlotlyJSONEncoder)
    except TiltwatchError as fault:
        _LOG.warning("%s", fault)
    except Exception:  # it is told to whoever visits; the other pages work
        _LOG.exception("the first page")


def _layout() -> Component:
    return html.Div(
        [
            dcc.Location(id="url", refresh="callback-nav"),
            dcc.Store(id="stamp"),
            dcc.Store(id="newer"),
            dcc.Interval(id="tick", interval=LOOK_EVERY_MS),
            html.Div(html.P("reading the catalog …", className="message"), id="app", className="app"),
        ]
    )


def _fill_pages(app: Dash, reader: Reader, filled: FilledPages) -> None:
    @app.callback(
        Output("app", "children"),
        Output("stamp", "data"),
        Input("url", "pathname"),
        Input("url", "search"),
        Input("newer", "data"),
    )
    def fill(pathname: str | None, search: str | None, _newer: str | None) -> tuple[Content, str]:
        stamp = reader.stamp
        try:
            content: Content = filled.at(address_of(pathname or "/", search or ""))
        except TiltwatchError as fault:
            link = dcc.Link("to the overview", href="/overview")
            content = message_frame("This cannot be shown", str(fault), [link])
        except Exception:  # one page's fault must not leave the reader before an empty window
            _LOG.exception("page %s%s", pathname, search)
            text = (
                "A fault of the program; the log of `tiltwatch dashboard` tells which. The other pages work."
            )
            content = message_frame("This page failed", text, [dcc.Link("to the overview", href="/overview")])
        return content, stamp or NO_CATALOG


def _follow_catalog(app: Dash, reader: Reader) -> None:
    @app.callback(
        Output("newer", "data"),
        Input("tick", "n_intervals"),
        State("stamp", "data"),
        prevent_initial_call=True,
    )
    def look(_n_intervals: int | None, shown: str | None) -> Any:
        stamp = reader.stamp or NO_CATALOG
        # before anything is shown the page is being filled anyway
        return no_update if shown in (None, stamp) else stamp


def _follow_choices(app: Dash) -> None:
    @app.callback(
        Output("url", "href", allow_duplicate=True),
        *[Input(f"choose-{name}", "value") for name in CHOICES],
        State("url", "pathname"),
        State("url", "search"),
        prevent_initial_call=True,
    )
    def choose(*given: str | None) -> Any:
        structure, epoch, reference, result, pathname, search = given
        now = address_of(pathname or "/", search or "")
        chosen = {item["prop_id"].split(".")[0] for item in callback_context.triggered}
        then = now
        if "choose-structure" in chosen and structure and structure != now.structure:
            then = Address(page=now.page, structure=structure)
        elif "choose-epoch" in chosen:
            then = now.choosing(epoch=epoch or None)
        elif "choose-reference" in chosen:
            then = now.choosing(reference=reference or None)
        elif "choose-result" in chosen:
            scheme, _, method = (result or "").partition("/")
            # a slice's number means another height under another scheme
            more = {key: value for key, value in now.more.items() if key != "slice"}
            then = replace(now, scheme=scheme or None, method=method or None, more=more)
        # a page that was just filled reports its choices, too
        return no_update if len(chosen) != 1 or then == now else then.href


def _follow_clicks(app: Dash) -> None:
    @app.callback(
        Output("url", "href", allow_duplicate=True),
        Input({"type": "drawing", "panel": ALL}, "clickData"),
        prevent_initial_call=True,
    )
    def open_point(_clicks: list[object]) -> Any:
        for item in callback_context.triggered:
            points = (item["value"] or {}).get("points", [])
            href = next((_href_in(point.get("customdata")) for point in points), None)
            if href is not None:
                return href
        return no_update


def _href_in(customdata: object) -> str | None:
    """The address behind a point, where it has one: the last item, and only an address of our own."""
    last = customdata[-1] if isinstance(customdata, list) and customdata else customdata
    if not isinstance(last, str) or not last.startswith("/") or last.startswith("//"):
        return None
    return last if urlsplit(last).path.strip("/") in pages() else None


def _serve_tables(server: flask.Flask, reader: Reader, sites: Mapping[str, Site]) -> None:
    @server.get("/csv/<page>/<panel>")
    def table(page: str, panel: str) -> flask.Response:
        try:
            view = _view_of(reader, sites, page)
            found = next((part for part in pages()[page].fill(view) if part.name == panel), None)
        except TiltwatchError as fault:
            return flask.Response(f"{fault}\n", 404, mimetype="text/plain")
        if found is None or found.table is None:
            return flask.Response(f"page {page} shows no such table\n", 404, mimetype="text/plain")
        name = "-".join((view.structure, view.epoch.epoch, page, panel))
        response = flask.Response(found.table.as_csv(), mimetype="text/csv")
        response.headers.set("Content-Disposition", "attachment", filename=f"{name}.csv")
        return response


def _view_of(reader: Reader, sites: Mapping[str, Site], page: str) -> View:
    address = address_of(page, flask.request.query_string.decode())
    view = open_view(reader, address, sites) if page in pages() else None
    if view is None:
        raise UsageError(f"there is no page {page!r}, or no epoch yet")
    return view
