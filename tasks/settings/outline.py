"""Names and paths of a campaign file, readable even where other parts of it are wrong."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tasks.settings.problems import Places


@dataclass(frozen=True, slots=True)
class Named:
    """A text of the file and the place where it stands."""

    where: str
    text: str


@dataclass(frozen=True, slots=True)
class NamedScan:
    """A scan file of an epoch, which scan of it where that is said, and the place where it stands."""

    where: str
    text: str
    part: str | int | None


@dataclass(frozen=True, slots=True)
class EpochOutline:
    """Names and scans of one epoch."""

    where: str
    is_reference: bool
    stations: tuple[Named, ...]
    sources: tuple[Named, ...]
    scans: tuple[NamedScan, ...]


@dataclass(frozen=True, slots=True)
class Outline:
    """Names and scans of a campaign file."""

    epochs: tuple[EpochOutline, ...]
    epoch_ids: tuple[Named, ...]
    schemes: tuple[str, ...]
    roots: tuple[str, ...]
    alarm_ids: tuple[Named, ...] = ()
    target_ids: tuple[Named, ...] = ()


def outline_of(raw: Mapping[str, object]) -> Outline:
    """Read the names and paths that are there and are texts."""
    places = Places(raw)
    epochs = tuple(_tables(raw, ("epochs",)))
    schemes = raw.get("schemes")
    files = raw.get("files")
    roots = files.get("roots") if isinstance(files, Mapping) else None
    return Outline(
        epochs=tuple(_epoch(places, location, epoch) for location, epoch in epochs),
        epoch_ids=tuple(_texts(places, epochs, "id")),
        schemes=tuple(schemes) if isinstance(schemes, Mapping) else (),
        roots=tuple(root for root in roots if isinstance(root, str)) if isinstance(roots, list) else (),
        alarm_ids=tuple(_texts(places, list(_tables(raw, ("alarms",))), "id")),
        target_ids=tuple(_texts(places, list(_tables(raw, ("notify",))), "id")),
    )


Location = tuple[str | int, ...]
Table = tuple[Location, Mapping[str, object]]


def _epoch(places: Places, location: Location, epoch: Mapping[str, object]) -> EpochOutline:
    stations = list(_tables(places.raw, (*location, "stations")))
    references = list(_tables(places.raw, (*location, "references")))
    return EpochOutline(
        where=places.name(location),
        is_reference=epoch.get("reference") is True,
        stations=tuple(_texts(places, stations, "id")),
        sources=tuple(_texts(places, references, "source")),
        scans=(*_scans(places, stations, "scan"), *_scans(places, [(location, epoch)], "registered")),
    )


def _tables(raw: object, location: Location) -> Iterator[Table]:
    here = raw
    for step in location:
        if isinstance(here, Mapping):
            here = here.get(step)
        elif isinstance(here, Sequence) and isinstance(step, int):
            here = here[step]
    if not isinstance(here, list):
        return
    for number, item in enumerate(here):
        if isinstance(item, Mapping):
            yield (*location, number), item


def _scans(places: Places, tables: Sequence[Table], key: str) -> Iterator[NamedScan]:
    for location, table in tables:
        for named in _texts(places, [(location, table)], key):
            part = table.get("part")
            yield NamedScan(named.where, named.text, part if isinstance(part, str | int) else None)


def _texts(places: Places, tables: Sequence[Table], key: str) -> Iterator[Named]:
    for location, table in tables:
        value = table.get(key)
        if isinstance(value, str):
            yield Named(places.name((*location, key)), value)
