"""Small choices of a page, as links: what is chosen stands in the address."""

from collections.abc import Sequence

from dash import dcc, html
from dash.development.base_component import Component

from dashboard.attributes import attributes
from dashboard.view import View


def choice_links(
    view: View, key: str, options: Sequence[tuple[str, str]], chosen: str, label: str
) -> Component:
    """A row of links that set one of the page's own choices.

    Parameters
    ----------
    key : str
        Its name in the address.
    options : sequence of (value, text)
        What there is to choose.
    chosen : str
        The value that is shown.
    label : str
        What is chosen, for readers of screens and before the links.
    """
    links = [
        html.Span(text, className="chosen", **attributes(aria_current="true"))
        if value == chosen
        else dcc.Link(text, href=view.asked.with_more(**{key: value}).href)
        for value, text in options
    ]
    return html.Span(
        [html.Span(label, className="choice-label"), *links], className="choice-links", role="group"
    )


def chosen_of(view: View, key: str, options: Sequence[tuple[str, str]]) -> str:
    """Return the value that the address has for a choice; the first option where it has none that is known."""
    given = view.asked.more.get(key)
    return given if given in [value for value, _text in options] else options[0][0]
