"""P7: how good the data are, and what follows from what is missing."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from statistics import median

from dash import dcc, html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.content.coverage import coverage_grid
from dashboard.content.quality import Evidence, Mind, warnings
from dashboard.content.sheet import Head, Shown, gap
from dashboard.content.stations import station_map
from dashboard.figures.counts import points_of_slices, removal_bars
from dashboard.figures.coverage import coverage_strip
from dashboard.figures.stations import station_plan
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.shell import badge
from dashboard.tables import Cell, row, table
from dashboard.theme import TONES, Tone
from dashboard.view import View
from storage.records import EpochRow, PairRow, StationRow, columns_of
from storage.views import (
    coverage_rows,
    pair_rows,
    removal_rows,
    scheme_rows,
    slice_rows_of,
    station_rows,
    tilt_rows,
)

NOT_KNOWN = "not known: the scan was not used"

_TONES: Mapping[str, Tone] = {
    "quality": replace(TONES["quality"], word="MISSING"),
    "warning": replace(TONES["warning"], word="MIND"),
    "note": replace(TONES["missing"], word="NOTE", icon="i"),
}


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the data's quality."""
    stations = view.reader.ask(station_rows, view.structure, view.epoch.epoch)
    return [
        _minds_panel(view, stations),
        _map_panel(view, stations),
        _stations_panel(stations),
        _coverage_panel(view),
        _slices_panel(view),
        _pairs_panel(view),
        _removals_panel(view),
    ]


PAGE = Page(
    "quality",
    7,
    "Data quality",
    "Can the data carry the result, and what follows from what is missing?",
    fill,
)


def evidence(view: View, stations: Sequence[StationRow]) -> Evidence:
    """The rows of the epoch that is shown, and of the newest other one that is whole."""
    about = (view.structure, view.epoch.epoch)
    before = _whole_epoch(view)
    return Evidence(
        view.epoch,
        view.result,
        view.reader.ask(tilt_rows, *about),
        view.reader.ask(scheme_rows, *about),
        stations,
        view.reader.ask(slice_rows_of, *about),
        view.reader.ask(coverage_rows, *about),
        before,
        () if before is None else view.reader.ask(tilt_rows, view.structure, before.epoch),
    )


def _whole_epoch(view: View) -> EpochRow | None:
    """The newest whole epoch before this one; else the newest whole one."""
    whole = [epoch for epoch in view.epochs if epoch.state == "ok" and epoch.epoch != view.epoch.epoch]
    earlier = [epoch for epoch in whole if epoch.epoch_time < view.epoch.epoch_time]
    return next(reversed(earlier or whole), None)


def _of_record(rows: Sequence[object], record: type) -> Table:
    names = [column.name for column in columns_of(record)]
    return Table(names, [[getattr(each, name) for name in names] for each in rows])


def _minds_panel(view: View, stations: Sequence[StationRow]) -> Panel:
    found = warnings(evidence(view, stations))
    listed: Component = html.Ul([_mind(mind) for mind in found], className="minds")
    if not found:
        listed = html.P("Nothing to note.", className="calm")
    lines = [[mind.tone, mind.what, mind.then] for mind in found]
    title = f"What to mind in epoch {view.epoch.epoch}, and what follows"
    return Panel("minds", title, listed, Table(["tone", "what", "then"], lines), span=7)


def _mind(mind: Mind) -> Component:
    return html.Li(
        [
            badge(_TONES[mind.tone]),
            html.Div([html.P(mind.what), html.P(mind.then, className="then")]),
        ]
    )


def _map_panel(view: View, stations: Sequence[StationRow]) -> Panel:
    tilt = view.tilt()
    radii = [each.radius_m for each in view.slices() if each.radius_m is not None]
    foot = None if tilt is None else (tilt.base_east_m, tilt.base_north_m)
    shown = station_map(stations, foot, median(radii) if radii else None, view.epoch.next_station_azimuth_deg)
    notes = []
    if shown.nowhere and shown.pins:
        notes.append(f"Without a position, as not used: {', '.join(shown.nowhere)}.")
    if shown.foot_m is None and shown.pins:
        notes.append(f"No lines: {'/'.join(view.result)} gave no axis.")
    return Panel(
        "map",
        "Stations in the plan, lines by the fit of their scans",
        station_plan(shown) if shown.pins else None,
        _of_record(stations, StationRow),
        span=5,
        missing=None if shown.pins else "no station has an adjusted position",
        note=" ".join(notes) or None,
    )


