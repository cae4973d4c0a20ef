"""Scans of the inbox: each is taken in, or kept there with the reason; after each, what the crew should know."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from flows.watch.events import Now, Teller, WatchEvent, fault_in_words
from flows.watch.file_kinds import is_marker, is_scan, is_sidecar
from flows.watch.place import WatchPlace
from flows.watch.preview_text import preview_lines
from storage.digests import file_sha256
from storage.errors import StorageError, TiltwatchError
from storage.inbox import InboxFile
from storage.intake import intake_files, write_intake, write_preview
from tasks.arrivals import (
    ArrivedScan,
    KeptScan,
    KnownScan,
    TakenScan,
    inspect_scan,
    known_as,
    missing_stations,
    take_in,
)
from tasks.settings.intake import Intake, check_intakes, intake_text, load_awaiting, read_intakes
from tasks.settings.sidecar import SUFFIX
from tasks.site_preview import StationLook, look_at_station, preview, preview_facts

Stamp = tuple[object, ...]

UNKNOWN: Final = "is neither a scan, nor a sidecar (.toml), nor a marker (.complete); it is left alone"


@dataclass(frozen=True, slots=True)
class ScanPair:
    """A scan of the inbox and its sidecar, where that is there."""

    scan: InboxFile
    sidecar: InboxFile | None


class Stations:
    """Takes scans in; what was looked at already is looked at again only when something changed."""

    def __init__(self, place: WatchPlace, teller: Teller, now: Now) -> None:
        self._place = place
        self._teller = teller
        self._now = now
        self._seen: dict[str, Stamp] = {}
        self._digests: dict[tuple[str, tuple[int, int]], str] = {}
        self._looks: dict[str, StationLook] = {}

    def take(self, files: Sequence[InboxFile], settled: frozenset[str]) -> None:
        """Take in what has come to rest."""
        for pair in pairs_of(files):
            if pair.scan.name not in settled or (pair.sidecar and pair.sidecar.name not in settled):
                continue
            stamp = self._stamp(pair)
            if self._seen.get(pair.scan.name) != stamp and self._take_or_keep(pair):
                self._seen[pair.scan.name] = stamp
        self._tell_lone_sidecars(files, settled)
        self._tell_strangers(files, settled)

    def _stamp(self, pair: ScanPair) -> Stamp:
        """Changes when the scan, its sidecar, the campaign file or an intake does."""
        around = (self._place.campaign_file, *intake_files(self._place.workspace, self._place.structure))
        return (
            pair.scan.stamp,
            pair.sidecar and pair.sidecar.stamp,
            *((path.name, path.stat().st_mtime_ns) for path in around if path.exists()),
        )

    def _take_or_keep(self, pair: ScanPair) -> bool:
        """Whether that is all that can be done before something changes; a full disk may have room at the next look."""
        try:
            self._take_one(pair)
        except StorageError as fault:
            self._keep(pair.scan.name, str(fault))
            return False
        except TiltwatchError as fault:
            self._keep(pair.scan.name, str(fault))
        except Exception as fault:
            self._keep(pair.scan.name, fault_in_words(fault))
        return True

    def _take_one(self, pair: ScanPair) -> None:
        scan, sidecar = pair.scan, pair.sidecar
        if sidecar is None:
            wanted = Path(scan.name).with_suffix(SUFFIX).name
            self._wait(scan.name, f"waits for its sidecar {wanted}")
            return
        intakes = read_intakes(self._place.workspace.root, self._place.structure)
        arrived = inspect_scan(scan.path, sidecar.path, self._digest(scan))
        known = known_as(arrived, intakes)
        if known is not None:
            self._tell_known(scan, known)
            return
        outcome = take_in(arrived, load_awaiting(self._place.campaign_file), intakes, self._now())
        if isinstance(outcome, KeptScan):
            self._keep(scan.name, outcome.reason)
            return
        others = tuple(intake for intake in intakes if intake.epoch != outcome.intake.epoch)
        check_intakes(self._place.campaign_file, (*others, outcome.intake))
        self._store(pair, sidecar, arrived, outcome)
        self._tell_taken(arrived, outcome)
        self.show_preview(outcome.intake)

    def _store(self, pair: ScanPair, sidecar: InboxFile, arrived: ArrivedScan, taken: TakenScan) -> None:
        """First the copies, then the note that names them; only then the inbox is cleared."""
        place, epoch = self._place, taken.intake.epoch
        beside = taken.target.with_suffix(SUFFIX)
        place.place(pair.scan, taken.target, arrived.sha256)
        place.place(sidecar, beside)
        write_intake(place.workspace, place.structure, epoch, intake_text(taken.intake))
        place.take_out(pair.scan, taken.target)
        place.take_out(sidecar, beside)

    def _digest(self, scan: InboxFile) -> str:
        key = (scan.name, scan.stamp)
        if key not in self._digests:
            self._digests[key] = file_sha256(scan.path)
        return self._digests[key]

    def _tell_taken(self, arrived: ArrivedScan, taken: TakenScan) -> None:
        intake = taken.intake
        points = "" if arrived.n_points is None else f", {arrived.n_points:,} points"
        late = "; its epoch was complete before, and is processed again" if intake.complete else ""
        facts = {
            "name": arrived.path.name,
            "epoch": intake.epoch,
            "station": arrived.station,
            "sha256": arrived.sha256,
            "size_bytes": arrived.size_bytes,
            "n_points": arrived.n_points,
            "scan": str(taken.target),
            "late": intake.complete is not None,
        }
        line = f"{intake.epoch} {arrived.station}: taken in{points}, {arrived.size_bytes / 1e6:.1f} MB{late}"
        self._teller.tell(WatchEvent("taken", (line,), facts))

    def show_preview(self, intake: Intake) -> None:
        """Tell what the stations of an epoch saw so far; a preview that fails stops nothing."""
        try:
            campaign = check_intakes(self._place.campaign_file, (intake,))
            digests = {arrival.station: arrival for arrival in intake.arrivals}
            for station in intake.stations:
                arrival = digests.get(station.id)
                if self._key(intake, station.id) not in self._looks:
                    n_points = None if arrival is None else arrival.n_points
                    self._looks[self._key(intake, station.id)] = look_at_station(campaign, station, n_points)
            looks = [self._looks[self._key(intake, station.id)] for station in intake.stations]
            missing = missing_stations(intake, load_awaiting(self._place.campaign_file))
            found = preview(campaign, intake, looks, missing)
            facts = preview_facts(found)
            write_preview(self._place.workspace, self._place.structure, intake.epoch, facts)
        except Exception as fault:
            reason = str(fault) if isinstance(fault, TiltwatchError) else fault_in_words(fault)
            line = f"error: {intake.epoch}: no preview: {reason}"
            self._teller.tell(WatchEvent("error", (line,), {"epoch": intake.epoch, "reason": reason}))
            return
        self._teller.tell(WatchEvent("preview", tuple(preview_lines(found)), facts))

    def _key(self, intake: Intake, station: str) -> str:
        sha256 = next((one.sha256 for one in intake.arrivals if one.station == station), "")
        return f"{intake.epoch}/{station}/{sha256}"

    def _tell_known(self, scan: InboxFile, known: KnownScan) -> None:
        if self._place.keeps and known.name == scan.path.name:
            return
        what = f"{scan.name}: is the scan of station {known.station} of epoch {known.epoch}, taken in as {known.name}"
        line = f"{what}; it is not counted again and stays: delete it, or send the right file"
        facts = {"name": scan.name, "epoch": known.epoch, "station": known.station}
        self._teller.tell_once(scan.name, WatchEvent("duplicate", (line,), facts))

    def _keep(self, name: str, reason: str) -> None:
        lines = tuple(f"kept: {name}: {line}" for line in reason.splitlines())
        self._teller.tell_once(name, WatchEvent("kept", lines, {"name": name, "reason": reason}))

    def _wait(self, name: str, what: str) -> None:
        self._teller.tell_once(
            name, WatchEvent("waiting", (f"{name}: {what}",), {"name": name, "reason": what})
        )

    def _tell_lone_sidecars(self, files: Sequence[InboxFile], settled: frozenset[str]) -> None:
        with_scan = {pair.sidecar.name for pair in pairs_of(files) if pair.sidecar is not None}
        for file in files:
            if is_sidecar(file) and file.name in settled and file.name not in with_scan:
                self._wait(file.name, "waits for its scan, a file of the same name with the suffix of a scan")

    def _tell_strangers(self, files: Sequence[InboxFile], settled: frozenset[str]) -> None:
        for file in files:
            if file.name in settled and not (is_scan(file) or is_sidecar(file) or is_marker(file)):
                event = WatchEvent("ignored", (f"{file.name}: {UNKNOWN}",), {"name": file.name})
                self._teller.tell_once(file.name, event)


def pairs_of(files: Sequence[InboxFile]) -> list[ScanPair]:
    """Scans with the sidecars of the same folder and stem."""
    sidecars = {_stem(file): file for file in files if is_sidecar(file)}
    return [ScanPair(file, sidecars.get(_stem(file))) for file in files if is_scan(file)]


def _stem(file: InboxFile) -> str:
    return str(Path(file.name).with_suffix(""))
