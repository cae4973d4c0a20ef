"""Epochs that came through an inbox: kept in the workspace, and seen beside those of the campaign file.

The campaign file is the user's and is never written. What it says itself counts; of an epoch that it lists beforehand,
with scans that are not there yet, the intake says what it leaves open.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import AwareDatetime, Field, ValidationError

from storage.errors import InputError
from storage.ids import check_id
from storage.intake import intake_files
from storage.workspace import Workspace
from tasks.settings.campaign import Campaign
from tasks.settings.epochs import EpochTime, Station
from tasks.settings.outline import outline_of
from tasks.settings.problems import problems_of
from tasks.settings.reading import campaign_of
from tasks.settings.scan_paths import resolve_scan
from tasks.settings.section import SafeId, Section
from tasks.settings.toml_file import input_error, read_toml
from tasks.settings.toml_text import toml_text

COMMENT: Final = (
    "Taken in by `tiltwatch watch`: an epoch of the campaign beside those of its file. To take a station out again,\n"
    "delete its two tables here. To change what a sidecar said, change it here."
)

Tables = tuple[dict[str, object], ...]


class Arrival(Section):
    """How a station came."""

    station: SafeId = Field(description="id of the station")
    name: str = Field(description="name of the scan's file in the inbox")
    sha256: str = Field(description="SHA-256 of the scan's file in hex")
    size_bytes: int = Field(ge=0, description="size of the scan's file [byte]")
    n_points: int | None = Field(
        default=None, ge=0, description="points by the scan's header, where it says so [1]"
    )
    arrived: AwareDatetime = Field(description="when it was taken in")


class Intake(Section):
    """An epoch that came through an inbox, whole or in part."""

    schema_version: Literal[1] = Field(default=1, description="version of this file's form; 1")
    epoch: SafeId = Field(description="id of the epoch")
    time: EpochTime = Field(description="time of measuring")
    first_arrival: AwareDatetime = Field(description="when its first station was taken in")
    expected: Annotated[tuple[SafeId, ...], Field(strict=False)] = Field(
        default=(), description="ids of all its stations, where the sidecars list them"
    )
    complete: Literal["stations", "marker"] | None = Field(
        default=None, description="why no more stations are awaited; missing while they are"
    )
    stations: Annotated[tuple[Station, ...], Field(strict=False)] = Field(
        default=(), description="as in the campaign file"
    )
    arrivals: Annotated[tuple[Arrival, ...], Field(strict=False)] = Field(
        default=(), description="how they came"
    )

    @property
    def arrived(self) -> tuple[str, ...]:
        """Ids of the stations that are there, in the order in which they came."""
        return tuple(station.id for station in self.stations)


def intake_text(intake: Intake) -> str:
    """Write an epoch that was taken in as TOML."""
    table = intake.model_dump(exclude_none=True, exclude={"stations"})
    arrivals = table.pop("arrivals")
    return toml_text(COMMENT, {**table, "stations": _station_tables(intake), "arrivals": arrivals})


def read_intakes(workspace: Path, structure: str) -> tuple[Intake, ...]:
    """Read the epochs of a structure that came through an inbox, by time; none where there is no workspace.

    Raises
    ------
    InputError
        If a file of theirs is damaged.
    """
    files = intake_files(Workspace(workspace.expanduser().resolve()), structure)
    return tuple(sorted((read_intake(file) for file in files), key=lambda intake: intake.time))


def read_intake(file: Path) -> Intake:
    """Read the file of an epoch that came through an inbox.

    Raises
    ------
    InputError
        If it is damaged.
    """
    raw = read_toml(file)
    try:
        return Intake.model_validate(raw)
    except ValidationError as error:
        raise input_error(file, list(problems_of(error, raw, Intake))) from error


def load_with_intake(file: Path, workspace: Path) -> Campaign:
    """Read a campaign file together with the complete epochs that came through an inbox.

    Raises
    ------
    InputError
        If the file, an intake or both together are bad; one line for every problem.
    """
    raw = read_toml(file)
    intakes = [intake for intake in _intakes_of(raw, workspace) if intake.complete is not None]
    return campaign_of(merged(raw, intakes, file), file)


def load_awaiting(file: Path) -> Campaign:
    """Read a campaign file as a watch does: it may be without epochs.

    Raises
    ------
    InputError
        If the file is bad.
    """
    return campaign_of(_with_epochs(read_toml(file), ()), file, awaits_epochs=True)


def check_intakes(file: Path, intakes: Sequence[Intake]) -> Campaign:
    """Check a campaign file together with epochs that came through an inbox, complete or not.

    Raises
    ------
    InputError
        If both together are bad; one line for every problem.
    """
    together = merged(read_toml(file), intakes, file)
    return campaign_of(_with_epochs(together, ()), file, awaits_epochs=True)


def merged(raw: Mapping[str, object], intakes: Sequence[Intake], file: Path) -> Mapping[str, object]:
    """Put epochs that came through an inbox beside those of a campaign file, or into those that it lists beforehand.

    Raises
    ------
    InputError
        If the campaign file lists an epoch without a station that came for it.
    """
    if not intakes:
        return raw
    epochs = raw.get("epochs", [])
    if not isinstance(epochs, list):
        return raw
    by_id = {intake.epoch: intake for intake in intakes}
    listed = {epoch.get("id") for epoch in epochs if isinstance(epoch, dict)}
    own = [_filled_in(epoch, by_id, raw, file) for epoch in epochs]
    new = [_as_table(intake) for intake in intakes if intake.epoch not in listed]
    return _with_epochs(raw, (*own, *new))


def _intakes_of(raw: Mapping[str, object], workspace: Path) -> tuple[Intake, ...]:
    structure = raw.get("structure")
    name = structure.get("id") if isinstance(structure, dict) else None
    if not isinstance(name, str):
        return ()
    try:
        check_id(name, "a structure")
    except InputError:
        # said when the campaign file is checked
        return ()
    return read_intakes(workspace, name)


def _with_epochs(raw: Mapping[str, object], epochs: Sequence[object]) -> Mapping[str, object]:
    return {**raw, "epochs": list(epochs) if epochs else raw.get("epochs", [])}


def _as_table(intake: Intake) -> dict[str, object]:
    return {"id": intake.epoch, "time": intake.time, "stations": _station_tables(intake)}


def _station_tables(intake: Intake) -> list[dict[str, object]]:
    """Tables of the stations with what was stated of them, id and scan first."""
    return [
        {"id": station.id, "scan": station.scan, **station.model_dump(exclude_unset=True, exclude_none=True)}
        for station in intake.stations
    ]


def _filled_in(epoch: object, by_id: Mapping[str, Intake], raw: Mapping[str, object], file: Path) -> object:
    """An epoch of the campaign file with what came for it; its own words count."""
    intake = by_id.get(str(epoch.get("id"))) if isinstance(epoch, dict) else None
    if intake is None or not isinstance(epoch, dict):
        return epoch
    came = {str(table["id"]): table for table in _tables(_as_table(intake))}
    stations = list(_tables(epoch))
    strangers = sorted(came.keys() - {table.get("id") for table in stations})
    if strangers:
        raise InputError(
            f"{file}: epochs[{intake.epoch}]: station {strangers[0]} came for it through the inbox and is not in its table; "
            "add it there, or take it out of the intake folder of the workspace"
        )
    return {**epoch, "stations": list(_stations(stations, came, raw, file))}


def _stations(
    stations: Sequence[dict[str, object]],
    came: Mapping[str, dict[str, object]],
    raw: Mapping[str, object],
    file: Path,
) -> Iterator[dict[str, object]]:
    for table in stations:
        intake = came.get(str(table.get("id")), {})
        own = {key: value for key, value in table.items() if key != "scan"}
        there = not intake or _is_there(str(table.get("scan")), raw, file)
        yield {**intake, **own, "scan": table.get("scan") if there else intake["scan"]}


def _is_there(scan: str, raw: Mapping[str, object], file: Path) -> bool:
    try:
        return resolve_scan(scan, file.absolute().parent, outline_of(raw).roots).is_file()
    except (InputError, OSError):
        # said when the whole is checked, or when the scan is read: a name may be too long, a folder closed
        return True


def _tables(epoch: Mapping[str, object]) -> Iterator[dict[str, object]]:
    stations = epoch.get("stations")
    yield from (table for table in stations if isinstance(table, dict)) if isinstance(stations, list) else ()
