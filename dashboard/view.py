"""What a page draws from: the rows that belong to its address."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TypeAlias

from dashboard.address import Address
from dashboard.reader import Reader
from dashboard.rule import RuleWords
from storage.errors import UsageError
from storage.records import EpochRow, SliceRow, TiltRow
from storage.views import (
    ChangeRow,
    change_rows,
    latest_epochs,
    scheme_comparison_rows,
    scheme_rows,
    slice_rows,
    tilt_rows,
)
from storage.views.condition import Condition, conditions

Result: TypeAlias = tuple[str, str]
"""A scheme and a method."""

Report: TypeAlias = Callable[[str, str, str], bytes]
"""Epoch, kind (pdf or html) and language (en or zh) to the file."""

DEFAULT_PRIMARY: Result = ("S", "surface")


@dataclass(frozen=True, slots=True)
class Site:
    """What the campaign file says of a structure and the catalog does not."""

    name: str
    primary: Result
    file: str | None = None
    """Name of the campaign file; None where it is not at hand."""
    rules: Sequence[RuleWords] = ()
    """Its rules of alarms, in words."""
    report: Report | None = None
    """Makes the report of an epoch; None where the campaign file is not at hand."""


@dataclass(frozen=True, slots=True)
class View:
    """An address made whole: which structure, epoch, reference, scheme and method are shown.

    ``asked`` is the address as it came: what it leaves open follows the newest epoch. ``address`` has all filled in, for
    links to what is shown just now.
    """

    reader: Reader
    asked: Address
    address: Address
    sites: Mapping[str, Site]
    """What campaign files say, by structure; of those that are at hand."""
    structures: Sequence[EpochRow]
    """The newest epoch of each structure of the catalog."""
    conditions: Sequence[Condition]
    """State of every epoch of the structure under its primary scheme and method, the earliest first."""
    condition: Condition
    """That of the epoch that is shown."""
    reference: EpochRow | None
    """The epoch that changes are counted from; None where there is only one."""
    result: Result
    """The scheme and method that is shown."""

    @property
    def structure(self) -> str:
        """Id of the structure."""
        return self.epoch.structure

    @property
    def site(self) -> Site:
        """Name and primary of the structure."""
        return self.site_of(self.structure)

    def site_of(self, structure: str) -> Site:
        """Name and primary of any structure of the catalog."""
        return _site(self.reader, self.sites, structure)

    @property
    def epoch(self) -> EpochRow:
        """The epoch that is shown."""
        return self.condition.epoch

    @property
    def epochs(self) -> list[EpochRow]:
        """All epochs of the structure, the earliest first."""
        return [condition.epoch for condition in self.conditions]

    @property
    def now(self) -> datetime:
        """The time of this machine."""
        return datetime.now(UTC)

    def tilts(self) -> list[TiltRow]:
        """Every axis of every epoch of the structure."""
        return self.reader.ask(tilt_rows, self.structure)

    def series(self) -> list[TiltRow]:
        """The axes of the scheme and method that is shown, the earliest first."""
        return [row for row in self.tilts() if (row.scheme, row.method) == self.result]

    def tilt(self, epoch: str | None = None) -> TiltRow | None:
        """The axis that is shown, of its epoch or of another."""
        wanted = self.epoch.epoch if epoch is None else epoch
        return next((row for row in self.series() if row.epoch == wanted), None)

    def changes(self) -> list[ChangeRow]:
        """The changes since the structure's reference epoch, of the scheme and method that is shown."""
        rows = self.reader.ask(change_rows, self.structure)
        return [row for row in rows if (row.scheme, row.method) == self.result]

    def slices(self, epoch: str | None = None) -> list[SliceRow]:
        """The slices of the scheme and method that is shown, from the bottom."""
        wanted = self.epoch.epoch if epoch is None else epoch
        return self.reader.ask(slice_rows, self.structure, wanted, *self.result)

    def results(self) -> list[Result]:
        """Schemes and methods of the epoch, those that gave no axis too."""
        rows = self.reader.ask(scheme_rows, self.structure, self.epoch.epoch)
        found = {(row.scheme, row.method) for row in rows} | {self.result}
        return sorted(found)


def open_view(reader: Reader, address: Address, sites: Mapping[str, Site]) -> View | None:
    """Fill in what an address leaves open; None where the catalog holds no epoch at all.

    Raises
    ------
    UsageError
        If the address names a structure, an epoch, a scheme or a method that is not there.
    StorageError
        If the catalog cannot be read.
    """
    if reader.stamp is None:
        return None
    newest = reader.ask(latest_epochs)
    if not newest:
        return None
    preferred = next(
        (name for name in sites if any(row.structure == name for row in newest)), newest[0].structure
    )
    structure = _known("structure", address.structure, [row.structure for row in newest]) or preferred
    site = _site(reader, sites, structure)
    found = reader.ask(conditions, structure, site.primary)
    names = [condition.epoch.epoch for condition in found]
    epoch = _known("epoch", address.epoch, names) or names[-1]
    condition = found[names.index(epoch)]
    reference = _known("reference epoch", address.reference, names)
    chosen = next((c.epoch for c in found if c.epoch.epoch == reference), None) or _reference(reader, found)
    result = _result(reader, condition.epoch, address, site.primary)
    filled = address.choosing(structure=structure, epoch=epoch, scheme=result[0], method=result[1])
    return View(reader, address, filled, sites, newest, found, condition, chosen, result)


def _known(what: str, wanted: str | None, known: Sequence[str]) -> str | None:
    if wanted is not None and wanted not in known:
        raise UsageError(f"unknown {what} {wanted!r}; known: {', '.join(known)}")
    return wanted


def _site(reader: Reader, sites: Mapping[str, Site], structure: str) -> Site:
    return sites.get(structure) or Site(structure, _primary_of(reader, structure))


def _primary_of(reader: Reader, structure: str) -> Result:
    """The primary of a structure whose campaign file is not at hand: what its schemes were compared with."""
    against = {row.against for row in reader.ask(scheme_comparison_rows, structure)}
    for name in sorted(against):
        scheme, found, method = name.partition("/")
        if found:
            return scheme, method
    return DEFAULT_PRIMARY


def _reference(reader: Reader, found: Sequence[Condition]) -> EpochRow | None:
    """The epoch that the catalog counts changes from."""
    if len(found) < 2:
        return None
    names = {row.reference_epoch for row in reader.ask(change_rows, found[0].epoch.structure)}
    marked = [c.epoch for c in found if c.epoch.epoch in names] or [
        c.epoch for c in found if c.epoch.is_reference
    ]
    return marked[0] if marked else None


def _result(reader: Reader, epoch: EpochRow, address: Address, primary: Result) -> Result:
    scheme, method = address.scheme or primary[0], address.method
    if method is None:
        method = primary[1] if scheme == primary[0] else None
    known = {(row.scheme, row.method) for row in reader.ask(tilt_rows, epoch.structure)} | {primary}
    # those that gave no axis, too: their page says why
    known |= {(row.scheme, row.method) for row in reader.ask(scheme_rows, epoch.structure, epoch.epoch)}
    matching = sorted(pair for pair in known if pair[0] == scheme and method in (None, pair[1]))
    if not matching:
        names = ", ".join(f"{a}/{b}" for a, b in sorted(known))
        raise UsageError(f"unknown scheme and method {scheme}/{method or '...'}; known: {names}")
    # the robust one where a scheme has several
    return next((pair for pair in matching if pair[1] == "robust"), matching[0])
