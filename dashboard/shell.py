"""What stands round every page: the rail with the choices, the status bar, the panels in their grid."""

from collections.abc import Sequence
from typing import Any, Final
from urllib.parse import quote

from dash import dcc, html
from dash.development.base_component import Component
from plotly.graph_objects import Figure

from dashboard import numbers
from dashboard.attributes import HIDDEN, attributes
from dashboard.page import Page, pages
from dashboard.panel import Panel
from dashboard.theme import NO_LIMIT, TONES, Tone
from dashboard.view import View
from storage.views.condition import Condition, Level

CHOICES: Final = ("structure", "epoch", "reference", "result")
"""What the rail lets one choose, each a part of the address."""

_DRAWING: Final[Any] = {
    "displaylogo": False,
    "responsive": True,
    "modeBarButtonsToRemove": ["select2d", "lasso2d", "autoScale2d"],
    "toImageButtonOptions": {"format": "svg"},
}


def page_frame(view: View, page: Page, panels: Sequence[Panel]) -> list[Component]:
    """Put a page together."""
    return [
        html.A("Skip to the page", href="#page", className="skip"),
        html.Aside(
            [_brand(), _choices(view), _links(view, page), *_reports(view), _keys()], className="rail"
        ),
        html.Div(
            [
                _status(view),
                html.Main(
                    [
                        html.Header(
                            [html.H1(page.title), html.P(page.asks, className="asks")], className="page-head"
                        ),
                        html.Div([_panel(view, page, panel) for panel in panels], className="grid"),
                    ],
                    id="page",
                    tabIndex=-1,
                    **attributes(data_page=page.name, data_stamp=view.reader.stamp or ""),
                ),
            ],
            className="body",
        ),
    ]


def message_frame(title: str, text: str, links: Sequence[Component] = ()) -> list[Component]:
    """A page that says why there is nothing to show, and what to do."""
    body = html.Main(
        [html.H1(title), html.P(text), html.P(list(links))],
        id="page",
        className="message",
        **attributes(data_page="message"),
    )
    return [html.Aside([_brand()], className="rail"), html.Div(body, className="body")]


def badge(tone: Tone, text: str | None = None, **more: Any) -> Component:
    """A state in words, with its sign and its colour."""
    return html.Span(
        [html.Span(tone.icon, className="icon", **HIDDEN), text or tone.word],
        className="badge",
        style={"color": tone.ink, "background": tone.ground},
        **more,
    )


def tone_of(condition: Condition) -> Tone:
    """The tone of a condition's level; without a limit nothing can be called in order."""
    if condition.level is Level.OK and condition.tilt is not None and condition.tilt.verdict == "no limit":
        return NO_LIMIT
    return TONES[condition.level.name.lower()]


def _brand() -> Component:
    return dcc.Link(
        [html.Span(className="mark", **HIDDEN), "tiltwatch"],
        href="/overview",
        className="brand",
    )


def _choices(view: View) -> Component:
    asked = view.asked
    newest, primary = view.epochs[-1].epoch, "/".join(view.site.primary)
    reference = view.reference.epoch if view.reference and asked.reference is None else None
    epochs = [condition.epoch.epoch for condition in reversed(view.conditions)]
    structures = [(row.structure, row.structure) for row in view.structures]
    results = [(f"{scheme}/{method}",) * 2 for scheme, method in view.results()]
    result = "" if asked.scheme is None else "/".join(view.result)
    return html.Div(
        [
            _choice("structure", "Structure", structures, view.structure),
            _choice(
                "epoch", "Epoch", [("", f"newest ({newest})"), *((e, e) for e in epochs)], asked.epoch or ""
            ),
            _choice(
                "reference",
                "Change since",
                [("", f"reference ({reference or numbers.MISSING})"), *((e, e) for e in epochs)],
                asked.reference or "",
            ),
            _choice("result", "Scheme / method", [("", f"primary ({primary})"), *results], result),
        ],
        className="choices",
    )


def _choice(name: str, label: str, options: Sequence[tuple[str, str]], value: str) -> Component:
    return html.Label(
        [
            html.Span(label),
            dcc.Dropdown(
                id=f"choose-{name}",
                options=[{"value": key, "label": text} for key, text in options],
                value=value,
                clearable=False,
                searchable=len(options) > 12,
            ),
        ],
        className="choice",
    )


