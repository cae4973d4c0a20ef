"""What becomes of a scan that lies in an inbox: taken in, known already, or kept there with the reason."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Final

from storage.digests import file_sha256
from storage.errors import InputError, StorageError
from tasks.ingest import READERS, ScanRequest, describe_scan
from tasks.settings import Campaign, Epoch
from tasks.settings.epochs import SetUp, Station
from tasks.settings.intake import Arrival, Intake
from tasks.settings.problems import nearest
from tasks.settings.sidecar import Sidecar, load_sidecar, station_of

SCANS: Final = "inbox-scans"
"""Folder beside the campaign file for scans that came through an inbox: scans are data, a workspace is results."""

SCAN_SUFFIXES: Final = frozenset(suffix for reader in READERS.values() for suffix in reader.suffixes)


@dataclass(frozen=True, slots=True)
class ArrivedScan:
    """A scan of the inbox that is whole by its sidecar and by its own header."""

    path: Path
    sidecar: Sidecar
    sha256: str
    size_bytes: int
    n_points: int | None

    @property
    def station(self) -> str:
        """Id of the station."""
        return str(self.sidecar.id)


@dataclass(frozen=True, slots=True)
class KnownScan:
    """The scan was taken in before: for which station of which epoch, under which name."""

    epoch: str
    station: str
    name: str


@dataclass(frozen=True, slots=True)
class KeptScan:
    """Why a scan stays in the inbox, and what to do."""

    reason: str


@dataclass(frozen=True, slots=True)
class TakenScan:
    """The intake with the new station, and where its scan is to lie."""

    intake: Intake
    target: Path


def inspect_scan(path: Path, sidecar_path: Path, digest: str | None = None) -> ArrivedScan:
    """Check a scan against its sidecar and its own header, without reading its points.

    Parameters
    ----------
    path, sidecar_path
        The two files.
    digest
        SHA-256 of the scan, where it is known already.

    Raises
    ------
    InputError
        If the sidecar is bad, digest or size are not what it says, or the header shows that the scan is not whole.
    StorageError
        If the scan cannot be read.
    """
    sidecar = load_sidecar(sidecar_path, path.name)
    size_bytes = _size_of(path)
    if sidecar.size_bytes is not None and sidecar.size_bytes != size_bytes:
        raise InputError(
            f"{path}: needed {sidecar.size_bytes} bytes by its sidecar, came {size_bytes}; send the scan again"
        )
    sha256 = digest or file_sha256(path)
    if sidecar.sha256 is not None and sidecar.sha256 != sha256:
        raise InputError(
            f"{path}: needed the digest {sidecar.sha256[:12]}... by its sidecar, came {sha256[:12]}...; send the scan again"
        )
    return ArrivedScan(path, sidecar, sha256, size_bytes, _points_by_header(path, sidecar))


def request_of(set_up: SetUp) -> ScanRequest:
    """How the scan of a station is read."""
    return ScanRequest(
        coordinates=set_up.coordinates,
        part=set_up.part,
        levelling="file" if set_up.pose == "file" else "scanner",
    )


def _points_by_header(path: Path, sidecar: Sidecar) -> int | None:
    header = describe_scan(path, request_of(sidecar))
    if header.n_points == 0:
        raise InputError(f"{path}: holds no points; export the scan again")
    if sidecar.pose == "file" and not any(part.pose is not None for part in header.parts):
        raise InputError(
            f'{path}: states no pose, which pose = "file" needs; write position_m and heading_deg into the sidecar'
        )
    return header.n_points


def known_as(scan: ArrivedScan, intakes: Sequence[Intake]) -> KnownScan | None:
    """Say for which station the same file was taken in before; two stations may name different scans of one file."""
    for intake in intakes:
        parts = {station.id: station.part for station in intake.stations}
        for arrival in intake.arrivals:
            if arrival.sha256 == scan.sha256 and parts.get(arrival.station) == scan.sidecar.part:
                return KnownScan(intake.epoch, arrival.station, arrival.name)
    return None


def take_in(
    scan: ArrivedScan, campaign: Campaign, intakes: Sequence[Intake], now: datetime
) -> TakenScan | KeptScan:
    """Decide whether a scan fits the campaign and what came before it.

    Parameters
    ----------
    scan
        As ``inspect_scan`` found it, and not known.
    campaign
        The campaign file alone, without what came through the inbox.
    intakes
        What came through the inbox so far.
    now
        Time of the arrival.
    """
    listed = campaign.epoch(scan.sidecar.epoch)
    before = next((intake for intake in intakes if intake.epoch == scan.sidecar.epoch), None)
    problems = [
        *_other_case(scan.sidecar.epoch, campaign, intakes),
        *(_against_listed(scan, listed, campaign) if listed is not None else ()),
        *(_against_intake(scan, before) if before is not None else ()),
    ]
    if problems:
        return KeptScan("; ".join(problems))
    text = _scan_text(scan, listed, campaign)
    return TakenScan(_with_station(scan, before, text, now), campaign.scan_path(text))


def expected_stations(intake: Intake, campaign: Campaign) -> tuple[str, ...]:
    """Ids of the stations that an epoch is to have: by the campaign file, else by its sidecars; empty where nobody says."""
    listed = campaign.epoch(intake.epoch)
    return intake.expected if listed is None else tuple(station.id for station in listed.stations)


def missing_stations(intake: Intake, campaign: Campaign) -> tuple[str, ...]:
    """Ids of the stations that are still to come; those whose scans lie where the campaign file says are there."""
    listed = campaign.epoch(intake.epoch)
    there = set(intake.arrived)
    if listed is not None:
        there |= {station.id for station in listed.stations if campaign.scan_path(station.scan).is_file()}
    return tuple(name for name in expected_stations(intake, campaign) if name not in there)


def _against_listed(scan: ArrivedScan, listed: Epoch, campaign: Campaign) -> Iterator[str]:
    """What speaks against a scan for an epoch that the campaign file has."""
    if listed.registered is not None:
        yield f"the campaign file has epoch {listed.id} as one registered cloud; name another epoch"
        return
    if listed.time != scan.sidecar.time:
        yield _two_times(scan, listed.time.isoformat(), "the campaign file")
    station = next((station for station in listed.stations if station.id == scan.station), None)
    if station is None:
        hint = nearest(scan.station, [station.id for station in listed.stations])
        yield f"the campaign file has epoch {listed.id} without a station {scan.station!r}; {hint}, or name another epoch"
    elif (
        campaign.scan_path(station.scan).is_file()
        and file_sha256(campaign.scan_path(station.scan)) != scan.sha256
    ):
        yield (
            f"the campaign file has the scan of station {station.id} of epoch {listed.id} already, another file: "
            f"{station.scan}; name another epoch or station"
        )
    else:
        yield from _contradictions(scan, station)


def _contradictions(scan: ArrivedScan, station: Station) -> Iterator[str]:
    own = station.model_dump(exclude_unset=True, exclude={"id", "scan"})
    for key, value in own.items():
        stated = getattr(scan.sidecar, key)
        if key in scan.sidecar.model_fields_set and stated != value:
            yield f"{key} is {stated!r} in the sidecar and {value!r} in the campaign file; put one of them right"


def _against_intake(scan: ArrivedScan, before: Intake) -> Iterator[str]:
    if before.time != scan.sidecar.time:
        yield _two_times(scan, before.time.isoformat(), "the sidecars that came before it")
    taken = next((name for name in before.arrived if name.casefold() == scan.station.casefold()), None)
    if taken is not None:
        yield (
            f"station {taken} of epoch {before.epoch} is there already, with another scan; choose another id, or take the "
            "first one out of the intake folder of the workspace"
        )
    wanted = scan.sidecar.of
    if wanted is not None and before.expected and set(wanted) != set(before.expected):
        yield f"lists the stations {', '.join(wanted)}, sidecars before it {', '.join(before.expected)}; agree on one list"
    strangers = [name for name in before.arrived if wanted is not None and name not in wanted]
    if strangers:
        yield f"lists the stations {', '.join(wanted or ())}, but {', '.join(strangers)} came before; list all of them"
    if before.expected and scan.station not in before.expected:
        yield f"the sidecars before it list no station {scan.station!r}; {nearest(scan.station, before.expected)}"


def _two_times(scan: ArrivedScan, other: str, where: str) -> str:
    return (
        f"epoch {scan.sidecar.epoch} has the time {scan.sidecar.time.isoformat()} in the sidecar and {other} in {where}; "
        "all stations of an epoch have one time, that of the epoch"
    )


def _other_case(epoch: str, campaign: Campaign, intakes: Sequence[Intake]) -> Iterator[str]:
    """An epoch whose id differs from a known one by its case alone is a slip, and no folder on every system."""
    known = {one.id for one in campaign.epochs} | {intake.epoch for intake in intakes}
    for name in sorted(known - {epoch}):
        if name.casefold() == epoch.casefold():
            yield f"there is an epoch {name!r} (only the case differs); write it so"


def _scan_text(scan: ArrivedScan, listed: Epoch | None, campaign: Campaign) -> str:
    """Where the campaign file awaits the scan; else in the folder of its epoch. Relative to the campaign file."""
    suffix = scan.path.suffix.lower()
    if listed is not None:
        station = next(station for station in listed.stations if station.id == scan.station)
        if Path(station.scan).suffix.lower() == suffix:
            return station.scan
    return f"{SCANS}/{campaign.structure.id}/{scan.sidecar.epoch}/{scan.station}{suffix}"


def _with_station(scan: ArrivedScan, before: Intake | None, path: str, now: datetime) -> Intake:
    station = Station.model_validate(station_of(scan.sidecar, path))
    arrival = Arrival(
        station=scan.station,
        name=scan.path.name,
        sha256=scan.sha256,
        size_bytes=scan.size_bytes,
        n_points=scan.n_points,
        arrived=now,
    )
    intake = before or Intake(epoch=scan.sidecar.epoch, time=scan.sidecar.time, first_arrival=now)
    changes: Mapping[str, object] = {
        "expected": scan.sidecar.of or intake.expected,
        "stations": (*intake.stations, station),
        "arrivals": (*intake.arrivals, arrival),
    }
    return intake.model_copy(update=changes)


def _size_of(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError as fault:
        raise StorageError(f"cannot read {path}: {fault.strerror}") from fault
