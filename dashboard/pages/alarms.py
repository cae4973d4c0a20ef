"""P9: what has alarmed, what became of it, what the rules mean, and what to type."""

from collections.abc import Mapping, Sequence
from typing import Final

from dash import dcc, html
from dash.development.base_component import Component

from dashboard import numbers
from dashboard.content.alarms import STATES, commands, counts, courses, in_words, narrowed, quantity, state_of
from dashboard.content.sheet import Head, Shown, gap
from dashboard.figures.alarms import course_of_values
from dashboard.page import Page
from dashboard.panel import Panel, Table
from dashboard.rule import RuleWords
from dashboard.shell import badge
from dashboard.tables import Cell, copied, row, table, words
from dashboard.theme import TONES, Tone
from dashboard.view import View
from storage.errors import UsageError
from storage.records import AlarmEventRow, AlarmRow, columns_of
from storage.views import alarm_event_rows, alarm_rows

MOST_EVENTS: Final = 80
"""So many are shown; the CSV has all."""


def fill(view: View) -> Sequence[Panel]:
    """Make the panels of the alarms."""
    alarms = view.reader.ask(alarm_rows, view.structure)
    events = view.reader.ask(alarm_event_rows, view.structure)
    state, rule = _choice(view, alarms)
    shown = narrowed(alarms, state, rule)
    chosen = _chosen(view, alarms, shown)
    return [
        _list_panel(view, alarms, shown, chosen),
        _course_panel(view, events),
        _commands_panel(view, chosen),
        _rules_panel(view, alarms),
        _history_panel(view, events, rule),
    ]


PAGE = Page("alarms", 9, "Alarms", "What has alarmed, who has seen it, and what do the rules mean?", fill)


def _choice(view: View, alarms: Sequence[AlarmRow]) -> tuple[str, str | None]:
    """Which alarms the reader wants to see."""
    more = view.asked.more
    state, rule = more.get("state", "open"), more.get("rule")
    if state not in STATES:
        raise UsageError(f"unknown state of alarms {state!r}; known: {', '.join(STATES)}")
    rules = sorted({row.rule for row in alarms} | {each.rule for each in view.site.rules})
    if rule is not None and rule not in rules:
        raise UsageError(f"unknown rule {rule!r}; known: {', '.join(rules) or 'none'}")
    return state, rule


def _chosen(view: View, alarms: Sequence[AlarmRow], shown: Sequence[AlarmRow]) -> AlarmRow | None:
    """The alarm that the reader wants to act on; else the first of the list."""
    wanted = view.asked.more.get("alarm")
    if wanted is None:
        return shown[0] if shown else None
    found = next((each for each in alarms if each.alarm == wanted), None)
    if found is None:
        raise UsageError(f"unknown alarm {wanted!r}; known: {', '.join(a.alarm for a in alarms) or 'none'}")
    return found


def _tone(severity: str) -> Tone:
    return TONES[severity if severity in ("alarm", "warning") else "missing"]


def _chip(view: View, label: str, is_here: bool, **more: str | None) -> Component:
    kept = {key: value for key, value in {**view.asked.more, **more}.items() if value is not None}
    href = view.asked.at(view.asked.page, **kept).href
    return dcc.Link(label, href=href, className="chip here" if is_here else "chip")


_LIST_HEAD = (
    Head("severity", is_number=False),
    Head("alarm", is_number=False),
    Head("state", is_number=False),
    Head("value"),
    Head("limit"),
    Head("epoch", is_number=False, means="that the value is of"),
    Head("raised", is_number=False),
    Head("what was found, and what was said last", is_number=False),
)


def _list_panel(
    view: View, alarms: Sequence[AlarmRow], shown: Sequence[AlarmRow], chosen: AlarmRow | None
) -> Panel:
    state, rule = _choice(view, alarms)
    number = counts(alarms)
    chips = [_chip(view, f"{name} {number[name]}", state == name, state=name, alarm=None) for name in STATES]
    rules = [
        _chip(view, "every rule", rule is None, rule=None, alarm=None),
        *(
            _chip(view, name, rule == name, rule=name, alarm=None)
            for name in sorted({each.rule for each in alarms})
        ),
    ]
    rows = [row(_LIST_HEAD, _list_cells(view, each), "here" if each is chosen else "") for each in shown]
    nothing = "No alarm was ever raised." if not alarms else f"No alarm is {state}, of this choice."
    body = table(_LIST_HEAD, rows, fluid=True) if rows else html.P(nothing, className="calm")
    filters = [html.Div(chips, className="chips")] + ([html.Div(rules, className="chips")] if alarms else [])
    columns = [column.name for column in columns_of(AlarmRow)]
    return Panel(
        "list",
        f"Alarms of {view.site.name}",
        html.Div([*filters, body]),
        Table(columns, [[getattr(each, name) for name in columns] for each in shown]),
        span=12,
        note="Alarms are of all epochs; open are those that nobody has closed or muted.",
    )


def _list_cells(view: View, each: AlarmRow) -> list[Cell]:
    said = [] if each.note is None and each.person is None else [_said(each)]
    kept = {**view.asked.more, "alarm": each.alarm}
    return [
        badge(_tone(each.severity), each.severity.upper()),
        dcc.Link(each.alarm, href=view.asked.at("alarms", **kept).href),
        in_words(each),
        Shown(quantity(each.value, each.unit)),
        Shown(quantity(each.limit_value, each.unit)),
        gap("it is about no epoch") if each.epoch is None else each.epoch,
        numbers.minute(each.raised_at),
        [words(each.what or ""), *said],
    ]


