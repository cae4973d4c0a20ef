"""What must hold between the tables of a campaign file."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, floor, hypot
from pathlib import Path
from typing import Final

from storage.errors import InputError
from tasks.methods import methods_of
from tasks.settings.alarm_checks import problems_of_alarms
from tasks.settings.campaign import Campaign
from tasks.settings.limit_checks import problems_of_limits
from tasks.settings.outline import EpochOutline, Named, NamedScan, Outline
from tasks.settings.problems import Problem, nearest
from tasks.settings.scan_paths import resolve_scan, same_file_key
from tasks.settings.schemes import BUILT_IN, Scheme
from tasks.settings.structure import Structure
from tasks.slicing import SCHEMES, AdaptiveCut

FARTHEST_M: Final = 10_000.0
"""No scanner sees a structure from farther away."""

LEAST_GAP_M: Final = 2.0
"""Between a stable box and the shaft: covers a lean of a degree over 100 m, and a rough base_xy_m."""

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
    yield from _doubles(outline.alarm_ids, "id of a rule")
    yield from _doubles(outline.target_ids, "id of a target")


def problems_between_values(campaign: Campaign) -> Iterator[Problem]:
    """List what does not fit together in a campaign whose tables are each valid."""
    yield from _report(campaign)
    yield from _design(campaign.structure)
    yield from _slices(campaign)
    yield from _far_stations(campaign)
    yield from _file_poses(campaign)
    yield from problems_of_limits(campaign)
    yield from _stable_names(campaign)
    yield from _stable_regions(campaign)
    yield from problems_of_alarms(campaign)


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
    first: dict[str, _Use] = {}
    for number, epoch in enumerate(outline.epochs):
        for scan in epoch.scans:
            try:
                path = resolve_scan(scan.text, folder, outline.roots)
            except InputError as error:
                yield Problem(scan.where, str(error), "move the file, or name its folder in [files] roots")
                continue
            use = first.setdefault(same_file_key(path), _Use(number, {}))
            yield from _used_before(use, number, scan)


@dataclass(frozen=True, slots=True)
class _Use:
    """The epoch that names a file, by its number, and the stations that do, by the scan of the file that they name."""

    epoch: int
    parts: dict[str | int | None, NamedScan]


def _used_before(use: _Use, epoch: int, scan: NamedScan) -> Iterator[Problem]:
    """Say that a file is named already, unless two stations of an epoch name different scans of it."""
    shared = (scan.part, *use.parts)
    if use.parts and (epoch != use.epoch or None in shared):
        earlier = next(iter(use.parts.values()))
        hint = "name each scan once" if epoch != use.epoch else "name each scan once, or say which with part"
        yield Problem(scan.where, f"scan {scan.text!r} is already used by {earlier.where}", hint)
    elif scan.part in use.parts:
        earlier = use.parts[scan.part]
        what = f"part {scan.part!r} of {scan.text!r} is already used by {earlier.where}"
        yield Problem(scan.where, what, "name each part once")
    use.parts.setdefault(scan.part, scan)


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
    elif method not in (methods := _methods_of(scheme, campaign)):
        yield Problem(
            where, f"scheme {scheme!r} has no method {method!r}", f"{scheme} goes with {' or '.join(methods)}"
        )


def _methods_of(name: str, campaign: Campaign) -> list[str]:
    own = campaign.schemes.get(name)
    scheme = SCHEMES[name] if own is None else own.as_scheme(name)
    return [method.name for method in methods_of(scheme)]


def _design(structure: Structure) -> Iterator[Problem]:
    """List designs that end within the shaft, and parts of a design without its radii."""
    if structure.design_radius_m is None:
        for name in ("design_lean", "design_base_xy_m"):
            if name in structure.model_fields_set:
                yield Problem(
                    f"structure.{name}",
                    "is a part of a design that has no radii",
                    "add design_radius_m or drop it",
                )
        return
    bottom, top = structure.design_radius_m[0][0], structure.design_radius_m[-1][0]
    low, high = structure.shaft_z_m
    if bottom > low or top < high:
        yield Problem(
            "structure.design_radius_m",
            f"goes from {bottom:g} to {top:g} m and leaves out a part of shaft_z_m [{low:g}, {high:g}]",
            "add the radii at its ends",
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
    if scheme.cut is not None:
        yield from _following_slices(f"schemes.{name}.adaptive", scheme.cut, high - low)
    outside = [height for height in scheme.heights_m or () if not low <= height <= high]
    if outside:
        yield Problem(
            f"schemes.{name}.heights_m",
            f"{', '.join(f'{height:g}' for height in outside)} lies outside shaft_z_m [{low:g}, {high:g}]",
            "drop the height or widen structure.shaft_z_m",
        )


def _following_slices(where: str, cut: AdaptiveCut, span_m: float) -> Iterator[Problem]:
    """Count the slices of an adaptive scheme where points are fewest, and where they are densest."""
    half_m = floor(50.0 * span_m) / 100.0
    if 2.0 * cut.most_thickness_m > span_m:
        yield Problem(
            where,
            f"most_thickness_m = {cut.most_thickness_m:g} leaves 1 slice on the {span_m:g} m of shaft_z_m where points"
            " are few; an axis needs at least 2",
            f"write {{ sigma_center_m = {cut.sigma_center_m:g}, most_thickness_m = {half_m:g} }} or less",
        )
    if span_m / cut.least_thickness_m > MOST_SLICES:
        yield Problem(
            where,
            f"least_thickness_m = {cut.least_thickness_m:g} may make more than {MOST_SLICES} slices",
            f"write at least {ceil(1000.0 * span_m / MOST_SLICES) / 1000.0:g}",
        )


def _far_stations(campaign: Campaign) -> Iterator[Problem]:
    for epoch in campaign.epochs:
        for station in epoch.stations:
            if station.position_m is None:
                continue
            away_m = max(abs(value) for value in campaign.frame.site_position_m(station.position_m))
            if away_m > FARTHEST_M:
                yield Problem(
                    f"epochs[{epoch.id}].stations[{station.id}].position_m",
                    f"lies {away_m:.0f} m from the origin; no scanner sees that far",
                    "write frame.origin_m near the structure, in the order of frame.axes",
                )


def _file_poses(campaign: Campaign) -> Iterator[Problem]:
    """List poses of files in a frame that no pose can state: a rotation has right-handed axes, and NEU has not."""
    if not campaign.frame.swaps_axes:
        return
    for epoch in campaign.epochs:
        for station in epoch.stations:
            if station.pose == "file":
                yield Problem(
                    f"epochs[{epoch.id}].stations[{station.id}].pose",
                    'a scan file states poses with x east, y north; frame.axes is "NEU"',
                    'write position_m and heading_deg instead, or the whole campaign with axes = "ENU"',
                )


def _stable_names(campaign: Campaign) -> Iterator[Problem]:
    named = [
        Named(f"registration.stable[#{number}].name", region.name)
        for number, region in enumerate(campaign.registration.stable, start=1)
    ]
    yield from _doubles(named, "name of a box")


def _stable_regions(campaign: Campaign) -> Iterator[Problem]:
    """List boxes that hold a part of the structure, or nearly: it must not be what holds it still."""
    structure, frame = campaign.structure, campaign.frame
    for number, region in enumerate(campaign.registration.stable, start=1):
        low, high = (
            (x - frame.origin_m[0], y - frame.origin_m[1]) for x, y, _ in (region.low_m, region.high_m)
        )
        apart = [
            max(near - base, base - far, 0.0)
            for near, far, base in zip(low, high, structure.base_xy_m, strict=True)
        ]
        gap_m = hypot(*apart) - max(structure.radius_m)
        if gap_m < LEAST_GAP_M:
            yield Problem(
                f"registration.stable[#{number}]",
                f"box {region.name!r} comes within {LEAST_GAP_M:g} m of the shaft (base_xy_m, largest radius, any"
                " height); epochs are never registered on the structure itself",
                "keep to surroundings that stand apart from it",
            )
