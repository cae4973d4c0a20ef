"""Files over HTTP: whole views, and the report of an epoch."""

from collections.abc import Mapping
from typing import Final

import flask

from dashboard.reader import Reader
from dashboard.view import Site
from storage.errors import TiltwatchError, UsageError
from storage.views import epoch_rows, latest_epochs
from storage.views.files import view_file

VIEW_FORMATS: Final = {
    "csv": "text/csv",
    "parquet": "application/vnd.apache.parquet",
    "json": "application/json",
}
REPORT_FORMATS: Final = {"pdf": "application/pdf", "html": "text/html"}


def serve_files(server: flask.Flask, reader: Reader, sites: Mapping[str, Site]) -> None:
    """Add ``/view/NAME.csv?structure=ID`` and ``/report/STRUCTURE/EPOCH.pdf?lang=en``.

    Views are written as ``tiltwatch export`` writes them (csv, json, parquet), reports as ``tiltwatch report`` (pdf, html).
    """

    @server.get("/view/<file>")
    def view(file: str) -> flask.Response:
        name, _, kind = file.rpartition(".")
        structure = flask.request.args.get("structure", "")
        try:
            _check_structure(reader, structure)
            content = view_file(reader.workspace, name, structure, kind)
        except TiltwatchError as fault:
            return _not_found(fault)
        return _attached(content, f"{structure}-{name}.{kind}", VIEW_FORMATS[kind])

    @server.get("/report/<structure>/<file>")
    def report(structure: str, file: str) -> flask.Response:
        # an epoch may have dots in its name
        epoch, _, kind = file.rpartition(".")
        language = flask.request.args.get("lang", "en")
        try:
            content = _report(reader, sites, (structure, epoch), kind, language)
        except TiltwatchError as fault:
            return _not_found(fault)
        return _attached(content, f"{structure}-{epoch}.{kind}", REPORT_FORMATS[kind])


def _report(
    reader: Reader, sites: Mapping[str, Site], of: tuple[str, str], kind: str, language: str
) -> bytes:
    structure, epoch = of
    _check_structure(reader, structure)
    if all(row.epoch != epoch for row in reader.ask(epoch_rows, structure)):
        raise UsageError(f"unknown epoch {epoch!r} of {structure}")
    if kind not in REPORT_FORMATS:
        raise UsageError(f"unknown kind of report {kind!r}; known: {', '.join(REPORT_FORMATS)}")
    site = sites.get(structure)
    if site is None or site.report is None:
        raise UsageError(
            f"the campaign file of {structure} is not at hand; name it, too, at `tiltwatch dashboard`"
        )
    return site.report(epoch, kind, language)


def _check_structure(reader: Reader, structure: str) -> None:
    if reader.stamp is None or all(row.structure != structure for row in reader.ask(latest_epochs)):
        raise UsageError(f"unknown structure {structure!r}")


def _attached(content: bytes, name: str, kind: str) -> flask.Response:
    response = flask.Response(content, mimetype=kind)
    response.headers.set("Content-Disposition", "attachment", filename=name)
    return response


def _not_found(fault: TiltwatchError) -> flask.Response:
    return flask.Response(f"{fault}\n", 404, mimetype="text/plain")
