"""Slides of a page: where one is let go is put into the address, as any other choice."""

from typing import Any

from dash import ALL, Dash, Input, Output, State, callback_context, dcc, no_update

from dashboard.address import address_of


def slide(name: str, shown: int, marks: dict[int, str], last: int) -> dcc.Slider:
    """A slide from 0 to ``last`` that stands at ``shown``; the page's address gets ``name`` with its place."""
    return dcc.Slider(
        id={"type": "slide", "name": name, "shown": shown},
        min=0,
        max=last,
        step=1,
        value=shown,
        marks={place: {"label": text} for place, text in marks.items()},
        included=False,
        updatemode="mouseup",
        allow_direct_input=False,
    )


def follow_slides(app: Dash) -> None:
    """Let the slides of all pages change the address."""

    @app.callback(
        Output("url", "href", allow_duplicate=True),
        Input({"type": "slide", "name": ALL, "shown": ALL}, "value"),
        State("url", "pathname"),
        State("url", "search"),
        prevent_initial_call=True,
    )
    def follow(_places: list[int | None], pathname: str | None, search: str | None) -> Any:
        moved = callback_context.triggered_id
        places = [item["value"] for item in callback_context.triggered]
        # a page that was just filled reports where its slides stand, too
        if not moved or len(places) != 1 or places[0] in (None, moved["shown"]):
            return no_update
        return address_of(pathname or "/", search or "").with_more(**{moved["name"]: str(places[0])}).href
