"""What must hold between the tables of a campaign file."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from storage.errors import InputError
from tasks.settings.campaign import Campaign
from tasks.settings.outline import EpochOutline, Named, Outline
from tasks.settings.problems import Problem, nearest
from tasks.settings.scan_paths import resolve_scan, same_file_key
from tasks.settings.schemes import BUILT_IN, Scheme

FARTHEST_M: Final = 10_000.0
"""No scanner sees a structure from farther away."""

MOST_SLICES: Final = 20_000


def problems_between_names(outline: Outline, folder: Path) -> Iterator[Problem]:
    """List doubles of ids and scans, scans outside the allowed folders, and clashing scheme names."""
    yield from _doubles(outline.epoch_ids, "epoch id")
    for epoch in outline.epochs:
        yield from _doubles(epoch.stations, "station id")
        yield from _doubles(epoch.sources, "source of a reference")
    yield from _scans(outline, folder)
    yield from _references(outline.epochs)
    yield from _scheme_names(outline.schemes)


def problems_between_values(campaign: Campaign) -> Iterator[Problem]:
    """List what does not fit together in a campaign whose tables are each valid."""
    yield from _report(campaign)
    yield from _slices(campaign)
    yield from _far_stations(campaign)


def _doubles(names: Sequence[Named], what: str) -> Iterator[Problem]:
    first: dict[str, Named] = {}
    for name in names:
        earlier = first.setdefault(name.text.casefold(), name)
        if earlier is not name:
            same = "" if earlier.text == name.text else f" (as {earlier.text!r}; only the case differs)"
            yield Problem(
                name.where, f"{what} {name.text!r} is taken by {earlier.where}{same}", "choose another"
            )


def _scans(outline: Outline, folder: Path) -> Iterator[Problem]:
    first: dict[str, Named] = {}
    for scan in (scan for epoch in outline.epochs for scan in epoch.scans):
        try:
            path = resolve_scan(scan.text, folder, outline.roots)
        except InputError as error:
            yield Problem(scan.where, str(error), "move the file, or name its folder in [files] roots")
            continue
        earlier = first.setdefault(same_file_key(path), scan)
        if earlier is not scan:
            yield Problem(
                scan.where, f"scan {scan.text!r} is already used by {earlier.where}", "name each scan once"
            )


def _references(epochs: Sequence[EpochOutline]) -> Iterator[Problem]:
    marked = [epoch for epoch in epochs if epoch.is_reference]
    for epoch in marked[1:]:
        yield Problem(
            f"{epoch.where}.reference", f"{marked[0].where} is the reference already", "keep one of the two"
        )


def _scheme_names(names: Sequence[str]) -> Iterator[Problem]:
    taken = {name.casefold(): f"the built-in scheme {name}" for name in BUILT_IN}
    for name in names:
        earlier = taken.setdefault(name.casefold(), f"[schemes.{name}]")
        if earlier != f"[schemes.{name}]":
            yield Problem(f"schemes.{name}", f"the name is taken by {earlier}", "choose another")


def _report(campaign: Campaign) -> Iterator[Problem]:
    yield from _scheme_method("report.primary", campaign.report.primary, campaign)
    control = campaign.report.control
    if not isinstance(control, str):
        yield from _scheme_method("report.control", control, campaign)
        return
    sources = sorted({reference.source for epoch in campaign.epochs for reference in epoch.references})
    if control not in sources:
        hint = nearest(control, sources) if sources else "add an [[epochs.references]] table with it"
        yield Problem("report.control", f"no epoch has a reference with source {control!r}", hint)


def _scheme_method(where: str, wanted: tuple[str, str], campaign: Campaign) -> Iterator[Problem]:
    scheme, method = wanted
    known = [*BUILT_IN, *campaign.schemes]
    if scheme not in known:
        yield Problem(where, f"unknown scheme {scheme!r}", f"known: {', '.join(known)}")
    elif (scheme == "S") != (method == "surface"):
        yield Problem(
            where,
            f"scheme {scheme!r} has no method {method!r}",
            "S goes with surface, the others with paper or robust",
        )


def _slices(campaign: Campaign) -> Iterator[Problem]:
    for name, scheme in campaign.schemes.items():
        yield from _slices_of(name, scheme, campaign.structure.shaft_z_m)


def _slices_of(name: str, scheme: Scheme, shaft_z_m: tuple[float, float]) -> Iterator[Problem]:
    low, high = shaft_z_m
    if scheme.interval_m is not None:
        where, span = f"schemes.{name}.interval_m", high - low
        if scheme.interval_m > span:
            yield Problem(
                where,
                f"{scheme.interval_m:g} m leaves 1 slice on the {span:g} m of shaft_z_m; an axis needs at least 2",
                f"write at most {span:g}",
            )
        if span / scheme.interval_m > MOST_SLICES:
            yield Problem(
                where, f"makes more than {MOST_SLICES} slices", f"write at least {span / MOST_SLICES:.3g}"
            )
    outside = [height for height in scheme.heights_m or () if not low <= height <= high]
    if outside:
        yield Problem(
            f"schemes.{name}.heights_m",
            f"{', '.join(f'{height:g}' for height in outside)} lies outside shaft_z_m [{low:g}, {high:g}]",
            "drop the height or widen structure.shaft_z_m",
        )


def _far_stations(campaign: Campaign) -> Iterator[Problem]:
    for epoch in campaign.epochs:
        for station in epoch.stations:
            away_m = max(abs(value) for value in campaign.frame.site_position_m(station.position_m))
            if away_m > FARTHEST_M:
                yield Problem(
                    f"epochs[{epoch.id}].stations[{station.id}].position_m",
                    f"lies {away_m:.0f} m from the origin; no scanner sees that far",
                    "write frame.origin_m near the structure, in the order of frame.axes",
                )
