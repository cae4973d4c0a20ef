"""P6: the slicing schemes beside each other, as tables 1 to 3 of the paper, with what these lack."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from dash import dcc, html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.content.scheme_differences import differences, drawable
from dashboard.content.scheme_tables import (
    accuracy_sheet,
    advice_sheet,
    comparison_sheet,
    fitting_sheet,
    monitoring_sheet,
)
from dashboard.content.schemes import (
    QUANTITIES,
    Control,
    Given,
    Way,
    control_of,
    marks,
    recommended,
    stored_control,
    ways,
)
from dashboard.content.sheet import Sheet
from dashboard.figures.schemes import deviations, over_epochs
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.tables import copy_tools, sheet_table, words
from dashboard.view import View
from storage.errors import UsageError
from storage.records import TiltRow
from storage.views import (
    accuracy_rows,
    reference_lean_rows,
    run_rows_of,
    scheme_comparison_rows,
    scheme_rows,
    slice_rows_of,
    tilt_rows,
)

NO_SCHEMES = "no scheme was processed in this epoch"


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the schemes."""
    found = ways_of(view)
    against = _against(view, found)
    over_epochs_panels = [_over_epochs_panel(view, against, method) for method in ("robust", "paper")]
    if not found:
        return [_none_panel(view), _deviations_panel(view, found), *over_epochs_panels]
    return [
        _deviations_panel(view, found),
        _advice_panel(view, found),
        _fitting_panel(found),
        _monitoring_panel(view, found),
        _accuracy_panel(view, found, against),
        _comparison_panel(view, found),
        *over_epochs_panels,
    ]


PAGE = Page("schemes", 6, "Schemes", "What does each slicing scheme say, and which is enough?", fill)


def ways_of(view: View) -> list[Way]:
    """The schemes and methods of the epoch that is shown."""
    about = (view.structure, view.epoch.epoch)
    given = Given(
        schemes=view.reader.ask(scheme_rows, *about),
        tilts=view.reader.ask(tilt_rows, *about),
        comparison=view.reader.ask(scheme_comparison_rows, *about),
        slices=view.reader.ask(slice_rows_of, *about),
        runs=view.reader.ask(run_rows_of, *about),
    )
    return ways(given, view.site.primary)


def _against(view: View, found: Sequence[Way]) -> str | None:
    """What the reader wants the schemes to be compared with."""
    wanted = view.asked.more.get("against")
    known = {f"{row.scheme}/{row.method}" for row in view.tilts()} | {way.label for way in found}
    if wanted is not None and wanted not in known:
        raise UsageError(f"unknown scheme and method {wanted!r}; known: {', '.join(sorted(known))}")
    return wanted


def _why_nothing(found: Sequence[Way]) -> str | None:
    if any(way.tilt is not None for way in found):
        return None
    return "every scheme failed" if found else NO_SCHEMES


def _none_panel(view: View) -> Panel:
    """One place for why there is no table at all; a long reason is folded up."""
    parts: list[Component | str] = [html.B(f"{numbers.MISSING} "), f"{NO_SCHEMES}."]
    if view.epoch.reason:
        parts.append(words(view.epoch.reason))
    link = dcc.Link("the data of this epoch", href=view.asked.at("quality").href)
    body = html.Div([html.P(parts), html.P(link)], className="missing")
    return Panel("none", f"Tables of epoch {view.epoch.epoch}", body, span=5)


def _rows(rows: Sequence[object], columns: Sequence[str]) -> Table:
    return Table(columns, [[getattr(row, name) for name in columns] for row in rows])


