"""P1: the owner's page. Is it safe, does it move, how fast, can one trust it."""

from collections.abc import Sequence

from dash import dcc, html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.address import Address
from dashboard.cards import cards
from dashboard.content.plan import tops
from dashboard.content.series import series_points
from dashboard.figures.plan import plan_of_tops
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.series_panels import deviation_panel, marking, movement_panel, movements_of
from dashboard.shell import badge, tone_of
from dashboard.theme import TONES, Tone
from dashboard.view import View
from storage.records import AlarmRow, EpochRow
from storage.views import alarm_rows
from storage.views.condition import conditions, sorted_alarms

MOST_ALARMS = 5


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the overview."""
    movements = movements_of(view)
    return [
        *cards(view, movements),
        deviation_panel(view, series_points(view.epochs, view.series()), span=7),
        _plan(view),
        movement_panel(view, movements, component=0, span=7),
        _alarms(view),
        _structures(view),
    ]


PAGE = Page("overview", 1, "Overview", "Is it safe, does it move, and can the data tell?", fill)


def _plan(view: View) -> Panel:
    rows = view.series()
    columns = ["epoch", "epoch_time", "lean_east", "lean_north"]
    columns += ["lean_cov_ee", "lean_cov_en", "lean_cov_nn", "height_m"]
    return Panel(
        "plan",
        "Plan of the top, 95 % ellipses, grid north up",
        plan_of_tops(tops(rows), marking(view), 320),
        Table(columns, [[getattr(row, name) for name in columns] for row in rows]),
        span=5,
        missing=None if rows else f"{'/'.join(view.result)} gave no axis in any epoch",
    )


def _alarms(view: View) -> Panel:
    found = sorted_alarms(view.reader.ask(alarm_rows, view.structure))
    open_ones = [row for row in found if row.state != "closed"]
    lines = [html.Li(_alarm_line(row)) for row in open_ones[:MOST_ALARMS]]
    if len(open_ones) > MOST_ALARMS:
        lines.append(html.Li(f"and {len(open_ones) - MOST_ALARMS} more"))
    # what rules found stands among the alarms
    reasons = [reason for reason in view.condition.reasons if not reason.what.startswith("rule ")]
    content = [
        html.H3("Why this state"),
        html.Ul(
            [html.Li([badge(TONES[r.level.name.lower()]), f" {numbers.brief(r.what, 240)}"]) for r in reasons]
        )
        if reasons
        else html.P(_calm(view, bool(lines)), className="calm"),
        html.H3("Open alarms"),
        html.Ul(lines) if lines else html.P("None.", className="calm"),
    ]
    link = dcc.Link("all alarms", href=view.asked.at("alarms").href)
    return Panel("alarms", "What to look at", html.Div(content), span=5, tools=[link])


def _calm(view: View, has_alarms: bool) -> str:
    tilt = view.condition.tilt
    if tilt is not None and tilt.verdict == "no limit":
        return "No limit is stated, so nothing can be called in order: name the one that applies in [limits]."
    return "Nothing but the alarms below." if has_alarms else "Nothing speaks against it."


def _alarm_line(row: AlarmRow) -> list[Component | str]:
    said = f" {row.rule}, {row.state}, raised {numbers.day(row.raised_at)}"
    return [
        badge(severity_tone(row.severity), row.severity.upper()),
        said,
        html.Br(),
        numbers.brief(row.what, 200),
    ]


def severity_tone(severity: str) -> Tone:
    """The tone of an alarm's severity."""
    return TONES[severity if severity in ("alarm", "warning") else "missing"]


def _structures(view: View) -> Panel:
    head = ("structure", "state", "epoch", "deviation (k=2)", "limit", "verdict", "measured")
    rows = [_structure(view, newest) for newest in view.structures]
    body = html.Table(
        [
            html.Thead(html.Tr([html.Th(name) for name in head])),
            html.Tbody([html.Tr([html.Td(cell) for cell in row]) for row in rows]),
        ]
    )
    return Panel("structures", "All structures, newest epoch", html.Div(body, className="wide"), span=12)


def _structure(view: View, newest: EpochRow) -> list[Component | str]:
    site = view.site_of(newest.structure)
    condition = view.reader.ask(conditions, newest.structure, site.primary)[-1]
    tilt = condition.tilt
    return [
        dcc.Link(site.name, href=Address(structure=newest.structure).href),
        badge(tone_of(condition)),
        newest.epoch,
        numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m) if tilt else numbers.MISSING,
        numbers.mm(tilt.allowable_m) if tilt else numbers.MISSING,
        tilt.verdict if tilt else numbers.MISSING,
        numbers.age(newest.epoch_time, view.now),
    ]
