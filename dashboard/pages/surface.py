"""P5: the skin of the shaft, unrolled: what it is off a straight shaft, and what moved since the reference epoch."""

from collections.abc import Sequence

from dashboard import numbers
from dashboard.content.surface import (
    SkinChange,
    SkinMap,
    StationMark,
    range_mm,
    skin_change,
    skin_map,
    station_marks,
)
from dashboard.figures.surface import change_figure, map_figure
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.view import View
from storage.views import station_rows, surface_change_rows, surface_map_rows

_MAP_COLUMNS = [
    "z_low_m",
    "z_high_m",
    "azimuth_deg",
    "n_points",
    "radius_m",
    "deviation_m",
    "deviation_sigma_m",
]
_MAP_COLUMNS += ["placing_sigma_m", "design_deviation_m", "design_sigma_m"]
_CHANGE_COLUMNS = [
    "z_low_m",
    "z_high_m",
    "azimuth_deg",
    "reference_epoch",
    "change_m",
    "lod95_m",
    "significant",
]
_CHANGE_COLUMNS += ["radius_change_m", "design_change_m", "design_lod95_m"]


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the surface."""
    marks = station_marks(view.reader.ask(station_rows, view.structure, view.epoch.epoch), view.tilt())
    return [_map(view, marks), _change(view, marks)]


PAGE = Page("surface", 5, "Surface", "Where does the wall bulge, and where did it move?", fill)


def _map(view: View, marks: Sequence[StationMark]) -> Panel:
    rows = view.reader.ask(surface_map_rows, view.structure, view.epoch.epoch)
    skin = skin_map(rows)
    title = f"Off the best-fit straight shaft, {view.epoch.epoch}"
    if skin is None:
        reason = numbers.brief(view.epoch.reason or "this epoch has no map of its surface", 400)
        return Panel("map", title, None, span=6, missing=reason)
    others = [_skin(view, epoch) for epoch in _of_range(view)]
    limits = (
        range_mm(skin.deviation_m) if not any(others) else range_mm(*(s.deviation_m for s in others if s))
    )
    note = (
        "Outward is orange. What a whole band has in common is in its radius, not here. "
        "The colours are the same for every epoch; grey has no points. A click opens the slice nearest in height."
    )
    return Panel(
        "map",
        title,
        map_figure(skin, limits, marks, lambda z_m: _slice_at(view, z_m)),
        Table(_MAP_COLUMNS, [[getattr(row, name) for name in _MAP_COLUMNS] for row in rows]),
        span=6,
        note=note,
    )


def _change(view: View, marks: Sequence[StationMark]) -> Panel:
    rows = view.reader.ask(surface_change_rows, view.structure, view.epoch.epoch)
    change = skin_change(rows)
    if change is None:
        return Panel("change", "Change of the surface", None, span=6, missing=_unchanged(view))
    newest = skin_change(view.reader.ask(surface_change_rows, view.structure, view.epochs[-1].epoch))
    limits = range_mm((newest or change).change_m)
    return Panel(
        "change",
        f"Change since {change.reference_epoch}",
        change_figure(change, limits, marks, lambda z_m: _slice_at(view, z_m)),
        Table(_CHANGE_COLUMNS, [[getattr(row, name) for name in _CHANGE_COLUMNS] for row in rows]),
        span=6,
        note=_change_note(view, change),
    )


def _change_note(view: View, change: SkinChange) -> str:
    by_chance = round(0.05 * change.n_compared)
    parts = [
        f"{change.n_significant} of {change.n_compared} pieces are beyond their level of detection (95 %); "
        f"up to {by_chance} would be if nothing had moved. Pale: within it. Grey: not seen in both epochs. "
        "Each epoch is measured from its own axis, so a movement of the whole shaft is not here."
    ]
    if view.reference is not None and view.reference.epoch != change.reference_epoch:
        parts.append(f"The catalog counts the surface from {change.reference_epoch} alone.")
    return " ".join(parts)


def _unchanged(view: View) -> str:
    if len(view.epochs) == 1:
        return "a change needs a second epoch"
    if view.epoch.is_reference:
        return "this is the epoch that changes are counted from"
    return (
        numbers.brief(view.epoch.reason or "", 400)
        or "no height band of this epoch and of the reference epoch is the same"
    )


def _of_range(view: View) -> list[str]:
    """The epochs whose maps set the colours of all: the first and the newest that have a result."""
    good = [epoch.epoch for epoch in view.epochs if epoch.state != "failed"]
    return sorted({good[0], good[-1]}) if good else []


def _skin(view: View, epoch: str) -> SkinMap | None:
    return skin_map(view.reader.ask(surface_map_rows, view.structure, epoch))


def _slice_at(view: View, z_m: float) -> str:
    return view.asked.at("slice", z=f"{z_m:.2f}").href
