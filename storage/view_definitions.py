"""The views of the catalog: what a row is, its columns, its SQL."""

from dataclasses import dataclass
from importlib.resources import files
from typing import Final

from storage.change import ChangeRow
from storage.errors import UsageError
from storage.records import TABLES, AlarmRow, EpochRow
from storage.surface_change import SurfaceChangeRow
from storage.version import VersionChangeRow, VersionRow, VersionTiltRow

VIEWS: Final[dict[str, type]] = {
    **TABLES,
    "alarms": AlarmRow,
    "changes": ChangeRow,
    "surface_changes": SurfaceChangeRow,
    "latest": EpochRow,
    "versions": VersionRow,
    "version_tilt": VersionTiltRow,
    "version_changes": VersionChangeRow,
}
"""View name to the record class that states its columns, units and meanings."""


@dataclass(frozen=True, slots=True)
class ViewDefinition:
    """A view as it stands in its file."""

    name: str
    row_is: str
    sql: str


def view_definition(name: str) -> ViewDefinition:
    """Read the file of a view; its first line says what a row is.

    Raises
    ------
    UsageError
        If there is no such view.
    """
    if name not in VIEWS:
        raise UsageError(f"unknown view {name!r}; known: {', '.join(VIEWS)}")
    sql = files("storage").joinpath("views", f"{name}.sql").read_text("utf-8")
    return ViewDefinition(name, sql.splitlines()[0].removeprefix("--").strip(), sql)