def _links(view: View, shown: Page) -> Component:
    return html.Nav(
        [
            dcc.Link(
                [html.Kbd(str(page.place % 10)), page.title],
                href=view.asked.at(page.name).href,
                className="page-link here" if page.name == shown.name else "page-link",
                id=f"to-{page.name}",
            )
            for page in pages().values()
        ],
        **attributes(aria_label="pages"),
    )


def _reports(view: View) -> list[Component]:
    """Links to the report of the epoch, where its campaign file is at hand."""
    if view.site.report is None:
        return []
    base = f"/report/{quote(view.structure)}/{quote(view.epoch.epoch)}"
    kinds = (("PDF", f"{base}.pdf"), ("HTML", f"{base}.html"), ("中文", f"{base}.pdf?lang=zh"))
    links = [
        html.A(word, href=href, download="", className="chip", id=f"report-{n}")
        for n, (word, href) in enumerate(kinds)
    ]
    return [
        html.Div(
            [html.Span(f"Report of {view.epoch.epoch}"), html.Span(links, className="chips")],
            className="reports",
        )
    ]


def _keys() -> Component:
    rows = (("1 to 0", "pages"), ("[ ]", "epoch before, after"), ("↑ ↓", "slice above, below"))
    return html.Div([html.P([html.Kbd(key), what]) for key, what in rows], className="keys")


def _status(view: View) -> Component:
    condition, tilt = view.condition, view.condition.tilt
    deviation = numbers.mm_with_u(tilt.deviation_m, tilt.deviation_sigma_m) if tilt else numbers.MISSING
    limit = numbers.mm(tilt.allowable_m) if tilt else numbers.MISSING
    tone = tone_of(condition)
    epoch = view.epoch
    measured = f", {numbers.day(epoch.epoch_time)}, {numbers.age(epoch.epoch_time, view.now)}"
    return html.Header(
        [
            badge(tone, id="state"),
            html.Strong(view.site.name, className="name"),
            html.Span(["epoch ", html.B(epoch.epoch, id="epoch"), measured], className="when"),
            html.Span(
                [
                    "deviation ",
                    html.B(deviation, id="deviation"),
                    " (k=2) | limit ",
                    html.B(limit, id="limit"),
                ],
                className="what",
            ),
            _data_badge(view),
            html.Span([_step(view, -1), _step(view, 1)], className="steps"),
        ],
        className="status",
    )


def _data_badge(view: View) -> Component:
    epoch = view.epoch
    used = f"{epoch.n_stations_used} of {epoch.n_stations} stations"
    tone = TONES["ok"] if epoch.state == "ok" else TONES["quality"]
    word = {"ok": "data ok", "degraded": "data incomplete", "failed": "no data"}.get(epoch.state, epoch.state)
    return badge(tone, f"{word}, {used}", id="data")


def _step(view: View, by: int) -> Component:
    """A link to the epoch before or after."""
    names = [epoch.epoch for epoch in view.epochs]
    place = names.index(view.epoch.epoch) + by
    sign, what, place_of_key = ("‹", "epoch before", "before") if by < 0 else ("›", "epoch after", "after")
    if not 0 <= place < len(names):
        return html.Span(sign, className="step off", **HIDDEN)
    href = view.asked.choosing(epoch=names[place]).href
    return dcc.Link(
        sign,
        href=href,
        className="step",
        title=f"{what}: {names[place]}",
        id=f"key-{place_of_key}",
    )


def _panel(view: View, page: Page, panel: Panel) -> Component:
    tools = list(panel.tools)
    if panel.table is not None and panel.missing is None:
        href = f"/csv/{page.name}/{panel.name}?{view.address.query}"
        tools.append(html.A("CSV", href=href, className="csv", download="", title="download what is shown"))
    head = html.Div([html.H2(panel.title), html.Div(tools, className="tools")], className="panel-head")
    parts: list[Component] = [head]
    if panel.missing is not None:
        parts.append(html.P([html.B(numbers.MISSING), f" {panel.missing}"], className="missing"))
    else:
        parts.append(_content(panel))
    if panel.note:
        parts.append(html.P(panel.note, className="note"))
    return html.Section(parts, id=f"panel-{panel.name}", className=f"panel span-{panel.span}")


def _content(panel: Panel) -> Component:
    if isinstance(panel.content, Figure):
        height = panel.content.layout.height or 320
        graph = dcc.Graph(
            id={"type": "drawing", "panel": panel.name},
            figure=panel.content,
            config=_DRAWING,
            responsive=True,
            style={"height": f"{height}px", "minWidth": f"{panel.least_px}px"},
        )
        return html.Div(graph, className="wide") if panel.least_px else graph
    return html.Div(panel.content)