def _deviations_panel(view: View, found: Sequence[Way]) -> Panel:
    references = view.reader.ask(reference_lean_rows, view.structure, view.epoch.epoch)
    drawn = marks(found, references)
    limits = [way.tilt.allowable_m for way in found if way.tilt is not None]
    columns = ["compared", "scheme", "method", "deviation_m", "deviation_sigma_m", "allowable_m"]
    allowable = next((limit for limit in limits if limit is not None), None)
    rows = [[m.label, m.scheme, m.method, m.value_m, m.sigma_m, allowable] for m in drawn]
    return Panel(
        "deviations",
        "Deviation of every scheme, with its uncertainty (k = 2)",
        deviations(drawn, allowable) if drawn else None,
        Table(columns, rows),
        span=7,
        missing=None if drawn else _why_nothing(found) or NO_SCHEMES,
        note="* primary; hollow squares: as in the paper; star: measured by other means."
        + (" No limit holds here." if limits and allowable is None else ""),
    )


def _advice_panel(view: View, found: Sequence[Way]) -> Panel:
    chosen = recommended(found)
    sheet = advice_sheet(found)
    line = html.P("No sliced scheme is enough: take the primary.", className="verdict-line")
    if chosen is not None and chosen.beside is not None:
        said = f" is enough with {chosen.beside.n_slices} slices, the fewest of those that are."
        line = html.P([html.B(chosen.label), said], className="verdict-line")
    columns = (
        "compared", "n_slices", "n_centres", "n_points", "workload_ratio", "sigma_m", "point_sigma_m",
        "excess_pct", "is_enough", "is_recommended", "reason",
    )  # fmt: skip
    rows = view.reader.ask(scheme_comparison_rows, view.structure, view.epoch.epoch)
    return Panel(
        "advice",
        "Which scheme is enough",
        html.Div([line, sheet_table(sheet)]),
        _rows(rows, columns),
        span=5,
        missing=_why_nothing(found),
        note="Point at a word for the reason.",
    )


def _fitting_panel(found: Sequence[Way]) -> Panel:
    columns = (
        "scheme",
        "method",
        "n_centres",
        "iterations",
        "update_weight_ratio_pct",
        "mean_deviation_m",
        "rmse_m",
        "n_effective",
    )
    rows = [
        [*[getattr(way.tilt, name) for name in columns], way.seconds] for way in found if way.tilt is not None
    ]
    panel = Panel(
        "table-1",
        "Table 1: fitting accuracy",
        None,
        Table([*columns, "seconds"], rows),
        span=12,
        note="-- in the rows of two slices: a line through two centres has no residual.",
    )
    return _with_sheet(panel, fitting_sheet(found), None if found else _why_nothing(found))


def _monitoring_panel(view: View, found: Sequence[Way]) -> Panel:
    columns = (
        "scheme", "method", "n_slices", "n_centres", "d_east", "d_north", "d_up", "beta_deg", "azimuth_deg",
        "azimuth_sigma_deg", "tilt_deg", "tilt_sigma_deg", "verticality_permille", "height_m", "deviation_m",
        "deviation_sigma_m", "allowable_m", "verdict",
    )  # fmt: skip
    tilts = [way.tilt for way in found if way.tilt is not None]
    panel = Panel(
        "table-2",
        f"Table 2: results at {view.epoch.height_m:.1f} m",
        None,
        _rows(tilts, columns),
        span=12,
        note="β is the paper's tilt-azimuth, the angle between the axis and the x axis; the azimuth is the direction of "
        "lean, clockwise from grid north, -- where the lean is below 3 sigma. S has height bands in the place of slices.",
    )
    return _with_sheet(panel, monitoring_sheet(found), None if found else _why_nothing(found))


def _accuracy_panel(view: View, found: Sequence[Way], against: str | None) -> Panel:
    stored = stored_control(view.reader.ask(accuracy_rows, view.structure, view.epoch.epoch))
    control = stored
    if against is not None:
        control = next((control_of(way) for way in found if way.label == against), None)
    choices = _choices(view, found, against, stored)
    name = against or "the control of the campaign"
    if control is None:
        why = _why_nothing(found) or f"{name} has no axis in this epoch"
        body = html.Div([choices, html.P([html.B(numbers.MISSING), f" {why}"], className="missing")])
        return Panel("table-3", "Table 3: relative errors", body, span=6)
    sheet = accuracy_sheet(found, control)
    tilts = [way.tilt for way in found if way.tilt is not None]
    return Panel(
        "table-3",
        f"Table 3: against {control.label}",
        html.Div([choices, sheet_table(sheet)]),
        _error_rows(tilts, control),
        span=6,
        tools=copy_tools(sheet),
        note="Eq. 23 of the paper: how far two results are apart, not how far from the truth.",
    )