_STATION_HEAD = (
    Head("station", is_number=False),
    Head("state", is_number=False),
    Head("points"),
    Head("east, m"),
    Head("north, m"),
    Head("up, m"),
    Head("σ, mm", means="root mean square of the standard deviations of east, north and up"),
    Head("overlap, %", means="largest share of its sampled planes that match one other station"),
    Head("RMS, mm", means="robust scale of the point-to-plane residuals"),
    Head("moved e, n, u, mm", means="adjusted minus stated position: east, north, up"),
    Head("turned, °", means="adjusted minus stated heading"),
    Head("σ head., ″", means="standard deviation of the heading"),
    Head("σ level, ″", means="standard deviation of one component of the level"),
    Head("leans, ″", means="how far this station's side of the shaft leans against the common one"),
    Head("χ²", means="of that lean, 2 degrees of freedom; above 20 the station is suspect"),
    Head("known least", is_number=False, means="what the data know least of this station, beside the priors"),
)


def _stations_panel(stations: Sequence[StationRow]) -> Panel:
    rows = [part for each in stations for part in _station_lines(each)]
    return Panel(
        "stations",
        f"Stations: {len(stations)}" if stations else "Stations",
        table(_STATION_HEAD, rows),
        _of_record(stations, StationRow),
        span=12,
        missing=None if stations else "the epoch is of a registered cloud, or no station is stored",
    )


def _station_lines(each: StationRow) -> list[Component]:
    """A row of figures, unless there is none; and what is said about the station below it."""
    state = badge(TONES["ok" if each.state == "ok" else "quality"], each.state.upper())
    began = None if each.start in (None, "as stated") else f"began with: {each.start}"
    remarks = "; ".join(part for part in (each.reason, began, each.notes) if part)
    if each.position_east_m is None:
        why = f"{numbers.MISSING} {remarks or NOT_KNOWN}"
        said = html.Td(why, colSpan=len(_STATION_HEAD) - 2, className="long")
        return [html.Tr([html.Td(html.B(each.station)), html.Td(state), said])]
    lines = [row(_STATION_HEAD, [html.B(each.station), state, *_station_cells(each)])]
    if remarks:
        said = html.Td(remarks, colSpan=len(_STATION_HEAD) - 1, className="long")
        lines.append(html.Tr([html.Td(), said], className="aside"))
    return lines


def _station_cells(each: StationRow) -> list[Cell]:
    why = "not stated, or not told apart by the scans"
    corrections = (each.correction_east_m, each.correction_north_m, each.correction_up_m)
    moved = " ".join(numbers.signed_mm(part, 1, "") for part in corrections)
    return [
        _value(each.n_points, numbers.count(each.n_points), why),
        *(
            _value(part, numbers.number(part, 3), why)
            for part in (each.position_east_m, each.position_north_m, each.position_up_m)
        ),
        _value(each.sigma_position_m, numbers.mm(each.sigma_position_m, 1, ""), why),
        _value(each.overlap, numbers.number(None if each.overlap is None else 100.0 * each.overlap, 0), why),
        _value(each.rmse_m, numbers.mm(each.rmse_m, 1, ""), why),
        gap(why) if None in corrections else Shown(moved),
        _value(each.heading_correction_deg, numbers.number(each.heading_correction_deg, 3), why),
        _value(each.sigma_heading_deg, _arcsec(each.sigma_heading_deg), why),
        _value(each.sigma_level_deg, _arcsec(each.sigma_level_deg), why),
        _value(each.level_check_arcsec, numbers.number(each.level_check_arcsec, 1), why),
        _value(each.level_check_chi2, numbers.number(each.level_check_chi2, 2), why),
        _value(each.weakest_direction, each.weakest_direction or "", why),
    ]


def _value(value: object, text: str, why: str) -> Shown:
    return gap(why) if value is None else Shown(text)


def _arcsec(value_deg: float | None) -> str:
    return numbers.number(None if value_deg is None else 3600.0 * value_deg, 1)


