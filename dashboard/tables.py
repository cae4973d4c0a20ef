"""Tables of a page as components; all text stays text."""

from collections.abc import Sequence
from typing import Any, Final, TypeAlias

from dash import dcc, html
from dash.development.base_component import Component

from dashboard.content.sheet import Head, Line, Sheet, Shown
from dashboard.numbers import MISSING

Part: TypeAlias = Component | str
LONG: Final = 240
"""Characters; what is longer is folded up."""

Cell: TypeAlias = Part | Sequence[Part] | Shown


def sheet_table(sheet: Sheet) -> Component:
    """A sheet as it is read."""
    return table(sheet.head, [_sheet_row(sheet, line) for line in sheet.lines])


def table(head: Sequence[Head], rows: Sequence[Component], fluid: bool = False) -> Component:
    """A table that scrolls by itself where the screen is narrow; a fluid one breaks its sentences first."""
    body = html.Table([html.Thead(html.Tr([_title(column) for column in head])), html.Tbody(list(rows))])
    return html.Div(body, className="wide fluid" if fluid else "wide", tabIndex=0)


def row(head: Sequence[Head], cells: Sequence[Cell], kind: str = "") -> Component:
    """A row: of each column its cell."""
    return html.Tr(
        [_cell(column, cell) for column, cell in zip(head, cells, strict=True)], className=kind or None
    )


def copy_tools(sheet: Sheet) -> list[Component]:
    """What copies a sheet for a paper or a wiki; CSV has a link of its own."""
    return [
        html.Span(
            ["LaTeX ", dcc.Clipboard(content=sheet.as_latex(), className="copy")], title="copy as LaTeX"
        ),
        html.Span(
            ["Markdown ", dcc.Clipboard(content=sheet.as_markdown(), className="copy")],
            title="copy as Markdown",
        ),
    ]


def words(text: str) -> Component:
    """A sentence in a cell; a long one opens by a click."""
    if len(text) <= LONG:
        return html.Span(text, className="words")
    return html.Details([html.Summary(f"{text[: LONG - 40].rsplit(' ', 1)[0]} …"), text], className="words")


def copied(text: str) -> Component:
    """A command to copy."""
    return html.Div([html.Code(text), dcc.Clipboard(content=text, className="copy")], className="command")


def missing(why: str) -> Component:
    """What stands where there is no value."""
    return html.Span(MISSING, title=why, className="gap")


def _title(column: Head) -> Component:
    return html.Th(column.title, className="n" if column.is_number else None, title=column.means, scope="col")


def _sheet_row(sheet: Sheet, line: Line) -> Component:
    first = html.Th(_shown(line.cells[0]), scope="row")
    kind = {"marked": "here", "mean": "mean", "gone": "gone"}.get(line.kind)
    if line.instead is not None:
        return html.Tr([first, html.Td(line.instead, colSpan=len(sheet.head) - 1)], className=kind)
    rest = [_cell(column, cell) for column, cell in zip(sheet.head[1:], line.cells[1:], strict=True)]
    return html.Tr([first, *rest], className=kind)


def _cell(column: Head, cell: Cell) -> Component:
    content = _shown(cell) if isinstance(cell, Shown) else cell
    kind = "n" if column.is_number else None
    # a narrow screen shows a fluid table as cards and has no head
    label: dict[str, Any] = {"data-label": column.title}
    return html.Td(content, className=kind, **label)


def _shown(cell: Shown) -> Part:
    if cell.why is None:
        return cell.text
    if cell.text == MISSING:
        return missing(cell.why)
    return html.Span(cell.text, title=cell.why, className="remark")