def _error_rows(tilts: Sequence[TiltRow], control: Control) -> Table:
    rows = []
    for tilt in tilts:
        for quantity in QUANTITIES:
            value, reference = getattr(tilt, quantity), control.values.get(quantity)
            rows.append([tilt.scheme, tilt.method, control.label, quantity, value, reference])
    return Table(["scheme", "method", "control", "quantity", "value", "reference"], rows)


def _choices(view: View, found: Sequence[Way], against: str | None, stored: Control | None) -> Component:
    shown = against or (stored.label if stored else None)
    links = [
        dcc.Link(
            way.label,
            href=view.asked.with_more(against=way.label).href,
            className="chip here" if way.label == shown else "chip",
        )
        for way in found
        if way.tilt is not None
    ]
    return html.Div([html.Span("against"), *links], className="chips")


def _comparison_panel(view: View, found: Sequence[Way]) -> Panel:
    columns = (
        "compared", "against", "height_m", "d_lean_east", "d_lean_north", "d_cov_ee", "d_cov_en", "d_cov_nn",
        "shared", "d_top_m", "d_sigma_top_m", "chi2", "p_value", "significant", "reason",
    )  # fmt: skip
    rows = view.reader.ask(scheme_comparison_rows, view.structure, view.epoch.epoch)
    against = next((row.against for row in rows), "/".join(view.site.primary))
    title = f"Minus {against}, what both share taken out"
    if not rows:
        why = _why_nothing(found) or "nothing was compared in this epoch"
        return Panel("comparison", title, None, span=6, missing=why)
    sheet = comparison_sheet(found, [row for row in rows if row.scheme is None], against)
    panel = Panel("comparison", title, None, _rows(rows, columns), span=6)
    return _with_sheet(panel, sheet, None)


def _with_sheet(panel: Panel, sheet: Sheet, missing: str | None) -> Panel:
    """Fill a panel with a sheet and what copies it."""
    tools = () if missing else copy_tools(sheet)
    return replace(panel, content=sheet_table(sheet), tools=tools, missing=missing)


def _over_epochs_panel(view: View, against: str | None, method: str) -> Panel:
    base = against or "/".join(view.site.primary)
    comparison = view.reader.ask(scheme_comparison_rows, view.structure)
    found = {
        label: series
        for label, series in differences(view.tilts(), comparison, base).items()
        if series[0].method in (method, "surface")
    }
    drawn, wild = drawable(found)
    epochs = [epoch.epoch for epoch in view.epochs]
    columns = ["epoch", "epoch_time", "scheme", "method", "along_lean_m", "sigma_m", "significant"]
    rows = [
        [d.epoch, d.time, d.scheme, d.method, d.value_m, d.sigma_m, d.significant]
        for series in found.values()
        for d in series
    ]
    known = any(d.sigma_m is not None for series in found.values() for d in series)
    return Panel(
        f"epochs-{method}",
        f"Minus {base} along the lean, {method}",
        over_epochs(drawn, base, epochs) if drawn else None,
        Table(columns, rows),
        span=6,
        missing=None if found else f"no epoch has an axis of {base} and of another scheme",
        note=_bars_note(known, wild, "/".join(view.site.primary)),
    )


def _bars_note(known: bool, wild: Mapping[str, float], primary: str) -> str:
    if not known:
        return f"No bars: covariances are known only against {primary}. What is far off lies outside the drawing."
    left = "; ".join(
        f"{label} is left out: ± {numbers.mm(numbers.COVERAGE * s, 0)} or more" for label, s in wild.items()
    )
    return "Bars: k = 2, what both share taken out; a dark rim: significant." + (f" {left}." if left else "")