_COVERAGE_COLUMNS = (
    "z_low_m",
    "z_high_m",
    "azimuth_low_deg",
    "azimuth_high_deg",
    "n_points",
    "n_stations",
    "station",
)


def _coverage_panel(view: View) -> Panel:
    rows = view.reader.ask(coverage_rows, view.structure, view.epoch.epoch)
    by_stations = view.asked.more.get("coverage") == "stations"
    empty = sum(each.n_points == 0 for each in rows)
    return Panel(
        "coverage",
        "What was seen of the shaft, unrolled",
        coverage_strip(coverage_grid(rows), by_stations) if rows else None,
        Table(_COVERAGE_COLUMNS, [[getattr(each, name) for name in _COVERAGE_COLUMNS] for each in rows]),
        span=8,
        missing=None if rows else "no coverage is stored of this epoch",
        note=f"{empty} of {len(rows)} pieces have no point (grey)." if rows else None,
        tools=[_coverage_chips(view, by_stations)] if rows else (),
    )


def _coverage_chips(view: View, by_stations: bool) -> Component:
    """What the colours mean: points, or the stations that saw a piece."""
    chips = [
        dcc.Link(
            name,
            href=view.asked.with_more(coverage=name).href,
            className="chip here" if (name == "stations") == by_stations else "chip",
        )
        for name in ("points", "stations")
    ]
    return html.Span(chips, className="chips")


def _slices_panel(view: View) -> Panel:
    rows = view.slices()
    columns = ("slice_index", "z_m", "n_points", "n_points_fit", "arc_coverage_deg", "state", "reason")
    failed = sum(each.state != "ok" for each in rows)
    return Panel(
        "slices",
        f"Points of the slices of {'/'.join(view.result)}",
        points_of_slices(rows) if rows else None,
        Table(columns, [[getattr(each, name) for name in columns] for each in rows]),
        span=4,
        missing=None if rows else "this scheme and method has no slices in this epoch",
        note=f"{failed} failed (crosses); those without a point stand at the left edge." if failed else None,
    )


_PAIR_HEAD = (
    Head("pair", is_number=False),
    Head("overlap, %"),
    Head("planes", means="planes that match"),
    Head("RMS, mm", means="robust scale of the distances along the normal"),
    Head("shaft, mm", means="the same of the matches on the structure"),
    Head("surroundings, mm", means="the same of all others"),
    Head("closure, mm", means="worst loop through this pair and a third station"),
    Head("closure, ″"),
)


def _pairs_panel(view: View) -> Panel:
    rows = view.reader.ask(pair_rows, view.structure, view.epoch.epoch)
    worst = sorted(rows, key=lambda each: -(each.rmse_m or 0.0))
    return Panel(
        "pairs",
        f"Pairs of stations: {len(rows)}, the worst first" if rows else "Pairs of stations",
        html.Div(table(_PAIR_HEAD, [row(_PAIR_HEAD, _pair_cells(each)) for each in worst]), className="tall"),
        _of_record(rows, PairRow),
        span=7,
        missing=None if rows else "no two stations were compared in this epoch",
    )


def _pair_cells(each: PairRow) -> list[Cell]:
    few = "too few matches"
    open_loop = "no loop closes"
    return [
        f"{each.station} – {each.other}",
        Shown(numbers.number(100.0 * each.overlap, 0)),
        Shown(numbers.count(each.n_matches)),
        _value(each.rmse_m, numbers.mm(each.rmse_m, 1, ""), few),
        _value(each.rmse_shaft_m, numbers.mm(each.rmse_shaft_m, 1, ""), few),
        _value(each.rmse_background_m, numbers.mm(each.rmse_background_m, 1, ""), few),
        _value(each.closure_m, numbers.mm(each.closure_m, 1, ""), open_loop),
        _value(each.closure_arcsec, numbers.number(each.closure_arcsec, 1), open_loop),
    ]


def _removals_panel(view: View) -> Panel:
    rows = view.reader.ask(removal_rows, view.structure, view.epoch.epoch)
    columns = ("step", "reason", "n_points")
    return Panel(
        "removals",
        "What became of the points",
        removal_bars(rows) if rows else None,
        Table(columns, [[getattr(each, name) for name in columns] for each in rows]),
        span=5,
        missing=None if rows else "no point was read in this epoch",
    )