def _said(each: AlarmRow) -> Component:
    who = each.person or "the program"
    return html.Div(words(f"{who}: {each.note or 'without words'}"), className="said")


def _course_panel(view: View, events: Sequence[AlarmEventRow]) -> Panel:
    found = courses(events, {epoch.epoch: epoch.epoch_time for epoch in view.epochs})
    rows = [
        [alarm, step.epoch, step.time, step.value, step.limit_value, step.unit, step.action]
        for alarm, steps in found.items()
        for step in steps
    ]
    return Panel(
        "course",
        "What the rules found over the epochs, as a multiple of their limits",
        course_of_values(found, view.asked.more.get("alarm")) if found else None,
        Table(["alarm", "epoch", "epoch_time", "value", "limit_value", "unit", "action"], rows),
        span=7,
        missing=None if found else "no rule has found anything in an epoch",
        note="Above the dashed line a rule is broken; of counts, as of stations, below it."
        if found
        else None,
    )


def _commands_panel(view: View, chosen: AlarmRow | None) -> Panel:
    if chosen is None:
        return Panel("commands", "What to type", None, span=5, missing="no alarm of this choice")
    lines = commands(chosen, view.site.file)
    body: list[Component] = [
        part for command in lines for part in (html.P(command.does, className="does"), copied(command.line))
    ]
    if not lines:
        body = [html.P("It is closed: nothing is left to say about it.", className="calm")]
    rule = next((each for each in view.site.rules if each.rule == chosen.rule), None)
    if rule is not None and state_of(chosen) != "closed":
        body.append(html.P([html.B("What to do: "), rule.advice], className="does"))
    note = "This dashboard only reads. What is said is on record for good, with the name."
    if view.site.file is None:
        note += " FILE is the campaign file of this structure."
    return Panel("commands", f"What to type about {chosen.alarm}", html.Div(body), span=5, note=note)


_RULE_HEAD = (
    Head("rule", is_number=False),
    Head("severity", is_number=False),
    Head("is broken when", is_number=False),
    Head("with", is_number=False),
    Head("what to do", is_number=False),
)


def _rules_panel(view: View, alarms: Sequence[AlarmRow]) -> Panel:
    rules = view.site.rules
    gone = sorted({each.rule for each in alarms} - {each.rule for each in rules})
    why = "the rules stand in the campaign file of this structure, which this dashboard was not started with"
    note = (
        f"Rules of alarms that the campaign file has no more: {', '.join(gone)}." if rules and gone else None
    )
    return Panel(
        "rules",
        "What the rules mean",
        table(_RULE_HEAD, [row(_RULE_HEAD, _rule_cells(each)) for each in rules], fluid=True),
        Table(
            ["rule", "kind", "severity", "means", "settings", "advice"],
            [[w.rule, w.kind, w.severity, w.means, w.settings, w.advice] for w in rules],
        ),
        span=12,
        missing=None if rules else why,
        note=note,
    )


def _rule_cells(rule: RuleWords) -> list[Cell]:
    return [
        html.B(rule.rule),
        badge(_tone(rule.severity), rule.severity.upper()),
        words(rule.means),
        html.Code(rule.settings),
        words(rule.advice),
    ]


_EVENT_HEAD = (
    Head("when", is_number=False),
    Head("alarm", is_number=False),
    Head("what happened", is_number=False),
    Head("epoch", is_number=False),
    Head("value"),
    Head("limit"),
    Head("who", is_number=False),
    Head("words", is_number=False),
)


def _history_panel(view: View, events: Sequence[AlarmEventRow], rule: str | None) -> Panel:
    wanted = view.asked.more.get("alarm")
    kept = [each for each in events if rule in (None, each.rule) and wanted in (None, each.alarm)]
    newest = list(reversed(kept))[:MOST_EVENTS]
    columns = [column.name for column in columns_of(AlarmEventRow)]
    tools: list[Component] = []
    if wanted is not None:
        tools = [_chip(view, "of all alarms", False, alarm=None)]
    return Panel(
        "history",
        "History" if wanted is None else f"History of {wanted}",
        html.Div(
            table(_EVENT_HEAD, [row(_EVENT_HEAD, _event_cells(each)) for each in newest], fluid=True),
            className="tall",
        ),
        Table(columns, [[getattr(each, name) for name in columns] for each in kept]),
        span=12,
        missing=None if kept else "nothing has happened yet",
        note=f"The newest {MOST_EVENTS} of {len(kept)}; the CSV has all."
        if len(kept) > len(newest)
        else None,
        tools=tools,
    )


_ACTIONS: Mapping[str, str] = {"updated": "worse than before", "eased": "back within its limit"}


def _event_cells(each: AlarmEventRow) -> list[Cell]:
    said = [each.note, f"until {numbers.minute(each.until)}" if each.until else None, each.target]
    return [
        numbers.minute(each.happened_at),
        each.alarm,
        _ACTIONS.get(each.action, each.action),
        gap("it is about no epoch") if each.epoch is None else each.epoch,
        Shown(quantity(each.value, each.unit)),
        Shown(quantity(each.limit_value, each.unit)),
        each.person or "the program",
        words(", ".join(part for part in said if part)),
    ]
