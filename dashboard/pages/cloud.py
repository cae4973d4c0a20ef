"""P8: the points in three dimensions, within the frame of the pages."""

from collections.abc import Sequence

from dash import html

from dashboard.page import Page
from dashboard.panel import Panel
from dashboard.view import View
from storage.errors import StorageError
from storage.views.shaft_points import shaft_points


def fill(view: View) -> Sequence[Panel]:
    """Make the panel that holds the page of three.js."""
    title = f"Points of the shaft, {view.epoch.epoch}"
    try:
        view.reader.ask(shaft_points, view.structure, view.epoch.epoch)
    except StorageError as fault:
        return [Panel("cloud", title, None, span=12, missing=str(fault))]
    address = f"/3d?{view.asked.at('3d').query}"
    alone = html.A("alone in the window", href=address)
    content = html.Iframe(src=address, title=title, style={"width": "100%", "height": "78vh", "border": 0})
    return [Panel("cloud", title, content, span=12, tools=[alone])]


PAGE = Page("cloud", 8, "3D", "What was scanned, and which way does it lean?", fill)
